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
CHUNK = 1 << 15  # rows at a time, so that what is worked on stays in the processor's cache


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


def _fit(message: "type[Message]", payloads: Payloads) -> Payloads:
    """Rows with all fields before the first variable one; what is missing is not available."""
    blank = _blank(message)
    missing = blank.size - payloads.shape[1]
    if missing <= 0:
        return payloads if payloads.strides[1] == 1 else np.ascontiguousarray(payloads)
    mask = (1 << blank.kept(payloads.shape[1])) - 1
    keep, fill = (np.frombuffer(bits.to_bytes(blank.size, "little"), np.uint8) for bits in (mask, blank.bits & ~mask))
    return np.pad(payloads, ((0, 0), (0, missing))) & keep | fill


@cache
def _blank(message: "type[Message]") -> codec.Blank:
    first = next(iter(codec.parts(message)), None)
    return codec.blank(first) if isinstance(first, codec.Run) else codec.Blank(0, 0, (0,))


def _fill(column: Column, slot: "Slot", rows: Payloads) -> None:
    assert isinstance(slot.field, Fixed)
    assert slot.offset is not None
    first, shift = divmod(slot.offset, 8)
    end = -(-(slot.offset + slot.field.bits) // 8)
    _convert(column, slot.field, _raw(slot.field, shift, rows[:, first:end]))


def _raw(field: Fixed, shift: int, data: Payloads) -> Raw:
    """The raw values, cut from the bytes that cover the field."""
    word = _word(data)
    spare = 8 * word.itemsize - field.bits
    if isinstance(field, Number) and field.signed:
        return (word << spare - shift if spare else word).view(f"<i{word.itemsize}") >> spare
    return word >> shift & field.ones if spare else word


def _word(data: Payloads) -> Raw:
    """Little-endian words of all bytes of a row."""
    size = data.shape[1]
    if size in WIDTHS:
        return np.ascontiguousarray(data.view(f"<u{size}")[:, 0])
    word = np.zeros(len(data), f"<u{next(width for width in WIDTHS if width > size)}")
    for place in range(size):
        word |= data[:, place].astype(word.dtype) << 8 * place
    return word


def _convert(column: Column, field: Fixed, raw: Raw) -> None:
    """Raw values to what they mean."""
    if not isinstance(field, Number):
        column[:] = raw
        if isinstance(field, Lookup):
            _forget(column, raw > field.highest)
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
    _forget(column, invalid)


def _forget(column: Column, invalid: npt.NDArray[np.bool_]) -> None:
    if invalid.any():
        column[invalid] = np.nan
