"""Our own recordings to frames, chunk by chunk instead of frame by frame. Needs the extra `columns`."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from timonel import native
from timonel.recording import flight
from timonel.recording.flight_bus import PACKED, ROWS_AT, SENT, layout
from timonel.recording.frames import Gatherer, fill
from timonel.recording.mcap import Mcap

_ROW = np.dtype(
    [("identifier", "<u4"), ("length", "u1"), ("flags", "u1"), ("", "V2"), ("data", "<u8"), ("elapsed", "<u4"),
     ("step", "<u4")]
)  # fmt: skip
_HEAD = flight.MESSAGE_HEAD
_LATEST = 1 << 62  # ns

Array = npt.NDArray[np.generic]


class _Frames(NamedTuple):
    """The frames of a message; `elapsed` in microseconds since `stamp`, ns."""

    stamp: int
    identifier: Array
    length: npt.NDArray[np.uint8]
    flags: npt.NDArray[np.uint8]
    data: Array
    elapsed: Array


class FastMcap(Mcap):
    """MCAP with a topic `bus`, whose frames are `gathered`.

    Only a message with frames of more than eight bytes gives them one by one.
    """

    def __init__(self, head: bytes, gathered: Gatherer) -> None:
        super().__init__(head)
        self._gathered = gathered
        self._bus_channel = -1
        self._read_many = self._with_kernel if native.kernels is not None else self._without

    def _note(self, content: bytes) -> None:
        super()._note(content)
        buses = [number for number, topic in self._topics.items() if topic == flight.BUS]
        self._bus_channel = buses[0] if len(buses) == 1 else -1

    def _many(self, data: bytes, place: int) -> int:
        if self._bus_channel < 0 or place == len(data):
            return place
        return self._read_many(data, place)

    def _with_kernel(self, data: bytes, place: int) -> int:
        room = self._gathered.room((len(data) - place) // PACKED.size)
        assert native.kernels is not None
        bus = self._bus_channel
        count, place = native.kernels.recorded_frames(data, place, bus, _LATEST, room.rows, room.stamp)
        self._gathered.took(count)
        return place

    def _without(self, data: bytes, place: int) -> int:
        messages: list[_Frames] = []
        while len(data) - place >= _HEAD.size:
            opcode, size, channel, _, stamp, _ = _HEAD.unpack_from(data, place)
            end = place + flight.RECORD.size + size
            if opcode != flight.MESSAGE or not place + _HEAD.size <= end <= len(data):
                break
            if channel == self._bus_channel:
                frames = _frames(data[place + _HEAD.size : end], stamp) if stamp < _LATEST else None
                if frames is None or (frames.length > 8).any() or (frames.flags > SENT).any():
                    break
                messages.append(frames)
            place = end
        self._gather(messages)
        return place

    def _gather(self, messages: list[_Frames]) -> None:
        if not messages:
            return
        stamps, identifiers, lengths, _, data, elapsed = zip(*messages, strict=True)
        count = sum(map(len, lengths))
        room = self._gathered.room(count)[:count]
        fill(room.rows, np.concatenate(identifiers), np.concatenate(lengths), np.concatenate(data))
        np.multiply(np.concatenate(elapsed), 1000, out=room.stamp, dtype=np.int64)
        room.stamp[:] += np.repeat(np.array(stamps, np.int64), [len(each) for each in lengths])
        self._gathered.took(count)


def _frames(message: bytes, stamp: int) -> _Frames | None:
    """None if the message is not made of frames."""
    found = layout(message)
    if found is None:
        return None
    count = found.frames
    if not found.columns:
        rows = np.frombuffer(message, _ROW, count, ROWS_AT)
        return _Frames(stamp, *(rows[name] for name in ("identifier", "length", "flags", "data", "elapsed")))
    identifier, data, since, _, length, flags = (
        np.frombuffer(message, kind, count, place)
        for kind, place in zip(("<u4", "<u8", "<u2", "u1", "u1", "u1"), found.columns, strict=True)
    )
    return _Frames(stamp, identifier, length, flags, data, np.cumsum(since, dtype=np.uint32))
