"""Recordings made of blocks that say how long they are."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from struct import error as struct_error
from typing import ClassVar

from timonel.recording.lines import LogFrame, Unreadable
from timonel.recording.strays import Strays, unreadable_bytes

Results = Iterator[LogFrame | Unreadable]


class Blocks(ABC):
    """Cuts a stream into blocks, however it comes, from the byte `before` on.

    Where no block can begin, the rest of the recording is lost, unless `_resume` finds where to go on.
    """

    HEAD: ClassVar[int]
    """Bytes of a block in which its size is told."""
    PADDING: ClassVar[bytes] = b""
    """Bytes that may stand between blocks."""

    def __init__(self, before: int = 0) -> None:
        self._before = before
        self._rest = b""
        self._at = 0
        self._lost = False
        self._strays = Strays()

    def receive(self, data: bytes) -> Results:
        """What `data`, the next of the stream, completes."""
        data = self._rest + data
        at = min(self._before, len(data))
        self._before -= at
        while len(data) - at >= self.HEAD and not self._lost:
            size = self._size(data, at)
            if size < self.HEAD:
                at = self._skip(data, at)
                continue
            if len(data) - at < size:
                break
            if not self._is_empty(data, at):
                yield from self._strays.told()
                yield from self._read(data[at : at + size], self._at + at)
            at += size
        self._rest = b"" if self._lost else data[at:]
        self._at += at

    def finish(self) -> Results:
        """What is left at the end."""
        yield from self._strays.told()
        if self._rest.strip(self.PADDING):
            yield unreadable_bytes(self._at, self._rest, "cut off")

    def _skip(self, data: bytes, at: int) -> int:
        place = self._resume(data, at + 1)
        if data[at:place].strip(self.PADDING):
            self._strays.add(self._at + at, data[at:place])
        return place

    def _resume(self, data: bytes, start: int) -> int:
        """Where in `data`, from `start` on, a block may begin."""
        self._lost = True
        return len(data)

    def _read(self, block: bytes, at: int) -> Results:
        try:
            yield from self._block(block, at)
        except (ValueError, struct_error) as reason:
            yield unreadable_bytes(at, block, str(reason))

    def _is_empty(self, data: bytes, at: int) -> bool:
        """Whether the block that begins at `at` has nothing that is read."""
        return False

    @abstractmethod
    def _size(self, data: bytes, at: int) -> int:
        """Bytes of the block that begins at `at`; 0 if none can."""

    @abstractmethod
    def _block(self, block: bytes, at: int) -> Results:
        """What the block at offset `at` of the recording has; ValueError if it is not well formed."""
