"""NMEA 2000 to NMEA 0183: what each message becomes, and when."""

from math import radians, tau

import pytest

from timonel.core.effects import Rejected, Say
from timonel.nmea2000.lookups import (
    DirectionRudder,
    GnssMethod,
    HeadingReference,
    HumiditySource,
    SteeringMode,
    TemperatureSource,
    TimeSource,
    TurnMode,
    VariationSource,
    WaterReference,
    WindReference,
    XteMode,
    YesNo,
)
from timonel.nmea2000.messages.environment import (
    EnvironmentalParameters,
    EnvironmentalParametersObsolete,
    Temperature,
    TemperatureExtendedRange,
    WindData,
)
from timonel.nmea2000.messages.navigation import (
    CogSogRapidUpdate,
    CrossTrackError,
    DistanceLog,
    GnssPositionData,
    NavigationData,
    NavigationRouteWpInformation,
    PositionRapidUpdate,
    Speed,
    SystemTime,
    TimeDate,
    WaterDepth,
    Waypoint,
)
from timonel.nmea2000.messages.steering import (
    Attitude,
    HeadingTrackControl,
    MagneticVariation,
    RateOfTurn,
    Rudder,
    VesselHeading,
)
from timonel.vehicles.boat.conversion import CONVERSIONS, HEAR, RATES, Converter
from timonel.vehicles.boat.truth import Truth

TRUE, MAGNETIC = HeadingReference.TRUE, HeadingReference.MAGNETIC
DAY = 19793  # 2024-03-11
KNOT = 1852 / 3600


class Afloat:
    """A converter that says nothing but `wanted`, ten times a second unless `rate` says otherwise."""

    def __init__(self, *wanted, rate=10.0, dialect="standard", model=None):
        rates = dict.fromkeys(RATES, 0.0) | dict.fromkeys(wanted, rate)
        self.converter = Converter(Truth(3.0, model), rates, dialect)

    def effects(self, message, now=0.0, source=1):
        return self.converter.receive(message, source, now)[0]

    def hear(self, message, now=0.0, source=1):
        """The sentences that a message brings about, without `$`, check sum and line end."""
        effects = self.effects(message, now, source)
        assert all(isinstance(effect, Say) for effect in effects), effects
        return [effect.line[1:-5].decode() for effect in effects]


def heading(degrees, reference=TRUE, deviation=None, variation=None):
    parts = (None if part is None else radians(part) for part in (degrees, deviation, variation))
    return VesselHeading(None, *parts, reference)


def variation(degrees):
    told = None if degrees is None else radians(degrees)
    return MagneticVariation(None, VariationSource.WMM_2020, age_of_service=None, variation=told)


def position(latitude=54.5, longitude=-10.25):
    return PositionRapidUpdate(latitude, longitude)


def fix(method=GnssMethod.GNSS_FIX, latitude=54.5, longitude=-10.25, date=DAY, time=43200.0, **values):
    return GnssPositionData(date=date, time=time, latitude=latitude, longitude=longitude, method=method, **values)


def clock(time=43200.0, date=DAY):
    return SystemTime(None, TimeSource.GPS, date=date, time=time)


def course(cog=90.0, sog=10 * KNOT, reference=TRUE):
    return CogSogRapidUpdate(None, reference, cog=None if cog is None else radians(cog), sog=sog)


def wind(reference, angle=30.0, speed=10 * KNOT):
    return WindData(None, speed, None if angle is None else radians(angle), reference)


def speed(water):
    return Speed(None, water, None, WaterReference.PADDLE_WHEEL, None)


def cross_track(xte, terminated=YesNo.NO, mode=XteMode.AUTONOMOUS):
    return CrossTrackError(None, mode, navigation_terminated=terminated, xte=xte)


def leg(**values):
    told = {
        "distance_to_waypoint": 1852.0 * 12.3,
        "course_bearing_reference": TRUE,
        "perpendicular_crossed": YesNo.NO,
        "arrival_circle_entered": YesNo.NO,
        "bearing_origin_to_destination_waypoint": radians(80.0),
        "bearing_position_to_destination_waypoint": radians(85.0),
        "origin_waypoint_number": 4,
        "destination_waypoint_number": 5,
        "destination_latitude": 54.75,
        "destination_longitude": -9.5,
        "waypoint_closing_velocity": 5 * KNOT,
    }
    return NavigationData(**told | values)


def route(**names):
    points = tuple(Waypoint(int(number[1:]), name, None, None) for number, name in names.items())
    return NavigationRouteWpInformation(None, len(points), None, None, None, None, route_name=None, waypoints=points)


# Heading ----------------------------------------------------------------------------------------


def test_a_true_heading_goes_through():
    assert Afloat("HDT", "THS").hear(heading(123.44)) == ["IIHDT,123.4,T", "IITHS,123.4,A"]


def test_a_true_heading_becomes_magnetic_by_taking_easterly_variation_away():
    afloat = Afloat("HDG", "HDM")
    assert afloat.hear(heading(10.0, variation=12.5)) == ["IIHDG,357.5,,,12.5,E", "IIHDM,357.5,M"]


def test_a_true_heading_without_variation_gives_no_magnetic_one():
    assert Afloat("HDG", "HDM").hear(heading(10.0)) == []


def test_a_compass_heading_stays_what_it_is_in_hdg():
    told = heading(100.0, MAGNETIC, deviation=-2.0, variation=-5.5)
    assert Afloat("HDG").hear(told) == ["IIHDG,100.0,2.0,W,5.5,W"]


def test_magnetic_is_compass_and_deviation_and_true_is_magnetic_and_variation():
    told = heading(355.0, MAGNETIC, deviation=3.0, variation=4.0)
    assert Afloat("HDT", "THS", "HDM").hear(told) == ["IIHDT,2.0,T", "IITHS,2.0,A", "IIHDM,358.0,M"]


def test_a_compass_that_tells_no_deviation_has_none():
    told = heading(100.0, MAGNETIC, variation=4.0)
    assert Afloat("HDT", "HDG", "HDM").hear(told) == ["IIHDT,104.0,T", "IIHDG,100.0,,,4.0,E", "IIHDM,100.0,M"]


def test_a_magnetic_heading_never_stands_in_hdt():
    afloat = Afloat("HDT", "THS", "HDG", "HDM")
    assert afloat.hear(heading(100.0, MAGNETIC)) == ["IIHDG,100.0,,,,", "IIHDM,100.0,M"]


def test_a_compass_own_variation_comes_before_that_of_the_bus():
    afloat = Afloat("HDT", "HDG")
    afloat.hear(variation(8.0), source=2)
    told = heading(100.0, MAGNETIC, variation=4.0)
    assert afloat.hear(told) == ["IIHDT,104.0,T", "IIHDG,100.0,,,4.0,E"]


def test_without_its_own_a_compass_is_corrected_by_the_variation_of_the_bus():
    afloat = Afloat("HDT", "HDG", model=lambda *_: radians(1.0))
    afloat.hear(variation(8.0), source=2)
    assert afloat.hear(heading(100.0, MAGNETIC), 2.9) == ["IIHDT,108.0,T", "IIHDG,100.0,,,8.0,E"]


def test_where_the_bus_tells_no_variation_the_model_computes_it_for_position_and_time():
    asked = []

    def model(*where):
        asked.append(where)
        return radians(-3.0)

    afloat = Afloat("HDT", "HDG", model=model)
    afloat.hear(position(54.5, -10.25))
    afloat.hear(clock())
    assert afloat.hear(heading(100.0, MAGNETIC)) == ["IIHDT,97.0,T", "IIHDG,100.0,,,3.0,W"]
    assert asked == [(54.5, -10.25, DAY * 86400 + 43200)]


def test_the_model_needs_a_position_and_a_date():
    afloat = Afloat("HDT", model=lambda *_: 0.1)
    assert afloat.hear(heading(100.0, MAGNETIC)) == []
    afloat.hear(position())
    assert afloat.hear(heading(100.0, MAGNETIC), 0.1) == []
    afloat.hear(clock(), 0.2)
    assert afloat.hear(heading(100.0, MAGNETIC), 0.2) == ["IIHDT,105.7,T"]


def test_variation_of_the_bus_is_forgotten_after_three_seconds():
    afloat = Afloat("HDT")
    afloat.hear(variation(8.0), source=2)
    assert afloat.hear(heading(100.0, MAGNETIC), 3.0) == []


@pytest.mark.parametrize("reference", [HeadingReference.ERROR, None])
def test_a_heading_of_no_reference_is_no_heading(reference):
    assert Afloat("HDT", "THS", "HDG", "HDM").hear(heading(100.0, reference, variation=4.0)) == []


def test_a_heading_that_is_not_available_gives_no_sentence():
    assert Afloat("HDT", "THS", "HDG", "HDM").hear(heading(None, MAGNETIC, 1.0, 4.0)) == []


@pytest.mark.parametrize("radian", [radians(359.96), 6.2832, tau])
def test_a_heading_that_rounds_to_a_full_turn_is_zero(radian):
    told = VesselHeading(None, radian, None, 0.0, MAGNETIC)
    assert Afloat("HDT", "HDG").hear(told) == ["IIHDT,0.0,T", "IIHDG,0.0,,,0.0,E"]


def test_two_compasses_each_bring_their_own_sentence_about():
    afloat = Afloat("HDT", "HDG", "HDM")
    assert afloat.hear(heading(104.0), 0.00, source=1) == ["IIHDT,104.0,T"]
    assert afloat.hear(heading(90.0, MAGNETIC, variation=4.0), 0.05, source=2) == ["IIHDG,90.0,,,4.0,E", "IIHDM,90.0,M"]
    assert afloat.hear(heading(105.0), 0.10, source=1) == ["IIHDT,105.0,T"]


def test_a_magnetic_compass_stands_in_for_a_true_one_that_has_been_silent_for_a_second():
    afloat = Afloat("HDT")
    afloat.hear(heading(104.0), 0.0, source=1)
    assert afloat.hear(heading(90.0, MAGNETIC, variation=4.0), 0.9, source=2) == []
    assert afloat.hear(heading(90.0, MAGNETIC, variation=4.0), 1.0, source=2) == ["IIHDT,94.0,T"]
    assert afloat.hear(heading(104.0), 1.1, source=1) == ["IIHDT,104.0,T"]


def test_a_compass_that_says_it_has_no_heading_is_replaced_at_once():
    afloat = Afloat("HDT")
    afloat.hear(heading(104.0), 0.0, source=1)
    afloat.hear(heading(None), 0.1, source=1)
    assert afloat.hear(heading(90.0, MAGNETIC, variation=4.0), 0.2, source=2) == ["IIHDT,94.0,T"]


# Turning and steering ---------------------------------------------------------------------------


@pytest.mark.parametrize(("degrees", "text"), [(1.5, "90.0"), (-0.25, "-15.0"), (-0.0005, "0.0")])
def test_rate_of_turn_is_in_degrees_a_minute_and_negative_to_port(degrees, text):
    assert Afloat("ROT").hear(RateOfTurn(None, radians(degrees))) == [f"IIROT,{text},A"]


def test_no_rate_of_turn_is_no_sentence():
    assert Afloat("ROT").hear(RateOfTurn(None, None)) == []


@pytest.mark.parametrize(("degrees", "text"), [(7.5, "7.5"), (-7.5, "-7.5")])
def test_a_rudder_to_starboard_is_positive(degrees, text):
    told = Rudder(0, None, angle_order=None, position=radians(degrees))
    assert Afloat("RSA").hear(told) == [f"IIRSA,{text},A,,"]


def test_an_order_to_the_rudder_is_not_its_angle():
    assert Afloat("RSA").hear(Rudder(0, None, angle_order=radians(5.0), position=None)) == []


def test_attitude_is_pitch_bow_up_and_roll_starboard_down():
    told = Attitude(None, yaw=None, pitch=radians(-1.25), roll=radians(12.0))
    assert Afloat("XDR").hear(told) == ["IIXDR,A,-1.2,D,PITCH,A,12,D,ROLL"]


def test_attitude_names_only_what_is_known():
    afloat = Afloat("XDR")
    assert afloat.hear(Attitude(None, yaw=None, pitch=radians(2.0), roll=None)) == ["IIXDR,A,2,D,PITCH"]
    assert afloat.hear(Attitude(None, yaw=radians(2.0), pitch=None, roll=None), 1.0) == []


def test_heading_control_is_told_field_by_field():
    told = HeadingTrackControl(
        rudder_limit_exceeded=YesNo.NO,
        off_heading_limit_exceeded=YesNo.NO,
        off_track_limit_exceeded=YesNo.NO,
        override=YesNo.NO,
        steering_mode=SteeringMode.HEADING_CONTROL,
        turn_mode=TurnMode.RUDDER_LIMIT_CONTROLLED,
        heading_reference=TRUE,
        rudder_limit=radians(25.0),
        off_heading_limit=radians(20.0),
        heading_to_steer_course=radians(190.4),
        vessel_heading=radians(186.4),
    )
    assert Afloat("HTD").effects(told) == [Say(b"$AGHTD,V,,,H,N,25.0,20.0,,,190.4,,,T,A,A,A,186.4*35\r\n", "HTD")]


def test_track_control_of_a_furuno_pilot():
    told = HeadingTrackControl.decode(bytes.fromhex("004d3fff7fcf81cf81ffffffffff7fff7fff7f147f"))
    assert Afloat("HTD").hear(told) == ["AGHTD,V,,R,T,T,,,,,190.4,,190.4,M,A,A,A,186.4"]


@pytest.mark.parametrize(
    ("mode", "letter"),
    [
        (SteeringMode.MAIN_STEERING, "M"),
        (SteeringMode.NON_FOLLOW_UP, "R"),
        (SteeringMode.FOLLOW_UP, "R"),
        (SteeringMode.HEADING_CONTROL_STANDALONE, "S"),
        (SteeringMode.HEADING_CONTROL, "H"),
        (SteeringMode.TRACK_CONTROL, "T"),
    ],
)
def test_each_steering_mode_has_its_letter(mode, letter):
    assert Afloat("HTD").hear(HeadingTrackControl(steering_mode=mode)) == [f"AGHTD,,,,{letter}" + "," * 13]


@pytest.mark.parametrize(("turn", "letter"), list(zip(TurnMode, "NTR", strict=True)))
def test_each_turn_mode_has_its_letter(turn, letter):
    assert Afloat("HTD").hear(HeadingTrackControl(turn_mode=turn)) == [f"AGHTD,,,,,{letter}" + "," * 12]


def test_a_rudder_order_has_a_magnitude_and_a_side():
    afloat = Afloat("HTD")
    order = HeadingTrackControl(commanded_rudder_angle=radians(-3.2))
    assert afloat.hear(order) == ["AGHTD,,3.2,L" + "," * 14]
    side = HeadingTrackControl(commanded_rudder_direction=DirectionRudder.STARBOARD)
    assert afloat.hear(side, 1.0) == ["AGHTD,,,R" + "," * 14]


def test_limits_of_a_pilot_are_miles_degrees_and_degrees_a_minute():
    told = HeadingTrackControl(
        override=YesNo.YES,
        radius_of_turn_order=-463,
        rate_of_turn_order=radians(0.5),
        off_track_limit=926,
        off_track_limit_exceeded=YesNo.YES,
    )
    assert Afloat("HTD").hear(told) == ["AGHTD,A,,,,,,,0.25,30.0,,0.50,,,,,V,"]


def test_a_pilot_that_tells_nothing_but_a_reference_is_not_quoted():
    assert Afloat("HTD").hear(HeadingTrackControl(heading_reference=MAGNETIC)) == []


# Water ------------------------------------------------------------------------------------------


def test_speed_through_water_comes_with_both_headings():
    afloat = Afloat("VHW")
    afloat.hear(heading(100.0, MAGNETIC, deviation=1.0, variation=4.0))
    assert afloat.hear(speed(5 * KNOT)) == ["IIVHW,105.0,T,101.0,M,5.0,N,9.3,K"]


def test_a_heading_older_than_three_seconds_leaves_its_fields_empty():
    afloat = Afloat("VHW")
    afloat.hear(heading(100.0))
    assert afloat.hear(speed(5 * KNOT), 2.9) == ["IIVHW,100.0,T,,,5.0,N,9.3,K"]
    assert afloat.hear(speed(5 * KNOT), 3.0) == ["IIVHW,,,,,5.0,N,9.3,K"]


def test_speed_over_ground_is_not_speed_through_water():
    assert Afloat("VHW").hear(Speed(None, None, 5.0, WaterReference.PADDLE_WHEEL, None)) == []


@pytest.mark.parametrize(("offset", "text"), [(0.6, "0.6"), (-1.4, "-1.4"), (None, "")])
def test_depth_keeps_the_offset_it_came_with(offset, text):
    assert Afloat("DPT").hear(WaterDepth(None, 12.34, offset, None)) == [f"IIDPT,12.3,{text}"]


def test_depth_has_the_range_of_the_sounder_where_it_is_told():
    assert Afloat("DPT").hear(WaterDepth(None, 12.34, 0.0, 200)) == ["IIDPT,12.3,0.0,200.0"]


def test_depth_below_the_transducer_is_in_feet_metres_and_fathoms():
    assert Afloat("DBT").hear(WaterDepth(None, 18.288, None, None)) == ["IIDBT,60.0,f,18.3,M,10.0,F"]


def test_no_depth_is_no_sentence():
    assert Afloat("DPT", "DBT").hear(WaterDepth(None, None, 0.6, 200)) == []


def test_the_log_is_in_miles():
    assert Afloat("VLW").hear(DistanceLog(None, None, 1852000, 2315)) == ["IIVLW,1000.00,N,1.25,N"]


def test_half_a_log_is_a_log():
    afloat = Afloat("VLW")
    assert afloat.hear(DistanceLog(None, None, None, 1852)) == ["IIVLW,,N,1.00,N"]
    assert afloat.hear(DistanceLog(None, None, None, None), 1.0) == []


SEA = TemperatureSource.SEA
EXTENDED = TemperatureExtendedRange(None, 0, SEA, 283.15, None)
PLAIN = Temperature(None, 0, SEA, 284.15, None)
COMBINED = EnvironmentalParameters(None, SEA, HumiditySource.OUTSIDE, 285.15, None, None)
OLDEST = EnvironmentalParametersObsolete(None, 286.15, None, None)


def test_the_best_source_of_water_temperature_wins():
    afloat = Afloat("MTW")
    assert [afloat.hear(message, now) for now, message in enumerate((OLDEST, COMBINED, PLAIN, EXTENDED))] == [
        ["IIMTW,13.0,C"],
        ["IIMTW,12.0,C"],
        ["IIMTW,11.0,C"],
        ["IIMTW,10.0,C"],
    ]
    assert [afloat.hear(message, 3.5) for message in (OLDEST, COMBINED, PLAIN)] == [[], [], []]


def test_a_lesser_source_of_water_temperature_takes_over_from_one_that_is_silent():
    afloat = Afloat("MTW")
    afloat.hear(EXTENDED)
    assert afloat.hear(OLDEST, 3.9) == []
    assert afloat.hear(OLDEST, 4.0) == ["IIMTW,13.0,C"]


@pytest.mark.parametrize(
    "message",
    [
        TemperatureExtendedRange(None, 0, TemperatureSource.OUTSIDE, 283.15, None),
        Temperature(None, 0, TemperatureSource.INSIDE, 284.15, None),
        EnvironmentalParameters(None, TemperatureSource.OUTSIDE, None, 285.15, None, None),
        EnvironmentalParametersObsolete(None, None, 290.0, 101300),
        TemperatureExtendedRange(None, 0, SEA, None, None),
    ],
)
def test_only_the_sea_has_a_water_temperature(message):
    assert Afloat("MTW").hear(message) == []


def test_water_just_below_freezing_is_not_minus_zero():
    assert Afloat("MTW").hear(EnvironmentalParametersObsolete(None, 273.14, None, None)) == ["IIMTW,0.0,C"]


# Position, course and time ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("latitude", "longitude", "text"),
    [
        (54.5, -10.25, "5430.000000,N,01015.000000,W"),
        (-33.8567844, 151.2152967, "3351.407064,S,15112.917802,E"),
        (59.999999995, -180.0, "6000.000000,N,18000.000000,W"),
        (1e-7, -1e-7, "0000.000006,N,00000.000006,W"),
        (-1e-10, -1e-10, "0000.000000,N,00000.000000,E"),
        (-90.0, 180.0, "9000.000000,S,18000.000000,E"),
    ],
)
def test_a_position_keeps_every_digit_that_it_came_with(latitude, longitude, text):
    assert Afloat("GLL").hear(position(latitude, longitude)) == [f"GPGLL,{text},,A,A"]


@pytest.mark.parametrize(("latitude", "longitude"), [(None, -10.25), (54.5, None), (None, None)])
def test_half_a_position_is_none(latitude, longitude):
    assert Afloat("GLL").hear(position(latitude, longitude)) == []


def test_the_time_of_a_position_is_that_of_the_bus():
    afloat = Afloat("GLL")
    afloat.hear(clock(45296.25))
    assert afloat.hear(position(), 1.9) == ["GPGLL,5430.000000,N,01015.000000,W,123456.25,A,A"]
    assert afloat.hear(position(), 2.0) == ["GPGLL,5430.000000,N,01015.000000,W,,A,A"]


def test_once_a_second_a_position_goes_with_the_clock_so_that_its_time_is_its_own():
    afloat = Afloat("GLL", rate=1.0)
    said = afloat.hear(clock(43199.5))
    for tenth in range(40):
        said += afloat.hear(position(54.0 + tenth / 10), tenth / 10)
        said += afloat.hear(clock(43200.0 + tenth / 10), tenth / 10) if tenth % 10 == 5 else []
    assert said == [
        "GPGLL,5430.000000,N,01015.000000,W,120000.50,A,A",
        "GPGLL,5530.000000,N,01015.000000,W,120001.50,A,A",
        "GPGLL,5630.000000,N,01015.000000,W,120002.50,A,A",
        "GPGLL,5730.000000,N,01015.000000,W,120003.50,A,A",
    ]
    assert afloat.hear(position(58.0), 5.5) == ["GPGLL,5800.000000,N,01015.000000,W,,A,A"], "the clock fell silent"


def test_a_clock_that_counts_from_1970_is_no_clock():
    afloat = Afloat("GLL", "RMC", "ZDA")
    assert afloat.hear(clock(date=0)) == []
    assert afloat.hear(position()) == ["GPGLL,5430.000000,N,01015.000000,W,,A,A"]
    assert afloat.hear(course()) == ["GPRMC,,A,5430.000000,N,01015.000000,W,10.0,90.0,,,,A"]


@pytest.mark.parametrize(
    "message",
    [clock(date=None), clock(time=None), TimeDate(DAY, None, None), fix(date=None, latitude=None)],
)
def test_half_a_clock_is_none(message):
    assert Afloat("ZDA").hear(message) == []


def test_date_and_time_come_from_three_messages_the_best_of_which_is_kept_to():
    afloat = Afloat("ZDA")
    assert afloat.hear(TimeDate(DAY, 3600.0, None), 0.0) == ["GPZDA,010000,11,03,2024,,"]
    assert afloat.hear(clock(3601.0), 0.5) == ["GPZDA,010001,11,03,2024,,"]
    assert afloat.hear(fix(time=3602.0), 0.9) == ["GPZDA,010002,11,03,2024,,"]
    assert afloat.hear(clock(9999.0), 1.5) == []
    assert afloat.hear(TimeDate(DAY, 9999.0, None), 1.6) == []


METHODS = {
    GnssMethod.NONE: ("V,N", 0),
    GnssMethod.GNSS_FIX: ("A,A", 1),
    GnssMethod.DGNSS_FIX: ("A,D", 2),
    GnssMethod.PRECISE_GNSS: ("A,P", 3),
    GnssMethod.RTK_FIXED_INTEGER: ("A,R", 4),
    GnssMethod.RTK_FLOAT: ("A,F", 5),
    GnssMethod.ESTIMATED: ("V,E", 6),
    GnssMethod.MANUAL: ("V,M", 7),
    GnssMethod.SIMULATED: ("V,S", 8),
}


def test_every_way_to_find_a_position_has_a_mode():
    assert METHODS.keys() == set(GnssMethod)


@pytest.mark.parametrize(("method", "status", "quality"), [(m, *told) for m, told in METHODS.items()])
def test_status_mode_and_quality_tell_how_the_position_was_found(method, status, quality):
    afloat = Afloat("GLL", "GGA", "RMC", "VTG")
    place = "5430.000000,N,01015.000000,W"
    assert afloat.hear(fix(method)) == [f"GPGLL,{place},120000,{status}", f"GPGGA,120000,{place},{quality},,,,M,,M,,"]
    valid, mode = status.split(",")
    assert afloat.hear(course()) == [
        f"GPRMC,120000,{valid},{place},10.0,90.0,110324,,,{mode}",
        f"GPVTG,90.0,T,,M,10.0,N,18.5,K,{mode}",
    ]


def test_a_position_whose_way_nobody_tells_is_an_ordinary_one_and_one_not_understood_is_not_trusted():
    afloat = Afloat("GLL")
    place = "GPGLL,5430.000000,N,01015.000000,W,120000"
    assert afloat.hear(fix(method=None)) == [f"{place},A,A"]
    assert afloat.hear(fix(method=13), 1.0) == [f"{place},V,N"]


def test_quality_of_a_fix_is_told_with_it():
    told = fix(number_of_svs=9, hdop=0.85, altitude=-3.21, geoidal_separation=48.5)
    assert Afloat("GGA").hear(told) == ["GPGGA,120000,5430.000000,N,01015.000000,W,1,09,0.8,-3.2,M,48.5,M,,"]


def test_more_satellites_than_two_digits_hold_are_ninety_nine():
    assert ",1,99," in Afloat("GGA").hear(fix(number_of_svs=120))[0]


def test_an_absurd_altitude_is_rejected_and_nothing_else_suffers():
    effects = Afloat("GGA", "GLL").effects(fix(altitude=1.44e12), source=3)
    assert effects == [
        Say(b"$GPGLL,5430.000000,N,01015.000000,W,120000,A,A*51\r\n", "GLL"),
        Rejected("GGA.altitude_m: 1440000000000.0 is outside -1e+06..1e+08", source="GnssPositionData from 3"),
    ]


def test_recommended_minimum_data_come_from_four_messages():
    afloat = Afloat("RMC")
    for message in (position(), clock(45296.25), variation(-1.5)):
        afloat.hear(message)
    assert afloat.hear(course(123.44)) == ["GPRMC,123456.25,A,5430.000000,N,01015.000000,W,10.0,123.4,110324,1.5,W,A"]


def test_recommended_minimum_data_without_a_position_are_void():
    assert Afloat("RMC").hear(course()) == ["GPRMC,,V,,,,,10.0,90.0,,,,N"]


def test_a_position_older_than_three_seconds_is_none():
    afloat = Afloat("RMC")
    afloat.hear(position())
    assert afloat.hear(course(), 2.9)[0].startswith("GPRMC,,A,5430.000000")
    assert afloat.hear(course(), 3.0) == ["GPRMC,,V,,,,,10.0,90.0,,,,N"]


@pytest.mark.parametrize(
    ("reference", "true", "magnetic"),
    [(TRUE, "90.0", "86.0"), (MAGNETIC, "94.0", "90.0"), (HeadingReference.ERROR, "", ""), (None, "", "")],
)
def test_a_course_is_told_true_and_magnetic_where_variation_is_known(reference, true, magnetic):
    afloat = Afloat("VTG", "RMC")
    afloat.hear(variation(4.0))
    assert afloat.hear(course(90.0, reference=reference)) == [
        f"GPRMC,,V,,,,,10.0,{true},,4.0,E,N",
        f"GPVTG,{true},T,{magnetic},M,10.0,N,18.5,K,A",
    ]


def test_without_variation_a_magnetic_course_stands_in_the_magnetic_field_only():
    afloat = Afloat("VTG", "RMC")
    assert afloat.hear(course(90.0, reference=MAGNETIC)) == [
        "GPRMC,,V,,,,,10.0,,,,,N",
        "GPVTG,,T,90.0,M,10.0,N,18.5,K,A",
    ]


def test_a_boat_at_rest_has_a_speed_and_no_course():
    afloat = Afloat("VTG")
    assert afloat.hear(course(None, 0.0)) == ["GPVTG,,T,,M,0.0,N,0.0,K,A"]
    assert afloat.hear(course(None, None), 1.0) == []


# Wind -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("reference", "letter"),
    [(WindReference.APPARENT, "R"), (WindReference.TRUE_BOAT, "T"), (WindReference.TRUE_WATER, "T")],
)
def test_wind_counted_from_the_bow_is_relative_or_theoretical(reference, letter):
    assert Afloat("MWV", "MWD").hear(wind(reference, 330.0)) == [f"IIMWV,330.0,{letter},10.0,N,A"]


def test_wind_counted_from_true_north_is_a_direction_and_never_an_angle():
    assert Afloat("MWV", "MWD").hear(wind(WindReference.TRUE_NORTH, 330.0)) == ["IIMWD,330.0,T,,M,10.0,N,5.1,M"]


@pytest.mark.parametrize(
    ("reference", "text"),
    [(WindReference.TRUE_NORTH, "2.0,T,358.0,M"), (WindReference.MAGNETIC_NORTH, "6.0,T,2.0,M")],
)
def test_a_wind_direction_is_told_true_and_magnetic_where_variation_is_known(reference, text):
    afloat = Afloat("MWD")
    afloat.hear(variation(4.0))
    assert afloat.hear(wind(reference, 2.0)) == [f"IIMWD,{text},10.0,N,5.1,M"]


def test_a_wind_without_an_angle_or_a_speed_leaves_it_empty():
    afloat = Afloat("MWV")
    assert afloat.hear(wind(WindReference.APPARENT, None)) == ["IIMWV,,R,10.0,N,A"]
    assert afloat.hear(wind(WindReference.APPARENT, 30.0, None), 1.0) == ["IIMWV,30.0,R,,N,A"]
    assert afloat.hear(wind(WindReference.APPARENT, None, None), 2.0) == []


def test_a_wind_of_no_reference_is_none():
    assert Afloat("MWV", "MWD").hear(wind(None)) == []


def test_apparent_and_theoretical_wind_each_have_their_ceiling():
    afloat = Afloat("MWV", rate=1.0)
    said = [
        line.split(",")[2]
        for tenth in range(50)
        for reference in (WindReference.APPARENT, WindReference.TRUE_BOAT)
        for line in afloat.hear(wind(reference), tenth / 10)
    ]
    assert (said.count("R"), said.count("T")) == (6, 6)


def test_of_two_theoretical_winds_the_one_against_the_water_is_told():
    afloat = Afloat("MWV")
    assert afloat.hear(wind(WindReference.TRUE_BOAT, 40.0), 0.0) == ["IIMWV,40.0,T,10.0,N,A"]
    assert afloat.hear(wind(WindReference.TRUE_WATER, 45.0), 0.1) == ["IIMWV,45.0,T,10.0,N,A"]
    assert afloat.hear(wind(WindReference.TRUE_BOAT, 40.0), 0.2) == []


# Route ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("xte", "text"), [(185.2, "0.100,L"), (-185.2, "0.100,R"), (0.0, "0.000,L")])
def test_a_positive_cross_track_error_asks_to_steer_left(xte, text):
    afloat = Afloat("XTE", "RMB", "APB")
    assert afloat.hear(cross_track(xte)) == [f"GPXTE,A,A,{text},N,A"]
    assert [sentence.split(",")[3] for sentence in afloat.hear(leg())] == [text[-1], text[:5]]


@pytest.mark.parametrize(
    ("mode", "letters"),
    [
        (XteMode.AUTONOMOUS, "A,A"),
        (XteMode.DIFFERENTIAL_ENHANCED, "A,D"),
        (XteMode.ESTIMATED, "V,E"),
        (XteMode.SIMULATOR, "V,S"),
        (XteMode.MANUAL, "V,M"),
        (9, "V,N"),
        (None, "A,A"),
    ],
)
def test_status_and_mode_tell_how_the_cross_track_error_was_found(mode, letters):
    status, letter = letters.split(",")
    assert Afloat("XTE").hear(cross_track(100.0, mode=mode)) == [f"GPXTE,{status},A,0.054,L,N,{letter}"]


def test_navigation_that_is_terminated_is_not_valid():
    afloat = Afloat("XTE", "RMB", "APB")
    assert afloat.hear(cross_track(185.2, YesNo.YES)) == ["GPXTE,V,V,0.100,L,N,A"]
    assert [sentence[:9] for sentence in afloat.hear(leg())] == ["GPRMB,V,0", "GPAPB,V,V"]


def test_no_cross_track_error_is_no_xte_and_takes_the_leg_its_validity():
    afloat = Afloat("XTE", "RMB", "APB")
    afloat.hear(cross_track(185.2))
    assert afloat.hear(cross_track(None), 1.0) == []
    assert [sentence[:11] for sentence in afloat.hear(leg(), 1.0)] == ["GPRMB,V,,,4", "GPAPB,V,V,,"]


def test_a_source_without_a_track_does_not_silence_one_that_has_it():
    afloat = Afloat("RMB")
    afloat.hear(cross_track(None), 0.0, source=1)
    afloat.hear(cross_track(185.2), 0.1, source=2)
    afloat.hear(cross_track(None), 0.2, source=1)
    assert afloat.hear(leg(), 0.3, source=2)[0].startswith("GPRMB,A,0.10,L")


def test_a_leg_is_told_to_displays_and_pilots():
    afloat = Afloat("RMB", "APB")
    afloat.hear(cross_track(185.2))
    assert afloat.hear(leg()) == [
        "GPRMB,A,0.10,L,4,5,5445.000000,N,00930.000000,W,12.3,85.0,5.0,V,A",
        "GPAPB,A,A,0.100,L,N,V,V,80.0,T,5,85.0,T,85.0,T,A",
    ]


def test_without_cross_track_error_there_is_no_leg():
    assert Afloat("RMB", "APB").hear(leg()) == []


def test_a_leg_without_bearing_and_distance_is_none():
    afloat = Afloat("RMB", "APB")
    afloat.hear(cross_track(185.2))
    empty = leg(distance_to_waypoint=None, bearing_position_to_destination_waypoint=None)
    assert afloat.hear(empty) == []


def test_magnetic_bearings_stay_magnetic_in_apb_and_become_true_in_rmb():
    afloat = Afloat("RMB", "APB")
    afloat.hear(cross_track(185.2))
    magnetic = leg(course_bearing_reference=MAGNETIC)
    rmb, apb = afloat.hear(magnetic)
    assert rmb.split(",")[11] == ""
    assert apb.endswith("80.0,M,5,85.0,M,85.0,M,A")
    afloat.hear(variation(4.0), 1.0)
    assert afloat.hear(magnetic, 1.0)[0].split(",")[11] == "89.0"


@pytest.mark.parametrize(
    ("circle", "abeam", "rmb", "apb"),
    [
        (YesNo.YES, YesNo.NO, "A", "A,V"),
        (YesNo.NO, YesNo.YES, "A", "V,A"),
        (YesNo.NO, YesNo.NO, "V", "V,V"),
        (None, YesNo.YES, "A", ",A"),
        (None, None, "", ","),
        (2, None, "", ","),
    ],
)
def test_arrival_is_the_circle_or_the_perpendicular(circle, abeam, rmb, apb):
    afloat = Afloat("RMB", "APB")
    afloat.hear(cross_track(185.2))
    said = afloat.hear(leg(arrival_circle_entered=circle, perpendicular_crossed=abeam))
    assert said[0].split(",")[13] == rmb
    assert said[1].split(",")[6:8] == apb.split(",")


def test_waypoints_are_called_by_the_names_that_the_route_gave_them():
    afloat = Afloat("RMB", "APB")
    afloat.hear(route(n4="Cobh", n5="Kinsale", n6=None))
    afloat.hear(cross_track(185.2))
    rmb, apb = afloat.hear(leg())
    assert ",L,,Kinsale,5445" in rmb
    assert ",T,Kinsale,85.0" in apb
    assert ",L,Cobh,6,5445" in afloat.hear(leg(destination_waypoint_number=6), 1.0)[0]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("Baile Átha Cliath", "Baile "),
        ("Žiri", "?iri"),
        ("A*B,C", "A^2AB^2C"),
        ("A*B,CD", "A^2AB^2C"),
        ("Long Island Sound", "Long Isl"),
        ("two\nlines", "two?line"),
    ],
)
def test_a_name_that_does_not_fit_is_shortened(name, text):
    afloat = Afloat("APB")
    afloat.hear(route(n5=name))
    afloat.hear(cross_track(185.2))
    assert afloat.hear(leg())[0].split(",")[10] == text


def test_the_longest_leg_fits_into_a_sentence():
    afloat = Afloat("RMB")
    afloat.hear(route(n4="Aaaaaaaaa", n5="Bbbbbbbbb"))
    afloat.hear(cross_track(-1e6))
    said = afloat.hear(leg(waypoint_closing_velocity=-327.0, distance_to_waypoint=4e7, destination_longitude=-179.9))
    assert said == ["GPRMB,A,9.99,R,,Bbbbbbbb,5445.000000,N,17954.000000,W,999.9,85.0,-635.6,V,A"]
    assert len(said[0]) + 6 <= 82


def test_a_number_too_long_for_a_sentence_is_not_cut():
    afloat = Afloat("APB")
    afloat.hear(cross_track(185.2))
    assert afloat.hear(leg(destination_waypoint_number=123_456_789))[0].split(",")[10] == ""


# Dialect, ceilings and sources ------------------------------------------------------------------


def test_the_first_edition_of_the_protocol_has_three_sentences_of_its_own():
    afloat = Afloat("VHW", "DPT", "GLL", "HDT", dialect="ar-1.0")
    afloat.hear(clock(45296.25))
    assert afloat.hear(heading(100.0)) == ["IIHDT,100.0,T"]
    assert afloat.hear(speed(5 * KNOT)) == ["IIVHW,,,5.0,N,9.3,K"]
    assert afloat.hear(WaterDepth(None, 12.34, -1.4, 200)) == ["IIDPT,12.3,0.0"]
    assert afloat.hear(position()) == ["GPGLL,5430.000000,N,01015.000000,W,123456,A"]


def jitter(hertz, seconds, early=0.4):
    """Times of a source whose messages come up to `early` of an interval early or late."""
    offsets = (0.0, early, -early, early, 0.0, -early, early / 2)
    return [(index + offsets[index % len(offsets)] + 1) / hertz for index in range(hertz * seconds)]


def test_a_jittering_source_of_ten_hertz_comes_out_at_ten_hertz():
    afloat = Afloat("HDT", "ROT")
    times = jitter(10, 60)
    assert sum(len(afloat.hear(heading(100.0), now)) for now in times) == 600
    assert sum(len(afloat.hear(RateOfTurn(None, 0.1), now)) for now in times) == 600


@pytest.mark.parametrize("formatter", ["HDT", "ROT", "VHW", "DPT", "GLL", "RMC", "MTW", "MWV"])
def test_no_sentence_comes_more_often_than_the_specification_allows(formatter):
    ceilings = {"HDT": 10, "ROT": 10, "VHW": 1, "DPT": 1, "GLL": 1, "RMC": 1, "MTW": 0.5, "MWV": 1}
    messages = {
        "HDT": heading(100.0),
        "ROT": RateOfTurn(None, 0.1),
        "VHW": speed(5.0),
        "DPT": WaterDepth(None, 5.0, None, None),
        "GLL": position(),
        "RMC": course(),
        "MTW": OLDEST,
        "MWV": wind(WindReference.APPARENT),
    }
    afloat = Afloat(formatter, rate=RATES[formatter])
    said = sum(len(afloat.hear(messages[formatter], index / 50)) for index in range(50 * 60))
    assert 60 * ceilings[formatter] <= said <= 60 * ceilings[formatter] + 1


def test_a_sentence_with_a_rate_of_zero_is_never_said():
    assert Afloat().hear(heading(100.0)) == []


def test_every_sentence_has_a_message_that_is_heard():
    assert {message for conversion in CONVERSIONS for message in conversion.messages} <= HEAR.keys()
    assert len({conversion.key for conversion in CONVERSIONS}) == len(CONVERSIONS)


def test_a_second_source_of_the_same_thing_is_not_mixed_in():
    afloat = Afloat("DPT", "ROT", "MWV")
    for message, worse in (
        (WaterDepth(None, 5.0, None, None), WaterDepth(None, 50.0, None, None)),
        (RateOfTurn(None, 0.1), RateOfTurn(None, 0.2)),
        (wind(WindReference.APPARENT), wind(WindReference.APPARENT, 200.0)),
    ):
        assert len(afloat.hear(message, 0.0, source=1)) == 1
        assert afloat.hear(worse, 0.5, source=2) == []


def test_four_winds_with_different_references_are_four_things():
    afloat = Afloat("MWV", "MWD")
    said = [afloat.hear(wind(reference), source=reference) for reference in (2, 4, 0)]
    assert [line[0][:12] for line in said] == ["IIMWV,30.0,R", "IIMWV,30.0,T", "IIMWD,30.0,T"]
    assert afloat.hear(wind(WindReference.TRUE_NORTH, None, None), source=9) == []


def test_a_receiver_that_lost_its_fix_says_so_at_once():
    afloat = Afloat("GLL", "RMC")
    place = "5430.000000,N,01015.000000,W"
    afloat.hear(fix())
    assert afloat.hear(fix(GnssMethod.NONE), 0.1) == [f"GPGLL,{place},120000,V,N"]
    assert afloat.hear(fix(GnssMethod.NONE, None, None), 0.2) == []
    assert afloat.hear(course(), 0.3) == ["GPRMC,120000,V,,,,,10.0,90.0,110324,,,N"]


def test_when_one_receiver_loses_its_fix_the_other_is_listened_to_at_once():
    afloat = Afloat("GLL")
    afloat.hear(fix(), 0.0, source=1)
    assert afloat.hear(fix(latitude=55.0), 0.1, source=2) == []
    afloat.hear(fix(GnssMethod.NONE), 1.0, source=1)
    assert afloat.hear(fix(latitude=55.0), 1.1, source=2) == ["GPGLL,5500.000000,N,01015.000000,W,120000,A,A"]
    assert afloat.hear(position(54.5), 1.2, source=1) == []
