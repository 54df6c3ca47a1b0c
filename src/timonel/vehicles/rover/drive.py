"""What makes the wheels turn, and above all what stops them. A pure machine.

Only the commander's stick and permission reach this machine (`helm` sees to that); a stop reaches it from anybody.
Times are in s, sticks and set points in percent. Ages count from the last byte of a frame, not from the silence that
proved it. Rules (spec/rover.md, Driving):

input                     accepted when                       effect
stick                     within +-100                        set points, while permitted
permission `'1'`          the stick is at rest                the drives are enabled
anything else as 101      always, from any station            stop
command passes            always                              stop
stick 200 ms old          -                                   set points to zero, permission kept
commander silent 500 ms   -                                   stop, permission must be given anew
commander silent 2 s      -                                   command is released (`helm`)

A permission is an event, not a level: one given before, to somebody else or before a stop, counts for nothing. A set
point is never queued: the latest wins, with its age. A stop is repeated for as long as nobody is permitted to drive.

mixing    left = forward + right, right = forward - right, each clamped, times the speed limit / 20
"""

from enum import Enum

import msgspec

from timonel.core.effects import Event, Refused
from timonel.core.pace import Pace

FULL = 100  # percent
LIMIT_STEPS = 20  # of the speed limit; 20 is full speed
STALE = 0.2  # s, the 2017 firmware's limit too
SILENT = 0.5  # s
PERIOD = 0.02  # s: 50 Hz
HEADROOM = 0.005  # s after a period that a 50 Hz stick may be late before its last set point is repeated for it
STOP_PERIOD = 0.2  # s between repetitions of a stop that was said for `STOP_BURST` seconds at 50 Hz
STOP_BURST = 0.5  # s


class Wheels(Event, frozen=True, gc=False):
    """Set points for the three wheels of each side, in percent of full speed, forward positive."""

    left: int
    right: int


class Permission(Event, frozen=True, gc=False):
    """The drives were enabled or stopped, and why."""

    granted: bool
    reason: str


class Stop(Enum):
    """Why the drives were stopped."""

    ORDERED = "a station ordered a stop"
    TRANSFERRED = "command passed"
    SILENT = "the commander fell silent"
    ROVER_SILENT = "the rover fell silent"
    UNPLUGGED = "the link of the commander was unplugged"


class Stick(msgspec.Struct, frozen=True, gc=False):
    """A joystick as frame 100 has it, -100..100: `x` -100 is full forward, `y` 100 is full right."""

    y: int
    x: int

    @property
    def at_rest(self) -> bool:
        """Whether nobody pushes it."""
        return self.y == 0 and self.x == 0


AT_REST = Stick(0, 0)
STANDSTILL = Wheels(0, 0)


def mixed(stick: Stick, speed_limit: int) -> Wheels:
    """What a stick asks of the wheels. Source: the mixer of the protocol's 2017 firmware (spec/rover.md)."""
    forward, right = -stick.x, stick.y
    return Wheels(_limited(forward + right, speed_limit), _limited(forward - right, speed_limit))


def _limited(percent: int, speed_limit: int) -> int:
    """Clamped to +-100 and scaled; rounded towards zero, so that a limit is never exceeded."""
    return int(max(-FULL, min(FULL, percent)) * speed_limit / LIMIT_STEPS)


class Drive:
    """The drives of a rover, told the time."""

    def __init__(self, now: float) -> None:
        self.permitted = False
        self.speed_limit = LIMIT_STEPS
        self._stick = AT_REST
        self._stick_heard = now
        self._heard = now
        self._burst_until = now
        self._next = now
        self._pace = Pace(PERIOD)
        self._said = STANDSTILL

    # What the commander says ----------------------------------------------------------------------

    def heard(self, now: float, age: float = 0.0) -> None:
        """Any frame came in from the commander's link, `age` s ago."""
        self._heard = now - age

    def stick(self, stick: Stick, station: int, now: float, age: float = 0.0) -> list[Event]:
        """The commander's stick, `age` s old. What is out of range is refused, never clipped into motion."""
        if not (-FULL <= stick.y <= FULL and -FULL <= stick.x <= FULL):
            return [Refused("stick out of range", station)]
        self._stick = stick
        self._stick_heard = now - age
        halts = self.wheels(now) == STANDSTILL != self._said  # a stop is never held back
        if not self.permitted or not (halts or self._pace.open(now)):
            return []
        return self._say(now, PERIOD + HEADROOM)

    def permit(self, station: int, now: float) -> list[Event]:
        """The commander permits motion: an event, with the stick at rest."""
        if not self._stick.at_rest:
            return [Refused("stick not at rest", station)]
        if self.permitted:
            return []
        self.permitted = True
        self._next = now
        return [Permission(True, f"station {station}")]

    def limit(self, speed_limit: int, station: int) -> list[Event]:
        """Full speed is `speed_limit` / 20 from now on."""
        if not 1 <= speed_limit <= LIMIT_STEPS:
            return [Refused("limit out of range", station)]
        self.speed_limit = speed_limit
        return []

    def stop(self, reason: Stop, now: float) -> list[Event]:
        """Whoever says so: set points to zero at once, permission withdrawn.

        The stick is remembered: who still pushes it is not permitted anew before letting go.
        """
        told = [Permission(False, reason.value)] if self.permitted else []
        self.permitted = False
        self._burst_until = now + STOP_BURST
        return [*told, *self._say(now, PERIOD)]

    def passes(self, now: float) -> list[Event]:
        """Command passes to somebody whose stick nobody has seen yet, and whose silence begins to count now."""
        self._heard = now
        self._stick = AT_REST
        return self.stop(Stop.TRANSFERRED, now)

    # What the wheels are told ---------------------------------------------------------------------

    def wheels(self, now: float) -> Wheels:
        """The set points as they should be at `now`."""
        return mixed(self.obeyed(now), self.speed_limit)

    def obeyed(self, now: float) -> Stick:
        """The stick as far as it is obeyed at `now`: at rest without permission, or when it is too old."""
        fresh = now < self._stick_heard + STALE and now < self._heard + SILENT
        return self._stick if self.permitted and fresh else AT_REST

    @property
    def deadline(self) -> float:
        """When `expire` is due."""
        if not self.permitted:
            return self._next
        moves_until = self._next if self._said == STANDSTILL else self._stick_heard + STALE
        return min(self._next, moves_until, self._heard + SILENT)

    def expire(self, now: float) -> list[Event]:
        """Silence, and the next repetition."""
        if self.permitted and now >= self._heard + SILENT:
            return self.stop(Stop.SILENT, now)
        if now < self.deadline:
            return []
        rests = not self.permitted and now >= self._burst_until
        return self._say(now, STOP_PERIOD if rests else PERIOD)

    def _say(self, now: float, again_after: float) -> list[Event]:
        self._pace.count(now)
        self._next = now + again_after
        self._said = self.wheels(now)
        return [self._said]
