"""What is known about a boat has the names, units and signs of Signal K."""

from math import pi, radians

import pytest

from tests.unit.interop.signalk.boats import NAMES, boat, heading, message, pilot_holds, told, values
from timonel.core.alerts import Alert, AlertKind, Priority
from timonel.core.frame import Frame
from timonel.interop.signalk.boat import known, notification, notification_path, timestamp
from timonel.nmea0183 import parp
from timonel.nmea2000.fastpacket import fragment
from timonel.nmea2000.identifier import join
from timonel.nmea2000.lookups import (
    CalculationType,
    GnssMethod,
    HeadingReference,
    SteeringMode,
    TemperatureSource,
    WindReference,
    YesNo,
)
from timonel.nmea2000.messages.environment import TemperatureExtendedRange, WindData
from timonel.nmea2000.messages.navigation import (
    CogSogRapidUpdate,
    CrossTrackError,
    DistanceLog,
    GnssPositionData,
    NavigationData,
    PositionRapidUpdate,
    SetDriftRapidUpdate,
    Speed,
    SystemTime,
    WaterDepth,
)
from timonel.nmea2000.messages.steering import (
    Attitude,
    HeadingTrackControl,
    MagneticVariation,
    RateOfTurn,
    Rudder,
    VesselHeading,
)
from timonel.vehicles.boat.alerts import NO_COMMANDER
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.sources import SourceSettings
from timonel.vehicles.boat.vehicle import Boat


def about(there: Boat, *paths: str) -> tuple[object, ...]:
    found = values(there)
    return tuple(found.get(path) for path in paths)


def test_a_magnetic_heading_is_told_with_its_true_one_and_the_deviation() -> None:
    there = boat(
        message(VesselHeading, heading=1.0, deviation=0.1, variation=0.05, reference=HeadingReference.MAGNETIC)
    )
    assert about(there, "navigation.headingMagnetic", "navigation.headingTrue", "navigation.magneticDeviation") == (
        pytest.approx(1.1),
        pytest.approx(1.15),
        pytest.approx(0.1),
    )


def test_what_moves_is_positive_to_starboard() -> None:
    there = boat(
        message(RateOfTurn, rate=0.01),
        message(Rudder, position=-0.2),
        message(Attitude, roll=0.1, pitch=-0.05),
        message(MagneticVariation, variation=-0.03),
    )
    assert about(there, "navigation.rateOfTurn", "steering.rudderAngle", "navigation.magneticVariation") == (
        pytest.approx(0.01, abs=1e-7),
        pytest.approx(-0.2),
        pytest.approx(-0.03),
    )
    assert values(there)["navigation.attitude"] == {
        "roll": pytest.approx(0.1), "pitch": pytest.approx(-0.05), "yaw": None
    }  # fmt: skip


@pytest.mark.parametrize(
    ("offset", "expected"),
    [
        (0.4, {"surfaceToTransducer": 0.4, "belowSurface": 20.4}),
        (-1.5, {"transducerToKeel": 1.5, "belowKeel": 18.5}),
        (0.0, {}),
        (None, {}),
    ],
)
def test_the_depth_is_told_from_the_datum_that_the_offset_is_for(
    offset: float | None, expected: dict[str, float]
) -> None:
    there = values(boat(message(WaterDepth, depth=20.0, offset=offset)))
    depths = {path.rpartition(".")[2]: value for path, value in there.items() if ".depth." in path}
    assert depths == {"belowTransducer": 20.0} | {name: pytest.approx(value) for name, value in expected.items()}


@pytest.mark.parametrize(("told_angle", "from_bow"), [(0.5, 0.5), (2 * pi - 0.5, -0.5), (pi, -pi)])
def test_apparent_wind_from_port_is_negative(told_angle: float, from_bow: float) -> None:
    there = boat(message(WindData, wind_speed=5.0, wind_angle=told_angle, reference=WindReference.APPARENT))
    speed, angle = about(there, "environment.wind.speedApparent", "environment.wind.angleApparent")
    assert (speed, angle) == (5.0, pytest.approx(from_bow, abs=1e-4))


def test_wind_against_the_water_is_not_wind_over_ground() -> None:
    water = message(WindData, wind_speed=5.0, wind_angle=1.0, reference=WindReference.TRUE_WATER)
    ground = message(WindData, wind_speed=6.0, wind_angle=2.0, reference=WindReference.TRUE_NORTH)
    there = boat(message(VesselHeading, heading=0.5, reference=HeadingReference.TRUE), water, ground)
    found = {path.rpartition(".")[2]: value for path, value in values(there).items() if ".wind." in path}
    assert found == {
        "speedTrue": 5.0,
        "angleTrueWater": pytest.approx(1.0),
        "speedOverGround": 6.0,
        "directionTrue": pytest.approx(2.0),
        "angleTrueGround": pytest.approx(1.5),
    }


def test_a_magnetic_wind_direction_needs_the_variation_to_be_a_true_one() -> None:
    wind = message(WindData, wind_speed=6.0, wind_angle=2.0, reference=WindReference.MAGNETIC_NORTH)
    there = boat(wind)
    paths = ("environment.wind.directionMagnetic", "environment.wind.directionTrue")
    assert about(there, *paths) == (pytest.approx(2.0), None)
    told(there, message(MagneticVariation, variation=0.1))
    assert about(there, *paths) == (pytest.approx(2.0), pytest.approx(2.1))


def test_a_magnetic_course_is_never_told_as_a_true_one() -> None:
    there = boat(message(CogSogRapidUpdate, cog=1.0, sog=3.0, cog_reference=HeadingReference.MAGNETIC))
    paths = ("navigation.courseOverGroundMagnetic", "navigation.courseOverGroundTrue", "navigation.speedOverGround")
    assert about(there, *paths) == (pytest.approx(1.0), None, pytest.approx(3.0))


def test_position_time_speed_log_and_temperature_are_as_the_bus_tells_them() -> None:
    there = boat(
        message(PositionRapidUpdate, latitude=-39.5000001, longitude=2.6),
        message(SystemTime, date=20000, time=3661.5),
        message(Speed, speed_water_referenced=3.2),
        message(TemperatureExtendedRange, source=TemperatureSource.SEA, temperature=290.15),
    )
    there.receive_message(0x19F5132A, message(DistanceLog, log=1000, trip_log=10).encode(), 0.0)
    found = values(there)
    assert found["navigation.position"] == {
        "latitude": pytest.approx(-39.5000001, abs=1e-9), "longitude": pytest.approx(2.6)
    }  # fmt: skip
    assert found["navigation.datetime"] == "2024-10-04T01:01:01.500Z"
    assert found["navigation.speedThroughWater"] == pytest.approx(3.2)
    assert found["environment.water.temperature"] == pytest.approx(290.15)
    assert (found["navigation.log"], found["navigation.trip.log"]) == (1000, 10)


def test_a_fix_says_how_it_was_found_in_the_words_of_the_schema() -> None:
    there = boat()
    fix = GnssPositionData(latitude=1.0, longitude=2.0, method=GnssMethod.RTK_FLOAT, number_of_svs=9, hdop=0.8)
    there.receive_message(0x0DF80529, fix.encode(), 0.0)
    found = values(there)
    assert found["navigation.gnss.methodQuality"] == "RTK float"
    assert (found["navigation.gnss.satellites"], found["navigation.gnss.horizontalDilution"]) == (9, 0.8)
    assert "navigation.gnss.antennaAltitude" not in found


def test_a_current_is_told_whither_it_sets() -> None:
    there = boat(
        message(MagneticVariation, variation=0.1),
        message(SetDriftRapidUpdate, set=1.0, drift=0.5, set_reference=HeadingReference.TRUE),
    )
    assert values(there)["environment.current"] == {
        "drift": pytest.approx(0.5), "setTrue": pytest.approx(1.0), "setMagnetic": pytest.approx(0.9)
    }  # fmt: skip


def test_an_instrument_s_port_and_what_is_computed_are_sources_of_their_own() -> None:
    ports = [Port("Wind 4800", instrument=True)]
    there = Boat(BoatSettings(sources=SourceSettings(derive=("true_wind",))), ports, 0.0)
    told(there, message(VesselHeading, heading=0.5, reference=HeadingReference.TRUE))
    told(there, message(Speed, speed_water_referenced=3.0))
    there.receive_bytes("Wind 4800", b"$IIMWV,40.0,R,6.0,M,A*0C\r\n", 0.0)
    told(there, message(Speed, speed_water_referenced=3.0), 0.1)
    sources = {each.key: each.source for each in known(there, NAMES, 0.2)}
    assert sources["wind apparent"] == "timonel.Wind 4800"
    assert sources["wind true"] == "timonel.derived"
    assert sources["heading true"] == "timonel.10"


def test_a_cross_track_error_is_positive_where_one_steers_left_and_ends_with_the_navigation() -> None:
    there = boat(message(CrossTrackError, xte=12.5, navigation_terminated=YesNo.NO))
    assert about(there, "navigation.courseGreatCircle.crossTrackError") == (12.5,)
    way = NavigationData(
        calculation_type=CalculationType.RHUMB_LINE,
        distance_to_waypoint=100.0,
        bearing_position_to_destination_waypoint=1.0,
        course_bearing_reference=HeadingReference.MAGNETIC,
    )
    there.receive_message(0x0DF9042E, way.encode(), 0.0)
    found = values(there)
    assert found["navigation.courseRhumbline.crossTrackError"] == 12.5
    assert found["navigation.courseRhumbline.nextPoint.distance"] == 100.0
    assert found["navigation.courseRhumbline.nextPoint.bearingMagnetic"] == pytest.approx(1.0)
    assert "navigation.courseRhumbline.nextPoint.bearingTrue" not in found
    assert "navigation.courseRhumbline.nextPoint.position" not in found
    told(there, message(CrossTrackError, xte=12.5, navigation_terminated=YesNo.YES))
    assert "navigation.courseRhumbline.crossTrackError" not in values(there)


def test_what_is_older_than_the_age_limit_is_not_known() -> None:
    there = boat(message(Rudder, position=0.1))
    assert "steering.rudderAngle" in values(there, 2.9)
    assert "steering.rudderAngle" not in values(there, 3.0)


def test_each_value_says_which_device_told_it_and_when() -> None:
    there = boat()
    told(there, message(Rudder, position=0.1), 1.5)
    (rudder,) = [each for each in known(there, NAMES, 2.0) if each.key == "rudder"]
    assert (rudder.source, rudder.heard) == ("timonel.10", 1.5)


def test_a_variation_that_nobody_tells_is_that_of_the_model_and_says_so() -> None:
    there = Boat(BoatSettings(), [], 0.0, lambda latitude, longitude, time: 0.02)
    told(there, message(PositionRapidUpdate, latitude=39.5, longitude=2.6), 1.7)
    told(there, message(SystemTime, date=20000, time=0.0), 1.7)
    (variation,) = [each for each in known(there, NAMES, 2.0) if each.key == "variation"]
    assert (variation.source, variation.heard) == ("timonel.model", 1.0)
    assert variation.values == {"navigation.magneticVariation": 0.02}
    told(there, message(MagneticVariation, variation=0.03), 1.8)
    (variation,) = [each for each in known(there, NAMES, 2.0) if each.key == "variation"]
    assert variation.source == "timonel.10"


# Pilot, command and alerts ----------------------------------------------------------------------------------

PILOT = ("steering.autopilot.state", "steering.autopilot.mode", "steering.autopilot.engaged")


def test_a_pilot_in_standby_holds_no_course() -> None:
    there = boat()
    assert about(there, *PILOT, "steering.autopilot.target.headingTrue") == ("standby", "compass", False, None)


@pytest.mark.parametrize(("reference", "path"), [("true", "headingTrue"), ("magnetic", "headingMagnetic")])
def test_a_pilot_that_holds_a_course_tells_it_in_the_boat_s_reference(reference: str, path: str) -> None:
    there = boat(message(MagneticVariation, variation=0.0), heading_reference=reference)
    there.receive_frames([heading(45.0), *pilot_holds(45.0)], 0.0)
    assert about(there, *PILOT) == ("auto", "compass", True)
    assert about(there, f"steering.autopilot.target.{path}") == (pytest.approx(radians(45)),)


def test_a_mode_that_is_not_understood_is_null_and_not_standby() -> None:
    report = message(HeadingTrackControl, steering_mode=SteeringMode.FOLLOW_UP)
    there = boat()
    there.receive_frames([Frame(join(2, 127237, 204), part) for part in fragment(report.encode(), 0)], 0.0)
    assert about(there, *PILOT) == (None, None, None)


def test_a_silent_bus_is_the_state_alarm_and_an_alarm() -> None:
    there = boat()
    there.expire(3.0)
    found = values(there, 3.0)
    assert found["steering.autopilot.state"] == "alarm"
    assert found["steering.autopilot.engaged"] is False
    alarm = found["notifications.timonel.backboneSilent101"]
    assert isinstance(alarm, dict)
    assert (alarm["state"], alarm["method"]) == ("alarm", ["visual", "sound"])


def test_the_station_in_command_is_told_by_name() -> None:
    there = boat()
    assert values(there)["steering.command"] is None
    there.receive_bytes("Cockpit", parp.command(parp.Verb.REQCMD, 2), 0.0)
    assert values(there)["steering.command"] == {"station": 2, "name": "Cockpit"}


@pytest.mark.parametrize(
    ("priority", "state"),
    [
        (Priority.EMERGENCY, "emergency"),
        (Priority.ALARM, "alarm"),
        (Priority.WARNING, "warn"),
        (Priority.CAUTION, "alert"),
    ],
)
def test_the_urgency_of_an_alert_is_the_state_of_its_notification(priority: Priority, state: str) -> None:
    assert notification(Alert(AlertKind(1, "x", priority), "", 0.0))["state"] == state


def test_an_alert_is_quiet_once_it_is_acknowledged_silenced_or_over() -> None:
    sounding = Alert(NO_COMMANDER, "nobody", 0.0)
    assert notification(sounding)["method"] == ["visual", "sound"]
    for quiet in ({"acknowledged": True}, {"silenced_until": 30.0}, {"active": False}):
        assert notification(Alert(NO_COMMANDER, "nobody", 0.0, **quiet))["method"] == ["visual"]  # type: ignore[arg-type]
    assert notification(Alert(NO_COMMANDER, "nobody", 0.0, active=False))["state"] == "normal"


@pytest.mark.parametrize(
    ("number", "name", "path"),
    [
        (105, "steering without commander", "steeringWithoutCommander105"),
        (7, "a.b/ c*", "abC7"),
        (7, "  ", "7"),
        (401, "whatever a device says", "alert401"),
    ],
)
def test_the_path_of_a_notification_is_one_word_and_a_device_cannot_make_ever_more(
    number: int, name: str, path: str
) -> None:
    alert = Alert(AlertKind(number, name, Priority.ALARM), "", 0.0)
    assert notification_path(alert) == f"notifications.timonel.{path}"


def test_a_time_is_told_to_the_millisecond_in_utc() -> None:
    assert timestamp(1_700_000_000.0005) == "2023-11-14T22:13:20.000Z"
    assert timestamp(1_700_000_000.9996) == "2023-11-14T22:13:21.000Z"
