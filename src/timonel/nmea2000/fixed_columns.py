"""Fields of fixed size in many payloads at once, as NumPy columns. Needs the extra `columns`.

How a field is read is worked out once; then it is a handful of NumPy's operations, however few rows there are.
"""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from timonel.core.fields import Ascii, Number
from timonel.nmea2000.catalogue import Field
from timonel.nmea2000.catalogue_codec import text
from timonel.nmea2000.catalogue_layout import Choice, Decimal, Octets, OddOctets, Place, Ranged, Real, Run

Array = npt.NDArray[Any]
Payloads = npt.NDArray[np.uint8]
Rows = npt.NDArray[np.intp]
Mask = npt.NDArray[np.bool_]
WIDTHS = (1, 2, 4, 8)
_least, _most = np.minimum.reduce, np.maximum.reduce  # without the way that `min` and `max` take to them


class Column(msgspec.Struct, frozen=True):
    """The values of a field, one a row.

    float64 for a scaled number, NaN where there is none (`valid` is None then); an integer type for whole numbers,
    lookups and bit lookups, with `valid` False where there is none, None if all are valid; uint8[n, size] for bytes of
    fixed size, of which row i has `sizes[i]` (None: all of them); objects for text, and for fields whose size the
    message tells: str, bytes, None, numbers.
    """

    field: Field
    values: Array
    valid: Mask | None = None
    sizes: Rows | None = None


Reader = Callable[[Payloads, Rows | None], Column]
"""(uint8[n, width], how many bytes each row has, None that all have all) -> the values of a field."""
Raw = Callable[[Payloads], Array]
"""uint8[n, width] -> raw values, in the smallest type that holds them."""
Scaled = Callable[[Field, Array, Mask | None], Column]
"""(field, raw values, rows that are too short for it) -> values."""


@cache
def readers(run: Run) -> tuple[tuple[str, Reader], ...]:
    """How each field of a run is read, by its id."""
    return tuple((place.field.id, reader(place)) for place in run.values)


def run_columns(run: Run, block: Payloads, have: Rows | None) -> dict[str, Column]:
    """The values of all fields of a run; `block` and `have` are `Reader`'s."""
    return {name: read(block, have) for name, read in readers(run)}


@cache
def reader(place: Place) -> Reader:
    """How one field is read, in its place of a run."""
    field = place.field
    if field.match is not None:
        return _constant(field, np.dtype(_unsigned(place.bits)))
    match place.kind:
        case Octets():
            return lambda block, have: Column(field, *_octets(place, block, have))
        case Ascii():
            return lambda block, have: Column(field, _texts(place, block, have))
    raw, scaled, need = _raw(place), _scaled(place), place.need

    def read(block: Payloads, have: Rows | None) -> Column:
        short = None if have is None else 8 * have < need
        return scaled(field, raw(block), short if short is not None and short.any() else None)

    return read


def _constant(field: Field, kind: np.dtype[Any]) -> Reader:
    """One value that all rows share."""
    value = np.array([field.match], kind)
    value.flags.writeable = False
    return lambda block, have: Column(field, np.ndarray((len(block),), kind, value, 0, (0,)))


def _octets(place: Place, block: Payloads, have: Rows | None) -> tuple[Array, None, Rows | None]:
    part = block[:, place.first : place.first + place.bits // 8]
    return part, None, None if have is None else np.clip(have - place.first, 0, part.shape[1])


def _texts(place: Place, block: Payloads, have: Rows | None) -> Array:
    """Text: what there is of it."""
    part, _, sizes = _octets(place, block, have)
    found = pieces(part, np.full(len(part), part.shape[1]) if sizes is None else sizes)
    known = {raw: text(raw) for raw in set(found)}
    return objects([known[raw] for raw in found])


def _raw(place: Place) -> Raw:
    """Cuts them from the smallest word that covers the field."""
    bits, signed = place.bits, isinstance(place.kind, Number) and place.kind.signed
    last = -(-(place.offset + bits) // 8)
    size = next(width for width in WIDTHS if width >= last - place.first)
    least, spare = max(last, size), 8 * size - bits
    word, kept = f"<u{size}", f"<i{size}" if signed else f"<u{size}"
    smallest = f"<{'i' if signed else 'u'}{_bytes_for(bits)}"

    def whole(block: Payloads) -> Array:
        block = with_room(block, least)
        first = place.first
        return np.ascontiguousarray(block[:, first : first + size].view(kept)[:, 0])

    def cut(block: Payloads) -> Array:
        block = with_room(block, least)
        first = min(place.first, block.shape[1] - size)
        words, shift = block[:, first : first + size].view(word)[:, 0], place.offset - 8 * first
        if signed:
            raw: Array = (words << spare - shift).view(kept) >> spare
            return raw.astype(smallest, copy=False)
        if shift:
            words = words >> shift
        return (words & (1 << bits) - 1).astype(smallest, copy=False)

    return cut if spare else whole


def with_room(block: Payloads, width: int) -> Payloads:
    """The same with so many bytes a row, at least, that lie side by side."""
    if block.shape[1] < width:
        return np.pad(block, ((0, 0), (0, width - block.shape[1])))
    return block if block.strides[1] == 1 else np.ascontiguousarray(block)


def _bytes_for(bits: int) -> int:
    return next(width for width in WIDTHS if 8 * width >= bits)


def _unsigned(bits: int) -> str:
    return f"<u{_bytes_for(bits)}"


def _scaled(place: Place) -> Scaled:
    """What becomes of the raw values."""
    match place.kind:
        case Ranged(integral=True) as number:
            return _integers(number)
        case Ranged() as number:
            return _numbers(number)
        case Choice(highest=highest, ones=ones) if highest < ones:
            return lambda field, raw, short: _whole(field, raw, either(short, _above(raw, highest)))
        case Real(resolution=resolution):
            return lambda field, raw, short: Column(field, _finite(raw, short) * float(resolution))
        case Decimal(bits=bits):
            return lambda field, raw, short: _decimals(field, bits // 8, raw, short)
        case OddOctets(bits=bits):
            size = -(-bits // 8)
            return lambda field, raw, short: _whole(field, raw.view(np.uint8).reshape(len(raw), -1)[:, :size], short)
    return _whole


def _integers(number: Ranged) -> Scaled:
    outside = _outside(number)
    factor, offset = int(number.resolution), int(number.offset)

    def scaled(field: Field, raw: Array, short: Mask | None) -> Column:
        invalid = either(short, outside(raw))
        return _whole(field, raw if (factor, offset) == (1, 0) else raw.astype(np.int64) * factor + offset, invalid)

    return scaled


def _numbers(number: Ranged) -> Scaled:
    outside, shift = _outside(number), number.shift
    operation = np.multiply if number.inverse is None else np.divide
    factor = float(number.resolution if number.inverse is None else number.inverse)
    offset = number.offset if shift is None else 0

    def scaled(field: Field, raw: Array, short: Mask | None) -> Column:
        invalid = either(short, outside(raw))
        values: Array = operation(raw if shift is None else raw.astype(np.int64) + shift, factor, dtype=np.float64)
        if offset:
            values += offset
        if invalid is not None:
            values[invalid] = np.nan
        return Column(field, values)

    return scaled


def _outside(number: Number) -> Callable[[Array], Mask | None]:
    """Finds the rows with a raw value that is none; None if there are none."""
    (lowest, highest), bits = number.range, number.bits
    least = -(1 << bits - 1) if number.signed else 0
    if lowest <= least:
        return lambda raw: _above(raw, highest)
    return lambda raw: either(_above(raw, highest), raw < lowest if _least(raw, initial=0) < lowest else None)


def _above(raw: Array, highest: int) -> Mask | None:
    # To look for the largest one first is quicker than to compare all, and mostly there is no more to do.
    above: Mask | None = raw > highest if _most(raw, initial=0) > highest else None
    return above


def either(one: Mask | None, other: Mask | None) -> Mask | None:
    return other if one is None else one if other is None else one | other


def _whole(field: Field, values: Array, invalid: Mask | None) -> Column:
    return Column(field, values, None if invalid is None else ~invalid)


def _finite(raw: Array, short: Mask | None) -> Array:
    with np.errstate(invalid="ignore"):  # signalling NaN
        values = raw.view("<f4").astype(np.float64)
    values[~np.isfinite(values) if short is None else ~np.isfinite(values) | short] = np.nan
    return values


def _decimals(field: Field, size: int, raw: Array, short: Mask | None) -> Column:
    values, invalid = np.zeros(len(raw), np.int64), short
    for place in range(size):
        byte = (raw >> np.uint64(8 * place) & np.uint64(255)).astype(np.int64)
        values = 100 * values + byte
        invalid = either(invalid, _above(byte, 99))
    return _whole(field, values, invalid)


def pieces(payloads: Payloads, lengths: Rows) -> list[bytes]:
    """The first bytes of each row, `lengths` of them."""
    data, width = payloads.tobytes(), payloads.shape[1]
    starts = range(0, len(payloads) * width, width) if width else [0] * len(payloads)
    return [data[start : start + length] for start, length in zip(starts, lengths.tolist(), strict=True)]


def objects(values: Sequence[Any]) -> Array:
    """object[n]."""
    made = np.empty(len(values), object)
    made[:] = values
    return made
