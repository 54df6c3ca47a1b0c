"""Any recording of a bus as arrays of frames, in chunks: whatever its size, it takes little memory.

```python
for frames in open_frames("log.candump.gz"):
    frames.identifier, frames.data, frames.stamp
```
candump's logs, captures and our own recordings are read thousands of frames at a time, all other formats one by one.
What comes out, and what is refused, is the same either way. Needs the extra `columns`.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import chain, islice
from pathlib import Path
from typing import cast

from timonel import native
from timonel.recording.blocks import Blocks
from timonel.recording.fast_candump import CandumpText
from timonel.recording.fast_mcap import FastMcap
from timonel.recording.fast_pcap import FastPcap
from timonel.recording.formats import Lines, LogReader, open_log
from timonel.recording.frames import CHUNK, Frames, Gatherer, from_logframes
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
    gathered = Gatherer(size)
    return _gathered(log, partial(FastPcap, gathered=gathered), gathered)


def _mcap(log: LogReader, size: int) -> Iterator[Frames]:
    gathered = Gatherer(size)
    return _gathered(log, partial(FastMcap, gathered=gathered), gathered)


def _gathered(log: LogReader, reader: Callable[[bytes], Blocks], gathered: Gatherer) -> Iterator[Frames]:
    """The chunks that a reader gathers; what it cannot, it gives one by one."""
    portions = _portions(log)
    first = next(portions)
    capture = reader(first)
    for portion in chain((first,), portions):
        _take(log, capture.receive(portion), gathered)
        yield from gathered.chunks()
    _take(log, chain(capture.finish(), log.damage()), gathered)
    yield from gathered.finish()


def _take(log: LogReader, found: Iterable[LogFrame | Unreadable], gathered: Gatherer) -> None:
    for frame in _accepted(log, found):
        gathered.put(from_logframes([frame]))


def _portions(log: LogReader) -> Iterator[bytes]:
    """The recording's bytes: without kernels a megabyte or so at a time, for what is done once a portion is much."""
    if native.kernels is not None:
        yield from log.portions()
        return
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
