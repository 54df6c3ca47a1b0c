"""The catalogue is canboat's database: that of the PyPI package `nmea2000`, and canboat.json for the rest."""

import json
import runpy
from functools import cache
from pathlib import Path

import pytest
from nmea2000 import _canboat as canboat
from nmea2000.native_units import NATIVE_UNITS

from tests.conformance import canboat_decoder
from tests.recordings import recording
from timonel.nmea2000 import catalogue, registry

DATABASE = canboat.Database("si")
JSON = "canboat_canboat/docs/canboat.json"
SCRIPT = Path(__file__).parents[2] / "scripts" / "make_catalogue.py"
DEFINITIONS = [definition for pgn in catalogue.pgns() for definition in catalogue.variants(pgn)]
NEW = 36  # definitions of 9.0.0 that canboat.json, 8.0.0-beta3, does not have
# What 9.0.0 has otherwise than canboat.json. Fields:
MOVED = {
    "fusionMenuLockId": "a token was found before the lock's number",
    "fusionZoneName": "the field `number` is called `zone`",
    "utilityPhaseBAcReactivePower": "the power has 32 bits",
    "utilityPhaseCAcReactivePower": "the power has 32 bits",
}
KINDS = {("ADDRESS", "NUMBER"), ("BITLOOKUP", "NUMBER"), ("INDIRECT_LOOKUP", "NUMBER"), ("LOOKUP", "NUMBER")}
SIGNED = {("airmarDeviceInformation", "supplyVoltage"), ("fusionAuxGain", "gain"), ("fusionBalance", "value")}
RELISTED = {
    ("fusionMenuActionStatus", "action"): "FUSION_MENU_STATUS",
    ("fusionLowPassFilter", "filter"): "FUSION_LOW_PASS_FILTER",
}


@cache
def told():
    definitions = json.loads(recording(JSON).read_text())["PGNs"]
    return {definition["Id"]: definition for definition in definitions}


@cache
def compiled():
    return {info.id: info for info in DATABASE.pgns()}


def test_the_file_is_what_the_script_makes_of_both():
    made = runpy.run_path(str(SCRIPT))["catalogue"](recording(JSON))
    kept = (Path(catalogue.__file__).parent / "catalogue.jsonl").read_text(encoding="utf-8")
    assert made == kept


def test_every_definition_is_there_in_the_order_in_which_canboat_tries_them():
    assert len(DEFINITIONS) == len(DATABASE.pgns()) == len(told()) + NEW
    for pgn in catalogue.pgns():
        assert [one.id for one in catalogue.variants(pgn)] == [info.id for info in DATABASE.pgn_variants(pgn)]


def test_the_version_is_that_of_the_database():
    assert DATABASE.version == catalogue.VERSION


def test_definitions_are_those_of_the_compiled_database():
    for definition in DEFINITIONS:
        info = compiled()[definition.id]
        assert (definition.pgn, definition.transport) == (info.pgn, info.packet_type)
        assert definition.interval == info.transmission_interval
        assert list(definition.sets) == info.repeating_sets
        assert [field.id for field in definition.fields] == [field.id for field in info.fields]


def test_fields_are_those_of_the_compiled_database():
    for definition in DEFINITIONS:
        for field, theirs in zip(definition.fields, compiled()[definition.id].fields, strict=True):
            assert (field.kind, field.bits) == (theirs.field_type or "NUMBER", theirs.bit_length)
            scale = NATIVE_UNITS.get((definition.id, field.id), (theirs.unit, theirs.resolution, theirs.offset))
            assert (field.unit, field.resolution, field.offset) == (scale[0] or "", scale[1] or 1, scale[2] or 0)
            assert field.key == theirs.part_of_primary_key


def test_fields_stand_where_the_compiled_database_has_them():
    for definition in DEFINITIONS:
        at = 0
        for number, (field, theirs) in enumerate(zip(definition.fields, compiled()[definition.id].fields, strict=True)):
            if any(number >= group.first for group in definition.groups):
                break
            assert theirs.bit_offset in (None, at), (definition.id, field.id)
            if field.bits is None:
                break
            at += field.bits


def test_what_canboat_encodes_is_found_as_canboat_finds_it():
    for definition in DEFINITIONS:
        blank = encoded(definition)
        identifier, _ = canboat_decoder.decode(definition.pgn, blank)
        found = catalogue.find(definition.pgn, blank)
        assert found is None or found.id == identifier, definition.id
        assert found is not None or identifier.startswith("0x")


def encoded(definition):
    """A message without values; of those that canboat encodes with values only, the constants."""
    try:
        return DATABASE.encode(definition.id, {})
    except canboat.EncodeError:
        _, value, end = definition.pattern
        return value.to_bytes(end + 40, "little")


@pytest.mark.parametrize("identifier", sorted(MOVED))
def test_a_moved_field_is_one_in_canboat_json_too(identifier):
    ours = [(field.id, field.bits) for field in catalogue.by_id(identifier).fields]
    assert ours != [(field["Id"], field.get("BitLength")) for field in told()[identifier]["Fields"]]


def test_definitions_are_those_of_canboat_json():
    for definition in DEFINITIONS:
        if definition.id in told():
            theirs = told()[definition.id]
            assert (definition.pgn, definition.title) == (theirs["PGN"], theirs["Description"])
            assert definition.priority == theirs.get("Priority")
            assert definition.fallback == bool(theirs.get("Fallback"))


def test_fields_are_those_of_canboat_json():
    for definition in DEFINITIONS:
        if definition.id in told() and definition.id not in MOVED:
            for field, theirs in zip(definition.fields, told()[definition.id]["Fields"], strict=True):
                key = definition.id, field.id
                assert (field.id, field.bits, field.match) == (
                    theirs["Id"],
                    theirs.get("BitLength"),
                    theirs.get("Match"),
                )
                assert field.kind == theirs["FieldType"] or (field.kind, theirs["FieldType"]) in KINDS, key
                if listed := theirs.get("LookupEnumeration") or theirs.get("LookupBitEnumeration"):
                    assert field.lookup == RELISTED.get(key, listed), key
                if field.kind == theirs["FieldType"] in ("NUMBER", "TIME", "DURATION", "DATE") and not field.offset:
                    assert field.signed == bool(theirs.get("Signed")) or key in SIGNED, key
                    assert field.resolution == pytest.approx(theirs.get("Resolution", 1), rel=1e-12), key
                    assert field.unit == (theirs.get("Unit") or "") or field.id == "apparentPower", key


def test_the_lists_are_those_of_the_compiled_database():
    named = {(field.kind, field.lookup) for one in DEFINITIONS for field in one.fields if field.lookup}
    for kind, name in named:
        if kind == "BITLOOKUP":
            assert catalogue.labels(name) == dict(DATABASE.bit_lookup(name))
        elif kind == "LOOKUP" and not asked(name):
            assert catalogue.labels(name) == dict(DATABASE.lookup(name))


def asked(name):
    """Whether a list has no name in the package that is known: it is named after its field, its labels asked for."""
    return name in ("AIRMAR_RESET_EEPROM_OPTIONS", "FUSION_TUNER_COMMAND_COMMAND", "SIMNET_ZC_KEY_KEY")


def test_how_a_pgn_travels_is_the_same_to_the_live_path():
    assert [pgn for pgn in range(1 << 18) if travels_fast(pgn) != registry.is_fast(pgn)] == []


def travels_fast(pgn):
    """As canboat says, or for one that it does not know as its range does."""
    if (found := catalogue.variants(pgn)) and not found[0].fallback:
        return found[0].fast
    return 0x1ED00 <= pgn <= 0x1EFFF or 0x1FF00 <= pgn <= 0x1FFFF
