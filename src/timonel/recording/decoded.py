"""Recordings as messages with their values, one by one. Millions at once: `assembly` and what builds on it.

```python
for message in timonel.open_recording("log.candump"):
    message.time, message.source, message.name, message.fields      # the values as a dict
    message.value                                                   # and as attributes
```
Fast packets are put together as the live path does it; a frame without a time comes `PACE` after the one before.
"""

from collections.abc import Iterator
from enum import Enum
from json import JSONEncoder
from json.encoder import encode_basestring
from pathlib import Path
from typing import Any, Self

import msgspec

from timonel.nmea2000.catalogue import Definition, find
from timonel.nmea2000.fastpacket import FastPacketCounters, Reassembler
from timonel.nmea2000.identifier import split
from timonel.nmea2000.schedule import is_fast
from timonel.recording.formats import LogReader, open_log
from timonel.recording.lines import LogFrame
from timonel.vehicles.rover.declaration import RoverFrame
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.segments import SINGLE, Joiner

PACE = 1_000_000
"""ns from frame to frame where a recording has no times."""

_json = JSONEncoder(ensure_ascii=False, check_circular=False).encode

_MAX_AGE, _MAX_GAP = 250_000_000, 100_000_000  # ns, the Reassembler's own limits


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
        return self.definition.decode(self.data) if self.definition else None

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


class Decoder:
    """Takes the frames of a recording one after the other; of standard identifiers by a rover's `protocol`."""

    def __init__(self, protocol: Protocol | None = None) -> None:
        self.protocol = protocol or Protocol()
        self._reassembler = Reassembler(_MAX_AGE, _MAX_GAP)
        self._joiner = Joiner({number: frame.size for number, frame in self.protocol.declarations.items()})
        self._now = 0
        self._row = -1

    @property
    def counters(self) -> FastPacketCounters:
        """What became of the fast packets."""
        return self._reassembler.counters

    def receive(self, frame: LogFrame) -> Message | OwnMessage | None:
        """The message that the frame is, or completes."""
        stamp, self._row = frame.stamp, self._row + 1
        self._now = self._now + PACE if stamp is None else round(stamp * 1e6) * 1000
        if not frame.extended:
            return self._own(frame)
        priority, pgn, source, destination = split(frame.identifier)
        data: bytes | None = frame.data
        if not frame.whole and is_fast(pgn):
            data = self._reassembler.receive(frame.identifier, frame.data, self._now)
        if data is None:
            return None
        return Message(stamp, priority, source, destination, pgn, data, find(pgn, data))

    def _own(self, frame: LogFrame) -> OwnMessage | None:
        """The frame of a rover that this is, or completes."""
        number, data = frame.identifier, frame.data
        declared = self.protocol.declaration(number)
        if declared is not None and declared.SEGMENTED and declared.size > SINGLE and len(data) <= SINGLE:
            joined = self._joiner.receive(number, data, (self._row * PACE if frame.stamp is None else self._now) / 1e9)
            if joined is None:
                return None
            data = joined
        return OwnMessage(frame.stamp, number, data, self.protocol.decode(number, data))


class Recording:
    """The messages of a recording: iterate over it once. `log` tells its format, times, and what could not be read."""

    def __init__(self, log: LogReader, protocol: Protocol | None = None) -> None:
        self.log = log
        self._decoder = Decoder(protocol)

    @property
    def counters(self) -> FastPacketCounters:
        """What became of the fast packets so far."""
        return self._decoder.counters

    def __iter__(self) -> Iterator[Message | OwnMessage]:
        for frame in self.log:
            message = self._decoder.receive(frame)
            if message is not None:
                yield message if self.log.dated else msgspec.structs.replace(message, time=None)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.log.close()


def open_recording(path: str | Path, protocol: Protocol | None = None, strict: bool = False) -> Recording:
    """Open a recording of a bus or a rover in any format; `-` is standard input.

    A rover's frames are decoded by `protocol`. `strict` and the errors are those of `recording.open_log`.
    """
    return Recording(open_log(path, strict), protocol)
