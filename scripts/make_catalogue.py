"""Write `src/timonel/nmea2000/catalogue.jsonl`: every definition of canboat's database, one a line.

    python scripts/make_catalogue.py CANBOAT_JSON [OUT]

Two sources, both canboat's (Apache-2.0). The database compiled into the PyPI package `nmea2000` is the newer one
and has the say: which definitions there are, in which order they are tried, their fields, places, scales, units,
transport. Units are those of canboat.json: SI, but for %, rpm, L, deg and the like. What the database does not tell
is taken from canboat's `docs/canboat.json`: priorities, which lookup a field has, its range, what a length or a
condition depends on. Definitions that only the database has are completed by asking it: what it encodes for a message
without values shows signs and the constants that tell variants apart, what it decodes from the numbers of a lookup
shows the labels.

A definition:  {"pgn", "id", "title", "transport", "priority", "interval", "sets", "fallback", "fields"}
A field:       {"id", "title", "kind", "bits", "signed", "resolution", "offset", "unit", "match", "lookup", "range",
                "key", "length", "overhead", "by", "when", "description"}
A lookup:      {"lookup", "labels"}, {"flags", "labels"}, {"pairs", "labels"}, {"keys", "fields"}

What has its ordinary value is left out; numbers of `range` are raw. See `nmea2000/catalogue.py`.
"""

import json
import re
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from nmea2000 import _canboat as canboat
from nmea2000.consts import FieldTypes
from nmea2000.native_units import NATIVE_UNITS

OUT = Path(__file__).parents[1] / "src" / "timonel" / "nmea2000" / "catalogue.jsonl"
DATABASE = canboat.Database("si")
NO_VALUE = {"RESERVED", "SPARE"}
LABELLED = {"LOOKUP", "INDIRECT_LOOKUP"}
PLAIN = {"LOOKUP", "BITLOOKUP", "RESERVED", "SPARE", "BINARY", "STRING_FIX", "STRING_LAU", "STRING_LZ", "FLOAT"}
# Lists of 9.0.0 that canboat.json does not have yet.
NEW_LISTS = (
    "ACTISENSE_OPERATING_MODE",
    "FUSION_LOW_PASS_FILTER",
    "FUSION_MENU_STATUS",
    "SIMNET_ZC_FUNCTION",
    "SIMNET_ZC_KEY_EVENT",
)


class Value:
    """A decoded field, as the codec of `nmea2000` makes it."""

    def __init__(self, *told: Any) -> None:
        self.id, _, _, _, self.value, *_ = told


class Decoded:
    """A decoded message."""

    def __init__(self, **told: Any) -> None:
        self.id, self.title = told["id"], told["description"]
        self.fields: dict[str, Value] = {field.id: field for field in told["fields"]}


def _template(identifier: str) -> tuple[None, Any, list[tuple[Any, ...]]]:
    """Labels and numbers of lookups, canboat's own value of all others; `nmea2000.backend` explains the columns."""
    rows = []
    for field in DATABASE.pgn_info(identifier).fields:
        mode = 1 if field.field_type in LABELLED | {"DYNAMIC_FIELD_KEY"} else 2 if field.field_type in NO_VALUE else 10
        rows.append((field.id, field.name, None, None, None, FieldTypes.NUMBER, False, mode, None, 0.0, False))
    return None, FieldTypes.VARIABLE, rows


CODEC = canboat.MessageCodec(_template, Value, Decoded, "si")


def main(source: str, out: str = str(OUT)) -> None:
    Path(out).write_text(catalogue(Path(source)), encoding="utf-8")


def catalogue(source: Path) -> str:
    """The text of the data file."""
    told = json.loads(source.read_text())
    header = {
        "catalogue": f"canboat {DATABASE.version}, as compiled into PyPI nmea2000; "
        f"canboat.json {told['Version']} for what that does not tell",
        "version": DATABASE.version,
        "licence": "Apache-2.0",
        "copyright": "Kees Verruijt and contributors of canboat",
    }
    maker = Maker(told)
    definitions = [maker.definition(info) for info in DATABASE.pgns()]
    lines = [header, *maker.lists(), *sorted(definitions, key=lambda definition: definition["pgn"])]
    return "".join(json.dumps(line, ensure_ascii=False, separators=(",", ":")) + "\n" for line in lines)


class Maker:
    """Joins the two sources."""

    def __init__(self, told: dict[str, Any]) -> None:
        self.told = told
        self.definitions = {definition["Id"]: definition for definition in told["PGNs"]}
        self.used: set[str] = set()
        self.asked: dict[str, dict[int, str]] = {}

    @cache  # noqa: B019
    def labels(self, name: str) -> dict[int, str]:
        return dict(DATABASE.lookup(name))

    def definition(self, info: Any) -> dict[str, Any]:
        told = self.definitions.get(info.id, {})
        blank = _blank(info)
        title = told.get("Description") or CODEC.decode(info.pgn, blank, 0, 255, 6).title
        line = {
            "pgn": info.pgn,
            "id": info.id,
            "title": title,
            "transport": info.packet_type,
            "priority": told.get("Priority"),
            "interval": info.transmission_interval,
            "fallback": told.get("Fallback"),
            "sets": [[start, size, count] for start, size, count in info.repeating_sets] or None,
        }
        fields = [self.field(info, field, told.get("Fields", []), blank) for field in info.fields]
        return _without_nothing(line) | {"fields": fields}

    def field(self, info: Any, field: Any, told_fields: list[dict[str, Any]], blank: bytes) -> dict[str, Any]:
        told = next((one for one in told_fields if one["Id"] == field.id), {})
        if told.get("BitLength") != field.bit_length:
            told = {}
        kind = field.field_type
        number = kind not in PLAIN
        signed = _signed(field, told, blank) if number else False
        names = {one["Order"]: one["Id"] for one in told_fields}
        given = (field.unit, field.resolution, field.offset)
        unit, resolution, offset = NATIVE_UNITS.get((info.id, field.id), given)
        line = {
            "id": field.id,
            "title": field.name,
            "kind": kind if kind != "NUMBER" else None,
            "bits": field.bit_length,
            "signed": signed or None,
            "resolution": _resolution(field.field_type, resolution),
            "offset": offset or None,
            "unit": unit,
            "match": _match(info, field, told, blank),
            "lookup": self.lookup(info, field, told, blank),
            "range": _range(field, told, signed)
            if number and kind not in ("ISO_NAME", "DECIMAL", "PGN", "ADDRESS")
            else None,
            "key": field.part_of_primary_key or None,
            "length": names.get(told.get("BitLengthField")),
            "overhead": told.get("DynamicFieldLengthOverhead"),
            "by": self.depends_on(info, field, told, names),
            "when": "proprietary" if told.get("Condition") == "PGNIsProprietary" else None,
            "description": field.description or None,
        }
        return _without_nothing(line)

    def depends_on(self, info: Any, field: Any, told: dict[str, Any], names: dict[int, str]) -> str | None:
        """The field whose number, together with its own, makes the label."""
        if field.field_type != "INDIRECT_LOOKUP":
            return None
        before = [one.id for one in info.fields if (one.bit_offset or 0) < (field.bit_offset or 0)]
        return names.get(told.get("LookupIndirectEnumerationFieldOrder")) or before[-1]

    def lookup(self, info: Any, field: Any, told: dict[str, Any], blank: bytes) -> str | None:
        """The name of a field's list."""
        match field.field_type:
            case "LOOKUP":
                name = self.found(info, field, told, blank)
            case "BITLOOKUP":
                name = field.lookup_bit_enumeration
            case "INDIRECT_LOOKUP":
                name = told.get("LookupIndirectEnumeration") or "FUSION_SETTING_VALUE"
            case "DYNAMIC_FIELD_KEY":
                name = told["LookupFieldTypeEnumeration"]
            case _:
                return None
        self.used.add(name)
        return name

    def found(self, info: Any, field: Any, told: dict[str, Any], blank: bytes) -> str:
        """The list whose labels a field shows; one of its own, named after it, where no list is known."""
        named = told.get("LookupEnumeration")
        if named and ("Match" in told or _bits(field, blank) is None):
            return named
        shown = _shown(info, field, blank)
        if named and all(shown(code) in (None, label) for code, label in self.labels(named).items()):
            return named
        own = _matched(field, blank)
        if own is not None:
            return self.named_alike(field, own, shown)
        if fitting := [name for name in self.names() if self.shows(shown, name)]:
            return max(fitting, key=lambda name: len(self.labels(name)))
        name = _upper(f"{info.id}_{field.id}")
        self.asked[name] = {code: label for code in range(256) if (label := shown(code)) is not None}
        return name

    def named_alike(self, field: Any, own: int, shown: Callable[[int], str | None]) -> str:
        """The list of a constant: the one that other fields of its name have, and that has its label."""
        fields = [one for told in self.definitions.values() for one in told["Fields"] if one["Id"] == field.id]
        alike = {one["LookupEnumeration"] for one in fields if "LookupEnumeration" in one} | set(NEW_LISTS)
        return next(name for name in sorted(alike) if self.labels(name).get(own, "") == shown(own))

    def names(self) -> list[str]:
        return sorted(entry["Name"] for entry in self.told["LookupEnumerations"]) + list(NEW_LISTS)

    def shows(self, shown: Callable[[int], str | None], name: str) -> bool:
        """Whether a field shows the labels of a list: nothing else at its first numbers, and all of them that fit."""
        labels = self.labels(name)
        return any(map(shown, labels)) and all(shown(code) == labels.get(code) for code in (*range(32), *labels))

    def lists(self) -> list[dict[str, Any]]:
        """Every list that a definition uses, sorted by name."""
        told = self.told
        pairs = {entry["Name"]: entry for entry in told["LookupIndirectEnumerations"]}
        keys = {entry["Name"]: entry for entry in told["LookupFieldTypeEnumerations"]}
        for name in keys.keys() & self.used:
            for value in keys[name]["EnumFieldTypeValues"]:
                self.used |= {value[k] for k in ("LookupEnumeration", "LookupBitEnumeration") if k in value}
        bits = {entry["Name"] for entry in told["LookupBitEnumerations"]}
        lines: list[dict[str, Any]] = []
        for name in sorted(self.used):
            if name in keys:
                fields = {str(value["value"]): _key(value) for value in keys[name]["EnumFieldTypeValues"]}
                lines.append({"keys": name, "fields": fields})
            elif name in pairs:
                lines.append({"pairs": name, "labels": _pairs(pairs[name])})
            elif name == "FUSION_SETTING_VALUE":
                lines.append({"pairs": name, "labels": _fusion_settings()})
            elif name in bits or _is_bits(name):
                lines.append({"flags": name, "labels": {str(bit): label for bit, label in DATABASE.bit_lookup(name)}})
            else:
                found = self.asked.get(name) or self.labels(name)
                lines.append({"lookup": name, "labels": {str(code): label for code, label in found.items()}})
        return lines


def _is_bits(name: str) -> bool:
    try:
        return bool(DATABASE.bit_lookup(name))
    except KeyError:
        return False


def _without_nothing(line: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in line.items() if value is not None}


def _resolution(kind: str, resolution: float | None) -> float | None:
    scaled = kind not in PLAIN or kind == "FLOAT"
    return _short(resolution) if scaled and resolution not in (None, 1.0) else None


def _short(number: float) -> float:
    return int(number) if number == int(number) else number


def _upper(name: str) -> str:
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).upper()


def _blank(info: Any) -> bytes:
    """The payload of a message without values: constants in place, all else not available."""
    try:
        return DATABASE.encode(info.id, {})
    except canboat.EncodeError:
        return b""  # of those with keys; canboat.json has them all


def _bits(field: Any, payload: bytes) -> int | None:
    if field.bit_offset is None or field.bit_length is None or field.bit_offset + field.bit_length > 8 * len(payload):
        return None
    return int.from_bytes(payload, "little") >> field.bit_offset & (1 << field.bit_length) - 1


def _with(field: Any, payload: bytes, raw: int) -> bytes:
    ones = (1 << field.bit_length) - 1
    bits = int.from_bytes(payload, "little") & ~(ones << field.bit_offset) | raw << field.bit_offset
    return bits.to_bytes(len(payload), "little")


def _signed(field: Any, told: dict[str, Any], blank: bytes) -> bool:
    if field.offset:  # a number counted from an offset has no sign on the wire
        return False
    ones = (1 << (field.bit_length or 1)) - 1
    sent = _bits(field, blank) if "Match" not in told else None
    if sent in (ones, ones >> 1) and ones > 1:
        return sent == ones >> 1
    return bool(told.get("Signed"))


def _matched(field: Any, blank: bytes) -> int | None:
    """The constant that a message without values has in this field."""
    raw = _bits(field, blank)
    ones = (1 << (field.bit_length or 0)) - 1
    return raw if field.field_type in ("LOOKUP", "NUMBER") and raw not in (None, ones, ones >> 1) else None


def _match(info: Any, field: Any, told: dict[str, Any], blank: bytes) -> int | None:
    return told["Match"] if "Match" in told else None if told else _matched(field, blank)


def _range(field: Any, told: dict[str, Any], signed: bool) -> list[int] | None:
    """The lowest and highest raw value where they are not those that the number of bits gives.

    canboat 9 keeps to the lower end of a range, and above to the values that mean something else.
    """
    bits = field.bit_length
    if bits is None or field.offset or not told.get("Resolution") or bool(told.get("Signed")) != signed:
        return None
    ones = (1 << bits) - 1
    highest = (ones >> 1 if signed else ones) - (3 if bits >= 8 else 2 if bits >= 4 else 1 if bits >= 2 else 0)
    lowest = -(1 << bits - 1) if signed else 0
    low = round(told.get("RangeMin", lowest) / told["Resolution"])
    low = low if low > lowest * (1 - 1e-6) + 1.5 and field.field_type != "MMSI" else lowest
    told_all = "UnknownValue" in told or bits == 64 or field.field_type == "MMSI"  # JSON has no numbers of 64 bits
    high = highest if told_all else ones >> signed
    return None if (low, high) == (lowest, highest) else [low, high]


def _shown(info: Any, field: Any, blank: bytes) -> Callable[[int], str | None]:
    """The label that a field shows for a number."""

    @cache
    def shown(raw: int) -> str | None:
        if raw >> field.bit_length:
            return None
        message = CODEC.decode(info.pgn, _with(field, blank, raw), 0, 255, 6)
        found = message.fields.get(field.id) if message is not None and message.id == info.id else None
        return found.value if found else None

    return shown


def _key(value: dict[str, Any]) -> dict[str, Any]:
    """The field that a key announces."""
    kind = value["FieldType"]
    resolution = _short(value.get("Resolution", 1))
    return _without_nothing(
        {
            "title": value["name"],
            "kind": kind if kind != "NUMBER" else None,
            "bits": int(value["Bits"]),
            "signed": value.get("Signed") or None,
            "resolution": resolution if resolution != 1 else None,
            "unit": value.get("Unit"),
            "lookup": value.get("LookupEnumeration") or value.get("LookupBitEnumeration"),
        }
    )


def _pairs(entry: dict[str, Any]) -> dict[str, dict[str, str]]:
    """Labels by the number of the field that it depends on, then its own."""
    found: dict[str, dict[str, str]] = {}
    for value in entry["EnumValues"]:
        found.setdefault(str(value["Value1"]), {})[str(value["Value2"])] = value["Name"]
    return found


def _fusion_settings() -> dict[str, dict[str, str]]:
    """What the values of Fusion's settings mean, asked number by number."""
    info = DATABASE.pgn_info("fusionSetSetting")
    setting, value = info.fields[-2:]
    found: dict[str, dict[str, str]] = {}
    for code in range(256):
        payload = _with(setting, _blank(info), code)
        shown = {}
        for raw in range(256):
            field = CODEC.decode(info.pgn, _with(value, payload, raw), 0, 255, 6).fields[value.id]
            if field.value is not None:
                shown[str(raw)] = field.value
        if shown:
            found[str(code)] = shown
    return found


if __name__ == "__main__":
    main(*sys.argv[1:])
