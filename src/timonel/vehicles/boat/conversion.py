"""NMEA 2000 to NMEA 0183: which message gives which sentence, how often, and how (spec/boat.md, Sentences sent).

`CONVERSIONS` is the table. Each line is a formatter, its ceiling in Hz, the messages that bring it about, and a
function from what is known to the sentence, or to None where there is nothing to say. Ceilings of 10 Hz for what
turns with the boat; 1 Hz and less for the rest, as the specification has them.
"""

from collections.abc import Callable
from datetime import date, timedelta
from math import degrees
from typing import Any

import msgspec

from timonel.core.effects import Effect, Rejected, Say
from timonel.core.message import Message
from timonel.core.pace import Pace
from timonel.errors import EncodeError
from timonel.nmea0183 import sentences as s
from timonel.nmea0183.dialect import encode_ar10
from timonel.nmea0183.fields import escaped
from timonel.nmea0183.sentence import Sentence
from timonel.nmea0183.vdm import OTHERS
from timonel.nmea2000.lookups import (
    DirectionRudder,
    GnssMethod,
    HeadingReference,
    SteeringMode,
    TurnMode,
    WindReference,
    XteMode,
    YesNo,
)
from timonel.nmea2000.messages import environment, navigation, steering
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
from timonel.nmea2000.messages.steering import (
    Attitude,
    HeadingTrackControl,
    RateOfTurn,
    Rudder,
    VesselHeading,
)
from timonel.vehicles.boat.truth import Truth

KNOT = 1852 / 3600  # m/s
MILE = 1852.0  # m
FOOT = 0.3048  # m
FATHOM = 6 * FOOT
ZERO_CELSIUS = 273.15  # K
MINUTE = 60.0  # s
LONGEST_NAME = 8  # characters: RMB has room for so many, if all its numbers are as long as can be
EPOCH = date(1970, 1, 1)
AIS_RATE = 10.0  # Hz, which no ship sends

MODES = {
    GnssMethod.NONE: s.Mode.NOT_VALID,
    GnssMethod.GNSS_FIX: s.Mode.AUTONOMOUS,
    GnssMethod.DGNSS_FIX: s.Mode.DIFFERENTIAL,
    GnssMethod.PRECISE_GNSS: s.Mode.PRECISE,
    GnssMethod.RTK_FIXED_INTEGER: s.Mode.RTK_FIXED,
    GnssMethod.RTK_FLOAT: s.Mode.RTK_FLOAT,
    GnssMethod.ESTIMATED: s.Mode.ESTIMATED,
    GnssMethod.MANUAL: s.Mode.MANUAL,
    GnssMethod.SIMULATED: s.Mode.SIMULATOR,
}
QUALITIES = {  # of GGA; a precise fix has no figure of its own
    GnssMethod.NONE: 0,
    GnssMethod.GNSS_FIX: 1,
    GnssMethod.DGNSS_FIX: 2,
    GnssMethod.PRECISE_GNSS: 3,
    GnssMethod.RTK_FIXED_INTEGER: 4,
    GnssMethod.RTK_FLOAT: 5,
    GnssMethod.ESTIMATED: 6,
    GnssMethod.MANUAL: 7,
    GnssMethod.SIMULATED: 8,
}
STEERING_MODES = {
    SteeringMode.MAIN_STEERING: s.SteeringMode.MANUAL,
    SteeringMode.NON_FOLLOW_UP: s.SteeringMode.RUDDER_CONTROL,
    SteeringMode.FOLLOW_UP: s.SteeringMode.RUDDER_CONTROL,
    SteeringMode.HEADING_CONTROL_STANDALONE: s.SteeringMode.STAND_ALONE,
    SteeringMode.HEADING_CONTROL: s.SteeringMode.HEADING_CONTROL,
    SteeringMode.TRACK_CONTROL: s.SteeringMode.TRACK_CONTROL,
}
TURN_MODES = {
    TurnMode.RUDDER_LIMIT_CONTROLLED: s.TurnMode.NOT_CONTROLLED,
    TurnMode.TURN_RATE_CONTROLLED: s.TurnMode.RATE,
    TurnMode.RADIUS_CONTROLLED: s.TurnMode.RADIUS,
}
REFERENCES = {
    HeadingReference.TRUE: s.Reference.TRUE,
    HeadingReference.MAGNETIC: s.Reference.MAGNETIC,
}


def deg(angle: float | None) -> float | None:
    """Degrees of rad, None of None."""
    return None if angle is None else degrees(angle)


def direction(angle: float | None) -> float | None:
    """Degrees 0..360 of rad. A full turn in steps of 1e-4 rad is a little more than one."""
    return None if angle is None else degrees(angle) % 360.0


def scaled(value: float | None, unit: float) -> float | None:
    """`value` in units of `unit`, None of None."""
    return None if value is None else value / unit


def yes(answer: YesNo | None) -> bool | None:
    """A and V of the answers that are answers."""
    return None if answer not in (YesNo.NO, YesNo.YES) else answer is YesNo.YES


# Heading ----------------------------------------------------------------------------------------


def hdt(truth: Truth, message: VesselHeading, now: float) -> Sentence | None:
    heading = truth.true.value
    return s.HDT(degrees(heading.angle)) if heading is not None and heading.message is message else None


def ths(truth: Truth, message: VesselHeading, now: float) -> Sentence | None:
    heading = truth.true.value
    if heading is None or heading.message is not message:
        return None
    return s.THS(degrees(heading.angle), s.HeadingMode.AUTONOMOUS)


def hdm(truth: Truth, message: VesselHeading, now: float) -> Sentence | None:
    heading = truth.magnetic.value
    return s.HDM(degrees(heading.angle)) if heading is not None and heading.message is message else None


def hdg(truth: Truth, message: VesselHeading, now: float) -> Sentence | None:
    """The compass as it reads; one that tells true headings is taken back to the magnetic one."""
    heading = truth.magnetic.value
    if heading is None or heading.message is not message:
        return None
    variation = message.variation if message.variation is not None else truth.variation(now)
    if message.reference is HeadingReference.MAGNETIC:
        return s.HDG(direction(message.heading), deg(message.deviation), deg(variation))
    return s.HDG(degrees(heading.angle), None, deg(variation))


def rot(truth: Truth, message: RateOfTurn, now: float) -> Sentence | None:
    return None if message.rate is None else s.ROT(degrees(message.rate) * MINUTE, True)


def xdr(truth: Truth, message: Attitude, now: float) -> Sentence | None:
    angles = (("PITCH", message.pitch), ("ROLL", message.roll))
    told = tuple(s.Transducer("A", round(degrees(a), 1), "D", name) for name, a in angles if a is not None)
    return s.XDR(told) if told else None


# Steering ---------------------------------------------------------------------------------------


def rsa(truth: Truth, message: Rudder, now: float) -> Sentence | None:
    return None if message.position is None else s.RSA(degrees(message.position), True)


def htd(truth: Truth, message: HeadingTrackControl, now: float) -> Sentence | None:
    sentence = heading_track(message)
    empty = s.HTD(reference=sentence.reference)
    return None if sentence == empty else sentence


def heading_track(message: HeadingTrackControl) -> s.HTD:
    """127237 field by field; a direction of rudder without an angle stays one (non-follow-up steering)."""
    return s.HTD(
        override=yes(message.override),
        rudder_angle_deg=None if (angle := message.commanded_rudder_angle) is None else _limit(abs(angle)),
        rudder_direction=_rudder_direction(message),
        steering_mode=STEERING_MODES.get(message.steering_mode) if message.steering_mode is not None else None,
        turn_mode=TURN_MODES.get(message.turn_mode) if message.turn_mode is not None else None,
        rudder_limit_deg=_limit(message.rudder_limit),
        off_heading_limit_deg=_limit(message.off_heading_limit),
        radius_nm=None if (radius := message.radius_of_turn_order) is None else abs(radius) / MILE,
        rate_deg_min=None if (rate := message.rate_of_turn_order) is None else degrees(rate) * MINUTE,
        heading_to_steer_deg=direction(message.heading_to_steer_course),
        off_track_limit_nm=None if (limit := message.off_track_limit) is None else abs(limit) / MILE,
        track_deg=direction(message.track),
        reference=_reference(message.heading_reference),
        within_rudder_limit=_within(message.rudder_limit_exceeded),
        within_off_heading_limit=_within(message.off_heading_limit_exceeded),
        within_off_track_limit=_within(message.off_track_limit_exceeded),
        heading_deg=direction(message.vessel_heading),
    )


def _limit(angle: float | None) -> float | None:
    """Degrees of a limit; one beyond half a turn is none. In steps of 1e-4 rad, half a turn is a little more."""
    limit = None if angle is None else round(degrees(angle), 1)
    return None if limit is None or limit > 180.0 else limit


def _rudder_direction(message: HeadingTrackControl) -> s.RudderDirection | None:
    """As ordered; an angle alone has its direction in its sign."""
    match message.commanded_rudder_direction:
        case DirectionRudder.STARBOARD:
            return s.RudderDirection.RIGHT
        case DirectionRudder.PORT:
            return s.RudderDirection.LEFT
    angle = message.commanded_rudder_angle
    if not angle:
        return None
    return s.RudderDirection.RIGHT if angle > 0 else s.RudderDirection.LEFT


def _reference(reference: HeadingReference | None) -> s.Reference | None:
    return None if reference is None else REFERENCES.get(reference)


def _within(exceeded: YesNo | None) -> bool | None:
    answer = yes(exceeded)
    return None if answer is None else not answer


# Water ------------------------------------------------------------------------------------------


def vhw(truth: Truth, message: Speed, now: float) -> Sentence | None:
    speed = message.speed_water_referenced
    true, magnetic = truth.true_heading(now), truth.magnetic_heading(now)
    return None if speed is None else s.VHW(deg(true), deg(magnetic), speed / KNOT, speed * 3.6)


def vlw(truth: Truth, message: DistanceLog, now: float) -> Sentence | None:
    return s.VLW(scaled(message.log, MILE), scaled(message.trip_log, MILE))


def dpt(truth: Truth, message: WaterDepth, now: float) -> Sentence | None:
    return s.DPT(message.depth, message.offset, message.range)


def dbt(truth: Truth, message: WaterDepth, now: float) -> Sentence | None:
    depth = message.depth
    return s.DBT(scaled(depth, FOOT), depth, scaled(depth, FATHOM))


def vdr(truth: Truth, message: SetDriftRapidUpdate, now: float) -> Sentence | None:
    current, reference = message.set, message.set_reference
    return s.VDR(
        direction(truth.to_true(current, reference, now)),
        direction(truth.to_magnetic(current, reference, now)),
        scaled(message.drift, KNOT),
    )


def mtw(truth: Truth, message: Message, now: float) -> Sentence | None:
    kelvin = truth.sea_temperature.value
    return None if kelvin is None else s.MTW(kelvin - ZERO_CELSIUS)


# Position ---------------------------------------------------------------------------------------


def _mode(truth: Truth, now: float) -> s.Mode:
    """A position whose way nobody tells is an ordinary one; a way that is not understood is not trusted."""
    method = truth.method_at(now)
    return s.Mode.AUTONOMOUS if method is None else MODES.get(method, s.Mode.NOT_VALID)


def gll(truth: Truth, message: Message, now: float) -> Sentence | None:
    position, clock = truth.position_at(now), truth.clock_at(now)
    if position is None:
        return None
    return s.GLL(*position, None if clock is None else clock.second, True, _mode(truth, now))


def rmc(truth: Truth, message: CogSogRapidUpdate, now: float) -> Sentence | None:
    position, clock = truth.position_at(now), truth.clock_at(now)
    latitude, longitude = position or (None, None)
    return s.RMC(
        time=None if clock is None else clock.second,
        valid=True,
        latitude_deg=latitude,
        longitude_deg=longitude,
        speed_kn=scaled(message.sog, KNOT),
        course_deg=direction(truth.to_true(message.cog, message.cog_reference, now)),
        date=None if clock is None else EPOCH + timedelta(days=clock.day),
        variation_deg=deg(truth.variation(now)),
        mode=s.Mode.NOT_VALID if position is None else _mode(truth, now),
    )


def vtg(truth: Truth, message: CogSogRapidUpdate, now: float) -> Sentence | None:
    course, reference = message.cog, message.cog_reference
    return s.VTG(
        direction(truth.to_true(course, reference, now)),
        direction(truth.to_magnetic(course, reference, now)),
        scaled(message.sog, KNOT),
        None if message.sog is None else message.sog * 3.6,
        _mode(truth, now),
    )


def gga(truth: Truth, message: GnssPositionData, now: float) -> Sentence | None:
    if message.latitude is None or message.longitude is None:
        return None
    return s.GGA(
        time=message.time,
        latitude_deg=message.latitude,
        longitude_deg=message.longitude,
        quality=0 if message.method is None else QUALITIES.get(message.method, 0),
        satellites=None if message.number_of_svs is None else min(message.number_of_svs, 99),
        hdop=message.hdop,
        altitude_m=message.altitude,
        geoid_m=message.geoidal_separation,
    )


def zda(truth: Truth, message: Message, now: float) -> Sentence | None:
    clock = truth.clock_at(now)
    if clock is None:
        return None
    day = EPOCH + timedelta(days=clock.day)
    return s.ZDA(clock.second, day.day, day.month, day.year)


# Wind -------------------------------------------------------------------------------------------

MWV_REFERENCES = {
    WindReference.APPARENT: s.WindReference.RELATIVE,
    WindReference.TRUE_BOAT: s.WindReference.THEORETICAL,
    WindReference.TRUE_WATER: s.WindReference.THEORETICAL,
}
NORTHS = {
    WindReference.TRUE_NORTH: HeadingReference.TRUE,
    WindReference.MAGNETIC_NORTH: HeadingReference.MAGNETIC,
}


def mwv(truth: Truth, message: WindData, now: float) -> Sentence | None:
    if message.reference not in MWV_REFERENCES:
        return None
    reference = MWV_REFERENCES[message.reference]
    return s.MWV(direction(message.wind_angle), reference, scaled(message.wind_speed, KNOT), s.SpeedUnit.KNOTS, True)


def mwv_relative(truth: Truth, message: WindData, now: float) -> Sentence | None:
    return mwv(truth, message, now) if message.reference is WindReference.APPARENT else None


def mwv_theoretical(truth: Truth, message: WindData, now: float) -> Sentence | None:
    return mwv(truth, message, now) if message.reference is not WindReference.APPARENT else None


def mwd(truth: Truth, message: WindData, now: float) -> Sentence | None:
    if message.reference not in NORTHS:
        return None
    angle, north = message.wind_angle, NORTHS[message.reference]
    return s.MWD(
        direction(truth.to_true(angle, north, now)),
        direction(truth.to_magnetic(angle, north, now)),
        scaled(message.wind_speed, KNOT),
        message.wind_speed,
    )


# Route ------------------------------------------------------------------------------------------

XTE_MODES = {
    XteMode.AUTONOMOUS: s.Mode.AUTONOMOUS,
    XteMode.DIFFERENTIAL_ENHANCED: s.Mode.DIFFERENTIAL,
    XteMode.ESTIMATED: s.Mode.ESTIMATED,
    XteMode.SIMULATOR: s.Mode.SIMULATOR,
    XteMode.MANUAL: s.Mode.MANUAL,
}


def _on_leg(message: CrossTrackError) -> bool:
    return message.xte is not None and message.navigation_terminated is not YesNo.YES


def _xte_mode(message: CrossTrackError) -> s.Mode:
    mode = message.xte_mode
    return s.Mode.AUTONOMOUS if mode is None else XTE_MODES.get(mode, s.Mode.NOT_VALID)


def xte(truth: Truth, message: CrossTrackError, now: float) -> Sentence | None:
    if message.xte is None:
        return None
    valid = _on_leg(message)
    return s.XTE(valid, valid, scaled(message.xte, MILE), _xte_mode(message))


def _waypoint(truth: Truth, number: int | None) -> str | None:
    """As much of the waypoint's name as a sentence has room for, else its number, which is never cut."""
    if number is None:
        return None
    name = truth.waypoint_names.get(number)
    return _short(name) if name else f"{number}" if number < 10**LONGEST_NAME else None


def _short(name: str) -> str:
    name = "".join(character if character.isprintable() and character <= "\xff" else "?" for character in name)
    while _width(name) > LONGEST_NAME:
        name = name[:-1]
    return name


def _width(name: str | None) -> int:
    """Characters in a sentence; a reserved one takes three."""
    return len(escaped(name, "waypoint")) if name else 0


def _arrived(message: NavigationData) -> bool | None:
    entered = yes(message.arrival_circle_entered)
    return entered if entered else (yes(message.perpendicular_crossed) or entered)


def rmb(truth: Truth, message: NavigationData, now: float) -> Sentence | None:
    """Where both names do not fit, the destination's stays."""
    leg = truth.cross_track_at(now)
    if leg is None:
        return None
    bearing = message.bearing_position_to_destination_waypoint
    origin = _waypoint(truth, message.origin_waypoint_number)
    destination = _waypoint(truth, message.destination_waypoint_number)
    return s.RMB(
        valid=_on_leg(leg),
        cross_track_error_nm=scaled(leg.xte, MILE),
        origin=origin if _width(origin) + _width(destination) <= LONGEST_NAME else None,
        destination=destination,
        latitude_deg=message.destination_latitude,
        longitude_deg=message.destination_longitude,
        range_nm=scaled(message.distance_to_waypoint, MILE),
        bearing_deg=direction(truth.to_true(bearing, message.course_bearing_reference, now)),
        closing_speed_kn=scaled(message.waypoint_closing_velocity, KNOT),
        arrived=_arrived(message),
        mode=_xte_mode(leg),
    )


def apb(truth: Truth, message: NavigationData, now: float) -> Sentence | None:
    """The bearings in the reference they were told in: a pilot that expects the other one must convert."""
    leg = truth.cross_track_at(now)
    if leg is None:
        return None
    reference = _reference(message.course_bearing_reference)
    bearing = direction(message.bearing_position_to_destination_waypoint)
    return s.APB(
        valid=_on_leg(leg),
        locked=_on_leg(leg),
        cross_track_error_nm=scaled(leg.xte, MILE),
        arrived=yes(message.arrival_circle_entered),
        perpendicular_passed=yes(message.perpendicular_crossed),
        leg_bearing_deg=direction(message.bearing_origin_to_destination_waypoint),
        leg_bearing_reference=reference,
        destination=_waypoint(truth, message.destination_waypoint_number),
        bearing_deg=bearing,
        bearing_reference=reference,
        heading_to_steer_deg=bearing,
        heading_to_steer_reference=reference,
        mode=_xte_mode(leg),
    )


# The table --------------------------------------------------------------------------------------

Build = Callable[[Truth, Any, float], Sentence | None]


class Conversion(msgspec.Struct, frozen=True):
    """One line of the table. `key` tells streams of one formatter apart, `rate` is the ceiling in Hz."""

    key: str
    rate: float
    build: Build
    messages: tuple[type[Message], ...]
    talker: str = "II"
    clocked: bool = False
    """Whether, up to one a second, it goes with the bus's clock, so that its time is the time of its position."""

    @property
    def formatter(self) -> str:
        return self.key[:3]


HEADING = (VesselHeading,)
COURSE = (CogSogRapidUpdate,)
WIND = (WindData,)
POSITION = (navigation.PositionRapidUpdate, GnssPositionData)
CLOCK = (navigation.SystemTime, navigation.TimeDate, GnssPositionData)
SEA = (
    environment.TemperatureExtendedRange,
    environment.Temperature,
    environment.EnvironmentalParameters,
    environment.EnvironmentalParametersObsolete,
)

CONVERSIONS = (
    Conversion("HDT", 10, hdt, HEADING),
    Conversion("THS", 10, ths, HEADING),
    Conversion("HDG", 10, hdg, HEADING),
    Conversion("HDM", 10, hdm, HEADING),
    Conversion("ROT", 10, rot, (RateOfTurn,)),
    Conversion("RSA", 10, rsa, (Rudder,)),
    Conversion("XDR", 1, xdr, (Attitude,)),
    Conversion("HTD", 2, htd, (HeadingTrackControl,), "AG"),
    Conversion("VHW", 1, vhw, (Speed,)),
    Conversion("VLW", 1, vlw, (DistanceLog,)),
    Conversion("DPT", 1, dpt, (WaterDepth,)),
    Conversion("DBT", 1, dbt, (WaterDepth,)),
    Conversion("VDR", 1, vdr, (SetDriftRapidUpdate,)),
    Conversion("MTW", 0.5, mtw, SEA),
    Conversion("GLL", 1, gll, (*POSITION, *CLOCK), "GP", clocked=True),
    Conversion("RMC", 1, rmc, COURSE, "GP"),
    Conversion("VTG", 1, vtg, COURSE, "GP"),
    Conversion("GGA", 1, gga, (GnssPositionData,), "GP"),
    Conversion("ZDA", 1, zda, CLOCK, "GP"),
    Conversion("MWV,R", 1, mwv_relative, WIND),
    Conversion("MWV,T", 1, mwv_theoretical, WIND),
    Conversion("MWD", 1, mwd, WIND),
    Conversion("XTE", 1, xte, (CrossTrackError,), "GP"),
    Conversion("RMB", 1, rmb, (NavigationData,), "GP"),
    Conversion("APB", 1, apb, (NavigationData,), "GP"),
)
RATES = {conversion.formatter: conversion.rate for conversion in CONVERSIONS} | {OTHERS: AIS_RATE}
"""The ceilings in Hz by formatter, as they are without settings; that of VDM, and VDO, is one for each ship."""

Hear = Callable[[Truth, Any, int, float], bool]
HEAR: dict[type[Message], Hear] = {
    VesselHeading: Truth.hear_heading,
    steering.MagneticVariation: Truth.hear_variation,
    Rudder: Truth.hear_rudder,
    HeadingTrackControl: Truth.hear_pilot,
    RateOfTurn: Truth.hear_rate,
    Attitude: Truth.hear_attitude,
    Speed: Truth.hear_speed,
    DistanceLog: Truth.hear_log,
    SetDriftRapidUpdate: Truth.hear_current,
    WaterDepth: Truth.hear_depth,
    navigation.PositionRapidUpdate: Truth.hear_position,
    GnssPositionData: Truth.hear_fix,
    CogSogRapidUpdate: Truth.hear_course,
    navigation.SystemTime: Truth.hear_system_time,
    navigation.TimeDate: Truth.hear_time_date,
    CrossTrackError: Truth.hear_cross_track,
    NavigationData: Truth.hear_navigation,
    navigation.NavigationRouteWpInformation: Truth.hear_route,
    WindData: Truth.hear_wind,
    environment.TemperatureExtendedRange: Truth.hear_extended_temperature,
    environment.Temperature: Truth.hear_temperature,
    environment.EnvironmentalParameters: Truth.hear_environment,
    environment.EnvironmentalParametersObsolete: Truth.hear_old_environment,
}
"""Every message that is listened to, and how."""


class Stream(Pace):
    """One line of the table at work: builds the sentence when its ceiling allows."""

    __slots__ = ("_build", "_clocked", "_key", "_standard", "_talker")

    def __init__(self, conversion: Conversion, rate: float, dialect: str) -> None:
        super().__init__(1 / rate)
        self._build = conversion.build
        self._key = conversion.key
        self._talker = conversion.talker
        self._standard = dialect == "standard"
        self._clocked = conversion.clocked and rate <= 1

    def say(self, truth: Truth, message: Message, now: float) -> Say | None:
        """The sentence that `message` brings about, if there is one. Raises EncodeError for an absurd value.

        Asked only when the ceiling is open.
        """
        if self._clocked and type(message) not in CLOCK and truth.clock_at(now) is not None:
            return None
        sentence = self._build(truth, message, now)
        if sentence is None:
            return None
        line = sentence.encode(self._talker) if self._standard else encode_ar10(sentence, self._talker)
        self.count(now)
        return Say(line, self._key)


class Converter:
    """All streams, by the message that brings them about. `rates` overrides `RATES`; 0 is never."""

    def __init__(self, truth: Truth, rates: dict[str, float], dialect: str) -> None:
        self._truth = truth
        wanted = RATES | rates
        streams: dict[type[Message], list[Stream]] = {message: [] for message in HEAR}
        for conversion in CONVERSIONS:
            if wanted[conversion.formatter] > 0:
                stream = Stream(conversion, wanted[conversion.formatter], dialect)
                for message in set(conversion.messages):
                    streams[message].append(stream)
        self._ways = {message: (hear, streams[message]) for message, hear in HEAR.items()}

    def receive(self, message: Message, source: int, now: float) -> tuple[list[Effect], bool]:
        """Hear `message` from `source` and say what it brings about; and whether it was taken.

        Runs once a message, so it is written for speed.
        """
        truth = self._truth
        hear, streams = self._ways[type(message)]
        effects: list[Effect] = []
        if not hear(truth, message, source, now):
            return effects, False
        for stream in streams:
            if now < stream.opens:
                continue
            try:
                say = stream.say(truth, message, now)
            except EncodeError as error:
                effects.append(Rejected(str(error), source=f"{type(message).__name__} from {source}"))
            else:
                if say is not None:
                    effects.append(say)
        return effects, True
