"""Recordings as messages with their values, one by one. Millions at once: `assembly` and what builds on it.

```python
for message in timonel.open_recording("log.candump"):
    message.time, message.source, message.name, message.fields      # the values as a dict
    message.value                                                   # and as attributes
```
Fast packets are put together as the live path does it; a frame without a time comes `PACE` after the one before.
"""

from collections.abc import Iterable, Iterator
from enum import Enum
from importlib.util import find_spec
from itertools import chain
from json import JSONEncoder
from json.encoder import encode_basestring
from pathlib import Path
from typing import Any, Self

import msgspec

from timonel.nmea2000.catalogue import Definition, Finder, finder, only
from timonel.nmea2000.fastpacket import FastPacketCounters, Reassembler
from timonel.nmea2000.identifier import split
from timonel.nmea2000.schedule import is_fast
from timonel.recording.formats import LogReader, open_log
from timonel.recording.lines import LogFrame, Record, Unreadable
from timonel.vehicles.rover.declaration import RoverFrame
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.segments import SINGLE, Joiner

PACE = 1_000_000
"""ns from frame to frame where a recording has no times."""

_json = JSONEncoder(ensure_ascii=False, check_circular=False).encode

FAST = ("candump", "pcap", "MCAP")
"""The formats of which many frames are read at a time."""

LONG = 1 << 20
"""Bytes of a recording that are as much work as it is to begin reading many frames at a time."""

MOST_IDENTIFIERS = 4096

_MAX_AGE, _MAX_GAP = 250_000, 100_000  # us, the Reassembler's own limits


# The encoder's own way costs ten times as much for a single value.
def as_json(value: Any) -> str:
    """JSON as it is usually written, with a blank behind each comma and colon."""
    kind = type(value)
    if kind is float or kind is int:
        return repr(value)
    return encode_basestring(value) if kind is str else _json(value)


class Message(msgspec.Struct, frozen=True, gc=False):
    """A message of an NMEA 2000 bus. `time` is in unix seconds, None if its recording does not tell.

    `definition` is canboat's, None for a PGN that it does not know.
    """

    time: float | None
    priority: int
    source: int
    destination: int
    pgn: int
    data: bytes
    definition: Definition | None

    def __repr__(self) -> str:
        return f"<{self.line()}>"

    @property
    def name(self) -> str | None:
        """canboat's id, as `vesselHeading`."""
        return self.definition.id if self.definition else None

    @property
    def value(self) -> Any:
        """The values as attributes, None where there is none; None if the PGN is not known."""
        definition = self.definition
        return None if definition is None else definition.decode(self.data)

    @property
    def fields(self) -> dict[str, Any]:
        """The values by canboat's ids, SI; what is not available is left out, bytes are in hex."""
        return self.definition.as_dict(self.data) if self.definition else {}

    def line(self, labels: bool = True) -> str:
        """One line of JSON; without `labels` lookups are numbers."""
        return (
            f'{{"time": {written(self.time)}, "priority": {self.priority}, "source": {self.source}, '
            f'"destination": {self.destination}, {self.head}{self.data.hex().upper()}{self._tail(labels)}'
        )

    @property
    def head(self) -> str:
        return f'"pgn": {self.pgn}, "name": {as_json(self.name)}, "data": "'

    def _tail(self, labels: bool) -> str:
        return f'", "fields": {as_json(self.definition.as_dict(self.data, labels))}}}' if self.definition else '"}'


class OwnMessage(msgspec.Struct, frozen=True, gc=False):
    """A frame of a rover, segmented ones whole; `value` is None where no such frame is declared."""

    time: float | None
    frame: int
    data: bytes
    value: RoverFrame | None

    def __repr__(self) -> str:
        return f"<{self.line()}>"

    @property
    def name(self) -> str | None:
        """What the frame is declared as, as `MotorCurrentRight`."""
        return type(self.value).__name__ if self.value is not None else None

    @property
    def fields(self) -> dict[str, Any]:
        """The values by name, SI, derived ones too; what is not available is left out."""
        return _fields(self.value, True)

    def line(self, labels: bool = True) -> str:
        """One line of JSON; without `labels` codes are numbers."""
        tail = f'", "fields": {as_json(_fields(self.value, labels))}}}' if self.value is not None else '"}'
        return (
            f'{{"time": {written(self.time)}, "frame": {self.frame}, "name": {as_json(self.name)}, '
            f'"data": "{self.data.hex().upper()}{tail}'
        )


def written(time: float | None) -> str:
    """Unix seconds, to the microsecond."""
    return "null" if time is None else f"{time:.6f}"


def _fields(value: RoverFrame | None, labels: bool) -> dict[str, Any]:
    if value is None:
        return {}
    names = [*value.__struct_fields__, *type(value).DERIVED]
    values = ((name, getattr(value, name)) for name in names)
    return {name: _plain(found, labels) for name, found in values if found is not None}


def _plain(value: Any, labels: bool) -> Any:
    if isinstance(value, Enum):
        return value.name if labels else value.value
    return value


Address = tuple[int, int, int, int, bool, Definition | None, Finder | None]
"""Priority, PGN, source, destination, whether it is a fast packet; its definition, or what tells that of a payload."""


class Addresses(dict[int, Address]):
    """What there is to know of extended identifiers; bits above the 29 are not looked at.

    Asked for each frame, of which a bus has a few hundred kinds: a subscript takes half as long as `lru_cache`, and a
    plain tuple is taken apart in a third of the time of a named one.
    """

    def __missing__(self, identifier: int) -> Address:
        if len(self) >= MOST_IDENTIFIERS:
            self.clear()
        priority, pgn, source, destination = split(identifier)
        definition = only(pgn)
        find = None if definition else finder(pgn)
        self[identifier] = address = priority, pgn, source, destination, is_fast(pgn), definition, find
        return address


ADDRESSES = Addresses()


def made(time: float | None, identifier: int, data: bytes) -> Message:
    """The message that was sent with an extended identifier."""
    priority, pgn, source, destination, _, definition, find = ADDRESSES[identifier]
    return Message(time, priority, source, destination, pgn, data, find(data) if find else definition)


class Decoder:
    """Takes the frames of a recording one after the other; of standard identifiers by a rover's `protocol`."""

    def __init__(self, protocol: Protocol | None = None) -> None:
        self.protocol = protocol or Protocol()
        self._reassembler = Reassembler(_MAX_AGE, _MAX_GAP)
        self._joiner = Joiner({number: frame.size for number, frame in self.protocol.declarations.items()})
        self._stamp: float | None = None
        self._now = 0
        self._row = -1

    @property
    def counters(self) -> FastPacketCounters:
        """What became of the fast packets."""
        return self._reassembler.counters

    # Once a frame: what only fast packets and rovers need, the time in us, is not made for others.
    def receive(self, frame: LogFrame) -> Message | OwnMessage | None:
        """The message that the frame is, or completes."""
        stamp, data = frame.stamp, frame.data
        self._row += 1
        if stamp is None:
            self._now = self._time() + PACE // 1000
        self._stamp = stamp
        if not frame.extended:
            return self.own(stamp, frame.identifier, data, self._row * PACE if stamp is None else self._time() * 1000)
        priority, pgn, source, destination, fast, definition, find = ADDRESSES[frame.identifier]
        if fast and not frame.whole:
            now = self._now if stamp is None else round(stamp * 1e6)
            payload = self._reassembler.receive(frame.identifier, data, now)
            if payload is None:
                return None
            data = payload
        return Message(stamp, priority, source, destination, pgn, data, find(data) if find else definition)

    def _time(self) -> int:
        """us of the frame that came last."""
        return self._now if self._stamp is None else round(self._stamp * 1e6)

    def own(self, time: float | None, number: int, data: bytes, now: int) -> OwnMessage | None:
        """The frame of a rover that this is, or completes; `now` in ns."""
        declared = self.protocol.declaration(number)
        if declared is not None and declared.SEGMENTED and declared.size > SINGLE and len(data) <= SINGLE:
            joined = self._joiner.receive(number, data, now / 1e9)
            if joined is None:
                return None
            data = joined
        return OwnMessage(time, number, data, self.protocol.decode(number, data))


class Recording:
    """The messages of a recording: iterate over it once. `log` tells its format, times, and what could not be read.

    Of a long one frames are read `many` at a time: then `log` and `counters` may be some thousand frames ahead.
    """

    def __init__(self, log: LogReader, protocol: Protocol | None = None, many: bool = False) -> None:
        self.log = log
        self._many = many
        self._decoder = Decoder(protocol)
        self._counters = self._decoder.counters

    @property
    def counters(self) -> FastPacketCounters:
        """What became of the fast packets so far."""
        return self._counters

    def __iter__(self) -> Iterator[Message | OwnMessage]:
        return self._messages() if self._many else self._one_by_one()

    def _messages(self) -> Iterator[Message | OwnMessage]:
        from timonel.recording.fast_decoded import Messages

        messages = Messages(self.log, self._decoder)
        self._counters = messages.counters
        return iter(messages)

    def _one_by_one(self) -> Iterator[Message | OwnMessage]:
        log, receive, dated = self.log, self._decoder.receive, self.log.dated
        with log:
            for record in chain.from_iterable(self._portions()):
                if isinstance(record, LogFrame):
                    log.frames += 1
                    message = receive(record)
                    if message is not None:
                        yield message if dated else msgspec.structs.replace(message, time=None)
                elif isinstance(record, Unreadable):
                    log.refuse(record)

    def _portions(self) -> Iterator[Iterable[Record | Unreadable]]:
        for portion in self.log.portions():
            yield self.log.stream.receive(portion)
        yield self.log.stream.finish()
        yield self.log.damage()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.log.close()


def open_recording(path: str | Path, protocol: Protocol | None = None, strict: bool = False) -> Recording:
    """Open a recording of a bus or a rover in any format; `-` is standard input.

    A rover's frames are decoded by `protocol`. `strict` and the errors are those of `recording.open_log`.
    """
    log = open_log(path, strict)
    return Recording(log, protocol, not strict and _is_long(log) and _has_numpy())


def _is_long(log: LogReader) -> bool:
    """Whether it is worth to import what reads many frames at a time; standard input is read as it comes."""
    return log.format in FAST and log.size is not None and log.size >= LONG


def _has_numpy() -> bool:
    return find_spec("numpy") is not None
