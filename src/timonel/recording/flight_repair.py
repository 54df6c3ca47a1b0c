"""Makes a sound file of one that was cut off: its records as they stand, and the index at the end that it lacks."""

import os
import struct
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import msgspec
from mcap.records import Attachment, AttachmentIndex, ChunkIndex, MetadataIndex

from timonel.errors import RecordingError
from timonel.recording import flight
from timonel.recording.flight import ChunkHead, Damage, Flight, Raw
from timonel.recording.flight_segment import INDEX_ENTRY, Contents, counted, decoded, message_indexes


class Repaired(msgspec.Struct):
    """What was saved, and what was not. Times are wall-clock time in ns, None without any message."""

    chunks: int
    messages: int
    first_ns: int | None
    last_ns: int | None
    size: int
    damage: list[Damage]

    @property
    def lost(self) -> int:
        """Bytes of the old file that nobody can read."""
        return sum(damage.size for damage in self.damage)


def repair(path: str | Path, output: str | Path) -> Repaired:
    """Write what can be read of `path` to a new file `output`, with index and summary.

    Any MCAP file will do. Raises RecordingError for one that cannot be opened or is none, and for an `output` that
    exists or cannot be written.
    """
    old = Flight(path)
    contents = Contents()
    try:
        with open(output, "xb") as file:
            file.write(flight.MAGIC)
            for raw in old.raw():
                file.write(_copied(raw, old, contents, file.tell()))
            file.write(contents.end(file.tell()))
            file.flush()
            os.fsync(file.fileno())
            size = file.tell()
    except OSError as fault:
        raise RecordingError(f"{output}: {fault.strerror}") from fault
    last = None if contents.first is None else contents.last
    return Repaired(len(contents.chunks), contents.messages.total(), contents.first, last, size, old.damage)


def _copied(raw: Raw, old: Flight, contents: Contents, start: int) -> bytes:
    """What stands in the new file, from `start` on, for a record of the old one; what it is, is noted."""
    match raw.opcode:
        case flight.CHUNK:
            return _copied_chunk(raw, old, contents, start)
        case flight.MESSAGE_INDEX:
            return b""  # made anew
        case flight.METADATA | flight.ATTACHMENT:
            return _copied_aside(raw, old, contents, start)
        case flight.MESSAGE:
            stamp = _stamp(raw.whole)
            contents.count(Counter({_number(raw.content): 1}), stamp, stamp)
        case _:
            _declare(raw.opcode, raw.whole, contents)
    return raw.whole


def _copied_chunk(raw: Raw, old: Flight, contents: Contents, start: int) -> bytes:
    data = old.unpack(raw)
    if data is None:
        return b""
    head = ChunkHead.of(raw.content)
    entries = _entries(data, contents)
    indexes, offsets = message_indexes(entries, start + len(raw.whole))
    contents.chunks.append(
        ChunkIndex(
            chunk_length=len(raw.whole),
            chunk_start_offset=start,
            compression=head.compression,
            compressed_size=len(raw.content) - head.length,
            message_end_time=head.last,
            message_index_length=len(indexes),
            message_index_offsets=offsets,
            message_start_time=head.first,
            uncompressed_size=head.unpacked,
        )
    )
    if entries:
        contents.count(counted(entries), head.first, head.last)
    return raw.whole + indexes


def _entries(data: bytes, contents: Contents) -> dict[int, bytearray]:
    """The message indexes of a chunk by channel; schemas and channels that it declares are noted."""
    entries: dict[int, bytearray] = {}
    for place, opcode, record in _records(data):
        if opcode == flight.MESSAGE:
            channel = _number(record[flight.RECORD.size :])
            entries.setdefault(channel, bytearray()).extend(INDEX_ENTRY.pack(_stamp(record), place))
        else:
            _declare(opcode, record, contents)
    return entries


def _records(data: bytes) -> Iterator[tuple[int, int, bytes]]:
    """Place, opcode and bytes of the records of a chunk, up to one that is none."""
    place = 0
    while place + flight.RECORD.size <= len(data):
        opcode, size = flight.RECORD.unpack_from(data, place)
        end = place + flight.RECORD.size + size
        if end > len(data) or (opcode == flight.MESSAGE and end - place < flight.MESSAGE_HEAD.size):
            return
        yield place, opcode, data[place:end]
        place = end


def _declare(opcode: int, record: bytes, contents: Contents) -> None:
    declared = {flight.SCHEMA: contents.schemas, flight.CHANNEL: contents.channels}.get(opcode)
    if declared is not None:
        declared[_number(record[flight.RECORD.size :])] = record


def _copied_aside(raw: Raw, old: Flight, contents: Contents, start: int) -> bytes:
    """Metadata or an attachment; one that is damaged is left out."""
    length = len(raw.whole)
    try:
        if raw.opcode == flight.METADATA:
            contents.metadata.append(MetadataIndex(start, length, flight.text_at(raw.content, 0)[0]))
        else:
            aside = decoded(Attachment, raw.content)
            contents.attachments.append(
                AttachmentIndex(
                    start, length, aside.log_time, aside.create_time, len(aside.data), aside.name, aside.media_type
                )
            )
    except (ValueError, struct.error) as fault:
        old.damage.append(Damage(raw.offset, length, f"a record is damaged: {fault}"))
        return b""
    return raw.whole


def _number(content: bytes) -> int:
    """The number of a schema or channel, or of a message's channel."""
    return int.from_bytes(content[:2], "little")


def _stamp(message: bytes) -> int:
    stamp: int = flight.MESSAGE_HEAD.unpack_from(message)[4]
    return stamp
