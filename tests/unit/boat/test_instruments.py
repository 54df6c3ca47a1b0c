"""NMEA 0183 to NMEA 2000, sentence by sentence: signs, references, units, and what is not told."""

from datetime import date
from math import radians

import pytest

from timonel.core.message import Message
from timonel.errors import EncodeError
from timonel.nmea0183 import sentences as s
from timonel.nmea0183.checksum import seal
from timonel.nmea0183.registry import parse
from timonel.nmea2000.lookups import GnssMethod, HeadingReference, TemperatureSource, WindReference, XteMode, YesNo
from timonel.nmea2000.messages.environment import Temperature, TemperatureExtendedRange
from timonel.nmea2000.messages.navigation import (
    CogSogRapidUpdate,
    CrossTrackError,
    GnssPositionData,
    NavigationData,
    NavigationRouteWpInformation,
    PositionRapidUpdate,
    SystemTime,
    WaterDepth,
)
from timonel.nmea2000.messages.steering import RateOfTurn, VesselHeading
from timonel.vehicles.boat.instruments import LAST_SID, READINGS, Ceilings, Instruments

PORT = "compass"
DAY = (date(2026, 11, 22) - date(1970, 1, 1)).days
KNOT, MILE = 1852 / 3600, 1852.0
TRUE, MAGNETIC = HeadingReference.TRUE, HeadingReference.MAGNETIC


class Afloat:
    """A port of instruments, and the time."""

    def __init__(self, depth_offset: float | None = None) -> None:
        self.instruments = Instruments({PORT: depth_offset})
        self.now = 0.0

    def hear(self, body: str, port: str = PORT) -> list[Message]:
        typed = parse(seal(body).rstrip())
        assert isinstance(typed, s.HDT.__base__), body
        made = list(self.instruments.receive(typed, port, self.now))
        assert {type(message) for message in made} <= set(READINGS[type(typed)].messages)
        return made


def told(body: str) -> dict[str, dict[str, object]]:
    """The messages of one sentence by name: their fields that are told, without sequence identifiers."""
    return {type(message).__name__: fields(message) for message in Afloat().hear(body)}


def fields(message: Message) -> dict[str, object]:
    values = {name: getattr(message, name) for name in message.__struct_fields__}
    plain = {name: value for name, value in values.items() if value is not None and name != "sid"}
    return {name: round(value, 9) if isinstance(value, float) else value for name, value in plain.items()}


def near(**values: object) -> dict[str, object]:
    return {
        name: pytest.approx(value, abs=1e-8) if isinstance(value, float) else value for name, value in values.items()
    }


# Heading ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("HEHDT,90.0,T", near(heading=radians(90), reference=TRUE)),
        ("HETHS,90.0,A", near(heading=radians(90), reference=TRUE)),
        ("HCHDM,90.0,M", near(heading=radians(90), reference=MAGNETIC)),
        ("HCHDG,90.0,,,,", near(heading=radians(90), reference=MAGNETIC)),
        (
            "HCHDG,90.0,1.5,W,3.0,E",
            near(heading=radians(90), deviation=radians(-1.5), variation=radians(3), reference=MAGNETIC),
        ),
        (
            "HCHDG,90.0,1.5,E,3.0,W",
            near(heading=radians(90), deviation=radians(1.5), variation=radians(-3), reference=MAGNETIC),
        ),
    ],
)
def test_a_heading_keeps_its_reference_and_its_corrections_their_places(body: str, expected: dict[str, object]):
    assert told(body) == {"VesselHeading": expected}


@pytest.mark.parametrize(
    "body", ["HEHDT,,T", "HCHDM,,M", "HCHDG,,1.0,E,3.0,E", "HEROT,,A", "HEROT,5.0,V", "HEROT,5.0,"]
)
def test_what_is_empty_or_invalid_tells_nothing(body: str):
    assert told(body) == {}


@pytest.mark.parametrize("mode", ["E", "M", "S", "V"])
def test_a_heading_that_was_not_measured_takes_back_the_one_that_was(mode: str):
    assert told(f"HETHS,90.0,{mode}") == {"VesselHeading": {"reference": TRUE}}


@pytest.mark.parametrize("text", ["360.0", "359.999", "0.0"])
def test_a_full_turn_is_none_and_can_be_sent(text: str):
    [heading] = Afloat().hear(f"HEHDT,{text},T")
    assert isinstance(heading, VesselHeading)
    assert VesselHeading.decode(heading.encode()).heading == 0.0


def test_of_one_port_the_better_sentence_is_taken_while_it_comes():
    afloat = Afloat()
    assert afloat.hear("HCHDM,91.0,M") != []
    assert afloat.hear("HCHDG,90.0,1.0,E,,") != []
    assert afloat.hear("HCHDM,91.0,M") == []
    afloat.now = 2.9
    assert afloat.hear("HCHDM,91.0,M") == []
    afloat.now = 3.0
    assert afloat.hear("HCHDM,91.0,M") != []
    assert afloat.hear("HCHDM,91.0,M", port="another") != []


def test_a_turn_to_starboard_is_positive_and_in_rad_a_second():
    assert told("HEROT,180.0,A") == {"RateOfTurn": near(rate=radians(3.0))}
    assert told("HEROT,-180.0,A") == {"RateOfTurn": near(rate=radians(-3.0))}


@pytest.mark.parametrize("pitch", ["PITCH", "pitch", "PTCH"])
def test_attitude_is_bow_up_and_starboard_down(pitch: str):
    assert told(f"YXXDR,A,5.5,D,{pitch},A,-12.5,D,ROLL") == {"Attitude": near(pitch=radians(5.5), roll=radians(-12.5))}


@pytest.mark.parametrize("body", ["YXXDR,C,21.5,C,CABIN", "YXXDR,A,5.5,D,MAST", "YXXDR,A,,D,PITCH", "YXXDR,A,1.0,D,"])
def test_transducers_of_other_things_are_no_attitude(body: str):
    assert told(body) == {}


def test_the_single_rudder_is_instance_0_and_the_port_one_instance_1():
    assert told("AGRSA,-10.0,A,,") == {"Rudder": near(instance=0, position=radians(-10))}
    both = Afloat().hear("AGRSA,10.0,A,9.5,A")
    assert [fields(rudder) for rudder in both] == [
        near(instance=0, position=radians(10)),
        near(instance=1, position=radians(9.5)),
    ]
    assert told("AGRSA,10.0,V,,") == {}


# Water ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("VWVHW,90.0,T,88.0,M,5.0,N,9.3,K", near(speed_water_referenced=5 * KNOT)),
        ("VWVHW,,T,,M,,N,9.0,K", near(speed_water_referenced=2.5)),
        ("VWVHW,,T,,M,0.0,N,0.0,K", near(speed_water_referenced=0.0)),
    ],
)
def test_speed_through_the_water_is_in_metres_a_second(body: str, expected: dict[str, object]):
    assert told(body) == {"Speed": expected}


def test_a_speed_that_is_not_told_is_not_zero():
    assert told("VWVHW,90.0,T,88.0,M,,N,,K") == {}


def test_the_log_is_in_whole_metres():
    assert told("VWVLW,1234.56,N,7.25,N") == {"DistanceLog": {"log": round(1234.56 * MILE), "trip_log": 13427}}
    assert told("VWVLW,,N,7.25,N") == {"DistanceLog": {"trip_log": 13427}}
    assert told("VWVLW,,N,,N") == {}


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("SDDPT,4.2,0.5", near(depth=4.2, offset=0.5)),
        ("SDDPT,4.2,-1.5,100.0", near(depth=4.2, offset=-1.5, range=100)),
        ("SDDPT,4.2,", near(depth=4.2)),
        ("SDDBT,13.8,f,4.2,M,2.3,F", near(depth=4.2)),
        ("SDDBT,10.0,f,,M,2.3,F", near(depth=3.048)),
        ("SDDBT,,f,,M,2.0,F", near(depth=3.6576)),
        ("SDDBS,,f,4.2,M,,F", near(depth=4.2, offset=0.0)),
    ],
)
def test_a_depth_has_the_unit_that_is_told_and_no_offset_that_is_not(body: str, expected: dict[str, object]):
    assert told(body) == {"WaterDepth": expected}


@pytest.mark.parametrize(
    "body", ["SDDPT,,0.5", "SDDBT,,f,,M,,F", "SDDBS,,f,,M,,F", "SDDBK,,f,,M,,F", "SDDBK,,f,4.2,M,,F"]
)
def test_no_depth_and_a_depth_below_a_keel_nobody_knows_are_not_told(body: str):
    assert told(body) == {}


@pytest.mark.parametrize(
    ("offset", "body", "depth"),
    [(-1.5, "SDDBK,,f,3.0,M,,F", 4.5), (0.5, "SDDBS,,f,3.0,M,,F", 2.5), (-1.5, "SDDBS,,f,3.0,M,,F", 3.0)],
)
def test_depths_below_keel_and_surface_are_brought_to_the_transducer(offset: float, body: str, depth: float):
    [message] = Afloat(offset).hear(body)
    assert isinstance(message, WaterDepth)
    assert (message.depth, message.offset) == (depth, max(offset, 0.0) if "DBS" in body else offset)


def test_a_depth_above_the_transducer_is_none():
    assert Afloat(0.5).hear("SDDBS,,f,0.2,M,,F") == []


@pytest.mark.parametrize("better", ["SDDPT,4.2,0.5", "SDDBT,,f,4.2,M,,F"])
def test_a_port_that_tells_the_depth_below_the_transducer_is_not_asked_for_that_below_the_surface(better: str):
    afloat = Afloat(-1.5)
    afloat.hear(better)
    assert afloat.hear("SDDBS,,f,9.0,M,,F") == afloat.hear("SDDBK,,f,9.0,M,,F") == []


def test_water_temperature_goes_into_both_messages_as_that_of_the_sea():
    sid, kelvin, sea = 0, 288.65, TemperatureSource.SEA
    assert Afloat().hear("YXMTW,15.5,C") == [
        TemperatureExtendedRange(sid=sid, instance=0, source=sea, temperature=kelvin, set_temperature=None),
        Temperature(sid=sid, instance=0, source=sea, actual_temperature=kelvin, set_temperature=None),
    ]
    assert told("YXMTW,,C") == {}


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("IIVDR,120.0,T,118.0,M,1.0,N", near(set_reference=TRUE, set=radians(120), drift=KNOT)),
        ("IIVDR,,T,118.0,M,1.0,N", near(set_reference=MAGNETIC, set=radians(118), drift=KNOT)),
        ("IIVDR,,T,,M,1.0,N", near(set_reference=TRUE, drift=KNOT)),
    ],
)
def test_the_current_keeps_its_reference(body: str, expected: dict[str, object]):
    assert told(body) == {"SetDriftRapidUpdate": expected}


def test_a_current_without_values_is_not_told():
    assert told("IIVDR,,T,,M,,N") == {}


# Wind -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("WIMWV,45.0,R,10.0,N,A", near(wind_speed=10 * KNOT, wind_angle=radians(45), reference=WindReference.APPARENT)),
        ("WIMWV,315.0,T,5.0,M,A", near(wind_speed=5.0, wind_angle=radians(315), reference=WindReference.TRUE_BOAT)),
        ("WIMWV,45.0,R,36.0,K,A", near(wind_speed=10.0, wind_angle=radians(45), reference=WindReference.APPARENT)),
        ("WIMWV,45.0,R,10.0,S,A", near(wind_speed=4.4704, wind_angle=radians(45), reference=WindReference.APPARENT)),
        ("WIMWV,45.0,R,,N,A", near(wind_angle=radians(45), reference=WindReference.APPARENT)),
        ("WIMWV,45.0,R,10.0,,A", near(wind_angle=radians(45), reference=WindReference.APPARENT)),
        (
            "WIMWD,270.0,T,268.0,M,10.0,N,5.1,M",
            near(wind_speed=5.1, wind_angle=radians(270), reference=WindReference.TRUE_NORTH),
        ),
        (
            "WIMWD,,T,268.0,M,10.0,N,,M",
            near(wind_speed=10 * KNOT, wind_angle=radians(268), reference=WindReference.MAGNETIC_NORTH),
        ),
    ],
)
def test_wind_keeps_its_reference_and_comes_in_metres_a_second(body: str, expected: dict[str, object]):
    assert told(body) == {"WindData": expected}


@pytest.mark.parametrize(
    "body", ["WIMWV,45.0,R,10.0,N,V", "WIMWV,45.0,,10.0,N,A", "WIMWV,,R,,N,A", "WIMWD,,T,,M,,N,,M"]
)
def test_wind_that_is_invalid_or_against_nothing_known_is_not_told(body: str):
    assert told(body) == {}


# Position ---------------------------------------------------------------------------------------

PLACE = "3645.0000,N,00312.0000,W"


def test_gga_tells_position_quality_and_altitude():
    afloat = Afloat()
    afloat.hear("GPZDA,120000.00,22,11,2026,00,00")
    fix, position = afloat.hear(f"GPGGA,120000.50,{PLACE},2,08,0.9,12.3,M,45.0,M,1.5,0120")
    assert fix == GnssPositionData(
        sid=1,
        date=DAY,
        time=43200.5,
        latitude=36.75,
        longitude=-3.2,
        altitude=12.3,
        method=GnssMethod.DGNSS_FIX,
        number_of_svs=8,
        hdop=0.9,
        geoidal_separation=45.0,
        reference_stations=0,
    )
    assert position == PositionRapidUpdate(latitude=36.75, longitude=-3.2)


@pytest.mark.parametrize("quality", ["0", "", "9"])
def test_without_a_fix_there_is_no_position_and_the_bus_learns_it(quality: str):
    afloat = Afloat()
    lost = f"GPGGA,120001.00,{PLACE},{quality},00,99.9,12.3,M,45.0,M,,"
    assert afloat.hear(lost) == []  # who never had one has nothing to take back
    afloat.hear(f"GPGGA,120000.00,{PLACE},1,08,0.9,12.3,M,45.0,M,,")
    assert afloat.hear(lost) == [
        GnssPositionData(sid=1, time=43201.0, method=GnssMethod.NONE, number_of_svs=0, reference_stations=0)
    ]


@pytest.mark.parametrize(
    ("quality", "method"), [("6", GnssMethod.ESTIMATED), ("7", GnssMethod.MANUAL), ("8", GnssMethod.SIMULATED)]
)
def test_a_position_that_was_not_measured_goes_where_it_says_so_and_nowhere_else(quality: str, method: GnssMethod):
    [fix] = Afloat().hear(f"GPGGA,120000.00,{PLACE},{quality},08,0.9,12.3,M,45.0,M,,")
    assert isinstance(fix, GnssPositionData)
    assert (fix.method, fix.latitude) == (method, 36.75)


@pytest.mark.parametrize(
    ("told_at", "then", "day"),
    [("235959.00", "000000.00", DAY + 1), ("000000.00", "235959.00", DAY - 1), ("120000.00", "120001.00", DAY)],
)
def test_a_time_without_a_date_belongs_to_the_nearest_day(told_at: str, then: str, day: int):
    afloat = Afloat()
    afloat.hear(f"GPZDA,{told_at},22,11,2026,,")
    fix = afloat.hear(f"GPGGA,{then},{PLACE},1,08,0.9,12.3,M,45.0,M,,")[0]
    assert isinstance(fix, GnssPositionData)
    assert fix.date == day


def test_an_old_date_is_no_date():
    afloat = Afloat()
    afloat.hear("GPZDA,120000.00,22,11,2026,,")
    afloat.now = 10.0
    fix = afloat.hear(f"GPGGA,120010.00,{PLACE},1,08,0.9,12.3,M,45.0,M,,")[0]
    assert isinstance(fix, GnssPositionData)
    assert (fix.date, fix.time) == (None, 43210.0)


def test_rmc_alone_tells_time_fix_position_course_and_speed_of_one_instant():
    messages = Afloat().hear(f"GPRMC,120000.00,A,{PLACE},5.0,90.0,221126,2.2,E,D")
    assert messages == [
        SystemTime(sid=0, source=None, date=DAY, time=43200.0),
        GnssPositionData(
            sid=0,
            date=DAY,
            time=43200.0,
            latitude=36.75,
            longitude=-3.2,
            method=GnssMethod.DGNSS_FIX,
            reference_stations=0,
        ),
        PositionRapidUpdate(latitude=36.75, longitude=-3.2),
        CogSogRapidUpdate(sid=0, cog_reference=TRUE, cog=radians(90), sog=5 * KNOT),
    ]


def test_beside_gga_rmc_makes_no_fix_of_its_own():
    afloat = Afloat()
    afloat.hear(f"GPGGA,120000.00,{PLACE},1,08,0.9,12.3,M,45.0,M,,")
    names = [type(message) for message in afloat.hear(f"GPRMC,120000.00,A,{PLACE},5.0,90.0,221126,,,A")]
    assert names == [SystemTime, PositionRapidUpdate, CogSogRapidUpdate]


@pytest.mark.parametrize(("status", "mode"), [("V", "N"), ("V", ""), ("V", "A"), ("A", "N"), ("", "A")])
def test_a_void_rmc_takes_the_position_back_and_tells_neither_course_nor_speed(status: str, mode: str):
    afloat = Afloat()
    void = f"GPRMC,120001.00,{status},{PLACE},5.0,90.0,221126,,,{mode}"
    assert [type(message) for message in afloat.hear(void)] == [SystemTime, PositionRapidUpdate]
    afloat.hear(f"GPRMC,120000.00,A,{PLACE},5.0,90.0,221126,,,A")
    messages = afloat.hear(void)
    assert [type(message) for message in messages] == [SystemTime, GnssPositionData, PositionRapidUpdate]
    assert [fields(message).get("latitude") for message in messages] == [None] * 3


def test_a_simulated_rmc_says_so():
    messages = Afloat().hear(f"GPRMC,120000.00,V,{PLACE},5.0,90.0,221126,,,S")
    fix = messages[1]
    assert isinstance(fix, GnssPositionData)
    assert (fix.method, fix.latitude) == (GnssMethod.SIMULATED, 36.75)
    assert messages[2:] == [PositionRapidUpdate(latitude=None, longitude=None)]


def test_gll_tells_a_position_or_that_there_is_none():
    assert told(f"GPGLL,{PLACE},120000.00,A,A") == {"PositionRapidUpdate": near(latitude=36.75, longitude=-3.2)}
    assert told(f"GPGLL,{PLACE}") == {"PositionRapidUpdate": near(latitude=36.75, longitude=-3.2)}
    assert told(f"GPGLL,{PLACE},120000.00,V,N") == {"PositionRapidUpdate": {}}
    assert told(f"GPGLL,{PLACE},120000.00,A,S") == {"PositionRapidUpdate": {}}
    assert told("GPGLL,,,,,120000.00,A,A") == {}


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("GPVTG,90.0,T,88.0,M,5.0,N,9.3,K,A", near(cog_reference=TRUE, cog=radians(90), sog=5 * KNOT)),
        ("GPVTG,,T,88.0,M,,N,9.0,K,A", near(cog_reference=MAGNETIC, cog=radians(88), sog=2.5)),
        ("GPVTG,,T,,M,0.0,N,0.0,K,A", near(cog_reference=TRUE, sog=0.0)),
        ("GPVTG,90.0,T,88.0,M,5.0,N,9.3,K", near(cog_reference=TRUE, cog=radians(90), sog=5 * KNOT)),
    ],
)
def test_a_course_is_true_where_it_can_be(body: str, expected: dict[str, object]):
    assert told(body) == {"CogSogRapidUpdate": expected}


@pytest.mark.parametrize("body", ["GPVTG,90.0,T,88.0,M,5.0,N,9.3,K,N", "GPVTG,,T,,M,,N,,K,A", "GPZDA,120000.00,,,,,"])
def test_no_course_and_no_date_are_not_told(body: str):
    assert told(body) == {}


def test_the_31st_of_february_is_no_date():
    assert told("GPZDA,120000.00,31,02,2026,,") == {}


def test_sentences_of_one_instant_have_one_sequence_identifier():
    afloat = Afloat()
    messages = afloat.hear("GPZDA,120000.00,22,11,2026,,") + afloat.hear("GPVTG,90.0,T,,M,5.0,N,,K,A")
    messages += afloat.hear(f"GPGGA,120000.00,{PLACE},1,08,0.9,12.3,M,45.0,M,,")[:1]
    later = afloat.hear("GPZDA,120001.00,22,11,2026,,")
    assert [message.sid for message in [*messages, *later]] == [0, 0, 0, 1]  # type: ignore[attr-defined]


def test_sequence_identifiers_begin_anew_before_those_that_mean_nothing():
    afloat = Afloat()
    sids = [message.sid for _ in range(LAST_SID + 2) for message in afloat.hear("HEHDT,90.0,T")]  # type: ignore[attr-defined]
    assert sids == [*range(LAST_SID + 1), 0]


# Route ------------------------------------------------------------------------------------------


def test_the_cross_track_error_is_positive_where_the_boat_must_steer_left():
    assert told("GPXTE,A,A,0.100,L,N,A") == {"CrossTrackError": near(xte_mode=XteMode.AUTONOMOUS, xte=185.2)}
    assert told("GPXTE,A,A,0.100,R,N,D") == {
        "CrossTrackError": near(xte_mode=XteMode.DIFFERENTIAL_ENHANCED, xte=-185.2)
    }
    assert told("GPXTE,A,A,0.100,L,N") == {"CrossTrackError": near(xte=185.2)}


@pytest.mark.parametrize("head", ["V,A", "A,V", "V,V"])
def test_an_invalid_leg_has_no_error(head: str):
    assert told(f"GPXTE,{head},0.100,L,N,A") == {"CrossTrackError": {"xte_mode": XteMode.AUTONOMOUS}}


def test_a_simulated_leg_says_so():
    assert told("GPXTE,V,V,0.100,L,N,S") == {"CrossTrackError": near(xte_mode=XteMode.SIMULATOR, xte=185.2)}


RMB = "GPRMB,A,0.10,R,HOME,BUOY,3645.0000,N,00312.0000,W,12.5,90.0,4.5,V,A"
APB = "GPAPB,A,A,0.100,R,N,V,A,88.0,M,BUOY,87.0,M,86.0,M,A"


def test_rmb_alone_tells_distance_true_bearing_and_place():
    leg, data, route = Afloat().hear(RMB)
    assert fields(leg) == near(xte_mode=XteMode.AUTONOMOUS, xte=-185.2)
    assert fields(data) == near(
        distance_to_waypoint=12.5 * MILE,
        course_bearing_reference=TRUE,
        arrival_circle_entered=YesNo.NO,
        bearing_position_to_destination_waypoint=radians(90),
        origin_waypoint_number=60001,
        destination_waypoint_number=60002,
        destination_latitude=36.75,
        destination_longitude=-3.2,
        waypoint_closing_velocity=4.5 * KNOT,
    )
    assert isinstance(route, NavigationRouteWpInformation)
    assert [(w.wp_id, w.wp_name, w.wp_latitude) for w in route.waypoints] == [
        (60001, "HOME", None),
        (60002, "BUOY", 36.75),
    ]


def test_apb_brings_the_reference_of_the_bearings():
    afloat = Afloat()
    leg, alone, _ = afloat.hear(APB)
    assert fields(leg) == near(xte_mode=XteMode.AUTONOMOUS, xte=-185.2)
    bearings = {
        "course_bearing_reference": MAGNETIC,
        "bearing_origin_to_destination_waypoint": radians(88),
        "bearing_position_to_destination_waypoint": radians(87),
    }
    flags = {
        "arrival_circle_entered": YesNo.NO,
        "perpendicular_crossed": YesNo.YES,
        "destination_waypoint_number": 60001,
    }
    assert fields(alone) == near(**bearings, **flags)
    together = afloat.hear(RMB)[0]
    assert fields(together) | bearings == fields(together) | near(**bearings)
    assert fields(together)["distance_to_waypoint"] == pytest.approx(12.5 * MILE)


def test_where_xte_tells_the_error_apb_and_rmb_do_not():
    afloat = Afloat()
    afloat.hear("GPXTE,A,A,0.100,R,N,A")
    assert CrossTrackError not in [type(message) for message in afloat.hear(APB) + afloat.hear(RMB)]


def test_with_rmb_apb_waits_for_the_next_one():
    afloat = Afloat()
    afloat.hear(RMB)
    assert [type(message) for message in afloat.hear(APB)] == [CrossTrackError]
    afloat.now = 3.0
    assert NavigationData in [type(message) for message in afloat.hear(APB)]


@pytest.mark.parametrize(
    ("bearings", "leg"), [("88.0,T,BUOY,87.0,M", None), ("88.0,T,BUOY,,", radians(88)), ("88.0,M,BUOY,,", None)]
)
def test_a_bearing_in_the_other_reference_is_left_out(bearings: str, leg: float | None):
    data = Afloat().hear(f"GPAPB,A,A,0.100,R,N,V,A,{bearings},86.0,M,A")[1]
    assert isinstance(data, NavigationData)
    assert data.bearing_origin_to_destination_waypoint == (None if leg is None else pytest.approx(leg))


def test_names_the_other_way_round_are_seen_by_apbs_destination():
    afloat = Afloat()
    afloat.hear(APB)
    data = afloat.hear(RMB.replace("HOME,BUOY", "BUOY,HOME"))[0]
    assert isinstance(data, NavigationData)
    assert (data.destination_waypoint_number, data.origin_waypoint_number) == (60001, 60002)


def test_a_name_that_is_a_number_is_that_number_and_no_route():
    _, data = Afloat().hear(RMB.replace("HOME,BUOY", "3,17"))
    assert isinstance(data, NavigationData)
    assert (data.origin_waypoint_number, data.destination_waypoint_number) == (3, 17)


def test_an_error_at_its_limit_is_not_told_for_a_distance():
    leg = Afloat().hear(RMB.replace("0.10,R", "9.99,R"))[0]
    assert isinstance(leg, CrossTrackError)
    assert leg.xte is None


@pytest.mark.parametrize(
    "body", [RMB.replace("RMB,A", "RMB,V"), APB.replace("APB,A,A", "APB,V,A"), APB.replace("A,A,0", "A,V,0")]
)
def test_an_invalid_leg_has_no_way_to_the_waypoint(body: str):
    [leg] = Afloat().hear(body)
    assert isinstance(leg, CrossTrackError)
    assert leg.xte is None


def test_an_invalid_leg_ends_the_one_before():
    afloat = Afloat()
    afloat.hear(RMB)
    afloat.hear(APB)
    assert len(afloat.hear(RMB.replace("RMB,A", "RMB,V"))) == 0  # APB tells the error
    assert NavigationData in [type(message) for message in afloat.hear(APB)]
    afloat.hear(APB.replace("APB,A", "APB,V"))
    data = afloat.hear(RMB)[0]
    assert isinstance(data, NavigationData)
    assert data.course_bearing_reference is TRUE


def test_waypoints_are_told_when_they_change_and_again_after_a_while():
    afloat = Afloat()

    def routes(body: str) -> int:
        return sum(isinstance(message, NavigationRouteWpInformation) for message in afloat.hear(body))

    assert (routes(RMB), routes(RMB)) == (1, 0)
    assert routes(RMB.replace("BUOY", "PORT")) == 1
    afloat.now = 4.9
    assert routes(RMB.replace("BUOY", "PORT")) == 0
    afloat.now = 5.0
    assert routes(RMB.replace("BUOY", "PORT")) == 1


def test_a_thousand_names_later_numbering_begins_anew():
    afloat = Afloat()
    for number in range(1001):
        afloat.hear(RMB.replace("HOME,BUOY", f",W{number}"))
    data = afloat.hear(RMB.replace("HOME,BUOY", ",W1000"))[1]
    assert isinstance(data, NavigationData)
    assert data.destination_waypoint_number == 60001


# All of them ------------------------------------------------------------------------------------


def test_a_sentence_of_something_else_tells_nothing():
    typed = parse(seal("IIHSC,90.0,T,88.0,M").rstrip())
    assert isinstance(typed, s.HSC)
    assert Instruments().receive(typed, PORT, 0.0) == ()


def test_an_absurd_value_cannot_be_sent():
    [turn] = Afloat().hear("HEROT,500000.0,A")
    assert isinstance(turn, RateOfTurn)
    with pytest.raises(EncodeError, match="rate"):
        turn.encode()


def test_what_goes_out_goes_out_as_often_as_by_the_book():
    ceilings = Ceilings()
    heading = VesselHeading(sid=0, heading=1.0, deviation=None, variation=None, reference=TRUE)
    magnetic = VesselHeading(sid=0, heading=1.0, deviation=None, variation=None, reference=MAGNETIC)
    times = [tick / 50 for tick in range(500)]
    assert sum(ceilings.allow(heading, now) for now in times) in (100, 101)
    assert sum(ceilings.allow(magnetic, now) for now in times) in (100, 101)
    depth = WaterDepth(sid=0, depth=1.0, offset=None, range=None)
    assert sum(ceilings.allow(depth, now) for now in times) in (10, 11)


def test_what_is_sent_on_event_has_no_ceiling():
    route = NavigationRouteWpInformation(
        start_rps=0,
        database_id=None,
        route_id=None,
        navigation_direction_in_route=None,
        supplementary_route_wp_data_available=None,
        route_name=None,
    )
    assert all(Ceilings().allow(route, 0.0) for _ in range(3))
