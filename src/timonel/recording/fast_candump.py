"""`candump -L` text to frames, millions of lines a second. Needs the extra `columns`.

Where as many lines as are read at a time have the length of the first, they are not even searched for. Lines that are
not of the shape of most (`candump_words`) are left to the reader of single lines, in their turn: what comes out, and
what is refused, is the same as if that one read them all.
"""

import re
from collections.abc import Iterable, Iterator
from struct import Struct
from typing import Protocol

import numpy as np

from timonel import native
from timonel.recording.candump_words import BLOCK, ROW, SHAPE, Lines, Parser, Shape, any_lines, equal_lines
from timonel.recording.frames import CHUNK, EXTENDED, FRAME, Bytes, Frames, Rows, Stamps, empty, nanoseconds
from timonel.recording.lines import LogFrame

LONGEST_LINE = 4096
"""Of more bytes without an end, the beginning is taken for a line of its own."""

_ROW = Struct("<IBB2x8s")
_PADDING = bytes(ROW)


class SingleLines(Protocol):
    """Reads lines that are not of the shape of most."""

    def __call__(self, before: int, text: bytes, last: bool) -> Iterable[LogFrame]:
        """The frames of `text`, behind which the recording ends if it is the `last`; lines `before` it are known."""


class CandumpText:
    """Text in, frames out, in chunks of about `size`."""

    def __init__(self, others: SingleLines, size: int = CHUNK) -> None:
        self._others = others
        self._size = size
        self._parser = Parser()
        self._line = 0
        self._parts: list[bytes] = []
        self._waiting = 0
        self._enough = BLOCK * ROW if native.kernels is None else ROW
        self._room = empty(size + BLOCK)
        self._filled = 0

    def receive(self, data: bytes) -> Iterator[Frames]:
        """The chunks that `data`, the next of the text, completes."""
        self._parts.append(data)
        self._waiting += len(data)
        if self._waiting >= self._enough:
            yield from self._read(self._enough)

    def finish(self) -> Iterator[Frames]:
        """What is left at the end of the text."""
        yield from self._read(0)
        if self._waiting:
            self._single(self._parts[0], 1, last=True)
        if self._filled:
            yield self._chunk()

    def _read(self, enough: int) -> Iterator[Frames]:
        """Read the whole lines of what is waiting, as long as these are `enough` bytes: whole blocks are quickest."""
        lines = b"".join((*self._parts, _PADDING))
        behind = len(lines) - ROW
        end = lines.rfind(b"\n", 0, behind) + 1
        too_long = behind - end > LONGEST_LINE
        text = np.frombuffer(lines, np.uint8)
        at = 0
        while at < end and (too_long or end - at >= enough):
            if native.kernels is not None and (behind_all := self._compiled(lines, at, end)) > at:
                at = behind_all
            else:
                first = SHAPE.match(lines, at)
                at += self._some(first, text[at:], end - at) if first else self._irregular(lines, at, end)
            if self._filled >= self._size:
                yield self._chunk()
        if too_long:
            self._single(lines[end : end + LONGEST_LINE] + b"\n", 1)
            at = behind
        self._parts, self._waiting = [lines[at:behind]], behind - at

    def _compiled(self, lines: bytes, at: int, end: int) -> int:
        """Read lines from `at` on, up to the first that is not of a shape; where that begins."""
        filled, at = native.kernels.candump_lines(lines, at, end, self._room.rows, self._room.stamp, self._filled)
        self._line += filled - self._filled
        self._filled = filled
        return at

    def _some(self, first: re.Match[bytes], text: Bytes, end: int) -> int:
        """Read some lines of `text[:end]`, whose first is of a shape; how many bytes they have."""
        shape = Shape(first[1], len(first[2]))
        self._enough = BLOCK * (first.end() - first.start())
        alike = equal_lines(text, end, first.end() - first.start())
        if alike.count == min(BLOCK, end // alike.stride):
            return self._equal(alike, shape)
        return self._any(text, min(end, BLOCK * alike.stride), shape)

    def _equal(self, lines: Lines, shape: Shape) -> int:
        """Up to the first that is not of the shape, for behind it they may begin elsewhere."""
        other = self._parser.parse(lines, shape, *self._next(lines.count))
        count = lines.count if other is None else int(other.argmax())
        self._filled += count
        self._line += count
        return count * lines.stride

    def _any(self, text: Bytes, end: int, shape: Shape) -> int:
        lines, starts, ends = any_lines(text, end)
        rows, stamps = self._next(lines.count)
        other = self._parser.parse(lines, shape, rows, stamps)
        count = lines.count
        if other is not None:
            for place in np.flatnonzero(other).tolist():
                line = text[starts[place] : ends[place] + 1].tobytes()
                for frame in self._others(self._line + place, line, False):
                    self._put(frame, self._filled + place)
                    other[place] = False
            kept = np.flatnonzero(~other)
            count = len(kept)
            rows[:count], stamps[:count] = rows[kept], stamps[kept]
        self._filled += count
        self._line += lines.count
        return int(ends[-1]) + 1

    def _irregular(self, lines: bytes, at: int, end: int) -> int:
        """Read the lines from `at` to the next that is of a shape, at most a block; how many bytes they have."""
        behind, count = at, 0
        while behind < end and count < BLOCK and not SHAPE.match(lines, behind):
            behind = lines.index(b"\n", behind) + 1
            count += 1
        self._single(lines[at:behind], count)
        return behind - at

    def _single(self, text: bytes, count: int, last: bool = False) -> None:
        for frame in self._others(self._line, text, last):
            self._put(frame, self._filled)
            self._filled += 1
        self._line += count

    def _put(self, frame: LogFrame, row: int) -> None:
        identifier = frame.identifier | EXTENDED if frame.extended else frame.identifier
        packed = _ROW.pack(identifier, len(frame.data), 0, frame.data)
        self._room.rows[row : row + 1] = np.frombuffer(packed, FRAME)
        self._room.stamp[row] = nanoseconds(frame.stamp)

    def _next(self, count: int) -> tuple[Rows, Stamps]:
        where = slice(self._filled, self._filled + count)
        return self._room.rows[where], self._room.stamp[where]

    def _chunk(self) -> Frames:
        chunk, self._room, self._filled = self._room[: self._filled], empty(self._size + BLOCK), 0
        return chunk
