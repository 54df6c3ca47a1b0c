"""Captures to frames, thousands of packets at a time. Needs the extra `columns`.

SocketCAN's packets are all of one size, so as far as they are, they are an array as they stand in the file. Every
other packet, and one that is no frame of classic CAN, is left to the reader of single packets, in its turn.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from timonel import native
from timonel.recording.blocks import Results
from timonel.recording.frames import EXTENDED, Frames, Gatherer, fill
from timonel.recording.pcap import LINKS, Pcap

MANY = 1 << 15
_FEW = 16
"""Packets that are looked at together: the more, the longer nothing else has come."""

_CAN_FRAME = 16
_PROTOCOL_CAN = 12
_REMOTE_OR_ERROR = 0x60000000


class FastPcap(Pcap):
    """pcap, whose frames are `gathered` as far as they are plain; `receive` gives the others, each in its turn."""

    def __init__(self, head: bytes, gathered: Gatherer) -> None:
        super().__init__(head)
        self._gathered = gathered
        before, protocol = LINKS[self._link]
        order = self._packet.format[0]
        fields = {
            "seconds": (f"{order}u4", 0),
            "fraction": (f"{order}u4", 4),
            "captured": (f"{order}u4", 8),
            "protocol": (">u2", 16 + (protocol or 0)),
            "identifier": (">u4", 16 + before),
            "length": ("u1", 20 + before),
            "data": ("<u8", 24 + before),
        }
        self._captured = before + _CAN_FRAME
        formats, offsets = zip(*fields.values(), strict=True)
        layout = {"names": list(fields), "formats": formats, "offsets": offsets, "itemsize": 16 + self._captured}
        self._packets = np.dtype(layout)  # type: ignore[call-overload]
        self._has_protocol = protocol is not None
        self._nanoseconds = 1_000_000_000 // int(self._second)
        stands = (16 + before, -1 if protocol is None else 16 + protocol)
        self._known = (16 + self._captured, self._captured, *stands, self._nanoseconds, order == ">")
        self._together = _FEW

    def receive(self, data: bytes) -> Results:
        """What `data`, the next of the capture, completes."""
        data, self._rest = self._rest + data, b""
        at = self._before if len(data) > self._before else 0
        if at:
            yield from super().receive(data[:at])
        while not self._lost:
            if count := self._run(data, at):
                at += count * self._packets.itemsize
                self._at += count * self._packets.itemsize
                continue
            size = self._size(data, at) if len(data) - at >= self.HEAD else 0
            end = at + size if size else len(data)
            yield from super().receive(data[at:end])
            at = end
            if self._rest or at == len(data):
                break

    def _run(self, data: bytes, at: int) -> int:
        """Take the frames from `at` up to the first packet of another size or kind; how many these are."""
        room = self._gathered.room()
        count = min((len(data) - at) // self._packets.itemsize, self._together, len(room))
        if native.kernels is not None:
            found = native.kernels.captured_frames(data, at, count, self._known, room.rows, room.stamp)
        else:
            found = self._plain(np.ndarray(count, self._packets, data, at), room)
        self._together = min(2 * self._together, MANY) if found == count else _FEW
        self._gathered.took(found)
        return found

    def _plain(self, packets: npt.NDArray[Any], room: Frames) -> int:
        identifier, length = packets["identifier"].astype(np.uint32), packets["length"].copy()
        plain = (packets["captured"] == self._captured) & (length <= 8) & (identifier & _REMOTE_OR_ERROR == 0)
        plain &= (identifier >= EXTENDED) | (identifier < 1 << 11)
        if self._has_protocol:
            plain &= packets["protocol"] == _PROTOCOL_CAN
        count = len(plain) if plain.all() else int(plain.argmin())
        packets = packets[:count]
        fill(room.rows[:count], identifier[:count], length[:count], packets["data"])
        stamp = room.stamp[:count]
        np.multiply(packets["seconds"], 1_000_000_000, out=stamp, dtype=np.int64)
        stamp += packets["fraction"].astype(np.int64) * self._nanoseconds
        return count
