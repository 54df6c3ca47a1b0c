"""Sentences of one kind to columns by the compiled kernels: what stands in a field as senders usually write it.

A sentence with anything else in a field is odd, as in `sentence_columns`. Needs the extra `columns`.
"""

from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from timonel import native
from timonel.nmea0183 import fields
from timonel.nmea0183.sentence import Sentence
from timonel.recording.decimals import Flags, Places, Text
from timonel.recording.sentence_columns import Column, Columns, count_of_wires, plan_of, with_modes
from timonel.recording.sentence_lines import Sentences

Array = npt.NDArray[Any]
Codes = npt.NDArray[np.uint16]
# As in native/sentences.c.
_NUMBER, _SIGNED, _POSITION, _TIME_OF_DAY, _DATE, _INTEGER, _LETTER, _STATUS, _TEXT = range(9)
_VALID = {_INTEGER: np.bool_, _STATUS: np.bool_, _TEXT: np.intp}
"""What the kernel writes beside the values: where there are some; of texts, which begin at the values, their size."""


class _Coded(msgspec.Struct, frozen=True, gc=False):
    """An attribute: what its field is to the kernel, in which range, of which letters; and the type of its values."""

    name: str
    how: int
    wire: int
    kind: str
    low: float = 0.0
    high: float = 0.0
    letters: bytes = b""

    @property
    def code(self) -> tuple[int, int, float, float, bytes]:
        return self.how, self.wire, self.low, self.high, self.letters

    def room(self, count: int) -> tuple[Array, Array]:
        values = np.empty(count, self.kind)
        return values, np.empty(count, _VALID[self.how]) if self.how in _VALID else values


def grouped(codes: Codes, sentences: Sentences) -> Iterator[tuple[int, Sentences]]:
    """Those that have the same code, in their order."""
    ends = np.empty(int(codes.max(initial=0)) + 1, np.intp)
    places = sentences.begin, sentences.end, sentences.line, sentences.stamp
    begin, end, line, stamp = (np.empty_like(each) for each in places)
    native.kernels.sentence_groups(codes, ends, *places, begin, end, line, stamp)
    found = Sentences(sentences.text, begin, end, line, stamp, None)
    for code, (first, last) in enumerate(pairwise([0, *ends.tolist()])):
        if first < last:
            yield code, found[first:last]


def coded(kind: type[Sentence], sentences: Sentences) -> tuple[Columns, Flags]:
    """The columns of sentences of one kind, and which are odd: they have a field that is not as usual."""
    plan, text = _plan(kind), sentences.text
    odd = np.zeros(len(sentences), np.bool_)
    rooms = [each.room(len(sentences)) for each in plan]
    wanted = tuple((*each.code, *room) for each, room in zip(plan, rooms, strict=True))
    native.kernels.sentence_columns(text, sentences.begin, sentences.end, count_of_wires(kind), wanted, odd)
    columns = {each.name: _column(each, text, *room) for each, room in zip(plan, rooms, strict=True)}
    return with_modes(kind, columns), odd


def _column(each: _Coded, text: Text, values: Array, valid: Array) -> Column:
    if each.how == _DATE:
        return Column(values.view("M8[D]"))
    if each.how == _TEXT:
        return Column(_cut(text, values, valid))
    return Column(values, valid if each.how in _VALID else None)


def _cut(text: Text, begin: Places, size: Places) -> Array:
    width = max(1, int(size.max(initial=0)))
    cells = np.empty(len(size), f"S{width}")
    native.kernels.cut_payloads(text, begin, size, cells, width)
    return cells


@cache
def _plan(kind: type[Sentence]) -> list[_Coded]:
    return [_Coded(name, *_code(wire, field)) for name, wire, field in plan_of(kind)]


def _code(wire: int, field: fields.Field) -> tuple[Any, ...]:
    match field:
        case fields.Number():
            return _NUMBER, wire, "f8", field.low, field.high, field.unit.encode()
        case fields.Signed():
            letters = field.positive + field.negative + field.unit
            return _SIGNED, wire, "f8", 0.0, field.high, letters.encode()
        case fields.Position():
            letters = field.positive + field.negative
            return _POSITION, wire, "f8", 0.0, field.limit, letters.encode()
        case fields.TimeOfDay():
            return _TIME_OF_DAY, wire, "f8"
        case fields.Date():
            return _DATE, wire, "i8"
        case fields.Integer():
            return _INTEGER, wire, "i8", field.low, field.high
        case fields.Letter():
            letters = "".join(letter for letter in field.choices if len(letter) == 1)
            return _LETTER, wire, "S1", 0.0, 0.0, letters.encode()
        case fields.Status():
            return _STATUS, wire, "?"
        case _:
            return _TEXT, wire, "i8"
