"""Vector's BLF, binary: objects, most of them in containers that are compressed.

    LOGG, size of the header, ..., at 40 the start: year, month, day of the week, day, h, min, s, ms, of 16 bits each
    LOBJ, size of the head, version of the head, size of the object, type; flags, time; what the type has
    type 10: a container; 1 and 86: a CAN frame; 100 and 101: CAN FD

Times are 10 us (flags 1) or 1 ns since the start; without a start they count from 1970-01-01. An object begins with
LOBJ wherever it stands, so behind damage reading goes on with the next. Other objects, remote requests and error
frames are passed over. Source: python-can `blf.py`, whose reader is not used because damage can send it round in
circles.
"""

import zlib
from datetime import UTC, datetime
from struct import Struct, unpack_from

from msgspec.structs import replace

from timonel.recording.blocks import Blocks, Results
from timonel.recording.lines import Kind, LogFrame, Unreadable, moment

_OBJECT = Struct("<4sHHII")
_CONTAINER = Struct("<H6xI4x")
_TIME = Struct("<I4xQ")
_CAN = Struct("<HBBI8s")
_HEADER, _START = 144, 40
_LARGEST = 1 << 26  # of an object, and of what a container unpacks to; Vector's containers have 128 KiB
_EXTENDED, _REMOTE, _TEN_MICROSECONDS = 0x80000000, 0x80, 1
_STORED, _DEFLATED = 0, 2


class _Objects(Blocks):
    """Objects, one behind the other."""

    HEAD = _OBJECT.size
    PADDING = b"\0"

    def __init__(self, began: float, before: int = 0) -> None:
        super().__init__(before)
        self._began = began
        self._inside: _Objects | None = None

    def finish(self) -> Results:
        """Also what the beginning of a container unpacks to."""
        if len(self._rest) > _OBJECT.size + _CONTAINER.size and _OBJECT.unpack_from(self._rest)[::4] == (b"LOBJ", 10):
            yield from self._read(self._rest, self._at)
        yield from super().finish()

    def _size(self, data: bytes, at: int) -> int:
        signature, _, _, size, _ = _OBJECT.unpack_from(data, at)
        return size if signature == b"LOBJ" and size <= _LARGEST else 0

    def _resume(self, data: bytes, start: int) -> int:
        place = data.find(b"LOBJ", start)
        return place if place >= 0 else max(start, len(data) - 3)

    def _block(self, block: bytes, at: int) -> Results:
        _, head, _, _, kind = _OBJECT.unpack_from(block)
        match kind:
            case 10:
                yield from self._container(block, at)
            case 1 | 86:
                frame = self._frame(block, head)
                if frame is not None:
                    yield frame
            case 100 | 101:
                raise ValueError("not a classic CAN frame")

    def _container(self, block: bytes, at: int) -> Results:
        if self._inside is None:
            self._inside = _Objects(self._began)
        for found in self._inside.receive(_unpacked(block)):
            yield replace(found, offset=at) if type(found) is Unreadable else found

    def _frame(self, block: bytes, head: int) -> LogFrame | None:
        flags, ticks = _TIME.unpack_from(block, _OBJECT.size)
        _, frame_flags, length, identifier, data = _CAN.unpack_from(block, head)
        if frame_flags & _REMOTE:
            return None
        extended, number = bool(identifier & _EXTENDED), identifier & 0x1FFFFFFF
        if length > 8 or (number >> 11 and not extended):
            raise ValueError("not a classic CAN frame")
        elapsed = ticks / (1e5 if flags == _TEN_MICROSECONDS else 1e9)
        return LogFrame(moment(self._began + elapsed), number, data[:length], extended)


class Blf(_Objects):
    """BLF: a header, then objects."""

    name = "Vector BLF"
    kind: Kind = "frames"

    @staticmethod
    def recognises(head: bytes) -> bool:
        return head[:4] == b"LOGG"

    def __init__(self, head: bytes) -> None:
        super().__init__(_began(head), _header(head))
        self.dated = self._began > 0


def _header(head: bytes) -> int:
    """Bytes of the header."""
    size = int.from_bytes(head[4:8], "little")
    return size if _START <= size <= 4096 else _HEADER


def _began(head: bytes) -> float:
    """Unix seconds; 0 where the header does not tell."""
    if len(head) < _START + 16:
        return 0.0
    year, month, _, day, hour, minute, second, millisecond = unpack_from("<8H", head, _START)
    try:
        return moment(datetime(year, month, day, hour, minute, second, millisecond * 1000, UTC).timestamp())
    except ValueError:
        return 0.0


def _unpacked(block: bytes) -> bytes:
    """What is in a container, or in its beginning. ValueError if it is damaged."""
    method, _ = _CONTAINER.unpack_from(block, _OBJECT.size)
    data = block[_OBJECT.size + _CONTAINER.size :]
    if method == _STORED:
        return data
    if method != _DEFLATED:
        raise ValueError(f"a container of unknown compression {method}")
    try:
        return zlib.decompressobj().decompress(data, _LARGEST)
    except zlib.error as damage:
        raise ValueError(f"a container that is damaged: {damage}") from damage
