"""Frames in arrays: what goes in comes out."""

import numpy as np

from timonel.recording import LogFrame
from timonel.recording.frames import EXTENDED, NO_STAMP, Gatherer, concatenate, empty, from_logframes

SHORT = LogFrame(1620807235.135421, 0x09F8017F, b"\x3e\x17\xb3")
STANDARD = LogFrame(None, 0x6C, bytes(range(8)), extended=False)
LONG = LogFrame(1.5, 0x09F8017F, bytes(range(100)), whole=True)


def test_frames_come_out_as_they_went_in():
    assert list(from_logframes([SHORT, STANDARD, LONG]).logframes()) == [SHORT, STANDARD, LONG]


def test_a_row_is_socketcans_frame():
    assert from_logframes([SHORT]).rows.tobytes() == bytes.fromhex("7f01f889 03000000 3e17b30000000000")


def test_a_stamp_is_whole_microseconds_in_nanoseconds():
    assert from_logframes([SHORT, STANDARD]).stamp.tolist() == [1620807235135421000, NO_STAMP]


def test_a_stamp_that_no_clock_shows_is_none():
    frames = from_logframes([LogFrame(stamp, 1, b"") for stamp in (float("nan"), float("inf"), 1e12, -1e12)])
    assert frames.stamp.tolist() == [NO_STAMP] * 4


def test_a_frame_of_more_than_eight_bytes_counts_as_whole():
    frames = from_logframes([LogFrame(None, 108, bytes(10), extended=False)])
    assert frames.whole.tolist() == [True]
    assert frames.payload(0) == bytes(10)


def test_a_slice_keeps_its_long_messages():
    assert list(from_logframes([SHORT, LONG, STANDARD])[1:].logframes()) == [LONG, STANDARD]


def test_frames_put_behind_each_other_keep_their_long_messages():
    other = LogFrame(2.5, 0x09F8017E, bytes(range(50, 70)), whole=True)
    parts = [from_logframes([LONG, SHORT]), from_logframes([]), from_logframes([STANDARD, other, LONG])]
    assert list(concatenate(parts).logframes()) == [LONG, SHORT, STANDARD, other, LONG]


def test_gathered_frames_come_in_chunks_with_their_long_messages():
    other = LogFrame(2.5, 0x09F8017E, bytes(range(50, 70)), whole=True)
    gathered = Gatherer(3)
    for frames in ([LONG], [SHORT, other], [STANDARD, other], [LONG], [SHORT]):
        gathered.put(from_logframes(frames))
    chunks = [list(chunk.logframes()) for chunk in (*gathered.chunks(), *gathered.finish())]
    assert chunks == [[LONG, SHORT, other], [STANDARD, other, LONG], [SHORT]]


def test_what_is_more_than_a_chunk_is_a_chunk_of_its_own():
    gathered = Gatherer(2)
    gathered.put(from_logframes([SHORT]))
    gathered.put(from_logframes([SHORT, LONG, STANDARD]))
    assert [len(chunk) for chunk in gathered.finish()] == [1, 3]
    assert gathered.finish() == []


def test_no_frames_put_behind_each_other_are_none():
    assert len(concatenate([])) == 0


def test_identifier_and_data_are_columns():
    frames = from_logframes([SHORT, STANDARD])
    assert frames.identifier.tolist() == [0x09F8017F | EXTENDED, 0x6C]
    assert frames.length.tolist() == [3, 8]
    assert frames.data.tolist() == [[0x3E, 0x17, 0xB3, 0, 0, 0, 0, 0], list(range(8))]


def test_room_is_for_as_many_frames_as_asked_for():
    assert len(empty(5)) == 5
    assert empty(5).stamp.dtype == np.int64
