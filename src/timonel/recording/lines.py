"""What the readers of every log format share: the records they give, what they refuse, and the times they read."""

from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from typing import Literal, Protocol

import msgspec

from timonel.core.frame import Frame

_A_DAY = 86400.0
_LATEST = 1 << 33  # s, in the year 2242: a stamp beyond is none


class LogFrame(msgspec.Struct, frozen=True, gc=False):
    """One line of a recording: a frame, or a message that its recorder had already put together (`whole`).

    `stamp` is in unix seconds, None if the line has none. `data` of a whole message may be longer than eight
    bytes and must not go through fast-packet reassembly; a message of a single-frame PGN is not marked.
    """

    stamp: float | None
    identifier: int
    data: bytes
    extended: bool = True
    whole: bool = False

    @property
    def frame(self) -> Frame:
        """The CAN frame; only for what is not `whole`."""
        return Frame(self.identifier, self.data, self.extended)


class LogSentence(msgspec.Struct, frozen=True, gc=False):
    """One NMEA 0183 sentence of a log, from its `$` or `!` to its check sum, which is right.

    `stamp` is when it was logged, in unix seconds, None if its line does not tell.
    """

    stamp: float | None
    line: bytes


Record = LogFrame | LogSentence

Kind = Literal["frames", "sentences", "uart"]
"""What a recording has: frames of a CAN bus, NMEA 0183 sentences, or frames of a rover's serial line."""


class Unreadable(msgspec.Struct, frozen=True, gc=False):
    """What is not of the recording's format: a line, counted from 1, or bytes at an offset (`line` is None).

    `offset` counts from the beginning of the recording, decompressed; of a line it is None.
    """

    line: int | None
    text: str
    reason: str
    offset: int | None = None

    @property
    def place(self) -> str:
        """Where it is, for people."""
        return f"byte {self.offset}" if self.line is None else f"line {self.line}"


class LineFormat(Protocol):
    """How the lines of one format are read; the first lines settle what a single one leaves open.

    `dated` is whether the stamps are of a calendar; where they are not, they count from 1970-01-01 all the same.
    """

    name: str
    kind: Kind

    def __init__(self, sample: Sequence[str]) -> None: ...

    @property
    def dated(self) -> bool: ...

    def read(self, line: str) -> Record | None:
        """The record of a line, None if it has none (a comment); ValueError if it is no such line."""


class Stream(Protocol):
    """A recording that is read in portions, however they come; `dated` as in `LineFormat`.

    Nothing raises: what cannot be read is among the results.
    """

    name: str
    kind: Kind

    @property
    def dated(self) -> bool: ...

    def receive(self, data: bytes) -> Iterable[Record | Unreadable]:
        """What `data`, the next of the recording, completes."""

    def finish(self) -> Iterable[Record | Unreadable]:
        """What is left at the end of the recording."""


class StreamFormat(Stream, Protocol):
    """A format that is read so; the first bytes settle how."""

    @staticmethod
    def recognises(head: bytes) -> bool:
        """Whether a recording that begins with `head` is of this format."""

    def __init__(self, head: bytes) -> None:
        """ValueError if it is of this format, but cannot be read all the same."""


class DateTime:
    """Reads ISO 8601 dates with times, also with a space or a dash between, and without a zone (UTC)."""

    def __init__(self) -> None:
        self._text = ""
        self._second = 0.0

    # Once a line, and most lines are of the same second as the one before.
    def read(self, text: str) -> float:
        """Unix seconds; ValueError for anything else."""
        fraction = text[19:].removesuffix("Z")
        if fraction and not (fraction[0] == "." and fraction[1:].isdigit()):
            return _utc(text)
        if text[:19] != self._text:
            self._second = _utc(text[:19])
            self._text = text[:19]
        return self._second + float(fraction) if fraction else self._second


def _utc(text: str) -> float:
    moment = datetime.fromisoformat(text)
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def is_comment(line: str) -> bool:
    return not line or line[0] == "#" or line.isspace()


def moment(seconds: float) -> float:
    """`seconds` as a stamp; ValueError for what can be none."""
    if not 0 <= seconds < _LATEST:
        raise ValueError(f"{seconds} s is no time of a recording")
    return seconds


class TimeOfDay:
    """Times of a day without a date: they count from 1970-01-01, and past midnight go on."""

    def __init__(self) -> None:
        self._midnight = 0.0
        self._last = 0.0

    def read(self, hours: str, minutes: str, seconds: str) -> float:
        """Seconds; ValueError for what no clock shows."""
        time_of_day = int(hours) * 3600 + int(minutes) * 60 + float(seconds)
        if time_of_day >= _A_DAY + 1 or int(minutes) > 59:  # a day may end in a leap second
            raise ValueError(f"{hours}:{minutes}:{seconds} is no time of day")
        if time_of_day < self._last - _A_DAY / 2:
            self._midnight += _A_DAY
        self._last = time_of_day
        return self._midnight + time_of_day
