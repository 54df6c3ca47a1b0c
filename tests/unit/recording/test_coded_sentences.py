"""Kernels for sentences: what they refuse, so that no caller's mistake writes where it must not."""

import numpy as np
import pytest

from tests.unit.recording.sentences import sealed
from timonel import native
from timonel.recording.sentence_lines import LONGEST, padded

TEXT = padded(sealed("IIHDT,123.4,T").encode())
ROOM = np.zeros(1)
HASHES = np.zeros(1 << 15, np.uint16)


def place(number: int) -> np.ndarray:
    return np.array([number], np.int64)


def columns(*field: object, text=TEXT, begin=LONGEST, end=LONGEST + 17, wires=2, odd=b"\0") -> None:
    fields = (field or (0, 0, 0.0, 1.0, b"T", ROOM, ROOM),)
    native.kernels.sentence_columns(text, place(begin), place(end), wires, fields, bytearray(odd))


REFUSED = {
    "a text without paddings": lambda: native.kernels.sentence_lines(bytes(31), *(place(0),) * 5),
    "fewer lines": lambda: native.kernels.sentence_lines(TEXT, *(np.zeros(2, np.int64),) * 5),
    "too few ends": lambda: native.kernels.sentence_lines(TEXT, place(0), bytearray(7), *(place(0),) * 3),
    "too few flags": lambda: native.kernels.sentence_lines(TEXT, *(place(0),) * 4, bytearray(0)),
    "codes before": lambda: native.kernels.sentence_codes(TEXT, place(-1), place(9), HASHES, place(0), place(0)),
    "codes behind": lambda: native.kernels.sentence_codes(TEXT, place(99), place(9), HASHES, place(0), place(0)),
    "few hashes": lambda: native.kernels.sentence_codes(TEXT, place(0), place(9), HASHES[1:], place(0), place(0)),
    "codes without room": lambda: native.kernels.sentence_codes(
        TEXT, place(0), place(9), HASHES, place(0), bytearray(1)
    ),
    "few groups": lambda: native.kernels.sentence_groups(np.ones(1, np.uint16), *(place(0),) * 9),
    "groups without room": lambda: native.kernels.sentence_groups(
        HASHES[:2], np.zeros(2, np.int64), *(place(0),) * 8
    ),
    "a sentence before": lambda: columns(begin=LONGEST - 1),
    "a sentence behind": lambda: columns(end=len(TEXT) - LONGEST + 1),
    "a sentence that ends before it begins": lambda: columns(end=LONGEST + 2),
    "no flags": lambda: columns(odd=b""),
    "negative wires": lambda: columns(wires=-1),
    "very many wires": lambda: columns(wires=257),
    "very many fields": lambda: native.kernels.sentence_columns(
        TEXT, place(LONGEST), place(LONGEST + 17), 2, ((0, 0, 0.0, 1.0, b"", ROOM, ROOM),) * 65, bytearray(1)
    ),
    "no such kind": lambda: columns(9, 0, 0.0, 1.0, b"", ROOM, ROOM),
    "a negative kind": lambda: columns(-1, 0, 0.0, 1.0, b"", ROOM, ROOM),
    "a negative wire": lambda: columns(0, -1, 0.0, 1.0, b"", ROOM, ROOM),
    "a wire too many": lambda: columns(0, 2, 0.0, 1.0, b"", ROOM, ROOM),
    "a unit's wire too many": lambda: columns(0, 1, 0.0, 1.0, b"T", ROOM, ROOM),
    "a side's wire too many": lambda: columns(1, 1, 0.0, 1.0, b"EW", ROOM, ROOM),
    "a side's unit too many": lambda: columns(1, 0, 0.0, 1.0, b"EWN", ROOM, ROOM),
    "a side without letters": lambda: columns(2, 0, 0.0, 1.0, b"E", ROOM, ROOM),
    "values without room": lambda: columns(0, 0, 0.0, 1.0, b"", bytearray(7), ROOM),
    "flags without room": lambda: columns(5, 0, 0.0, 1.0, b"", ROOM, bytearray(0)),
    "sizes without room": lambda: columns(8, 0, 0.0, 1.0, b"", ROOM, bytearray(7)),
}  # fmt: skip


def test_a_kernel_takes_what_is_right():
    values = np.zeros(1)
    columns(0, 0, 0.0, 360.0, b"T", values, values)
    assert values.tolist() == [123.4]


@pytest.mark.parametrize("name", REFUSED)
def test_arrays_that_are_too_small_and_places_outside_of_them_are_refused(name):
    with pytest.raises(ValueError):
        REFUSED[name]()
