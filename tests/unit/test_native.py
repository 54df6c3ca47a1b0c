"""The compiled kernels: what they refuse, so that no caller's mistake writes where it must not."""

import numpy as np
import pytest

from hatch_build import compiled
from timonel import native
from timonel.recording.frames import FRAME, Frames, empty

FRAMES = 4
LINE = b"(1669809600.001488) can0 0DF11917#00FF7F1F02A3FFFF\n"


def numbers(count):
    return np.zeros(count, np.int64)


def each(count):
    """So many arrays of one number."""
    return [numbers(1) for _ in range(count)]


SMALL = [numbers(1)] * 11
SLOTS, STREAMS = np.zeros(1 << 22, np.uint8), np.zeros(0x130000, np.uint16)
PLENTY = [numbers(64)] * 12


def begun(room):
    """The first arguments of `fast_packets`: four rows of one code."""
    return room.rows, room.stamp, np.ones(FRAMES, np.uint16), 1, np.array([0, FRAMES], np.uint32), (1, 1, 1)


def test_they_are_compiled():
    assert native.kernels is not None, "not compiled: python3 hatch_build.py says why"


def test_they_compile_without_a_warning(tmp_path):
    assert compiled(tmp_path / "kernels.so", "-Wall", "-Wextra", "-Werror") is None


def test_lines_end_where_there_is_no_more_room():
    room = empty(2)
    text = LINE * FRAMES + bytes(64)
    assert native.kernels.candump_lines(text, 0, len(LINE) * FRAMES, room.rows, room.stamp, 0) == (2, 2 * len(LINE))


def test_nothing_is_read_within_64_bytes_of_the_end_of_the_text():
    room = empty(2)
    assert native.kernels.candump_lines(LINE, 0, len(LINE), room.rows, room.stamp, 0) == (0, 0)


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("candump_lines", lambda room: (LINE, 0, len(LINE) + 1, room.rows, room.stamp, 0)),
        ("candump_lines", lambda room: (LINE, -1, len(LINE), room.rows, room.stamp, 0)),
        ("candump_lines", lambda room: (LINE, 0, len(LINE), room.rows, numbers(1), 0)),
        ("captured_frames", lambda room: (bytes(31), 0, 1, (32, 16, 16, -1, 1, False), room.rows, room.stamp)),
        ("captured_frames", lambda room: (bytes(64), 0, 2, (32, 16, 16, 31, 1, False), room.rows, room.stamp)),
        ("captured_frames", lambda room: (bytes(320), 0, 10, (32, 16, 16, -1, 1, False), room.rows, room.stamp)),
        ("recorded_frames", lambda room: (bytes(200), 0, 1, 1 << 62, room.rows, room.stamp)),
        ("recorded_frames", lambda room: (bytes(90), 0, 1, 1 << 62, room.rows, numbers(1))),
        ("recorded_frames", lambda room: (bytes(90), 91, 1, 1 << 62, room.rows, room.stamp)),
        ("recorded_frames", lambda room: (bytes(90), -1, 1, 1 << 62, room.rows, room.stamp)),
        ("frame_codes", lambda room: (room.rows, numbers(1), numbers(1), numbers(1))),
        ("single_frames", lambda room: (room.rows, *(numbers(1) for _ in range(8)))),
        ("fast_packets", lambda room: (*begun(room), *SMALL[:2], 0, *SMALL, *SMALL[:3])),
        ("fast_packets", lambda room: (*begun(room), SLOTS, STREAMS, 0, b"", numbers(3), *PLENTY)),
        ("fast_packets", lambda room: (*begun(room), SLOTS, STREAMS, 8192, b"", numbers(4), *PLENTY)),
        ("fast_packets", lambda room: (*begun(room), SLOTS, STREAMS, 0, b"", numbers(4), *PLENTY[1:], bytearray(1))),
        ("values_by_kind", lambda room: (bytes(8), np.zeros(1, np.uint16), numbers(1) + 1, *each(5))),
        ("values_by_kind", lambda room: (bytes(8), np.zeros(1, np.uint16), numbers(1) - 1, *each(5))),
        ("values_by_kind", lambda room: (bytes(8), np.zeros(2, np.uint16), *each(6))),
        ("cut_payloads", lambda room: (bytes(8), numbers(1), numbers(1) + 9, bytearray(8), 8)),
        ("cut_payloads", lambda room: (bytes(8), numbers(1) - 1, numbers(1) + 1, bytearray(8), 8)),
        ("gather", lambda room: (bytes(8), numbers(1) + 7, bytearray(8), 2)),
        ("gather", lambda room: (bytes(8), numbers(2), bytearray(2), 2)),
        ("item_places", lambda room: (bytes(8), numbers(2), numbers(1), *(numbers(1),) * 3, 1, numbers(1), numbers(1))),
    ],
)  # fmt: skip
def test_arrays_that_are_too_small_and_places_outside_of_them_are_refused(name, arguments):
    room = Frames(np.zeros(FRAMES, FRAME), numbers(FRAMES))
    with pytest.raises(ValueError):
        getattr(native.kernels, name)(*arguments(room))


def test_items_stop_where_the_room_for_their_places_ends():
    steps, values, eight = np.array([[0, 1]], np.int64), numbers(1 << 16), numbers(1) + 8
    with pytest.raises(ValueError, match="too few"):
        native.kernels.item_places(bytes(8), steps, values, numbers(1), eight, eight, 1, numbers(1), numbers(2))
