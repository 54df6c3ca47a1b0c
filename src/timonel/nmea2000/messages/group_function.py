"""PGN 126208: ask for a message, command, read or write single fields of one, and what came of it.

A field is named by its number in the target's layout, counted from 1 with reserved fields, and its value has
the field's size, filled up with zeros to whole bytes. A proprietary target names manufacturer and industry too.

```python
command(HeadingTrackControl, steering_mode=SteeringMode.HEADING_CONTROL, heading_to_steer_course=0.7941)
message_of(HeadingTrackControl, received.parameters).steering_mode
```
"""

from collections.abc import Sequence
from typing import Annotated, Any

import msgspec

from timonel.core.fields import (
    U8,
    U16,
    U32,
    Bits,
    Fixed,
    Lookup,
    Match,
    Packed,
    Repeat,
    Reserved,
    StringLau,
    Variable,
)
from timonel.core.message import Message, MessageMeta, Slot
from timonel.errors import EncodeError
from timonel.nmea2000.lookups import (
    GroupFunction,
    IndustryCode,
    ManufacturerCode,
    NewPriority,
    ParameterError,
    PgnErrorCode,
    TransmissionIntervalError,
)
from timonel.nmea2000.messages import (
    ais,
    alerts,
    environment,
    garmin,
    maretron,
    navico,
    navigation,
    network,
    raymarine,
    steering,
)


def declared(*modules: Any) -> dict[int, list[type[Message]]]:
    """The messages of some modules by their PGN, in the order they stand there."""
    found: dict[int, list[type[Message]]] = {}
    for module in modules:
        for item in vars(module).values():
            if isinstance(item, MessageMeta) and item.PGN is not None and item.__module__ == module.__name__:
                found.setdefault(item.PGN, []).append(item)  # type: ignore[arg-type]
    return found


TARGETS = declared(steering, navigation, environment, network, alerts, ais, raymarine, navico, garmin, maretron)


def proprietary(pgn: int) -> bool:
    """Whether a PGN means something else for every manufacturer."""
    return pgn in (0xEF00, 0x1EF00) or 0xFF00 <= pgn <= 0xFFFF or 0x1FF00 <= pgn <= 0x1FFFF


class Parameter(msgspec.Struct, frozen=True, gc=False):
    """One field of the target by its number, and its raw value. Of an unknown target: all that is left."""

    index: int
    value: bytes


class Parameters(Variable, frozen=True):
    """A tuple of `Parameter`s of the target in the field `pgn`, as many as the earlier field `count` says."""

    count: str

    @property
    def counter(self) -> str:
        return self.count

    @property
    def context(self) -> tuple[str, ...]:
        return ("pgn", self.count)

    def read(self, data: bytes, at: int, *context: Any) -> tuple[tuple[Parameter, ...], int]:
        pgn, wanted = context
        found: list[Parameter] = []
        while len(found) < (wanted or 0) and at < len(data):
            size = _size(pgn, found, data, at)
            end = len(data) if size is None else at + 1 + size
            found.append(Parameter(data[at], data[at + 1 : end]))
            at = end
        return tuple(found), at

    def write(self, value: Sequence[Parameter], *context: Any) -> bytes:
        return b"".join(bytes((parameter.index,)) + parameter.value for parameter in value)


class Proprietary(Message):
    """Whose target it is; stands in a read or write of a proprietary PGN."""

    manufacturer_code: Annotated[ManufacturerCode | None, Lookup(11, ManufacturerCode)]
    reserved: Annotated[None, Reserved(2)] = None
    industry_code: Annotated[IndustryCode | None, Lookup(3, IndustryCode)]


class WhenProprietary(Variable, frozen=True):
    """A `Proprietary` if the target in the field `pgn` is one, else nothing."""

    @property
    def context(self) -> tuple[str, ...]:
        return ("pgn",)

    def read(self, data: bytes, at: int, *context: Any) -> tuple[Proprietary | None, int]:
        return Proprietary.read(data, at) if proprietary(context[0]) else (None, at)

    def write(self, value: Proprietary | None, *context: Any) -> bytes:
        if proprietary(context[0]) != (value is not None):
            raise EncodeError(f"owner: {value} does not go with PGN {context[0]}")
        return value.encode() if value else b""


class NmeaRequestGroupFunction(Message, pgn=126208):
    """PGN 126208: asks for a PGN, or for another interval of it.

    Fast packet, priority 3, on event. Layout: canboat `nmeaRequestGroupFunction`.

    An interval of 0 turns it off, None leaves it as it is.
    """

    function_code: Annotated[GroupFunction, Match(8)] = GroupFunction.REQUEST
    pgn: Annotated[int, Bits(24)]
    transmission_interval: Annotated[float | None, U32(0.001, "s")] = None
    transmission_interval_offset: Annotated[float | None, U16(0.01, "s")] = None
    number_of_parameters: Annotated[int | None, U8()] = None
    parameters: Annotated[tuple[Parameter, ...], Parameters("number_of_parameters")] = ()


class NmeaCommandGroupFunction(Message, pgn=126208):
    """PGN 126208: commands fields of a PGN to have these values.

    Fast packet, priority 3, on event. Layout: canboat `nmeaCommandGroupFunction`.
    """

    function_code: Annotated[GroupFunction, Match(8)] = GroupFunction.COMMAND
    pgn: Annotated[int, Bits(24)]
    priority: Annotated[NewPriority | None, Lookup(4, NewPriority)] = NewPriority.LEAVE_UNCHANGED
    reserved: Annotated[None, Reserved(4)] = None
    number_of_parameters: Annotated[int | None, U8()] = None
    parameters: Annotated[tuple[Parameter, ...], Parameters("number_of_parameters")] = ()


class NmeaAcknowledgeGroupFunction(Message, pgn=126208):
    """PGN 126208: what came of a request or a command.

    Fast packet, priority 3, on event. Layout: canboat `nmeaAcknowledgeGroupFunction`.
    """

    function_code: Annotated[GroupFunction, Match(8)] = GroupFunction.ACKNOWLEDGE
    pgn: Annotated[int, Bits(24)]
    pgn_error_code: Annotated[PgnErrorCode | None, Lookup(4, PgnErrorCode)]
    transmission_interval_priority_error_code: Annotated[
        TransmissionIntervalError | None, Lookup(4, TransmissionIntervalError)
    ]
    number_of_parameters: Annotated[int | None, U8()] = None
    parameters: Annotated[
        tuple[ParameterError | None, ...],
        Packed(Lookup(4, ParameterError), "number_of_parameters"),
    ] = ()


class NmeaReadFieldsGroupFunction(Message, pgn=126208):
    """PGN 126208: asks for fields of the PGN whose selected fields have these values.

    Fast packet, priority 3, on event. Layout: canboat `nmeaReadFieldsGroupFunction`.
    """

    function_code: Annotated[GroupFunction, Match(8)] = GroupFunction.READ_FIELDS
    pgn: Annotated[int, Bits(24)]
    owner: Annotated[Proprietary | None, WhenProprietary()] = None
    unique_id: Annotated[int | None, U8()]
    number_of_selection_pairs: Annotated[int | None, U8()] = None
    number_of_parameters: Annotated[int | None, U8()] = None
    selection: Annotated[tuple[Parameter, ...], Parameters("number_of_selection_pairs")] = ()
    parameters: Annotated[tuple[int, ...], Packed(Bits(8), "number_of_parameters")] = ()


class NmeaReadFieldsReplyGroupFunction(Message, pgn=126208):
    """PGN 126208: the fields that were asked for.

    Fast packet, priority 3, on event. Layout: canboat `nmeaReadFieldsReplyGroupFunction`.
    """

    function_code: Annotated[GroupFunction, Match(8)] = GroupFunction.READ_FIELDS_REPLY
    pgn: Annotated[int, Bits(24)]
    owner: Annotated[Proprietary | None, WhenProprietary()] = None
    unique_id: Annotated[int | None, U8()]
    number_of_selection_pairs: Annotated[int | None, U8()] = None
    number_of_parameters: Annotated[int | None, U8()] = None
    selection: Annotated[tuple[Parameter, ...], Parameters("number_of_selection_pairs")] = ()
    parameters: Annotated[tuple[Parameter, ...], Parameters("number_of_parameters")] = ()


class NmeaWriteFieldsGroupFunction(Message, pgn=126208):
    """PGN 126208: writes fields of the PGN whose selected fields have these values.

    Fast packet, priority 3, on event. Layout: canboat `nmeaWriteFieldsGroupFunction`.
    """

    function_code: Annotated[GroupFunction, Match(8)] = GroupFunction.WRITE_FIELDS
    pgn: Annotated[int, Bits(24)]
    owner: Annotated[Proprietary | None, WhenProprietary()] = None
    unique_id: Annotated[int | None, U8()]
    number_of_selection_pairs: Annotated[int | None, U8()] = None
    number_of_parameters: Annotated[int | None, U8()] = None
    selection: Annotated[tuple[Parameter, ...], Parameters("number_of_selection_pairs")] = ()
    parameters: Annotated[tuple[Parameter, ...], Parameters("number_of_parameters")] = ()


class NmeaWriteFieldsReplyGroupFunction(Message, pgn=126208):
    """PGN 126208: the fields as they are after a write.

    Fast packet, priority 3, on event. Layout: canboat `nmeaWriteFieldsReplyGroupFunction`.
    """

    function_code: Annotated[GroupFunction, Match(8)] = GroupFunction.WRITE_FIELDS_REPLY
    pgn: Annotated[int, Bits(24)]
    owner: Annotated[Proprietary | None, WhenProprietary()] = None
    unique_id: Annotated[int | None, U8()]
    number_of_selection_pairs: Annotated[int | None, U8()] = None
    number_of_parameters: Annotated[int | None, U8()] = None
    selection: Annotated[tuple[Parameter, ...], Parameters("number_of_selection_pairs")] = ()
    parameters: Annotated[tuple[Parameter, ...], Parameters("number_of_parameters")] = ()


def command(target: type[Message], **values: Any) -> NmeaCommandGroupFunction:
    """The command to set these fields of `target`. Raises EncodeError for a value that does not fit."""
    assert target.PGN is not None
    return NmeaCommandGroupFunction(pgn=target.PGN, parameters=parameters_of(target, **values))


def parameters_of(target: type[Message], **values: Any) -> tuple[Parameter, ...]:
    """Fields of `target` as parameters, and before them the constants that say which target it is."""
    message = msgspec.structs.replace(target.decode(b""), **values)
    payload = int.from_bytes(message.encode(), "little")
    return tuple(
        Parameter(index, (payload >> slot.offset & slot.field.ones).to_bytes(-(-slot.field.bits // 8), "little"))
        for index, slot in enumerate(target.layout, 1)
        if isinstance(slot.field, Fixed) and slot.offset is not None
        if slot.name in values or isinstance(slot.field, Match)
    )


def message_of(target: type[Message], parameters: Sequence[Parameter]) -> Message:
    """The target with the fields that `parameters` set; all others are not available."""
    payload = bytearray(target.decode(b"").encode())
    for parameter in parameters:
        slot = _slot(target, parameter.index)
        if slot and slot.offset is not None and isinstance(slot.field, Fixed):
            bits = int.from_bytes(payload, "little") & ~(slot.field.ones << slot.offset)
            raw = int.from_bytes(parameter.value, "little") & slot.field.ones
            payload[:] = (bits | raw << slot.offset).to_bytes(len(payload), "little")
    return target.decode(bytes(payload))


def _slot(target: type[Message], index: int) -> Slot | None:
    """The field with this number; a group's fields follow those before it."""
    slots: list[Slot] = []
    for slot in target.layout:
        slots += slot.field.group.layout if isinstance(slot.field, Repeat) else [slot]
    return slots[index - 1] if 1 <= index <= len(slots) else None


def _size(pgn: int, before: Sequence[Parameter], data: bytes, at: int) -> int | None:
    """How many bytes the value of the parameter at `at` has, if all targets that it can be agree."""
    targets = [target for target in TARGETS.get(pgn, ()) if _fits(target, before)]
    if proprietary(pgn) and data[at] <= len(Proprietary.layout):
        targets = [Proprietary]
    slots = {_slot(target, data[at]) for target in targets}
    sizes = {_length(slot, data[at + 1 : at + 2]) if slot else None for slot in slots}
    return sizes.pop() if len(sizes) == 1 else None


def _fits(target: type[Message], parameters: Sequence[Parameter]) -> bool:
    slots = ((_slot(target, parameter.index), parameter.value) for parameter in parameters)
    return all(
        int.from_bytes(value, "little") == slot.default
        for slot, value in slots
        if slot and isinstance(slot.field, Match)
    )


def _length(slot: Slot, first: bytes) -> int | None:
    if isinstance(slot.field, StringLau):
        return max(first[0], 2) if first else 0
    return None if slot.length is None else -(-slot.length // 8)
