"""What is known about a boat, as Signal K says it.

Only what holds now is told: a value that aged out or was taken back is not in it, and `model` tells that it is gone.
Directions 0..2 pi, angles from the bow -pi..pi, all in SI.
"""

from collections.abc import Callable, Iterator, Mapping
from datetime import UTC, datetime
from math import floor, pi, radians, tau
from typing import Any

import msgspec

from timonel.core.alerts import Alert, Priority
from timonel.core.command import NOBODY
from timonel.interop.signalk.told import OWN, Told, Values
from timonel.nmea2000.lookups import CalculationType, GnssMethod, HeadingReference, WindReference, YesNo
from timonel.nmea2000.messages.environment import WindData
from timonel.nmea2000.messages.navigation import (
    CogSogRapidUpdate,
    CrossTrackError,
    DistanceLog,
    GnssPositionData,
    NavigationData,
    SetDriftRapidUpdate,
    Speed,
    WaterDepth,
)
from timonel.nmea2000.messages.steering import Attitude, RateOfTurn
from timonel.vehicles.boat.foreign_alerts import FIRST as FOREIGN
from timonel.vehicles.boat.pilot import Mode
from timonel.vehicles.boat.sources import INSTRUMENTS
from timonel.vehicles.boat.truth import Clock, Datum, Heading, Truth
from timonel.vehicles.boat.vehicle import Boat

STATES = {Mode.STANDBY: "standby", Mode.HEADING_HOLD: "auto", Mode.TRACK: "route", Mode.ALARM: "alarm"}
"""Words of the schema; a mode that is not understood has none."""
STEERING = {Mode.STANDBY: False, Mode.HEADING_HOLD: True, Mode.TRACK: True, Mode.ALARM: False}
MODES = {Mode.STANDBY: "compass", Mode.HEADING_HOLD: "compass", Mode.TRACK: "gps"}
METHODS = {
    GnssMethod.NONE: "no GPS",
    GnssMethod.GNSS_FIX: "GNSS Fix",
    GnssMethod.DGNSS_FIX: "DGNSS fix",
    GnssMethod.PRECISE_GNSS: "Precise GNSS",
    GnssMethod.RTK_FIXED_INTEGER: "RTK fixed integer",
    GnssMethod.RTK_FLOAT: "RTK float",
    GnssMethod.ESTIMATED: "Estimated (DR) mode",
    GnssMethod.MANUAL: "Manual input",
    GnssMethod.SIMULATED: "Simulator mode",
}
URGENCY = {
    Priority.EMERGENCY: "emergency",
    Priority.ALARM: "alarm",
    Priority.WARNING: "warn",
    Priority.CAUTION: "alert",
}
MAGNETIC = HeadingReference.MAGNETIC

Read = Callable[[Any, Truth, float], Values]


class Part(msgspec.Struct, frozen=True):
    """A datum, how many times the boat's age limit it counts for, and how its value reads."""

    datum: Callable[[Truth], Datum[Any] | None]
    read: Read
    ages: int = 1


def known(boat: Boat, names: Mapping[int, str], now: float) -> list[Told]:
    """Everything that holds at `now` (s). `names` are what the stations are called."""
    truth, age = boat.truth, boat.settings.max_age
    told = []
    for key, part in PARTS.items():
        datum = part.datum(truth)
        value = None if datum is None else datum.at(now, part.ages * age)
        if datum is not None and value is not None:
            source = source_label(boat, datum.source)
            told.append(Told(key, source, datum.heard, _present(part.read(value, truth, now))))
    return [*told, *_modelled_variation(boat, now), _pilot(boat), _command(boat, names), *_notifications(boat)]


def source_label(boat: Boat, source: int) -> str:
    """`timonel.40` is the device at that address, `timonel.Wind` an instrument's port, `timonel.derived` ourselves."""
    if source < INSTRUMENTS or boat.sources is None:
        return f"{OWN}.{source}"
    ports = {number: name for name, number in boat.sources.ports.items()}
    return f"{OWN}.{ports.get(source, 'derived')}"


def _present(values: Values) -> Values:
    return {path: value for path, value in values.items() if value is not None}


def from_bow(angle: float | None) -> float | None:
    """An angle 0..2 pi clockwise from the bow as -pi..pi, negative to port."""
    return None if angle is None else (angle + pi) % tau - pi


# What devices tell ------------------------------------------------------------------------------------------


def _true_heading(heading: Heading, _: Truth, __: float) -> Values:
    return {"navigation.headingTrue": heading.angle}


def _magnetic_heading(heading: Heading, _: Truth, __: float) -> Values:
    told = heading.message
    deviation = told.deviation if told.reference is MAGNETIC else None
    return {"navigation.headingMagnetic": heading.angle, "navigation.magneticDeviation": deviation}


def _rate(message: RateOfTurn, _: Truth, __: float) -> Values:
    return {"navigation.rateOfTurn": message.rate}


def _attitude(message: Attitude, _: Truth, __: float) -> Values:
    return {"navigation.attitude": {"roll": message.roll, "pitch": message.pitch, "yaw": message.yaw}}


def _position(position: tuple[float, float], _: Truth, __: float) -> Values:
    return {"navigation.position": {"latitude": position[0], "longitude": position[1]}}


def _fix(message: GnssPositionData, _: Truth, __: float) -> Values:
    return {
        "navigation.gnss.methodQuality": None if message.method is None else METHODS.get(message.method),
        "navigation.gnss.satellites": message.number_of_svs,
        "navigation.gnss.antennaAltitude": message.altitude,
        "navigation.gnss.geoidalSeparation": message.geoidal_separation,
        "navigation.gnss.horizontalDilution": message.hdop,
        "navigation.gnss.positionDilution": message.pdop,
    }


def _course(message: CogSogRapidUpdate, truth: Truth, now: float) -> Values:
    return {
        "navigation.courseOverGroundTrue": truth.to_true(message.cog, message.cog_reference, now),
        "navigation.courseOverGroundMagnetic": truth.to_magnetic(message.cog, message.cog_reference, now),
        "navigation.speedOverGround": message.sog,
    }


def _clock(clock: Clock, _: Truth, __: float) -> Values:
    return {"navigation.datetime": timestamp(clock.unix)}


def _speed(message: Speed, _: Truth, __: float) -> Values:
    return {"navigation.speedThroughWater": message.speed_water_referenced}


def _depth(message: WaterDepth, _: Truth, __: float) -> Values:
    """An offset is to the waterline if it is positive, to the keel if it is negative."""
    depth, offset = message.depth, message.offset or 0.0
    values: Values = {"environment.depth.belowTransducer": depth}
    if depth is not None and offset > 0:
        values |= {
            "environment.depth.surfaceToTransducer": offset,
            "environment.depth.belowSurface": depth + offset,
        }
    if depth is not None and offset < 0:
        values |= {"environment.depth.transducerToKeel": -offset, "environment.depth.belowKeel": depth + offset}
    return values


def _log(message: DistanceLog, _: Truth, __: float) -> Values:
    return {"navigation.log": message.log, "navigation.trip.log": message.trip_log}


def _sea_temperature(kelvin: float, _: Truth, __: float) -> Values:
    return {"environment.water.temperature": kelvin}


def _rudder(angle: float, _: Truth, __: float) -> Values:
    return {"steering.rudderAngle": angle}


def _apparent(message: WindData, _: Truth, __: float) -> Values:
    return {
        "environment.wind.speedApparent": message.wind_speed,
        "environment.wind.angleApparent": from_bow(message.wind_angle),
    }


def _true_wind(message: WindData, _: Truth, __: float) -> Values:
    return {
        "environment.wind.speedTrue": message.wind_speed,
        "environment.wind.angleTrueWater": from_bow(message.wind_angle),
    }


def _ground_wind(message: WindData, truth: Truth, now: float) -> Values:
    reference = MAGNETIC if message.reference is WindReference.MAGNETIC_NORTH else HeadingReference.TRUE
    direction, heading = truth.to_true(message.wind_angle, reference, now), truth.true_heading(now)
    known = direction is not None and heading is not None
    return {
        "environment.wind.speedOverGround": message.wind_speed,
        "environment.wind.directionTrue": direction,
        "environment.wind.directionMagnetic": truth.to_magnetic(message.wind_angle, reference, now),
        "environment.wind.angleTrueGround": from_bow((direction or 0.0) - (heading or 0.0)) if known else None,
    }


def _current(message: SetDriftRapidUpdate, truth: Truth, now: float) -> Values:
    current: dict[str, object] = {
        "drift": message.drift,
        "setTrue": truth.to_true(message.set, message.set_reference, now),
        "setMagnetic": truth.to_magnetic(message.set, message.set_reference, now),
    }
    return {"environment.current": current}


def _cross_track(message: CrossTrackError, truth: Truth, now: float) -> Values:
    ended = message.navigation_terminated is YesNo.YES
    return {f"{_kind(truth)}.crossTrackError": None if ended else message.xte}


def _navigation(message: NavigationData, truth: Truth, _: float) -> Values:
    base = _kind(truth)
    north = "Magnetic" if message.course_bearing_reference is MAGNETIC else "True"
    latitude, longitude = message.destination_latitude, message.destination_longitude
    there: dict[str, object] = {"latitude": latitude, "longitude": longitude}
    return {
        f"{base}.bearingTrack{north}": message.bearing_origin_to_destination_waypoint,
        f"{base}.nextPoint.distance": message.distance_to_waypoint,
        f"{base}.nextPoint.bearing{north}": message.bearing_position_to_destination_waypoint,
        f"{base}.nextPoint.velocityMadeGood": message.waypoint_closing_velocity,
        f"{base}.nextPoint.position": None if latitude is None or longitude is None else there,
    }


def _kind(truth: Truth) -> str:
    """How the way to the waypoint was worked out; along a great circle where nobody says."""
    told = truth.navigation.value
    rhumb = told is not None and told.calculation_type is CalculationType.RHUMB_LINE
    return f"navigation.course{'Rhumbline' if rhumb else 'GreatCircle'}"


PARTS = {
    "heading true": Part(lambda truth: truth.true, _true_heading),
    "heading magnetic": Part(lambda truth: truth.magnetic, _magnetic_heading),
    "variation": Part(lambda truth: truth.told_variation, lambda value, _, __: {VARIATION: value}),
    "rate of turn": Part(lambda truth: truth.rate, _rate),
    "attitude": Part(lambda truth: truth.attitude, _attitude),
    "position": Part(lambda truth: truth.position, _position),
    "fix": Part(lambda truth: truth.fix, _fix),
    "course": Part(lambda truth: truth.course, _course),
    "clock": Part(lambda truth: truth.clock, _clock),
    "speed": Part(lambda truth: truth.speed, _speed),
    "depth": Part(lambda truth: truth.depth, _depth),
    "log": Part(lambda truth: truth.log, _log),
    "sea temperature": Part(lambda truth: truth.sea_temperature, _sea_temperature, ages=2),
    "rudder": Part(lambda truth: truth.rudder, _rudder),
    "wind apparent": Part(lambda truth: truth.winds.get(WindReference.APPARENT), _apparent),
    "wind true": Part(lambda truth: truth.winds.get(WindReference.TRUE_WATER), _true_wind),
    "wind ground": Part(lambda truth: truth.winds.get(WindReference.TRUE_NORTH), _ground_wind),
    "current": Part(lambda truth: truth.current, _current),
    "cross track": Part(lambda truth: truth.cross_track, _cross_track),
    "navigation": Part(lambda truth: truth.navigation, _navigation),
}
VARIATION = "navigation.magneticVariation"


# What we know ourselves -------------------------------------------------------------------------------------


def _modelled_variation(boat: Boat, now: float) -> Iterator[Told]:
    """Of the World Magnetic Model where nobody tells it, once a second."""
    truth = boat.truth
    if truth.told_variation.at(now, boat.settings.max_age) is not None:
        return
    position = truth.position.at(now, boat.settings.max_age)
    variation = None if position is None else truth.variation(now)
    if variation is not None:
        yield Told("variation", f"{OWN}.model", float(floor(truth.position.heard)), {VARIATION: variation})


def _pilot(boat: Boat) -> Told:
    pilot = boat.helm.pilot
    mode, setpoint = pilot.mode, pilot.setpoint
    holds = mode is not Mode.STANDBY and setpoint is not None
    heading = "headingTrue" if boat.settings.heading_reference == "true" else "headingMagnetic"
    return Told(
        "pilot",
        OWN,
        None,
        {
            "steering.autopilot.state": STATES.get(mode),
            "steering.autopilot.mode": MODES.get(mode),
            "steering.autopilot.engaged": STEERING.get(mode),
            f"steering.autopilot.target.{heading}": radians((setpoint or 0) / 10) if holds else None,
        },
    )


def _command(boat: Boat, names: Mapping[int, str]) -> Told:
    station = boat.helm.transfer.commander
    commander: dict[str, object] = {"station": station, "name": names.get(station, "")}
    return Told("command", OWN, None, {"steering.command": None if station == NOBODY else commander})


def _notifications(boat: Boat) -> Iterator[Told]:
    for alert in boat.helm.alerts.standing:
        yield Told(f"alert {alert.kind.id}", OWN, None, {notification_path(alert): notification(alert)})


def notification_path(alert: Alert) -> str:
    """`notifications.timonel.pilotSilent104`: what it is called, and its number so that there is but one.

    One that another device tells is called by the number alone, since what it is called may change.
    """
    number = alert.kind.id
    words = alert.kind.name.lower().split() if number < FOREIGN else ["alert"]
    first, *more = ["".join(filter(str.isalnum, word)) for word in words] or [""]
    return f"notifications.{OWN}.{first}{''.join(map(str.capitalize, more))}{number}"


def notification(alert: Alert) -> dict[str, object]:
    """An alert that stands: it makes a sound until it is acknowledged, silenced or rectified."""
    quiet = alert.acknowledged or alert.silenced_until is not None or not alert.active
    return {
        "state": URGENCY[alert.kind.priority] if alert.active else "normal",
        "method": ["visual"] if quiet else ["visual", "sound"],
        "message": alert.text or alert.kind.name,
    }


def timestamp(unix: float) -> str:
    """Seconds since 1970 as ISO 8601, UTC, to the millisecond."""
    return datetime.fromtimestamp(round(unix, 3), UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
