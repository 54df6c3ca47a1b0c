"""Recordings of a bus: what every log format gives, and telling from the content which one a file has.

    candump, candump -L, candump -t a|A|d|z     frames                  `candump.py`
    YD RAW, with and without time               frames                  `yachtdevices.py`
    canboat PLAIN and FAST, also mixed          frames, messages        `canboat.py`

Times are unix seconds. A format without a date counts from 1970-01-01, one without a zone is taken as UTC,
and a line without a time has `None`. A line that cannot be read is collected and skipped: a recording that
ends in half a line is still a recording.
"""

import os
import stat
from collections.abc import Iterator, Sequence
from io import FileIO
from pathlib import Path

import msgspec

from timonel.errors import RecordingError
from timonel.recording.canboat import Canboat
from timonel.recording.candump import Candump
from timonel.recording.lines import LineFormat, LogFrame
from timonel.recording.yachtdevices import YachtDevicesRaw

FORMATS: tuple[type[LineFormat], ...] = (Candump, YachtDevicesRaw, Canboat)
_CHUNK = 1 << 16
_LONGEST_LINE = 4096  # canboat's line of 223 bytes has some 720 characters
_KEPT = 100


class Unreadable(msgspec.Struct, frozen=True, gc=False):
    """A line that is not of the recording's format; lines count from 1."""

    line: int
    text: str
    reason: str


class LogReader:
    """A recording, line by line: iterate over it once; at its end the file is closed.

    `size` is in bytes, None for a pipe; `bytes_read` grows as it is read. Of the lines that could not be
    read, all are counted in `unreadable_count`, the first hundred kept in `unreadable`.
    """

    def __init__(self, name: str, stream: FileIO, strict: bool = False) -> None:
        self.name = name
        self.size = _size(stream)
        self.bytes_read = 0
        self.frames = 0
        self.unreadable: list[Unreadable] = []
        self.unreadable_count = 0
        self._stream = stream
        self._strict = strict
        self._head = _head(stream)
        self._format = recognise(name, self._head)
        self.format = self._format.name

    def __iter__(self) -> Iterator[LogFrame]:
        with self:
            yield from self._frames()

    def _frames(self) -> Iterator[LogFrame]:
        read = self._format.read
        for number, line in enumerate(self._lines(), 1):
            try:
                frame = read(line)
            except ValueError as reason:
                self._refuse(number, line, str(reason))
                continue
            if frame is not None:
                self.frames += 1
                yield frame

    def close(self) -> None:
        """Close the file; standard input stays open."""
        self._stream.close()

    def __enter__(self) -> "LogReader":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _lines(self) -> Iterator[str]:
        """The lines without their ends; a chunk is decoded at once, for speed."""
        rest = ""
        chunk = self._head
        while chunk:
            self.bytes_read += len(chunk)
            *lines, rest = (rest + chunk.decode("latin-1").replace("\r", "")).split("\n")
            yield from lines
            if len(rest) > _LONGEST_LINE:
                yield rest
                rest = ""
            chunk = self._stream.read(_CHUNK)
        if rest:
            yield rest

    def _refuse(self, number: int, line: str, reason: str) -> None:
        if self._strict:
            raise RecordingError(f"{self.name}, line {number}: {reason}: {line[:100]!r}")
        self.unreadable_count += 1
        if len(self.unreadable) < _KEPT:
            self.unreadable.append(Unreadable(number, line[:100], reason))


def open_log(path: str | Path, strict: bool = False) -> LogReader:
    """Open a recording; `-` is standard input.

    `strict` makes the first unreadable line a RecordingError that names file and line. Raises
    RecordingError for a file that cannot be opened or has none of the formats.
    """
    standard_input = str(path) == "-"
    try:
        # Unbuffered: what a pipe has is read at once, however little it is.
        stream = FileIO(0, closefd=False) if standard_input else FileIO(os.fspath(path))
    except OSError as error:
        raise RecordingError(f"{path}: {error.strerror}") from error
    try:
        return LogReader("standard input" if standard_input else str(path), stream, strict)
    except (OSError, RecordingError) as error:
        stream.close()
        raise RecordingError(str(error)) from error


def recognise(name: str, head: bytes) -> LineFormat:
    """The format that reads most of a recording's first lines; candump's if there is nothing to read.

    Raises RecordingError, in which `name` names the file, if none of them reads any.
    """
    lines = head.decode("latin-1").replace("\r", "").split("\n")
    sample = lines[:-1] if len(lines) > 1 and lines[-1] else lines
    readable, _, best = max((_readable(form, sample), -rank, form) for rank, form in enumerate(FORMATS))
    content = [line for line in sample if line.strip() and not line.startswith("#")]
    if content and not readable:
        raise RecordingError(f"{name}: no log format known here has lines such as {content[0][:100]!r}")
    return best(sample)


def _readable(form: type[LineFormat], sample: Sequence[str]) -> int:
    lines = form(sample)
    return sum(_reads(lines, line) for line in sample[:200])


def _reads(lines: LineFormat, line: str) -> bool:
    try:
        return lines.read(line) is not None
    except ValueError:
        return False


def _size(stream: FileIO) -> int | None:
    status = os.fstat(stream.fileno())
    return status.st_size if stat.S_ISREG(status.st_mode) else None


def _head(stream: FileIO) -> bytes:
    """The first of the recording, enough to tell its format by."""
    head = b""
    while b"\n" not in head and len(head) < _LONGEST_LINE:
        more = stream.read(_CHUNK)
        if not more:
            break
        head += more
    return head
