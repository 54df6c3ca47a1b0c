"""Actisense's binary messages, as a stream and in EBL."""

import struct

import pytest

from tests.unit.recording.writers import bdtp, bst, bst_d0, ebl_tag, ebl_time, raw_frame
from timonel.nmea2000.identifier import NULL, Identifier, split
from timonel.recording import LogFrame, Unreadable
from timonel.recording.actisense import Ebl, Ngt1

# From a recording: PGN 129025, priority 2, source 127, data with a DLE in their check sum.
POSITION = bytes.fromhex("9313 0201F801FF7F AF3A0A09 08 E715B322C318590D CA")
DATA = bytes.fromhex("E715B322C318590D")


def read(form, *pieces):
    reader = form(b"".join(pieces))
    found = [each for piece in pieces for each in reader.receive(piece)]
    return [*found, *reader.finish()]


def told(results):
    return [(each.place, each.reason) for each in results if isinstance(each, Unreadable)]


def test_a_message_that_the_gateway_heard_has_its_time_and_address():
    (frame,) = read(Ngt1, bdtp(POSITION))
    assert frame == LogFrame(151_665.327, 0x09F8017F, DATA)


def test_a_message_to_send_has_no_time_and_no_source():
    content = bytes((6,)) + (127503).to_bytes(3, "little") + bytes((255, 20)) + bytes(20)
    (frame,) = read(Ngt1, bdtp(bst(0x94, content)))
    assert split(frame.identifier) == Identifier(6, 127503, NULL, 255)
    assert (frame.stamp, frame.data, frame.whole) == (None, bytes(20), True)


def test_a_message_with_a_destination_has_it_whatever_stands_in_the_lowest_byte_of_its_pgn():
    content = bytes((6,)) + (59904 + 35).to_bytes(3, "little") + bytes((35, 7)) + bytes(4) + b"\x03\x14\xf0\x01"
    (frame,) = read(Ngt1, bdtp(bst(0x93, content)))
    assert split(frame.identifier) == Identifier(6, 59904, 7, 35)


def test_a_raw_frame_is_a_frame_even_of_a_fast_packet():
    (frame,) = read(Ngt1, bdtp(raw_frame(LogFrame(2.5, 0x0DF8057F, b"\x602+\x00GI\xa0\x08"))))
    assert frame == LogFrame(2.5, 0x0DF8057F, b"\x602+\x00GI\xa0\x08")


@pytest.mark.parametrize(("resolution", "tick"), [(0, 1e-3), (1, 1e-4), (2, 1e-5), (3, 1e-6)])
def test_the_clock_of_raw_frames_goes_on_when_its_sixteen_bits_are_used_up(resolution, tick):
    identifier = 0x09F8017F | resolution << 29
    stream = (bdtp(bst(0x95, struct.pack("<HI", ticks, identifier) + b"\1")) for ticks in (65_000, 65_535, 0, 10))
    frames = read(Ngt1, *stream)
    assert {frame.identifier for frame in frames} == {0x09F8017F}
    assert [frame.stamp for frame in frames] == pytest.approx([n * tick for n in (65_000, 65_535, 65_536, 65_546)])


def test_a_frame_that_is_marked_as_sent_is_a_frame():
    (frame,) = read(Ngt1, bdtp(bst(0x95, struct.pack("<HI", 1000, 0x89F8017F) + b"\1\2")))
    assert frame == LogFrame(1.0, 0x09F8017F, b"\1\2")


def test_the_newer_kind_of_message_is_read():
    content = bytes((255, 7, 0x05, 0xF8, 3 << 2 | 1, 0x21)) + (5250).to_bytes(4, "little") + bytes(43)
    (frame,) = read(Ngt1, bdtp(bst_d0(content)))
    assert (frame.stamp, split(frame.identifier)) == (5.25, Identifier(3, 129029, 7, 255))
    assert (frame.data, frame.whole) == (bytes(43), True)


def test_what_the_gateway_says_of_itself_is_passed_over():
    assert read(Ngt1, bdtp(bst(0xA0, b"\xf2\x01\x0e\x00")), bdtp(POSITION)) == [LogFrame(151_665.327, 0x09F8017F, DATA)]
    own = b"\x00" + (0x40100).to_bytes(3, "little") + bytes(6) + b"\x01\x02"
    assert read(Ngt1, bdtp(bst(0x93, own))) == []


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (POSITION[:-1] + b"\xcb", "wrong check sum"),
        (b"", "wrong check sum"),
        (bst(0x93, b"\x02\x01\xf8"), "wrong length of its data"),
        (bst(0x93, POSITION[2:12] + b"\x07" + DATA), "wrong length of its data"),
        (bst(0x94, b"\x02\x01"), "wrong length of its data"),
        (bst(0x95, b"\x02\x01"), "not a frame of 0..8 bytes"),
        (bst(0x95, bytes(6 + 9)), "not a frame of 0..8 bytes"),
        (bst_d0(b"\xff\x07"), "too short"),
        (bst(0x93, POSITION[2:-1])[:-1] + b"\x00\xca", "wrong length"),
        (bst_d0(bytes((255, 7, 5, 0xF8, 9, 0)) + bytes(4 + 224)), "224 bytes are not 0..223"),
    ],
)
def test_a_message_that_is_not_well_formed_is_told_with_its_place(message, reason):
    results = read(Ngt1, b"\x55" + bdtp(POSITION), bdtp(message), bdtp(POSITION))
    assert [each for each in results if isinstance(each, LogFrame)] == [LogFrame(151_665.327, 0x09F8017F, DATA)] * 2
    assert told(results) == [
        ("byte 0", "1 bytes of nothing that is known"),
        (f"byte {1 + len(bdtp(POSITION))}", reason),
    ]


def test_bytes_between_messages_are_told_once_however_they_come():
    noise = bytes(range(17, 117))
    pieces = [bdtp(POSITION), *(noise[n : n + 1] for n in range(100)), bdtp(POSITION)]
    whole, cut = read(Ngt1, b"".join(pieces)), read(Ngt1, *pieces)
    assert whole == cut
    assert told(cut) == [("byte 26", "100 bytes of nothing that is known")]


def test_a_message_that_never_ends_does_not_fill_the_memory():
    pieces = [b"\x10\x02" + bytes(5000), bytes(5000), bdtp(POSITION)]
    results = read(Ngt1, *pieces)
    assert [each for each in results if isinstance(each, LogFrame)] == [LogFrame(151_665.327, 0x09F8017F, DATA)]
    assert told(results) == [("byte 0", "10002 bytes of nothing that is known")]


def test_the_times_of_ebl_count_and_its_bytes_are_undoubled():
    escapes = bst(0x93, POSITION[2:13] + b"\x1b\x10\x1b\x1b\x10\x01\x0a\x02")
    stream = ebl_time(1.5e9) + bdtp(escapes).replace(b"\x1b", b"\x1b\x1b") + ebl_time(1.5e9 + 27) + bdtp(POSITION)
    assert read(Ebl, stream) == [
        LogFrame(1.5e9, 0x09F8017F, b"\x1b\x10\x1b\x1b\x10\x01\x0a\x02"),
        LogFrame(1.5e9 + 27, 0x09F8017F, DATA),
    ]
    assert read(Ebl, *(stream[n : n + 1] for n in range(len(stream)))) == read(Ebl, stream)


def test_a_message_of_ebl_before_any_time_has_none():
    assert read(Ebl, bdtp(POSITION), ebl_time(1.5e9)) == [LogFrame(None, 0x09F8017F, DATA)]


def test_a_tag_may_hold_a_message_with_its_check_sum_or_without():
    frame = raw_frame(LogFrame(1.0, 0x09F8017F, DATA))
    tags = ebl_time(1.5e9) + ebl_tag(b"\x07" + frame) + ebl_tag(b"\x07" + frame[:-1])
    assert read(Ebl, tags) == [LogFrame(1.5e9, 0x09F8017F, DATA)] * 2
    assert told(read(Ebl, ebl_time(1.5e9), ebl_tag(b"\x07" + frame[:-1] + b"\x00"))) == [("byte 13", "wrong check sum")]


def test_other_tags_are_passed_over_and_a_time_that_cannot_be_is_told():
    assert read(Ebl, ebl_tag(b"\x01\xea\x03\x00\x00"), ebl_tag(b"\x02words"), ebl_tag(b"\x05\x01")) == []
    assert told(read(Ebl, ebl_tag(b"\x03" + b"\xff" * 8))) == [
        ("byte 0", "1833029933770.955 s is no time of a recording")
    ]


def test_an_escape_out_of_place_costs_what_it_stands_in():
    results = read(Ebl, ebl_time(1.5e9), b"\x1b\x42", bdtp(POSITION), b"\x1b\x01\x03\x00")
    assert [each for each in results if isinstance(each, LogFrame)] == [LogFrame(1.5e9, 0x09F8017F, DATA)]
    assert told(results) == [("byte 13", "2 bytes of nothing that is known"), ("byte 41", "cut off")]


def test_a_stream_is_known_by_a_right_check_sum():
    assert Ngt1.recognises(b"\x00" + bdtp(POSITION))
    assert not Ngt1.recognises(bdtp(POSITION[:-1] + b"\xcb"))
    assert not Ngt1.recognises(bdtp(POSITION)[:-1])
    assert not Ebl.recognises(bdtp(POSITION))
    assert Ebl.recognises(ebl_tag(b"\x01\xea\x03\x00\x00"))
