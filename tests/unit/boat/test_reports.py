"""What pilots say of themselves, maker by maker; bytes of real pilots where there are any."""

from itertools import groupby
from math import degrees

import pytest

from tests.conformance.recorded import messages
from tests.recordings import recording
from timonel.nmea2000.identifier import split
from timonel.nmea2000.lookups import (
    DeviceClass,
    GarminPilotMode,
    HeadingReference,
    ManufacturerCode,
    SeatalkMode,
    SimnetApMode,
    SimnetApModeFlags,
    SimnetAutopilotMode,
    SteeringMode,
)
from timonel.nmea2000.messages.garmin import (
    GarminAutopilotHeadingToSteer,
    GarminAutopilotModeState,
    GarminAutopilotRateOfTurn,
)
from timonel.nmea2000.messages.navico import SimnetAutopilotAngle, SimnetAutopilotModeState, SimnetPilotMode
from timonel.nmea2000.messages.network import IsoAddressClaim
from timonel.nmea2000.messages.raymarine import SeatalkPilotLockedHeading, SeatalkPilotMode
from timonel.nmea2000.messages.steering import HeadingTrackControl
from timonel.nmea2000.registry import decode
from timonel.vehicles.boat.pilot import Mode
from timonel.vehicles.boat.reports import PilotReports, Reading
from timonel.vehicles.boat.vehicle import PILOT_MESSAGES

TRUE, MAGNETIC = HeadingReference.TRUE, HeadingReference.MAGNETIC
FURUNO, RAYMARINE = ManufacturerCode.FURUNO, ManufacturerCode.RAYMARINE
PILOT, HEAD = 150, 140  # device functions
SAMPLES = "canboat_canboat/samples/"


def name(maker, function=PILOT):
    return IsoAddressClaim(
        unique_number=1,
        manufacturer_code=maker,
        device_instance_lower=0,
        device_instance_upper=0,
        device_function=function,
        device_class=DeviceClass.STEERING_AND_CONTROL,
        system_instance=0,
        industry_group=None,
        arbitrary_address_capable=None,
    )


def standard(mode=None, course=None, reference=None):
    return HeadingTrackControl(steering_mode=mode, heading_to_steer_course=course, heading_reference=reference)


def seatalk(mode):
    return SeatalkPilotMode(pilot_mode=mode, sub_mode=0, pilot_mode_data=0)


def locked(true=None, magnetic=None):
    return SeatalkPilotLockedHeading(sid=None, target_heading_true=true, target_heading_magnetic=magnetic)


def flags(mode):
    return SimnetPilotMode(model=None, mode=mode)


def state(mode):
    return SimnetAutopilotModeState(mode_class=None, mode=mode, c=None, d=None, flags=None)


def introduced(maker, source=204):
    reports = PilotReports()
    reports.introduce(name(maker), source)
    return reports


def read(message, maker=None, source=204):
    reports = PilotReports() if maker is None else introduced(maker, source)
    return reports.receive(message, source, 0.0)


def modes(recorded):
    """The modes that the pilot of a recording reports, each once until it changes."""
    reports, told = PilotReports(), []
    for message in messages(recording(SAMPLES + recorded)):
        target = split(message.identifier)
        decoded = decode(target.pgn, message.payload)
        if isinstance(decoded, IsoAddressClaim):
            reports.introduce(decoded, target.source)
        elif isinstance(decoded, PILOT_MESSAGES):
            reading = reports.receive(decoded, target.source, message.now)
            told += [] if reading is None else [reading.mode]
    return [mode for mode, _ in groupby(told)]


# 127237 by the standard -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("told", "mode"),
    [
        (SteeringMode.MAIN_STEERING, Mode.STANDBY),
        (SteeringMode.NON_FOLLOW_UP, Mode.UNKNOWN),
        (SteeringMode.FOLLOW_UP, Mode.UNKNOWN),
        (SteeringMode.HEADING_CONTROL_STANDALONE, Mode.HEADING_HOLD),
        (SteeringMode.HEADING_CONTROL, Mode.HEADING_HOLD),
        (SteeringMode.TRACK_CONTROL, Mode.TRACK),
        (6, Mode.UNKNOWN),
        (None, None),
    ],
)
@pytest.mark.parametrize("maker", [None, ManufacturerCode.COMNAV])
def test_a_pilot_of_no_known_maker_is_read_by_the_standard(told, mode, maker):
    assert read(standard(told), maker) == Reading(mode)


def test_the_course_comes_in_the_reference_that_it_was_told_in():
    told = standard(SteeringMode.HEADING_CONTROL, 1.5, MAGNETIC)
    assert read(told) == Reading(Mode.HEADING_HOLD, 1.5, MAGNETIC)


# Furuno -----------------------------------------------------------------------------------------


def test_a_furuno_pilot_whose_helm_is_jogged_stands_by():
    assert read(standard(SteeringMode.NON_FOLLOW_UP), FURUNO) == Reading(Mode.STANDBY)
    assert read(standard(SteeringMode.HEADING_CONTROL_STANDALONE), FURUNO) == Reading(Mode.HEADING_HOLD)


def test_a_recorded_furuno_pilot_goes_from_standby_to_track():
    assert modes("furuno-fap7011c-autopilot-off-then-on.raw") == [Mode.STANDBY, Mode.TRACK]


# Raymarine --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("told", "mode"),
    [
        (SeatalkMode.STANDBY, Mode.STANDBY),
        (SeatalkMode.AUTO, Mode.HEADING_HOLD),
        (SeatalkMode.TRACK, Mode.TRACK),
        (SeatalkMode.WIND, Mode.UNKNOWN),
        (SeatalkMode.NO_DRIFT, Mode.UNKNOWN),
        (999, Mode.UNKNOWN),
    ],
)
def test_a_raymarine_pilot_tells_its_mode_in_65379(told, mode):
    assert read(SeatalkPilotMode.decode(seatalk(told).encode()), RAYMARINE) == Reading(mode)


def test_a_raymarine_pilot_that_tells_no_mode_tells_nothing():
    assert read(seatalk(None), RAYMARINE) is None


@pytest.mark.parametrize(
    ("heading", "course", "reference"),
    [(locked(None, 1.5), 1.5, MAGNETIC), (locked(1.6, 1.5), 1.6, TRUE), (locked(1.6), 1.6, TRUE)],
)
def test_a_raymarine_pilot_tells_its_locked_heading_in_65360(heading, course, reference):
    reports = introduced(RAYMARINE)
    assert reports.receive(heading, 204, 0.0) is None
    assert reports.receive(seatalk(SeatalkMode.AUTO), 204, 0.1) == Reading(Mode.HEADING_HOLD, course, reference)
    assert reports.receive(seatalk(SeatalkMode.AUTO), 204, 5.0) == Reading(Mode.HEADING_HOLD)


@pytest.mark.parametrize(
    ("told", "mode"),
    [(SteeringMode.MAIN_STEERING, Mode.STANDBY), (SteeringMode.FOLLOW_UP, Mode.UNKNOWN), (None, None)],
)
def test_of_a_raymarine_pilot_127237_tells_only_that_it_stands_by(told, mode):
    assert read(standard(told), RAYMARINE) == Reading(mode)


def test_a_mode_in_its_makers_words_counts_for_five_seconds_against_127237():
    reports = introduced(RAYMARINE)
    reports.receive(seatalk(SeatalkMode.AUTO), 204, 0.0)
    assert reports.receive(standard(SteeringMode.FOLLOW_UP), 204, 4.9) == Reading(Mode.HEADING_HOLD)
    assert reports.receive(standard(SteeringMode.FOLLOW_UP), 204, 5.0) == Reading(Mode.UNKNOWN)


def test_a_recorded_raymarine_pilot_is_read_from_its_own_words_though_a_head_sends_127237():
    hold, standby = Mode.HEADING_HOLD, Mode.STANDBY
    told = modes("raymarine-ev1.raw")
    assert told[0] is Mode.UNKNOWN  # the head speaks first
    assert told[1:] == [hold, standby] * 4


def test_a_pilot_with_its_makers_words_takes_the_place_of_a_head_at_once():
    reports = PilotReports()
    assert reports.receive(standard(SteeringMode.FOLLOW_UP), 172, 0.0) == Reading(Mode.UNKNOWN)
    assert reports.receive(seatalk(SeatalkMode.AUTO), 204, 0.1) == Reading(Mode.HEADING_HOLD)
    assert reports.receive(standard(SteeringMode.MAIN_STEERING), 172, 0.2) is None


# Navico -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("maker", [ManufacturerCode.NAVICO, ManufacturerCode.SIMRAD, ManufacturerCode.B_AND_G])
def test_a_navico_pilot_that_tells_no_mode_in_127237_is_not_understood(maker):
    assert read(standard(None, 0.8552, MAGNETIC), maker) == Reading(Mode.UNKNOWN, 0.8552, MAGNETIC)
    assert read(standard(SteeringMode.HEADING_CONTROL), maker) == Reading(Mode.HEADING_HOLD)


@pytest.mark.parametrize(
    ("told", "mode"),
    [
        (SimnetApModeFlags.STANDBY, Mode.STANDBY),
        (SimnetApModeFlags.HEADING, Mode.HEADING_HOLD),
        (SimnetApModeFlags.NAV, Mode.TRACK),
        (SimnetApModeFlags.WIND, Mode.UNKNOWN),
        (SimnetApModeFlags.NO_DRIFT, Mode.UNKNOWN),
        (SimnetApModeFlags.STANDBY | SimnetApModeFlags.HEADING, Mode.UNKNOWN),
        (SimnetApModeFlags(0), Mode.UNKNOWN),
    ],
)
def test_a_navico_pilot_tells_its_mode_in_65305(told, mode):
    assert read(flags(told)) == Reading(mode)


@pytest.mark.parametrize(
    ("told", "mode"),
    [
        (SimnetAutopilotMode.STANDBY, Mode.STANDBY),
        (SimnetAutopilotMode.HEADING, Mode.HEADING_HOLD),
        (SimnetAutopilotMode.NON_FOLLOW_UP, Mode.STANDBY),
        (SimnetAutopilotMode.NAVIGATION, Mode.TRACK),
        (SimnetAutopilotMode.WIND, Mode.UNKNOWN),
        (77, Mode.UNKNOWN),
    ],
)
def test_an_ac42_tells_its_mode_in_65340(told, mode):
    assert read(SimnetAutopilotModeState.decode(state(told).encode())) == Reading(mode)


def test_recorded_navico_pilots_stand_by_or_are_in_a_mode_that_has_no_word_here():
    assert modes("can0-2.pcap") == [Mode.STANDBY]
    assert modes("susteranna2020.raw") == [Mode.STANDBY]
    assert modes("simrad_event_timer_start.raw")[-1] is Mode.UNKNOWN  # wind mode


@pytest.mark.parametrize("reference", [TRUE, MAGNETIC])
def test_a_navico_pilots_65341_is_counted_as_its_127237_counts(reference):
    reports = introduced(ManufacturerCode.NAVICO)
    angle = SimnetAutopilotAngle(mode=SimnetApMode.HEADING, angle=1.5)
    assert reports.receive(angle, 204, 0.0) is None  # no mode told yet
    reports.receive(flags(SimnetApModeFlags.HEADING), 204, 0.1)
    assert reports.receive(angle, 204, 0.2) is None  # nobody knows from where it is counted
    reports.receive(standard(None, 1.4, reference), 204, 0.3)
    assert reports.receive(angle, 204, 0.4) == Reading(Mode.HEADING_HOLD, 1.5, reference)


@pytest.mark.parametrize("mode", [SimnetApMode.WIND, SimnetApMode.NAV, None])
def test_an_angle_of_another_mode_is_no_course(mode):
    reports = introduced(ManufacturerCode.NAVICO)
    reports.receive(flags(SimnetApModeFlags.HEADING), 204, 0.1)
    reports.receive(standard(None, 1.4, TRUE), 204, 0.3)
    assert reports.receive(SimnetAutopilotAngle(mode=mode, angle=1.5), 204, 0.4) is None


def test_recorded_navico_pilots_tell_no_angle_while_they_stand_by():
    for name in ("can0-2.pcap", "susteranna2020.raw"):
        angles = [
            decode(65341, message.payload)
            for message in messages(recording(SAMPLES + name))
            if split(message.identifier).pgn == 65341
        ]
        assert angles
        assert all(isinstance(one, SimnetAutopilotAngle) and one.angle is None for one in angles)


# Garmin -----------------------------------------------------------------------------------------


def garmin(mode):
    return GarminAutopilotModeState(mode_state=mode)


def course(angle):
    return GarminAutopilotHeadingToSteer(heading_to_steer=angle)


@pytest.mark.parametrize(
    ("told", "mode"),
    [
        (GarminPilotMode.STANDBY, Mode.STANDBY),
        (GarminPilotMode.ENGAGED, Mode.HEADING_HOLD),
        (GarminPilotMode.SHADOW_DRIVE, Mode.UNKNOWN),
        (99, Mode.UNKNOWN),
    ],
)
def test_a_garmin_pilot_tells_its_mode_when_it_changes_and_it_holds_until_the_next(told, mode):
    reports = introduced(ManufacturerCode.GARMIN)
    assert reports.receive(GarminAutopilotModeState.decode(garmin(told).encode()), 204, 0.0) == Reading(mode)
    assert reports.receive(course(2.5), 204, 3000.0) == Reading(mode, 2.5)
    assert reports.receive(GarminAutopilotRateOfTurn(rate_of_turn=0.0), 204, 3001.0) == Reading(mode)


def test_a_garmin_pilot_whose_mode_was_not_heard_yet_is_in_none_that_is_known():
    assert introduced(ManufacturerCode.GARMIN).receive(course(2.5), 204, 0.0) == Reading(Mode.UNKNOWN, 2.5)


def test_a_mode_without_a_name_or_a_course_without_a_number_says_nothing_new():
    reports = introduced(ManufacturerCode.GARMIN)
    assert reports.receive(garmin(None), 204, 0.0) is None
    assert reports.receive(course(None), 204, 0.0) == Reading(Mode.UNKNOWN)


def test_what_a_garmin_control_head_commands_is_not_what_the_pilot_reports():
    reports = introduced(ManufacturerCode.GARMIN)
    reports.introduce(name(ManufacturerCode.GARMIN, HEAD), 1)
    reports.receive(garmin(GarminPilotMode.STANDBY), 204, 0.0)
    assert reports.receive(garmin(GarminPilotMode.ENGAGED), 1, 0.1) is None
    assert reports.receive(garmin(GarminPilotMode.ENGAGED), 9, 0.1) is None  # who has not introduced itself
    assert reports.receive(course(2.5), 204, 0.2) == Reading(Mode.STANDBY, 2.5)


def test_the_recorded_session_of_a_reactor_is_read_as_it_went():
    """Engaged, turned by one and by ten degrees, shadow drive, standby: the session has no address claims."""
    reports, told = introduced(ManufacturerCode.GARMIN, source=0), []
    for message in messages(recording(SAMPLES + "garmin-ap-reactor-126720.raw")):
        target = split(message.identifier)
        decoded = decode(target.pgn, message.payload)
        if isinstance(decoded, PILOT_MESSAGES) and target.destination == 255:
            reading = reports.receive(decoded, target.source, message.now)
            told += [] if reading is None else [reading]
    assert [mode for mode, _ in groupby(reading.mode for reading in told)] == [
        Mode.UNKNOWN,
        Mode.HEADING_HOLD,
        Mode.UNKNOWN,
        Mode.STANDBY,
    ]
    held = [r.course for r in told if r.mode is Mode.HEADING_HOLD and r.course is not None]
    assert [round(degrees(angle), 1) for angle in held] == [157.5, 167.5]


# Who the pilot is -------------------------------------------------------------------------------


def test_the_first_to_speak_like_a_pilot_is_it_until_it_is_silent_for_two_seconds():
    reports = PilotReports()
    assert reports.receive(standard(SteeringMode.HEADING_CONTROL), 10, 0.0) is not None
    assert reports.receive(standard(SteeringMode.MAIN_STEERING), 11, 1.9) is None
    assert reports.receive(standard(SteeringMode.MAIN_STEERING), 11, 2.0) == Reading(Mode.STANDBY)
    assert reports.receive(standard(SteeringMode.HEADING_CONTROL), 10, 2.1) is None


def test_a_device_that_says_to_be_an_autopilot_is_the_pilot_at_once():
    reports = PilotReports()
    reports.introduce(name(FURUNO), 11)
    reports.receive(standard(SteeringMode.MAIN_STEERING), 10, 0.0)
    assert reports.receive(standard(SteeringMode.TRACK_CONTROL), 11, 0.1) == Reading(Mode.TRACK)
    assert reports.receive(standard(SteeringMode.MAIN_STEERING), 10, 0.2) is None


def test_a_pilot_that_its_owner_chose_is_the_only_one_as_soon_as_it_is_there():
    there = []
    reports = PilotReports(lambda: there[0] if there else None)
    assert reports.receive(standard(SteeringMode.HEADING_CONTROL), 10, 0.0) == Reading(Mode.HEADING_HOLD)
    there.append(11)
    assert reports.receive(standard(SteeringMode.HEADING_CONTROL), 10, 0.1) is None
    assert reports.receive(seatalk(SeatalkMode.AUTO), 10, 0.1) is None
    reports.introduce(name(FURUNO), 11)
    assert reports.receive(standard(SteeringMode.MAIN_STEERING), 11, 0.2) == Reading(Mode.STANDBY)


def test_a_raymarine_pilots_course_is_told_as_soon_as_it_changes_once_its_mode_is_known():
    reports = introduced(RAYMARINE)
    reports.receive(seatalk(SeatalkMode.AUTO), 204, 0.0)
    assert reports.receive(locked(None, 1.5), 204, 0.1) == Reading(Mode.HEADING_HOLD, 1.5, MAGNETIC)
    assert reports.receive(locked(None, None), 204, 0.2) == Reading(Mode.HEADING_HOLD, 1.5, MAGNETIC)


def test_the_course_of_the_last_time_is_not_the_course_of_a_pilot_engaged_anew():
    reports = introduced(RAYMARINE)
    reports.receive(seatalk(SeatalkMode.AUTO), 204, 0.0)
    reports.receive(locked(None, 1.5), 204, 0.1)
    reports.receive(seatalk(SeatalkMode.STANDBY), 204, 0.2)
    assert reports.receive(seatalk(SeatalkMode.AUTO), 204, 0.3) == Reading(Mode.HEADING_HOLD)
    assert reports.receive(locked(None, 1.6), 204, 0.4) == Reading(Mode.HEADING_HOLD, 1.6, MAGNETIC)


def test_a_device_that_says_to_be_something_else_is_the_pilot_of_last_resort():
    reports = PilotReports()
    reports.introduce(name(RAYMARINE, HEAD), 10)
    assert reports.receive(standard(SteeringMode.MAIN_STEERING), 10, 0.0) == Reading(Mode.STANDBY)
    assert reports.receive(standard(SteeringMode.TRACK_CONTROL), 11, 0.1) == Reading(Mode.TRACK)
    assert reports.receive(standard(SteeringMode.MAIN_STEERING), 10, 0.2) is None
