"""Decimal numbers that stand in a text, very many at a time. Needs the extra `columns`.

Up to sixteen characters are worked on at once, in two 64-bit words: the point is squeezed out, what is left must be
digits, and is added up in pairs, fours and eights. The values are those of `float`, bit for bit: up to fifteen
digits, whole number and power of ten are exact, and their quotient is rounded as it is there.
"""

from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

LONGEST = 16
"""Characters; `text` must be readable for as many before and behind each number."""

Text = npt.NDArray[np.uint8]
Places = npt.NDArray[np.intp]
Words = npt.NDArray[np.uint64]
Flags = npt.NDArray[np.bool_]

_POWERS = 10.0 ** np.arange(LONGEST)
_EXACT = 10**15


class Decimals(msgspec.Struct, frozen=True, eq=False, gc=False):
    """`fine` is where there is a plain number, with a point and a minus sign or without; elsewhere nothing means it."""

    fine: Flags
    digits: npt.NDArray[np.int64]
    """The number without its point."""
    places: npt.NDArray[np.int8]
    """Digits behind the point, -1 without a point."""
    negative: Flags

    @property
    def values(self) -> npt.NDArray[np.float64]:
        """float64[n]."""
        values = self.digits / _POWERS.take(np.maximum(self.places, 0))
        return np.negative(values, out=values, where=self.negative) if self.negative.any() else values

    def __getitem__(self, which: Any) -> "Decimals":
        return Decimals(*(column[which] for column in msgspec.structs.astuple(self)))


def decimals(text: Text, begin: Places, end: Places) -> Decimals:
    """The numbers in `text[begin[i]:end[i]]`."""
    size = end - begin
    negative = (text.take(begin) == ord("-")) & (size > 0)
    low = _load(text, np.maximum(begin, end - 8))
    missing = np.maximum(8 - size, 0)
    low <<= (8 * missing).astype(np.uint64)
    if negative.any():
        _clear_sign(low, missing, negative & (size <= 8))
    low, places = _without_point(low)
    missing += places >= 0
    missing += negative
    fine = _become_digits(low, missing)
    fine &= missing < 8
    digits = eight_digits(low)
    long = np.flatnonzero(size > 8)
    if len(long):
        fine[long], digits[long], places[long] = _long(text, begin[long], end[long], negative[long])
    return Decimals(fine, digits.view(np.int64), places, negative)


def _long(text: Text, begin: Places, end: Places, negative: Flags) -> tuple[Flags, Words, npt.NDArray[np.int8]]:
    """Numbers of more than eight characters."""
    size = end - begin
    missing = np.maximum(LONGEST - size, 0)
    high = _load(text, begin) << (8 * missing).astype(np.uint64)
    _clear_sign(high, missing, negative)
    low, places = _without_point(_load(text, end - 8))
    within = places >= 0
    high, places_high = _without_point(high)
    low |= np.where(within, high >> 56, 0)
    high <<= np.where(within, np.uint64(8), np.uint64(0))
    missing += negative
    missing += within | (places_high >= 0)
    fine = _become_digits(low, np.maximum(missing - 8, 0))
    fine &= _become_digits(high, missing)
    fine &= (size <= LONGEST) & ~(within & (places_high >= 0))
    digits = eight_digits(high) * np.uint64(10**8) + eight_digits(low)
    fine &= digits < _EXACT
    return fine, digits, np.where(places_high >= 0, places_high + np.int8(8), places)


def _load(text: Text, at: Places) -> Words:
    """Eight characters, the first one lowest."""
    words: Words = np.ndarray(len(text) - 7, "<u8", text, 0, (1,))[at]
    return words


def _clear_sign(words: Words, missing: Places, negative: Flags) -> None:
    """A minus sign becomes one more character that is not there."""
    words &= ~np.where(negative, np.uint64(0xFF) << (8 * missing).astype(np.uint64), 0)


def _without_point(words: Words) -> tuple[Words, npt.NDArray[np.int8]]:
    """The words with what is before the first point moved over it; how many characters are behind it, or -1."""
    other = words ^ repeated(ord("."))
    point = (other - repeated(1)) & ~other & repeated(0x80)
    point &= ~point + 1
    places = (7 - (np.bitwise_count(point - 1) >> 3)).astype(np.int8)
    before = (point >> 7) - 1
    squeezed = (words & before) << 8 | words & ~(before | (point >> 7) * 0xFF)
    return np.where(places >= 0, squeezed, words), places


def _become_digits(words: Words, missing: Places) -> Flags:
    """Turn characters into digits, of which the first are missing; where there was nothing else."""
    words ^= np.uint64(repeated(ord("0"))) << (8 * missing).astype(np.uint64)
    fine: Flags = (words | words + repeated(6)) & repeated(0xF0) == 0
    return fine


def eight_digits(digits: Words, out: Words | None = None) -> Words:
    """The numbers of eight decimal digits, one a byte, the first one lowest; in `out`, if it is given."""
    numbers = np.multiply(digits, 10 << 8 | 1, out=out)
    numbers >>= 8
    numbers &= 0x00FF00FF00FF00FF
    numbers *= 100 << 16 | 1
    numbers >>= 16
    numbers &= 0x0000FFFF0000FFFF
    numbers *= 10000 << 32 | 1
    numbers >>= 32
    return numbers


def repeated(byte: int) -> int:
    return byte * 0x0101010101010101
