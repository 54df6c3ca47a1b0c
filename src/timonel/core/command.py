"""Who may steer: the transfer of command between stations, as one pure machine.

It reads no clock: every call is told the time, `deadline` says when `expire` should be called, and `receive`
resolves what is overdue by itself first, so a late timer can never change the outcome.

The rules (spec/command.md):

event      by            accepted when                  effect
REQUEST    any station   nobody in command              in command at once
                         somebody else in command       joins the queue; its head is announced
                         in command or in the queue     refused; the deadline is not moved
RELEASE    commander     always                         head of the queue takes over, else nobody
ACKNOWLEDGE commander    the queue is not empty         head of the queue takes over
DENY       commander     the queue is not empty         head leaves the queue
TAKE       the bridge    always                         in command at once, the queue is emptied
(time)                   the deadline has passed        head takes over, or is denied if `on_timeout` says so

After every transfer and every denial the next in the queue is announced with a deadline of its own.
"""

from collections.abc import Sequence
from enum import Enum, auto

from timonel.core.effects import Event, Refused

NOBODY = 0
BRIDGE = 1
STATIONS = (1, 2, 3, 4)


class Verb(Enum):
    """What a station may say about command."""

    REQUEST = auto()
    RELEASE = auto()
    ACKNOWLEDGE = auto()
    DENY = auto()
    TAKE = auto()


class OnTimeout(Enum):
    """What becomes of a request that the commander leaves unanswered; the words of a configuration."""

    TRANSFER = "transfer"
    DENY = "deny"


class Transferred(Event, frozen=True, gc=False):
    """Command passed from `previous` to `commander`; 0 is nobody."""

    previous: int
    commander: int


class Requested(Event, frozen=True, gc=False):
    """The request of `station` is announced: the commander has until the deadline to answer."""

    station: int


class Denied(Event, frozen=True, gc=False):
    """The announced request of `station` was turned down, by the commander or by time."""

    station: int


class Overridden(Event, frozen=True, gc=False):
    """The bridge insisted: the requests of `stations` are void."""

    stations: tuple[int, ...]


class CommandTransfer:
    """The one commander and the queue of those who want to be it."""

    def __init__(self, *, timeout: float = 10.0, on_timeout: OnTimeout = OnTimeout.TRANSFER) -> None:
        self.timeout = timeout
        self.on_timeout = on_timeout
        self.commander = NOBODY
        self.queue: tuple[int, ...] = ()
        self.deadline: float | None = None

    def receive(self, verb: Verb, station: int, now: float, requester: int | None = None) -> list[Event]:
        """What `station` says at `now` (s), and what follows from it.

        `requester` is the station that an answer names; an answer to anybody but the announced requester is
        refused, since it answers a question that is no longer asked.
        """
        overdue = self.expire(now)
        if requester is not None and self.queue[:1] != (requester,):
            return [*overdue, Refused("no such request", station)]
        match verb:
            case Verb.REQUEST:
                effects = self._request(station, now)
            case Verb.TAKE:
                effects = self._take(station)
            case _ if station != self.commander:
                effects = [Refused("not in command", station)]
            case Verb.RELEASE:
                effects = self._pass_on(now)
            case _ if not self.queue:
                effects = [Refused("no request to answer", station)]
            case Verb.ACKNOWLEDGE:
                effects = self._pass_on(now)
            case Verb.DENY:
                effects = self._deny(now)
        return overdue + effects

    def expire(self, now: float) -> list[Event]:
        """Resolve the announced request if its deadline has come."""
        if self.deadline is None or now < self.deadline:
            return []
        return self._pass_on(now) if self.on_timeout is OnTimeout.TRANSFER else self._deny(now)

    def _request(self, station: int, now: float) -> list[Event]:
        if station not in STATIONS:
            return [Refused("no such station", station)]
        if self.commander == NOBODY:
            return self._hand_to(station)
        if station == self.commander:
            return [Refused("already in command", station)]
        if station in self.queue:
            return [Refused("already requested", station)]
        self.queue += (station,)
        return self._announce(now) if len(self.queue) == 1 else []

    def _take(self, station: int) -> list[Event]:
        if station != BRIDGE:
            return [Refused("only the bridge takes command", station)]
        void = tuple(waiting for waiting in self.queue if waiting != BRIDGE)
        self.queue = ()
        self.deadline = None
        overridden: list[Event] = [Overridden(void)] if void else []
        return overridden if self.commander == BRIDGE else overridden + self._hand_to(BRIDGE)

    def _pass_on(self, now: float) -> list[Event]:
        head, self.queue = (self.queue or (NOBODY,))[0], self.queue[1:]
        return self._hand_to(head) + self._announce(now)

    def _deny(self, now: float) -> list[Event]:
        head, self.queue = self.queue[0], self.queue[1:]
        return [Denied(head), *self._announce(now)]

    def _hand_to(self, station: int) -> list[Event]:
        previous, self.commander = self.commander, station
        return [Transferred(previous, station)]

    def _announce(self, now: float) -> list[Event]:
        if not self.queue:
            self.deadline = None
            return []
        self.deadline = now + self.timeout
        return [Requested(self.queue[0])]


def waiting(transfer: CommandTransfer, now: float) -> Sequence[tuple[int, float | None]]:
    """The queue with the seconds left for its head, for displays."""
    left = None if transfer.deadline is None else max(0.0, transfer.deadline - now)
    return [(station, left if place == 0 else None) for place, station in enumerate(transfer.queue)]
