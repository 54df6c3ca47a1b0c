"""What is recorded between two flushes, put together as one chunk: told the time, without any I/O.

What runs once a frame or once an answer is written for speed here: it is the only part of the recorder that the
vehicle's stations wait for.
"""

import struct
from collections.abc import Iterable, Sequence

import msgspec

from timonel.core.frame import Frame
from timonel.recording.flight import BUS, EVENTS, IN, MESSAGE, MESSAGE_HEAD, OUT, PORTS, RECORD, RECORDER, TIMER
from timonel.recording.flight_bus import (
    CONTINUED,
    EXTENDED,
    LONGEST_PAUSE,
    MOST_STEPS,
    PACKED,
    SCHEMA,
    SCHEMA_NAME,
    message_of,
)

FULL = 1_000_000  # bytes
SPAN = 100_000  # us of frames that one message of `bus` holds
STEPS = 1 << 32
LATEST = 1 << 64
_encode = msgspec.json.Encoder().encode
BUS_NUMBER = 1
_MESSAGE_SIZE = MESSAGE_HEAD.size - RECORD.size
_pack_frame, _pack_head = PACKED.pack, MESSAGE_HEAD.pack
_pack_entry = struct.Struct("<QQ").pack  # of a message index
_NO_FRAMES = bytes(message_of(b""))


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


FRAMES_SCHEMA = Schema(SCHEMA_NAME, "ros2msg", SCHEMA, "cdr")
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
        """The number of the step that is recorded, from 0; none before the first."""
        self.full = False
        """Whether what was recorded should be taken before its time."""
        self.numbers: dict[str, int] = {}
        self._topics: list[Topic] = []
        for topic in (*OWN, *(Topic(IN + station, TEXT) for station in stations)):
            self.channel(topic)
        self._frames = bytearray()  # of the message of `bus` that is on, as `PACKED` has them
        self._frames_us = self._frames_step = 0  # when it began
        self._last_us = self._last_step = 0  # of its last frame
        self._begin()

    def _begin(self) -> None:
        self.full = False
        self._data = bytearray()
        self._indexes: dict[int, bytearray] = {}
        self._first = LATEST
        self._last = 0
        self._began = self.step

    def channel(self, topic: Topic) -> int:
        """The number of a topic, from now on."""
        if topic.name not in self.numbers:
            self._topics.append(topic)
            self.numbers[topic.name] = len(self._topics)
        return self.numbers[topic.name]

    def frames(self, frames: Sequence[Frame], us: int, flags: int = 0) -> None:
        """Frames that the machine was told together, or sent (`SENT`), at monotonic `us`."""
        if not frames:
            self.add(BUS_NUMBER, us, _NO_FRAMES)
            return
        since, steps = us - self._last_us, self.step - self._last_step
        packed = self._frames
        if not packed or us - self._frames_us >= SPAN or since > LONGEST_PAUSE or steps > MOST_STEPS:
            packed = self._begin_frames(us)
            since = steps = 0
        self._last_us, self._last_step = us, self.step
        for frame in frames:
            data = frame.data
            number = frame.identifier | EXTENDED if frame.extended else frame.identifier
            packed += _pack_frame(number, data, since, steps, len(data), flags)
            since = steps = 0
            if len(data) > 8:
                self._continue(number, data, flags | CONTINUED)

    def _continue(self, number: int, data: bytes, flags: int) -> None:
        """The rest of a frame of more than eight bytes."""
        for place in range(8, len(data), 8):
            rest = data[place : place + 8]
            self._frames += _pack_frame(number, rest, 0, 0, len(rest), flags)

    def _begin_frames(self, us: int) -> bytearray:
        if self._frames:
            self._close_frames()
        self._frames_us, self._frames_step = us, self.step % STEPS
        return self._frames

    def _close_frames(self) -> None:
        packed, self._frames = self._frames, bytearray()
        self.add(BUS_NUMBER, self._frames_us, message_of(packed), self._frames_step)

    def add(self, channel: int, us: int, data: bytes | bytearray, step: int | None = None) -> None:
        """A message of a topic, by its number; of this step if no other is said."""
        now = us * 1000
        stamp = now + self.offset
        messages = self._data
        index = self._indexes.get(channel)
        if index is None:
            index = self._indexes[channel] = bytearray()
        index += _pack_entry(stamp, len(messages))
        number = self.step % STEPS if step is None else step
        messages += _pack_head(MESSAGE, _MESSAGE_SIZE + len(data), channel, number, stamp, now)
        messages += data
        if len(messages) > FULL:
            self.full = True
        if stamp > self._last:
            self._last = stamp
        if stamp < self._first:
            self._first = stamp

    def take(self) -> Page | None:
        """What was recorded since the last page; None if that is nothing. Only between two steps."""
        if self._frames:
            self._close_frames()
        if not self._data:
            return None
        steps = self.step - self._began
        page = Page(tuple(self._topics), self._data, self._indexes, self._first, self._last, steps)
        self._begin()
        return page


class Text(msgspec.Struct, gc=False):
    """The bytes of a port, each a character."""

    text: str


def text(data: bytes) -> bytes:
    """The message of a port's bytes."""
    return _encode(Text(data.decode("latin-1")))
