"""Alarms, alerts and their acknowledgement.

ALR and ACK are the older pair: a number, whether the condition holds, whether somebody has seen it. ALF, ALC, ACN, ARC
and HBT are those of bridge alert management.
"""

from enum import StrEnum
from typing import Annotated, Self

import msgspec

from timonel.nmea0183.checksum import LONGEST, seal
from timonel.nmea0183.fields import Integer, Letter, escaped, text_of
from timonel.nmea0183.sentence import Sentence
from timonel.nmea0183.sentences.kinds import AOrV, Name, UtcTime

AlarmId = Annotated[int | None, Integer(3, 0, 9999999)]
Instance = Annotated[int | None, Integer(1, 0, 999999)]

HIGHEST_SENTENCE = 99  # of one ALC list


class ALR(Sentence, frozen=True):
    """State of one alarm; `time` is when it changed."""

    time: UtcTime = None
    alarm: AlarmId = None
    active: AOrV = None
    acknowledged: AOrV = None
    text: Name = None


class ACK(Sentence, frozen=True):
    """Acknowledges the alarm."""

    alarm: AlarmId = None


class AlertCommand(StrEnum):
    """What is to be done about an alert."""

    ACKNOWLEDGE = "A"
    REPEAT = "Q"
    TAKE_RESPONSIBILITY = "O"
    SILENCE = "S"


class AlertUrgency(StrEnum):
    """Priority of an alert."""

    EMERGENCY = "E"
    ALARM = "A"
    WARNING = "W"
    CAUTION = "C"


class AlertCondition(StrEnum):
    """State of an alert."""

    UNACKNOWLEDGED = "V"
    SILENCED = "S"
    ACKNOWLEDGED = "A"
    TRANSFERRED = "O"
    RECTIFIED = "U"
    NORMAL = "N"


class AlertCategory(StrEnum):
    """What it takes to judge an alert: A the display of its system, B what the alert says, C people who look."""

    A = "A"
    B = "B"
    C = "C"


class ACN(Sentence, frozen=True):
    """A command about an alert: `maker` is of whom its number is, "" the standard's; `status` is always C, a command.

    Source: IEC 61162-1, ACN.
    """

    time: UtcTime = None
    maker: Name = None
    alarm: AlarmId = None
    instance: Instance = None
    command: Annotated[AlertCommand | None, Letter(AlertCommand)] = None
    status: Name = None


class ALF(Sentence, frozen=True):
    """State of one alert in up to two sentences: the first tells its title, the second describes it.

    Time, category, priority and state are in the first only. `revision` counts the changes, 1..99; `escalation` how
    often it was announced again, 0..9. Source: IEC 61162-1, ALF.
    """

    total: Annotated[int | None, Integer(1, 1, 2)] = None
    number: Annotated[int | None, Integer(1, 1, 2)] = None
    sequence: Annotated[int | None, Integer(1, 0, 9)] = None
    time: UtcTime = None
    category: Annotated[AlertCategory | None, Letter(AlertCategory)] = None
    priority: Annotated[AlertUrgency | None, Letter(AlertUrgency)] = None
    state: Annotated[AlertCondition | None, Letter(AlertCondition)] = None
    maker: Name = None
    alarm: AlarmId = None
    instance: Instance = None
    revision: Annotated[int | None, Integer(1, 0, 99)] = None
    escalation: Annotated[int | None, Integer(1, 0, 9)] = None
    text: Name = None


class ARC(Sentence, frozen=True):
    """A command about an alert that is not carried out. Source: IEC 61162-1, ARC."""

    time: UtcTime = None
    maker: Name = None
    alarm: AlarmId = None
    instance: Instance = None
    command: Annotated[AlertCommand | None, Letter(AlertCommand)] = None


class HBT(Sentence, frozen=True):
    """A sign of life: it comes every `interval` s; `normal` is whether the sender is sound."""

    interval: Annotated[int | None, Integer(1, 0, 999)] = None
    normal: AOrV = None
    sequence: Annotated[int | None, Integer(1, 0, 9)] = None


class Listed(msgspec.Struct, frozen=True, gc=False):
    """An alert in a list: whose, which, and at what revision."""

    maker: str | None = None
    alarm: int | None = None
    instance: int | None = None
    revision: int | None = None


class ALC(Sentence, frozen=True):
    """The alerts that stand, told over and over; a list of none says so. Source: IEC 61162-1, ALC."""

    total: int = 1
    number: int = 1
    sequence: int = 0
    entries: tuple[Listed, ...] = ()

    def encode(self, talker: str = "II") -> bytes:
        head = f"{talker}ALC,{self.total:02d},{self.number:02d},{self.sequence:02d},{len(self.entries)}"
        return seal(head + "".join(map(_entry, self.entries)))

    @classmethod
    def read(cls, wires: list[bytes]) -> Self | None:
        try:
            total, number, sequence, count = map(_whole, wires[:4])
            groups = zip(*(iter(wires[4:]),) * 4, strict=True)
            entries = tuple(_listed(*group) for group in groups)
        except ValueError:
            return None
        return cls(total, number, sequence, entries) if len(entries) == count and 1 <= number <= total else None


def listing(alerts: list[Listed], sequence: int, talker: str = "II") -> list[ALC]:
    """As few sentences as hold `alerts` in order, each within 82 characters; one if there are none."""
    room = LONGEST - len(f"${talker}ALC,99,99,99,99*hh\r\n")
    groups: list[list[Listed]] = [[]]
    left = room
    for alert in alerts:
        needed = len(_entry(alert))
        if needed > left:
            groups.append([])
            left = room
        groups[-1].append(alert)
        left -= needed
    groups = groups[:HIGHEST_SENTENCE]
    return [ALC(len(groups), number, sequence, tuple(group)) for number, group in enumerate(groups, 1)]


def _whole(wire: bytes) -> int:
    number = int(wire)
    if number < 0:
        raise ValueError
    return number


def _listed(maker: bytes, alarm: bytes, instance: bytes, revision: bytes) -> Listed:
    return Listed(
        text_of(maker) if maker else None, *(_whole(wire) if wire else None for wire in (alarm, instance, revision))
    )


def _entry(alert: Listed) -> str:
    numbers = ("" if number is None else str(number) for number in (alert.alarm, alert.instance, alert.revision))
    return f",{escaped(alert.maker, 'ALC.maker') if alert.maker else ''},{','.join(numbers)}"
