"""Declared messages in clear beside the frames they came in, for whoever opens a recording in a viewer.

`{"heading": 3.1416, "reference": "MAGNETIC"}` on `decoded/VesselHeading`, in the declaration's units; what is not
available is null. A fast packet stands at the time of its last frame.
"""

from collections.abc import Callable, Sequence
from enum import Enum
from functools import cache
from typing import Protocol as Shape

import msgspec

from timonel.core.frame import Frame
from timonel.gateway.configuration import Configuration
from timonel.gateway.moment import seconds
from timonel.nmea2000 import registry
from timonel.nmea2000.fastpacket import Reassembler
from timonel.nmea2000.identifier import split
from timonel.recording.flight import DECODED
from timonel.recording.flight_tape import Tape, Topic, json_schema
from timonel.vehicles.boat.settings import BoatSettings
from timonel.vehicles.rover.protocol import Protocol

Read = Callable[[Frame, float], msgspec.Struct | None]
"""The message that a frame completes at a time in s; None for none, or none that is declared."""


class Interpreter(Shape):
    """Writes messages in clear."""

    def receive(self, frames: Sequence[Frame], us: int, tape: Tape) -> None:
        """Add what frames that came at `us` say."""


class Clear:
    """Writes what `read` makes of frames."""

    def __init__(self, read: Read) -> None:
        self._read = read

    def receive(self, frames: Sequence[Frame], us: int, tape: Tape) -> None:
        """Add what frames that came at `us` say."""
        for frame in frames:
            message = self._read(frame, seconds(us))
            if message is not None:
                tape.add(tape.channel(_topic(type(message))), us, _message(message))


def interpreter(configuration: Configuration) -> Interpreter:
    """Of the messages that a vehicle understands."""
    match configuration.vehicle:
        case BoatSettings():
            return Clear(_boat_reader())
        case _:
            return Clear(_rover_reader(configuration.protocol or Protocol()))


def _boat_reader() -> Read:
    reassembler = Reassembler()

    def read(frame: Frame, now: float) -> msgspec.Struct | None:
        pgn = split(frame.identifier).pgn
        fast = registry.is_fast(pgn)
        data = reassembler.receive(frame.identifier, frame.data, now) if fast else frame.data
        return None if data is None else registry.decode(pgn, data)

    return read


def _rover_reader(protocol: Protocol) -> Read:
    return lambda frame, now: protocol.decode(frame.identifier, frame.data)


@cache
def _topic(kind: type[msgspec.Struct]) -> Topic:
    return Topic(DECODED + kind.__name__, json_schema(f"timonel.{kind.__name__}"))


def _message(message: msgspec.Struct) -> bytes:
    return msgspec.json.encode({name: _clear(getattr(message, name)) for name in message.__struct_fields__})


def _clear(value: object) -> object:
    match value:
        case Enum():
            return value.name
        case bytes():
            return value.hex()
        case _:
            return value
