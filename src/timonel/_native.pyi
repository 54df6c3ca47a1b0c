"""Kernels in C (`native/`): bytes and numbers in arrays of their callers, who say what they mean.

Arrays are contiguous. Raises ValueError for those that are too small, and for places that are not in them.
"""

from typing import Any

Array = Any
"""Whatever has a buffer: bytes, NumPy's arrays."""

def candump_lines(text: Array, at: int, end: int, rows: Array, stamps: Array, filled: int, /) -> tuple[int, int]:
    """Whole lines of `text[at:end]` become rows and stamps from `filled` on, as long as there is room and they are of
    the shape: how many are filled then, and where the next line begins. Behind `end` there are 64 bytes."""

def frame_codes(rows: Array, table: Array, codes: Array, counts: Array, /) -> bool:
    """The code of each row in `table`, and how many rows have each; whether a row is a whole message."""

def single_frames(
    rows: Array,
    stamps: Array,
    codes: Array,
    next: Array,
    row: Array,
    stamp: Array,
    identifier: Array,
    length: Array,
    data: Array,
    /,
) -> None:
    """Rows with code c go from `next[c]` on, in their order; where it is negative they go nowhere."""

def fast_packets(
    rows: Array,
    now: Array,
    codes: Array,
    first: int,
    slots: Array,
    streams: Array,
    known: int,
    waiting: Array,
    row: Array,
    run: Array,
    begin: Array,
    last: Array,
    count: Array,
    slot: Array,
    dirty: Array,
    message: Array,
    offset: Array,
    payloads: Array,
    max_age: int,
    max_gap: int,
    longest: int,
    /,
) -> tuple[int, int, int]:
    """Rows with codes from `first` on are fast packets: how many streams are known then, how many runs there are, and
    messages that may be plain. -1 for the first if these are too many, or a row has no data."""

def cut_payloads(payloads: Array, offset: Array, size: Array, cells: Array, width: int, /) -> None:
    """`size` bytes from each offset, and zeros, to rows of `width` bytes."""
