"""Alarms and their acknowledgement."""

from typing import Annotated

from timonel.nmea0183.fields import Integer
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
