"""candump's lines, as logged and as printed."""

import pytest

from timonel.recording import LogFrame
from timonel.recording.candump import Candump

DATA = bytes.fromhex("3E17B322B320590D")


def read(*lines):
    candump = Candump(lines)
    return [candump.read(line) for line in lines]


def test_a_logged_line_gives_time_identifier_and_data():
    frames = read("(1620807235.135421) can0 09F8017F#3E17B322B320590D")
    assert frames == [LogFrame(1620807235.135421, 0x09F8017F, DATA)]


@pytest.mark.parametrize("direction", ["R", "T"])
def test_a_logged_line_may_end_in_its_direction(direction):
    assert read(f"(1.5) can0 09F8017F#3E17B322B320590D {direction}") == [LogFrame(1.5, 0x09F8017F, DATA)]


def test_an_identifier_of_three_digits_is_a_standard_frame():
    assert read("(1.5) can0 06C#0102")[0] == LogFrame(1.5, 0x6C, b"\x01\x02", extended=False)
    assert read("  can0  06C   [2]  01 02")[0] == LogFrame(None, 0x6C, b"\x01\x02", extended=False)


def test_a_printed_line_without_a_time_has_none():
    assert read("  can0  09F8017F   [8]  3E 17 B3 22 B3 20 59 0D") == [LogFrame(None, 0x09F8017F, DATA)]


def test_a_printed_line_in_lower_case_with_its_direction_and_its_characters_is_read():
    line = " can0  RX - -  09f8017f   [8]  3e 17 b3 22 b3 20 59 0d   '>..\". Y.'"
    assert read(line) == [LogFrame(None, 0x09F8017F, DATA)]


def test_absolute_and_dated_times_are_unix_seconds():
    frames = read(
        " (1676902769.342282)  can0  15FD0617   [1]  01",
        " (2023-02-20 16:17:04.590873)  can0  15FD0617   [1]  01",
    )
    assert [frame.stamp for frame in frames] == pytest.approx([1676902769.342282, 1676909824.590873], abs=1e-6)


def test_times_from_zero_stay_as_they_are():
    frames = read(*(f" ({t})  can0  15FD0617   [1]  01" for t in ("000.000000", "000.019798", "001.000000")))
    assert [frame.stamp for frame in frames] == [0.0, 0.019798, 1.0]


def test_times_that_go_back_count_from_the_line_before():
    frames = read(*(f" ({t})  can0  15FD0617   [1]  01" for t in ("000.000000", "000.750000", "000.500000")))
    assert [frame.stamp for frame in frames] == [0.0, 0.75, 1.25]


@pytest.mark.parametrize(
    "line",
    [
        "",
        "   ",
        "# candump can0",
        "(1.5) can0 09F8017F#R",
        "(1.5) can0 20000004#0000000000000000",
        "  can0  09F8017F   [0]  remote request",
    ],
)
def test_what_is_no_data_frame_gives_nothing(line):
    assert read(line) == [None]


@pytest.mark.parametrize(
    "line",
    [
        "hello",
        "(1.5) can0 09F8017F",
        "(1.5) can0 09F8017F#123",
        "(1.5) can0 09F8017F##1112233",
        "(1.5) can0 09F8017F#010203040506070809",
        "(1.5) can0 9F8017F#01",
        "(1.5) can0 89F8017F#01",
        "(later) can0 09F8017F#01",
        "  can0  09F8017F   [8]  3E 17 B3",
        "  can0  09F8017F   [9]  3E 17 B3 22 B3 20 59 0D 00",
        " (noon)  can0  09F8017F   [1]  3E",
    ],
)
def test_a_line_of_another_kind_is_refused(line):
    with pytest.raises(ValueError):
        read(line)


LOGGED = "(1669809600.001488) can0 0DF11917#00FF7F1F02A3FFFF"


@pytest.mark.parametrize(
    "line",
    [
        LOGGED,
        LOGGED.replace("001488", "999999"),
        LOGGED.replace("0DF11917", "0DF11918"),
        LOGGED.replace("600.", "601."),
        LOGGED.replace("001488", "0014889"),
        LOGGED + " T",
        LOGGED + "00",
        LOGGED.replace("FF7F", "FF 7F"),
        LOGGED.replace("001488", "+01488"),
        LOGGED.replace("#00", "00"),
        LOGGED.partition("#")[0],
        LOGGED.partition("#")[0] + "#",
        LOGGED.partition("#")[0] + "#R",
    ],
)
def test_a_line_is_read_the_same_behind_one_with_its_second_and_identifier(line):
    behind = Candump([])
    assert [behind.read(LOGGED)] == read(LOGGED)
    assert outcome(behind.read, line) == outcome(Candump([]).read, line)


def outcome(reader, line):
    try:
        return reader(line)
    except ValueError as refused:
        return str(refused)


def test_an_interface_may_have_the_mark_before_the_data():
    candump = Candump([])
    odd = LOGGED.replace("can0", "c#00")
    assert [candump.read(odd), candump.read(odd)] == read(LOGGED, LOGGED)
    with pytest.raises(ValueError):
        candump.read(odd.partition(" 0DF")[0])


def test_lines_of_two_interfaces_and_of_both_kinds_of_identifier_take_turns():
    turns = [
        LOGGED,
        LOGGED.replace("can0", "vcan12"),
        LOGGED.replace("0DF11917", "123"),
        LOGGED.replace("#00", "#"),
    ] * 3
    assert read(*turns) == [frame for line in turns for frame in read(line)]
