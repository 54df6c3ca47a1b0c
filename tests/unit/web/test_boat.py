"""What a boat shows."""

import asyncio
from math import radians, tau

import pytest

from tests.unit.web.scene import Scene, frame, heading, scene, wire
from timonel.core.alerts import AlertChanged, AlertKind, Alerts, Priority
from timonel.core.effects import Refused, Rejected, SecurityEvent
from timonel.nmea0183 import parp
from timonel.nmea0183.parp import Verb
from timonel.nmea2000.lookups import HeadingReference, WindReference
from timonel.nmea2000.messages.environment import WindData
from timonel.nmea2000.messages.navigation import CogSogRapidUpdate, PositionRapidUpdate, SystemTime, WaterDepth
from timonel.nmea2000.messages.steering import MagneticVariation, Rudder
from timonel.web.boat import SAMPLES
from timonel.web.messages import BoatTopics, Measured, Wind
from timonel.web.state import EVENTS_SHOWN, PRIORITIES, Topics


def topics(here: Scene, later: float = 0.0) -> Topics:
    return here.console.state.topics(here.gateway.now + later)


def wind(reference: WindReference, speed: float, degrees: float):
    return frame(WindData(sid=None, wind_speed=speed, wind_angle=radians(degrees), reference=reference))


def test_all_topics_that_are_declared_are_told() -> None:
    async def play() -> None:
        async with scene() as here:
            assert topics(here).keys() == set(BoatTopics.__struct_fields__)
            BoatTopics(**topics(here))

    asyncio.run(play())


def test_what_was_never_heard_is_absent() -> None:
    async def play() -> None:
        async with scene() as here:
            shown = topics(here)
            assert shown["depth"] == Measured(None, None, "absent")
            assert shown["wind_apparent"] == Wind(None, None, None, "absent")
            assert shown["heading"].quality == shown["position"].quality == shown["utc"].quality == "absent"
            assert here.console.state.samples(shown) == dict.fromkeys(SAMPLES)

    asyncio.run(play())


def test_a_value_has_its_age_and_is_stale_after_three_seconds() -> None:
    async def play() -> None:
        async with scene() as here:
            await here.hear(frame(WaterDepth(sid=None, depth=12.34, offset=None, range=None)))
            depth = topics(here)["depth"]
            assert (depth.value, depth.quality) == (12.34, "fresh")
            assert depth.at == pytest.approx(here.gateway.now, abs=0.5)
            assert topics(here, later=2.5)["depth"] == depth
            assert topics(here, later=3.1)["depth"] == Measured(12.34, depth.at, "stale")
            assert here.console.state.samples(topics(here))["depth"] == 12.34
            assert here.console.state.samples(topics(here, later=3.1))["depth"] is None

    asyncio.run(play())


def test_values_are_those_of_the_bus_in_si() -> None:
    async def play() -> None:
        async with scene() as here:
            await here.hear(
                heading(182.5),
                frame(Rudder(instance=0, direction_order=None, angle_order=None, position=radians(-5.0))),
                frame(CogSogRapidUpdate(sid=None, cog_reference=HeadingReference.TRUE, cog=1.0, sog=3.5)),
                frame(PositionRapidUpdate(latitude=39.5, longitude=-2.5)),
                frame(SystemTime(sid=None, source=None, date=20_000, time=43_200.0)),
                wind(WindReference.APPARENT, 8.0, 45.0),
            )
            shown = topics(here)
            assert shown["heading"].value == pytest.approx(radians(182.5), abs=1e-4)
            assert shown["heading"].reference == "true"
            assert shown["rudder"].value == pytest.approx(radians(-5.0), abs=1e-4)
            assert (shown["cog"].value, shown["cog"].reference, shown["sog"].value) == (1.0, "true", 3.5)
            assert (shown["position"].latitude, shown["position"].longitude) == (39.5, -2.5)
            assert shown["utc"].value == 20_000 * 86_400 + 43_200
            assert shown["wind_apparent"].speed == 8.0
            assert shown["wind_apparent"].angle == pytest.approx(radians(45), abs=1e-4)
            assert shown["links"][-1].kind == "gnss"
            assert shown["links"][-1].connected
            assert not topics(here, later=4.0)["links"][-1].connected

    asyncio.run(play())


def test_true_wind_over_ground_is_counted_from_the_bow() -> None:
    async def play() -> None:
        async with scene() as here:
            await here.hear(wind(WindReference.TRUE_NORTH, 7.0, 30.0))
            assert topics(here)["wind_true"].angle is None, "nobody knows where the bow points"
            await here.hear(heading(90.0))
            assert topics(here)["wind_true"].angle == pytest.approx(tau - radians(60), abs=2e-4)
            await here.hear(wind(WindReference.TRUE_WATER, 6.0, 10.0))
            assert topics(here)["wind_true"].speed == 6.0, "better against the water"

    asyncio.run(play())


def test_a_variation_that_the_bus_tells_comes_before_the_model() -> None:
    async def play() -> None:
        async with scene() as here:
            assert topics(here)["variation"].quality == "absent"
            await here.hear(
                frame(PositionRapidUpdate(latitude=39.5, longitude=2.5)),
                frame(SystemTime(sid=None, source=None, date=20_000, time=43_200.0)),
            )
            modelled = topics(here)["variation"]
            assert 0.0 < modelled.value < 0.1
            assert modelled.quality == "fresh"
            told = MagneticVariation(sid=None, source=None, age_of_service=None, variation=0.2)
            await here.hear(frame(told))
            assert topics(here)["variation"].value == 0.2

    asyncio.run(play())


def test_the_pilot_has_a_set_point_only_while_it_holds_one() -> None:
    async def play() -> None:
        async with scene() as here:
            await here.hear(heading(90.0))
            pilot = topics(here)["pilot"]
            assert (pilot.mode, pilot.setpoint, pilot.pending) == ("STANDBY", None, False)
            bridge = here.gateway.channels[0].receive
            bridge.say(parp.command(Verb.TAKECMD, 1) + parp.command(Verb.ENGAGE, 1))  # type: ignore[union-attr]
            pilot = topics(here)["pilot"]
            assert (pilot.mode, pilot.pending) == ("HEADING_HOLD", True)
            assert pilot.setpoint == pytest.approx(radians(90.0), abs=1e-5)
            assert here.console.state.samples(topics(here))["setpoint"] == pilot.setpoint

    asyncio.run(play())


def test_who_commands_and_who_asks_is_told_with_names_and_the_time_left() -> None:
    async def play() -> None:
        async with scene(stations=[wire(1, "Bridge"), wire(2, "Cockpit")]) as here:
            boat = here.gateway.vehicle
            now = here.gateway.now
            boat.receive_bytes("Cockpit", parp.command(Verb.REQCMD, 2), now)
            boat.receive_bytes("Station 4 web", parp.command(Verb.REQCMD, 4), now)
            command = topics(here)["command"]
            assert (command.commander, command.commander_name) == (2, "Cockpit")
            assert [(waiting.station, waiting.name) for waiting in command.queue] == [(4, "Station 4")]
            assert command.deadline == pytest.approx(now + 10.0, abs=1e-3)
            assert command.policy == "transfer"
            assert [(each.id, each.name, each.connected) for each in command.stations] == [
                (1, "Bridge", False), (2, "Cockpit", False), (3, "Station 3", None), (4, "Station 4", None),
            ]  # fmt: skip

    asyncio.run(play())


def test_links_are_those_of_the_configuration_not_those_of_consoles() -> None:
    async def play() -> None:
        async with scene(stations=[wire(1, "Bridge")]) as here:
            links = {link.name: link for link in topics(here)["links"]}
            assert list(links) == ["bus", "Bridge", "GNSS"]
            assert (links["bus"].kind, links["bus"].connected) == ("bus", True)
            assert (links["Bridge"].kind, links["Bridge"].connected) == ("in", False)
            assert links["Bridge"].reason

    asyncio.run(play())


def test_an_alert_is_shown_until_it_is_over_and_acknowledged() -> None:
    async def play() -> None:
        async with scene() as here:
            now = here.gateway.now
            for event in here.gateway.vehicle.expire(now + 3.0):
                here.console.state.effect(event, now)
            (alert,) = topics(here)["alerts"]
            assert (alert.id, alert.name, alert.priority) == (101, "backbone silent", "alarm")
            assert (alert.active, alert.acknowledged, alert.silenced_until) == (True, False, None)
            alerts = here.gateway.vehicle.helm.alerts  # type: ignore[attr-defined]
            for event in alerts.acknowledge(101):
                here.console.state.effect(event, now)
            assert topics(here)["alerts"][0].acknowledged
            for event in here.gateway.vehicle.receive_frames([heading(1.0)], now + 4.0):
                here.console.state.effect(event, now)
            assert topics(here)["alerts"] == []

    asyncio.run(play())


def test_the_most_urgent_alert_comes_first() -> None:
    async def play() -> None:
        async with scene() as here:
            alerts = Alerts()
            for number, priority in enumerate((Priority.CAUTION, Priority.EMERGENCY, Priority.WARNING), 1):
                (changed,) = alerts.arise(AlertKind(number, priority.name, priority), "", float(number))
                here.console.state.effect(changed, 0.0)
            assert [alert.priority for alert in topics(here)["alerts"]] == ["alarm", "warning", "caution"]
            assert PRIORITIES.keys() == set(Priority)

    asyncio.run(play())


def test_the_last_twenty_events_are_told_in_words_and_repeated_ones_once() -> None:
    async def play() -> None:
        async with scene() as here:
            state = here.console.state
            for _ in range(5):
                state.effect(Refused("not in command", 3), 7.0)
            state.effect(SecurityEvent("another station's id", "Bridge", 2), 8.0)
            state.effect(Rejected("bad check sum", b"$<script>", "Bridge"), 9.0)
            refused, security, rejected = topics(here)["events"][-3:]
            assert (refused.kind, refused.times, refused.at) == ("refused", 5, 7.0)
            assert refused.text == "station 3 refused: not in command"
            assert (security.kind, rejected.kind) == ("security", "other")
            for number in range(100):
                state.effect(Refused(f"reason {number}", 3), 10.0)
            assert len(topics(here)["events"]) == EVENTS_SHOWN

    asyncio.run(play())


def test_what_presses_is_told_at_once_and_a_refusal_does_not_press() -> None:
    async def play() -> None:
        async with scene() as here:
            pressed: list[bool] = []
            here.console.state.pressing = lambda: pressed.append(True)
            here.console.state.effect(Refused("not in command", 3), 0.0)
            assert pressed == []
            (changed,) = Alerts().arise(AlertKind(1, "x", Priority.ALARM), "", 0.0)
            assert isinstance(changed, AlertChanged)
            here.console.state.effect(changed, 0.0)
            assert pressed == [True]

    asyncio.run(play())
