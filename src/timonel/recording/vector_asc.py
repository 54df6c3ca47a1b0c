"""Vector's ASC, which CANalyzer and its kin write.

    date Wed Sep 28 10:23:45.123 am 2016
    base hex  timestamps absolute
       0.015991 1  18EBFF00x       Rx   d 8 01 A0 0F A6 60 3B D1 40  Length = 273910 BitCount = 141 ID = 4...
    seconds since the date, channel, identifier (`x`: of 29 bits), direction, `d`ata or `r`emote, length, data

`timestamps relative` are seconds since the line before; `base dec` is for identifiers and data. The other events
of a measurement are passed over. Without a date, times count from 1970-01-01. Source: python-can `asc.py`, whose
reader is not used because it takes a line cut in its data for a shorter frame.
"""

import re
from collections.abc import Sequence
from datetime import UTC, datetime

from timonel.recording.lines import Kind, LogFrame, is_comment, moment

_EVENT = re.compile(r"\s*(\d+\.\d+)\s+(\S.*)")
_CAN = re.compile(r"(?:\d+\s+[0-9A-F]+x?|\d+\s+\S+\s+(?:Rx|Tx|TxRq)|CANFD)(?:\s.*)?", re.IGNORECASE)
_FRAME = re.compile(
    r"\d+\s+([0-9A-F]+)(x?)\s+(?:Rx|Tx|TxRq)\s+(?:r\b.*|d\s+([0-8])((?:\s+[0-9A-F]{1,3})*)(?:\s+Length\s*=.*)?)\s*",
    re.IGNORECASE,
)
_HEADING = re.compile(
    r"(?:date|base|//|(?:begin|end)\s+triggerblock|(?:no\s+)?internal\s+events|previous\s+log\s+file)\b.*|//.*",
    re.IGNORECASE,
)
_DATE = re.compile(
    r"(?:date|begin\s+triggerblock)\s+\w+\s+(\w{3})\s+(\d+)\s+(\d+):(\d+):(\d+)(\.\d+)?\s*([ap]m)?\s+(\d{4})\s*",
    re.IGNORECASE,
)
_BASE = re.compile(r"base\s+(hex|dec)(?:\s+timestamps\s+(absolute|relative))?.*", re.IGNORECASE)
_MONTHS = {"jan": 1, "feb": 2, "mar": 3, "apr": 4, "may": 5, "jun": 6, "jul": 7, "aug": 8, "sep": 9, "oct": 10}
_MONTHS |= {"nov": 11, "dec": 12, "mär": 3, "mai": 5, "okt": 10, "dez": 12}


class VectorAsc:
    """Lines of ASC."""

    name = "Vector ASC"
    kind: Kind = "frames"

    def __init__(self, sample: Sequence[str]) -> None:
        self._base = 16
        self._relative = False
        self._began = 0.0
        self._elapsed = 0.0
        self.dated = any(_DATE.fullmatch(line) for line in sample)

    def read(self, line: str) -> LogFrame | None:
        """A frame; None for a heading, a remote request or another event. ValueError for any other line."""
        event = _EVENT.fullmatch(line)
        if event is None:
            self._heading(line)
            return None
        time, text = event.groups()
        self._elapsed = self._elapsed + float(time) if self._relative else float(time)
        if not _CAN.fullmatch(text):
            return None
        frame = _FRAME.fullmatch(text)
        if frame is None:
            raise ValueError("not a classic CAN frame")
        identifier, extended, length, data = frame.groups()
        if length is None:
            return None
        number = int(identifier, self._base)
        if number >> (29 if extended else 11):
            raise ValueError("an identifier has 29 bits with x, 11 without")
        payload = self._bytes(data)
        if len(payload) != int(length):
            raise ValueError(f"{length} bytes announced, {len(payload)} found")
        return LogFrame(moment(self._began + self._elapsed), number, payload, bool(extended))

    def _heading(self, line: str) -> None:
        if not _HEADING.fullmatch(line.strip()) and not is_comment(line):
            raise ValueError("neither a heading nor an event")
        if base := _BASE.fullmatch(line):
            self._base = 10 if base[1].lower() == "dec" else 16
            self._relative = (base[2] or "").lower() == "relative"
        if date := _DATE.fullmatch(line):
            self._began = _unix(*date.groups())
            self._elapsed = 0.0

    def _bytes(self, text: str) -> bytes:
        if self._base == 16:
            return bytes.fromhex(text)
        return bytes(map(int, text.split()))


def _unix(
    month: str, day: str, hour: str, minute: str, second: str, part: str | None, half: str | None, year: str
) -> float:
    if month.lower() not in _MONTHS:
        raise ValueError(f"{month} is no month")
    hours = int(hour) if half is None else int(hour) % 12 + 12 * (half.lower() == "pm")
    date = datetime(int(year), _MONTHS[month.lower()], int(day), hours, int(minute), int(second), tzinfo=UTC)
    return date.timestamp() + float(part or 0)
