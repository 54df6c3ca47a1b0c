"""Bytes of a binary recording that could not be read."""

from timonel.recording.lines import Unreadable

_SHOWN = 32  # bytes


def unreadable_bytes(offset: int, data: bytes, reason: str) -> Unreadable:
    """What is told of them: the first, in hex, and the offset in the recording."""
    return Unreadable(None, data[:_SHOWN].hex(" "), reason, offset)


class Strays:
    """Bytes that are of nothing, told once however many they are, and however they came."""

    def __init__(self) -> None:
        self._first = b""
        self._offset = 0
        self._count = 0

    def add(self, offset: int, data: bytes) -> None:
        """`data` directly behind those before."""
        if not self._count:
            self._offset = offset
        self._first += data[: _SHOWN - len(self._first)]
        self._count += len(data)

    def told(self) -> list[Unreadable]:
        """Those since the last time, if there are any."""
        if not self._count:
            return []
        count, first = self._count, self._first
        self._first, self._count = b"", 0
        return [unreadable_bytes(self._offset, first, f"{count} bytes of nothing that is known")]
