"""The way to a course with a pilot that must first be engaged, and that perhaps knows only changes of course.

A pure machine, told by what the pilot reports. All courses here are tenths of a degree as the pilot counts them.

the pilot reports                            what is done
not in heading hold, not engaged yet         waited for; the order to engage is repeated
heading hold                                 a course to be commanded is commanded now
the course that was aimed at                 the end
the course as before the last step           waited for
the course as the last step should make it   progress, and the next step
any other course                             given up: somebody else steers
not in heading hold, engaged before          given up: the pilot let go

Steps are never repeated: one that is lost looks like one that was not followed yet. Whoever waits is not waited for
longer than `vehicles.boat.pilot` allows.
"""

from timonel.vehicles.boat.pilot import SAME_COURSE, TURN, Mode

OTHER_HEAD = "another course was set elsewhere"
LET_GO = "the pilot let go by itself"
STEPPED = 5  # tenths that a step may come out otherwise: pilots count whole or half degrees


def difference(a: int, b: int) -> int:
    """From `b` to `a` the short way round, starboard positive, in tenths."""
    return (a - b + TURN // 2) % TURN - TURN // 2


class Approach:
    """Where the way is: nowhere, before the pilot is engaged, or between two steps."""

    def __init__(self) -> None:
        self.target: int | None = None
        """The course to come to; None if the pilot is only to be engaged, or nothing is under way."""
        self.active = False
        self.engaged = False
        """Whether the pilot holds a heading, as far as this way is concerned."""
        self._before = 0
        self._step = 0

    def begin(self, target: int | None, engaged: bool) -> None:
        """A new aim. A step that is under way is still waited for."""
        if not (self.active and engaged):
            self._step = 0
        self.active, self.target, self.engaged = True, target, engaged

    def end(self) -> bool:
        """There is no aim any more; whether there was one."""
        was, self.active, self.target, self._step = self.active, False, None, 0
        return was

    @property
    def stepping(self) -> bool:
        """Whether a step is under way that the pilot has yet to report."""
        return self._step != 0

    def report_mode(self, mode: Mode | None) -> str | None:
        """The pilot told its mode; why the way has ended, or None."""
        if mode is Mode.HEADING_HOLD:
            self.engaged = True
        elif self.engaged and mode is not None:
            self.end()
            return LET_GO
        return None

    def report_course(self, course: int) -> str | None:
        """The pilot told its course; why the way has ended, or None. `stepping` tells whether a step is followed."""
        moved = difference(course, self._before)
        if self._step and abs(moved - self._step) <= min(STEPPED, abs(self._step) // 2):
            self._step = 0
        elif self._step and abs(moved) > min(STEPPED, abs(self._step) // 2):
            self.end()
            return OTHER_HEAD
        return None

    def left(self, course: int) -> int:
        """What is left from `course` to the aim; 0 when it is there, as far as pilots' own steps allow."""
        apart = 0 if self.target is None else difference(self.target, course)
        return apart if abs(apart) > SAME_COURSE else 0

    def step(self, course: int, change: int) -> None:
        """A step of `change` is under way from `course`."""
        self._before, self._step = course, change
