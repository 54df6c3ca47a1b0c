"""The alerts of other devices, in the one table of the boat.

Every one gets a number of its own (`FIRST` and up), which ALR, ACK and the console know it by, and keeps it while it
is remembered. What its owner tells moves the table; what people do moves the owner:

owner tells                    the table
active                         arises; it arises anew if the owner had it acknowledged, or counts it as a new one
holds                          arises if it is not there; says nothing about who has seen it
silenced, acknowledged         as if it were done here
rectified, normal              rectified; it stays until somebody has seen it, as ours do
nothing for `age` s            rectified: nobody knows any more whether it holds

people acknowledge, silence    the owner is told, unless it told us; `TRIES` times while it goes on as before

A flood of foreign alerts pushes out neither ours nor more urgent ones: there are `PLACES`, one source takes at most
`PLACES_OF_ONE`, and it changes them at most `CHANGES` times in `WINDOW` s; the rest is counted. What is told over and
over catches up as soon as it may.
"""

from collections import Counter
from collections.abc import Hashable
from enum import Enum, auto

import msgspec

from timonel.core.alerts import Alert, AlertKind, Alerts, Priority
from timonel.core.effects import Event
from timonel.core.pace import Allowance

FIRST = 401
PLACES = 256
PLACES_OF_ONE = 64
CHANGES, WINDOW = 20, 10.0  # of one source's alerts, s
SOURCES = 256  # whose changes are counted one by one
TRIES = 3
ANSWER_TIME = 2.0  # s that an owner may take to show that it has heard
NEVER = float("inf")


class Condition(Enum):
    """What an owner says of its alert."""

    NORMAL = auto()
    ACTIVE = auto()
    HOLDS = auto()
    SILENCED = auto()
    ACKNOWLEDGED = auto()
    RECTIFIED = auto()


class Order(Enum):
    """What an owner should do about its alert."""

    ACKNOWLEDGE = auto()
    SILENCE = auto()


OPEN = (Condition.ACTIVE, Condition.HOLDS, Condition.SILENCED, Condition.RECTIFIED)
"""Where an acknowledgement is news to the owner."""


class Report(msgspec.Struct, frozen=True, gc=False):
    """What a device tells of one of its alerts.

    `key` is which alert, and `source` who tells it, whatever address or port it comes from; `origin` is what was said,
    from which an answer is made. `occurrence` counts how often it arose, `age` is how long it counts if nothing more is
    heard, in s. `confirms` is whether the owner shows that it has heard an answer.
    """

    key: Hashable
    source: Hashable
    origin: object
    condition: Condition
    name: str
    text: str
    priority: Priority
    age: float
    occurrence: int | None = None
    confirms: bool = True


class Answer(msgspec.Struct, frozen=True, gc=False):
    """What the owner of an alert is to be told; `origin` is what was said of it last, and `source` who said it."""

    order: Order
    origin: object
    source: Hashable


class Entry:
    """A foreign alert: its number, what its owner told last and when, and what waits for its answer."""

    __slots__ = ("age", "answer_due", "condition", "heard", "number", "report", "silenced_until", "tries")

    def __init__(self, number: int, report: Report, now: float) -> None:
        self.number = number
        self.report = report
        self.condition = Condition.NORMAL
        self.heard = now
        self.age = report.age
        self.answer_due = NEVER
        self.silenced_until: float | None = None
        self.tries = 0

    @property
    def kind(self) -> AlertKind:
        return AlertKind(self.number, self.report.name, self.report.priority)

    @property
    def deadline(self) -> float:
        return min(self.answer_due, self.heard + self.age)


class ForeignAlerts:
    """Other devices' alerts in the boat's table."""

    def __init__(self, alerts: Alerts, counters: Counter[str]) -> None:
        self._alerts = alerts
        self._counters = counters
        self._entries: dict[Hashable, Entry] = {}
        self._numbers: dict[int, Entry] = {}
        self._allowances: dict[Hashable, Allowance] = {}

    def entry(self, number: int) -> Entry | None:
        """The foreign alert of a number; None is one of ours, or none."""
        return self._numbers.get(number)

    def known(self, key: Hashable) -> Entry | None:
        """The foreign alert of a key."""
        return self._entries.get(key)

    @property
    def entries(self) -> list[Entry]:
        """All that are remembered, the longest known first."""
        return list(self._entries.values())

    # What owners tell -----------------------------------------------------------------------------

    def report(self, report: Report, now: float) -> list[Event]:
        """A device told of an alert."""
        entry = self._entries.get(report.key)
        if entry is None:
            return [] if report.condition is Condition.NORMAL else self._introduce(report, now)
        entry.heard, entry.age = now, report.age
        news = self._news(entry, report)
        if not news and _words(entry.report) == _words(report):
            entry.report = report
            return []
        if not self._allowed(report.source, now):
            return []
        worded = self._worded(entry, report)
        return worded + self._apply(entry, report, now) if news else worded

    def reword(self, key: Hashable, name: str, text: str, now: float) -> list[Event]:
        """What an alert is called, told apart from its state."""
        entry = self._entries.get(key)
        if entry is None or (entry.report.name, entry.report.text) == (name, text):
            return []
        if not self._allowed(entry.report.source, now):
            return []
        return self._worded(entry, msgspec.structs.replace(entry.report, name=name, text=text))

    def _news(self, entry: Entry, report: Report) -> bool:
        if entry.report.occurrence != report.occurrence:
            return True
        if report.condition is Condition.HOLDS:
            return not self._alerts.active(entry.kind)
        return entry.condition is not report.condition

    def _worded(self, entry: Entry, report: Report) -> list[Event]:
        """Name, text and priority are what was said last; of the state `_apply` knows."""
        entry.report = msgspec.structs.replace(report, occurrence=entry.report.occurrence)
        return self._alerts.reword(entry.kind, report.text)

    def _introduce(self, report: Report, now: float) -> list[Event]:
        if not self._allowed(report.source, now):
            return []
        number, events = self._place(report)
        if number is None:
            self._counters["alerts beyond the table"] += 1
            return []
        entry = self._entries[report.key] = self._numbers[number] = Entry(number, report, now)
        return events + self._apply(entry, report, now)

    def _apply(self, entry: Entry, report: Report, now: float) -> list[Event]:
        before, entry.condition = entry.condition, report.condition
        again = entry.report.occurrence != report.occurrence
        entry.report = report
        entry.answer_due, entry.tries = NEVER, 0
        kind, alerts = entry.kind, self._alerts
        renewed: list[Event] = []
        if report.condition is Condition.ACTIVE and (again or before is Condition.ACKNOWLEDGED):
            renewed = alerts.rectify(kind)
        match report.condition:
            case Condition.ACTIVE | Condition.HOLDS:
                return renewed + alerts.arise(kind, report.text, now)
            case Condition.SILENCED:
                return alerts.arise(kind, report.text, now) + alerts.silence(entry.number, now)
            case Condition.ACKNOWLEDGED:
                arisen = alerts.arise(kind, report.text, now, acknowledged=True)
                return arisen or alerts.acknowledge(entry.number)
            case Condition.RECTIFIED:
                arisen = [] if alerts.get(entry.number) else alerts.arise(kind, report.text, now)
                return arisen + alerts.rectify(kind)
            case _:
                return alerts.rectify(kind)

    # What people do -------------------------------------------------------------------------------

    def changed(self, alert: Alert, now: float) -> list[Answer]:
        """The table has changed: what the alert's owner does not know yet."""
        entry = self._numbers.get(alert.kind.id)
        if entry is None or alert.kind.priority is Priority.CAUTION or self._is_past(alert):
            return []
        silenced_until, entry.silenced_until = entry.silenced_until, alert.silenced_until
        if alert.acknowledged:
            news = entry.condition in OPEN and entry.tries == 0
            return self._acknowledged(entry, now) if news else []
        if alert.silenced_until in (None, silenced_until) or entry.condition is Condition.SILENCED:
            return []
        return [Answer(Order.SILENCE, entry.report.origin, entry.report.source)]

    def _is_past(self, alert: Alert) -> bool:
        """Whether the number has become another's, or the alert has changed again: nothing is answered for what was."""
        present = self._alerts.get(alert.kind.id)
        return present is not None and present != alert

    def _acknowledged(self, entry: Entry, now: float) -> list[Answer]:
        entry.tries = 1
        if entry.report.confirms:
            entry.answer_due = now + ANSWER_TIME
        return [Answer(Order.ACKNOWLEDGE, entry.report.origin, entry.report.source)]

    # Time -----------------------------------------------------------------------------------------

    @property
    def deadline(self) -> float:
        """When `expire` is due, s."""
        return min((entry.deadline for entry in self._entries.values()), default=NEVER)

    def expire(self, now: float) -> tuple[list[Event], list[Answer]]:
        """What an owner has not answered is told it again; what nobody tells any more holds no longer."""
        events: list[Event] = []
        answers: list[Answer] = []
        for entry in self.entries:
            if entry.answer_due <= now:
                answers += self._insist(entry, now)
            if entry.heard + entry.age <= now:
                events += self._age(entry)
        return events, answers

    def _insist(self, entry: Entry, now: float) -> list[Answer]:
        if entry.tries >= TRIES:
            entry.answer_due = NEVER
            self._counters["acknowledgements without effect"] += 1
            return []
        entry.tries += 1
        entry.answer_due = now + ANSWER_TIME
        return [Answer(Order.ACKNOWLEDGE, entry.report.origin, entry.report.source)]

    def _age(self, entry: Entry) -> list[Event]:
        entry.heard = NEVER
        entry.answer_due = NEVER
        entry.condition = Condition.NORMAL
        return self._alerts.rectify(entry.kind)

    # Bounds ---------------------------------------------------------------------------------------

    def _allowed(self, source: Hashable, now: float) -> bool:
        allowance = self._allowances.get(source)
        if allowance is None:
            if len(self._allowances) >= SOURCES:
                del self._allowances[next(iter(self._allowances))]
            allowance = self._allowances[source] = Allowance(CHANGES, WINDOW)
        if allowance.take(now):
            return True
        self._counters["alert changes beyond the allowance"] += 1
        return False

    def _place(self, report: Report) -> tuple[int | None, list[Event]]:
        """A number for a new alert, and what becomes of the one that must make room; None if there is no room."""
        own = [entry for entry in self._entries.values() if entry.report.source == report.source]
        if len(own) >= PLACES_OF_ONE:
            return self._replace(own, report)
        free = next((number for number in range(FIRST, FIRST + PLACES) if number not in self._numbers), None)
        return self._replace(self.entries, report) if free is None else (free, [])

    def _replace(self, entries: list[Entry], report: Report) -> tuple[int | None, list[Event]]:
        """The place of one that stands no longer, else of the least urgent if that is less urgent than the new one."""
        gone = min(entries, key=self._worth)
        if self._worth(gone) >= (1, -report.priority):
            return None, []
        del self._entries[gone.report.key], self._numbers[gone.number]
        return gone.number, self._alerts.forget(gone.number)

    def _worth(self, entry: Entry) -> tuple[int, int]:
        alert = self._alerts.get(entry.number)
        return (0, 0) if alert is None else (1, -alert.kind.priority)


def _words(report: Report) -> tuple[str, str, Priority]:
    return report.name, report.text, report.priority
