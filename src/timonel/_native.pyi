"""Kernels in C (`native/`): bytes and numbers in arrays of their callers, who say what they mean.

Arrays are contiguous. Raises ValueError for those that are too small, and for places that are not in them.
"""

from typing import Any

Array = Any
"""Whatever has a buffer: bytes, NumPy's arrays."""

def candump_lines(text: Array, at: int, end: int, rows: Array, stamps: Array, filled: int, /) -> tuple[int, int]:
    """Whole lines of `text[at:end]` become rows and stamps from `filled` on, as long as there is room and they are of
    the shape: how many are filled then, and where the next line begins. Behind `end` there are 64 bytes."""

def captured_frames(
    capture: Array, at: int, count: int, packets: tuple[int, int, int, int, int, bool], rows: Array, stamps: Array, /
) -> int:
    """How many packets from `at` on became frames, up to the first of another kind. Of all `packets`: their size, how
    much is captured of each, where the frame and (or -1) the protocol stand, how many ns a fraction counts, and whether
    numbers are of the other byte order than the machine's."""

def recorded_frames(chunk: Array, at: int, bus: int, latest: int, rows: Array, stamps: Array, /) -> tuple[int, int]:
    """How many frames stand in the messages of `bus` from `at` on, and where the first record begins that is no message
    or is not made of frames, or has longer ones than eight bytes, or a time that is not before `latest`, ns."""

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
    counts: Array,
    limits: tuple[int, int, int],
    slots: Array,
    streams: Array,
    known: int,
    waiting: Array,
    row: Array,
    begin: Array,
    last: Array,
    count: Array,
    slot: Array,
    dirty: Array,
    place: Array,
    message: Array,
    completed: Array,
    identifier: Array,
    size: Array,
    offset: Array,
    payloads: Array,
    /,
) -> tuple[int, int, int]:
    """Rows with codes from `first` on, of which there are `counts`, are fast packets: how many streams are known then,
    how many runs there are, and how many of the frames, whose `row` is told, are in none that is plain. -1 for the
    first if these are too many, or a row has no data. Messages that may be plain stand from where as many of them begin
    as there are frames of the codes before up to `place` of their own code; `message` is the run of each."""

def cut_payloads(payloads: Array, offset: Array, size: Array, cells: Array, width: int, /) -> None:
    """`size` bytes from each offset, and zeros, to rows of `width` bytes."""

def gather(flat: Array, places: Array, cells: Array, size: int, /) -> None:
    """`size` bytes from each place, side by side."""

def values_by_kind(
    flat: Array, kinds: Array, places: Array, left: Array, order: Array, words: Array, ends: Array, least: Array, /
) -> int:
    """How many `kinds` (uint16) there are. The numbers of the places by kind, and the eight bytes `words` that stand
    there; `ends` is where those of each kind end, `least` how much is left behind those of a kind at least."""

def item_places(
    flat: Array, steps: Array, values: Array, at: Array, end: Array, count: Array, least: int, found: Array,
    places: Array, /,
) -> int:  # fmt: skip
    """Where the items of each payload stand, and how many there are, which is returned for all; `at` becomes where they
    end."""

def sentence_lines(text: Array, begin: Array, end: Array, behind: Array, stamp: Array, plain: Array, /) -> None:
    """Where sentences, or other lines, begin, where their characters end, where the next lines begin, the sentences'
    times, and which lines have a plain one, alone or behind a time of usual shape."""

def sentence_codes(text: Array, begin: Array, end: Array, by_hash: Array, letters: Array, codes: Array, /) -> None:
    """The number of each sentence's formatter, where `by_hash` tells the number of its letters; 0 for all others."""

def sentence_groups(
    codes: Array, ends: Array, begin: Array, end: Array, line: Array, stamp: Array, to_begin: Array, to_end: Array,
    to_line: Array, to_stamp: Array, /,
) -> None:  # fmt: skip
    """Sentences in the order of their codes, those with one code in the order in which they were; and where the ones
    with each code end."""

def sentence_columns(
    text: Array, begin: Array, end: Array, wires: int, fields: tuple[tuple[Any, ...], ...], odd: Array, /
) -> None:
    """The columns of these sentences, and which sentences are not as usual; `fields` are tuples (how, wire, low, high,
    letters, values, valid)."""

def json_lines(
    texts: Array,
    slots: Array,
    steps: Array,
    owners: Array,
    made: Array,
    sizes: Array,
    tables: Array,
    page: Array,
    state: Array,
    gaps: Array,
    columns: list[Array],
    day: int,
    timed: bool,
    /,
) -> tuple[int, int, int]:
    """The lines of frames from `state` on: of table n by its steps where the owner is n + 1, the next ones of `made`
    where it is -1. Why it stopped, and at which step and code. Lines that it left out are told in `gaps`."""
