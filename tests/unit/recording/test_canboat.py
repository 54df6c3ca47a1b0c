"""canboat's PLAIN and FAST lines."""

import pytest

from timonel.nmea2000.fastpacket import fragment
from timonel.recording import LogFrame
from timonel.recording.canboat import Canboat

HEADING = "2016-02-28T19:57:02.364Z,2,127250,7,255,8,ff,10,3b,ff,7f,ce,f5,fc"
NOON = "2024-01-01T12:00:00.000Z"
COURSE = bytes.fromhex("3f3cffff7f051fffffffffffffff7fff7fff7f8b1e")


def read(*lines):
    canboat = Canboat(lines)
    return [canboat.read(line) for line in lines]


def line(pgn, data, source=35, destination=255, stamp=NOON):
    return f"{stamp},2,{pgn},{source},{destination},{len(data)}," + data.hex(",")


def whole(*lines):
    return [frame.whole for frame in read(*lines)]


def test_a_line_gives_time_identifier_and_data():
    assert read(HEADING) == [LogFrame(1456689422.364, 0x09F11207, bytes.fromhex("ff103bff7fcef5fc"))]


def test_a_pgn_with_a_destination_keeps_it():
    assert read("2016-02-28T19:57:02Z,6,59904,35,42,3,00,ee,00")[0].identifier == 0x18EA2A23


@pytest.mark.parametrize(
    ("stamp", "seconds"),
    [
        ("2024-01-01T12:00:00.250Z", 1704110400.25),
        ("2024-01-01T12:00:00.250", 1704110400.25),
        ("2024-01-01-12:00:00.250", 1704110400.25),
        ("2024-01-01-12:00:00", 1704110400.0),
        ("2024-01-01T12:00:00Z", 1704110400.0),
        ("2024-01-01T05:00:00.250000001-07:00", 1704110400.25),
    ],
)
def test_times_are_read_however_they_are_written(stamp, seconds):
    assert read(line(127250, bytes(8), stamp=stamp), line(127250, bytes(8), stamp=stamp))[1].stamp == seconds


def test_a_line_of_a_whole_message_is_marked():
    assert read(line(127237, COURSE)) == [LogFrame(1704110400.0, 0x09F10523, COURSE, whole=True)]


def test_frames_of_a_fast_packet_are_not_messages():
    assert whole(*(line(127237, frame) for frame in fragment(COURSE, 1))) == [False] * 4


def test_a_single_frame_pgn_is_never_marked():
    assert whole(HEADING, line(127237, COURSE)) == [False, True]


def test_eight_bytes_beside_other_lengths_of_their_pgn_are_a_message():
    acknowledgement = bytes.fromhex("0263ff0000040000")
    assert whole(line(126208, acknowledgement), line(126208, bytes(17))) == [True, True]


def test_frames_beside_whole_messages_of_their_pgn_stay_frames():
    frames = [line(127237, frame) for frame in fragment(COURSE, 1)]
    assert whole(*frames, line(127237, COURSE)) == [False] * 4 + [True]


def test_a_pgn_in_frames_and_another_in_messages_are_told_apart():
    frames = [line(130916, frame) for frame in fragment(bytes(7), 3)]
    assert whole(*frames, line(126208, bytes(17)), line(126208, bytes(8))) == [False, False, True, True]


def test_eight_bytes_are_a_message_where_all_fast_packets_are():
    assert whole(line(129029, bytes(43)), line(127513, bytes(8))) == [True, True]
    assert whole(line(127513, bytes(8))) == [False]


def test_a_recording_that_says_it_is_fast_has_messages_only():
    canboat = Canboat(["# format=FAST"])
    assert canboat.read(line(127513, bytes(8))).whole


def test_fewer_than_eight_bytes_of_a_fast_packet_are_a_message():
    assert whole(line(126208, bytes(7))) == [True]


def test_a_gateways_own_pgn_and_a_comment_give_nothing():
    assert read("2016-02-28T19:57:02Z,0,262386,0,255,2,00,01", "# comment", "") == [None, None, None]


def test_a_value_of_one_digit_is_read():
    assert read(f"{NOON},2,127250,7,255,8,ff,0,3b,ff,7f,ce,f5,fc")[0].data[1] == 0


@pytest.mark.parametrize(
    "text",
    [
        "hello",
        f"{NOON},2,127250,7,255,8,ff,10,3b",
        f"{NOON},2,127250,7,255,0",
        f"{NOON},2,127250,7,255,-1,ff,10",
        f"{NOON},9,127250,7,255,1,ff",
        f"{NOON},2,59905,7,255,1,ff",
        f"{NOON},2,x,7,255,1,ff",
        f"{NOON},2,127250,7,255,1,xx",
        f"{NOON},2,127250,7,255,1,1ff",
        "yesterday,2,127250,7,255,1,ff",
        f"{NOON},2,129029,7,255,224," + bytes(224).hex(","),
    ],
)
def test_a_line_of_another_kind_is_refused(text):
    with pytest.raises(ValueError):
        Canboat([]).read(text)
