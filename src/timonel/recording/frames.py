"""Frames by the million: SocketCAN's 16 bytes a frame in one array, and a time beside each. Needs the extra `columns`.

    identifier  uint32    bit 31 is set in an extended identifier (29 bits), clear in a standard one (11 bits)
    length      uint8     bytes of data
    flags       uint8     bit 0: a whole message, which its recorder had put together, or a frame that is longer than 8
    data        uint8[8]  zeros behind the data; of a message longer than 8 bytes, where in `spill` it begins

Source: Linux `struct can_frame`, whose padding holds the flags.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from timonel.recording.lines import LogFrame

FRAME = np.dtype([("identifier", "<u4"), ("length", "u1"), ("flags", "u1"), ("", "V2"), ("data", "u1", (8,))])
SIXTEEN = np.dtype("<c16")
"""Any type of as many bytes as a row, which NumPy moves in one piece."""
EXTENDED = 0x80000000
WHOLE = 1
NO_STAMP = -(1 << 63)
"""The stamp of a frame whose recording has no time for it."""
CHUNK = 1 << 18
"""Frames in a chunk: few enough to stay in bounded memory, enough that what is done once a chunk costs nothing."""

_FARTHEST = 9.2e9  # s: what int64 nanoseconds hold

Rows = npt.NDArray[np.void]
Stamps = npt.NDArray[np.int64]
Bytes = npt.NDArray[np.uint8]
Identifiers = npt.NDArray[np.uint32]
NO_BYTES: Bytes = np.empty(0, np.uint8)
_MASKS = np.array([(1 << 8 * length) - 1 for length in range(9)], np.uint64)


class Frames(msgspec.Struct, frozen=True, eq=False, gc=False):
    """`rows` FRAME[n] and `stamp` int64[n], unix ns; `spill` uint8 has the messages that are longer than a frame."""

    rows: Rows
    stamp: Stamps
    spill: Bytes = NO_BYTES

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, which: slice | npt.NDArray[Any]) -> "Frames":
        return Frames(self.rows[which], self.stamp[which], self.spill)

    @property
    def identifier(self) -> Identifiers:
        return self.rows["identifier"]

    @property
    def length(self) -> npt.NDArray[np.uint8]:
        return self.rows["length"]

    @property
    def data(self) -> Bytes:
        """uint8[n, 8]; of a message longer than that, its place in `spill`."""
        return self.rows["data"]

    @property
    def whole(self) -> npt.NDArray[np.bool_]:
        whole: npt.NDArray[np.bool_] = self.rows["flags"] & WHOLE != 0
        return whole

    def payload(self, row: int) -> bytes:
        """The data of one frame or message."""
        length, data = int(self.length[row]), bytes(self.data[row])
        if length <= 8:
            return data[:length]
        start = int.from_bytes(data, "little")
        return bytes(self.spill[start : start + length])

    def logframes(self) -> Iterator[LogFrame]:
        """One by one, as the readers of lines give them."""
        fields = ("identifier", "flags")
        identifiers, flags = (self.rows[field].tolist() for field in fields)
        for row, (identifier, flag, stamp) in enumerate(zip(identifiers, flags, self.stamp.tolist(), strict=True)):
            time = None if stamp == NO_STAMP else stamp / 1e9
            extended = identifier >= EXTENDED
            yield LogFrame(time, identifier & 0x1FFFFFFF, self.payload(row), extended, flag & WHOLE != 0)


def empty(size: int) -> Frames:
    """Room for `size` frames, not filled in."""
    return Frames(np.empty(size, FRAME), np.empty(size, np.int64))


class Gatherer:
    """Chunks of about `size` frames, put together of pieces of any size; `chunks` are those that are full."""

    def __init__(self, size: int = CHUNK) -> None:
        self._size = size
        self._room = empty(0)
        self._filled = 0
        self._spill: list[Bytes] = []
        self._spilled = 0
        self._chunks: list[Frames] = []

    def room(self, least: int = 1) -> Frames:
        """Where the next frames go, `least` of them at least; of those that are filled in, `took` is told."""
        if len(self._room) - self._filled < least:
            self._end_chunk()
            self._room = empty(max(self._size, least))
        return self._room[self._filled :]

    def took(self, count: int) -> None:
        """The first `count` frames of the room are filled in."""
        self._filled += count

    def put(self, frames: Frames) -> None:
        """The next frames are these."""
        count = len(frames)
        room = self.room(count)
        # As NumPy's records rows are copied field by field, which takes six times as long.
        room.rows[:count].view(SIXTEEN)[:] = frames.rows.view(SIXTEEN)
        room.stamp[:count] = frames.stamp
        if len(frames.spill):
            room.rows["data"][:count].view("<u8")[frames.length > 8] += np.uint64(self._spilled)
            self._spill.append(frames.spill)
            self._spilled += len(frames.spill)
        self.took(count)

    def chunks(self) -> list[Frames]:
        """Those that are full, and were not given yet."""
        chunks, self._chunks = self._chunks, []
        return chunks

    def finish(self) -> list[Frames]:
        """All that is left."""
        self._end_chunk()
        return self.chunks()

    def _end_chunk(self) -> None:
        if self._filled:
            spill = np.concatenate(self._spill) if self._spill else NO_BYTES
            self._chunks.append(Frames(self._room.rows[: self._filled], self._room.stamp[: self._filled], spill))
        self._room, self._filled = empty(0), 0
        self._spill, self._spilled = [], 0


def fill(rows: Rows, identifier: Identifiers, length: Bytes, data: npt.NDArray[np.uint64]) -> None:
    """Make `rows` of frames of at most eight bytes, with `data` as a number, the first byte lowest."""
    words = rows.view("<u8").reshape(-1, 2)
    words[:, 0] = length.astype(np.uint64) << 32 | identifier
    np.bitwise_and(data, _MASKS.take(length), out=words[:, 1])


def from_logframes(frames: Sequence[LogFrame]) -> Frames:
    """The frames in an array. Stamps are rounded to the microsecond: a float of unix seconds has no more."""
    rows = np.zeros(len(frames), FRAME)
    rows["identifier"] = [frame.identifier | EXTENDED if frame.extended else frame.identifier for frame in frames]
    rows["length"] = [len(frame.data) for frame in frames]
    rows["flags"] = [WHOLE if frame.whole or len(frame.data) > 8 else 0 for frame in frames]
    spill = bytearray()
    cells = []
    for frame in frames:
        if len(frame.data) > 8:
            cells.append(len(spill).to_bytes(8, "little"))
            spill += frame.data
        else:
            cells.append(frame.data.ljust(8, b"\0"))
    rows["data"] = np.frombuffer(b"".join(cells), np.uint8).reshape(-1, 8)
    stamp = np.array([nanoseconds(frame.stamp) for frame in frames], np.int64)
    return Frames(rows, stamp, np.frombuffer(bytes(spill), np.uint8))


def nanoseconds(stamp: float | None) -> int:
    """Unix seconds as whole microseconds, in ns; NO_STAMP for None and for what int64 does not hold."""
    if stamp is None or not abs(stamp) < _FARTHEST:
        return NO_STAMP
    return round(stamp * 1e6) * 1000


def concatenate(parts: Iterable[Frames]) -> Frames:
    """All of them, in order."""
    parts = list(parts)
    gathered = Gatherer(sum(map(len, parts)))
    for part in parts:
        gathered.put(part)
    return next(iter(gathered.finish()), empty(0))
