"""What is recorded between two flushes, put together as one chunk: told the time, without any I/O.

What runs once a frame or once an answer is written for speed here: it is the only part of the recorder that the
vehicle's stations wait for.
"""

import struct
from collections.abc import Iterable, Sequence

import msgspec

from timonel.core.frame import Frame
from timonel.recording.flight import (
    BUS,
    CONTINUED,
    EVENTS,
    EXTENDED,
    IN,
    MESSAGE,
    MESSAGE_HEAD,
    OUT,
    PORTS,
    RECORD,
    RECORDER,
    ROW,
    TIMER,
)

SPAN = 100_000  # us of frames that one message of `bus` holds
ROWS = 4096  # at most
STEPS = 1 << 32
_MESSAGE_SIZE = MESSAGE_HEAD.size - RECORD.size
_INDEX = struct.Struct("<QQ")  # an entry of a message index
_CDR = struct.Struct("<4sI")
_LITTLE_ENDIAN = b"\0\1\0\0"  # CDR's header

FRAMES = """\
# CAN frames of a tenth of a second. The time of one is the message's own and `elapsed`.
Frame[] frames
================================================================================
MSG: timonel/Frame
uint32 identifier  # bit 31: 29 bits, else 11
uint8 length
uint8 flags        # 1: sent by the gateway, 2: goes on with the data of the one before
uint16 reserved
uint8[8] data
uint32 elapsed     # microseconds
uint32 step        # frames that the machine was told together have the same one
"""


class Schema(msgspec.Struct, frozen=True):
    """How the messages of a topic are written, in the words of the MCAP registry."""

    name: str
    encoding: str
    text: str
    message_encoding: str


def json_schema(name: str, **properties: str) -> Schema:
    """A schema of JSON messages with values of these types."""
    kinds = {key: {"type": kind} for key, kind in properties.items()}
    text = msgspec.json.encode({"title": name, "type": "object", "properties": kinds}).decode()
    return Schema(name, "jsonschema", text, "json")


class Topic(msgspec.Struct, frozen=True):
    """A channel of the recording; its number is its place among all, from 1."""

    name: str
    schema: Schema


FRAMES_SCHEMA = Schema("timonel/msg/Frames", "ros2msg", FRAMES, "cdr")
TEXT = json_schema("timonel.Text", text="string")
EVENT = json_schema("timonel.Event", type="string")
OWN = (
    Topic(BUS, FRAMES_SCHEMA),
    Topic(OUT, TEXT),
    Topic(PORTS, json_schema("timonel.Port", port="string", connected="boolean")),
    Topic(TIMER, json_schema("timonel.Timer")),
    Topic(EVENTS, EVENT),
    Topic(RECORDER, EVENT),
)


class Page(msgspec.Struct):
    """The records of a chunk, `indexes` by channel as a message index has them, and what is in it."""

    topics: tuple[Topic, ...]
    data: bytearray
    indexes: dict[int, bytearray]
    first: int
    last: int
    steps: int


class Tape:
    """Takes records in order, and gives them as pages.

    `stations` are the ports that may say something. `offset` in ns makes wall-clock time of monotonic time.
    """

    def __init__(self, stations: Iterable[str], offset: int) -> None:
        self.offset = offset
        self.step = -1
        """The number of the step that is recorded, counted modulo 2**32."""
        self.numbers: dict[str, int] = {}
        self._topics: list[Topic] = []
        for topic in (*OWN, *(Topic(IN + station, TEXT) for station in stations)):
            self.channel(topic)
        self._rows = bytearray()
        self._rows_us = self._rows_step = 0
        self._begin()

    def _begin(self) -> None:
        self._data = bytearray()
        self._indexes: dict[int, bytearray] = {}
        self._first: int | None = None
        self._last = 0
        self._began = self.step

    def channel(self, topic: Topic) -> int:
        """The number of a topic, from now on."""
        if topic.name not in self.numbers:
            self._topics.append(topic)
            self.numbers[topic.name] = len(self._topics)
        return self.numbers[topic.name]

    @property
    def size(self) -> int:
        """Of what was recorded since the last page, in bytes, before it is compressed."""
        return len(self._data) + len(self._rows)

    def frames(self, frames: Sequence[Frame], us: int, flags: int = 0) -> None:
        """Frames that the machine was told together, or sent (`SENT`), at monotonic `us`."""
        rows, step = self._rows, self.step % STEPS
        if rows and (us - self._rows_us >= SPAN or len(rows) >= ROWS * ROW.size):
            self._close_rows()
            rows = self._rows
        if not rows:
            self._rows_us, self._rows_step = us, step
        if not frames:
            self._put(1, us, step, _CDR.pack(_LITTLE_ENDIAN, 0))
        elapsed = us - self._rows_us
        pack = ROW.pack
        for frame in frames:
            data = frame.data
            number = frame.identifier | EXTENDED if frame.extended else frame.identifier
            rows += pack(number, len(data), flags, 0, data, elapsed, step)
            for place in range(8, len(data), 8):
                rest = data[place : place + 8]
                rows += pack(number, len(rest), flags | CONTINUED, 0, rest, elapsed, step)

    def add(self, channel: int, us: int, data: bytes) -> None:
        """A message of any other topic."""
        self._put(channel, us, self.step % STEPS, data)

    def _close_rows(self) -> None:
        rows, self._rows = self._rows, bytearray()
        self._put(1, self._rows_us, self._rows_step, _CDR.pack(_LITTLE_ENDIAN, len(rows) // ROW.size) + rows)

    def _put(self, channel: int, us: int, step: int, data: bytes | bytearray) -> None:
        now = us * 1000
        stamp = now + self.offset
        place = self._data
        index = self._indexes.get(channel)
        if index is None:
            index = self._indexes[channel] = bytearray()
        index += _INDEX.pack(stamp, len(place))
        place += MESSAGE_HEAD.pack(MESSAGE, _MESSAGE_SIZE + len(data), channel, step, stamp, now)
        place += data
        if self._first is None or stamp < self._first:
            self._first = stamp
        if stamp > self._last:
            self._last = stamp

    def take(self) -> Page | None:
        """What was recorded since the last page; None if that is nothing. Only between two steps."""
        if self._rows:
            self._close_rows()
        if self._first is None:
            return None
        steps = self.step - self._began
        page = Page(tuple(self._topics), self._data, self._indexes, self._first, self._last, steps)
        self._begin()
        return page


def text(data: bytes) -> bytes:
    """The message of a port's bytes."""
    return msgspec.json.encode({"text": data.decode("latin-1")})
