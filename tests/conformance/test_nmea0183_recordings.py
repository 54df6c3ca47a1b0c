"""Public recordings: every sentence of a known type is read, and its values are those pynmea2 reads."""

from collections import Counter
from collections.abc import Iterator
from typing import Any

import pynmea2
import pytest
from pynmea2.nmea_utils import dm_to_sd

from tests.recordings import recording
from timonel.nmea0183.checksum import Fault, verify
from timonel.nmea0183.framing import SentenceFramer
from timonel.nmea0183.registry import SENTENCES, parse
from timonel.nmea0183.sentence import Sentence

SIGNALK, GPSD, AVNAV = "SignalK_signalk-server/samples/", "ntpsec_gpsd/test/daemon/", "wellenvogel_avnav/test/"

# Sentences of known types that are read, and malformed ones with a right check sum: these are XDR with
# angles like "-1.-3". Counted with grep; a last line without its end is no sentence.
RECORDINGS = {
    f"{SIGNALK}plaka.log": (86_999, 0),
    f"{SIGNALK}gps.log": (3603, 0),
    f"{SIGNALK}gofree-merrimac.log": (3501, 141),
    f"{SIGNALK}nais300-merrimac.log": (10, 0),
    f"{SIGNALK}nais400-merrimac.log": (46, 0),
    f"{SIGNALK}n2kd-183-merrimac.log": (541, 0),
    f"{AVNAV}nmea-20130630-3wind.log": (17_069, 0),
    f"{AVNAV}2015-12-22.nmea": (369, 0),
    "Knio_pynmea2/examples/data.log": (1, 0),
    f"{GPSD}sounder.log": (244, 0),
    f"{GPSD}pypilot.log": (29, 0),
    f"{GPSD}skytraq-PX1172RH_DS.log": (63, 0),
    f"{GPSD}GPSmap-76S.log": (70, 0),
    f"{GPSD}ais-nmea.log": (656, 0),
    f"{GPSD}telit-he910.log": (896, 0),
}

# Our attribute -> pynmea2's; a pair of theirs is a magnitude and its direction.
NAMES: dict[str, dict[str, str | tuple[str, str]]] = {
    "HDT": {"heading_deg": "heading"},
    "HDM": {"magnetic_heading_deg": "heading"},
    "HDG": {
        "heading_deg": "heading",
        "deviation_deg": ("deviation", "dev_dir"),
        "variation_deg": ("variation", "var_dir"),
    },
    "ROT": {"rate_deg_min": "rate_of_turn"},
    "VHW": {
        "heading_deg": "heading_true",
        "magnetic_heading_deg": "heading_magnetic",
        "speed_kn": "water_speed_knots",
        "speed_kmh": "water_speed_km",
    },
    "DPT": {"depth_m": "depth", "offset_m": "offset", "range_m": "range"},
    "DBT": {"depth_ft": "depth_feet", "depth_m": "depth_meters", "depth_fathoms": "depth_fathoms"},
    "DBS": {"depth_ft": "depth_feet", "depth_m": "depth_meter"},
    "GLL": {"latitude_deg": ("lat", "lat_dir"), "longitude_deg": ("lon", "lon_dir")},
    "RMC": {
        "latitude_deg": ("lat", "lat_dir"),
        "longitude_deg": ("lon", "lon_dir"),
        "speed_kn": "spd_over_grnd",
        "course_deg": "true_course",
        "variation_deg": ("mag_variation", "mag_var_dir"),
    },
    "GGA": {
        "latitude_deg": ("lat", "lat_dir"),
        "longitude_deg": ("lon", "lon_dir"),
        "quality": "gps_qual",
        "satellites": "num_sats",
        "hdop": "horizontal_dil",
        "altitude_m": "altitude",
        "geoid_m": "geo_sep",
        "age_s": "age_gps_data",
    },
    "VTG": {
        "course_deg": "true_track",
        "magnetic_course_deg": "mag_track",
        "speed_kn": "spd_over_grnd_kts",
        "speed_kmh": "spd_over_grnd_kmph",
    },
    "ZDA": {"day": "day", "month": "month", "year": "year",
            "zone_hours": "local_zone", "zone_minutes": "local_zone_minutes"},
    "MTW": {"temperature_c": "temperature"},
    "MWV": {"angle_deg": "wind_angle", "speed": "wind_speed"},
    "MWD": {
        "direction_deg": "direction_true",
        "magnetic_direction_deg": "direction_magnetic",
        "speed_kn": "wind_speed_knots",
        "speed_ms": "wind_speed_meters",
    },
    "VDR": {"set_deg": "deg_t", "magnetic_set_deg": "deg_m", "drift_kn": "current"},
    "APB": {
        "cross_track_error_nm": ("cross_track_err_mag", "dir_steer"),
        "leg_bearing_deg": "bearing_to_dest",
        "bearing_deg": "bearing_pres_dest",
        "heading_to_steer_deg": "heading_to_dest",
    },
    "RMB": {
        "cross_track_error_nm": ("cross_track_error", "cte_correction_dir"),
        "latitude_deg": ("dest_lat", "dest_lat_dir"),
        "longitude_deg": ("dest_lon", "dest_lon_dir"),
        "range_nm": "dest_range",
        "bearing_deg": "dest_true_bearing",
        "closing_speed_kn": "dest_velocity",
    },
    "XTE": {"cross_track_error_nm": ("cross_track_err_dist", "correction_dir")},
}  # fmt: skip


def framed(name: str) -> Iterator[bytes]:
    framer = SentenceFramer()
    data = recording(name).read_bytes()
    for start in range(0, len(data), 1000):
        yield from framer.receive(data[start : start + 1000])


def theirs(sentence: pynmea2.NMEASentence, name: str | tuple[str, str]) -> float | None:
    """A value as pynmea2 has it; the directions S, W and R are negative."""
    if isinstance(name, str):
        value = getattr(sentence, name)
        return None if value in ("", None) else float(value)
    magnitude, direction = (getattr(sentence, part) for part in name)
    if magnitude in ("", None) or direction == "":
        return None
    number = dm_to_sd(magnitude) if "lat" in name[0] or "lon" in name[0] else float(magnitude)
    return -number if direction in "SWR" else number


@pytest.mark.parametrize("name", RECORDINGS)
def test_every_sentence_of_a_known_type_is_read_from_the_recordings(name: str) -> None:
    results = Counter("read" if isinstance(read, Sentence) else read for read in map(parse, framed(name)))
    assert (results["read"], results[Fault.MALFORMED]) == RECORDINGS[name]


@pytest.mark.parametrize("name", RECORDINGS)
def test_the_values_read_are_those_pynmea2_reads(name: str) -> None:
    seen = set()
    for line in framed(name):
        ours = parse(line)
        if line in seen or not isinstance(ours, Sentence) or type(ours).__name__ not in NAMES:
            continue
        seen.add(line)
        reference = pynmea2.parse(line.decode("ascii"), check=True)
        for attribute, their_name in NAMES[type(ours).__name__].items():
            expected = theirs(reference, their_name)
            assert getattr(ours, attribute) == (expected if expected is None else pytest.approx(expected, abs=1e-10)), (
                line
            )
        _same_time_and_status(ours, reference)


def _same_time_and_status(ours: Any, reference: Any) -> None:
    if getattr(ours, "time", None) is not None:
        clock = reference.timestamp
        seconds = clock.hour * 3600 + clock.minute * 60 + clock.second + clock.microsecond / 1e6
        assert ours.time == pytest.approx(seconds, abs=2e-6)
    if getattr(ours, "date", None) is not None:
        assert ours.date == reference.datestamp
    if hasattr(reference, "status"):
        mode = getattr(ours, "mode", None)
        expected = reference.status == "A" and mode in (None, *"ADPRF")
        assert ours.valid is (expected if reference.status else None)


def test_every_sentence_that_is_read_is_written_and_read_again() -> None:
    for name in RECORDINGS:
        for line in set(framed(name)):
            read = parse(line)
            if isinstance(read, Sentence) and len(line) <= 78:
                again = parse(read.encode(line[1:3].decode())[:-2])
                assert type(again) is type(read), line
                assert isinstance(again, Sentence)
                assert again.encode() == read.encode(), line


def test_sentences_run_together_by_a_broken_sender_are_not_read() -> None:
    lines = [line for line in framed(f"{SIGNALK}gofree-merrimac.log") if line[3:6] == b"VLW"]
    assert len(lines) == 142
    assert {verify(line) for line in lines} == {Fault.WRONG_CHECKSUM}


def test_the_recordings_have_most_sentence_types() -> None:
    read = {type(sentence).__name__ for name in RECORDINGS for sentence in map(parse, framed(name))} - {"Fault"}
    assert len(read) >= 22, set(SENTENCES)
