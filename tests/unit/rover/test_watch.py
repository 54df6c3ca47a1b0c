"""What telemetry says that people must know of."""

import pytest

from timonel.core.alerts import AlertChanged, AlertKind, Alerts, Priority
from timonel.core.effects import Event
from timonel.vehicles.rover.alerts import BATTERY, DRIVER_LEFT, DRIVER_RIGHT, RUNAWAY, STALLED
from timonel.vehicles.rover.declaration import RoverFrame
from timonel.vehicles.rover.drive import STANDSTILL, Permission, Wheels
from timonel.vehicles.rover.frames import (
    BatteryState,
    BmsStatus,
    DriverState,
    MotorCurrentLeft,
    MotorCurrentRight,
    MotorDriverStatusLeft,
    MotorDriverStatusRight,
    WheelSpeedLeft,
    WheelSpeedRight,
)
from timonel.vehicles.rover.watch import Watch

AHEAD = Wheels(50, 50)
GRANTED, WITHDRAWN = Permission(True, ""), Permission(False, "")


def right(rpm: float | None) -> WheelSpeedRight:
    return WheelSpeedRight(front_rpm=0.0, middle_rpm=rpm, rear_rpm=None)


def left(rpm: float | None) -> WheelSpeedLeft:
    return WheelSpeedLeft(front_rpm=rpm, middle_rpm=0.0, rear_rpm=0.0)


def current(amperes: float | None) -> MotorCurrentRight:
    return MotorCurrentRight(front=1.0, middle=amperes, rear=None)


class Seen:
    """A watch with its alerts, told things at their times."""

    def __init__(self) -> None:
        self.alerts = Alerts()
        self.watch = Watch(self.alerts, stall_current=10.0, now=0.0)

    def hear(self, now: float, *frames: RoverFrame) -> list[Event]:
        return [event for frame in frames for event in self.watch.hear(frame, now)]

    def driving(self) -> "Seen":
        self.watch.permission(GRANTED, 0.0)
        self.watch.told(AHEAD, 0.0)
        return self

    def active(self, kind: AlertKind) -> bool:
        return self.alerts.active(kind)


# Stalled --------------------------------------------------------------------------------------------


def test_wheels_that_do_not_turn_for_two_seconds_at_a_high_current_are_stalled():
    seen = Seen().driving()
    assert seen.hear(1.99, left(0.0), right(0.0), current(12.0)) == []
    events = seen.hear(2.0, current(12.0))
    assert [event.alert.text for event in events if isinstance(event, AlertChanged)] == [
        "told to turn for 2 s, but no wheel does, at 12 A"
    ]
    assert seen.active(STALLED)


def test_the_current_of_either_direction_and_either_side_counts():
    seen = Seen().driving()
    seen.hear(2.0, right(0.0), MotorCurrentLeft(front=None, middle=0.0, rear=-10.0))
    assert seen.active(STALLED)


@pytest.mark.parametrize(
    ("frames", "why"),
    [
        ((right(0.0), left(0.0), current(9.9)), "the current is low: the encoders may be broken"),
        ((right(0.0), left(-30.0), current(12.0)), "a wheel turns"),
        ((right(2.0), current(12.0)), "a wheel turns, slowly"),
        ((current(12.0),), "nobody tells what the wheels do"),
        ((right(0.0), left(0.0)), "nobody tells the current"),
        ((right(0.0), current(None)), "the current is not available"),
    ],
)
def test_they_are_not_while(frames: tuple[RoverFrame, ...], why: str):
    seen = Seen().driving()
    seen.hear(2.5, *frames)
    assert not seen.active(STALLED), why


def test_a_measurement_counts_for_a_second():
    seen = Seen().driving()
    seen.hear(1.0, right(30.0))
    seen.hear(1.99, left(0.0), current(12.0))
    seen.hear(2.0, current(12.0))
    assert seen.active(STALLED), "that the right wheels turned is too long ago"


def test_the_two_seconds_begin_when_the_wheels_are_told_to_turn_and_anew_after_a_halt():
    seen = Seen().driving()
    seen.watch.told(AHEAD, 1.0)
    seen.watch.told(STANDSTILL, 1.5)
    seen.watch.told(AHEAD, 1.6)
    seen.hear(3.5, right(0.0), current(12.0))
    assert not seen.active(STALLED)
    seen.hear(3.6, current(12.0))
    assert seen.active(STALLED)


def test_the_alert_ends_when_a_wheel_turns():
    seen = Seen().driving()
    seen.hear(2.0, right(0.0), current(12.0))
    seen.hear(2.1, right(30.0))
    assert not seen.active(STALLED)


# Turning without permission -------------------------------------------------------------------------


def test_a_wheel_that_turns_a_second_after_a_stop_is_an_emergency():
    seen = Seen().driving()
    seen.watch.permission(WITHDRAWN, 5.0)
    seen.hear(5.99, right(-40.0))
    assert not seen.active(RUNAWAY), "it may coast"
    (event,) = seen.hear(6.0, left(41.0))
    assert isinstance(event, AlertChanged)
    assert event.alert.text == "a wheel turns at 41 rpm without permission"
    assert event.alert.kind.priority is Priority.EMERGENCY


def test_it_ends_when_all_stand_or_motion_is_permitted():
    seen = Seen()
    seen.hear(1.0, right(40.0))
    assert seen.active(RUNAWAY)
    seen.hear(1.1, right(1.9))
    assert not seen.active(RUNAWAY)
    seen.hear(1.2, right(40.0))
    seen.watch.permission(GRANTED, 1.3)
    seen.hear(1.3, right(40.0))
    assert not seen.active(RUNAWAY)


# What modules say of themselves ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "frame"), [(DRIVER_RIGHT, MotorDriverStatusRight), (DRIVER_LEFT, MotorDriverStatusLeft)]
)
def test_a_motor_driver_without_supply_or_with_a_fault_is_an_alert_until_it_is_well(kind: AlertKind, frame: type):
    for bad, word in ((DriverState.NO_SUPPLY, "no supply"), (DriverState.FAULT, "fault"), (None, "unknown")):
        for good in (DriverState.RUNNING, DriverState.STOPPED):
            seen = Seen()
            assert seen.hear(0.0, frame(status=good)) == []
            (event,) = seen.hear(0.1, frame(status=bad))
            assert isinstance(event, AlertChanged)
            assert event.alert.text == f"{kind.name}: {word}"
            assert seen.hear(0.2, frame(status=bad)) == []
            seen.hear(0.3, frame(status=good))
            assert not seen.active(kind)


def test_a_battery_that_says_anything_but_ok_is_an_alert():
    for bad in (BatteryState.UNDER_VOLTAGE, BatteryState.OVER_TEMPERATURE, BatteryState.OVER_CURRENT, None):
        seen = Seen()
        assert seen.hear(0.0, BmsStatus(status=BatteryState.OK)) == []
        seen.hear(0.1, BmsStatus(status=bad))
        assert seen.active(BATTERY)
        seen.hear(0.2, BmsStatus(status=BatteryState.OK))
        assert not seen.active(BATTERY)
