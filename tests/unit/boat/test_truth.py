"""Which of several sources is listened to, and for how long."""

from math import radians

import pytest

from timonel.nmea2000.lookups import GnssMethod, HeadingReference, TimeSource, WindReference
from timonel.nmea2000.messages.environment import WindData
from timonel.nmea2000.messages.navigation import (
    CogSogRapidUpdate,
    GnssPositionData,
    NavigationRouteWpInformation,
    PositionRapidUpdate,
    SystemTime,
    Waypoint,
)
from timonel.nmea2000.messages.steering import HeadingTrackControl, MagneticVariation, Rudder, VesselHeading
from timonel.vehicles.boat.truth import MOST_WAYPOINTS, Datum, Truth

TRUE, MAGNETIC = HeadingReference.TRUE, HeadingReference.MAGNETIC
DAY = 19793


@pytest.fixture
def truth():
    return Truth(3.0)


def heading(angle, reference=TRUE, deviation=None, variation=None):
    return VesselHeading(None, angle, deviation, variation, reference)


def variation(angle):
    return MagneticVariation(None, None, age_of_service=None, variation=angle)


def rudder(angle):
    return Rudder(None, None, angle_order=None, position=angle)


def fix(latitude=54.5, method=GnssMethod.GNSS_FIX, **values):
    return GnssPositionData(latitude=latitude, longitude=None if latitude is None else -10.0, method=method, **values)


# One value --------------------------------------------------------------------------------------


def test_a_datum_keeps_to_the_first_of_equal_sources():
    datum = Datum(hold=1.0)
    assert datum.offer("first", 0.0, source=1)
    assert not datum.offer("second", 0.5, source=2)
    assert datum.offer("first again", 0.9, source=1)
    assert datum.at(0.9, age=3.0) == "first again"


def test_another_source_is_heard_when_the_first_was_silent_for_the_hold_time():
    datum = Datum(hold=1.0)
    datum.offer("first", 0.0, source=1)
    assert not datum.offer("second", 0.999, source=2)
    assert datum.offer("second", 1.0, source=2)
    assert not datum.offer("first", 1.5, source=1)


def test_a_better_source_takes_over_at_once_and_a_worse_one_waits():
    datum = Datum(hold=1.0)
    datum.offer("worse", 0.0, source=1, rank=1)
    assert datum.offer("better", 0.1, source=2, rank=0)
    assert not datum.offer("worse", 0.2, source=1, rank=1)
    assert datum.offer("worse", 1.1, source=1, rank=1)


def test_one_device_has_a_rank_for_each_way_to_tell():
    datum = Datum(hold=1.0)
    datum.offer("rapid", 0.0, source=1, rank=0)
    assert not datum.offer("slow", 0.1, source=1, rank=1)
    assert datum.offer("slow", 1.0, source=1, rank=1)
    assert datum.offer("rapid", 1.1, source=1, rank=0)


def test_a_value_counts_until_its_age_is_reached():
    datum = Datum(hold=1.0)
    datum.offer("value", 10.0, source=1)
    assert datum.at(12.999, age=3.0) == "value"
    assert datum.at(13.0, age=3.0) is None


def test_only_who_told_a_value_can_take_it_back():
    datum = Datum(hold=1.0)
    datum.offer("value", 0.0, source=1)
    datum.withdraw(2)
    assert datum.at(0.1, age=3.0) == "value"
    datum.withdraw(1)
    assert datum.at(0.1, age=3.0) is None
    assert datum.offer("other", 0.1, source=2)


def test_what_was_never_told_is_not_known(truth):
    assert truth.true_heading(0.0) is None
    assert truth.magnetic_heading(0.0) is None
    assert truth.variation(0.0) is None
    assert truth.rudder_angle(0.0) is None
    assert truth.position_at(0.0) is None
    assert truth.method_at(0.0) is None
    assert truth.clock_at(0.0) is None
    assert truth.cross_track_at(0.0) is None


# Heading ----------------------------------------------------------------------------------------


def test_one_compass_gives_both_headings_where_variation_is_known(truth):
    truth.hear_heading(heading(1.0, MAGNETIC, 0.02, 0.1), 1, 0.0)
    assert truth.true_heading(0.0) == pytest.approx(1.12)
    assert truth.magnetic_heading(0.0) == pytest.approx(1.02)


def test_headings_stay_within_a_turn(truth):
    truth.hear_heading(heading(0.05, TRUE, variation=0.1), 1, 0.0)
    assert truth.magnetic_heading(0.0) == pytest.approx(radians(360) - 0.05)


def test_a_true_compass_does_not_speak_for_a_magnetic_one(truth):
    truth.hear_heading(heading(1.0, MAGNETIC), 1, 0.0)
    truth.hear_heading(heading(2.0, TRUE, variation=0.1), 2, 0.1)
    assert truth.magnetic_heading(0.1) == 1.0
    assert truth.true_heading(0.1) == 2.0


def test_a_compass_without_variation_does_not_keep_an_old_true_heading_alive(truth):
    truth.hear_heading(heading(2.0, TRUE), 2, 0.0)
    for tenth in range(30):
        truth.hear_heading(heading(1.0, MAGNETIC), 1, tenth / 10)
    assert truth.true_heading(2.9) == 2.0
    assert truth.true_heading(3.0) is None


@pytest.mark.parametrize("reference", [HeadingReference.ERROR, None])
def test_a_heading_of_no_reference_is_not_taken(truth, reference):
    assert not truth.hear_heading(heading(1.0, reference), 1, 0.0)
    assert truth.true_heading(0.0) is None


def test_variation_comes_from_127258_then_from_a_compass(truth):
    truth.hear_heading(heading(1.0, MAGNETIC, variation=0.1), 1, 0.0)
    assert truth.variation(0.0) == 0.1
    truth.hear_variation(variation(0.2), 2, 0.1)
    truth.hear_heading(heading(1.0, MAGNETIC, variation=0.1), 1, 0.2)
    assert truth.variation(0.2) == 0.2
    truth.hear_heading(heading(1.0, MAGNETIC, variation=0.1), 1, 2.1)
    assert truth.variation(2.1) == 0.1


def test_the_model_is_asked_anew_after_a_tenth_of_a_degree_or_a_day():
    asked = []

    def model(latitude, longitude, unix):
        asked.append((latitude, longitude, unix))
        return 0.05

    truth = Truth(3.0, model)

    def variation_at(latitude, day):
        truth.hear_position(PositionRapidUpdate(latitude, -10.0), 1, float(len(asked)))
        truth.hear_system_time(SystemTime(None, TimeSource.GPS, date=day, time=60.0), 1, float(len(asked)))
        return truth.variation(float(len(asked)))

    assert [variation_at(54.50, DAY), variation_at(54.51, DAY), variation_at(54.61, DAY)] == [0.05] * 3
    assert variation_at(54.61, DAY + 1) == 0.05
    assert asked == [
        (54.50, -10.0, DAY * 86400 + 60.0),
        (54.61, -10.0, DAY * 86400 + 60.0),
        (54.61, -10.0, (DAY + 1) * 86400 + 60.0),
    ]


def test_directions_are_converted_by_the_variation_east_positive(truth):
    truth.hear_variation(variation(0.1), 1, 0.0)
    assert truth.to_true(1.0, MAGNETIC, 0.0) == pytest.approx(1.1)
    assert truth.to_magnetic(1.0, TRUE, 0.0) == pytest.approx(0.9)
    assert truth.to_true(1.0, TRUE, 0.0) == truth.to_magnetic(1.0, MAGNETIC, 0.0) == 1.0


@pytest.mark.parametrize("reference", [HeadingReference.ERROR, None])
def test_directions_of_no_reference_are_not_converted(truth, reference):
    truth.hear_variation(variation(0.1), 1, 0.0)
    assert truth.to_true(1.0, reference, 0.0) is None
    assert truth.to_magnetic(1.0, reference, 0.0) is None


def test_no_direction_stays_none(truth):
    assert truth.to_true(None, TRUE, 0.0) is None
    assert truth.to_magnetic(None, TRUE, 0.0) is None


# Rudder -----------------------------------------------------------------------------------------


def test_a_rudder_order_stands_in_only_for_a_rudder_that_nobody_measures(truth):
    truth.hear_pilot(HeadingTrackControl(commanded_rudder_angle=0.2), 204, 0.0)
    assert truth.rudder_angle(0.0) == 0.2
    truth.hear_rudder(rudder(-0.1), 10, 0.1)
    truth.hear_pilot(HeadingTrackControl(commanded_rudder_angle=0.2), 204, 0.2)
    assert truth.rudder_angle(0.2) == -0.1
    truth.hear_pilot(HeadingTrackControl(commanded_rudder_angle=0.3), 204, 1.1)
    assert truth.rudder_angle(1.1) == 0.3


def test_an_order_in_a_message_of_its_own_does_not_take_the_angle_away(truth):
    truth.hear_rudder(rudder(-0.1), 10, 0.0)
    assert not truth.hear_rudder(rudder(None), 10, 0.1)
    assert truth.rudder_angle(0.1) == -0.1


# Position and time ------------------------------------------------------------------------------


def test_the_rapid_position_comes_before_that_of_129029(truth):
    truth.hear_fix(fix(54.0), 1, 0.0)
    assert truth.position_at(0.0) == (54.0, -10.0)
    truth.hear_position(PositionRapidUpdate(54.5, -10.0), 1, 0.1)
    truth.hear_fix(fix(54.0), 1, 0.2)
    assert truth.position_at(0.2) == (54.5, -10.0)


def test_a_source_whose_positions_are_empty_does_not_get_in_the_way(truth):
    assert not truth.hear_position(PositionRapidUpdate(None, None), 1, 0.0)
    assert truth.hear_position(PositionRapidUpdate(54.5, -10.0), 2, 0.1)
    assert not truth.hear_position(PositionRapidUpdate(None, None), 1, 0.2)
    assert truth.position_at(0.2) == (54.5, -10.0)


def test_a_receiver_that_loses_its_position_has_none_at_once(truth):
    truth.hear_position(PositionRapidUpdate(54.5, -10.0), 1, 0.0)
    truth.hear_position(PositionRapidUpdate(None, None), 1, 0.1)
    assert truth.position_at(0.1) is None


def test_a_fix_with_an_empty_position_does_not_replace_a_good_one(truth):
    assert truth.hear_fix(fix(), 1, 0.0)
    assert not truth.hear_fix(fix(None, None), 2, 0.5)
    assert truth.hear_fix(fix(), 1, 1.0)
    assert truth.method_at(1.0) is GnssMethod.GNSS_FIX


def test_positions_of_a_receiver_without_a_fix_are_the_last_resort(truth):
    truth.hear_fix(fix(53.0, GnssMethod.NONE), 1, 0.0)
    assert truth.position_at(0.0) == (53.0, -10.0)
    assert truth.method_at(0.0) is GnssMethod.NONE
    truth.hear_position(PositionRapidUpdate(53.1, -10.0), 1, 0.1)
    assert truth.position_at(0.1) == (53.1, -10.0)
    truth.hear_position(PositionRapidUpdate(54.5, -10.0), 2, 0.2)
    assert truth.position_at(0.2) == (54.5, -10.0)


def test_a_receiver_that_has_its_fix_again_is_trusted_again(truth):
    truth.hear_fix(fix(53.0, GnssMethod.NONE), 1, 0.0)
    truth.hear_fix(fix(53.0), 1, 0.1)
    truth.hear_position(PositionRapidUpdate(53.1, -10.0), 1, 0.2)
    assert not truth.hear_position(PositionRapidUpdate(54.5, -10.0), 2, 0.3)


def test_a_clock_reading_goes_with_positions_for_two_seconds(truth):
    truth.hear_system_time(SystemTime(None, TimeSource.GPS, date=DAY, time=60.0), 1, 0.0)
    clock = truth.clock_at(1.9)
    assert (clock.day, clock.second, clock.unix) == (DAY, 60.0, DAY * 86400 + 60.0)
    assert truth.clock_at(2.0) is None


def test_the_oldest_date_that_is_believed_is_that_of_the_first_devices(truth):
    assert not truth.hear_system_time(SystemTime(None, None, date=10956, time=0.0), 1, 0.0)
    assert truth.hear_system_time(SystemTime(None, None, date=10957, time=0.0), 1, 0.0)


def test_a_course_is_taken_with_a_direction_or_a_speed(truth):
    assert not truth.hear_course(CogSogRapidUpdate(None, TRUE, cog=None, sog=None), 1, 0.0)
    assert truth.hear_course(CogSogRapidUpdate(None, TRUE, cog=None, sog=0.0), 1, 0.0)
    assert truth.hear_course(CogSogRapidUpdate(None, TRUE, cog=1.0, sog=None), 1, 0.1)


# Wind and waypoints -----------------------------------------------------------------------------


def test_a_wind_with_speed_and_angle_comes_before_half_a_wind(truth):
    assert truth.hear_wind(WindData(None, 5.0, None, WindReference.APPARENT), 1, 0.0)
    assert truth.hear_wind(WindData(None, 5.0, 1.0, WindReference.APPARENT), 2, 0.1)
    assert not truth.hear_wind(WindData(None, 5.0, None, WindReference.APPARENT), 1, 0.2)


@pytest.mark.parametrize("reference", [5, 6, None])
def test_a_wind_of_unknown_reference_is_not_taken(truth, reference):
    assert not truth.hear_wind(WindData(None, 5.0, 1.0, reference), 1, 0.0)


def test_names_of_waypoints_do_not_grow_without_end(truth):
    def route(number):
        points = (Waypoint(number, f"W{number}", None, None), Waypoint(None, "nowhere", None, None))
        return NavigationRouteWpInformation(None, 2, None, None, None, None, route_name=None, waypoints=points)

    for number in range(3 * MOST_WAYPOINTS):
        assert truth.hear_route(route(number), 1, 0.0)
        assert truth.waypoint_names[number] == f"W{number}"
    assert len(truth.waypoint_names) <= MOST_WAYPOINTS + 1
