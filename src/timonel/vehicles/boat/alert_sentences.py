"""Alerts as sentences: what those of instruments mean, and how all of the table are said to the stations.

ALR      one alarm: a number, whether it holds, whether somebody has seen it
ALF      one alert with priority, state and up to two texts
ALC      the list of an instrument's alerts: what is not in it any more is over

A number is its instrument's own: it is known by port, talker, manufacturer, number and instance.
"""

import unicodedata
from collections.abc import Hashable, Iterable
from typing import TypeVar

import msgspec

from timonel.core.alerts import Alert, Priority
from timonel.core.effects import Say, SayTo
from timonel.nmea0183.sentences import (
    ACK,
    ACN,
    ALC,
    ALF,
    ALR,
    HBT,
    AlertCategory,
    AlertCommand,
    AlertCondition,
    AlertUrgency,
    Listed,
)
from timonel.nmea0183.sentences.alarm import listing
from timonel.vehicles.boat.alert_messages import plain
from timonel.vehicles.boat.foreign_alerts import Condition, Order, Report

T = TypeVar("T")

MAKER = "ARP"  # whose numbers ours are, in the sentences that tell
AGE = 600.0  # s: many instruments say ALR once when something changes
LIST_INTERVAL = 30.0  # s, of ALC and HBT
ROOM = {"ALR": 48, "title": 30, "text": 40}  # characters that always fit
KEPT = 64
TURN = 10  # of the sequence numbers of ALF and HBT
REVISIONS = 99

PRIORITIES = {
    AlertUrgency.EMERGENCY: Priority.EMERGENCY,
    AlertUrgency.ALARM: Priority.ALARM,
    AlertUrgency.WARNING: Priority.WARNING,
    AlertUrgency.CAUTION: Priority.CAUTION,
}
URGENCIES = {priority: urgency for urgency, priority in PRIORITIES.items()}
CONDITIONS = {
    AlertCondition.UNACKNOWLEDGED: Condition.ACTIVE,
    AlertCondition.SILENCED: Condition.SILENCED,
    AlertCondition.ACKNOWLEDGED: Condition.ACKNOWLEDGED,
    AlertCondition.TRANSFERRED: Condition.ACKNOWLEDGED,
    AlertCondition.RECTIFIED: Condition.RECTIFIED,
    AlertCondition.NORMAL: Condition.NORMAL,
}
ORDERS = {Order.ACKNOWLEDGE: AlertCommand.ACKNOWLEDGE, Order.SILENCE: AlertCommand.SILENCE}


# In ---------------------------------------------------------------------------------------------------


class Instrument(tuple[str, str]):
    """Who speaks: a port and a talker on it."""

    __slots__ = ()


def key(instrument: Instrument, maker: str | None, alarm: int | None, instance: int | None) -> Hashable:
    """Which alert of an instrument; ALR tells neither manufacturer nor instance."""
    return ("sentence", *instrument, maker or "", alarm, instance or 1)


def alr(sentence: ALR, instrument: Instrument) -> Report | None:
    """What ALR tells; None for "there are no alarms", which some say without a number."""
    if sentence.alarm is None or sentence.active is None:
        return None
    condition = Condition.NORMAL
    if sentence.active:
        condition = Condition.ACKNOWLEDGED if sentence.acknowledged else Condition.ACTIVE
    name = plain(sentence.text) or f"alarm {sentence.alarm}"
    identity = key(instrument, None, sentence.alarm, None)
    return Report(identity, instrument, sentence, condition, name, instrument[0], Priority.ALARM, AGE, confirms=False)


class Lists:
    """What ALF and ALC say in several sentences, put together; bounded, whatever comes."""

    def __init__(self) -> None:
        self._titles: dict[Hashable, ALF] = {}
        self._texts: dict[Hashable, str | None] = {}
        self._lists: dict[Hashable, tuple[int, int, list[Listed]]] = {}

    def alf(self, sentence: ALF, instrument: Instrument) -> Report | None:
        """What ALF tells: with its first sentence, and once more if the text of its second is another than before."""
        identity = key(instrument, sentence.maker, sentence.alarm, sentence.instance)
        if sentence.number == 1:
            _keep(self._titles, identity, sentence)
            return _alf(sentence, instrument, self._texts.get(identity) if sentence.total == 2 else None)
        title = self._titles.pop(identity, None)
        if title is None or title.sequence != sentence.sequence:
            return None
        _keep(self._texts, identity, sentence.text)
        return _alf(title, instrument, sentence.text)

    def alc(self, sentence: ALC, instrument: Instrument) -> list[Listed] | None:
        """The whole list, with its last sentence; None before, and for one that misses a part."""
        number, sequence, entries = self._lists.pop(instrument, (0, sentence.sequence, []))
        if sentence.number == 1:
            number, sequence, entries = 0, sentence.sequence, []
        if (sentence.number, sentence.sequence) != (number + 1, sequence):
            return None
        entries = entries + list(sentence.entries)
        if sentence.number == sentence.total:
            return entries
        _keep(self._lists, instrument, (sentence.number, sequence, entries))
        return None


def _keep(kept: dict[Hashable, T], key: Hashable, value: T) -> None:
    """Remember a part, and not more of them than a ship's instruments have at once."""
    if len(kept) >= KEPT and key not in kept:
        del kept[next(iter(kept))]
    kept[key] = value


def _alf(sentence: ALF, instrument: Instrument, text: str | None) -> Report | None:
    if sentence.alarm is None or sentence.state is None:
        return None
    identity = key(instrument, sentence.maker, sentence.alarm, sentence.instance)
    name = plain(sentence.text) or f"alert {sentence.alarm}"
    priority = Priority.ALARM if sentence.priority is None else PRIORITIES[sentence.priority]
    said = plain(text) or instrument[0]
    condition = CONDITIONS[sentence.state]
    return Report(identity, instrument, sentence, condition, name, said, priority, AGE, confirms=False)


def answer(order: Order, origin: object, instrument: Instrument) -> list[SayTo]:
    """What tells an instrument of an acknowledgement, on its own port: others have the same numbers."""
    match origin:
        case ALR(alarm=alarm) if order is Order.ACKNOWLEDGE:
            return [SayTo(ACK(alarm).encode(), "ACK", instrument[0])]
        case ALF():
            command = ACN(None, origin.maker, origin.alarm, origin.instance, ORDERS[order], "C")
            return [SayTo(command.encode(), "ACN", instrument[0])]
    return []


# Out --------------------------------------------------------------------------------------------------


def fitting(text: str, room: int) -> str:
    """`text` in ASCII without the characters that a sentence reserves, at most `room` of them."""
    letters = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    return "".join(" " if letter in "!$*,\\^~" or not letter.isprintable() else letter for letter in letters)[:room]


def said_alr(alert: Alert, time: float | None) -> bytes:
    """An alert as ALR; `time` is when it changed, s of the day."""
    return ALR(time, alert.kind.id, alert.active, alert.acknowledged, fitting(alert.kind.name, ROOM["ALR"])).encode()


class Speaker:
    """ALF, ALC and HBT of the table, for those who understand them."""

    def __init__(self, now: float) -> None:
        self.deadline = now + LIST_INTERVAL
        self._revisions: dict[int, int] = {}
        self._sequence = 0
        self._beat = 0

    def changed(self, alert: Alert, time: float | None) -> list[Say]:
        """An alert as it stands after a change."""
        number = alert.kind.id
        self._revisions[number] = self._revisions.get(number, 0) % REVISIONS + 1
        if not alert.active and alert.acknowledged:
            revision = self._revisions.pop(number)
        else:
            revision = self._revisions[number]
        return self._said(alert, revision, time)

    def again(self, alert: Alert, time: float | None) -> list[Say]:
        """The same once more, nothing having changed."""
        return self._said(alert, self._revisions.get(alert.kind.id, 1), time)

    def _said(self, alert: Alert, revision: int, time: float | None) -> list[Say]:
        self._sequence = (self._sequence + 1) % TURN
        text = fitting(alert.text, ROOM["text"])
        total = 2 if text.strip() else 1
        described = ALF(
            total,
            2,
            self._sequence,
            maker=MAKER,
            alarm=alert.kind.id,
            instance=1,
            revision=revision,
            escalation=min(alert.announced, 9),
            text=text,
        )
        title = msgspec.structs.replace(
            described,
            number=1,
            time=time,
            category=AlertCategory.B,
            priority=URGENCIES[alert.kind.priority],
            state=condition_of(alert),
            text=fitting(alert.kind.name, ROOM["title"]),
        )
        return [Say(sentence.encode(), "ALF", urgent=True) for sentence in (title, described)[:total]]

    def expire(self, standing: Iterable[Alert], now: float) -> list[Say]:
        """The list of what stands, and the sign of life, when they are due."""
        if now < self.deadline:
            return []
        self.deadline = now + LIST_INTERVAL
        self._beat = (self._beat + 1) % TURN
        listed = [Listed(MAKER, alert.kind.id, 1, self._revisions.get(alert.kind.id, 1)) for alert in standing]
        lists = [Say(sentence.encode(), "ALC", urgent=True) for sentence in listing(listed, self._beat)]
        beat = HBT(round(LIST_INTERVAL), True, self._beat).encode()
        return [*lists, Say(beat, "HBT", urgent=True)]


def condition_of(alert: Alert) -> AlertCondition:
    """The state of an alert, as ALF says it."""
    if not alert.active:
        return AlertCondition.NORMAL if alert.acknowledged else AlertCondition.RECTIFIED
    if alert.transferred:
        return AlertCondition.TRANSFERRED
    if alert.acknowledged:
        return AlertCondition.ACKNOWLEDGED
    return AlertCondition.UNACKNOWLEDGED if alert.silenced_until is None else AlertCondition.SILENCED
