"""What became of a command: told from the machine's own state, and from what the pilot reports.

command                        confirmed when                            refused when
TAKECMD, and a request         the station has command                   the machine says so; the request is denied
RELCMD, ACKCMD, DENYCMD        the machine has obeyed                    the machine says so
ENGAGE, SETHEADING, turns      the pilot reports that it does            the machine says so
DISENGAGE                      the pilot reports STANDBY                 the station is not in command
enable, stop, limits           the drives are so                         the machine says so
acknowledge, silence           the alert is so                           there is no such alert

What is neither within 2 s is unconfirmed. A request may wait for as long as the commander has to answer.
"""

from collections.abc import Callable, Sequence

import msgspec

from timonel.core.command import CommandTransfer
from timonel.core.effects import Effect, Refused, Rejected, SecurityEvent
from timonel.vehicles.boat.pilot import FOLLOW_TIME, Mode, Pilot
from timonel.web.messages import Outcome

WITHIN = FOLLOW_TIME


class Verdict(msgspec.Struct, frozen=True):
    """How it ended, or, if `outcome` is "sent", what it waits for."""

    outcome: Outcome
    reason: str = ""

    @property
    def final(self) -> bool:
        """Whether nothing more will follow."""
        return self.outcome != "sent"


Judge = Callable[[float], Verdict | None]
"""Asked at a time (s) what became of a command; None while that is not known."""

CONFIRMED = Verdict("confirmed")


def refused(effects: Sequence[Effect], station: int) -> Verdict | None:
    """What the machine says against it, if anything."""
    for effect in effects:
        match effect:
            case Refused(reason=reason, station=whose) if whose == station:
                return Verdict("refused", reason)
            case Rejected(reason=reason) | SecurityEvent(reason=reason):
                return Verdict("refused", reason)
    return None


def at_once(holds: Callable[[], bool], sent: float) -> Judge:
    """Confirmed as soon as something holds."""

    def judge(now: float) -> Verdict | None:
        if holds():
            return CONFIRMED
        return None if now < sent + WITHIN else Verdict("unconfirmed")

    return judge


def steering(pilot: Pilot, wanted: Mode, sent: float) -> Judge:
    """Confirmed by the pilot's own report."""

    def judge(now: float) -> Verdict | None:
        if now >= sent + WITHIN:
            return Verdict("unconfirmed", "the pilot has not confirmed")
        if pilot.mode is not wanted:
            return Verdict("unconfirmed", "something else was commanded" if pilot.pending else "the mode has changed")
        return None if pilot.pending else CONFIRMED

    return judge


def request(transfer: CommandTransfer, station: int) -> Judge:
    """Confirmed when the station has command; it may wait in the queue."""

    def judge(now: float) -> Verdict | None:
        if transfer.commander == station:
            return CONFIRMED
        return None if station in transfer.queue else Verdict("refused", "denied")

    return judge
