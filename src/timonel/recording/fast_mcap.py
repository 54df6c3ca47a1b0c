"""Our own recordings to frames, message by message instead of frame by frame. Needs the extra `columns`."""

import numpy as np

from timonel.recording import flight
from timonel.recording.blocks import Results
from timonel.recording.frames import FRAME, Frames
from timonel.recording.mcap import Mcap

_ROW = np.dtype([("frame", "V16"), ("elapsed", "<u4"), ("step", "<u4")])
_FLAGS = FRAME.fields["flags"][1]  # type: ignore[index]
_ALONE = bytes((0, flight.SENT))  # flags of a frame that is one row
_LATEST = 1 << 62  # ns


class FastMcap(Mcap):
    """MCAP with a topic `bus`: its rows are collected, and `taken` has their frames.

    Only a message with frames of more than one row gives them one by one.
    """

    def __init__(self, head: bytes) -> None:
        super().__init__(head)
        self._stamps: list[int] = []
        self._rows: list[bytes] = []

    # Once a message, which is what stands on the bus in a tenth of a second.
    def _bus(self, stamp: int, rows: bytes) -> Results:
        if len(rows) % _ROW.itemsize or rows[_FLAGS :: _ROW.itemsize].strip(_ALONE) or stamp >= _LATEST:
            return super()._bus(stamp, rows)
        self._stamps.append(stamp)
        self._rows.append(rows)
        return iter(())

    def taken(self) -> Frames:
        """The frames collected since the last time."""
        table = np.frombuffer(b"".join(self._rows), _ROW)
        count = np.array([len(rows) // _ROW.itemsize for rows in self._rows], np.intp)
        rows = table["frame"].copy().view(FRAME)
        rows["flags"] = 0
        stamp = np.repeat(np.array(self._stamps, np.int64), count)
        stamp += table["elapsed"].astype(np.int64) * 1000
        self._stamps, self._rows = [], []
        return Frames(rows, stamp)
