"""Drivers of pilots that choose their own course when they are engaged, and are then brought to another.

`ByCourse` commands a course as such, `BySteps` changes it step by step and waits for each. What a maker's pilot is
told in which bytes stands in the file of that maker.
"""

from collections.abc import Iterator, Sequence
from math import degrees, radians

from timonel.nmea2000.lookups import HeadingReference
from timonel.vehicles.boat.pilot import Manner, Mode, PilotReport, tenths
from timonel.vehicles.boat.pilots.approach import Approach
from timonel.vehicles.boat.pilots.driver import NEVER, Answer, Compass, Driver, GaveUp, Progressed
from timonel.vehicles.boat.pilots.finder import Finder
from timonel.vehicles.boat.reports import PilotMessage, Reading

NO_VARIATION = "no magnetic variation: the pilot's courses cannot be told from ours"
PASSED = "command has passed"


class EngagedPilot(Driver):
    """A pilot that is engaged first. Which messages do what, the makers' drivers say."""

    tells_course = True
    """Whether it tells the course that it has chosen when it is engaged, and not only the last one before."""
    uncountable = NO_VARIATION
    """Why a course of ours cannot be told as the pilot counts it."""
    keep_alive: tuple[float, ...] = ()
    """How often a control head shows that it is there, in s, each in its own way."""

    def __init__(self, finder: Finder, compass: Compass) -> None:
        self.finder = finder
        self.compass = compass
        self._approach = Approach()
        self._goal: int | None = None  # a set point of ours that is to be commanded once the pilot is engaged
        self._mode: Mode | None = None
        self._course: int | None = None  # that the pilot told last, as it counts
        self._shown_at: list[float] = []  # when a control head is to show that it is there; empty until it was used

    # What makers say otherwise ---------------------------------------------------------------------

    def engage(self) -> list[Answer]:
        """Hold the present heading."""
        raise NotImplementedError

    def release(self) -> list[Answer]:
        """Let go, whether the pilot's address is known or not."""
        raise NotImplementedError

    def theirs(self, setpoint: int, now: float) -> int | None:
        """A set point of ours as the pilot counts it, in tenths; None where that cannot be known."""
        return self.turned(setpoint, HeadingReference.MAGNETIC, now)

    def turned(self, setpoint: int, reference: HeadingReference, now: float) -> int | None:
        """A set point of ours counted from `reference`, in tenths; None without variation."""
        course = self.compass.theirs(radians(setpoint / 10), reference, now)
        return None if course is None else tenths(degrees(course))

    def proceed(self, course: int, left: int) -> list[Answer]:
        """Come to the aim, which is `left` from the `course` that the pilot holds."""
        raise NotImplementedError

    def show(self, which: int) -> list[Answer]:
        """A control head is there: the message of `keep_alive[which]`."""
        return []

    # How it goes -----------------------------------------------------------------------------------

    def objection(self, setpoint: int, now: float) -> str | None:
        """See `Driver`."""
        reason = self.finder.objection
        if reason is not None:
            return reason
        return self.uncountable if self.theirs(setpoint, now) is None else None

    def hear(self, reading: Reading, heading: float | None, now: float) -> float | None:
        """See `Driver`."""
        return self.compass.ours(reading.course, reading.reference, now)

    def steer(self, setpoint: int | None, heading: float | None, now: float, manner: Manner) -> Sequence[Answer]:
        """See `Driver`."""
        if not self._shown_at:
            self._shown_at = [now] * len(self.keep_alive)
        if setpoint is None:
            self._approach.end()
            return self.release()
        if manner is Manner.REPEAT:
            return self.repeat()
        self._goal = None if manner is Manner.ENGAGE else setpoint
        waiting = self._approach.active and not self._approach.engaged
        engaged = self._mode is Mode.HEADING_HOLD
        self._approach.begin(self._target(now), engaged)
        if engaged:
            return list(self._onward())
        return () if waiting else self.engage()

    def repeat(self) -> Sequence[Answer]:
        """Say again what can be said again and has not been followed."""
        return self.engage() if self._approach.active and not self._approach.engaged else ()

    def reported(
        self, message: PilotMessage, reading: Reading, report: PilotReport, pending: bool, now: float
    ) -> Sequence[Answer]:
        """See `Driver`."""
        if reading.mode is not None:
            if reading.mode is not self._mode and self.tells_course:
                self._course = None
            self._mode = reading.mode
        if reading.course is not None:
            self._course = tenths(degrees(reading.course))
        if not pending:
            self._approach.end()
        if not self._approach.active:
            return ()
        self._approach.target = self._target(now)
        return list(self._follow(reading.mode))

    def _target(self, now: float) -> int | None:
        return None if self._goal is None else self.theirs(self._goal, now)

    def passed(self) -> Sequence[Answer]:
        """See `Driver`. A course that is still being approached is left where it is."""
        return (GaveUp(PASSED),) if self._approach.end() else ()

    def _follow(self, mode: Mode | None) -> Iterator[Answer]:
        engaged, stepping = self._approach.engaged, self._approach.stepping
        reason = self._approach.report_mode(mode)
        if reason is None and self._course is not None:
            reason = self._approach.report_course(self._course)
        if reason is not None:
            yield GaveUp(reason)
            return
        if (engaged, stepping) != (self._approach.engaged, self._approach.stepping):
            yield Progressed()
        yield from self._onward()

    def _onward(self) -> Iterator[Answer]:
        """What brings the pilot nearer to its aim, if that is the next thing to do."""
        approach, course = self._approach, self._course
        if course is not None and approach.engaged and not approach.stepping and (left := approach.left(course)):
            yield from self.proceed(course, left)

    # A control head that is there ------------------------------------------------------------------

    @property
    def deadline(self) -> float:  # type: ignore[override]
        """See `Driver`."""
        return min(self._shown_at, default=NEVER)

    def expire(self, now: float) -> Sequence[Answer]:
        """See `Driver`."""
        answers: list[Answer] = []
        for which, (due, interval) in enumerate(zip(self._shown_at, self.keep_alive, strict=True)):
            if now >= due:
                self._shown_at[which] = max(due + interval, now)
                answers += self.show(which)
        return answers


class ByCourse(EngagedPilot):
    """A pilot that takes a course as such."""

    def set_course(self, target: int) -> list[Answer]:
        """Hold `target`, tenths as the pilot counts them."""
        raise NotImplementedError

    def proceed(self, course: int, left: int) -> list[Answer]:
        """The course in one."""
        target = self._approach.target
        assert target is not None
        self._approach.step(course, left)
        return self.set_course(target)

    def repeat(self) -> Sequence[Answer]:
        """See `EngagedPilot`. A course as such may be said again: it is the same course."""
        approach = self._approach
        if approach.stepping and approach.target is not None:
            return self.set_course(approach.target)
        return super().repeat()


class BySteps(EngagedPilot):
    """A pilot that takes changes of course only; `theirs` makes the aim of them."""

    def change(self, step: int) -> tuple[int, list[Answer]]:
        """The largest single change towards `step` tenths that the pilot knows, and the message for it."""
        raise NotImplementedError

    def proceed(self, course: int, left: int) -> list[Answer]:
        """One step, and no other until the pilot reports this one."""
        step, answers = self.change(left)
        self._approach.step(course, step)
        return answers
