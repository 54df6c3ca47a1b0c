"""The frames of our own recordings, read as a stream: piped, compressed once more, whole or torn.

`flight.py` says what stands in them. What the gateway sent is among the frames: it was on the bus too.
"""

from timonel.recording import flight
from timonel.recording.blocks import Blocks, Results
from timonel.recording.flight_bus import frames_of, layout
from timonel.recording.lines import Kind, LogFrame, moment
from timonel.recording.strays import unreadable_bytes

_READ = (flight.CHANNEL, flight.MESSAGE, flight.CHUNK)


class Mcap(Blocks):
    """MCAP with a topic `bus`."""

    name = "MCAP"
    kind: Kind = "frames"
    dated = True
    HEAD = flight.RECORD.size

    @staticmethod
    def recognises(head: bytes) -> bool:
        return head.startswith(flight.MAGIC)

    def __init__(self, head: bytes) -> None:
        """Raises RecordingError without the package `zstandard`."""
        super().__init__(len(flight.MAGIC))
        flight.decompressor()
        self._damage = flight.zstd_error()
        self._topics: dict[int, str] = {}

    def finish(self) -> Results:
        if self._rest == flight.MAGIC:
            self._rest = b""
        yield from super().finish()
        if self._topics and flight.BUS not in self._topics.values():
            yield unreadable_bytes(0, b"", f"no topic `{flight.BUS}`")

    def _size(self, data: bytes, at: int) -> int:
        opcode, size = flight.RECORD.unpack_from(data, at)
        return self.HEAD + size if opcode and size <= flight.LARGEST_CHUNK else 0

    def _is_empty(self, data: bytes, at: int) -> bool:
        return data[at] not in _READ

    def _block(self, block: bytes, at: int) -> Results:
        match block[0]:
            case flight.CHANNEL:
                self._note(block[self.HEAD :])
            case flight.MESSAGE:
                yield from self._message(block, at)
            case flight.CHUNK:
                yield from self._chunk(memoryview(block)[self.HEAD :], at)

    def _chunk(self, content: memoryview, at: int) -> Results:
        try:
            data = flight.unpacked(content)
        except self._damage as damage:
            raise ValueError(f"a chunk that is damaged: {damage}") from damage
        place = self._many(data, 0)
        while place + self.HEAD <= len(data):
            size = self._size(data, place)
            if not size or place + size > len(data):
                raise ValueError("a chunk that is not made of records")
            if data[place] in (flight.CHANNEL, flight.MESSAGE):
                yield from self._block(data[place : place + size], at)
            place = self._many(data, place + size)

    def _many(self, data: bytes, place: int) -> int:
        """Read records from `place` on as long as that can be done faster; where the next one begins."""
        return place

    def _message(self, block: bytes, at: int) -> Results:
        _, _, channel, step, stamp, _ = flight.MESSAGE_HEAD.unpack_from(block)
        if self._topics.get(channel) != flight.BUS:
            return
        message = block[flight.MESSAGE_HEAD.size :]
        if layout(message) is None:
            yield unreadable_bytes(at, block, "a message that is not made of frames")
        for frame in frames_of(message, step):
            seconds = moment((stamp + frame.elapsed * 1000) / 1e9)
            yield LogFrame(seconds, frame.identifier, frame.data, frame.extended, len(frame.data) > 8)

    def _note(self, content: bytes) -> None:
        number = int.from_bytes(content[:2], "little")
        self._topics[number] = flight.text_at(content, 4)[0]
