"""Recordings: what every log format gives, and telling from the content which one a file has.

`docs/formats.md` lists the formats and what each carries. Times are unix seconds. A format without a date counts
from 1970-01-01 (`dated` tells), one without a zone is taken as UTC, and what has no time has `None` (`timed`
tells). What cannot be read is collected and skipped: a recording that is torn is still a recording.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from io import FileIO
from itertools import islice
from pathlib import Path
from typing import Generic, TypeAlias, TypeVar, cast

from timonel.errors import RecordingError
from timonel.recording.actisense import Ebl, Ngt1
from timonel.recording.actisense_ascii import ActisenseAscii
from timonel.recording.blf import Blf
from timonel.recording.canboat import Canboat
from timonel.recording.candump import Candump
from timonel.recording.garmin import GarminCsv
from timonel.recording.ikonvert import IKonvert
from timonel.recording.lines import Kind, LineFormat, LogFrame, Record, Stream, StreamFormat, Unreadable, is_comment
from timonel.recording.mcap import Mcap
from timonel.recording.nmea0183 import Nmea0183
from timonel.recording.pcap import Pcap, PcapNg
from timonel.recording.peak_trc import PeakTrc
from timonel.recording.source import Source
from timonel.recording.strays import unreadable_bytes
from timonel.recording.vector_asc import VectorAsc
from timonel.recording.yachtdevices import YachtDevicesRaw

FORMATS: tuple[type[LineFormat], ...] = (
    Candump,
    YachtDevicesRaw,
    Canboat,
    ActisenseAscii,
    IKonvert,
    GarminCsv,
    VectorAsc,
    PeakTrc,
    Nmea0183,
)
"""Formats of lines; of those that read as many lines, the first is taken."""

STREAMS: tuple[type[StreamFormat], ...] = (Pcap, PcapNg, Blf, Mcap, Ebl, Ngt1)
"""Binary formats, known by how they begin or by their check sums. The rover's serial line is tried last of all."""

_LONGEST_LINE = 4096  # canboat's line of 223 bytes has some 720 characters
_SAMPLE = 200  # lines, or records
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
_KEPT = 100
_MORE = ("0", "1", "00", " 00", "AAAA")
"""How the data at the end of a line can go on, in one format or another."""

R = TypeVar("R", bound=Record)
Opener = Callable[[], Stream]


class Reader(Generic[R]):
    """A recording, record by record: iterate over it once; at its end the file is closed.

    `kind` is what it has, `format` the name of its format; `timed` is whether there are times, and `dated` whether
    they have a date, as far as the beginning shows. `frames` counts the records. Of what could not be read, all is
    counted in `unreadable_count`, the first hundred kept in `unreadable`.
    """

    def __init__(self, name: str, stream: FileIO, strict: bool = False) -> None:
        self.name = name
        self.frames = 0
        self.unreadable: list[Unreadable] = []
        self.unreadable_count = 0
        self._strict = strict
        self._received = 0
        self._source = Source(stream)
        self._head = _head(self._source)
        open_format = recognise(self._head)
        self._format = open_format()
        self.format = self._format.name
        self.kind: Kind = self._format.kind
        self.timed, self.dated = _times(open_format(), self._head)

    @property
    def size(self) -> int | None:
        """Bytes of the file, None for a pipe."""
        return self._source.size

    @property
    def bytes_read(self) -> int:
        """Bytes of the file that have been read."""
        return self._source.position

    def __iter__(self) -> Iterator[R]:
        with self:
            for found in self._found():
                if type(found) is Unreadable:
                    self.refuse(found)
                else:
                    self.frames += 1
                    yield cast(R, found)

    def close(self) -> None:
        """Close the file; standard input stays open."""
        self._source.close()

    def __enter__(self) -> "Reader[R]":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def stream(self) -> Stream:
        """What reads its format."""
        return self._format

    def portions(self) -> Iterator[bytes]:
        """Its bytes, decompressed, as they come: for who does not iterate over the records."""
        chunk = self._head
        while chunk:
            self._received += len(chunk)
            yield chunk
            chunk = self._source.read()

    def damage(self) -> list[Unreadable]:
        """What is told of a compressed file that ended too soon, behind everything else."""
        fault = self._source.fault
        return [unreadable_bytes(self._received, b"", f"the compressed file is {fault}")] if fault else []

    def _found(self) -> Iterator[Record | Unreadable]:
        for chunk in self.portions():
            yield from self._format.receive(chunk)
        yield from self._format.finish()
        yield from self.damage()

    def refuse(self, found: Unreadable) -> None:
        """Count what could not be read; RecordingError if the reader is strict."""
        if self._strict:
            raise RecordingError(f"{self.name}, {found.place}: {found.reason}: {found.text!r}")
        self.unreadable_count += 1
        if len(self.unreadable) < _KEPT:
            self.unreadable.append(found)


LogReader: TypeAlias = Reader[LogFrame]


def open_log(path: str | Path, strict: bool = False) -> LogReader:
    """Open a recording of a bus, or of a rover's serial line; `-` is standard input.

    `strict` makes the first thing that cannot be read a RecordingError that names file and place. Raises
    RecordingError for a file that cannot be opened, has none of the formats, or has no frames but sentences.
    """
    reader = open_any(path, strict)
    if reader.kind == "sentences":
        reader.close()
        raise RecordingError(f"{reader.name}: sentences ({reader.format}), not frames of a bus")
    return cast(LogReader, reader)


def open_any(path: str | Path, strict: bool = False) -> Reader[Record]:
    """Open a recording of any kind, as `open_log` opens one of frames."""
    standard_input = str(path) == "-"
    name = "standard input" if standard_input else str(path)
    try:
        # Unbuffered: what a pipe has is read at once, however little it is.
        stream = FileIO(0, closefd=False) if standard_input else FileIO(os.fspath(path))
    except OSError as error:
        raise RecordingError(f"{name}: {error.strerror}") from error
    try:
        return Reader(name, stream, strict)
    except (OSError, RecordingError) as error:
        stream.close()
        raise RecordingError(f"{name}: {error}") from error


def recognise(head: bytes) -> Opener:
    """What opens the format of a recording that begins with `head`; candump's if there is nothing to read.

    Raises RecordingError if none has it.
    """
    for form in STREAMS:
        if form.recognises(head):
            return partial(_opened, form, head)
    lines = _lines(head)
    sample = lines[:_SAMPLE]
    score, best = (0, 0), FORMATS[0]
    for lines_form in FORMATS:
        found = _score(lines_form, sample)
        if found > score:
            score, best = found, lines_form
        if found[0] == len(sample):
            break  # no other one can read more
    if any(score):
        return lambda: Lines(best(lines))
    return _uart(head) or _nothing(lines)


class Lines:
    """A format of lines, read as a stream."""

    def __init__(self, form: LineFormat) -> None:
        self.name = form.name
        self.kind: Kind = form.kind
        self.number = 0
        """Lines so far."""
        self._form = form
        self._rest = ""

    @property
    def dated(self) -> bool:
        return self._form.dated

    # A chunk is decoded at once, and what stands in the loop runs once a line: both for speed.
    def receive(self, data: bytes) -> Iterator[Record | Unreadable]:
        """What stands in the lines that `data` ends."""
        *lines, self._rest = (self._rest + data.decode("latin-1").replace("\r", "")).split("\n")
        if len(self._rest) > _LONGEST_LINE:
            lines.append(self._rest[:_LONGEST_LINE])
            self._rest = ""
        read = self._form.read
        first = self.number + 1
        self.number += len(lines)
        for number, line in enumerate(lines, first):
            try:
                record = read(line)
            except ValueError as reason:
                yield Unreadable(number, line[:100], str(reason))
                continue
            if record is not None:
                yield record

    def finish(self) -> Iterator[Record | Unreadable]:
        """What stands in a last line without an end, if nothing can be missing from it."""
        last = self._rest
        for found in self.receive(b"\n") if last else ():
            doubtful = isinstance(found, LogFrame) and any(self._is_another(last + more, found) for more in _MORE)
            yield Unreadable(self.number, last[:100], "the last line may be cut off") if doubtful else found

    def _is_another(self, line: str, frame: LogFrame) -> bool:
        try:
            other = self._form.read(line)
        except ValueError:
            return False
        return isinstance(other, LogFrame) and other.data != frame.data


def _opened(form: type[StreamFormat], head: bytes) -> Stream:
    try:
        return form(head)
    except ValueError as reason:
        raise RecordingError(str(reason)) from reason


def _uart(head: bytes) -> Opener | None:
    """Only here, because it needs all frames of the rover."""
    from timonel.recording.uart import Uart

    return partial(Uart, head) if Uart.recognises(head) else None


def _nothing(lines: Sequence[str]) -> Opener:
    content = [line for line in lines if line.strip() and not line.startswith("#")]
    if content:
        raise RecordingError(f"no log format known here has lines such as {content[0][:100]!r}")
    return lambda: Lines(Candump(lines))


def _lines(head: bytes) -> list[str]:
    """The whole lines of the beginning; if there is none, the beginning of the first."""
    lines = head.decode("latin-1").replace("\r", "").split("\n")
    return lines[:-1] if len(lines) > 1 and lines[-1] else lines


def _score(form: type[LineFormat], sample: Sequence[str]) -> tuple[int, int]:
    """How many of the first lines have a record, and how many are the format's headings."""
    lines = form(sample)
    records = headings = 0
    for line in sample:
        try:
            record = lines.read(line)
        except ValueError:
            continue
        if record is not None:
            records += 1
        elif not is_comment(line):
            headings += 1
    return records, headings


def _times(form: Stream, head: bytes) -> tuple[bool, bool]:
    """Whether the first records of a recording have times, and whether these have a date."""
    records = [found for found in islice(form.receive(head), _SAMPLE) if not isinstance(found, Unreadable)]
    timed = any(record.stamp is not None for record in records) if records else form.dated
    return timed, timed and form.dated


def _head(source: Source) -> bytes:
    """The first of the recording, enough to tell its format by."""
    head = b""
    while b"\n" not in head and len(head) < _LONGEST_LINE:
        more = source.read()
        if not more:
            break
        head += more
    return head.removeprefix(_BYTE_ORDER_MARK)
