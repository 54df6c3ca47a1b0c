"""How values are written in JSON, a column of them at a time.

What stands for a column is what stands for each of its values, byte for byte: a text is made of every value that
occurs, and found again by the raw value where a field has 16 bits or less. Needs the extra `columns`.
"""

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from timonel.nmea2000.catalogue import Definition, Field
from timonel.nmea2000.catalogue_columns import AnyColumn, Mixed, listed, words
from timonel.nmea2000.fixed_columns import Column
from timonel.recording.decoded import as_json
from timonel.recording.sinks.texts import Texts, constant, decimals, where
from timonel.recording.sinks.texts import listed as texts_of

Text = Callable[[Any], str]
Codes = npt.NDArray[Any]
Mask = npt.NDArray[np.bool_]

HEXADECIMAL = np.array([b"%02X" % byte for byte in range(256)]).view("<u2")
"""The two characters of a byte."""

_BITS = 16
_NOTHING = 1  # the text that stands where there is no value; 0 is not made yet
_LONGEST = 10**15  # numbers that a float has exactly, and prints as they are
_MOST_PLACES = 13
_SMALLEST = 1e-4  # below it a float is printed with an exponent


class Notation:
    """Writes the columns of any definition: `, "heading": 2.3154`, or nothing. Without `labels` lookups are numbers."""

    def __init__(self, labels: bool = True) -> None:
        self._labels = labels
        self._known: dict[tuple[str, str, Field], Known] = {}

    def pieces(self, definition: Definition, columns: Mapping[str, AnyColumn]) -> list[Texts]:
        """What is to be put, in its order, for the columns of a definition or of a repeating set of it."""
        return [piece for name in columns for piece in self._pieces(definition, columns, name)]

    def _pieces(self, definition: Definition, columns: Mapping[str, AnyColumn], name: str) -> list[Texts]:
        column = columns[name]
        before = f', "{column.field.id}": '
        if isinstance(column, Mixed):
            return self._mixed(definition, before.encode(), column)
        if column.field.by and self._labels:
            return self._one_by_one(before.encode(), words(columns, name))
        return self._column(definition, before, column)

    def _column(self, definition: Definition, before: str, column: Column) -> list[Texts]:
        field, values = column.field, column.values
        if field.match is not None:
            value = field.labels.get(field.match, field.match) if self._labels else field.match
            return [constant(f"{before}{as_json(value)}".encode(), len(values))]
        if values.ndim == 2:
            return _bytes(before, column)
        if values.dtype == object:
            return self._one_by_one(before.encode(), listed(column))
        valid = _valid(column)
        if (codes := _codes(column)) is not None:
            return [self._known_of(definition, before, field).texts(codes, values, valid)]
        if self._labels and field.labels:
            return [_distinct(self._known_of(definition, before, field), column, valid)]
        return [_prefix(before.encode(), len(values), valid), _only(numbers(column), valid)]

    def _known_of(self, definition: Definition, before: str, field: Field) -> "Known":
        key = definition.id, before, field
        known = self._known.get(key)
        if known is None:
            told = self._told(field)
            make = lambda value: f"{before}{told(value)}".encode()  # noqa: E731
            known = self._known[key] = Known(_BITS, make)
        return known

    def _mixed(self, definition: Definition, before: bytes, column: Mixed) -> list[Texts]:
        """Values of many kinds: those of one kind at a time."""
        parts = [(rows, self._whole(definition, part)) for rows, part in column.parts]
        width = max((part.cells.shape[1] for _, part in parts), default=1)
        cells, sizes = np.zeros((column.rows, width), np.uint8), np.zeros(column.rows, np.intp)
        for rows, part in parts:
            cells[rows, : part.cells.shape[1]] = (
                part.cells if part.which is None else part.cells.take(part.which, axis=0)
            )
            sizes[rows] = part.sizes
        return [_prefix(before, column.rows, sizes > 0), Texts(cells, sizes)]

    def _whole(self, definition: Definition, column: Column) -> Texts:
        """The values of a column of one kind, with nothing before them."""
        if column.values.dtype == object:
            return self._texts(listed(column))
        (*_, piece) = self._column(definition, "", column)
        return piece

    def _told(self, field: Field) -> Text:
        """How a value of the field is written."""
        if not self._labels:
            return as_json
        if field.kind == "BITLOOKUP":
            return lambda code: as_json(set_bits(field, code))
        labels = field.labels
        return (lambda code: as_json(labels.get(code, code))) if labels else as_json

    def _one_by_one(self, before: bytes, values: list[Any]) -> list[Texts]:
        valid = np.array([value is not None for value in values], np.bool_)
        return [_prefix(before, len(values), None if valid.all() else valid), self._texts(values)]

    def _texts(self, values: list[Any]) -> Texts:
        made: dict[Any, bytes] = {(type(None), None): b""}
        return texts_of([self._text_of(value, made) for value in values])

    def _text_of(self, value: Any, made: dict[Any, bytes]) -> bytes:
        key = (type(value), value) if value.__hash__ else as_json(value)
        if key not in made:
            made[key] = as_json(plain(value)).encode()
        return made[key]


def _prefix(text: bytes, rows: int, valid: Mask | None) -> Texts:
    return constant(text, rows) if valid is None else where(valid, text)


def _bytes(before: str, column: Column) -> list[Texts]:
    """In hex, two characters a byte."""
    rows, width = column.values.shape
    sizes = np.full(rows, width) if column.sizes is None else column.sizes
    valid = sizes > 0 if column.valid is None else (sizes > 0) & column.valid
    digits = Texts(HEXADECIMAL[column.values].view(np.uint8), 2 * sizes * valid)
    return [where(valid, f'{before}"'.encode()), digits, where(valid, b'"')]


def plain(value: Any) -> Any:
    return value.hex().upper() if isinstance(value, bytes) else value


def set_bits(field: Field, code: int) -> list[str | int]:
    return [field.labels.get(bit, 1 << bit) for bit in range(field.bits or 0) if code >> bit & 1]


class Known:
    """The texts that were made so far of values that have a code of `bits` bits."""

    def __init__(self, bits: int, text: Callable[[Any], bytes]) -> None:
        self.text = text
        self._slot = np.zeros(1 << bits, np.uint32)
        self._cells, self._sizes = np.zeros((2, 1), np.uint8), np.zeros(2, np.intp)

    def texts(self, codes: Codes, values: npt.NDArray[Any], valid: Mask | None = None) -> Texts:
        """The text of each row's value, nothing where it is not `valid`."""
        which = self._slot.take(codes)
        if not which.all():
            new = which == 0 if valid is None else (which == 0) & valid
            self._make(codes[new], values[new])
            which = self._slot.take(codes)
        if valid is not None:
            which[~valid] = _NOTHING
        return Texts(self._cells, self._sizes, which)

    def _make(self, codes: Codes, values: npt.NDArray[Any]) -> None:
        distinct, first = np.unique(codes, return_index=True)
        made = texts_of([self.text(value) for value in values[first].tolist()])
        before, more = len(self._cells), len(distinct)
        self._slot[distinct] = np.arange(before, before + more)
        cells = np.zeros((before + more, max(self._cells.shape[1], made.cells.shape[1])), np.uint8)
        cells[:before, : self._cells.shape[1]] = self._cells
        cells[before:, : made.cells.shape[1]] = made.cells
        self._cells, self._sizes = cells, np.concatenate((self._sizes, made.lengths))


def _codes(column: Column) -> Codes | None:
    """The raw values, where they are of 16 bits or less: of the same value always the same."""
    values, field = column.values, column.field
    if values.dtype.kind in "iu":
        return values.view(f"u{values.dtype.itemsize}") if values.dtype.itemsize <= 2 else None
    if not field.bits or field.bits > 16 or field.kind == "FLOAT":
        return None
    with np.errstate(invalid="ignore"):
        return np.rint((values - field.offset) / field.resolution).astype(np.int32).astype(np.uint16)


def numbers(column: Column) -> Texts:
    """The numbers of a column as they are printed; where there is none, anything."""
    values = column.values
    if values.dtype.kind in "iu":
        if values.max(initial=0) < _LONGEST and values.min(initial=0) > -_LONGEST:
            return decimals(values.astype(np.int64), 0)
        return texts_of([str(value).encode() for value in values.tolist()])
    places = _places(column.field)
    values = np.nan_to_num(values)
    if places is None:
        return texts_of(_printed(values))
    magnitudes = np.abs(values)
    other = magnitudes >= _LONGEST / 10.0**places
    other |= (magnitudes < _SMALLEST) & (magnitudes > 0)
    rows = np.flatnonzero(other)
    if 2 * len(rows) > len(values):
        return texts_of(_printed(values))
    if not len(rows):
        return decimals(np.rint(values * 10.0**places).astype(np.int64), places)
    plain = decimals(np.rint(np.where(other, 0.0, values) * 10.0**places).astype(np.int64), places)
    return plain.replaced(rows, texts_of(_printed(values[rows])))


def _printed(values: npt.NDArray[np.float64]) -> list[bytes]:
    """As Python does it; msgspec is quicker, but writes exponents otherwise."""
    text = msgspec.json.encode(values.tolist())
    return (
        [repr(value).encode() for value in values.tolist()]
        if b"e" in text or b"0.0000" in text
        else text[1:-1].split(b",")
    )


@cache
def _places(field: Field) -> int | None:
    """Digits behind the point that all values of the field end within; None if they are too many to be exact."""
    if field.offset or field.kind == "FLOAT":
        return None
    steps = (float(field.resolution) * 10.0**places for places in range(_MOST_PLACES))
    return next(
        (places for places, step in enumerate(steps) if step > 0.5 and abs(step / round(step) - 1) < 1e-9), None
    )


def _only(texts: Texts, valid: Mask | None) -> Texts:
    return texts if valid is None else Texts(texts.cells, texts.lengths * valid)


def _distinct(known: Known, column: Column, valid: Mask | None) -> Texts:
    """A text for each value that there is."""
    values = column.values.view(f"i{column.values.dtype.itemsize}")
    distinct, which = np.unique(values, return_inverse=True)
    made = [known.text(value) for value in distinct.view(column.values.dtype).tolist()]
    texts = texts_of([b"", *made])
    return Texts(texts.cells, texts.lengths, which + 1 if valid is None else (which + 1) * valid)


def _valid(column: Column) -> Mask | None:
    """Which rows have a value; None for all."""
    if column.valid is not None or column.values.dtype.kind != "f":
        return column.valid
    nothing = np.isnan(column.values)
    return ~nothing if nothing.any() else None
