"""What telemetry says that people must know of (spec/rover.md, Driving).

alert                            arises when                                            ends when
wheels stalled                   told to turn for 2 s, none does, at a high current     one turns, or none is told to
wheels turn without permission   one turns, a second after the drives were stopped      all stand, or permitted
motor driver right, left         116, 117 say no supply or fault                        they say running or stopped
battery                          118 says anything but ok                               it says ok
"""

from timonel.core.alerts import AlertKind, Alerts
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

STALL_TIME = 2.0  # s
COAST_TIME = 1.0  # s that wheels may still turn after a stop
AGE = 1.0  # s that a measurement counts
TURNING = 2.0  # rpm: less is an encoder that cannot decide

Speeds = WheelSpeedRight | WheelSpeedLeft
Currents = MotorCurrentRight | MotorCurrentLeft


class Watch:
    """Compares what the wheels are told with what they do."""

    def __init__(self, alerts: Alerts, stall_current: float, now: float) -> None:
        self._alerts = alerts
        self._stall_current = stall_current
        self._turning_since: float | None = None  # when the wheels were told to turn
        self._stopped_since: float | None = now  # when the permission went
        self._speeds: dict[type[RoverFrame], tuple[float, float]] = {}  # fastest wheel in rpm, when
        self._currents: dict[type[RoverFrame], tuple[float, float]] = {}  # highest current in A, when

    def told(self, wheels: Wheels, now: float) -> None:
        """The wheels are told something."""
        if wheels == STANDSTILL:
            self._turning_since = None
        elif self._turning_since is None:
            self._turning_since = now

    def permission(self, permission: Permission, now: float) -> None:
        """The drives are enabled or stopped."""
        self._stopped_since = None if permission.granted else now

    def hear(self, frame: RoverFrame, now: float) -> list[Event]:
        """A module told something."""
        match frame:
            case WheelSpeedRight() | WheelSpeedLeft():
                self._speeds[type(frame)] = (highest(frame.front_rpm, frame.middle_rpm, frame.rear_rpm), now)
                return self._stalled(now) + self._runaway(now)
            case MotorCurrentRight() | MotorCurrentLeft():
                self._currents[type(frame)] = (highest(frame.front, frame.middle, frame.rear), now)
                return self._stalled(now)
            case MotorDriverStatusRight(status=status):
                return self._driver(DRIVER_RIGHT, status, now)
            case MotorDriverStatusLeft(status=status):
                return self._driver(DRIVER_LEFT, status, now)
            case BmsStatus(status=battery):
                return self._battery(battery, now)
        return []

    def _stalled(self, now: float) -> list[Event]:
        told = self._turning_since is not None and now - self._turning_since >= STALL_TIME
        speed, current = recent(self._speeds, now), recent(self._currents, now)
        stalls = told and speed is not None and speed < TURNING and (current or 0.0) >= self._stall_current
        text = f"told to turn for {STALL_TIME:g} s, but no wheel does, at {current or 0.0:.0f} A"
        return self._hold(STALLED, stalls, text, now)

    def _runaway(self, now: float) -> list[Event]:
        stopped = self._stopped_since is not None and now - self._stopped_since >= COAST_TIME
        speed = recent(self._speeds, now) or 0.0
        text = f"a wheel turns at {speed:.0f} rpm without permission"
        return self._hold(RUNAWAY, stopped and speed >= TURNING, text, now)

    def _driver(self, kind: AlertKind, status: DriverState | None, now: float) -> list[Event]:
        fine = status in (DriverState.RUNNING, DriverState.STOPPED)
        return self._hold(kind, not fine, f"{kind.name}: {name_of(status)}", now)

    def _battery(self, state: BatteryState | None, now: float) -> list[Event]:
        return self._hold(BATTERY, state is not BatteryState.OK, f"battery: {name_of(state)}", now)

    def _hold(self, kind: AlertKind, holds: bool, text: str, now: float) -> list[Event]:
        return self._alerts.arise(kind, text, now) if holds else self._alerts.rectify(kind)


def highest(*values: float | None) -> float:
    """The largest magnitude of what is known, 0 if nothing is."""
    return max((abs(value) for value in values if value is not None), default=0.0)


def recent(measured: dict[type[RoverFrame], tuple[float, float]], now: float) -> float | None:
    """The highest of both sides, of what was measured lately; None if nothing was."""
    return max((value for value, when in measured.values() if now - when < AGE), default=None)


def name_of(code: DriverState | BatteryState | None) -> str:
    """A state in words."""
    return "unknown" if code is None else code.name.lower().replace("_", " ")
