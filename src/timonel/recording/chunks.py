"""Any recording of a bus as arrays of frames, in chunks: whatever its size, it takes little memory.

```python
for frames in open_frames("log.candump.gz"):
    frames.identifier, frames.data, frames.stamp
```
candump's logs, captures and our own recordings are read thousands of frames at a time, all other formats one by one.
What comes out, and what is refused, is the same either way. Needs the extra `columns`.
"""

from collections.abc import Callable, Iterable, Iterator
from itertools import chain, islice
from pathlib import Path
from typing import cast

from timonel.recording.fast_candump import CandumpText
from timonel.recording.fast_mcap import FastMcap
from timonel.recording.fast_pcap import FastPcap
from timonel.recording.formats import Lines, LogReader, open_log
from timonel.recording.frames import CHUNK, Frames, concatenate, from_logframes
from timonel.recording.lines import LogFrame, Record, Unreadable

PORTION = 1 << 20
"""Bytes at a time: enough that what is done once a portion costs nothing."""


class FrameReader:
    """The frames of a recording in chunks of about `size`: iterate over it once; at its end the file is closed.

    `log` tells the recording's name, format and size, whether it has times and dates, how many frames were read, and
    what could not be.
    """

    def __init__(self, log: LogReader, size: int = CHUNK) -> None:
        self.log = log
        self._size = size

    def __iter__(self) -> Iterator[Frames]:
        read = FAST.get(self.log.format)
        if read is None:
            yield from _one_by_one(self.log, self._size)
            return
        with self.log:
            for chunk in read(self.log, self._size):
                self.log.frames += len(chunk)
                yield chunk


def open_frames(path: str | Path, strict: bool = False, size: int = CHUNK) -> FrameReader:
    """Open a recording of frames; `-` is standard input. `strict` and the errors are those of `open_log`."""
    return FrameReader(open_log(path, strict), size)


def _one_by_one(log: LogReader, size: int) -> Iterator[Frames]:
    frames = iter(log)
    while some := list(islice(frames, size)):
        yield from_logframes(some)


def _candump(log: LogReader, size: int) -> Iterator[Frames]:
    lines = cast(Lines, log.stream)

    def others(before: int, text: bytes, last: bool) -> Iterator[LogFrame]:
        lines.number = before
        yield from _accepted(log, lines.receive(text))
        if last:
            yield from _accepted(log, lines.finish())

    text = CandumpText(others, size)
    for portion in log.portions():
        yield from text.receive(portion)
    yield from text.finish()
    for found in log.damage():
        log.refuse(found)


def _accepted(log: LogReader, records: Iterable[Record | Unreadable]) -> Iterator[LogFrame]:
    for found in records:
        if isinstance(found, Unreadable):
            log.refuse(found)
        elif isinstance(found, LogFrame):
            yield found


def _pcap(log: LogReader, size: int) -> Iterator[Frames]:
    portions = _portions(log)
    first = next(portions)
    capture = FastPcap(first)
    found = chain.from_iterable(map(capture.receive, chain((first,), portions)))
    return _gathered(log, size, chain(found, capture.finish()))


def _mcap(log: LogReader, size: int) -> Iterator[Frames]:
    portions = _portions(log)
    first = next(portions)
    return _gathered(log, size, _taken(FastMcap(first), chain((first,), portions)))


def _taken(recording: FastMcap, portions: Iterable[bytes]) -> Iterator[Frames | LogFrame | Unreadable]:
    for portion in portions:
        for found in recording.receive(portion):
            yield from recording.taken()  # what stands before it
            yield found
        yield from recording.taken()
    yield from recording.finish()


def _gathered(log: LogReader, size: int, found: Iterable[Frames | LogFrame | Unreadable]) -> Iterator[Frames]:
    """Chunks of what comes in pieces of any size."""
    parts: list[Frames] = []
    count = 0
    for piece in chain(found, _damage(log)):
        if isinstance(piece, Unreadable):
            log.refuse(piece)
            continue
        part = from_logframes([piece]) if isinstance(piece, LogFrame) else piece
        parts.append(part)
        count += len(part)
        if count >= size:
            yield concatenate(parts)
            parts, count = [], 0
    if count:
        yield concatenate(parts)


def _damage(log: LogReader) -> Iterator[Unreadable]:
    yield from log.damage()


def _portions(log: LogReader) -> Iterator[bytes]:
    """The recording's bytes, a megabyte or so at a time."""
    parts: list[bytes] = []
    size = 0
    for part in log.portions():
        parts.append(part)
        size += len(part)
        if size >= PORTION:
            yield b"".join(parts)
            parts, size = [], 0
    yield b"".join(parts)


FAST: dict[str, Callable[[LogReader, int], Iterator[Frames]]] = {
    "candump": _candump,
    "pcap": _pcap,
    "MCAP": _mcap,
}
"""The formats that are read many frames at a time."""
