"""Sentences of one kind to columns: the values that `nmea0183.registry.parse` gives, many at a time.

What stands in a field as senders usually write it is read here; a sentence with anything else in a field is left to
that parser, and its values put in their places. Needs the extra `columns`.
"""

from collections.abc import Callable, Sequence
from datetime import date
from enum import Enum
from functools import cache, cached_property
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from timonel.nmea0183 import fields
from timonel.nmea0183.registry import parse
from timonel.nmea0183.sentence import Sentence, layout
from timonel.nmea0183.sentences import ALC, XDR
from timonel.recording.decimals import Decimals, Flags, Places, Text, decimals

Array = npt.NDArray[Any]
_VALID_MODES = np.zeros(256, np.bool_)
_VALID_MODES[[0, *(ord(mode) for mode in fields.VALID_MODES if mode)]] = True  # 0 is none
LISTS = (ALC, XDR)
"""Kinds with any number of fields: their sentences are read one by one."""
_NUMBERS = (fields.Number, fields.Signed, fields.Position, fields.TimeOfDay, fields.Date, fields.Integer)


class Column(msgspec.Struct, frozen=True, eq=False, gc=False):
    """The values of an attribute, one a sentence.

    float64 with NaN, datetime64[D] with NaT, or bytes (letters and text, ISO 8859-1) with b"", where there is none;
    bool and int64 with `valid` False where there is none; objects for what stands in lists (ALC, XDR).
    """

    values: Array
    valid: Flags | None = None

    def some(self, rows: Places) -> "Column":
        return Column(self.values[rows], None if self.valid is None else self.valid[rows])


Columns = dict[str, Column]


class Wires(msgspec.Struct, frozen=True, eq=False, dict=True):
    """Where the comma-separated fields of sentences stand: `begin` and `end` intp[fields, n] in `text`; where there is
    no such field, both are 0."""

    text: Text
    begin: Places
    end: Places

    @cached_property
    def sizes(self) -> Places:
        """intp[fields, n]: characters."""
        sizes: Places = self.end - self.begin
        return sizes

    @cached_property
    def ones(self) -> Flags:
        """bool[fields, n]: where there is one character."""
        ones: Flags = self.sizes == 1
        return ones

    @cached_property
    def nothing(self) -> Flags:
        """bool[fields, n]: where there is none."""
        nothing: Flags = self.sizes == 0
        return nothing

    def only(self, wire: int, letters: str) -> Flags:
        """Where a field is one of these letters."""
        first = self.text.take(self.begin[wire])
        found: Flags = first == ord(letters[0])
        for letter in letters[1:]:
            found |= first == ord(letter)
        found &= self.ones[wire]
        return found


class _Reading(msgspec.Struct, frozen=True, eq=False):
    """What the kinds of field read from: the wires, the numbers that stand in some, and which sentences are odd."""

    wires: Wires
    numbers: dict[int, Decimals]
    odd: Flags

    def empty(self, wire: int) -> Flags:
        empty: Flags = self.wires.nothing[wire]
        return empty

    def need(self, usual: Flags) -> None:
        np.logical_or(self.odd, ~usual, out=self.odd)


def mended(columns: Columns, odd: Flags, lines: Callable[[Places], list[bytes]]) -> tuple[Columns, Flags]:
    """The columns with the values of odd sentences, and which are malformed (what their rows have means nothing).

    `lines` gives some of the sentences, from `$` to the check sum.
    """
    malformed = np.zeros(len(odd), np.bool_)
    rows = np.flatnonzero(odd)
    if len(rows):
        sentences = [parse(line) for line in lines(rows)]
        read = [isinstance(sentence, Sentence) for sentence in sentences]
        malformed[rows] = np.logical_not(read)
        fine = [sentence for sentence in sentences if isinstance(sentence, Sentence)]
        columns = {name: _with(column, rows[read], fine, name) for name, column in columns.items()}
    return columns, malformed


def unread(kind: type[Sentence], count: int) -> tuple[Columns, Flags]:
    """The columns of a kind of `LISTS`, and that all sentences are odd."""
    columns = {name: Column(np.full(count, None, object)) for name in kind.__struct_fields__}
    return columns, np.ones(count, np.bool_)


def usual(kind: type[Sentence], wires: Wires) -> tuple[Columns, Flags]:
    """The columns of sentences of one kind, and which are odd: they have a field that is not as usual."""
    plan = plan_of(kind)
    numeric = [wire for _, wire, field in plan if isinstance(field, _NUMBERS)]
    count = wires.begin.shape[1]
    found = decimals(wires.text, wires.begin[numeric].ravel(), wires.end[numeric].ravel())
    numbers = {wire: found[place * count : (place + 1) * count] for place, wire in enumerate(numeric)}
    reading = _Reading(wires, numbers, np.zeros(count, np.bool_))
    columns = {name: _READ[type(field)](reading, wire, field) for name, wire, field in plan}
    return with_modes(kind, columns), reading.odd


def with_modes(kind: type[Sentence], columns: Columns) -> Columns:
    """A status that depends on a mode is settled when both are read."""
    for name, _, field in plan_of(kind):
        if isinstance(field, fields.Status) and field.mode:
            columns[name].values[~_VALID_MODES.take(columns[field.mode].values.view(np.uint8))] = False
    return columns


@cache
def plan_of(kind: type[Sentence]) -> list[tuple[str, int, fields.Field]]:
    """Each attribute with the first of its wires."""
    found, wire = [], 0
    for name, field in layout(kind).items():
        found.append((name, wire, field))
        wire += field.wires
    return found


@cache
def count_of_wires(kind: type[Sentence]) -> int:
    """How many comma-separated fields a kind has."""
    return 0 if kind in LISTS else sum(field.wires for field in layout(kind).values())


def _number(reading: _Reading, wire: int, field: Any) -> Column:
    number, empty = reading.numbers[wire], reading.empty(wire)
    values = number.values
    reading.need(number.fine & (values >= field.low) & (values <= field.high) | empty)
    values[empty] = np.nan
    _need_unit(reading, wire + 1, field.unit)
    return Column(values)


def _need_unit(reading: _Reading, wire: int, unit: str) -> None:
    if unit:
        reading.need(reading.wires.only(wire, unit) | reading.empty(wire))


def _signed(reading: _Reading, wire: int, field: Any) -> Column:
    number = reading.numbers[wire]
    missing = reading.empty(wire) | reading.empty(wire + 1)
    values = number.values
    _need_side(reading, wire, field, missing, number.fine & ~number.negative & (values <= field.high))
    _need_unit(reading, wire + 2, field.unit)
    return Column(_towards(reading, wire, field, values, missing))


def _position(reading: _Reading, wire: int, field: Any) -> Column:
    number = reading.numbers[wire]
    missing = reading.empty(wire) | reading.empty(wire + 1)
    value = number.values
    degrees = value // 100.0
    minutes = value - degrees * 100.0
    values = degrees + minutes / 60.0
    usual = number.fine & ~number.negative & (minutes < 60.0) & (values <= field.limit)
    _need_side(reading, wire, field, missing, usual)
    return Column(_towards(reading, wire, field, values, missing))


def _need_side(reading: _Reading, wire: int, field: Any, missing: Flags, usual: Flags) -> None:
    there = usual & reading.wires.only(wire + 1, field.positive + field.negative)
    reading.need(there | missing & (reading.numbers[wire].fine | reading.empty(wire)))


def _towards(reading: _Reading, wire: int, field: Any, values: Array, missing: Flags) -> Array:
    np.subtract(0.0, values, out=values, where=reading.wires.only(wire + 1, field.negative))
    values[missing] = np.nan
    return values


def _time_of_day(reading: _Reading, wire: int, field: Any) -> Column:
    number, empty = reading.numbers[wire], reading.empty(wire)
    places = np.maximum(number.places, 0).astype(np.int64)
    whole = reading.wires.sizes[wire] - 1 - number.places == 6
    unit = 10**places
    clock, second = np.divmod(number.digits, 100 * unit)
    seconds = second / unit
    hour, minute = np.divmod(clock, 100)
    usual = number.fine & ~number.negative & whole & (hour < 24) & (minute < 60) & (seconds < 60.0)
    reading.need(usual | empty)
    values = (hour * 60 + minute) * 60 + seconds
    values[empty] = np.nan
    return Column(values)


def _date(reading: _Reading, wire: int, field: Any) -> Column:
    number, empty = reading.numbers[wire], reading.empty(wire)
    day, rest = np.divmod(number.digits, 10_000)
    month, year = np.divmod(rest, 100)
    months = (year + np.where(year >= 80, 1900, 2000) - 1970) * 12 + month - 1
    first, following = ((months + step).astype("datetime64[M]").astype("datetime64[D]") for step in (0, 1))
    values = first + (day - 1)
    six = (reading.wires.sizes[wire] == 6) & number.fine & (number.places < 0) & ~number.negative
    reading.need(six & (month >= 1) & (month <= 12) & (day >= 1) & (values < following) | empty)
    values[empty] = np.datetime64("NaT")
    return Column(values)


def _integer(reading: _Reading, wire: int, field: Any) -> Column:
    number, empty = reading.numbers[wire], reading.empty(wire)
    values = np.where(number.negative, -number.digits, number.digits)
    usual = number.fine & (number.places < 0) & (values >= field.low) & (values <= field.high)
    reading.need(usual | empty)
    return Column(values, ~empty)


def _letter(reading: _Reading, wire: int, field: Any) -> Column:
    empty = reading.empty(wire)
    reading.need(reading.wires.only(wire, "".join(letter for letter in field.choices if len(letter) == 1)) | empty)
    return Column(np.where(empty, 0, reading.wires.text.take(reading.wires.begin[wire])).astype(np.uint8).view("S1"))


def _status(reading: _Reading, wire: int, field: Any) -> Column:
    return Column(reading.wires.only(wire, "A"), ~reading.empty(wire))


def _text(reading: _Reading, wire: int, field: Any) -> Column:
    begin, size = reading.wires.begin[wire], reading.wires.sizes[wire]
    width = max(1, int(size.max(initial=0)))
    place = np.arange(width)
    there = place < size[:, None]
    cells = np.where(there, reading.wires.text.take(np.where(there, begin[:, None] + place, 0)), 0).astype(np.uint8)
    reading.need(~(cells == ord("^")).any(axis=1))
    return Column(cells.view(f"S{width}")[:, 0])


_READ: dict[type[fields.Field], Callable[[_Reading, int, Any], Column]] = {
    fields.Number: _number,
    fields.Angle: _number,
    fields.Signed: _signed,
    fields.Position: _position,
    fields.TimeOfDay: _time_of_day,
    fields.Date: _date,
    fields.Integer: _integer,
    fields.Letter: _letter,
    fields.Status: _status,
    fields.Text: _text,
}


def _with(column: Column, rows: Places, sentences: Sequence[Sentence], name: str) -> Column:
    """The column with the values of sentences that were read one by one."""
    found = [getattr(sentence, name) for sentence in sentences]
    values, valid = column.values, column.valid
    match values.dtype.kind:
        case "f":
            values[rows] = [np.nan if value is None else value for value in found]
        case "M":
            values[rows] = np.array([value if isinstance(value, date) else "NaT" for value in found], "datetime64[D]")
        case "S":
            texts = np.array([_text_of(value) for value in found], "S")
            values = values.astype(np.promote_types(values.dtype, texts.dtype))
            values[rows] = texts
        case "O":
            for row, value in zip(rows.tolist(), found, strict=True):
                values[row] = value
        case _:
            assert valid is not None
            values[rows] = [value or 0 for value in found]
            valid[rows] = [value is not None for value in found]
    return Column(values, valid)


def _text_of(value: Any) -> bytes:
    text = value.value if isinstance(value, Enum) else value or ""
    return str(text).encode("latin-1")
