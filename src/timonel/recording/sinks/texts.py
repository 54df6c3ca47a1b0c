"""Texts by the million in arrays, and a page on which they are put side by side. Needs the extra `columns`.

A text is a row of bytes of which only the first count. It is put on the page whole, and what is too much is covered
by the text that follows it; so texts are put in the order in which they are read, and what begins a line last of all.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

Cells = npt.NDArray[np.uint8]
Sizes = npt.NDArray[np.intp]
Numbers = npt.NDArray[np.int64]

SPARE = 64
"""The most bytes that do not count of a row that is put. What begins a line is longer, and covers them."""

_POWERS = 10 ** np.arange(19, dtype=np.uint64)
_QUADS = np.array([b"%04d" % number for number in range(10000)]).view("<u4")
_ZERO, _POINT, _MINUS = b"0.-"


class Texts(msgspec.Struct, frozen=True, eq=False, gc=False):
    """`cells` uint8[m, width], of which `sizes` bytes count; row i is text `which[i]`, or text i."""

    cells: Cells
    lengths: Sizes
    which: npt.NDArray[Any] | None = None

    @property
    def sizes(self) -> Sizes:
        """Bytes of each row."""
        return self.lengths if self.which is None else self.lengths.take(self.which)

    def block(self, rows: slice | Sizes) -> tuple[Cells, Sizes]:
        """The cells of some rows, and their sizes."""
        if self.which is None:
            return self.cells[rows], self.lengths[rows]
        which = self.which[rows]
        return self.cells.take(which, axis=0), self.lengths.take(which)

    def replaced(self, rows: Sizes, others: "Texts") -> "Texts":
        """The same with other texts in some rows; only for one text a row."""
        width = max(self.cells.shape[1], others.cells.shape[1])
        cells, lengths = self.cells, self.lengths.copy()
        if width > cells.shape[1]:
            cells = np.pad(cells, ((0, 0), (0, width - cells.shape[1])))
        cells[rows, : others.cells.shape[1]] = others.cells
        lengths[rows] = others.lengths
        return Texts(cells, lengths)


def listed(found: Sequence[bytes]) -> Texts:
    """One text a row."""
    lengths = np.fromiter(map(len, found), np.intp, len(found))
    width = max(1, int(lengths.max(initial=0)))
    cells = np.array(found, f"S{width}").view(np.uint8).reshape(len(found), width)
    return Texts(cells, lengths)


def constant(text: bytes, rows: int) -> Texts:
    """The same text in every row."""
    return Texts(np.frombuffer(text, np.uint8)[None], np.array([len(text)], np.intp), np.zeros(rows, np.intp))


def where(valid: npt.NDArray[np.bool_], text: bytes) -> Texts:
    """The text where `valid`, nothing elsewhere."""
    return Texts(
        np.frombuffer(text, np.uint8)[None].repeat(2, 0), np.array([0, len(text)], np.intp), valid.view(np.uint8)
    )


def decimals(numbers: Numbers, places: int) -> Texts:
    """`numbers` / 10**`places` as JSON has it: no zeros before or behind, but one digit behind the point.

    Without `places` whole numbers. Of 18 digits at most.
    """
    magnitudes = np.abs(numbers).astype(np.uint64)
    whole = 1 + np.searchsorted(_POWERS[1:], magnitudes, "right") - places
    digits = -(-max(places + 1, int(whole.max(initial=1)) + places) // 4) * 4
    cells = _digits(magnitudes, digits, places)
    integers = digits - places
    start = integers - np.maximum(whole, 1) + 1  # before it there is room for a sign
    end = np.full(len(numbers), cells.shape[1])
    if places > 1:
        end -= _zeros_behind(cells, places - 1)
    if (numbers < 0).any():
        negative = np.flatnonzero(numbers < 0)
        start[negative] -= 1
        cells[negative, start[negative]] = _MINUS
    return Texts(_from(cells, start), end - start)


def _digits(magnitudes: npt.NDArray[np.uint64], digits: int, places: int) -> Cells:
    """uint8[n, 1 + digits (+ 1)]: room for a sign, all digits, the point among them."""
    quads = np.empty((len(magnitudes), digits // 4), "<u4")
    left: npt.NDArray[Any] = magnitudes
    if digits <= 8 or int(magnitudes.max(initial=0)) < 1 << 32:
        left = magnitudes.astype(np.uint32)
    for place in range(digits // 4 - 1, 0, -1):
        higher = left // 10000
        quads[:, place] = _QUADS[left - higher * 10000]
        left = higher
    quads[:, 0] = _QUADS[left]
    plain = quads.view(np.uint8)
    cells = np.empty((len(plain), 1 + digits + bool(places)), np.uint8)
    point = 1 + digits - places
    cells[:, 1:point] = plain[:, : digits - places]
    if places:
        cells[:, point] = _POINT
        cells[:, point + 1 :] = plain[:, digits - places :]
    return cells


def _zeros_behind(cells: Cells, most: int) -> Sizes:
    """How many of the last digits of each row are zeros."""
    count = np.zeros(len(cells), np.intp)
    zeros = np.ones(len(cells), np.bool_)
    for place in range(1, most + 1):
        zeros &= cells[:, -place] == _ZERO
        if not zeros.any():
            break
        count += zeros
    return count


def _from(cells: Cells, start: Sizes) -> Cells:
    """Each row from `start` on."""
    width = cells.shape[1]
    padded = np.empty(cells.size + width, np.uint8)
    padded[: cells.size] = cells.ravel()
    rows = _windows(padded, width)[np.arange(len(cells)) * width + start]
    found: Cells = rows.view(np.uint8).reshape(len(cells), width)
    return found


def _windows(data: Cells, width: int) -> npt.NDArray[np.void]:
    """`width` bytes from each byte on."""
    return np.ndarray((len(data) - width + 1,), f"V{width}", data, 0, (1,))


class Page:
    """Bytes on which texts are put; `clear` makes it one of another size, without what stood there."""

    def __init__(self, size: int = 0) -> None:
        self._data = np.empty(0, np.uint8)
        self.clear(size)

    # Memory that was used before costs a fifth of what new memory does.
    def clear(self, size: int) -> None:
        self._size = size
        if len(self._data) < size + 4 * SPARE:
            self._data = np.empty(size + size // 4 + 4 * SPARE, np.uint8)

    @property
    def content(self) -> memoryview:
        """All that was put."""
        return self._data[: self._size].data

    def put(self, at: Sizes, cells: Cells, sizes: Sizes) -> None:
        """Put a text a row at its place; up to `SPARE` bytes behind it are spoilt."""
        if cells.shape[1] <= SPARE:
            self._put(at, cells)
            return
        for rows, width in _by_size(sizes, cells.shape[1]):
            self._put(at[rows], cells[rows, :width])

    def put_all(self, at: Sizes, text: bytes) -> None:
        """Put the same text at every place."""
        _windows(self._data, len(text))[at] = np.frombuffer(text, f"V{len(text)}")

    def put_one(self, at: int, text: bytes) -> None:
        self._data[at : at + len(text)] = np.frombuffer(text, np.uint8)

    def _put(self, at: Sizes, cells: Cells) -> None:
        width = cells.shape[1]
        if width and len(at):
            _windows(self._data, width)[at] = np.ascontiguousarray(cells).view(f"V{width}")[:, 0]


def _by_size(sizes: Sizes, width: int) -> Iterator[tuple[Sizes, int]]:
    """Rows that differ by less than `SPARE` bytes, and how many of them are put; empty ones not at all."""
    for below in range(0, width, SPARE):
        rows = np.flatnonzero((sizes > below) & (sizes <= below + SPARE))
        if len(rows):
            yield rows, min(width, below + SPARE)
