"""What every driver of a pilot has in common: how it is asked, what it answers, and what is known of it.

`vehicle` asks the driver that the owner chose, and nobody else speaks to the pilot:

asked                      when                                                       answers with
objection                  before a station's course is accepted                      why not, or None
steer                      a station in command steers; again at 1 Hz while           messages to the pilot
                           the pilot has not confirmed it, or holds our course
reported                   the pilot told something of itself                         the next step of a course that
                                                                                      takes several
passed                     command passed to another station, or to nobody            nothing, or that it gave up
expire                     the driver's `deadline` has come                           what a control head says to
                                                                                      show that it is there

A driver that lets go sends it at once, whether it knows the pilot's address or not. It confirms nothing itself: a
command is followed when the pilot reports it (`vehicles.boat.pilot`).
"""

from collections.abc import Callable, Sequence
from enum import StrEnum

import msgspec

from timonel.core.effects import Event, SayTo
from timonel.nmea2000.lookups import HeadingReference
from timonel.nmea2000.sender import Outgoing
from timonel.vehicles.boat.pilot import Manner, PilotReport
from timonel.vehicles.boat.reports import PilotMessage, Reading

NEVER = float("inf")


class Evidence(StrEnum):
    """How it is known that a pilot understands what a driver sends."""

    STANDARD = "standard"
    """It is written in a standard. Whether a pilot obeys it is another matter."""
    CAPTURED = "captured"
    """The bytes stand in a recording of a control head and its pilot."""
    REVERSE_ENGINEERED = "reverse-engineered"
    """Somebody found out, and others use it; no recording here shows it."""


class Kind(msgspec.Struct, frozen=True):
    """A driver as its owner chooses it: what it steers, what it can do, and how we know."""

    name: str
    steers: str
    """Which pilots, for people."""
    evidence: Evidence
    sources: str
    """Public recordings and programs that the bytes come from."""
    sends: str
    confirmed_by: str
    absolute: bool
    """Whether a course is commanded as such, or by steps that the pilot confirms one by one."""
    references: str
    """What north the pilot's courses are counted from."""
    adopts: bool = False
    """Whether the pilot chooses the course when it is engaged: the heading of its own compass."""


class Progressed(Event, frozen=True, gc=False):
    """The pilot has followed one of several steps."""


class GaveUp(Event, frozen=True, gc=False):
    """What was commanded will not be brought to its end."""

    reason: str


Answer = Outgoing | SayTo | Progressed | GaveUp


class Driver:
    """Says to a pilot what it is to do. Set points are tenths of a degree in the boat's reference."""

    messages_only = False
    """Whether steering takes messages to the bus and nothing else."""
    on_bus = True
    """Whether it needs an address on the bus to speak to the pilot."""
    deadline = NEVER
    """When `expire` should be called, s."""

    def objection(self, setpoint: int, now: float) -> str | None:
        """Why the pilot cannot be told to hold `setpoint`; None if it can."""
        return None

    def steer(self, setpoint: int | None, heading: float | None, now: float, manner: Manner) -> Sequence[Answer]:
        """Make it hold `setpoint`, or let go if that is None; `manner` says why now.

        `heading` is the boat's own in degrees, in the same reference, if it is known.
        """
        raise NotImplementedError

    def hear(self, reading: Reading, heading: float | None, now: float) -> float | None:
        """The course that the pilot tells, in rad of the boat's reference; None where that cannot be known.

        `heading` is the boat's own in degrees at the same time, if it is known.
        """
        raise NotImplementedError

    def reported(
        self, message: PilotMessage, reading: Reading, report: PilotReport, pending: bool, now: float
    ) -> Sequence[Answer]:
        """The pilot told something of itself; `pending` is whether it has yet to confirm a command."""
        return ()

    def passed(self) -> Sequence[Answer]:
        """Command is no longer where it was."""
        return ()

    def expire(self, now: float) -> Sequence[Answer]:
        """What the passing of time brings about."""
        return ()


class Compass(msgspec.Struct, frozen=True):
    """How courses are turned from one north to another: exactly, or not at all.

    `reference` is the boat's, in which stations speak; `to` and `back` are the truth's.
    """

    reference: HeadingReference
    to_true: Callable[[float | None, HeadingReference | None, float], float | None]
    to_magnetic: Callable[[float | None, HeadingReference | None, float], float | None]

    def ours(self, course: float | None, reference: HeadingReference | None, now: float) -> float | None:
        """A course of the pilot in the boat's reference."""
        return self._turned(course, reference, self.reference, now)

    def theirs(self, course: float, reference: HeadingReference, now: float) -> float | None:
        """A course of ours in the pilot's reference."""
        return self._turned(course, self.reference, reference, now)

    def _turned(
        self, course: float | None, source: HeadingReference | None, wanted: HeadingReference, now: float
    ) -> float | None:
        convert = self.to_true if wanted is HeadingReference.TRUE else self.to_magnetic
        return convert(course, source, now)
