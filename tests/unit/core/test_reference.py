"""The protocol page says what the declarations say."""

import runpy
from pathlib import Path

import pytest

from timonel.core.reference import rows, section
from timonel.nmea2000.messages.garmin import GarminAutopilotHeadingToSteer
from timonel.nmea2000.messages.navico import SimnetPilotMode
from timonel.nmea2000.messages.navigation import GnssPositionData
from timonel.nmea2000.messages.network import PgnListTransmitAndReceive
from timonel.nmea2000.messages.steering import VesselHeading

ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize("name", ["pgns.md", "conversion.md", "rover_frames.md", "security.md"])
def test_a_page_is_made_of_the_declarations_as_they_are(name):
    script = runpy.run_path(str(ROOT / "scripts" / "make_reference.py"))
    assert (ROOT / "docs" / name).read_text() == script["PAGES"][name](), "run scripts/make_reference.py"


def test_a_row_has_place_size_range_and_unit():
    assert rows(VesselHeading)[1:3] == [
        "| 2 | heading | 8 | 16 | 0 to 6.2831 rad, in steps of 0.0001 |",
        "| 3 | deviation | 24 | 16 | -3.1415 to 3.1415 rad, in steps of 0.0001 |",
    ]
    assert rows(VesselHeading)[4:] == [
        "| 5 | reference | 56 | 2 | 0 true, 1 magnetic, 2 error |",
        "| 6 | reserved | 58 | 6 | ones |",
    ]


def test_constants_and_flags_are_told_by_their_names():
    assert rows(SimnetPilotMode)[0] == "| 1 | manufacturer_code | 0 | 11 | always 1857 (simrad) |"
    assert rows(SimnetPilotMode)[5].endswith("| bit 3 standby, bit 4 heading, bit 6 nav, bit 8 no drift, bit 10 wind |")


def test_a_constant_without_a_name_and_a_float_are_told_too():
    told = rows(GarminAutopilotHeadingToSteer)
    assert told[4] == "| 5 | wrapper_byte1 | 32 | 8 | always 4 |"
    assert told[9] == "| 10 | heading_to_steer | 72 | 32 | a number in IEEE 754 |"


def test_the_fields_of_a_group_are_counted_on():
    assert rows(GnssPositionData)[-4:-1] == [
        "|  | stations | 344 |  | `ReferenceStation`, as many as `reference_stations` says |",
        "| 16 | - reference_station_type |  | 4 | 0 gps, 1 glonass, 2 gps glonass, 3 gps sbas, "
        "4 gps sbas glonass, 5 chayka, 6 integrated, 7 surveyed, 8 galileo |",
        "| 17 | - reference_station_id |  | 12 | 0 to 4092 |",
    ]
    assert rows(PgnListTransmitAndReceive)[-1] == "| 2 | pgns | 8 |  | of 24 bits each, up to the end |"


def test_a_section_begins_with_what_the_message_is():
    assert section(VesselHeading).startswith("### VesselHeading\n\nPGN 127250: where the bow points")
