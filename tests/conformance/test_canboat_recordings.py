"""Every message of every recording, decoded by the catalogue, by canboat and by the declared messages.

Where the catalogue differs from canboat 9.0.0 it says so in `EXPLAINED`; there is no number that both have and that
differs. A field that the message ends in is one kind of difference: canboat makes a number of the bits that are
there, the catalogue has no value.
"""

import gzip
import json
import math
import re
from collections import defaultdict
from functools import cache

import pytest

from tests.catalogue import by_row, plain, table
from tests.conformance import canboat_decoder
from tests.conformance.recorded import messages, recordings
from tests.recordings import ROOT, recording
from timonel.core.fields import Bits, Flags, Lookup, Number
from timonel.nmea2000 import catalogue, registry
from timonel.nmea2000.catalogue_columns import select
from timonel.nmea2000.identifier import split

GATEWAY = 0x40000
ZERO = "an MMSI of 0, as the references have it; canboat 9 has none"
CUT = "the message ends within the field"
EXPLAINED = {
    ("aisDataLinkManagementMessage", "list.offset"): CUT,
    ("distanceLog", "log"): CUT,
    ("gnssSatsInView", "list.rangeResiduals"): CUT,
    ("navicoDataTypeSourceDirectory", "list.dataType"): CUT,
    ("routeAndWpServiceXteLimitNavigationMethod", "list.rps"): CUT,
    ("navicoUdbDatabaseObjectDump", "list.value"): "bytes: those that are there of more that were announced",
    ("aisClassAStaticAndVoyageRelatedData", "destination"): "text ends at `@`, as AIS pads it",
    ("mercuryEngineStatus", "helm"): "half a byte in hex: canboat has its four bits in the upper half",
    ("aisClassBStaticDataMsg24PartB", "mothershipUserId"): ZERO,
    ("aisInterrogation", "destinationId2"): ZERO,
    ("gnssPositionData", "referenceStationType"): "no reference station is an empty list, not one of zeros",
    ("gnssPositionData", "referenceStationId"): "the same",
    ("gnssPositionData", "ageOfDgnssCorrections"): "the same",
    ("nmeaRequestGroupFunction", "list.parameter"): "all that the target can be have the field alike: it is read",
    ("nmeaRequestGroupFunction", "list.value"): "the same; canboat has bytes of all that follows",
}


@cache
def payloads():
    """PGN -> every distinct payload of the recordings."""
    found = defaultdict(dict)
    for name in recordings():
        for message in messages(recording(name)):
            found[split(message.identifier).pgn][message.payload] = name
    return found


# What a unit of canboat.json is in SI. The package gives values whose field the message tells in SI whatever is asked.
SI = (1, 0.01, 0.001, 1e-3 / 3600, 3600, 3.6e6, math.radians(1), 1 / 60)


def same(ours, theirs, factors=(1,)):
    if isinstance(ours, int | float) and isinstance(theirs, int | float):
        return any(math.isclose(ours * factor, theirs, rel_tol=1e-9, abs_tol=1e-12) for factor in factors)
    return ours == theirs


def known(identifier):
    """Whether canboat's definition is more than that of a range of PGNs."""
    return identifier is not None and not identifier.startswith("0x")


def test_every_message_of_every_recording_is_what_canboat_decodes():
    number, met, wrong = 0, set(), []
    for pgn, found in payloads().items():
        for payload, name in found.items():
            number += 1
            definition = catalogue.find(pgn, payload)
            identifier, theirs = canboat_decoder.decode(pgn, payload)
            if definition is None or definition.id != identifier:
                wrong += [(name, pgn, identifier, payload.hex())] if definition or known(identifier) else []
                continue
            ours = dict(canboat_decoder.items(definition.as_dict(payload)))
            for field in ours.keys() | theirs.keys():
                if not same(ours.get(field), theirs.get(field), SI if field.rpartition(".")[2] == "value" else (1,)):
                    key = identifier, re.sub(r"\.\d+", "", field)
                    met.add(key)
                    if key not in EXPLAINED or both_are_numbers(ours.get(field), theirs.get(field)):
                        wrong.append((name, *key, ours.get(field), theirs.get(field), payload.hex()))
    assert number > 100_000
    assert wrong == []
    assert met == EXPLAINED.keys()


def both_are_numbers(ours, theirs):
    return isinstance(ours, int | float) and isinstance(theirs, int | float)


def test_one_by_one_and_all_at_once_are_the_same_on_every_message():
    for pgn, found in payloads().items():
        distinct = list(found)
        for definition, rows in select(pgn, *table(distinct)):
            chosen = [distinct[row] for row in rows]
            assert all(catalogue.find(pgn, payload) is definition for payload in chosen)
            if definition is not None:
                assert by_row(definition, chosen) == [plain(definition.decode_codes(one)) for one in chosen]


def test_a_declared_message_has_the_values_of_its_definition():
    """Or none, where it keeps to a range that canboat does not keep to."""
    compared = 0
    for pgn in payloads().keys() & registry.MESSAGES.keys():
        for payload in payloads()[pgn]:
            message, definition = registry.decode(pgn, payload), catalogue.find(pgn, payload)
            if message is None or definition is None or type(message).__name__.lower() != definition.id.lower():
                continue
            values = definition.decode_codes(payload)
            for slot, value in declared_values(message):
                theirs = getattr(values, camel(slot.name))
                if isinstance(theirs, bytes):
                    theirs = int.from_bytes(theirs, "little")
                assert same(value, theirs) or stricter(slot.field, value, theirs), (definition.id, slot.name)
                compared += 1
    assert compared > 100_000


def declared_values(message):
    for slot in message.layout:
        if isinstance(slot.field, Number | Lookup | Bits | Flags) and slot.offset is not None:
            yield slot, getattr(message, slot.name)


def camel(name):
    return re.sub(r"_([a-z0-9])", lambda found: found[1].upper(), name)


def stricter(field, value, theirs):
    """A number outside its range is none; and a number of two bits without a name is one to the declaration."""
    if isinstance(field, Number) and value is None:
        lowest, highest = field.span
        return not lowest <= theirs <= highest
    return isinstance(field, Lookup) and theirs is None and value.name.startswith("UNKNOWN_")


# Reference files ------------------------------------------------------------------------------------

CANBOAT = sorted(str(path.relative_to(ROOT)) for path in ROOT.rglob("*.canboat.jsonl.gz"))
EXPECTED = sorted(str(path.relative_to(ROOT)) for path in ROOT.rglob("*.expected.jsonl.gz"))
# What the references decode and the catalogue leaves as bytes: a PGN of a range that is nobody's own.
NOBODYS = {130762}
# Lists of canboat 9 with other words than those of canboat 8, with which the references were made.
# Where the references have a number for what means "not available".
RESERVED = {("batteryConfigurationStatus", "peukertExponent")}
REWORDED = {"Device Identification": "Device Indentification"}


def lines(name):
    with gzip.open(recording(name), "rt") as file:
        yield from map(json.loads, file)


@pytest.mark.parametrize("name", CANBOAT)
def test_every_number_of_the_references_is_ours(name):
    count = 0
    for line in lines(name):
        for identifier, message in line.items():
            if not isinstance(message, dict) or message["pgn"] >= GATEWAY or message["pgn"] in NOBODYS:
                continue
            payload = bytes.fromhex(message["data"])
            definition = catalogue.find(message["pgn"], payload)
            assert definition is not None, message
            assert definition.id == identifier
            agrees(definition, message["fields"], plain(definition.decode_codes(payload)), definition.as_dict(payload))
            count += 1
    assert count > 200


def agrees(definition, theirs, codes, labels):
    """Every value of a reference, an item's of a list too, is ours."""
    fields = {field.id: field for field in definition.fields}
    for name, value in theirs.items():
        if name in ("list", "list2"):
            if definition.pgn != 126208:
                for item, ours, words in zip(value, codes[name], labels[name], strict=True):
                    agrees(definition, item, ours, words)
        elif not fields[name].silent and (definition.id, name) not in EXPLAINED.keys() | RESERVED:
            assert agrees_with(fields[name], value, codes.get(name), labels.get(name)), (definition.id, name, value)


def agrees_with(field, theirs, code, label):
    value, words = (theirs.get("value"), theirs.get("name")) if isinstance(theirs, dict) else (theirs, None)
    match field.kind:
        case "LOOKUP" | "INDIRECT_LOOKUP" | "DYNAMIC_FIELD_KEY":
            return value == code and (words is None or words == REWORDED.get(label, label))
        case "BITLOOKUP":
            return [bit["name"] for bit in theirs or []] == (label or [])
        case "MMSI":
            return (None if value is None else int(value)) == code
        case "BINARY":
            return (value or "").replace(" ", "") == (label or "")
        case "TIME" | "DURATION" if value is not None:
            scaled = value * field.resolution if words and field.resolution < 1 else value
            return code is not None and math.isclose(scaled, code, abs_tol=field.resolution / 2)
    if isinstance(value, int | float) and code is not None:
        return close(field, value, code)
    return value == code


@pytest.mark.parametrize("name", EXPECTED)
def test_every_number_that_is_expected_is_ours(name):
    count = 0
    for line in lines(name):
        payload = bytes.fromhex(line["d"])
        definition = catalogue.find(line["pgn"], payload)
        assert definition is not None
        codes = plain(definition.decode_codes(payload))
        for field in definition.fields:
            if field.id in line["f"] and not isinstance(line["f"][field.id], list | dict):
                count += 1
                assert expected(field, line["f"][field.id], codes.get(field.id)), (line, field.id)
    assert count > 500


def expected(field, theirs, ours):
    if theirs is None or ours is None or isinstance(theirs, str):
        return theirs == ours
    if field.kind == "TIME":
        theirs *= field.resolution
    return close(field, theirs, ours)


def close(field, theirs, ours):
    """Within the field's resolution; positions are written with seven digits."""
    digits = 1e-7 if field.unit == "deg" else field.resolution
    return math.isclose(theirs, ours, abs_tol=digits / 2 * 1.001, rel_tol=1e-9)
