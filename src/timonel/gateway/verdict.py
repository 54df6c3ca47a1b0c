"""What became of a command, as far as the sentences of the far end tell it. Pure machines, told the time.

The protocol has neither an acknowledgement nor a refusal: there is STATUS, at once after every change or refusal
(a gateway) or only at 2 Hz (the ESP32), and one may be on its way while the command still travels. So:

STATUS after the command                               verdict
shows what stood in the way before the command too     refused, for that reason
shows the effect                                       done
any other, less than 0.5 s after                       none yet: it may be older than the command
any other, later                                       refused

A request for command ends otherwise:

heard                                                  verdict
CMDTRANSFER to us, or a STATUS that names us           granted
announced, then CMDTRANSFER to another                 refused: only the bridge's override passes us by
announced, then CMDREQUEST of another                  refused: it was denied, the next one is asked about
announced, and nothing 1 s after the deadline          refused: it was denied
waiting, then CMDTRANSFER to another, and no           refused: the override emptied the queue (the head of a
    CMDREQUEST in the next 0.5 s                           queue is announced with the transfer before it)
"""

from collections.abc import Callable
from enum import Enum
from typing import Protocol

import msgspec

from timonel.gateway.lookout import OVERDUE
from timonel.nmea0183 import parp
from timonel.nmea0183.parp import PilotMode, Verb

ON_THE_WAY = 0.5
"""Seconds by which a STATUS that was sent before our command arrived has come in."""
JITTER = 0.25
"""Seconds that a deadline may be off between the far end's clock and what is heard of it here."""

STEERING = frozenset({Verb.SETHEADING, Verb.PORTONE, Verb.STBDONE, Verb.PORTTEN, Verb.STBDTEN})


class Grant(Enum):
    """How a station came into command."""

    ALREADY = "already in command"
    NOBODY = "nobody was in command"
    ANSWERED = "the commander gave it"
    SILENCE = "the commander did not answer"


class Done(msgspec.Struct, frozen=True):
    """The command has had its effect; `grant` says how, for a request."""

    grant: Grant | None = None


class Refusal(msgspec.Struct, frozen=True):
    """The command has had none, and will have none."""

    reason: str


class Verdict(Protocol):
    """Hears what comes in after a command until it knows what became of it."""

    def hear(self, report: parp.Report, now: float) -> Done | Refusal | None: ...


def named(station: int) -> str:
    return f"station {station:02d}" if station else "nobody"


def obstacle(verb: Verb, station: int, status: parp.Status) -> str | None:
    """What forbids `verb` to `station` in the state that `status` shows; None if nothing does."""
    if verb is Verb.TAKECMD:
        return None
    if status.commander != station:
        return f"{named(status.commander)} is in command"
    if verb is Verb.ENGAGE or verb in STEERING:
        return _no_steering(verb, status)
    return None


def _no_steering(verb: Verb, status: parp.Status) -> str | None:
    if status.mode is PilotMode.ALARM:
        return "the far end is in ALARM"
    if verb is Verb.ENGAGE:
        return "no heading" if status.heading_deg is None else None
    if status.mode is not PilotMode.HEADING_HOLD:
        return f"no heading is being held ({status.mode_text or 'mode unknown'})"
    return None


class CommandVerdict:
    """Waits for the STATUS that `shows` the effect of `verb`, sent at `sent` when `before` was the last STATUS."""

    def __init__(
        self,
        verb: Verb,
        station: int,
        shows: Callable[[parp.Status], bool],
        *,
        sent: float,
        before: parp.Status | None,
    ) -> None:
        self._verb = verb
        self._station = station
        self._shows = shows
        self._settled = sent + ON_THE_WAY
        self._obstacle = obstacle(verb, station, before) if before else None

    def hear(self, report: parp.Report, now: float) -> Done | Refusal | None:
        if not isinstance(report, parp.Status):
            return None
        reason = obstacle(self._verb, self._station, report)
        if reason is not None and reason == self._obstacle:
            return Refusal(reason)
        if self._shows(report):
            return Done()
        if now < self._settled:
            return None
        return Refusal(reason or f"STATUS shows no effect of {self._verb}")


class RequestVerdict:
    """Waits for what becomes of the request of `station`; `announced` is when it was, if it was before."""

    def __init__(self, station: int, request_seconds: float, announced: float | None = None) -> None:
        self._station = station
        self._request_seconds = request_seconds
        self._announced = announced
        self._passed_by: tuple[int, float] | None = None

    @property
    def announced(self) -> bool:
        """Whether the commander has been asked."""
        return self._announced is not None

    def hear(self, report: parp.Report, now: float) -> Done | Refusal | None:
        match report:
            case parp.CommandRequested():
                return self._asked(report.station, now)
            case parp.CommandTransferred(previous, commander):
                return self._transferred(previous, commander, now)
            case parp.Status(commander=commander) if commander == self._station:
                return Done(Grant.NOBODY) if self._announced is None else self._granted(now)
            case parp.Status():
                return self._unanswered(report.commander, now)

    def _asked(self, station: int, now: float) -> Refusal | None:
        self._passed_by = None
        if station == self._station:
            self._announced = now if self._announced is None else self._announced
        elif self._announced is not None:
            return Refusal(f"denied; {named(station)} is asked about now")
        return None

    def _transferred(self, previous: int, commander: int, now: float) -> Done | Refusal | None:
        if commander == self._station:
            return Done(Grant.NOBODY) if previous == 0 else self._granted(now)
        if self._announced is not None:
            return Refusal(f"{named(commander)} has taken command")
        if commander:
            self._passed_by = (commander, now)
        return None

    def _granted(self, now: float) -> Done:
        silent = self._announced is not None and now >= self._announced + self._request_seconds - JITTER
        return Done(Grant.SILENCE if silent else Grant.ANSWERED)

    def _unanswered(self, commander: int, now: float) -> Refusal | None:
        if self._announced is not None and now >= self._announced + self._request_seconds + OVERDUE:
            return Refusal(f"denied; {named(commander)} stays in command")
        if self._passed_by is not None and now >= self._passed_by[1] + ON_THE_WAY:
            return Refusal(f"{named(self._passed_by[0])} has taken command")
        return None
