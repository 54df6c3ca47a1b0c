"""One file of a recording, as it is written: chunk by chunk, and an index at its end."""

import os
import struct
import zlib
from collections import Counter
from collections.abc import Iterable, Mapping
from io import BytesIO
from pathlib import Path
from typing import TypeVar

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.records import Chunk as ChunkRecord
from mcap.records import Metadata as MetadataRecord
from zstandard import ZstdCompressor

from timonel.recording.flight import MAGIC, MESSAGE_INDEX, Metadata
from timonel.recording.flight_tape import Page, Topic
from timonel.recording.flight_tape import Schema as TopicSchema

R = TypeVar("R", bound=McapRecord)
LIBRARY = "timonel"
INDEX_ENTRY = struct.Struct("<QQ")
"""Of a message index: log_time, and where the message stands in its chunk."""
_INDEX_HEAD = struct.Struct("<BQHI")


def encoded(record: McapRecord) -> bytes:
    """A record as it stands in the file."""
    builder = RecordBuilder()
    record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data


def decoded(kind: type[R], content: bytes) -> R:
    """The record that stands behind opcode and size. Raises ValueError and struct.error for a damaged one."""
    try:
        record: R = kind.read(ReadDataStream(BytesIO(content)))  # type: ignore[attr-defined]
    except EndOfFile as fault:
        raise ValueError("it is cut off") from fault
    return record


class Contents:
    """What a file holds, for the index at its end."""

    def __init__(self) -> None:
        self.schemas: dict[int, bytes] = {}
        self.channels: dict[int, bytes] = {}
        self.chunks: list[ChunkIndex] = []
        self.attachments: list[AttachmentIndex] = []
        self.metadata: list[MetadataIndex] = []
        self.messages: Counter[int] = Counter()
        self.first: int | None = None
        self.last = 0

    def count(self, messages: Counter[int], first: int, last: int) -> None:
        """Messages by channel, and the times of the first and the last."""
        self.messages += messages
        self.first = first if self.first is None else min(self.first, first)
        self.last = max(self.last, last)

    def groups(self) -> list[tuple[Opcode, bytes]]:
        """The records of the summary."""
        statistics = Statistics(
            attachment_count=len(self.attachments),
            channel_count=len(self.channels),
            channel_message_counts=dict(self.messages),
            chunk_count=len(self.chunks),
            message_count=self.messages.total(),
            message_end_time=self.last,
            message_start_time=self.first or 0,
            metadata_count=len(self.metadata),
            schema_count=len(self.schemas),
        )
        return [
            (Opcode.SCHEMA, b"".join(self.schemas.values())),
            (Opcode.CHANNEL, b"".join(self.channels.values())),
            (Opcode.STATISTICS, encoded(statistics)),
            (Opcode.CHUNK_INDEX, b"".join(map(encoded, self.chunks))),
            (Opcode.ATTACHMENT_INDEX, b"".join(map(encoded, self.attachments))),
            (Opcode.METADATA_INDEX, b"".join(map(encoded, self.metadata))),
        ]

    def end(self, start: int) -> bytes:
        """The end of the file, which begins at `start`."""
        data_end = encoded(DataEnd(0))
        start += len(data_end)
        groups = [(opcode, data) for opcode, data in self.groups() if data]
        summary, offsets = b"", b""
        for opcode, data in groups:
            offsets += encoded(SummaryOffset(opcode, start + len(summary), len(data)))
            summary += data
        footer = encoded(Footer(start, start + len(summary), 0))[:-4]
        crc = zlib.crc32(summary + offsets + footer)  # up to the check sum itself, as the specification has it
        return data_end + summary + offsets + footer + struct.pack("<I", crc) + MAGIC


class SegmentFile:
    """A file in the making. All methods raise OSError, and leave the file as it was before then.

    `path` must not exist.
    """

    def __init__(self, path: Path, metadata: Metadata) -> None:
        self.path = path
        self.size = 0
        self._contents = Contents()
        self._schemas: dict[TopicSchema, int] = {}
        self._compressor = ZstdCompressor(level=3)
        self._fd = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644)
        try:
            self._write_front(metadata)
        except OSError:
            self.discard()
            raise

    @property
    def chunks(self) -> int:
        """How many were written."""
        return len(self._contents.chunks)

    def _write_front(self, metadata: Metadata) -> None:
        front = MAGIC + encoded(Header("", LIBRARY))
        indexes = []
        for name, pairs in metadata.items():
            record = encoded(MetadataRecord(name, pairs))
            indexes.append(MetadataIndex(len(front), len(record), name))
            front += record
        self._append(front)
        self._contents.metadata += indexes

    def write(self, page: Page) -> None:
        """Append a chunk."""
        announced = self._announce(page.topics)
        chunk, index = chunk_of(page, self._compressor, self.size + len(announced))
        self._append(announced + chunk)
        self._contents.chunks.append(index)
        self._contents.count(counted(page.indexes), page.first, page.last)

    def _announce(self, topics: Iterable[Topic]) -> bytes:
        """The records of topics that this file has not seen."""
        contents, announced = self._contents, []
        for number, topic in enumerate(topics, 1):
            if number in contents.channels:
                continue
            schema = topic.schema
            if schema not in self._schemas:
                place = self._schemas[schema] = len(self._schemas) + 1
                contents.schemas[place] = encoded(
                    Schema(id=place, data=schema.text.encode(), encoding=schema.encoding, name=schema.name)
                )
                announced.append(contents.schemas[place])
            channel = Channel(number, topic.name, schema.message_encoding, {}, self._schemas[schema])
            contents.channels[number] = encoded(channel)
            announced.append(contents.channels[number])
        return b"".join(announced)

    def sync(self) -> None:
        """Returns when all of it is on the disk."""
        os.fsync(self._fd)

    def finish(self) -> None:
        """Write the index and close."""
        try:
            self._append(self._contents.end(self.size))
            self.sync()
        finally:
            self.close()

    def close(self) -> None:
        """Close it as it is: it can be read up to its last chunk."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def discard(self) -> None:
        """Close and delete it."""
        self.close()
        os.unlink(self.path)

    def _append(self, data: bytes) -> None:
        written = 0
        try:
            while written < len(data):
                written += os.write(self._fd, memoryview(data)[written:])
        except OSError:
            if written:
                os.ftruncate(self._fd, self.size)
                os.lseek(self._fd, self.size, os.SEEK_SET)
            raise
        self.size += len(data)


def chunk_of(page: Page, compressor: ZstdCompressor, start: int) -> tuple[bytes, ChunkIndex]:
    """A chunk with its message indexes, and what the index of a file says of it where it stands at `start`."""
    packed = compressor.compress(page.data)
    record = encoded(
        ChunkRecord(
            compression="zstd",
            data=packed,
            message_start_time=page.first,
            message_end_time=page.last,
            uncompressed_crc=zlib.crc32(page.data),
            uncompressed_size=len(page.data),
        )
    )
    indexes, offsets = message_indexes(page.indexes, start + len(record))
    index = ChunkIndex(
        chunk_length=len(record),
        chunk_start_offset=start,
        compression="zstd",
        compressed_size=len(packed),
        message_end_time=page.last,
        message_index_length=len(indexes),
        message_index_offsets=offsets,
        message_start_time=page.first,
        uncompressed_size=len(page.data),
    )
    return record + indexes, index


def message_indexes(entries: Mapping[int, bytes | bytearray], start: int) -> tuple[bytes, dict[int, int]]:
    """The message indexes of a chunk, which stand from `start` on, and where each channel's does."""
    records, offsets = bytearray(), {}
    for channel, index in entries.items():
        offsets[channel] = start + len(records)
        records += _INDEX_HEAD.pack(MESSAGE_INDEX, 6 + len(index), channel, len(index)) + index
    return bytes(records), offsets


def counted(entries: Mapping[int, bytes | bytearray]) -> Counter[int]:
    """How many messages of each channel there are."""
    return Counter({channel: len(index) // INDEX_ENTRY.size for channel, index in entries.items()})
