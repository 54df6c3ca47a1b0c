"""Every declared layout is the one of canboat's database: place, size, scale, unit, range, names, transport.

The database is canboat's `docs/canboat.json`; the same one is compiled into the PyPI package `nmea2000`.
"""

import json
import re
from collections.abc import Iterator
from enum import IntEnum, IntFlag
from functools import cache
from typing import Any

import pytest

from tests.recordings import recording
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
    Reserved,
    Spare,
    StringLau,
)
from timonel.core.message import Message, Slot
from timonel.nmea2000 import lookups, registry
from timonel.nmea2000.messages.group_function import Parameters, Proprietary, WhenProprietary
from timonel.nmea2000.messages.raymarine import SeatalkKeepAlive

TYPES: dict[type[Field], set[str]] = {
    Number: {"MMSI", "NUMBER", "DURATION", "DATE", "TIME", "INDIRECT_LOOKUP"},
    Bits: {"NUMBER", "PGN", "ISO_NAME", "BINARY"},
    Lookup: {"LOOKUP"},
    Flags: {"BITLOOKUP"},
    Match: {"LOOKUP", "NUMBER"},
    Reserved: {"RESERVED"},
    Spare: {"SPARE"},
    Ascii: {"STRING_FIX"},
    Binary: {"BINARY"},
    StringLau: {"STRING_LAU"},
    Float32: {"FLOAT"},
}
UNKNOWN_TO_CANBOAT = {SeatalkKeepAlive}
PRIORITY_BY_RECORDINGS = {65305, 65345, 65361, 126720, 126983, 126984, 126985, 130856}
# Constants only: of these lists the messages need no more than what they are told apart by.
PARTS_OF_LISTS = {lookups.Seatalk1Command, lookups.SeatalkCommand, lookups.SeatalkMessageId, lookups.GarminMessageId}
RATES = {None: "on event", 0.1: "10 Hz", 0.25: "4 Hz", 0.5: "2 Hz", 1.0: "1 Hz", 2.0: "every 2 s", 60.0: "every 60 s"}
TRANSPORTS = {"Single": "Single frame", "Fast": "Fast packet", "ISO": "9 bytes, by ISO transport"}

DECLARED = [message for message in registry.variants() if message not in UNKNOWN_TO_CANBOAT]
EVERY_MESSAGE = pytest.mark.parametrize("message", DECLARED, ids=lambda message: message.__name__)
LISTS = [
    item
    for item in vars(lookups).values()
    if isinstance(item, type) and issubclass(item, IntEnum | IntFlag) and item.__module__ == lookups.__name__
]


@cache
def database() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(recording("canboat_canboat/docs/canboat.json").read_text())
    return found


@cache
def definition(identifier: str) -> dict[str, Any]:
    return next(pgn for pgn in database()["PGNs"] if pgn["Id"] == identifier)


def layout_of(message: type[Message]) -> dict[str, Any]:
    """The definition that a declaration names as its source."""
    named = re.search(r"Layout: canboat `(\w+)`", message.__doc__ or "")
    assert named, f"{message.__name__} names no source"
    return definition(named[1])


def snake(identifier: str) -> str:
    return re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", identifier).lower()


def flat(message: type[Message]) -> Iterator[Slot | str]:
    """The fields in canboat's order: those of groups in their place, parameters as index and value."""
    for slot in message.layout:
        match slot.field:
            case Repeat(group=group):
                yield from group.layout
            case WhenProprietary():
                yield from Proprietary.layout
            case Parameters():
                yield from ("FIELD_INDEX", "VARIABLE")
            case Packed(element=element):
                yield "FIELD_INDEX" if element.bits == 8 else "PGN" if element.bits == 24 else "LOOKUP"
            case _:
                yield slot


def fields(message: type[Message]) -> list[tuple[Slot, dict[str, Any]]]:
    pairs = zip(flat(message), layout_of(message)["Fields"], strict=True)
    return [(slot, field) for slot, field in pairs if isinstance(slot, Slot)]


@EVERY_MESSAGE
def test_it_is_the_pgn_that_canboat_names_like_it(message: type[Message]):
    found = layout_of(message)
    assert (found["PGN"], found["Id"][0].upper() + found["Id"][1:]) == (message.PGN, message.__name__)


@EVERY_MESSAGE
def test_fields_have_canboats_names_types_and_sizes(message: type[Message]):
    for slot, field in fields(message):
        assert slot.name == snake(field["Id"])
        assert field["FieldType"] in TYPES[type(slot.field)], slot.name
        assert slot.length == field.get("BitLength"), slot.name


@EVERY_MESSAGE
def test_lists_and_parameters_stand_for_fields_of_canboat(message: type[Message]):
    pairs = zip(flat(message), layout_of(message)["Fields"], strict=True)
    for kind, field in pairs:
        if isinstance(kind, str):
            assert kind == field["FieldType"], field["Id"]


@EVERY_MESSAGE
def test_fields_stand_where_canboat_has_them(message: type[Message]):
    placed = [(slot, field) for slot, field in fields(message) if slot in message.layout]
    assert placed
    for slot, field in placed:
        assert slot.offset == field.get("BitOffset"), slot.name


@EVERY_MESSAGE
def test_numbers_have_canboats_scale_unit_sign_and_range(message: type[Message]):
    for slot, field in fields(message):
        if isinstance(number := slot.field, Number):
            assert number.resolution == field["Resolution"], slot.name
            assert number.unit == (field.get("Unit") or ""), slot.name
            assert number.signed == bool(field.get("Signed")), slot.name
            assert number.offset == field.get("Offset", 0), slot.name
            tolerance = {"rel": 0.003} if number.bits == 64 else {"abs": number.resolution}
            if field["FieldType"] != "MMSI":  # whose lowest numbers we leave to those who give them out
                assert number.value(number.range[0]) == pytest.approx(field["RangeMin"], **tolerance), slot.name
            assert number.value(number.range[1]) == pytest.approx(field["RangeMax"], **tolerance), slot.name


@EVERY_MESSAGE
def test_lookups_are_canboats_and_end_where_its_range_ends(message: type[Message]):
    for slot, field in fields(message):
        match slot.field:
            case Lookup() as lookup:
                assert source(lookup.codes) == field["LookupEnumeration"], slot.name
                assert lookup.highest == field["RangeMax"], slot.name
            case Flags() as flags:
                assert source(flags.flags) == field["LookupBitEnumeration"], slot.name


@EVERY_MESSAGE
def test_constants_are_those_that_canboat_matches(message: type[Message]):
    wanted = {snake(field["Id"]): field["Match"] for field in layout_of(message)["Fields"] if "Match" in field}
    assert {slot.name: slot.default for slot in message.layout if isinstance(slot.field, Match)} == wanted


@EVERY_MESSAGE
def test_groups_repeat_by_canboats_count(message: type[Message]):
    found = layout_of(message)
    counts = [found.get(f"RepeatingFieldSet{number}CountField") for number in (1, 2)]
    counters = [slot.field.counter for slot in message.layout if isinstance(slot.field, Repeat | Parameters | Packed)]
    names = [snake(found["Fields"][count - 1]["Id"]) for count in counts if count]
    assert [counter for counter in counters if counter] == names


@EVERY_MESSAGE
def test_transport_priority_and_interval_are_canboats(message: type[Message]):
    found, pgn = layout_of(message), message.PGN
    assert pgn is not None
    interval = found.get("TransmissionInterval")
    assert registry.interval(pgn) == (interval / 1000 if interval else None)
    if pgn in PRIORITY_BY_RECORDINGS:
        assert found.get("Priority") in (None, registry.priority(pgn))
    else:
        assert registry.priority(pgn) == found["Priority"]


@EVERY_MESSAGE
def test_the_docstring_says_how_it_travels(message: type[Message]):
    found, pgn = layout_of(message), message.PGN
    assert pgn is not None
    priority = f", priority {registry.priority(pgn)}" if "Priority" in found else ""
    expected = f"{TRANSPORTS[found['Type']]}{priority}, {RATES[registry.interval(pgn)]}."
    assert expected in " ".join((message.__doc__ or "").split())
    assert (message.__doc__ or "").startswith(f"PGN {pgn}: ")


def test_fast_packets_are_those_of_canboat():
    definite = [pgn for pgn in database()["PGNs"] if not pgn.get("Fallback")]
    assert len(definite) > 500
    wrong = {pgn["PGN"] for pgn in definite if registry.is_fast(pgn["PGN"]) != (pgn["Type"] == "Fast")}
    assert wrong == set()


@pytest.mark.parametrize(
    ("first", "last", "fast"),
    [
        (0xE800, 0xEEFF, False),
        (0xEF00, 0xEFFF, False),
        (0xF000, 0xFFFF, False),
        (0x1ED00, 0x1EEFF, True),
        (0x1EF00, 0x1EFFF, True),
        (0x1FF00, 0x1FFFF, True),
    ],
)
def test_a_pgn_nobody_knows_travels_as_its_range_does(first: int, last: int, fast: bool):
    assert {registry.is_fast(pgn) for pgn in range(first, last + 1)} == {fast}


def source(enumeration: type[IntEnum] | type[IntFlag]) -> str:
    named = re.fullmatch(r"canboat `(\w+)`\.", enumeration.__doc__ or "")
    assert named, f"{enumeration.__name__} names no source"
    return named[1]


def codes(name: str) -> dict[int, str]:
    """A list of canboat: numbers, or bits, and their names."""
    for entry in database()["LookupEnumerations"]:
        if entry["Name"] == name:
            return {value["Value"]: value["Name"] for value in entry["EnumValues"]}
    bits = next(entry for entry in database()["LookupBitEnumerations"] if entry["Name"] == name)
    return {1 << value["Bit"]: value["Name"] for value in bits["EnumBitValues"]}


@pytest.mark.parametrize("enumeration", LISTS, ids=lambda enumeration: enumeration.__name__)
def test_a_list_has_the_numbers_of_canboats(enumeration: type[IntEnum]):
    ours, theirs = {int(code) for code in enumeration}, set(codes(source(enumeration)))
    assert ours < theirs if enumeration in PARTS_OF_LISTS else ours == theirs


# Where canboat's words would make no name, or a long one.
RENAMED = {
    "SeatalkKey": {"MINUS_1", "MINUS_10", "PLUS_1", "PLUS_10", "MINUS_1_AND_MINUS_10", "PLUS_1_AND_PLUS_10"},
    "Seatalk1Command": {"PILOT_STATE", "DEVICE_IDENTIFICATION"},
    "GnssMethod": {"NONE", "SIMULATED"},
    "AlertLanguageId": {"ENGLISH_US", "ENGLISH_UK"},
    "WindReference": {"TRUE_NORTH", "MAGNETIC_NORTH", "TRUE_BOAT", "TRUE_WATER"},
    "NewPriority": {f"PRIORITY_{number}" for number in range(8)},
    "SeatalkAlarmStatus": {"ACTIVE"},
    "CalculationType": {"RHUMB_LINE"},
}


@pytest.mark.parametrize("enumeration", LISTS, ids=lambda enumeration: enumeration.__name__)
def test_names_are_made_of_canboats_words(enumeration: type[IntEnum]):
    theirs = codes(source(enumeration))
    for code in enumeration:
        if code.name not in RENAMED.get(enumeration.__name__, ()):
            words = re.sub(r"[^a-z0-9]", "", theirs[code].lower().replace("+", "plus").replace("&", "and"))
            own = code.name.removesuffix(f"_{code.value}").lower().split("_")
            assert all(word in words or word == "and" for word in own), (code.name, theirs[code])
