"""What is true of every declared message, told by its declaration."""

import math
import string
from functools import cache
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from timonel.core.columns import columns
from timonel.core.fields import (
    Ascii,
    Binary,
    Bits,
    Field,
    Flags,
    Float32,
    Lookup,
    Match,
    Number,
    Packed,
    Repeat,
    StringLau,
    Variable,
)
from timonel.core.message import Message
from timonel.nmea2000 import registry
from timonel.nmea2000.messages.group_function import (
    TARGETS,
    Parameter,
    Parameters,
    WhenProprietary,
    message_of,
    parameters_of,
)

MESSAGES = list(registry.variants())
EVERY_MESSAGE = pytest.mark.parametrize("message", MESSAGES, ids=lambda message: message.__name__)
FEW = settings(max_examples=10, deadline=None)
WORDS = st.text(string.ascii_letters + string.digits, min_size=1, max_size=20)


@cache
def values(field: Field) -> st.SearchStrategy[Any]:
    """Values that a field can carry, as it would be read."""
    match field:
        case Number():
            return st.none() | st.integers(*field.range).map(field.value)
        case Lookup():
            absent = st.none() if field.highest < field.ones else st.nothing()
            return absent | st.integers(0, field.highest).map(field.meaning)
        case Flags():
            return st.integers(0, field.ones).map(field.flags)
        case Bits():
            return st.integers(0, field.ones)
        case Ascii(size=size):
            return st.none() | WORDS.map(lambda text: text[:size])
        case StringLau():
            return st.none() | WORDS | st.just("R\xeda de Vigo \u0416")
        case Float32(limit=limit):
            return st.none() | st.floats(-limit, limit, exclude_min=True, exclude_max=True, width=32)
        case Binary(size=size):
            return st.binary(min_size=size, max_size=size)
        case Repeat(group=group):
            return st.lists(messages(group), max_size=3).map(tuple)  # type: ignore[arg-type]
        case Packed(element=element):
            return st.lists(values(element), max_size=3).map(tuple)
    return st.none()


def messages(message: type[Message]) -> st.SearchStrategy[Message]:
    """Messages as they would be read, counts filled in; 126208 with parameters of a target that is known."""
    fields = {slot.name: values(slot.field) for slot in message.layout if not isinstance(slot.field, Match)}
    if any(isinstance(slot.field, Parameters) for slot in message.layout):
        return st.fixed_dictionaries(fields).flatmap(lambda found: _addressed(message, found))
    return st.fixed_dictionaries(fields).map(lambda found: _counted(message, found))


def _counted(message: type[Message], found: dict[str, Any]) -> Message:
    return message(**found | {count: len(found[name]) for count, name in counters(message).items()})


def counters(message: type[Message]) -> dict[str, str]:
    """The fields that count, and what they count."""
    pairs = {slot.field.counter: slot.name for slot in message.layout if isinstance(slot.field, Variable)}
    return {count: name for count, name in pairs.items() if count}


@st.composite
def _addressed(draw: st.DrawFn, message: type[Message], found: dict[str, Any]) -> Message:
    target = draw(st.sampled_from([found for several in TARGETS.values() for found in several]))
    found["pgn"] = target.PGN
    for slot in message.layout:
        if isinstance(slot.field, Parameters):
            found[slot.name] = parameters_of(target)
        if isinstance(slot.field, WhenProprietary) and registry.group_function.proprietary(target.PGN or 0):
            found[slot.name] = draw(messages(registry.group_function.Proprietary))
    return _counted(message, found)


def alike(one: object, other: object) -> bool:
    """Equal; a float that is finer than its resolution on the wire may differ by what a float can tell."""
    match one, other:
        case float(), float():
            return math.isclose(one, other, rel_tol=1e-15)
        case Message(), Message():
            names = one.__struct_fields__
            return type(one) is type(other) and all(alike(getattr(one, name), getattr(other, name)) for name in names)
        case tuple(), tuple():
            return len(one) == len(other) and all(map(alike, one, other))
    return one == other


def fine(message: type[Message]) -> bool:
    """Whether a message has numbers that are finer on the wire than a float."""
    return any(isinstance(slot.field, Number) and slot.field.bits > 53 for slot in message.layout)


@EVERY_MESSAGE
def test_a_message_is_read_as_it_was_written(message: type[Message]):
    @given(messages(message))
    @FEW
    def check(written: Message) -> None:
        read = message.decode(written.encode())
        assert alike(read, written) if fine(message) else read == written

    check()


@EVERY_MESSAGE
def test_any_bytes_of_any_length_are_read_and_what_was_read_is_written(message: type[Message]):
    @given(st.binary(max_size=230))
    @FEW
    def check(data: bytes) -> None:
        read = message.decode(data)
        written = read.encode()
        uncounted = [count for count in counters(message) if getattr(read, count) is None]
        filled = {count: len(getattr(read, counters(message)[count])) for count in uncounted}
        assert alike(message.decode(written), msgspec.structs.replace(read, **filled))
        assert fine(message) or message.decode(written).encode() == written

    check()


@EVERY_MESSAGE
def test_a_message_is_found_by_its_bytes(message: type[Message]):
    @given(messages(message))
    @FEW
    def check(written: Message) -> None:
        assert message.PGN is not None
        found = registry.decode(message.PGN, written.encode())
        assert type(found) is message or _more_special(type(found), message)

    check()


def _more_special(found: type, message: type[Message]) -> bool:
    """Whether a message may be an instance of one that another declaration has narrowed, as `tack` is a command."""
    matches = sum(isinstance(slot.field, Match) for slot in message.layout)
    return issubclass(found, Message) and matches < sum(isinstance(s.field, Match) for s in found.layout)


@EVERY_MESSAGE
def test_columns_agree_with_single_messages(message: type[Message]):
    @given(st.integers(0, 60), st.integers(0, 2**32))
    @FEW
    def check(size: int, seed: int) -> None:
        payloads = np.random.default_rng(seed).integers(0, 256, (4, size), dtype=np.uint8)
        payloads[0] = 0xFF
        found = columns(message, payloads)
        for index, payload in enumerate(payloads):
            one = message.decode(payload.tobytes())
            for name, column in found.items():
                value = getattr(one, name)
                assert math.isnan(column[index]) if value is None else column[index] == float(value)

    check()


@given(st.integers(0, 0x3FFFF) | st.sampled_from(sorted(registry.MESSAGES)), st.binary(max_size=230))
def test_no_payload_of_any_pgn_raises(pgn: int, data: bytes):
    found = registry.decode(pgn, data)
    assert found is None or type(found) in registry.MESSAGES[pgn]


@pytest.mark.parametrize(
    "target", [message for several in TARGETS.values() for message in several], ids=lambda target: target.__name__
)
def test_parameters_of_a_message_say_the_same_as_the_message(target: type[Message]):
    @given(messages(target))
    @FEW
    def check(written: Message) -> None:
        fixed = [slot.name for slot in target.layout if slot.offset is not None and slot.length is not None]
        wanted = {name: getattr(written, name) for name in fixed}
        read = message_of(target, parameters_of(target, **wanted))
        numbers = [slot.name for slot in target.layout if slot.name in fixed and hasattr(slot.field, "specials")]
        assert all(alike(getattr(read, name), wanted[name]) for name in numbers)

    check()


@given(st.lists(st.builds(Parameter, st.integers(0, 255), st.binary(max_size=9)), max_size=4).map(tuple))
def test_parameters_that_make_no_sense_set_what_they_can(parameters: tuple[Parameter, ...]):
    for several in TARGETS.values():
        assert type(message_of(several[0], parameters)) is several[0]
