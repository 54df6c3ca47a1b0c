"""Frames out of a stream of bytes, whatever was lost, added or changed on the way.

A frame is `#`, an id, and as many bytes as the id fixes; how a dialect writes them, and what proves that a frame
is one, its own module says. What all have in common:

```
at a `#`                                           effect
a frame, and proved                                emitted
not a frame, or disproved                          its `#` is dropped, the search goes on from the next byte
a frame so far; the line is silent for `idle`      emitted, if it is whole and silence proves it
the same, but not whole, silent for `patience`     given up: its `#` is dropped, the search goes on
the end of the stream                              as silence, at once
```
An id that was not declared begins no frame, so a parser is given the ids of its own direction only. The meaning
of a frame never vetoes it.

A silence shorter than `patience` does not disprove a frame, because it need not be one of the line: an adapter
may keep bytes back. By default `patience` is longer than the 16 ms of the common USB adapters, and shorter than the
20 ms from one frame at 50 Hz to the next. On a direct line it can be as short as `idle`: then no frame is
ever joined across a gap.

What comes out, and what is counted, does not depend on how the stream was cut into pieces. Between calls at most
one longest frame is kept, with what the dialect allows behind it.

Source: spec/rover.md, Framing without a check sum.
"""

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

import msgspec

from timonel.errors import EncodeError


class Counters(msgspec.Struct, gc=False):
    """The quality of a link. Every byte received is in a frame, in `fill`, in `skipped`, or still waits."""

    frames: int = 0
    fill: int = 0
    """Fill bytes between frames."""
    skipped: int = 0
    """Bytes that found no place in a frame."""
    rejected: int = 0
    """Times that a `#` with a declared id was not a frame."""
    resynchronised: int = 0
    """Times that a frame was found again behind skipped bytes."""


class Framer(ABC):
    """Cuts a stream into frames (id, data).

    `lengths` are the ids to accept with their number of data bytes; an id whose data the dialect cannot carry is
    left out. `idle` and `patience` are in s. Nothing that is received raises.
    """

    __slots__ = (
        "_adrift",
        "_candidate",
        "_closed",
        "_idle",
        "_open",
        "_patience",
        "_rest",
        "counters",
        "deadline",
        "heard",
    )

    LONGEST: ClassVar[int] = 255
    """Most data bytes that a frame can carry."""
    FOLLOW: ClassVar[bytes] = b""
    """Pattern of what proves a frame, behind it."""
    SILENCE: ClassVar[bytes] = b""
    """The same where the line has fallen silent."""

    def __init__(self, lengths: Mapping[int, int], idle: float = 0.005, patience: float = 0.018) -> None:
        self.counters = Counters()
        self.deadline = math.inf
        """When `expire` is due; infinite if nothing waits."""
        self.heard = -math.inf
        """When the last byte came in, s; what waits came then at the latest."""
        self._idle = idle
        self._patience = patience
        self._rest = b""
        self._adrift = False
        ids: dict[int, bytes] = {}
        for number, length in lengths.items():
            if length <= self.LONGEST:
                ids[length] = ids.get(length, b"") + bytes((number,))
        frame = b"|".join(self._frame(self._id(each), length) for length, each in ids.items()) or b"(?!)"
        begun = b"|".join(self._begun(self._id(each), length) for length, each in ids.items()) or b"(?!)"
        self._open = re.compile(b"#(?:(%s)%s|(?:%s)?\\Z)" % (frame, self.FOLLOW, begun), re.DOTALL)
        self._closed = re.compile(b"#(%s)%s" % (frame, self.SILENCE), re.DOTALL)
        self._candidate = re.compile(b"#(?=%s)" % self._id(b"".join(ids.values())))

    @property
    def waiting(self) -> int:
        """Bytes kept because only the next ones, or silence, can tell what they are."""
        return len(self._rest)

    def receive(self, data: bytes, now: float) -> list[tuple[int, bytes]]:
        """The frames that `data` completes or proves, in order; `now` in s, never going back."""
        frames = self.expire(now)
        if data:
            self.heard = now
            frames += self._take(self._open, self._rest + data)
            self.deadline = now + self._wait() if self._rest else math.inf
        return frames

    def expire(self, now: float) -> list[tuple[int, bytes]]:
        """What silence up to `now` proves; nothing before the deadline."""
        return self.finish() if now >= self.deadline else []

    def finish(self) -> list[tuple[int, bytes]]:
        """The stream has ended: the frames in what still waits."""
        self.deadline = math.inf
        return self._take(self._closed, self._rest)

    @staticmethod
    @abstractmethod
    def write(number: int, data: bytes) -> bytes:
        """One frame as it goes out; `number` is its id. Raises EncodeError where the dialect cannot carry it."""

    @staticmethod
    @abstractmethod
    def _id(numbers: bytes) -> bytes:
        """Pattern of any of the ids `numbers`."""

    @staticmethod
    @abstractmethod
    def _frame(number: bytes, length: int) -> bytes:
        """Pattern of a frame behind its `#`."""

    @staticmethod
    @abstractmethod
    def _begun(number: bytes, length: int) -> bytes:
        """Pattern of what, behind a `#`, can still become a proved frame."""

    @staticmethod
    @abstractmethod
    def _parse(frame: bytes) -> tuple[int, bytes] | None:
        """Id and data of what `_frame` matched; None if it disproves itself."""

    def _wait(self) -> float:
        return self._idle if self._closed.match(self._rest) else self._patience

    # Once a frame, so it is written for speed: the search for the next frame and its proof are one match.
    def _take(self, pattern: re.Pattern[bytes], data: bytes) -> list[tuple[int, bytes]]:
        """The frames in `data`; from where only more bytes can decide, it is kept."""
        frames = []
        fill = place = at = 0
        end = len(data)
        while match := pattern.search(data, at):
            start = match.start()
            if match[1] is None:
                end = start
                break
            frame = self._parse(match[1])
            if frame is None:
                at = start + 1
                continue
            if start > place or self._adrift:
                self._skip(data, place, start)
                self._adrift = False
                self.counters.resynchronised += 1
            frames.append(frame)
            place = at = match.end()
            fill += place - match.end(1)
        if end > place:
            self._skip(data, place, end)
        self._rest = data[end:]
        self.counters.frames += len(frames)
        self.counters.fill += fill
        return frames

    def _skip(self, data: bytes, start: int, end: int) -> None:
        self._adrift = True
        self.counters.skipped += end - start
        candidates = self._candidate.finditer(data, start, end + 2)  # an id has up to two characters
        self.counters.rejected += sum(match.start() < end for match in candidates)


def check(number: int, data: bytes, longest: int) -> None:
    """Raises EncodeError if no frame has this id or so much data."""
    if not 0 <= number <= 255:
        raise EncodeError(f"frame {number}: ids are 0..255")
    if len(data) > longest:
        raise EncodeError(f"frame {number}: {len(data)} bytes of data are more than {longest}")
