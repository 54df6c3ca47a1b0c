"""Whole recordings at once: the fields of many payloads as NumPy columns. Needs the extra `columns`."""

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from timonel.core import codec
from timonel.core.fields import Bits, Fixed, Flags, Lookup, Number

if TYPE_CHECKING:
    from timonel.core.message import Message, Slot

Column = npt.NDArray[np.float64]
Payloads = npt.NDArray[np.uint8]
Raw = npt.NDArray[np.integer]
VALUES = Number | Lookup | Bits | Flags
WIDTHS = (1, 2, 4, 8)
CHUNK = 1 << 14  # rows at a time, so that what is worked on stays in the processor's cache


def columns(message: "type[Message]", payloads: Payloads) -> dict[str, Column]:
    """Decode uint8[n, size] into one float64[n] per field, in the field's unit, NaN where not available.

    Lookups and flags are their numbers. Text, bytes, repeated fields and what stands behind a field of
    variable size have no column. The values are those of `message.decode`, bit for bit.
    """
    slots = [slot for slot in message.layout if slot.offset is not None and isinstance(slot.field, VALUES)]
    rows = _fit(message, payloads)
    block = np.empty((len(slots), len(rows)))  # in one piece: the kernel gives it in huge pages
    for start in range(0, len(rows), CHUNK):
        chunk = slice(start, start + CHUNK)
        for column, slot in zip(block, slots, strict=True):
            _fill(column[chunk], slot, rows[chunk])
    return {slot.name: column for slot, column in zip(slots, block, strict=True)}


def _end(slot: "Slot") -> int:
    """The end of a field in bytes."""
    assert slot.offset is not None
    assert slot.length is not None
    return -(-(slot.offset + slot.length) // 8)


def _fit(message: "type[Message]", payloads: Payloads) -> Payloads:
    """Rows with all fields before the first variable one; what is missing is not available."""
    first = codec.parts(message)[:1]
    blank = codec.blank(first[0]) if first and isinstance(first[0], codec.Run) else codec.Blank(0, 0, (0,))
    missing = blank.size - payloads.shape[1]
    if missing <= 0:
        return payloads if payloads.strides[1] == 1 else np.ascontiguousarray(payloads)
    mask = (1 << blank.kept(payloads.shape[1])) - 1
    keep, fill = (np.frombuffer(bits.to_bytes(blank.size, "little"), np.uint8) for bits in (mask, blank.bits & ~mask))
    return np.pad(payloads, ((0, 0), (0, missing))) & keep | fill


def _fill(column: Column, slot: "Slot", rows: Payloads) -> None:
    assert isinstance(slot.field, Fixed)
    assert slot.offset is not None
    first, shift = divmod(slot.offset, 8)
    size = _end(slot) - first
    if size == 1:
        column[:] = _table(slot.field, shift)[rows[:, first]]
    else:
        _convert(column, slot.field, _raw(slot.field, shift, rows[:, first : first + size]))


@cache
def _table(field: Fixed, shift: int) -> Column:
    """What each value of a byte means to a field within it."""
    column = np.empty(256)
    _convert(column, field, _cut(field, np.arange(256, dtype=np.uint64) >> np.uint64(shift)))
    return column


def _convert(column: Column, field: Fixed, raw: Raw) -> None:
    """Raw values to what they mean."""
    if not isinstance(field, Number):
        column[:] = raw
        if isinstance(field, Lookup):
            column[raw > field.highest] = np.nan
        return
    if field.inverse is not None:
        np.divide(raw, float(field.inverse), out=column, dtype=np.float64)
    else:
        np.multiply(raw, float(field.resolution), out=column, dtype=np.float64)
    if field.offset:
        column += field.offset
    lowest, highest = field.range
    invalid = raw > highest
    if lowest:
        invalid |= raw < lowest
    if invalid.any():
        column[invalid] = np.nan


def _raw(field: Fixed, shift: int, data: Payloads) -> Raw:
    """The raw values: words where the field is one, else cut from the bytes that cover it."""
    size = data.shape[1]
    if shift == 0 and field.bits == 8 * size and size in WIDTHS:
        kind = "i" if isinstance(field, Number) and field.signed else "u"
        return np.ascontiguousarray(data.view(f"<{kind}{size}")[:, 0])
    word = np.zeros(len(data), np.uint64)
    for place in range(size):
        word |= data[:, place].astype(np.uint64) << np.uint64(8 * place)
    return _cut(field, word >> np.uint64(shift))


def _cut(field: Fixed, word: npt.NDArray[np.uint64]) -> Raw:
    """The lowest bits of a word, with their sign."""
    raw = word & np.uint64(field.ones)
    if isinstance(field, Number) and field.signed:
        sign = 1 << field.bits - 1
        return (raw.astype(np.int64) ^ sign) - sign
    return raw
