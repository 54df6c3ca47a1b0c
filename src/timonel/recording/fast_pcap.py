"""Captures to frames, thousands of packets at a time. Needs the extra `columns`.

SocketCAN's packets are all of one size, so as far as they are, they are an array as they stand in the file. Every
other packet, and one that is no frame of classic CAN, is left to the reader of single packets, in its turn.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from timonel import native
from timonel.recording.frames import EXTENDED, Bytes, Frames, Identifiers, empty, fill
from timonel.recording.lines import LogFrame, Unreadable
from timonel.recording.pcap import LINKS, Pcap

MANY = 1 << 15
_FEW = 16
"""Packets that are looked at together: the more, the longer nothing else has come."""

_CAN_FRAME = 16
_PROTOCOL_CAN = 12
_REMOTE_OR_ERROR = 0x60000000


class FastPcap(Pcap):
    """pcap, of which `receive` gives arrays of frames too."""

    def __init__(self, head: bytes) -> None:
        super().__init__(head)
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

    def receive(self, data: bytes) -> Iterator[Frames | LogFrame | Unreadable]:  # type: ignore[override]
        """What `data`, the next of the capture, completes."""
        data, self._rest = self._rest + data, b""
        at = self._before if len(data) > self._before else 0
        if at:
            yield from super().receive(data[:at])
        while not self._lost:
            frames = self._run(data, at)
            if len(frames):
                yield frames
                at += len(frames) * self._packets.itemsize
                self._at += len(frames) * self._packets.itemsize
                continue
            size = self._size(data, at) if len(data) - at >= self.HEAD else 0
            end = at + size if size else len(data)
            yield from super().receive(data[at:end])
            at = end
            if self._rest or at == len(data):
                break

    def _run(self, data: bytes, at: int) -> Frames:
        """The frames from `at` up to the first packet of another size or kind."""
        count = min((len(data) - at) // self._packets.itemsize, self._together)
        if native.kernels is not None:
            frames = empty(count)
            found = native.kernels.captured_frames(data, at, count, self._known, frames.rows, frames.stamp)
            self._together = min(2 * self._together, MANY) if found == count else _FEW
            return frames[:found]
        packets = np.ndarray(count, self._packets, data, at)
        identifier, length = packets["identifier"].astype(np.uint32), packets["length"].copy()
        plain = (packets["captured"] == self._captured) & (length <= 8) & (identifier & _REMOTE_OR_ERROR == 0)
        plain &= (identifier >= EXTENDED) | (identifier < 1 << 11)
        if self._has_protocol:
            plain &= packets["protocol"] == _PROTOCOL_CAN
        if plain.all():
            self._together = min(2 * self._together, MANY)
        else:
            self._together = _FEW
            count = int(plain.argmin())
        return self._frames(packets[:count], identifier[:count], length[:count])

    def _frames(self, packets: npt.NDArray[Any], identifier: Identifiers, length: Bytes) -> Frames:
        frames = empty(len(packets))
        fill(frames.rows, identifier, length, packets["data"])
        np.multiply(packets["seconds"], 1_000_000_000, out=frames.stamp, dtype=np.int64)
        fraction = packets["fraction"].astype(np.int64)
        fraction *= self._nanoseconds
        np.add(frames.stamp, fraction, out=frames.stamp)
        return frames
