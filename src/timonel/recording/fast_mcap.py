"""Our own recordings to frames, chunk by chunk instead of frame by frame. Needs the extra `columns`."""

import numpy as np
import numpy.typing as npt

from timonel import native
from timonel.recording import flight
from timonel.recording.frames import Gatherer, fill
from timonel.recording.mcap import Mcap

_ROW = np.dtype(
    [("identifier", "<u4"), ("length", "u1"), ("flags", "u1"), ("", "V2"), ("data", "<u8"), ("elapsed", "<u4"),
     ("step", "<u4")]
)  # fmt: skip
_HEAD = flight.MESSAGE_HEAD
_BEFORE_ROWS = _HEAD.size + flight.ROWS_AT
_LATEST = 1 << 62  # ns


class FastMcap(Mcap):
    """MCAP with a topic `bus`, whose frames are `gathered`.

    Only a message with frames of more than one row gives them one by one.
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
        room = self._gathered.room((len(data) - place) // _ROW.itemsize)
        assert native.kernels is not None
        bus = self._bus_channel
        count, place = native.kernels.recorded_frames(data, place, bus, _LATEST, room.rows, room.stamp)
        self._gathered.took(count)
        return place

    def _without(self, data: bytes, place: int) -> int:
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
        self._gather(stamps, tables)
        return place

    def _gather(self, stamps: list[int], tables: list[npt.NDArray[np.void]]) -> None:
        """The frames of messages with a time each, ns."""
        table = np.concatenate(tables or [np.empty(0, _ROW)])
        room = self._gathered.room(len(table))[: len(table)]
        fill(room.rows, table["identifier"], table["length"], table["data"])
        np.multiply(table["elapsed"], 1000, out=room.stamp, dtype=np.int64)
        room.stamp[:] += np.repeat(np.array(stamps, np.int64), [len(each) for each in tables])
        self._gathered.took(len(table))
