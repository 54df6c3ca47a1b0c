"""What each kind of field allows, and how the fields of variable size are read and written."""

from typing import Annotated

import pytest

from timonel.core.fields import (
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U24,
    U32,
    Bits,
    Code,
    Date,
    Float32,
    Lookup,
    Number,
    Packed,
    Repeat,
    StringLau,
    TimeOfDay,
    Unsigned,
    Variable,
)
from timonel.core.message import Message
from timonel.errors import EncodeError


class Gear(Code):
    NEUTRAL = 0
    AHEAD = 1
    ASTERN = 2


class Full(Code):
    LAST = 3


class Point(Message):
    x: Annotated[int | None, U8()]
    y: Annotated[int | None, U8()]


@pytest.mark.parametrize(
    ("field", "lowest", "highest"),
    [
        (U8(), 0, 252),
        (U16(), 0, 65532),
        (U24(0.001, "K"), 0, 0xFFFFFC),
        (U32(0.01, "m"), 0, 0xFFFFFFFC),
        (I8(), -127, 124),
        (I16(1, "m"), -32767, 32764),
        (Unsigned(2), 0, 2),
        (Unsigned(3), 0, 6),
        (Unsigned(4), 0, 13),
        (Unsigned(7), 0, 125),
        (Unsigned(12), 0, 4092),
        (U16(1e-4, "rad"), 0, 62832),
        (I16(1e-4, "rad"), -31416, 31416),
        (I32(1e-7, "deg", limit=90), -900_000_000, 900_000_000),
        (I64(1e-16, "deg", limit=180), -18 * 10**17, 18 * 10**17),
        (TimeOfDay(), 0, 864_010_000),
        (Date(), 0, 65532),
    ],
)
def test_a_number_keeps_its_highest_values_for_what_is_none(field: Number, lowest: int, highest: int):
    assert field.range == (lowest, highest)


@pytest.mark.parametrize(
    ("field", "inverse"),
    [
        (U16(1e-4), 10_000),
        (I16(3.125e-5), 32_000),
        (I32(3.125e-8), 32_000_000),
        (I64(1e-16), 10**16),
        (I16(0.004), 250),
        (U8(10), None),
        (U8(), None),
        (U8(0.3), None),
    ],
)
def test_a_resolution_with_an_integer_inverse_is_divided_by(field: Number, inverse: int | None):
    assert field.inverse == inverse


def test_scaled_values_print_short():
    assert U16(1e-4, "rad").value(39324) == 3.9324
    assert I64(1e-16, "deg").value(374872500000000000) == 37.48725
    assert U16(0.1, "K").value(2981) == 298.1


def test_an_offset_is_added_after_scaling():
    assert U8(0.5, "C", offset=-40).value(100) == 10.0
    assert U8(2, offset=-40).value(100) == 160


def test_the_span_of_an_angle_is_a_full_circle():
    assert U16(1e-4, "rad").span == (0, 6.2831)
    assert I16(1e-4, "rad").span == (-3.1415, 3.1415)


def test_an_unknown_code_stays_distinguishable():
    unknown = Gear(6)
    assert unknown.name == "UNKNOWN_6"
    assert unknown == 6
    assert unknown not in list(Gear)


@pytest.mark.parametrize("value", [-1, "ahead", None, 1.5])
def test_what_no_field_can_hold_is_no_code(value: object):
    with pytest.raises(ValueError):
        Gear(value)


def test_a_lookup_without_a_name_for_it_reads_its_highest_value_as_none():
    assert Lookup(2, Gear).meaning(3) is None
    assert Lookup(8, Gear).meaning(253) is None
    assert Lookup(8, Gear).meaning(252) == 252


def test_a_lookup_with_a_name_for_it_has_no_none():
    assert Lookup(2, Full).meaning(3) is Full.LAST


@pytest.mark.parametrize(
    ("data", "text", "end"),
    [
        (b"\x07\x01Buoy1", "Buoy1", 7),
        (b"\x06\x00\xe4\x00\xf1\x00", "\xe4\xf1", 6),
        (b"\x02\x01", None, 2),
        (b"\x05\x01\xff\xff\xff", None, 5),
        (b"\x06\x01AB\x00C", "AB", 6),
        (b"\x05\x07abc", None, 5),  # a kind that nobody knows
        (b"\x00\x01", None, 2),  # shorter than its own head
        (b"\x09\x01AB", "AB", 9),  # longer than the message
        (b"\x05\x00\xe4\x00\xf1", "\xe4", 5),  # half a character
        (b"\x05", None, 2),
        (b"", None, 2),
    ],
)
def test_a_string_gives_what_is_there(data: bytes, text: str | None, end: int):
    assert StringLau().read(data, 0) == (text, end)


@pytest.mark.parametrize("text", ["Buoy1", "\xe4\xf1", "\u0416", None])
def test_a_string_is_read_as_it_was_written(text: str | None):
    written = StringLau().write(text)
    assert StringLau().read(written, 0) == (text, len(written))


def test_a_string_that_no_length_byte_can_count_is_refused():
    with pytest.raises(EncodeError, match="254 bytes, a string at most 253"):
        StringLau().write("a" * 254)


@pytest.mark.parametrize(
    ("data", "value"),
    [
        ("b48d2e40", pytest.approx(2.727399, abs=1e-6)),  # canboat sample garmin-ap-reactor-126720
        ("0000c842", None),  # 100.0, which is the limit
        ("0000c8c2", None),
        ("0000c07f", None),  # not a number
        ("0000807f", None),  # infinite
        ("00000000", 0.0),
    ],
)
def test_a_float_is_what_it_is_or_none(data: str, value: object):
    assert Float32("rad", 100.0).read(bytes.fromhex("ff" + data), 1) == (value, 5)


def test_a_float_that_is_not_there_whole_is_none():
    assert Float32().read(b"\0\0\0", 0) == (None, 4)


def test_a_float_is_read_as_it_was_written_and_none_as_its_limit():
    field = Float32("rad", 100.0)
    assert field.read(field.write(2.5), 0) == (2.5, 4)
    assert field.write(None).hex() == "0000c842"
    assert field.read(field.write(None), 0) == (None, 4)
    with pytest.raises(EncodeError, match=r"100\.0 rad is outside -100\.\.100"):
        field.write(100.0)


def test_groups_are_counted_by_their_field_or_run_to_the_end():
    data = bytes((1, 2, 3, 4, 5, 6))
    assert Repeat(Point, "n").read(data, 0, 2) == ((Point(x=1, y=2), Point(x=3, y=4)), 4)
    assert len(Repeat(Point).read(data, 0)[0]) == 3


@pytest.mark.parametrize("count", [200, None])
def test_a_count_that_does_not_fit_gives_what_is_there(count: int | None):
    groups, _ = Repeat(Point, "n").read(bytes((1, 2, 3)), 0, count)
    assert groups == ((Point(x=1, y=2),) if count else ())


def test_packed_lookups_have_no_gaps():
    field = Packed(Lookup(4, Gear), "n")
    assert field.read(b"\x10\x02", 0, 3) == ((Gear.NEUTRAL, Gear.AHEAD, Gear.ASTERN), 2)
    assert field.write((0, 1, 2)) == b"\x10\xf2"
    assert field.read(b"\xff", 0, 9) == ((None, None), 1)


def test_packed_bits_run_to_the_end_of_the_message():
    assert Packed(Bits(24)).read(b"\x00\xee\x00\x14\xf0\x01\xff", 0) == ((60928, 126996), 6)
    assert Packed(Bits(24)).write((60928, 126996)) == b"\x00\xee\x00\x14\xf0\x01"
    assert Packed(Bits(24)).read(b"", 5) == ((), 5)


@pytest.mark.parametrize("value", [-1, 16])
def test_a_packed_value_that_needs_more_bits_is_refused(value: int):
    with pytest.raises(EncodeError, match=f"{value} is outside 0..15"):
        Packed(Bits(4)).write((value,))


def test_a_field_of_variable_size_must_say_how_it_is_read_and_written():
    with pytest.raises(NotImplementedError):
        Variable().read(b"", 0)
    with pytest.raises(NotImplementedError):
        Variable().write(None)
