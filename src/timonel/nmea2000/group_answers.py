"""What a node answers to group functions (PGN 126208): requests, commands, reads and writes of what it has.

asked for                                        answer
a PGN that we do not have                        acknowledgement, PGN not supported
a request whose parameters are ours              the PGN itself
another interval                                 of the heartbeat 1..60 s; of anything else "not supported"
a command or write of fields that may be set     they are set, all of them or none
  of others                                      access denied; numbers that the PGN has not: invalid field
a read                                           the fields

What comes to everybody gets no acknowledgement. Source: NMEA 2000's complex request and command group functions
as the Arduino NMEA 2000 library (ttlappalainen) and canboat's `nmea...GroupFunction` have them.
"""

from collections.abc import Callable, Mapping, Sequence

import msgspec

from timonel.core.fields import Fixed, StringLau
from timonel.core.message import Message
from timonel.nmea2000.lookups import NewPriority, ParameterError, PgnErrorCode, TransmissionIntervalError
from timonel.nmea2000.messages.group_function import (
    NmeaAcknowledgeGroupFunction,
    NmeaCommandGroupFunction,
    NmeaReadFieldsGroupFunction,
    NmeaReadFieldsReplyGroupFunction,
    NmeaRequestGroupFunction,
    NmeaWriteFieldsGroupFunction,
    NmeaWriteFieldsReplyGroupFunction,
    Parameter,
)

GroupFunctionMessage = (
    NmeaRequestGroupFunction | NmeaCommandGroupFunction | NmeaReadFieldsGroupFunction | NmeaWriteFieldsGroupFunction
)
UNCHANGED, DEFAULT = 0xFFFFFFFF, 0xFFFFFFFE  # raw intervals
KEPT_PRIORITIES = (NewPriority.LEAVE_UNCHANGED, NewPriority.RESET_TO_DEFAULT, None)
LONGEST_TEXT = 100  # bytes that a string may have when we send it, so that a message of two fits a fast packet
OK = ParameterError.ACKNOWLEDGE
OUT_OF_RANGE = ParameterError.PARAMETER_OUT_OF_RANGE


class Target(msgspec.Struct, frozen=True):
    """A PGN that can be asked for. `message` gives it as it is now; `writable` are the numbers of the fields that
    may be set, `write` sets them. `intervals` are those that it may be sent at, s, `repeat` sets one (None: the usual).
    """

    message: Callable[[], Message]
    writable: frozenset[int] = frozenset()
    write: Callable[[Sequence[Parameter]], None] | None = None
    intervals: tuple[float, float] | None = None
    repeat: Callable[[float | None], None] | None = None


class Answers(msgspec.Struct, frozen=True):
    """What to send back: messages to the one who asked, and the PGN itself if `send` is one."""

    replies: tuple[Message, ...] = ()
    send: int | None = None


def answer(
    asked: GroupFunctionMessage, payload: bytes, targets: Mapping[int, Target], denied: frozenset[int]
) -> Answers:
    """What comes of a group function; `payload` is it as it came. `denied` are PGNs that nobody may command."""
    target = targets.get(asked.pgn)
    if target is None:
        error = PgnErrorCode.ACCESS_DENIED if asked.pgn in denied else PgnErrorCode.PGN_NOT_SUPPORTED
        return _refusal(asked.pgn, error, parameters=(OK,) * len(asked.parameters))
    match asked:
        case NmeaRequestGroupFunction():
            return _requested(asked, payload, target)
        case NmeaCommandGroupFunction():
            return _commanded(asked, target)
        case NmeaReadFieldsGroupFunction():
            return _read(asked, target)
    return _written(asked, target)


def _refusal(
    pgn: int,
    error: PgnErrorCode = PgnErrorCode.ACKNOWLEDGE,
    interval: TransmissionIntervalError = TransmissionIntervalError.ACKNOWLEDGE,
    parameters: tuple[ParameterError, ...] = (),
) -> Answers:
    """An acknowledgement; it says what went wrong, or that nothing did."""
    acknowledgement = NmeaAcknowledgeGroupFunction(
        pgn=pgn, pgn_error_code=error, transmission_interval_priority_error_code=interval, parameters=parameters
    )
    return Answers((acknowledgement,))


def _requested(asked: NmeaRequestGroupFunction, payload: bytes, target: Target) -> Answers:
    values = field_values(target.message())
    errors = tuple(_matches(parameter, values) for parameter in asked.parameters)
    raw = int.from_bytes(payload[4:8].ljust(4, b"\xff"), "little")
    interval = _interval_error(raw, target)
    if any(errors) or interval:
        return _refusal(asked.pgn, interval=interval, parameters=errors)
    if raw == UNCHANGED or target.repeat is None:
        return Answers(send=asked.pgn)
    target.repeat(None if raw == DEFAULT else raw / 1000)
    return msgspec.structs.replace(_refusal(asked.pgn, parameters=errors), send=asked.pgn)


def _interval_error(raw: int, target: Target) -> TransmissionIntervalError:
    if raw in (UNCHANGED, DEFAULT):
        return TransmissionIntervalError.ACKNOWLEDGE
    if target.intervals is None or raw > target.intervals[1] * 1000:
        return TransmissionIntervalError.TRANSMIT_INTERVAL_PRIORITY_NOT_SUPPORTED
    if raw < target.intervals[0] * 1000:
        return TransmissionIntervalError.TRANSMIT_INTERVAL_TOO_LOW
    return TransmissionIntervalError.ACKNOWLEDGE


def _matches(parameter: Parameter, values: Sequence[bytes]) -> ParameterError:
    if not 1 <= parameter.index <= len(values):
        return ParameterError.INVALID_PARAMETER_FIELD
    return OK if parameter.value == values[parameter.index - 1] else OUT_OF_RANGE


def _commanded(asked: NmeaCommandGroupFunction, target: Target) -> Answers:
    priority = TransmissionIntervalError.ACKNOWLEDGE
    if asked.priority not in KEPT_PRIORITIES:
        priority = TransmissionIntervalError.TRANSMIT_INTERVAL_PRIORITY_NOT_SUPPORTED
    errors = _set(asked.parameters, target, allowed=not priority)
    return _refusal(asked.pgn, interval=priority, parameters=errors)


def _set(parameters: Sequence[Parameter], target: Target, allowed: bool = True) -> tuple[ParameterError, ...]:
    """Set the fields if all of them may be, and tell of each how it went."""
    layout = target.message().layout
    errors = tuple(_may_set(parameter, target, len(layout)) for parameter in parameters)
    errors = tuple(
        error or (OK if _fits(layout[parameter.index - 1].field, parameter.value) else OUT_OF_RANGE)
        for error, parameter in zip(errors, parameters, strict=True)
    )
    if allowed and target.write is not None and not any(errors):
        target.write(parameters)
    return errors


def _may_set(parameter: Parameter, target: Target, fields: int) -> ParameterError:
    if not 1 <= parameter.index <= fields:
        return ParameterError.INVALID_PARAMETER_FIELD
    return OK if parameter.index in target.writable else ParameterError.ACCESS_DENIED


def _fits(field: object, value: bytes) -> bool:
    if isinstance(field, StringLau):
        sound = len(value) >= 2 and value[0] == len(value) and value[1] in StringLau.ENCODINGS
        return sound and len(field.write(field.read(value, 0)[0])) <= LONGEST_TEXT
    return isinstance(field, Fixed) and bool(value) and int.from_bytes(value, "little") <= field.ones


def _read(asked: NmeaReadFieldsGroupFunction, target: Target) -> Answers:
    values = field_values(target.message())
    selected = tuple(_matches(parameter, values) for parameter in asked.selection)
    wanted = tuple(
        OK if 1 <= index <= len(values) else ParameterError.INVALID_PARAMETER_FIELD for index in asked.parameters
    )
    if any(selected + wanted):
        return _refusal(asked.pgn, PgnErrorCode.READ_OR_WRITE_NOT_SUPPORTED, parameters=selected + wanted)
    reply = NmeaReadFieldsReplyGroupFunction(
        pgn=asked.pgn,
        unique_id=asked.unique_id,
        selection=asked.selection,
        parameters=tuple(Parameter(index, values[index - 1]) for index in asked.parameters),
    )
    return Answers((reply,))


def _written(asked: NmeaWriteFieldsGroupFunction, target: Target) -> Answers:
    values = field_values(target.message())
    selected = tuple(_matches(parameter, values) for parameter in asked.selection)
    written = _set(asked.parameters, target, allowed=not any(selected))
    if any(selected + written):
        return _refusal(asked.pgn, PgnErrorCode.READ_OR_WRITE_NOT_SUPPORTED, parameters=selected + written)
    values = field_values(target.message())
    reply = NmeaWriteFieldsReplyGroupFunction(
        pgn=asked.pgn,
        unique_id=asked.unique_id,
        selection=asked.selection,
        parameters=tuple(Parameter(parameter.index, values[parameter.index - 1]) for parameter in asked.parameters),
    )
    return Answers((reply,))


def field_values(message: Message) -> list[bytes]:
    """Each field of a message as group functions carry it: filled up with zeros to whole bytes, strings as they are."""
    payload = message.encode()
    packed = int.from_bytes(payload, "little")
    values: list[bytes] = []
    at = 0
    for slot in message.layout:
        bits = max(payload[at // 8], 2) * 8 if isinstance(slot.field, StringLau) else slot.length or 0
        values.append((packed >> at & (1 << bits) - 1).to_bytes(-(-bits // 8), "little"))
        at += bits
    return values
