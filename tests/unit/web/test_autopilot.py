"""Signal K's autopilot API never goes round the transfer of command."""

import asyncio
from math import radians, tau
from typing import Any

import pytest

from tests.unit.web.scene import OPEN_TO_ALL, Answered, Scene, heading, pilot_holds, request, scene
from tests.unit.web.test_routes import AT, access
from timonel.core.frame import Frame
from timonel.gateway.signalk_settings import SignalK
from timonel.nmea2000.fastpacket import Reassembler
from timonel.nmea2000.identifier import split
from timonel.nmea2000.messages.steering import HeadingTrackControl
from timonel.vehicles.boat.vehicle import Boat
from timonel.web.messages import Command

BASE = "/signalk/v2/api/vessels/self/autopilots"
PILOT = f"{BASE}/_default"
COMPLETED = {"state": "COMPLETED", "statusCode": 200, "message": "OK"}


def helm(here: Scene) -> Any:
    assert isinstance(here.gateway.vehicle, Boat)
    return here.gateway.vehicle.helm


async def order(here: Scene, method: str, what: str, body: Any = None, station: int | None = 2) -> Answered:
    which = "" if station is None else f"?station={station}"
    return await request(here.app, method, f"{PILOT}/{what}{which}", body)


async def confirmed(here: Scene, course: float, method: str, what: str, body: Any = None) -> Answered:
    """An order, while a pilot reports that it holds a course."""
    asked = asyncio.create_task(order(here, method, what, body))
    await asyncio.sleep(0.01)
    await here.hear(*pilot_holds(course))
    return await asked


async def engaged(here: Scene) -> None:
    """Station 2 has command, and the pilot holds 90."""
    await here.hear(heading(90.0))
    answer = await confirmed(here, 90.0, "POST", "engage")
    assert (answer.status, answer.json) == (200, COMPLETED)


def told(frames: list[Frame]) -> float | None:
    """The course of the last order to the pilot, rad."""
    reassembler, course = Reassembler(), None
    for frame in frames:
        if split(frame.identifier).pgn == 127237 and (data := reassembler.receive(frame.identifier, frame.data, 0.0)):
            course = HeadingTrackControl.decode(data).heading_to_steer_course
    return course


# Command ----------------------------------------------------------------------------------------------------


def test_who_engages_while_nobody_has_command_gets_it_by_asking() -> None:
    async def play() -> None:
        async with scene() as here:
            await engaged(here)
            assert helm(here).transfer.commander == 2
            assert helm(here).pilot.mode == "HEADING_HOLD"

    asyncio.run(play())


@pytest.mark.parametrize(
    ("method", "what", "body"),
    [
        ("POST", "engage", None),
        ("POST", "disengage", None),
        ("PUT", "state", {"value": "standby"}),
        ("PUT", "target", {"value": 1.0}),
        ("PUT", "target/adjust", {"value": 0.1}),
    ],
)
def test_who_is_not_in_command_changes_nothing_and_asks_nobody(method: str, what: str, body: Any) -> None:
    async def play() -> None:
        async with scene() as here:
            await engaged(here)
            before = len(here.sent), helm(here).pilot.setpoint
            answer = await order(here, method, what, body, station=3)
            assert answer.status == 403
            assert answer.json == {"state": "FAILED", "statusCode": 403, "message": "not in command"}
            assert (helm(here).transfer.commander, list(helm(here).transfer.queue)) == (2, [])
            assert (len(here.sent), helm(here).pilot.setpoint) == before

    asyncio.run(play())


def test_who_is_not_in_command_may_ask_as_a_console_does_and_then_steer() -> None:
    async def play() -> None:
        async with scene() as here:
            await engaged(here)
            here.console.ports[3].carry_out(Command(1, "REQCMD"))
            here.console.ports[2].carry_out(Command(2, "ACKCMD"))
            asked = asyncio.create_task(order(here, "PUT", "target", {"value": 100, "units": "deg"}, station=3))
            await asyncio.sleep(0.01)
            await here.hear(*pilot_holds(100.0))
            assert (await asked).status == 200

    asyncio.run(play())


def test_an_order_is_the_word_of_a_station_and_of_one_that_is_its_own() -> None:
    async def play() -> None:
        async with scene() as here:
            unsaid = await order(here, "POST", "engage", station=None)
            assert unsaid.status == 400
            assert "?station=1..4" in unsaid.json["message"]
            assert (await order(here, "POST", "engage", station=5)).status == 400
            assert here.console.signalk is not None
            here.console.signalk.settings = SignalK(station=4)
            assert (await order(here, "POST", "engage", station=None)).json["message"] == "no heading"
            assert helm(here).transfer.commander == 4
        async with scene(web=OPEN_TO_ALL) as here:
            cookie = {"cookie": access().seal([2]).partition(";")[0]}
            refused = await request(here.app, "POST", f"{PILOT}/engage?station=3", **AT, **cookie)
            assert (refused.status, refused.json["message"]) == (403, "not paired with this station")
            assert (await request(here.app, "POST", f"{PILOT}/engage", **AT, **cookie)).status == 400
            assert helm(here).transfer.commander == 2

    asyncio.run(play())


# Orders -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("what", "body", "course"),
    [
        ("target", {"value": 1.0}, 57.3),
        ("target", {"value": 270, "units": "deg"}, 270.0),
        ("target", {"value": -90, "units": "deg"}, 270.0),
        ("target", {"value": tau}, 0.0),
        ("target/adjust", {"value": 10, "units": "deg"}, 100.0),
        ("target/adjust", {"value": -radians(100)}, 350.0),
    ],
)
def test_a_course_is_set_in_rad_or_degrees(what: str, body: Any, course: float) -> None:
    async def play() -> None:
        async with scene() as here:
            await engaged(here)
            answer = await confirmed(here, course, "PUT", what, body)
            assert (answer.status, answer.json) == (200, COMPLETED)
            assert told(here.sent) == pytest.approx(radians(course), abs=1e-4)
            assert (await here.get(f"{PILOT}/target")).json["value"] == pytest.approx(radians(course), abs=1e-9)

    asyncio.run(play())


@pytest.mark.parametrize(
    ("what", "body"),
    [
        ("target", {"value": 6.3}),
        ("target", {"value": -3.2}),
        ("target", {"value": "1"}),
        ("target", {}),
        ("target", {"value": 1, "units": "gon"}),
        ("target/adjust", {"value": 3.2}),
        ("target/adjust", {"value": 1e308, "units": "deg"}),
        ("state", {"value": "fast"}),
        ("state", {"value": 1}),
    ],
)
def test_a_value_out_of_bounds_is_refused_and_never_guessed(what: str, body: Any) -> None:
    async def play() -> None:
        async with scene() as here:
            await engaged(here)
            answer = await order(here, "PUT", what, body)
            assert (answer.status, answer.json["state"], answer.json["statusCode"]) == (400, "FAILED", 400)
            assert helm(here).pilot.setpoint == 900

    asyncio.run(play())


def test_a_course_is_not_set_or_changed_while_none_is_held() -> None:
    async def play() -> None:
        async with scene() as here:
            await here.hear(heading(90.0))
            for what in ("target", "target/adjust"):
                assert (await order(here, "PUT", what, {"value": 0.1})).status == 400
            assert helm(here).pilot.mode == "STANDBY"

    asyncio.run(play())


def test_a_pilot_that_does_not_confirm_is_told_as_that() -> None:
    async def play() -> None:
        async with scene() as here:
            await here.hear(heading(90.0))
            answer = await order(here, "PUT", "state", {"value": "auto"})
            assert (answer.status, answer.json["message"]) == (504, "the pilot has not confirmed")

    asyncio.run(play())


@pytest.mark.parametrize("body", [{"value": "route"}, {"value": "alarm"}])
def test_a_state_that_cannot_be_set_is_not_implemented(body: Any) -> None:
    async def play() -> None:
        async with scene() as here:
            assert (await order(here, "PUT", "state", body)).status == 501

    asyncio.run(play())


# How it stands ----------------------------------------------------------------------------------------------


def test_there_is_one_autopilot_and_it_is_the_default() -> None:
    async def play() -> None:
        async with scene() as here:
            assert (await here.get(BASE)).json == {"timonel": {"provider": "timonel", "isDefault": True}}
            assert (await here.get(f"{BASE}/_providers/_default")).json == {"id": "timonel"}
            assert (await here.post(f"{BASE}/_providers/_default/timonel")).json == COMPLETED
            assert (await here.post(f"{BASE}/_providers/_default/x")).status == 404
            for path in ("x", "x/state", "x/options"):
                assert (await here.get(f"{BASE}/{path}")).status == 404

    asyncio.run(play())


def test_its_status_is_what_the_stations_see() -> None:
    async def play() -> None:
        async with scene() as here:
            standby = (await here.get(PILOT)).json
            assert {key: standby[key] for key in standby if key != "options"} == {
                "state": "standby", "mode": "compass", "target": None, "engaged": False
            }  # fmt: skip
            await engaged(here)
            holding = (await here.get(f"{BASE}/timonel")).json
            assert (holding["state"], holding["engaged"]) == ("auto", True)
            assert holding["target"] == pytest.approx(radians(90))
            assert {"name": "auto", "engaged": True} in holding["options"]["states"]
            assert (await here.get(f"{PILOT}/options")).json == holding["options"]
            assert (await here.get(f"{PILOT}/state")).json == {"value": "auto"}
            assert (await here.get(f"{PILOT}/mode")).json == {"value": "compass"}

    asyncio.run(play())
