"""The simulated boat: it steers like a boat, and what its devices say agrees with what it does."""

from math import atan2, cos, degrees, hypot, pi, radians, sin, tau

import pytest

from timonel.core.frame import Frame
from timonel.nmea2000 import registry
from timonel.nmea2000.fastpacket import Reassembler, fragment
from timonel.nmea2000.identifier import join, split
from timonel.nmea2000.lookups import HeadingReference, SteeringMode, WindReference
from timonel.nmea2000.messages.environment import (
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
    PositionRapidUpdate,
    Speed,
    SystemTime,
    WaterDepth,
)
from timonel.nmea2000.messages.network import IsoAddressClaim, IsoRequest
from timonel.nmea2000.messages.steering import (
    Attitude,
    HeadingTrackControl,
    MagneticVariation,
    RateOfTurn,
    Rudder,
    VesselHeading,
)
from timonel.vehicles.boat.simulator import (
    COMPASS,
    EARTH,
    FUNCTIONS,
    GNSS,
    PILOT,
    RUDDER_LIMIT,
    RUDDER_RATE,
    VARIATION,
    Fault,
    SimulatedBoat,
)

STATION = 35  # somebody else's address


def command(boat, source=STATION, **fields):
    """Send a 127237 to the pilot."""
    for data in fragment(HeadingTrackControl(**fields).encode(), 0):
        boat.receive(Frame(join(2, 127237, source), data))


def engage(boat, heading, reference=HeadingReference.TRUE):
    command(
        boat,
        steering_mode=SteeringMode.HEADING_CONTROL,
        heading_reference=reference,
        heading_to_steer_course=heading % tau,
    )


def messages(frames):
    """(source, message) of everything that was sent."""
    reassembler = Reassembler()
    for frame in frames:
        identifier = split(frame.identifier)
        payload = frame.data
        if registry.is_fast(identifier.pgn):
            payload = reassembler.receive(frame.identifier, frame.data, 0.0)
        if payload is not None:
            yield identifier.source, registry.decode(identifier.pgn, payload)


def of(kind, frames):
    return [message for _, message in messages(frames) if isinstance(message, kind)]


def apart(a, b):
    """The difference of two angles, in degrees."""
    return degrees((a - b + pi) % tau - pi)


# --- the bus
# -------------------------------------------------------------------------------------------------


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others():
    assert SimulatedBoat(seed=7).step(30) == SimulatedBoat(seed=7).step(30)
    assert SimulatedBoat(seed=7).step(30) != SimulatedBoat(seed=8).step(30)


def test_the_bytes_do_not_depend_on_how_time_is_cut():
    fine, coarse = SimulatedBoat(), SimulatedBoat()
    assert [frame for _ in range(700) for frame in fine.step(0.01)] == coarse.step(7.0)


@pytest.mark.parametrize(
    ("kind", "rate"),
    [
        (VesselHeading, 10),
        (RateOfTurn, 10),
        (Rudder, 10),
        (PositionRapidUpdate, 10),
        (HeadingTrackControl, 4),
        (CogSogRapidUpdate, 4),
        (WindData, 4),
        (EnvironmentalParametersObsolete, 2),
        (Attitude, 1),
        (SystemTime, 1),
        (GnssPositionData, 1),
        (MagneticVariation, 1),
        (Speed, 1),
        (DistanceLog, 1),
        (WaterDepth, 1),
        (Temperature, 0.5),
        (TemperatureExtendedRange, 0.5),
    ],
)
def test_every_message_comes_at_its_rate(kind, rate):
    assert len(of(kind, SimulatedBoat().step(20))) == 20 * rate


def test_every_device_claims_its_address_first_and_when_asked():
    boat = SimulatedBoat()
    claims = [source for source, message in messages(boat.step(5)) if isinstance(message, IsoAddressClaim)]
    assert sorted(claims) == sorted(FUNCTIONS)
    request = IsoRequest(pgn=60928).encode()
    boat.receive(Frame(join(6, 59904, STATION, PILOT), request))
    assert [source for source, m in messages(boat.step(1)) if isinstance(m, IsoAddressClaim)] == [PILOT]
    boat.receive(Frame(join(6, 59904, STATION), request))
    assert len(of(IsoAddressClaim, boat.step(1))) == len(FUNCTIONS)


def test_time_starts_where_it_was_told_and_comes_from_the_gnss():
    boat = SimulatedBoat(start=86400.0 * 20000 + 3600)
    first = of(SystemTime, boat.step(10))
    assert {time.date for time in first} == {20000}
    assert first[0].time == pytest.approx(3600.25)
    assert first[-1].time - first[0].time == pytest.approx(9)
    assert of(GnssPositionData, boat.step(1))[0].date == 20000


# --- steering
# ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("turn", [10, -10, 90, -90])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_turn_settles_within_a_degree_in_a_minute_without_much_overshoot(turn, seed):
    boat = SimulatedBoat(seed=seed)
    boat.step(5)
    start = boat.hull.heading
    engage(boat, start)
    boat.step(60)
    assert abs(apart(boat.hull.heading, start)) < 1
    engage(boat, start + radians(turn))
    error = []
    for _ in range(1200):
        boat.step(0.1)
        error.append(apart(boat.hull.heading, start + radians(turn)))
    assert max(e if turn > 0 else -e for e in error) < 10
    assert max(abs(e) for e in error[600:]) < 1


def test_the_short_way_is_taken_across_north():
    boat = SimulatedBoat(heading=radians(5))
    engage(boat, radians(355))
    boat.step(2)
    assert boat.hull.rate < 0


def test_the_rudder_never_passes_its_limit_or_its_rate():
    boat = SimulatedBoat()
    before = boat.hull.rudder
    for course in (90, 270, 90, 10, 200):
        engage(boat, radians(course))
        for _ in range(100):
            boat.step(0.05)
            assert abs(boat.hull.rudder) <= RUDDER_LIMIT + 1e-9
            assert abs(boat.hull.rudder - before) <= RUDDER_RATE * 0.05 + 1e-9
            before = boat.hull.rudder
    command(boat, steering_mode=SteeringMode.MAIN_STEERING)
    boat.helm = radians(60)
    boat.step(20)
    assert boat.hull.rudder == pytest.approx(RUDDER_LIMIT)


def test_starboard_rudder_turns_clockwise():
    boat = SimulatedBoat()
    boat.helm = radians(10)
    frames = boat.step(10)
    assert of(Rudder, frames)[-1].position == pytest.approx(radians(10), abs=1e-4)
    assert of(RateOfTurn, frames)[-1].rate > radians(1)


def test_a_magnetic_course_is_steered_by_magnetic_heading():
    boat = SimulatedBoat()
    engage(boat, radians(60), HeadingReference.MAGNETIC)
    boat.step(60)
    assert abs(apart(boat.hull.heading, radians(60) + VARIATION)) < 1
    status = of(HeadingTrackControl, boat.step(1))[-1]
    assert status.heading_reference is HeadingReference.MAGNETIC
    assert abs(apart(status.vessel_heading, radians(60))) < 1


def test_the_pilot_says_what_it_does():
    boat = SimulatedBoat()
    standby = of(HeadingTrackControl, boat.step(1))[-1]
    assert standby.steering_mode is SteeringMode.MAIN_STEERING
    assert standby.heading_to_steer_course is None
    assert standby.vessel_heading == pytest.approx(boat.hull.heading, abs=0.01)
    engage(boat, radians(80))
    engaged = of(HeadingTrackControl, boat.step(1))[-1]
    assert engaged.steering_mode is SteeringMode.HEADING_CONTROL
    assert engaged.heading_to_steer_course == pytest.approx(radians(80), abs=1e-4)
    assert engaged.off_heading_limit_exceeded == 1
    assert engaged.commanded_rudder_angle > 0


def test_main_steering_lets_go_and_the_rudder_goes_to_the_helm():
    boat = SimulatedBoat()
    engage(boat, boat.hull.heading + 1)
    boat.step(3)
    assert boat.hull.rudder > 0.1
    command(boat, steering_mode=SteeringMode.MAIN_STEERING)
    assert of(HeadingTrackControl, boat.step(10))[-1].steering_mode is SteeringMode.MAIN_STEERING
    assert boat.hull.rudder == 0


@pytest.mark.parametrize(
    "fields",
    [
        {"steering_mode": SteeringMode.HEADING_CONTROL, "heading_to_steer_course": 1.0},
        {"steering_mode": SteeringMode.HEADING_CONTROL, "heading_reference": HeadingReference.TRUE},
        {"heading_reference": HeadingReference.TRUE, "heading_to_steer_course": 1.0},
        {
            "steering_mode": SteeringMode.HEADING_CONTROL,
            "heading_reference": HeadingReference.ERROR,
            "heading_to_steer_course": 1.0,
        },
    ],
)
def test_a_command_that_lacks_something_engages_nothing(fields):
    boat = SimulatedBoat()
    command(boat, **fields)
    assert not boat.pilot.engaged


def test_the_pilot_does_not_obey_its_own_status():
    boat = SimulatedBoat()
    command(
        boat,
        source=PILOT,
        steering_mode=SteeringMode.HEADING_CONTROL,
        heading_reference=HeadingReference.TRUE,
        heading_to_steer_course=1.0,
    )
    assert not boat.pilot.engaged


# --- what does not work
# --------------------------------------------------------------------------------------


def test_a_deaf_pilot_does_not_move_and_hears_again_when_restored():
    boat = SimulatedBoat()
    boat.silence(Fault.PILOT_DEAF)
    engage(boat, boat.hull.heading + 1)
    assert of(HeadingTrackControl, boat.step(5))[-1].steering_mode is SteeringMode.MAIN_STEERING
    assert boat.hull.rudder == 0
    boat.restore(Fault.PILOT_DEAF)
    engage(boat, boat.hull.heading + 1)
    boat.step(5)
    assert boat.hull.rudder > 0


def test_a_silent_backbone_passes_nothing_while_the_pilot_goes_on():
    boat = SimulatedBoat()
    engage(boat, boat.hull.heading)
    boat.step(1)
    boat.silence(Fault.BACKBONE)
    command(boat, steering_mode=SteeringMode.MAIN_STEERING)
    assert boat.step(5) == []
    boat.restore(Fault.BACKBONE)
    assert of(HeadingTrackControl, boat.step(1))[-1].steering_mode is SteeringMode.HEADING_CONTROL


@pytest.mark.parametrize(("fault", "source"), [(Fault.HEADING, COMPASS), (Fault.GNSS, GNSS)])
def test_a_lost_sensor_is_silent_and_the_others_are_not(fault, source):
    boat = SimulatedBoat()
    boat.step(1)
    boat.silence(fault)
    heard = {sender for sender, _ in messages(boat.step(2))}
    assert heard == set(FUNCTIONS) - {source, 46}


def test_without_a_compass_the_pilot_lets_go():
    boat = SimulatedBoat()
    engage(boat, boat.hull.heading)
    boat.silence(Fault.HEADING)
    status = of(HeadingTrackControl, boat.step(1))[-1]
    assert status.steering_mode is SteeringMode.MAIN_STEERING
    assert status.vessel_heading is None


# --- what the sensors say agrees
# -----------------------------------------------------------------------------


def test_the_track_is_the_speed_over_ground_added_up():
    boat = SimulatedBoat()
    boat.step(1)
    engage(boat, boat.hull.heading + radians(120))
    frames = boat.step(300)
    steps = of(CogSogRapidUpdate, frames)
    north, east = (sum(0.25 * s.sog * f(s.cog) for s in steps) for f in (cos, sin))
    places = of(PositionRapidUpdate, frames)
    moved_north = radians(places[-1].latitude - places[0].latitude) * EARTH
    moved_east = radians(places[-1].longitude - places[0].longitude) * EARTH * cos(radians(39.5))
    assert hypot(moved_north - north, moved_east - east) < 0.01 * hypot(north, east) + 3


def test_the_rapid_position_and_the_full_one_agree():
    frames = SimulatedBoat().step(0.3)  # the full one comes last, a twentieth of a second after the other
    full, rapid = of(GnssPositionData, frames)[-1], of(PositionRapidUpdate, frames)[-1]
    assert full.latitude == pytest.approx(rapid.latitude, abs=2e-6)
    assert full.longitude == pytest.approx(rapid.longitude, abs=2e-6)


def test_heading_is_what_the_rate_of_turn_adds_up_to():
    boat = SimulatedBoat()
    boat.helm = radians(5)
    frames = boat.step(20)
    headings = of(VesselHeading, frames)
    turned = sum(0.1 * turn.rate for turn in of(RateOfTurn, frames))
    assert abs(apart(headings[-1].heading, headings[0].heading + turned)) < 1


def test_a_true_compass_says_true_and_leaves_variation_to_127258():
    frames = SimulatedBoat().step(2)
    heading = of(VesselHeading, frames)[-1]
    assert (heading.reference, heading.deviation, heading.variation) == (HeadingReference.TRUE, None, None)
    assert of(MagneticVariation, frames)[-1].variation == pytest.approx(VARIATION, abs=1e-4)


def test_a_magnetic_compass_with_its_deviation_and_variation_gives_the_true_heading():
    boat = SimulatedBoat(heading=radians(90), magnetic=True)
    heading = of(VesselHeading, boat.step(0.1))[-1]
    assert heading.reference is HeadingReference.MAGNETIC
    assert heading.deviation > 0.03
    true = heading.heading + heading.deviation + VARIATION
    assert abs(apart(true, boat.hull.heading)) < 0.2


def test_the_apparent_wind_is_the_true_wind_and_the_way_through_the_water():
    boat = SimulatedBoat()
    frames = boat.step(60)
    speed = of(Speed, frames)[-1].speed_water_referenced
    apparent, true = (
        [wind for wind in of(WindData, frames) if wind.reference is reference][-1]
        for reference in (WindReference.APPARENT, WindReference.TRUE_WATER)
    )
    ahead = true.wind_speed * cos(true.wind_angle) + speed
    across = true.wind_speed * sin(true.wind_angle)
    assert apparent.wind_speed == pytest.approx(hypot(ahead, across), abs=0.2)
    assert abs(apart(apparent.wind_angle, atan2(across, ahead))) < 3


def test_the_seabed_is_uneven_and_never_dry():
    depths = [depth.depth for depth in of(WaterDepth, SimulatedBoat().step(600))]
    assert min(depths) > 2
    assert max(depths) - min(depths) > 3


def test_the_log_counts_the_metres_through_the_water():
    frames = SimulatedBoat().step(101)
    logged = of(DistanceLog, frames)
    speeds = [speed.speed_water_referenced for speed in of(Speed, frames)]
    assert logged[-1].trip_log - logged[0].trip_log == pytest.approx(sum(speeds[1:]), abs=2)


def test_the_sea_has_one_temperature_in_all_messages():
    frames = SimulatedBoat().step(4)
    kelvin = of(TemperatureExtendedRange, frames)[-1].temperature
    assert 285 < kelvin < 300
    assert of(Temperature, frames)[-1].actual_temperature == pytest.approx(kelvin, abs=0.02)
    assert of(EnvironmentalParametersObsolete, frames)[-1].water_temperature == pytest.approx(kelvin, abs=0.02)


def test_the_way_to_the_waypoint_says_which_way_to_steer():
    boat = SimulatedBoat(heading=radians(90), destination=(39.6, 2.6))  # it goes east, the waypoint is north
    frames = boat.step(60)
    assert of(CrossTrackError, frames)[-1].xte > 100  # right of the track: steer left
    way = of(NavigationData, frames)[-1]
    assert way.distance_to_waypoint == pytest.approx(radians(0.1) * EARTH, rel=0.01)
    assert way.bearing_position_to_destination_waypoint > radians(358)
    assert not of(CrossTrackError, SimulatedBoat().step(2))
