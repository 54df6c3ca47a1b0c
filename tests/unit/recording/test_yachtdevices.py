"""Yacht Devices' RAW text."""

import pytest

from timonel.recording import LogFrame
from timonel.recording.yachtdevices import YachtDevicesRaw

DATA = bytes.fromhex("012F3070002F3070")


def read(*lines):
    raw = YachtDevicesRaw(lines)
    return [raw.read(line) for line in lines]


@pytest.mark.parametrize("direction", ["R", "T"])
def test_a_line_gives_its_time_of_day(direction):
    frames = read(f"17:33:21.107 {direction} 19F51323 01 2F 30 70 00 2F 30 70")
    assert frames == [LogFrame(17 * 3600 + 33 * 60 + 21.107, 0x19F51323, DATA)]


def test_a_line_without_time_in_lower_case_is_read():
    assert read("19f51323 01 2f 30 70 00 2f 30 70") == [LogFrame(None, 0x19F51323, DATA)]


def test_time_goes_on_past_midnight():
    frames = read("23:59:59.500 R 19F51323 01", "00:00:00.500 R 19F51323 01")
    assert frames[1].stamp - frames[0].stamp == 1.0


def test_a_comment_gives_nothing():
    assert read("# This is PGN 129540", "") == [None, None]


@pytest.mark.parametrize(
    "line",
    [
        "17:33:21.107 R 39F51323 01",
        "17:33:21.107 R 19F51323 01 2",
        "17:33:21.107 R 19F51323 01 02 03 04 05 06 07 08 09",
        "17:33:21.107 X 19F51323 01",
        "hello",
    ],
)
def test_a_line_of_another_kind_is_refused(line):
    with pytest.raises(ValueError):
        read(line)
