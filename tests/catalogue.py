"""What the catalogue's two decoders make of payloads, as plain values that can be compared."""

import msgspec
import numpy as np

from timonel.nmea2000.catalogue_columns import columns, listed


def table(payloads, filler=0):
    """Payloads as uint8[n, width] and their lengths; behind a payload's end stands `filler`."""
    lengths = np.array([len(payload) for payload in payloads], np.intp)
    rows = np.full((len(payloads), lengths.max(initial=0)), filler, np.uint8)
    for row, payload in zip(rows, payloads, strict=True):
        row[: len(payload)] = np.frombuffer(payload, np.uint8)
    return rows, lengths


def by_row(definition, payloads, filler=0):
    """The columns of payloads, as one dictionary of values a row."""
    found = columns(definition, *table(payloads, filler), labels=False)
    rows = [{} for _ in payloads]
    _fill(rows, found.fields)
    for items in found.groups:
        values = [{} for _ in items.rows]
        _fill(values, items.fields)
        for row, value in zip(items.rows.tolist(), values, strict=True):
            rows[row].setdefault(items.group.name, []).append(value)
    return rows


def _fill(rows, fields):
    for name, column in fields.items():
        for row, value in zip(rows, listed(column), strict=True):
            if value is not None:
                row[name] = value


def plain(message):
    """The values of a decoded message by canboat's ids; what is not available is left out."""
    kind = type(message)
    pairs = zip(kind.__struct_encode_fields__, kind.__struct_fields__, strict=True)
    values = {name: getattr(message, attribute) for name, attribute in pairs}
    return {name: _plain(value) for name, value in values.items() if value is not None}


def _plain(value):
    if isinstance(value, list) and value and isinstance(value[0], msgspec.Struct):
        return [plain(item) for item in value]
    return value
