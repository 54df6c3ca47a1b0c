"""Lines of gateways and tools: what is read of them, and what is not."""

import pytest

from timonel.nmea2000.identifier import Identifier, split
from timonel.recording.actisense_ascii import ActisenseAscii
from timonel.recording.garmin import GarminCsv
from timonel.recording.ikonvert import IKonvert

CSV = "Sequence #,Timestamp,PGN,Name,Manufacturer,Remote Address,Local Address,Priority,Single Frame,Size,Packet"
DATED = (
    "Sequence #,Month_Day_Year_Hours_Minutes_Seconds_msTicks,PGN,Processed PGN,Name,Manufacturer,Remote Address,"
    "Local Address,Priority,Single Frame,Size,Packet"
)


def read(form, *lines):
    reader = form(lines)
    return [reader.read(line) for line in lines]


def parts(frame):
    return frame.stamp, split(frame.identifier), frame.data.hex(), frame.whole


# Actisense N2K ASCII ------------------------------------------------------------------------------


def test_n2k_ascii_has_time_addresses_priority_pgn_and_data():
    (frame,) = read(ActisenseAscii, "A173321.107 23FF7 1F513 012F3070002F30709F")
    assert parts(frame) == (63_201.107, Identifier(7, 128275, 0x23, 255), "012f3070002f30709f", True)


def test_n2k_ascii_may_lack_milliseconds_and_the_top_bit_of_the_priority_means_nothing():
    (frame,) = read(ActisenseAscii, "A000001 0A23E 0EA00 14F001 ")
    assert parts(frame) == (1.0, Identifier(6, 59904, 0x0A, 0x23), "14f001", False)


def test_n2k_ascii_goes_on_past_midnight():
    stamps = [f.stamp for f in read(ActisenseAscii, "A235959.900 23FF2 1F802 00", "A000000.100 23FF2 1F802 00")]
    assert stamps == [86_399.9, 86_400.1]


def test_n2k_ascii_passes_over_what_is_the_gateways_own():
    assert read(ActisenseAscii, "A000001 0AFF2 40100 00", "# note", "") == [None, None, None]


@pytest.mark.parametrize(
    "line",
    [
        "A173321.107 23FF7 1F513 012F3070002F30709",
        "A173321.107 23FF7 1F513",
        "A173321.107 23FF7 1F51 0102",
        "173321.107 23FF7 1F513 0102",
        "A173321.107 23FF7 0EA01 0102",
        "A173321.107 23FF7 1F513 " + "00" * 224,
    ],
)
def test_n2k_ascii_of_another_shape_is_refused(line):
    with pytest.raises(ValueError):
        read(ActisenseAscii, line)


# iKonvert -----------------------------------------------------------------------------------------


def test_ikonvert_has_pgn_priority_source_destination_time_and_data():
    (frame,) = read(IKonvert, "!PDGY,129039,4,43,255,481.706,ErZcAw6BGlf/h2BIHkP//wAABgAG//8AdAH/")
    expected = "12b65c030e811a57ff8760481e43ffff0000060006ffff007401ff"
    assert parts(frame) == (481.706, Identifier(4, 129039, 43, 255), expected, True)


def test_the_milliseconds_of_ikonvert_have_no_leading_zeros():
    lines = [f"!PDGY,127250,2,3,255,482.{ms},2S20AAAAAAE=" for ms in (36, 117, 7)]
    assert [frame.stamp for frame in read(IKonvert, *lines)] == [482.036, 482.117, 482.007]


def test_what_ikonvert_says_of_itself_is_passed_over():
    assert read(IKonvert, "$PDGY,000000,3,,5,798,1,0", "$PDGY,TEXT,Digital_Yacht", "# note") == [None, None, None]


@pytest.mark.parametrize(
    "line",
    [
        "!PDGY,127250,2,3,255,482.36,2S20AAAAAAE",
        "!PDGY,127250,2,3,255,482.36,2S20AAAAA=AE",
        "!PDGY,127250,2,3,255,482.36,",
        "!PDGY,127250,9,3,255,482.36,2S20AAAAAAE=",
        "!PDGY,127250,2,3,256,482.36,2S20AAAAAAE=",
        "$PDGY,0000$PDGY,000050,2,3,255,536.56,+920AAAAAAE=",
        "!PDGY,127250,2,3",
        f"!PDGY,127250,2,3,255,{'9' * 400}.36,2S20AAAAAAE=",
    ],
)
def test_ikonvert_of_another_shape_is_refused(line):
    with pytest.raises(ValueError):
        read(IKonvert, line)


# Garmin CSV ---------------------------------------------------------------------------------------


def test_garmin_counts_milliseconds_and_its_names_may_have_commas():
    line = "129,491183,129029,GNSS Position Data,Unknown, really,3,255,3,0,10,0xFFDF40A6E9BB22C04B36"
    headings, frame = read(GarminCsv, CSV, line)
    assert headings is None
    assert parts(frame) == (491.183, Identifier(3, 129029, 3, 255), "ffdf40a6e9bb22c04b36", True)
    assert not GarminCsv([CSV]).dated


def test_garmin_with_dates_orders_what_came_within_a_second():
    head = "6,255,2,1,8,0x017505FF7FFFFFFF"
    times = ("16_11_14_24931648", "16_11_14_24931998", "16_11_15_24932010", "16_11_20_24937010")
    lines = [f"{n},6_21_2015_{time},127508,Processed,Battery Status,Garmin,{head}" for n, time in enumerate(times)]
    frames = read(GarminCsv, DATED, *lines)[1:]
    began = 1434903074.0
    assert [f.stamp - began for f in frames] == pytest.approx([0, 0.35, 0.362, 5.362], abs=1e-6)
    assert GarminCsv([DATED]).dated


def test_garmin_takes_a_clock_that_is_set_for_what_it_says():
    lines = [
        f"{n},{date},127508,Processed,Name,Garmin,6,255,2,1,1,0x01"
        for n, date in enumerate(("1_1_2000_0_0_10_10000", "6_21_2015_16_11_14_11000"))
    ]
    assert [f.stamp for f in read(GarminCsv, *lines)] == [946684810.0, 1434903074.0]


@pytest.mark.parametrize(
    "line",
    [
        "0,486942,127508,Battery Status,Garmin,6,255,2,1,8,0x017505FF7FFFFF",
        "0,486942,127508,Battery Status,Garmin,6,255,2,1,8,0x017505FF7FFFFFF",
        "0,486942,127508,Battery Status,Garmin,6,255,2,1,8",
        "0,13_41_2015_16_11_14_648,127508,Processed,Battery Status,Garmin,6,255,2,1,1,0x01",
        "0,486942,127508,6,255,2,1,1,0x01",
        f"0,{'9' * 400},127508,Battery Status,Garmin,6,255,2,1,1,0x01",
        f"0,6_21_2015_16_11_14_{'9' * 400},127508,Battery Status,Garmin,6,255,2,1,1,0x01",
    ],
)
def test_garmin_of_another_shape_is_refused(line):
    with pytest.raises(ValueError):
        read(GarminCsv, line)
