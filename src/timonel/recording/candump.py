"""can-utils' candump, as it logs (`-L`, `-l`) and as it prints, with and without times.

    (1620807235.135072) can0 09F8017F#3E17B322B320590D          -L
      can0  09F8017F   [8]  3E 17 B3 22 B3 20 59 0D             no option
     (1676902769.342282)  can0  09F8017F   [8]  3E 17 ...    -t a; -t z: from 0; -t d: from the line before
     (2023-02-20 16:17:04.590873)  can0  09F8017F   [8]  ...    -t A

Source: can-utils `lib.c`, `candump.c`. Remote requests, error frames and CAN FD carry no data of this kind.
"""

import re
from collections.abc import Sequence
from itertools import pairwise

from timonel.nmea2000.text import CANDUMP
from timonel.recording.lines import DateTime, Kind, LogFrame, is_comment, moment

_ERROR = 0x20000000  # CAN_ERR_FLAG
_A_DAY = 86400.0
_MOST_IDENTIFIERS = 4096
_A_DATE = 1e8  # s: a smaller time, before 1973, counts from the start of something

_PRINTED = re.compile(
    r"\s*(?:\(([^)]+)\)\s+)?[\w.-]+\s+(?:[RT]X\s+\S+\s+\S+\s+)?([0-9A-F]{3}|[0-9A-F]{8})\s+\[(\d)\]\s*(.*)",
    re.IGNORECASE,
)
_STAMP = re.compile(r"\s*\(([^)]+)\)")
_SECONDS = re.compile(r"\d+\.\d+")


class Candump:
    """Lines of candump."""

    name = "candump"
    kind: Kind = "frames"

    def __init__(self, sample: Sequence[str]) -> None:
        self._date_time = DateTime()
        self._deltas = _are_deltas(sample)
        self._elapsed = 0.0
        self._second, self._microseconds = "", 0
        self._identifiers: dict[str, tuple[int, bool]] = {}
        self._data = 0
        self.dated = any(_is_date(match[1]) for match in map(_STAMP.match, sample) if match)

    def read(self, line: str) -> LogFrame | None:
        """A frame; None for a comment, a remote request or an error frame. ValueError for any other line."""
        # Once a line: what was read before, the second and what stands between the time and the data, is not read
        # anew, and the data is looked for where it was last. The quotient is the one that `float` makes of the digits.
        data = self._data
        known = self._identifiers.get(line[18:data])
        if known is None:
            data = self._data = line.find("#") + 1
            known = self._identifiers.get(line[18:data])
        fraction, digits = line[12:18], line[data:]
        if known is not None and line[:12] == self._second and fraction.isdecimal():
            try:
                payload = bytes.fromhex(digits)
            except ValueError:
                return self._any(line)
            if 2 * len(payload) == len(digits) <= 16:
                return LogFrame((self._microseconds + int(fraction)) / 1e6, known[0], payload, known[1])
        return self._any(line)

    def _any(self, line: str) -> LogFrame | None:
        match = CANDUMP.fullmatch(line)
        if match is not None:
            stamp, identifier, data = match.groups()
            frame = _frame(float(stamp), identifier, data)
            if frame is not None and match.end(1) == 18:
                self._remember(line, match.end(2) + 1, frame)
            return frame
        if is_comment(line):
            return None
        return self._printed(line)

    def _remember(self, line: str, data: int, frame: LogFrame) -> None:
        """`(1669809600.` and `) can0 0DF11917#` of a line, unless its interface has a `#`, too."""
        if line[11] != "." or line.index("#") + 1 < data:
            return
        if len(self._identifiers) == _MOST_IDENTIFIERS:
            self._identifiers.clear()
        self._second, self._microseconds = line[:12], int(line[1:11]) * 1_000_000
        self._identifiers[line[18:data]] = frame.identifier, frame.extended

    def _printed(self, line: str) -> LogFrame | None:
        match = _PRINTED.fullmatch(line)
        if match is None:
            raise ValueError("neither a comment nor a frame")
        stamp, identifier, length, data = match.groups()
        now = None if stamp is None else self._stamp(stamp)
        if data.startswith("remote"):
            return None
        frame = _frame(now, identifier, data[: 3 * int(length)])
        if frame is not None and len(frame.data) != int(length):
            raise ValueError(f"{length} bytes announced")
        return frame

    def _stamp(self, text: str) -> float:
        if ":" in text:
            return self._date_time.read(text)
        if not _SECONDS.fullmatch(text):
            raise ValueError(f"{text} is no time")
        if not self._deltas:
            return moment(float(text))
        self._elapsed += float(text)
        return moment(self._elapsed)


def _frame(stamp: float | None, identifier: str, data: str) -> LogFrame | None:
    number = int(identifier, 16)
    if number & _ERROR or data[:1] == "R":
        return None
    payload = bytes.fromhex(data)
    if len(payload) > 8 or number >> 29:
        raise ValueError("not a classic CAN frame")
    return LogFrame(stamp, number, payload, len(identifier) == 8)


def _is_date(stamp: str) -> bool:
    return ":" in stamp or (_SECONDS.fullmatch(stamp) is not None and float(stamp) >= _A_DATE)


def _are_deltas(sample: Sequence[str]) -> bool:
    """Times that go back within the first day can only count from the line before."""
    printed = map(_PRINTED.fullmatch, (line for line in sample if "[" in line))
    stamps = [match[1] for match in printed if match and match[1] and ":" not in match[1]]
    times = [float(stamp) for stamp in stamps if _SECONDS.fullmatch(stamp)]
    return max(times, default=0.0) < _A_DAY and any(later < earlier for earlier, later in pairwise(times))
