"""The bytes of a recording: as the file has them, or out of gzip or zstd, told apart by how they begin.

They are handed over as they come: a pipe's at once, a compressed file's in portions that stay small, however much
a few compressed bytes may stand for. A compressed file that is damaged or cut gives what stands before, and
`fault` says why no more.
"""

import os
import stat
import zlib
from collections.abc import Callable
from io import FileIO
from typing import Protocol

from timonel.errors import RecordingError

_CHUNK = 1 << 16
_SLICE = 1 << 8  # compressed bytes at a time: the most that they can stand for is 8 MiB
_MAGIC = 4  # bytes
_GZIP = b"\x1f\x8b"
_ZSTD = b"\x28\xb5\x2f\xfd"


class Source:
    """A recording's bytes, decompressed; `size` is the file's, None for a pipe, `position` what was read of it.

    Raises RecordingError for zstd without the package `zstandard`.
    """

    def __init__(self, stream: FileIO) -> None:
        self.size = _size(stream)
        self.position = 0
        self.fault = ""
        self._stream = stream
        self._ahead = self._first()
        self._packed = _packed(self._ahead)

    def read(self) -> bytes:
        """The next bytes, none at the end."""
        if self._packed is None:
            return self._raw()
        while not self.fault:
            try:
                if data := self._packed.read():
                    return data
            except self._packed.error as fault:
                self.fault = f"damaged: {fault}"
                break
            raw = self._raw()
            if not raw:
                self.fault = "" if self._packed.ended else "cut off"
                break
            self._packed.take(raw)
        return b""

    def close(self) -> None:
        self._stream.close()

    def _first(self) -> bytes:
        data = b""
        while len(data) < _MAGIC and (more := self._read()):
            data += more
        return data

    def _raw(self) -> bytes:
        data, self._ahead = self._ahead, b""
        return data or self._read()

    def _read(self) -> bytes:
        data = self._stream.read(_CHUNK)
        self.position += len(data)
        return data


class _Decompressor(Protocol):
    @property
    def eof(self) -> bool: ...
    @property
    def unused_data(self) -> bytes: ...
    def decompress(self, data: bytes, /) -> bytes: ...


class _Packed:
    """Compressed members, one behind the other; `error` is what `read` raises for damage."""

    def __init__(self, start: Callable[[], _Decompressor], error: type[Exception]) -> None:
        self.error = error
        self.ended = True
        self._start = start
        self._member = start()
        self._rest = b""

    def take(self, data: bytes) -> None:
        self._rest += data

    def read(self) -> bytes:
        """What the bytes taken stand for, not much more than 64 KiB at a time; none if they are used up."""
        parts: list[bytes] = []
        size = 0
        while self._rest and size < _CHUNK:
            part = self._member.decompress(self._rest[:_SLICE])
            self._rest, self.ended = self._rest[_SLICE:], self._member.eof
            if self.ended:
                self._rest = (self._member.unused_data + self._rest).lstrip(b"\0")  # the padding of tapes
                self._member = self._start()
            parts.append(part)
            size += len(part)
        return b"".join(parts)


def _packed(head: bytes) -> _Packed | None:
    """None for what is not compressed."""
    if head.startswith(_GZIP):
        return _Packed(lambda: zlib.decompressobj(zlib.MAX_WBITS | 16), zlib.error)
    if not head.startswith(_ZSTD):
        return None
    try:
        import zstandard
    except ImportError as missing:
        raise RecordingError("zstd: needs the extra `recording` (pip install 'timonel[recording]')") from missing
    return _Packed(zstandard.ZstdDecompressor().decompressobj, zstandard.ZstdError)


def _size(stream: FileIO) -> int | None:
    status = os.fstat(stream.fileno())
    return status.st_size if stat.S_ISREG(status.st_mode) else None
