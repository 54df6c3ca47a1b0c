"""canboat 9.0.0's own decoder, out of the PyPI package `nmea2000`: values in the units of canboat.json."""

from datetime import date
from functools import cache

from nmea2000 import _canboat as canboat
from nmea2000.consts import FieldTypes
from nmea2000.native_units import NATIVE_UNITS

DATABASE = canboat.Database("si")
EPOCH = date(1970, 1, 1)
LABELLED = {"LOOKUP", "INDIRECT_LOOKUP", "DYNAMIC_FIELD_KEY"}
SILENT = {"RESERVED", "SPARE"}
SCALED, LABEL, NUMBER, OWN = 0, 1, 2, 10  # how the package is told to give a value; its `backend.py` explains them


class _Value:
    def __init__(self, *told):
        self.id, _, _, _, self.value, self.raw, *_ = told


class _Message:
    def __init__(self, **told):
        self.id, self.fields = told["id"], told["fields"]


@cache
def kinds(identifier):
    """Field id -> kind and number of bits."""
    return {field.id: (field.field_type, field.bit_length) for field in DATABASE.pgn_info(identifier).fields}


def _template(identifier):
    rows = []
    for field in DATABASE.pgn_info(identifier).fields:
        unit, resolution, offset = NATIVE_UNITS.get((identifier, field.id), (None, None, None))
        mode = SCALED if resolution else _mode(field.field_type)
        rows.append((field.id, "", None, unit, None, FieldTypes.NUMBER, False, mode, resolution, offset or 0.0, False))
    return None, FieldTypes.VARIABLE, rows


def _mode(kind):
    return LABEL if kind in LABELLED else NUMBER if kind in SILENT else OWN


_CODEC = canboat.MessageCodec(_template, _Value, _Message, "native")


def decode(pgn, payload):
    """The definition's id, and its values with names as in `items`; None, {} for what it cannot decode."""
    try:
        message = _CODEC.decode(pgn, payload, 0, 255, 6)
    except canboat.DecodeError:
        return None, {}
    if message is None:
        return None, {}
    return message.id, dict(_values(message.id, message.fields, ""))


def _values(identifier, fields, prefix):
    for field in fields:
        if field.id.startswith("##list"):
            for number, item in enumerate(field.value):
                yield from _values(identifier, item.values(), f"{prefix}{field.id.strip('#')}.{number}.")
        elif (value := _value(*kinds(identifier)[field.id], field)) is not None:
            yield prefix + field.id, value


def _value(kind, bits, field):
    if kind in SILENT:
        return None
    value = field.value
    if kind in LABELLED and value is None and field.raw is not None:
        special = 3 if bits >= 8 else 2 if bits >= 4 or bits == 2 else 1
        return field.raw if field.raw < (1 << bits) - special else None
    if isinstance(value, date):
        return (value - EPOCH).days
    if isinstance(value, bytes):
        return value.hex().upper()
    return int(value) if kind == "DECIMAL" and value is not None else value


def items(values, prefix=""):
    """Names and values of a decoded message: `list.0.prn` is that of the first item of its list."""
    for name, value in values.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            for number, item in enumerate(value):
                yield from items(item, f"{prefix}{name}.{number}.")
        elif value is not None:
            yield prefix + name, value
