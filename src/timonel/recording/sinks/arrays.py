"""Columns as Arrow arrays: NumPy's memory is theirs, not copied, nor looked at value by value. Needs pyarrow."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from timonel.errors import RecordingError
from timonel.nmea2000.catalogue import Field
from timonel.recording.frames import NO_STAMP
from timonel.recording.sinks.notation import set_bits

try:
    import pyarrow as pa
except ImportError as missing:
    raise RecordingError("Arrow and Parquet need the extra `columns` (pip install 'timonel[columns]')") from missing

__all__ = ("TIME", "Words", "binary", "bitmap", "distinct", "numbers", "occurring", "pa", "sparse_texts", "times")

Values = npt.NDArray[Any]
Mask = npt.NDArray[np.bool_]
Places = npt.NDArray[np.int32]

TIME = pa.timestamp("us", "UTC")

_LIST = pa.list_(pa.string())
_TYPES = {np.dtype(code): pa.from_numpy_dtype(code) for code in "bBhHiIqQd"}


def numbers(values: Values, valid: Mask | None = None) -> Any:
    """Null where they are not valid or, floats, NaN."""
    if values.dtype.kind == "f":
        valid = values == values
    values = np.ascontiguousarray(values)
    buffers = [bitmap(valid), pa.py_buffer(values)]
    return pa.Array.from_buffers(_TYPES[values.dtype], len(values), buffers)


def bitmap(valid: Mask | None) -> Any:
    """What Arrow has for a mask, None if all are valid."""
    return None if valid is None or valid.all() else pa.py_buffer(np.packbits(valid, bitorder="little"))


def times(stamp: npt.NDArray[np.int64], day: int | None) -> Any:
    """Of ns since `day`, null where there is no stamp, all of them where there is no day."""
    if day is None:
        return pa.nulls(len(stamp), TIME)
    return numbers((stamp + (day + 500)) // 1000, stamp != NO_STAMP).view(TIME)


def binary(payloads: npt.NDArray[np.uint8], sizes: npt.NDArray[np.intp] | None, valid: Mask | None = None) -> Any:
    """The first bytes of each row of uint8[n, width], `sizes` of them, all if None."""
    rows, width = payloads.shape
    if sizes is None:
        data, sizes = payloads, np.full(rows, width)
    else:
        data = payloads[np.arange(width) < sizes[:, None]]
    return _pieces(pa.binary(), np.ascontiguousarray(data), sizes, valid)


def sparse_texts(texts: Sequence[tuple[int, str]], rows: int) -> Any:
    """Texts by their row; all other rows are null."""
    data = [(row, text.encode()) for row, text in sorted(texts)]
    sizes = np.zeros(rows, np.intp)
    valid = np.zeros(rows, np.bool_)
    there = [row for row, _ in data]
    sizes[there], valid[there] = [len(text) for _, text in data], True
    return _pieces(pa.string(), b"".join(text for _, text in data), sizes, valid)


def _pieces(kind: Any, data: Any, sizes: npt.NDArray[np.intp], valid: Mask | None) -> Any:
    buffers = [bitmap(valid), pa.py_buffer(_offsets(sizes)), pa.py_buffer(data)]
    return pa.Array.from_buffers(kind, len(sizes), buffers)


def _offsets(sizes: npt.NDArray[np.intp]) -> npt.NDArray[np.int32]:
    offsets = np.zeros(len(sizes) + 1, np.int32)
    np.cumsum(sizes, out=offsets[1:])
    return offsets


def distinct(codes: Values) -> tuple[Values, npt.NDArray[np.intp]]:
    """The codes that occur, each once, and which of them each row has."""
    if codes.dtype.itemsize > 2:
        return np.unique(codes, return_inverse=True)
    found = occurring(codes)
    rank = np.empty(1 << 8 * codes.dtype.itemsize, np.intp)
    rank[_unsigned(found)] = np.arange(len(found))
    return found, rank.take(_unsigned(codes))


def occurring(codes: Values) -> Values:
    """The codes of one or two bytes that occur, each once."""
    unsigned = _unsigned(codes)
    there = np.zeros(1 << 8 * codes.dtype.itemsize, np.bool_)
    there[unsigned] = True
    return np.flatnonzero(there).astype(unsigned.dtype).view(codes.dtype)


def _unsigned(codes: Values) -> Values:
    return codes.view(f"u{codes.dtype.itemsize}")


class Words:
    """The words of a lookup in the order in which they are met: dictionaries only grow."""

    def __init__(self, field: Field) -> None:
        self._field = field
        self._place: dict[str, int] = {}
        self._words = pa.array([], pa.string())
        self._places: Places = np.empty(0, np.int32)  # of the codes there can be, if they are few; -1: not met yet

    def array(self, codes: Values, valid: Mask | None) -> Any:
        """A dictionary array; a code without a word is its number."""
        if codes.dtype.itemsize > 2:
            found, which = distinct(codes)
            return self._dictionary(self._of(found).take(which), valid)
        unsigned = _unsigned(codes)
        if not len(self._places):
            self._places = np.full(1 << 8 * codes.dtype.itemsize, -1, np.int32)
        places = self._places.take(unsigned)
        if places.min(initial=0) < 0:
            new = occurring(codes[places < 0])
            self._places[_unsigned(new)] = self._of(new)
            places = self._places.take(unsigned)
        return self._dictionary(places, valid)

    def one_by_one(self, found: Sequence[str | int | None]) -> Any:
        """A dictionary array of words or numbers."""
        places = [-1 if word is None else self._place_of(str(word)) for word in found]
        indices = np.array(places, np.int32)
        return self._dictionary(np.maximum(indices, 0), indices >= 0)

    def lists(self, codes: Values, valid: Mask | None) -> Any:
        """The words of the bits that are set."""
        found, which = distinct(codes)
        made = [[str(word) for word in set_bits(self._field, code)] for code in found.tolist()]
        sizes = np.array([len(some) for some in made], np.intp).take(which)
        flat = [word for place in which[sizes > 0].tolist() for word in made[place]]
        buffers = [bitmap(valid), pa.py_buffer(_offsets(sizes))]
        return pa.Array.from_buffers(_LIST, len(codes), buffers, children=[pa.array(flat, pa.string())])

    def _of(self, codes: Values) -> Places:
        """Where the words of some codes stand."""
        labels = self._field.labels
        return np.array([self._place_of(str(labels.get(code, code))) for code in codes.tolist()], np.int32)

    def _place_of(self, word: str) -> int:
        return self._place.setdefault(word, len(self._place))

    def _dictionary(self, places: Places, valid: Mask | None) -> Any:
        if len(self._words) < len(self._place):
            self._words = pa.array(list(self._place), pa.string())
        # Arrow need not look again whether all places are in the dictionary.
        return pa.DictionaryArray.from_arrays(numbers(places, valid), self._words, safe=False)
