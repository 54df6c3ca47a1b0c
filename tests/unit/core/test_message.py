"""A message is its declaration: layout, and the codec that is made from it."""

from typing import Annotated

import msgspec
import pytest

from timonel.core.fields import (
    I8,
    I16,
    U8,
    U16,
    U24,
    Ascii,
    Binary,
    Bits,
    Code,
    Flags,
    Lookup,
    Match,
    Number,
    Packed,
    Repeat,
    Reserved,
    Spare,
    StringLau,
    Unsigned,
)
from timonel.core.message import Message
from timonel.errors import EncodeError
from timonel.nmea2000.lookups import HeadingReference, SimnetApModeFlags, SteeringMode, YesNo
from timonel.nmea2000.messages.network import ProductInformation
from timonel.nmea2000.messages.steering import HeadingTrackControl, VesselHeading

STEERED = bytes.fromhex("3f3cffff7f051fffffffffffffff7fff7fff7f8b1e")


class Kind(Code):
    ONE = 1


class Header(Message):
    kind: Annotated[Kind, Match(8)] = Kind.ONE
    spare: Annotated[None, Spare(4)] = None
    reserved: Annotated[None, Reserved(4)] = None


class Everything(Header):
    odd: Annotated[int | None, Unsigned(5)]
    signed_odd: Annotated[int | None, Number(11, True)]
    wide: Annotated[float | None, U24(0.001, "K")]
    signed_wide: Annotated[int | None, Number(24, True)]
    tens: Annotated[int | None, U8(10, "m")]
    celsius: Annotated[float | None, U16(0.01, "C", offset=-273.15)]
    thirds: Annotated[float | None, U8(0.3)]
    pattern: Annotated[int, Bits(40)]
    flags: Annotated[SimnetApModeFlags, Flags(16, SimnetApModeFlags)]
    label: Annotated[str | None, Ascii(4)]
    unknown: Annotated[bytes, Binary(2)]


class Pair(Message):
    low: Annotated[int | None, I8()]
    high: Annotated[int | None, I16()]


class Listed(Message):
    count: Annotated[int | None, U8()] = None
    name: Annotated[str | None, StringLau()]
    pairs: Annotated[tuple[Pair, ...], Repeat(Pair, "count")] = ()
    codes: Annotated[tuple[Kind | None, ...], Packed(Lookup(4, Kind))] = ()


class Empty(Message):
    pass


EVERYTHING = Everything(
    odd=17,
    signed_odd=-3,
    wide=293.15,
    signed_wide=-70000,
    tens=250,
    celsius=20.5,
    thirds=3.0,
    pattern=0x0123456789,
    flags=SimnetApModeFlags.HEADING | SimnetApModeFlags.WIND,
    label="AB",
    unknown=b"\x01\x02",
)


def heading(value: object) -> VesselHeading:
    return VesselHeading(sid=1, heading=value, deviation=None, variation=None, reference=None)  # type: ignore[arg-type]


def test_the_layout_is_read_from_the_declaration():
    names = [(slot.name, slot.offset, slot.length, slot.unit) for slot in VesselHeading.layout]
    assert names == [
        ("sid", 0, 8, ""),
        ("heading", 8, 16, "rad"),
        ("deviation", 24, 16, "rad"),
        ("variation", 40, 16, "rad"),
        ("reference", 56, 2, ""),
        ("reserved", 58, 6, ""),
    ]
    assert VesselHeading.PGN == 127250


def test_a_layout_begins_with_that_of_its_base():
    assert [slot.name for slot in Everything.layout[:4]] == ["kind", "spare", "reserved", "odd"]
    assert Header.PGN is None


def test_what_stands_behind_a_variable_field_has_no_offset():
    assert [slot.offset for slot in Listed.layout] == [0, 8, None, None]
    assert Listed.layout[1].length is None


def test_a_message_is_frozen_and_compares_by_value():
    assert heading(1.0) == heading(1.0)
    with pytest.raises(AttributeError):
        heading(1.0).sid = 2  # type: ignore[misc]


def test_a_field_left_out_is_not_available():
    message = HeadingTrackControl(
        override=YesNo.NO,
        steering_mode=SteeringMode.HEADING_CONTROL,
        heading_reference=HeadingReference.TRUE,
        heading_to_steer_course=0.7941,
        vessel_heading=0.7819,
    )
    assert message.encode() == STEERED
    assert HeadingTrackControl.decode(STEERED) == message


def test_a_subclass_does_not_inherit_the_codec_of_its_base():
    Header.decode(b"")
    assert Everything.decode(EVERYTHING.encode()).odd == 17
    assert len(Header().encode()) == 2


def test_a_codec_is_generated_once_whoever_holds_the_method():
    class Late(Message):
        x: Annotated[int | None, U8()]

    early = Late.decode
    assert early(b"\x01") == Late(x=1)
    generated = Late.decode
    assert early(b"\x02") == Late(x=2)
    assert Late.decode is generated


def test_every_kind_of_field_is_read_as_it_was_written():
    assert Everything.decode(EVERYTHING.encode()) == EVERYTHING


def test_every_kind_of_field_has_its_place():
    assert EVERYTHING.encode().hex(" ") == (
        "01 f0 b1 ff 1e 79 04 90 ee fe 19 b5 72 0a 89 67 45 23 01 10 04 41 42 ff ff 01 02"
    )


def test_a_group_can_be_decoded_alone():
    assert Pair.decode(b"\xff\x01\x00") == Pair(low=-1, high=1)
    assert Pair.read(b"..\xff\x01\x00", 2) == (Pair(low=-1, high=1), 5)


def test_a_message_without_fields_has_no_bytes():
    assert Empty().encode() == b""
    assert Empty.decode(b"abc") == Empty()


def test_half_a_field_is_none():
    message = msgspec.structs.replace(EVERYTHING, odd=None, signed_odd=5)
    for size in range(len(message.encode())):
        read = Everything.decode(message.encode()[:size])
        assert read.signed_odd == (5 if size >= 4 else None)
        assert read.signed_wide == (-70000 if size >= 10 else None)
        assert read.label == ("AB"[: max(0, size - 21)] or None)


def test_a_short_payload_is_filled_with_not_available_and_a_long_one_is_cut():
    whole = heading(1.5).encode()
    assert VesselHeading.decode(whole[:3]) == heading(1.5)
    assert VesselHeading.decode(whole[:2]) == heading(None)
    assert VesselHeading.decode(whole + b"\x00\x01") == heading(1.5)
    assert VesselHeading.decode(b"") == VesselHeading(
        sid=None, heading=None, deviation=None, variation=None, reference=None
    )


@pytest.mark.parametrize("kind", [bytes, bytearray, memoryview])
def test_a_payload_can_be_any_bytes(kind: type):
    assert VesselHeading.decode(kind(heading(1.5).encode())) == heading(1.5)
    assert VesselHeading.decode(kind(b"\x01")).sid == 1
    assert Listed.decode(kind(b"\x00\x02\x01")).name is None


@pytest.mark.parametrize("raw", ["fdff", "feff", "ffff", "71f5"])
def test_special_and_impossible_values_are_none(raw: str):
    assert VesselHeading.decode(bytes.fromhex("01" + raw)).heading is None


def test_a_full_circle_that_was_rounded_up_is_a_heading():
    assert VesselHeading.decode(bytes.fromhex("0170f5")).heading == 6.2832
    assert heading(6.28318).encode()[1:3] == b"\x70\xf5"


def test_values_are_rounded_to_nearest():
    assert heading(0.79412).encode()[1:3] == (7941).to_bytes(2, "little")
    assert heading(0.79418).encode()[1:3] == (7942).to_bytes(2, "little")


def test_a_code_without_a_name_is_kept():
    mode = HeadingTrackControl.decode(b"\xff\x06").steering_mode
    assert mode is not None
    assert mode.name == "UNKNOWN_6"
    assert HeadingTrackControl(steering_mode=mode).encode()[1] & 7 == 6


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        (99.0, "heading: 99.0 rad is outside 0..6.2831"),
        (-1, "heading: -1 rad is outside 0..6.2831"),
        (float("nan"), "heading: nan is not a number"),
        (float("inf"), "heading: inf rad is outside 0..6.2831"),
        ("north", "heading: 'north' is not a number"),
    ],
)
def test_a_heading_that_is_none_is_refused(value: object, reason: str):
    with pytest.raises(EncodeError) as refused:
        heading(value).encode()
    assert str(refused.value) == reason


@pytest.mark.parametrize(
    ("field", "value", "reason"),
    [
        ("odd", 31, "odd: 31 is outside 0..29"),
        ("odd", 1.5, "odd: 1.5 is not a whole number"),
        ("signed_odd", -1024, "signed_odd: -1024 is outside -1023..1020"),
        ("tens", 2521 * 10, "tens: 25210 m is outside 0..2520"),
        ("celsius", -300.0, "celsius: -300.0 C is outside -273.15..382.17"),
        ("pattern", -1, "pattern: -1 is outside 0..1099511627775"),
        ("pattern", None, "pattern: None is not a whole number"),
        ("flags", 1 << 16, "flags: 65536 is outside 0..65535"),
        ("kind", 2, "kind: 2 is not <Kind.ONE: 1>"),
        ("label", "ABCDE", "label: 'ABCDE' is not ASCII text of at most 4 characters"),
        ("label", "\xe4", "label: '\xe4' is not ASCII text of at most 4 characters"),
        ("label", 7, "label: 7 is not ASCII text of at most 4 characters"),
        ("unknown", b"1", "unknown: b'1' is not 2 bytes"),
    ],
)
def test_what_a_field_cannot_hold_is_refused_in_its_words(field: str, value: object, reason: str):
    with pytest.raises(EncodeError) as refused:
        msgspec.structs.replace(EVERYTHING, **{field: value}).encode()
    assert str(refused.value) == reason


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (HeadingTrackControl(steering_mode=8), "steering_mode: 8 is outside 0..6"),  # type: ignore[arg-type]
        (Listed(name=3), "name: 3 is neither text nor a tuple"),  # type: ignore[arg-type]
        (Listed(name=None, pairs=7), "pairs: 7 is neither text nor a tuple"),  # type: ignore[arg-type]
        (Listed(name=None, pairs=(Pair(low=1, high=2),) * 253), "Listed: more in a list than can be counted"),
        (Listed(name="a" * 254), "'aaaaaaaaaaaaaaaaaaaa'... has 254 bytes, a string at most 253"),
        (Listed(name=None, pairs=(Pair(low=500, high=2),)), "low: 500 is outside -127..124"),
    ],
)
def test_a_list_or_code_that_cannot_be_sent_is_refused(message: Message, reason: str):
    with pytest.raises(EncodeError) as refused:
        message.encode()
    assert str(refused.value) == reason


def test_a_count_is_filled_in_and_a_given_one_is_sent_as_it_is():
    pairs = (Pair(low=1, high=2), Pair(low=None, high=None))
    filled = Listed.decode(Listed(name="A", pairs=pairs).encode())
    assert (filled.count, filled.pairs) == (2, pairs)
    assert Listed(count=20, name="A", pairs=pairs).encode()[0] == 20


def test_fields_behind_a_variable_one_are_read_where_it_ends():
    message = Listed(count=1, name="Buoy", pairs=(Pair(low=-1, high=300),), codes=(Kind.ONE, None))
    assert message.encode().hex() == "010601" + b"Buoy".hex() + "ff2c01" + "f1"
    assert Listed.decode(message.encode()) == message


@pytest.mark.parametrize("pad", [b"\xff", b"\x00", b"@", b" "])
def test_fixed_text_ends_at_its_padding(pad: bytes):
    payload = bytearray(b"\xff" * 134)
    payload[4:36] = b"AP-1".ljust(32, pad)
    payload[36:68] = pad * 32
    information = ProductInformation.decode(bytes(payload))
    assert (information.model_id, information.software_version_code) == ("AP-1", None)
