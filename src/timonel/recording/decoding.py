"""A recording from file to messages, and a summary of it. Needs the extra `columns`.

A pass over a recording holds one chunk at a time, however long the recording is.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path

import msgspec

from timonel.recording.assembly import Assembly, Group
from timonel.recording.chunks import FrameReader, open_frames
from timonel.recording.formats import LogReader
from timonel.recording.frames import Frames, from_logframes
from timonel.recording.lines import LogFrame, Record, Unreadable
from timonel.recording.summary import Summariser, Summary
from timonel.recording.tables import Selected, keep_memory
from timonel.recording.wanted import Wanted
from timonel.vehicles.rover.protocol import Protocol

EVERYTHING = Wanted()

CHUNK = 131_072
"""Frames at a time: with these, and what is made of them, a program stays below 200 MiB."""

FIRST = 1 << 10
"""Frames of the first chunk, so that something comes out at once."""


class Chunk(msgspec.Struct, frozen=True, eq=False):
    """The messages that `frames` frames complete; the first one is number `first` of the recording.

    `selected` has the variants of PGNs that have several.
    """

    groups: list[Group]
    first: int
    frames: int
    selected: Selected


class Pass:
    """A recording from beginning to end: iterate over its chunks, then `summary` is complete.

    Only the messages that are `wanted` are looked at. Raises RecordingError for a file that cannot be read, and in it,
    if `strict`, at the first thing that cannot. Standard input is read as it comes: nothing waits for what follows.
    """

    def __init__(
        self,
        path: str | Path,
        protocol: Protocol | None = None,
        wanted: Wanted = EVERYTHING,
        strict: bool = False,
    ) -> None:
        keep_memory()
        reader = open_frames(path, strict, CHUNK)
        self.log = reader.log
        self._frames = _as_they_come(self.log) if str(path) == "-" else _first_some(reader)
        self._assembly = Assembly(wanted.pgns, wanted.standard)
        self._summariser = Summariser(self.log.name, protocol or Protocol())

    def __iter__(self) -> Iterator[Chunk]:
        return self._chunks() if self.log.size is None else _ahead(self._chunks())

    def _chunks(self) -> Iterator[Chunk]:
        for frames in self._frames:
            first = self._assembly.frames
            groups = self._assembly.receive(frames)
            selected = self._summariser.receive(groups)
            yield Chunk(groups, first, len(frames), selected)

    @property
    def summary(self) -> Summary:
        """What was read so far."""
        return self._summariser.finish(self.log, self._assembly)

    def day(self, date: int | None) -> int | None:
        """ns at which the recording's times begin: 0 if they have dates, else that of `date`, None without one."""
        return 0 if self.log.dated else date


def _ahead(chunks: Iterator[Chunk]) -> Iterator[Chunk]:
    """The next chunk is made while the one before is written."""
    for first in chunks:
        yield first
        break
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(1) as thread:
        coming = thread.submit(next, chunks, None)
        while (chunk := coming.result()) is not None:
            coming = thread.submit(next, chunks, None)
            yield chunk


def _first_some(reader: FrameReader) -> Iterator[Frames]:
    chunks = iter(reader)
    for frames in chunks:
        yield frames[:FIRST]
        yield frames[FIRST:]
        break
    yield from chunks


def _as_they_come(log: LogReader) -> Iterator[Frames]:
    with log:
        for portion in log.portions():
            yield from _frames(log, log.stream.receive(portion))
        yield from _frames(log, log.stream.finish())
        yield from _frames(log, log.damage())


def _frames(log: LogReader, records: Iterable[Record | Unreadable]) -> Iterator[Frames]:
    found = []
    for record in records:
        if isinstance(record, Unreadable):
            log.refuse(record)
        elif isinstance(record, LogFrame):
            found.append(record)
    log.frames += len(found)
    if found:
        yield from_logframes(found)
