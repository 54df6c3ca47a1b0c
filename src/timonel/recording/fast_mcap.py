"""Our own recordings to frames, chunk by chunk instead of frame by frame. Needs the extra `columns`."""

import numpy as np
import numpy.typing as npt

from timonel import native
from timonel.recording import flight
from timonel.recording.frames import Frames, empty, fill
from timonel.recording.mcap import Mcap

_ROW = np.dtype(
    [("identifier", "<u4"), ("length", "u1"), ("flags", "u1"), ("", "V2"), ("data", "<u8"), ("elapsed", "<u4"),
     ("step", "<u4")]
)  # fmt: skip
_HEAD = flight.MESSAGE_HEAD
_BEFORE_ROWS = _HEAD.size + flight.ROWS_AT
_LATEST = 1 << 62  # ns


class FastMcap(Mcap):
    """MCAP with a topic `bus`: its frames are collected, and `taken` has them.

    Only a message with frames of more than one row gives them one by one.
    """

    def __init__(self, head: bytes) -> None:
        super().__init__(head)
        self._frames: list[Frames] = []
        self._bus_channel = -1
        self._reads = self._with_kernel if native.kernels is not None else self._without

    def taken(self) -> list[Frames]:
        """The frames collected since the last time."""
        frames, self._frames = self._frames, []
        return frames

    def _note(self, content: bytes) -> None:
        super()._note(content)
        buses = [number for number, topic in self._topics.items() if topic == flight.BUS]
        self._bus_channel = buses[0] if len(buses) == 1 else -1

    def _many(self, data: bytes, place: int) -> int:
        if self._bus_channel < 0 or place == len(data):
            return place
        frames, place = self._reads(data, place)
        if len(frames):
            self._frames.append(frames)
        return place

    def _with_kernel(self, data: bytes, place: int) -> tuple[Frames, int]:
        frames = empty((len(data) - place) // _ROW.itemsize)
        assert native.kernels is not None
        bus = self._bus_channel
        count, place = native.kernels.recorded_frames(data, place, bus, _LATEST, frames.rows, frames.stamp)
        return frames[:count], place

    def _without(self, data: bytes, place: int) -> tuple[Frames, int]:
        stamps: list[int] = []
        tables: list[npt.NDArray[np.void]] = []
        while len(data) - place >= _HEAD.size:
            opcode, size, channel, _, stamp, _ = _HEAD.unpack_from(data, place)
            end = place + flight.RECORD.size + size
            if opcode != flight.MESSAGE or not place + _HEAD.size <= end <= len(data):
                break
            if channel == self._bus_channel:
                count, over = divmod(end - place - _BEFORE_ROWS, _ROW.itemsize)
                if count < 0 or over or stamp >= _LATEST:
                    break
                table = np.frombuffer(data, _ROW, count, place + _BEFORE_ROWS)
                if (table["length"] > 8).any() or (table["flags"] > flight.SENT).any():
                    break
                stamps.append(stamp)
                tables.append(table)
            place = end
        return _joined(stamps, tables), place


def _joined(stamps: list[int], tables: list[npt.NDArray[np.void]]) -> Frames:
    """The frames of messages with a time each, ns."""
    table = np.concatenate(tables or [np.empty(0, _ROW)])
    frames = empty(len(table))
    fill(frames.rows, table["identifier"], table["length"], table["data"])
    np.multiply(table["elapsed"], 1000, out=frames.stamp, dtype=np.int64)
    frames.stamp[:] += np.repeat(np.array(stamps, np.int64), [len(each) for each in tables])
    return frames
