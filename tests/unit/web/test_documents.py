"""What a broker is told of what the console shows."""

from math import isclose, radians
from typing import Any

import pytest

from timonel.interop import mqtt
from timonel.web import documents
from timonel.web.messages import (
    AlertState,
    BatteryState,
    CommandState,
    Direction,
    DriveState,
    LinkState,
    MagnetometerState,
    Measured,
    PilotState,
    Position,
    Quality,
    StickState,
    Waiting,
    WheelState,
    Wind,
)

NOW = 100.0
NOWHERE = Measured(None, None, "absent")
COMMAND = CommandState(2, "Cockpit", [], [Waiting(3, "Flybridge")], 105.0, "deny")
LINKS = [LinkState("bus", "bus", True, "", 1.0)]


def boat(**changed: Any) -> dict[str, Any]:
    topics = dict.fromkeys(("sog", "stw", "rudder", "rate_of_turn", "depth", "water_temperature", "variation"), NOWHERE)
    return {
        **topics,
        "command": COMMAND,
        "pilot": PilotState("HEADING_HOLD", radians(45), "true", True),
        "heading": Direction(radians(44), 99.9, "fresh", "magnetic"),
        "cog": Direction(None, None, "absent", "true"),
        "wind_apparent": Wind(7.0, 0.5, 99.0, "fresh"),
        "wind_true": Wind(6.0, 0.7, 90.0, "stale"),
        "position": Position(39.5, 2.6, 99.9, "fresh"),
        "alerts": [],
        "links": LINKS,
    } | changed


def wheel(rpm: float | None, quality: Quality) -> WheelState:
    return WheelState("left", "front", 0.0, rpm, None, None, None, 99.0, quality)


def rover(**changed: Any) -> dict[str, Any]:
    return {
        "command": COMMAND,
        "drive": DriveState(True, StickState(0, 0), 0.12345, 0.5, 1.0, "station 1"),
        "battery": BatteryState(15.2, [3.8, 3.8, None, 3.8], [], "ok", 99.9, "fresh"),
        "wheels": [wheel(10.0, "fresh"), wheel(None, "fresh"), wheel(20.0, "fresh"), wheel(90.0, "stale")],
        "magnetometer": MagnetometerState(1.0, 4e-5, 99.9, "fresh"),
        "gps": Position(None, None, None, "absent"),
        "alerts": [],
        "links": LINKS,
    } | changed


@pytest.mark.parametrize(("vehicle", "topics"), [("boat", boat()), ("rover", rover())])
def test_every_value_of_the_table_is_told(vehicle: mqtt.Vehicle, topics: dict[str, Any]) -> None:
    assert list(documents.values(topics, vehicle)) == [value.key for value in mqtt.VALUES[vehicle]]


def test_a_value_is_told_in_si_with_what_it_is_worth() -> None:
    told = documents.values(boat(), "boat")
    assert told["heading"] == mqtt.Reading(radians(44), "rad", "fresh", "magnetic")
    assert told["wind_apparent_speed"] == mqtt.Reading(7.0, "m/s", "fresh")
    assert mqtt.written(told["wind_apparent_speed"]) == b'{"value":7.0,"unit":"m/s","quality":"fresh"}'


def test_what_is_stale_or_absent_has_no_value() -> None:
    told = documents.values(boat(), "boat")
    assert told["wind_true_angle"] == mqtt.Reading(None, "rad", "stale")
    assert told["depth"] == mqtt.Reading(None, "m", "absent")
    assert mqtt.written(told["depth"]) == b'{"value":null,"unit":"m","quality":"absent"}'


def test_who_commands_and_who_asks_is_told() -> None:
    told = documents.states(boat(), "boat", NOW)
    assert told["command"] == mqtt.Command(2, "Cockpit", [mqtt.Requester(3, "Flybridge")], "deny")
    assert told["pilot"] == mqtt.Pilot("HEADING_HOLD", radians(45), "true", True)
    assert told["links"] == [mqtt.Link("bus", "bus", True, "")]


def test_a_position_that_does_not_hold_is_left_out() -> None:
    assert documents.states(boat(), "boat", NOW)["position"] == mqtt.Position("fresh", 39.5, 2.6)
    stale = boat(position=Position(39.5, 2.6, 90.0, "stale"))
    assert mqtt.written(documents.states(stale, "boat", NOW)["position"]) == b'{"quality":"stale"}'


@pytest.mark.parametrize(("until", "silenced"), [(None, False), (NOW + 1, True), (NOW, False)])
def test_an_alert_is_told_as_all_stations_see_it(until: float | None, silenced: bool) -> None:
    alert = AlertState(101, "backbone silent", "nothing heard", "alarm", True, False, until, 95.0, announced=0)
    (told,) = documents.states(boat(alerts=[alert]), "boat", NOW)["alerts"]  # type: ignore[misc]
    assert told == mqtt.Alert(101, "backbone silent", "nothing heard", "alarm", True, False, silenced)


def test_a_rover_tells_its_cells_and_the_mean_of_the_wheels_that_tell_theirs() -> None:
    told = documents.values(rover(), "rover")
    assert told["cell1"] == mqtt.Reading(3.8, "V", "fresh")
    assert told["cell3"] == mqtt.Reading(None, "V", "fresh")
    assert told["wheel_speed"] == mqtt.Reading(15.0, "rpm", "fresh")
    drive = documents.states(rover(), "rover", NOW)["drive"]
    assert isinstance(drive, mqtt.Drive)
    assert (drive.permitted, drive.reason, drive.battery) == (True, "station 1", "ok")
    assert isclose(drive.left, 0.123)


@pytest.mark.parametrize(("worth", "expected"), [("stale", "stale"), ("absent", "absent")])
def test_wheels_that_tell_nothing_have_no_speed(worth: Quality, expected: str) -> None:
    told = documents.values(rover(wheels=[wheel(None, "absent"), wheel(None, worth)]), "rover")
    assert told["wheel_speed"] == mqtt.Reading(None, "rpm", expected)


def test_a_battery_that_is_not_heard_any_more_has_no_cells() -> None:
    battery = BatteryState(15.2, [3.8] * 4, [], "ok", 90.0, "stale")
    told = documents.values(rover(battery=battery), "rover")
    assert (told["cell1"], told["battery_voltage"]) == (mqtt.Reading(None, "V", "stale"),) * 2
