"""The autopilot as the stations see it: mode, set point, and what makes it safe. A pure machine.

Only the commander's words reach this machine (`vehicle` sees to that). Set points are whole tenths of a
degree, 0..3599, in the boat's heading reference: what is shown is exactly what is commanded.

The rules (spec/boat.md, "$PARP received" and "Safety rules"):

input             accepted when                   effect
engage            not in ALARM, heading < 3 s     HEADING_HOLD at the present heading
disengage         always                          STANDBY, in ALARM too
set, turn         HEADING_HOLD                    the set point, modulo 360; never the mode
bus silent 3 s    -                               ALARM; commands but disengage are refused
heading lost 3 s  HEADING_HOLD                    ALARM
data is back      ALARM                           what the pilot reports, else STANDBY and a disengage
pilot's report    no command is under way         the truth about mode and set point
pilot's report    a command is under way          confirms it, or is ignored until the command is 2 s old
2 s unconfirmed   the pilot was ever heard        alert; the report is the truth again

Pilots differ, and their drivers (`vehicles.boat.pilots`) say how. One that `adopts` chooses its course by its own
compass when it is engaged, so that engaging it is confirmed by the mode alone; every other course is confirmed only
by the same course, told. One that is brought to a course step by step has 2 s for each step (`progressed`). A driver
may object to a course before it is accepted, and may give up one that was.

Nothing here ever engages but the commander. A command is repeated at 1 Hz while it is under way, and a course
while it is ours: until the pilot reports a mode or a set point that somebody gave it elsewhere. Two heads
that both repeat would fight over the rudder.
"""

from collections.abc import Callable
from enum import Enum, StrEnum

import msgspec

from timonel.core.alerts import Alerts
from timonel.core.effects import Event, Refused
from timonel.vehicles.boat.alerts import BACKBONE_SILENT, HEADING_LOST, PILOT_NOT_FOLLOWING, PILOT_SILENT

TURN = 3600  # tenths of a degree in a full turn
DATA_AGE = 3.0  # s, spec/boat.md rules 4 and 7
FOLLOW_TIME = 2.0  # s, spec/boat.md "Commands become NMEA 2000"
REPEAT_INTERVAL = 1.0  # s, same place
PILOT_AGE = 10.0  # s; 127237 comes at 4 Hz by the book, but some pilots send it only when something changes
REPORT_GRACE = 1.0  # s that a pilot heard before may take to report after an ALARM; it reports at 4 Hz
HEADING_LOST_TEXT = f"no heading for {DATA_AGE:g} s while holding one"
SAME_COURSE = 5  # tenths: pilots that hold whole or half degrees still confirm


class Mode(StrEnum):
    """What the pilot does. The value is the word in STATUS; a mode nobody understands is an empty field."""

    STANDBY = "STANDBY"
    HEADING_HOLD = "HEADING_HOLD"
    TRACK = "TRACK"
    ALARM = "ALARM"
    UNKNOWN = ""


class Manner(Enum):
    """Why the pilot is told to hold a course now."""

    ENGAGE = "engage"  # hold on to the present heading
    COURSE = "course"  # hold this course, or let go
    REPEAT = "repeat"  # the same again


# Looked up once: a member of an enum costs as much as a call, and these stand between a key and the rudder.
ENGAGE, COURSE, REPEAT = Manner.ENGAGE, Manner.COURSE, Manner.REPEAT
STANDBY, HEADING_HOLD, ALARM, UNKNOWN = Mode.STANDBY, Mode.HEADING_HOLD, Mode.ALARM, Mode.UNKNOWN


class Steer(Event, frozen=True, gc=False):
    """Tell the pilot: hold `setpoint` (tenths of a degree), or let go if `setpoint` is None."""

    setpoint: int | None


class PilotChanged(Event, frozen=True, gc=False):
    """Mode or set point (tenths of a degree, None if not known) are not what they were."""

    mode: Mode
    setpoint: int | None


class PilotReport(msgspec.Struct, frozen=True, gc=False):
    """What the pilot says of itself: `mode` None means it does not tell, `setpoint` in tenths of a degree."""

    mode: Mode | None
    setpoint: int | None = None


class Command(msgspec.Struct, frozen=True, gc=False):
    """A command that the pilot has yet to confirm, by `deadline` (s); `told` is whether it must tell its course."""

    mode: Mode
    setpoint: int | None
    deadline: float
    told: bool = False

    def confirmed_by(self, report: PilotReport) -> bool:
        """Whether the pilot does what it was told."""
        if report.mode is not self.mode:
            return False
        if self.setpoint is None:
            return True
        if report.setpoint is None:
            return not self.told
        return same_course(self.setpoint, report.setpoint)


def same_course(a: int, b: int) -> bool:
    """Whether two set points (tenths of a degree) are one, as far as a pilot's own steps allow."""
    return abs((a - b + TURN // 2) % TURN - TURN // 2) <= SAME_COURSE


def tenths(degrees: float) -> int:
    """A course in degrees as whole tenths 0..3599, rounded to nearest."""
    return round(degrees * 10) % TURN


class Pilot:
    """Mode and set point of the autopilot, told the time."""

    def __init__(self, alerts: Alerts, now: float) -> None:
        self.adopts = False
        """Whether the pilot itself chooses the course when it is engaged, and tells every course that it holds."""
        self.objection: Callable[[int, float], str | None] | None = None
        """Why a set point cannot be commanded at a time (s); None if it can, or if every one can."""
        self.manner = COURSE
        """Why the last `Steer` was said."""
        self._alerts = alerts
        self._mode = STANDBY
        self._setpoint: int | None = None
        self._alarm = False
        self._bus_heard = now
        self._bus_silent = False
        self._heading: float | None = None
        self._heading_heard = now
        self._report: PilotReport | None = None
        self._report_heard = now
        self._report_due = now
        self._command: Command | None = None
        self._ours = False
        self._may_hold = False  # the pilot was told to hold, and not yet where it could hear it to let go
        self._repeat_at = now
        self._recover_at: float | None = None

    # What people see ------------------------------------------------------------------------------

    @property
    def mode(self) -> Mode:
        """The mode for STATUS: ALARM covers whatever the pilot was doing."""
        return ALARM if self._alarm else self._mode

    @property
    def setpoint(self) -> int | None:
        """The set point for STATUS in tenths of a degree: 0 in STANDBY, None where it is not known."""
        return 0 if self._mode is STANDBY else self._setpoint

    @property
    def pending(self) -> bool:
        """Whether a command waits for the pilot to confirm it."""
        return self._command is not None

    @property
    def reported_mode(self) -> Mode | None:
        """The mode that the pilot itself told last; None if it told none."""
        return None if self._report is None else self._report.mode

    def heading(self, now: float) -> float | None:
        """The present heading in degrees; None if the last one is 3 s old."""
        return self._heading if now < self._heading_heard + DATA_AGE else None

    # What the bus tells ---------------------------------------------------------------------------

    def expect_no_bus(self) -> None:
        """There may be no backbone: one that was never heard is not missed."""
        self._bus_heard = float("inf")

    def bus_heard(self, now: float) -> list[Event]:
        """Any frame came in from the backbone."""
        self._bus_heard = now
        if not self._bus_silent:
            return []
        self._bus_silent = False
        self._report_due = max(self._report_due, now + PILOT_AGE)
        return self._alerts.rectify(BACKBONE_SILENT) + self._data_back(now)

    def heading_heard(self, degrees: float, now: float) -> list[Event]:
        """A valid heading in the boat's reference, degrees."""
        self._heading = degrees
        self._heading_heard = now
        if not self._alerts.active(HEADING_LOST):
            return []
        return self._alerts.rectify(HEADING_LOST) + self._data_back(now)

    def reported(self, report: PilotReport, now: float) -> list[Event]:
        """The pilot told its mode, its set point or both."""
        self._report = report
        self._report_heard = now
        self._report_due = now + PILOT_AGE
        back = self._alerts.rectify(PILOT_SILENT)
        if self._alarm:
            return back if self._recover_at is None else back + self._recover(now)
        if self._command is None:
            return back + self._adopt(report)
        if not self._command.confirmed_by(report):
            return back
        self._command = None
        return back + self._alerts.rectify(PILOT_NOT_FOLLOWING) + self._adopt(report)

    # What the commander says ----------------------------------------------------------------------

    def engage(self, station: int, now: float) -> list[Event]:
        """Hold the present heading."""
        if self._alarm:
            return [Refused("alarm", station)]
        heading = self.heading(now)
        if heading is None:
            return [Refused("no heading", station)]
        setpoint = tenths(heading)
        if self.objection is not None and (reason := self.objection(setpoint, now)) is not None:
            return [Refused(reason, station)]
        adopted = self.adopts and self.reported_mode is not HEADING_HOLD
        return self._steer(HEADING_HOLD, setpoint, now, ENGAGE if adopted else COURSE)

    def disengage(self, now: float) -> list[Event]:
        """Let go of the rudder. Always accepted."""
        self._alarm = False
        self._recover_at = None
        effects = self._alerts.rectify(HEADING_LOST) + self._steer(STANDBY, None, now)
        self._may_hold = self._bus_silent
        return effects

    def set_heading(self, setpoint: int, station: int, now: float) -> list[Event]:
        """Hold `setpoint`, tenths of a degree."""
        if self._mode is not HEADING_HOLD or self._alarm:
            return [Refused("not in heading hold", station)]
        setpoint %= TURN
        if self.objection is not None and (reason := self.objection(setpoint, now)) is not None:
            return [Refused(reason, station)]
        return self._steer(HEADING_HOLD, setpoint, now)

    def turn(self, change: int, station: int, now: float) -> list[Event]:
        """Move the set point by `change` tenths of a degree, starboard positive."""
        if self._setpoint is None:
            return [Refused("no set point", station)]
        return self.set_heading(self._setpoint + change, station, now)

    # What the driver says --------------------------------------------------------------------------

    def progressed(self, now: float) -> None:
        """The pilot followed one of several steps, and has as long for the next."""
        if self._command is not None:
            self._command = msgspec.structs.replace(self._command, deadline=now + FOLLOW_TIME)

    def gave_up(self, reason: str, now: float) -> list[Event]:
        """What is under way will not be brought to its end: the pilot's report is the truth again."""
        return [] if self._command is None else self._unconfirmed(now, reason)

    # Time -----------------------------------------------------------------------------------------

    @property
    def deadline(self) -> float:
        """When `expire` should be called, s."""
        times = [float("inf") if self._bus_silent else self._bus_heard + DATA_AGE]
        if self._watches_heading:
            times.append(self._heading_heard + DATA_AGE)
        if self._watches_pilot:
            times.append(self._report_due)
        if self._command is not None:
            times.append(self._command.deadline)
        if self._repeats:
            times.append(self._repeat_at)
        if self._recover_at is not None:
            times.append(self._recover_at)
        return min(times)

    def expire(self, now: float) -> list[Event]:
        """What the passing of time brings about. What gives up a command or a report comes before what
        watches over the mode that is then shown."""
        effects: list[Event] = []
        if not self._bus_silent and now >= self._bus_heard + DATA_AGE:
            effects += self._bus_lost(now)
        if self._watches_pilot and now >= self._report_due:
            effects += self._pilot_lost(now)
        if self._command is not None and now >= self._command.deadline:
            effects += self._unconfirmed(now)
        if self._recover_at is not None and now >= self._recover_at:
            effects += self._let_go()
        if self._watches_heading and now >= self._heading_heard + DATA_AGE:
            effects += self._heading_lost(now)
        if self._repeats and now >= self._repeat_at:
            effects += self._repeat(now)
        return effects

    @property
    def _watches_heading(self) -> bool:
        return self.mode is HEADING_HOLD and self._heading is not None

    @property
    def _watches_pilot(self) -> bool:
        return self._report is not None and not self._bus_silent and not self._alerts.active(PILOT_SILENT)

    @property
    def _repeats(self) -> bool:
        return (self._ours or self._command is not None) and not self._alarm

    # How it is done -------------------------------------------------------------------------------

    def _steer(self, mode: Mode, setpoint: int | None, now: float, manner: Manner = COURSE) -> list[Event]:
        self.manner = manner
        self._command = Command(mode, None if manner is ENGAGE else setpoint, now + FOLLOW_TIME, self.adopts)
        self._ours = self._may_hold = mode is HEADING_HOLD
        self._repeat_at = now + REPEAT_INTERVAL
        self._mode, self._setpoint = mode, setpoint
        return [PilotChanged(self.mode, self.setpoint), Steer(setpoint)]

    def _show(self, mode: Mode, setpoint: int | None) -> list[Event]:
        self._mode, self._setpoint = mode, setpoint
        return [PilotChanged(self.mode, self.setpoint)]

    def _adopt(self, report: PilotReport) -> list[Event]:
        if report.mode is None:
            return []
        setpoint = self._reported_setpoint(report)
        self._ours = self._ours and report.mode is HEADING_HOLD and self._is_ours(setpoint)
        if (report.mode, setpoint) == (self._mode, self._setpoint):
            return []
        return self._show(report.mode, setpoint)

    def _reported_setpoint(self, report: PilotReport) -> int | None:
        if report.mode is STANDBY:
            return None
        if report.setpoint is None and report.mode is self._mode:
            return self._setpoint  # it holds on without saying what
        return report.setpoint

    def _is_ours(self, setpoint: int | None) -> bool:
        return setpoint is not None and self._setpoint is not None and same_course(setpoint, self._setpoint)

    def _bus_lost(self, now: float) -> list[Event]:
        self._bus_silent = True
        text = f"nothing heard from the backbone for {DATA_AGE:g} s"
        return self._alerts.arise(BACKBONE_SILENT, text, now) + self._sound()

    def _heading_lost(self, now: float) -> list[Event]:
        return self._alerts.arise(HEADING_LOST, HEADING_LOST_TEXT, now) + self._sound()

    def _sound(self) -> list[Event]:
        self._alarm = True
        self._command = None
        return [PilotChanged(self.mode, self.setpoint)]

    def _pilot_lost(self, now: float) -> list[Event]:
        text = f"the pilot has not reported for {PILOT_AGE:g} s"
        effects = self._alerts.arise(PILOT_SILENT, text, now)
        if self._alarm or self._ours or self._mode is STANDBY:
            return effects
        return effects + self._show(UNKNOWN, None)

    def _unconfirmed(self, now: float, reason: str = "") -> list[Event]:
        command, self._command = self._command, None
        if self._report is None or command is None:
            return []
        text = "engage" if command.mode is HEADING_HOLD else "standby"
        why = f": {reason}" if reason else f" for {FOLLOW_TIME:g} s"
        effects = self._alerts.arise(PILOT_NOT_FOLLOWING, f"{text} not followed{why}", now)
        if now >= self._report_heard + DATA_AGE:
            return effects
        was_ours = self._ours
        effects += self._adopt(self._report)
        return effects + self._release() if was_ours and self._mode is STANDBY else effects

    def _data_back(self, now: float) -> list[Event]:
        if not self._alarm:
            return self._release()
        if self._bus_silent or self._alerts.active(HEADING_LOST):
            return []
        if self._report is None or now < self._report_heard + DATA_AGE:
            return self._recover(now)
        self._recover_at = now + REPORT_GRACE
        return []

    def _recover(self, now: float) -> list[Event]:
        report = self._report
        if report is None or report.mode is None:
            return self._let_go()
        self._recover_at = None
        if report.mode is HEADING_HOLD and self.heading(now) is None:
            return self._alerts.arise(HEADING_LOST, HEADING_LOST_TEXT, now)
        self._alarm = False
        self._ours = False
        return self._show(report.mode, self._reported_setpoint(report))

    def _let_go(self) -> list[Event]:
        self._alarm = False
        self._recover_at = None
        self._ours = False
        self._may_hold = self._may_hold or self._mode is not STANDBY
        return self._show(STANDBY, None) + self._release()

    def _release(self) -> list[Event]:
        self.manner = COURSE
        may_hold, self._may_hold = self._may_hold, False
        return [Steer(None)] if may_hold else []

    def _repeat(self, now: float) -> list[Event]:
        self.manner = REPEAT
        self._repeat_at = now + REPEAT_INTERVAL
        return [Steer(self._setpoint)]
