"""Alarms and their acknowledgement."""

from enum import StrEnum
from typing import Annotated

from timonel.nmea0183.fields import Integer, Letter
from timonel.nmea0183.sentence import Sentence
from timonel.nmea0183.sentences.kinds import AOrV, Name, UtcTime

AlarmId = Annotated[int | None, Integer(3, 0, 99999)]


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


class ACN(Sentence, frozen=True):
    """A command about an alert: `maker` is of whom its number is, "" the standard's; `status` is always C, a command.

    Source: IEC 61162-1, ACN.
    """

    time: UtcTime = None
    maker: Name = None
    alarm: AlarmId = None
    instance: Annotated[int | None, Integer(1, 0, 999999)] = None
    command: Annotated[AlertCommand | None, Letter(AlertCommand)] = None
    status: Name = None
