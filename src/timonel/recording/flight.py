"""The flight recorder's recordings: what stands in them, and reading them, whole or torn.

A recording is an MCAP file (mcap.dev/spec), so other programs open it as it is. `docs/recording.md` describes it.

```
topic            one message                                                                   encoding
bus              CAN frames, both ways, of a tenth of a second: `flight_bus`                    CDR, ros2msg
in/<station>     {"text": what came in on a port at once}, a character a byte (ISO 8859-1)     JSON
out/all          {"text": what was said}: every OUT port is told the same                      JSON
ports, timer     what else the machine was told: a port came or went, time passed              JSON
events           {"type": ..., fields}: what the machine noticed                               JSON
recorder         {"type": ..., fields}: links, faults, alerts and gaps of the recorder's own   JSON
decoded/<name>   the values of a declared message, if the configuration wants them             JSON
```
`log_time` is wall-clock time, `publish_time` the machine's monotonic time, a whole number of microseconds, both in
ns. `sequence` is the step: every time the machine is told something a step begins, and what it answered has the
number of that step. The chunks of a recording hold whole steps, so a file that was cut off anywhere is a recording up
to its last whole chunk.
"""

import os
import struct
from collections.abc import Iterator
from functools import cache
from io import FileIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec

from timonel.errors import RecordingError
from timonel.recording.flight_bus import frames_of, layout
from timonel.recording.lines import LogFrame

try:  # a quarter of the time that zlib takes
    from isal.isal_zlib import crc32
except ImportError:
    from zlib import crc32

if TYPE_CHECKING:
    from zstandard import ZstdDecompressor

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX = 0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07
ATTACHMENT, METADATA, DATA_END = 0x09, 0x0C, 0x0F
"""What the records of an MCAP file are (mcap.dev/spec)."""
LARGEST_CHUNK = 1 << 30

BUS, OUT, PORTS, TIMER, EVENTS, RECORDER = "bus", "out/all", "ports", "timer", "events", "recorder"
IN = "in/"
DECODED = "decoded/"
"""The topics; a station's port and a message have theirs behind the slash."""

RECORD = struct.Struct("<BQ")
MESSAGE_HEAD = struct.Struct("<BQHIQQ")
"""Opcode and size; of a message also channel, sequence, log_time and publish_time."""
_CHUNK_HEAD = struct.Struct("<QQQII")
_CHUNK_DATA = struct.Struct("<Q")

Metadata = dict[str, dict[str, str]]


class Record(NamedTuple):
    """A message of a recording: wall-clock and monotonic time in ns, its step and its bytes."""

    topic: str
    step: int
    stamp_ns: int
    now_ns: int
    data: bytes

    @property
    def fields(self) -> dict[str, Any]:
        """What a JSON message says. Raises msgspec.DecodeError for any other."""
        fields: dict[str, Any] = msgspec.json.decode(self.data)
        return fields


class Damage(msgspec.Struct, frozen=True):
    """`size` bytes from `offset` on that could not be read."""

    offset: int
    size: int
    reason: str


class Raw(NamedTuple):
    """A record of an MCAP file as it stands there."""

    offset: int
    opcode: int
    content: bytes

    @property
    def whole(self) -> bytes:
        """With opcode and size."""
        return RECORD.pack(self.opcode, len(self.content)) + self.content


class ChunkHead(NamedTuple):
    """What stands before the data of a chunk: `length` bytes with the times of its messages and the size of what it
    holds, unpacked, with the check sum of that (0: none)."""

    first: int
    last: int
    unpacked: int
    crc: int
    compression: str
    length: int

    @classmethod
    def of(cls, content: bytes | memoryview) -> "ChunkHead":
        """Raises ValueError and struct.error."""
        first, last, unpacked, crc, _ = _CHUNK_HEAD.unpack_from(content)
        compression, end = text_at(content, _CHUNK_HEAD.size - 4)
        (size,) = _CHUNK_DATA.unpack_from(content, end)
        if end + _CHUNK_DATA.size + size != len(content):
            raise ValueError("its size is wrong")
        return cls(first, last, unpacked, crc, compression, end + _CHUNK_DATA.size)


class Flight:
    """A recording, read from front to end as far as it goes: iterate over it, or over `pages` or `raw`, once.

    `metadata`, by name, is there at once; `damage` tells afterwards what could not be read, and `finished` whether
    the file was brought to its end. Raises RecordingError for a file that cannot be opened or is no MCAP file, and
    nothing after that.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.metadata: Metadata = {}
        self.damage: list[Damage] = []
        self.finished = False
        self.topics: dict[int, str] = {}
        with _open(self.path) as stream:
            for raw in self._records(stream):
                if raw.opcode == CHUNK:
                    break
        self.finished = False
        self.damage.clear()

    def __iter__(self) -> Iterator[Record]:
        for page in self.pages():
            yield from page

    def pages(self) -> Iterator[list[Record]]:
        """The messages of each chunk; what was recorded by a Tape is whole steps."""
        for raw in self.raw():
            if raw.opcode == CHUNK and (data := self.unpack(raw)) is not None:
                yield list(self._messages(raw.offset, data))

    def raw(self) -> Iterator[Raw]:
        """The records of the file before its end, which is looked at all the same."""
        ended = False
        with _open(self.path) as stream:
            for raw in self._records(stream):
                ended |= raw.opcode == DATA_END
                if not ended:
                    yield raw

    def unpack(self, raw: Raw) -> bytes | None:
        """What stands in a chunk; None, noted as damage, if that cannot be told."""
        try:
            return unpacked(raw.content)
        except (ValueError, struct.error, zstd_error()) as fault:
            self.damage.append(Damage(raw.offset, len(raw.whole), f"a chunk is damaged: {fault}"))
            return None

    def _records(self, stream: FileIO) -> Iterator[Raw]:
        """All of a file but the footer, and whether it is finished."""
        end = os.fstat(stream.fileno()).st_size
        offset = len(MAGIC)
        while not self.finished:
            head = stream.read(RECORD.size)
            opcode, size = RECORD.unpack(head) if len(head) == RECORD.size else (0, 0)
            after = offset + RECORD.size + size
            if not opcode or after > end:
                break
            raw = Raw(offset, opcode, stream.read(size))
            offset = after
            if opcode == FOOTER:
                self.finished = stream.read(len(MAGIC)) == MAGIC
                break
            self._note(raw)
            yield raw
        if not self.finished:
            self.damage.append(Damage(offset, end - offset, "the file is cut off"))

    def _note(self, raw: Raw) -> None:
        try:
            if raw.opcode == METADATA:
                name, rest = text_at(raw.content, 0)
                self.metadata[name] = _pairs(raw.content, rest)
            elif raw.opcode == CHANNEL:
                (number,) = struct.unpack_from("<H", raw.content)
                self.topics[number] = text_at(raw.content, 4)[0]
        except (ValueError, struct.error) as fault:
            self.damage.append(Damage(raw.offset, len(raw.whole), f"a record is damaged: {fault}"))

    def _messages(self, offset: int, data: bytes) -> Iterator[Record]:
        """Runs once a message: written for speed."""
        topics = self.topics
        place, end = 0, len(data)
        size_of_head = MESSAGE_HEAD.size
        while place + RECORD.size <= end:
            opcode, size = RECORD.unpack_from(data, place)
            begin, place = place, place + RECORD.size + size
            if place > end:
                self.damage.append(Damage(offset, end - begin, "a message is cut off"))
                return
            if opcode == MESSAGE and place - begin >= size_of_head:
                _, _, channel, step, stamp, now = MESSAGE_HEAD.unpack_from(data, begin)
                topic, message = topics.get(channel, ""), data[begin + size_of_head : place]
                if topic == BUS and layout(message) is None:
                    self.damage.append(Damage(offset, place - begin, "a message is not made of frames"))
                    continue
                yield Record(topic, step, stamp, now, message)
            elif opcode == CHANNEL:  # others than a Tape put them here
                self._note(Raw(offset, opcode, data[begin + RECORD.size : place]))


def read(path: str | Path) -> Iterator[Record]:
    """The messages of a recording, as far as it can be read. Raises RecordingError as `Flight` does."""
    return iter(Flight(path))


def frames(path: str | Path, *, sent: bool | None = None) -> Iterator[LogFrame]:
    """The frames of the bus with their wall-clock times; with `sent` only those that the gateway sent, or did not."""
    for record in read(path):
        if record.topic != BUS:
            continue
        for frame in frames_of(record.data, record.step):
            if sent is None or frame.sent is sent:
                moment = (record.stamp_ns + frame.elapsed * 1000) / 1e9
                yield LogFrame(moment, frame.identifier, frame.data, frame.extended, len(frame.data) > 8)


def _open(path: Path) -> FileIO:
    try:
        stream = FileIO(path)
    except OSError as fault:
        raise RecordingError(f"{path}: {fault.strerror}") from fault
    try:
        if stream.read(len(MAGIC)) == MAGIC:
            return stream
    except OSError as fault:
        raise RecordingError(f"{path}: {fault.strerror}") from fault
    stream.close()
    raise RecordingError(f"{path}: not an MCAP file")


def unpacked(content: bytes | memoryview) -> bytes:
    """What a chunk holds. Raises ValueError, struct.error and `zstd_error` for a damaged one."""
    head = ChunkHead.of(content)
    if head.unpacked > LARGEST_CHUNK:
        raise ValueError(f"{head.unpacked} bytes are announced")
    packed = content[head.length :]
    match head.compression:
        case "":
            data = bytes(packed)
        case "zstd":
            data = _decompress(packed, head.unpacked)
        case other:
            raise ValueError(f'compressed with "{other}", which is not read here')
    if head.crc and crc32(data) != head.crc:
        raise ValueError("its check sum is wrong")
    return data


def _decompress(data: bytes | memoryview, size: int) -> bytes:
    from zstandard import frame_content_size

    if frame_content_size(data) not in (-1, size):  # it says itself how much memory it wants
        raise ValueError(f"{size} bytes are announced, and others")
    return decompressor().decompress(data, max_output_size=size)


def zstd_error() -> type[Exception]:
    """What zstandard raises."""
    from zstandard import ZstdError

    return ZstdError


@cache
def decompressor() -> "ZstdDecompressor":
    """Raises RecordingError where the extra is missing."""
    try:
        from zstandard import ZstdDecompressor
    except ImportError as fault:
        raise RecordingError("reading this recording needs zstandard: pip install timonel[recording]") from fault
    return ZstdDecompressor()


def text_at(content: bytes | memoryview, place: int) -> tuple[str, int]:
    """A string with its size before it, and where it ends."""
    (size,) = struct.unpack_from("<I", content, place)
    end = place + 4 + size
    if end > len(content):
        raise ValueError("a text is cut off")
    return bytes(content[place + 4 : end]).decode(), end


def _pairs(content: bytes, place: int) -> dict[str, str]:
    """A map of strings with its size before it."""
    (size,) = struct.unpack_from("<I", content, place)
    place, end = place + 4, place + 4 + size
    pairs = {}
    while place < end:
        key, place = text_at(content, place)
        pairs[key], place = text_at(content, place)
    return pairs
