"""NMEA 0183 to NMEA 2000: what the sentences of instruments tell, as messages; the inverse of `conversion`.

`READINGS` is the table: each sentence and the function that makes messages of it. The functions keep to this:

* What is empty is not available, and what is marked invalid (status V, mode N, quality 0) is not told: no position is
  ever 0, 0 for want of one. Where the bus must learn at once that there is none any more, it is told as not available.
* Signs and references are those of the sentence. No variation is applied, no reference assumed: HDM stays magnetic, and
  the bearings of a leg are counted from what APB says.
* An estimated, manual or simulated position goes into 129029 alone, which can say so; 129025 cannot.
* What one port tells in several sentences is taken from the best: HDG before HDM, THS before HDT, DPT before DBT, GGA
  before RMC for 129029, XTE before APB before RMB for the cross-track error.
* What goes together (date and time, the halves of a leg) is joined only while it is young.
* The variation that RMC tells is not made 127258: most senders compute it, and so do we.
"""

from collections.abc import Callable, Mapping
from datetime import date
from math import radians
from typing import Any

import msgspec

from timonel.core.message import Message
from timonel.core.pace import Pace
from timonel.nmea0183 import sentences as s
from timonel.nmea0183.fields import VALID_MODES
from timonel.nmea0183.sentence import Sentence
from timonel.nmea2000 import registry
from timonel.nmea2000.lookups import GnssMethod, HeadingReference, TemperatureSource, WindReference, XteMode, YesNo
from timonel.nmea2000.messages.environment import Temperature, TemperatureExtendedRange, WindData
from timonel.nmea2000.messages.navigation import (
    CogSogRapidUpdate,
    CrossTrackError,
    DistanceLog,
    GnssPositionData,
    NavigationData,
    NavigationRouteWpInformation,
    PositionRapidUpdate,
    SetDriftRapidUpdate,
    Speed,
    SystemTime,
    WaterDepth,
    Waypoint,
)
from timonel.nmea2000.messages.steering import Attitude, RateOfTurn, Rudder, VesselHeading
from timonel.vehicles.boat.conversion import (
    EPOCH,
    FATHOM,
    FOOT,
    KNOT,
    MILE,
    MINUTE,
    MODES,
    QUALITIES,
    XTE_MODES,
    ZERO_CELSIUS,
)
from timonel.vehicles.boat.truth import NEVER, Datum

METHODS = {mode: method for method, mode in MODES.items()}
QUALITY_METHODS = {quality: method for method, quality in QUALITIES.items()}
XTE_MODES_READ: dict[s.Mode, XteMode] = {mode: code for code, mode in XTE_MODES.items()}
SPEEDS = {
    s.SpeedUnit.KNOTS: KNOT,
    s.SpeedUnit.METRES_A_SECOND: 1.0,
    s.SpeedUnit.KILOMETRES_AN_HOUR: 1 / 3.6,
    s.SpeedUnit.STATUTE_MILES_AN_HOUR: 1609.344 / 3600,
}
WINDS = {s.WindReference.RELATIVE: WindReference.APPARENT, s.WindReference.THEORETICAL: WindReference.TRUE_BOAT}
REFERENCES = {s.Reference.TRUE: HeadingReference.TRUE, s.Reference.MAGNETIC: HeadingReference.MAGNETIC}
PITCHES, ROLLS = ("PITCH", "PTCH"), ("ROLL",)

FULL_CIRCLE = 6.28315  # rad: what is more rounds to a full turn in steps of 1e-4, which is none
LAST_SID = 252
TOGETHER = 3.0  # s that what belongs together may lie apart, and that a better sentence is waited for
DATE_AGE = 10.0  # s that a date may stand beside a time of day
HALF_A_DAY = 43200.0  # s
FARTHEST = 9.99  # nm: RMB tells no cross-track error above it
ROUTE_INTERVAL = 5.0  # s between two messages of the same waypoints
FIRST_NUMBER = 60_001  # of a waypoint that has a name and no number
MOST_NUMBERS = 1000  # waypoints that are numbered; then it begins anew
HIGHEST_NUMBER = 0xFFFFFFFC

Messages = tuple[Message, ...]


def rad(degrees: float | None) -> float | None:
    """Signed rad of degrees, None of None."""
    return None if degrees is None else radians(degrees)


def turn(degrees: float | None) -> float | None:
    """A direction in rad, 0 up to a full turn."""
    if degrees is None:
        return None
    angle = radians(degrees % 360.0)
    return 0.0 if angle >= FULL_CIRCLE else angle


def times(value: float | None, unit: float) -> float | None:
    """`value` units in SI, None of None."""
    return None if value is None else value * unit


def speed(knots: float | None, kilometres_an_hour: float | None) -> float | None:
    """m/s of the one that is told."""
    return times(knots, KNOT) if knots is not None else times(kilometres_an_hour, 1 / 3.6)


def answer(told: bool | None) -> YesNo | None:
    """Of A and V."""
    return None if told is None else YesNo.YES if told else YesNo.NO


class Talk:
    """What one port has told that goes together with what it will tell."""

    def __init__(self, depth_offset: float | None, numbers: "Numbers") -> None:
        self.depth_offset = depth_offset
        self.numbers = numbers
        self.day: Datum[tuple[int, float]] = Datum(DATE_AGE)
        self.apb: Datum[s.APB] = Datum(TOGETHER)
        self.rmb: Datum[s.RMB] = Datum(TOGETHER)
        self.had_fix = False
        self._best: dict[str, Datum[None]] = {}
        self._sid = LAST_SID
        self._second: float | None = None
        self._route: tuple[Waypoint, ...] = ()
        self._route_told = NEVER

    def prefers(self, what: str, now: float, rank: int) -> bool:
        """Whether no better sentence has told `what` of late; a lower `rank` is better."""
        best = self._best.get(what)
        if best is None:
            best = self._best[what] = Datum(TOGETHER)
        return best.offer(None, now, 0, rank)

    def fix_is_news(self, found: bool) -> bool:
        """Whether a fix, or that there is none, is worth telling: who never had one has nothing to take back."""
        self.had_fix = self.had_fix or found
        return self.had_fix

    def sid(self) -> int:
        """The next sequence identifier: what has the same one was measured at the same time."""
        self._sid = 0 if self._sid >= LAST_SID else self._sid + 1
        return self._sid

    def sid_at(self, second: float | None) -> int:
        """That of the fix of this time of day; without one, that of the last fix."""
        if second is None or second == self._second:
            return self._sid if self._second is not None else self.sid()
        self._second = second
        return self.sid()

    def told_day(self, day: date | None, second: float | None, now: float) -> int | None:
        """Days since 1970 of a date that was told with a time of day."""
        if day is None or second is None:
            return None
        number = (day - EPOCH).days
        self.day.offer((number, second), now, 0)
        return number

    def day_of(self, second: float | None, now: float) -> int | None:
        """The day to which a time of day belongs that was told without a date: midnight may lie between."""
        told = self.day.at(now, DATE_AGE)
        if told is None or second is None:
            return None
        day, then = told
        return day + (second < then - HALF_A_DAY) - (second > then + HALF_A_DAY)

    def route(self, waypoints: tuple[Waypoint, ...], now: float) -> Messages:
        """129285 where it is news, or was told a while ago."""
        if not waypoints or (waypoints == self._route and now - self._route_told < ROUTE_INTERVAL):
            return ()
        self._route, self._route_told = waypoints, now
        return (
            NavigationRouteWpInformation(
                start_rps=0,
                nitems=len(waypoints),
                database_id=None,
                route_id=None,
                navigation_direction_in_route=None,
                supplementary_route_wp_data_available=None,
                route_name=None,
                waypoints=waypoints,
            ),
        )


class Numbers:
    """Numbers for waypoints that have names: the bus knows them by number."""

    def __init__(self) -> None:
        self._by_name: dict[str, int] = {}

    def of(self, name: str | None) -> int | None:
        """A name that is a number is that number."""
        if name is None:
            return None
        if name.isascii() and name.isdigit() and int(name) <= HIGHEST_NUMBER:
            return int(name)
        if name not in self._by_name and len(self._by_name) >= MOST_NUMBERS:
            self._by_name.clear()
        return self._by_name.setdefault(name, FIRST_NUMBER + len(self._by_name))


# Heading ----------------------------------------------------------------------------------------

NO_HEADING = VesselHeading(sid=None, heading=None, deviation=None, variation=None, reference=HeadingReference.TRUE)


def _heading(talk: Talk, angle: float | None, reference: HeadingReference) -> Messages:
    if angle is None:
        return ()
    return (VesselHeading(sid=talk.sid(), heading=turn(angle), deviation=None, variation=None, reference=reference),)


def hdt(talk: Talk, sentence: s.HDT, now: float) -> Messages:
    return _heading(talk, sentence.heading_deg, HeadingReference.TRUE) if talk.prefers("true", now, 1) else ()


def ths(talk: Talk, sentence: s.THS, now: float) -> Messages:
    """Only a heading that was measured: 127250 cannot say that one is estimated or simulated."""
    talk.prefers("true", now, 0)
    measured = sentence.mode is s.HeadingMode.AUTONOMOUS
    return _heading(talk, sentence.heading_deg, HeadingReference.TRUE) if measured else (NO_HEADING,)


def hdm(talk: Talk, sentence: s.HDM, now: float) -> Messages:
    wanted = talk.prefers("magnetic", now, 1)
    return _heading(talk, sentence.magnetic_heading_deg, HeadingReference.MAGNETIC) if wanted else ()


def hdg(talk: Talk, sentence: s.HDG, now: float) -> Messages:
    """The compass as it reads, with what makes its heading magnetic and true."""
    talk.prefers("magnetic", now, 0)
    if sentence.heading_deg is None:
        return ()
    return (
        VesselHeading(
            sid=talk.sid(),
            heading=turn(sentence.heading_deg),
            deviation=rad(sentence.deviation_deg),
            variation=rad(sentence.variation_deg),
            reference=HeadingReference.MAGNETIC,
        ),
    )


def rot(talk: Talk, sentence: s.ROT, now: float) -> Messages:
    if sentence.rate_deg_min is None or sentence.valid is not True:
        return ()
    return (RateOfTurn(sid=talk.sid(), rate=radians(sentence.rate_deg_min) / MINUTE),)


def xdr(talk: Talk, sentence: s.XDR, now: float) -> Messages:
    angles = {t.name.upper(): t.value for t in sentence.transducers if (t.kind, t.unit) == ("A", "D") and t.name}
    pitch, roll = (next((angles[n] for n in names if n in angles), None) for names in (PITCHES, ROLLS))
    if pitch is None and roll is None:
        return ()
    return (Attitude(sid=talk.sid(), yaw=None, pitch=rad(pitch), roll=rad(roll)),)


def rsa(talk: Talk, sentence: s.RSA, now: float) -> Messages:
    """A single rudder is the starboard one, instance 0; the port one is instance 1."""
    rudders = (sentence.starboard_deg, sentence.starboard_valid), (sentence.port_deg, sentence.port_valid)
    return tuple(
        Rudder(instance=instance, direction_order=None, angle_order=None, position=radians(angle))
        for instance, (angle, valid) in enumerate(rudders)
        if angle is not None and valid is True
    )


# Water ------------------------------------------------------------------------------------------


def vhw(talk: Talk, sentence: s.VHW, now: float) -> Messages:
    """The speed; its headings are somebody else's."""
    told = speed(sentence.speed_kn, sentence.speed_kmh)
    if told is None:
        return ()
    return (
        Speed(
            sid=talk.sid(),
            speed_water_referenced=told,
            speed_ground_referenced=None,
            speed_water_referenced_type=None,
            speed_direction=None,
        ),
    )


def vlw(talk: Talk, sentence: s.VLW, now: float) -> Messages:
    total, trip = (None if nm is None else round(nm * MILE) for nm in (sentence.total_nm, sentence.trip_nm))
    return () if total is None and trip is None else (DistanceLog(date=None, time=None, log=total, trip_log=trip),)


def _depth(talk: Talk, depth: float | None, offset: float | None, farthest: float | None = None) -> Messages:
    if depth is None:
        return ()
    reach = None if farthest is None else round(farthest)
    return (WaterDepth(sid=talk.sid(), depth=depth, offset=offset, range=reach),)


def dpt(talk: Talk, sentence: s.DPT, now: float) -> Messages:
    talk.prefers("depth", now, 0)
    return _depth(talk, sentence.depth_m, sentence.offset_m, sentence.range_m)


def metres(sentence: s.DBT | s.DBS | s.DBK) -> float | None:
    """The depth in the unit that is told, the finest first."""
    if sentence.depth_m is not None:
        return sentence.depth_m
    if sentence.depth_ft is not None:
        return sentence.depth_ft * FOOT
    return times(sentence.depth_fathoms, FATHOM)


def dbt(talk: Talk, sentence: s.DBT, now: float) -> Messages:
    return _depth(talk, metres(sentence), None) if talk.prefers("depth", now, 1) else ()


def dbs(talk: Talk, sentence: s.DBS, now: float) -> Messages:
    """Below the surface: by the known height of the surface above the transducer, else from a transducer in it."""
    depth = metres(sentence)
    if depth is None or not talk.prefers("depth", now, 2):
        return ()
    offset = max(talk.depth_offset or 0.0, 0.0)
    return _depth(talk, depth - offset, offset) if depth >= offset else ()


def dbk(talk: Talk, sentence: s.DBK, now: float) -> Messages:
    """Below the keel, where it is known how far below the transducer that is: else it can not be told."""
    depth, offset = metres(sentence), talk.depth_offset
    if depth is None or offset is None or offset >= 0 or not talk.prefers("depth", now, 3):
        return ()
    return _depth(talk, depth - offset, offset)


def mtw(talk: Talk, sentence: s.MTW, now: float) -> Messages:
    if sentence.temperature_c is None:
        return ()
    sid, kelvin, sea = talk.sid(), sentence.temperature_c + ZERO_CELSIUS, TemperatureSource.SEA
    return (
        TemperatureExtendedRange(sid=sid, instance=0, source=sea, temperature=kelvin, set_temperature=None),
        Temperature(sid=sid, instance=0, source=sea, actual_temperature=kelvin, set_temperature=None),
    )


def vdr(talk: Talk, sentence: s.VDR, now: float) -> Messages:
    direction, reference = _one_of(sentence.set_deg, sentence.magnetic_set_deg)
    if direction is None and sentence.drift_kn is None:
        return ()
    return (
        SetDriftRapidUpdate(
            sid=talk.sid(), set_reference=reference, set=turn(direction), drift=times(sentence.drift_kn, KNOT)
        ),
    )


def _one_of(true: float | None, magnetic: float | None) -> tuple[float | None, HeadingReference]:
    """The true direction if it is told, else the magnetic one."""
    if true is None and magnetic is not None:
        return magnetic, HeadingReference.MAGNETIC
    return true, HeadingReference.TRUE


# Position ---------------------------------------------------------------------------------------

NO_POSITION = PositionRapidUpdate(latitude=None, longitude=None)
"""There is none any more: for ourselves, not for the bus, which 129029 tells it."""


def gll(talk: Talk, sentence: s.GLL, now: float) -> Messages:
    if sentence.valid is False:
        return (NO_POSITION,)
    return _position(sentence.latitude_deg, sentence.longitude_deg)


def _position(latitude: float | None, longitude: float | None) -> Messages:
    if latitude is None or longitude is None:
        return ()
    return (PositionRapidUpdate(latitude=latitude, longitude=longitude),)


def gga(talk: Talk, sentence: s.GGA, now: float) -> Messages:
    talk.prefers("fix", now, 0)
    method = GnssMethod.NONE if sentence.quality is None else QUALITY_METHODS.get(sentence.quality, GnssMethod.NONE)
    found = method is not GnssMethod.NONE
    if not talk.fix_is_news(found):
        return ()
    fix = GnssPositionData(
        sid=talk.sid_at(sentence.time),
        date=talk.day_of(sentence.time, now),
        time=sentence.time,
        latitude=sentence.latitude_deg if found else None,
        longitude=sentence.longitude_deg if found else None,
        altitude=sentence.altitude_m if found else None,
        method=method,
        number_of_svs=sentence.satellites,
        hdop=sentence.hdop if found else None,
        geoidal_separation=sentence.geoid_m if found else None,
        reference_stations=0,
    )
    measured = MODES[method] in VALID_MODES
    return (fix, *_position(sentence.latitude_deg, sentence.longitude_deg)) if measured else (fix,)


def rmc(talk: Talk, sentence: s.RMC, now: float) -> Messages:
    """Time, position, course and speed. The time of a receiver without a fix counts too: its date tells whether."""
    sid, day = talk.sid_at(sentence.time), talk.told_day(sentence.date, sentence.time, now)
    messages: Messages = ()
    if day is not None:
        messages += (SystemTime(sid=sid, source=None, date=day, time=sentence.time),)
    fix = _fix(sentence, sid, day)
    if talk.prefers("fix", now, 1) and talk.fix_is_news(fix.method is not GnssMethod.NONE):
        messages += (fix,)
    if sentence.valid is not True:
        return (*messages, NO_POSITION)
    position = _position(sentence.latitude_deg, sentence.longitude_deg)
    return messages + position + _course(sid, sentence.course_deg, None, times(sentence.speed_kn, KNOT))


def _fix(sentence: s.RMC, sid: int, day: int | None) -> GnssPositionData:
    mode = s.Mode.AUTONOMOUS if sentence.mode is None else sentence.mode
    method = METHODS[mode] if sentence.valid or mode not in VALID_MODES else GnssMethod.NONE
    found = method is not GnssMethod.NONE
    return GnssPositionData(
        sid=sid,
        date=day,
        time=sentence.time,
        latitude=sentence.latitude_deg if found else None,
        longitude=sentence.longitude_deg if found else None,
        method=method,
        reference_stations=0,
    )


def vtg(talk: Talk, sentence: s.VTG, now: float) -> Messages:
    if sentence.mode not in VALID_MODES:
        return ()
    over_ground = speed(sentence.speed_kn, sentence.speed_kmh)
    return _course(talk.sid_at(None), sentence.course_deg, sentence.magnetic_course_deg, over_ground)


def _course(sid: int, true: float | None, magnetic: float | None, over_ground: float | None) -> Messages:
    course, reference = _one_of(true, magnetic)
    if course is None and over_ground is None:
        return ()
    return (CogSogRapidUpdate(sid=sid, cog_reference=reference, cog=turn(course), sog=over_ground),)


def zda(talk: Talk, sentence: s.ZDA, now: float) -> Messages:
    day = talk.told_day(_date(sentence), sentence.time, now)
    if day is None:
        return ()
    return (SystemTime(sid=talk.sid_at(sentence.time), source=None, date=day, time=sentence.time),)


def _date(sentence: s.ZDA) -> date | None:
    """None for what is no date: before the first fix some tell the 31st of February."""
    if sentence.year is None or sentence.month is None or sentence.day is None:
        return None
    try:
        return date(sentence.year, sentence.month, sentence.day)
    except ValueError:
        return None


# Wind -------------------------------------------------------------------------------------------


def mwv(talk: Talk, sentence: s.MWV, now: float) -> Messages:
    if sentence.valid is not True or sentence.reference is None:
        return ()
    unit = None if sentence.unit is None else SPEEDS[sentence.unit]
    told = None if unit is None else times(sentence.speed, unit)
    return _wind(talk, sentence.angle_deg, told, WINDS[sentence.reference])


def mwd(talk: Talk, sentence: s.MWD, now: float) -> Messages:
    direction, north = _one_of(sentence.direction_deg, sentence.magnetic_direction_deg)
    reference = WindReference.TRUE_NORTH if north is HeadingReference.TRUE else WindReference.MAGNETIC_NORTH
    told = sentence.speed_ms if sentence.speed_ms is not None else times(sentence.speed_kn, KNOT)
    return _wind(talk, direction, told, reference)


def _wind(talk: Talk, angle: float | None, told: float | None, reference: WindReference) -> Messages:
    if angle is None and told is None:
        return ()
    return (WindData(sid=talk.sid(), wind_speed=told, wind_angle=turn(angle), reference=reference),)


# Route ------------------------------------------------------------------------------------------

GUESSED = frozenset({s.Mode.ESTIMATED, s.Mode.MANUAL, s.Mode.SIMULATOR})
"""Modes whose status must be V although there is a value, which 129283 can tell for what it is."""


def _leg(talk: Talk, error_nm: float | None, valid: bool, mode: s.Mode | None) -> Messages:
    told = error_nm if valid or mode in GUESSED else None
    known = None if mode is None else XTE_MODES_READ.get(mode)
    return (CrossTrackError(sid=talk.sid(), xte_mode=known, navigation_terminated=None, xte=times(told, MILE)),)


def xte(talk: Talk, sentence: s.XTE, now: float) -> Messages:
    talk.prefers("leg", now, 0)
    return _leg(talk, sentence.cross_track_error_nm, bool(sentence.valid and sentence.locked), sentence.mode)


def apb(talk: Talk, sentence: s.APB, now: float) -> Messages:
    """With the RMB of the same time one message; alone what it tells."""
    valid = bool(sentence.valid and sentence.locked)
    messages: Messages = ()
    if talk.prefers("leg", now, 1):
        messages = _leg(talk, sentence.cross_track_error_nm, valid, sentence.mode)
    if not valid and sentence.mode not in GUESSED:
        talk.apb.withdraw(0)
        return messages
    talk.apb.offer(sentence, now, 0)
    return messages if talk.rmb.at(now, TOGETHER) else messages + _navigation(talk, None, sentence, now)


def rmb(talk: Talk, sentence: s.RMB, now: float) -> Messages:
    messages: Messages = ()
    if talk.prefers("leg", now, 2):
        error = sentence.cross_track_error_nm
        messages = _leg(
            talk,
            None if error is None or abs(error) >= FARTHEST else error,
            sentence.valid is True,
            sentence.mode,
        )
    if sentence.valid is not True and sentence.mode not in GUESSED:
        talk.rmb.withdraw(0)
        return messages
    talk.rmb.offer(sentence, now, 0)
    return messages + _navigation(talk, sentence, talk.apb.at(now, TOGETHER), now)


def _navigation(talk: Talk, rmb: s.RMB | None, apb: s.APB | None, now: float) -> Messages:
    """129284 and the names of its waypoints. One reference holds for both bearings; one in another is left out."""
    to_steer, leg, reference = _bearings(rmb, apb)
    origin, destination = _ends(rmb, apb)
    numbers = talk.numbers
    latitude, longitude = (None, None) if rmb is None else (rmb.latitude_deg, rmb.longitude_deg)
    data = NavigationData(
        sid=talk.sid(),
        distance_to_waypoint=None if rmb is None else times(rmb.range_nm, MILE),
        course_bearing_reference=reference,
        perpendicular_crossed=None if apb is None else answer(apb.perpendicular_passed),
        arrival_circle_entered=answer(rmb.arrived if apb is None and rmb is not None else apb.arrived if apb else None),
        bearing_origin_to_destination_waypoint=turn(leg),
        bearing_position_to_destination_waypoint=turn(to_steer),
        origin_waypoint_number=numbers.of(origin),
        destination_waypoint_number=numbers.of(destination),
        destination_latitude=latitude,
        destination_longitude=longitude,
        waypoint_closing_velocity=None if rmb is None else times(rmb.closing_speed_kn, KNOT),
    )
    places = ((origin, None, None), (destination, latitude, longitude))
    waypoints = tuple(
        Waypoint(wp_id=numbers.of(name), wp_name=name, wp_latitude=north, wp_longitude=east)
        for name, north, east in places
        if name is not None and not name.isdigit()
    )
    return (data, *talk.route(waypoints, now))


def _bearings(rmb: s.RMB | None, apb: s.APB | None) -> tuple[float | None, float | None, HeadingReference | None]:
    """From here to the destination, from origin to destination, and the reference of both."""
    if apb is None or apb.bearing_deg is None or apb.bearing_reference is None:
        true = None if rmb is None else rmb.bearing_deg
        leg = None if apb is None or apb.leg_bearing_reference is not s.Reference.TRUE else apb.leg_bearing_deg
        return true, leg, HeadingReference.TRUE
    leg = apb.leg_bearing_deg if apb.leg_bearing_reference is apb.bearing_reference else None
    return apb.bearing_deg, leg, REFERENCES[apb.bearing_reference]


def _ends(rmb: s.RMB | None, apb: s.APB | None) -> tuple[str | None, str | None]:
    """Origin and destination. Where APB tells the destination, an RMB that has them the other way round is seen."""
    destination = None if apb is None else apb.destination
    if rmb is None:
        return None, destination
    if destination is not None and rmb.origin == destination != rmb.destination:
        return rmb.destination, destination
    return rmb.origin, rmb.destination if rmb.destination is not None else destination


# The table --------------------------------------------------------------------------------------

Read = Callable[[Talk, Any, float], Messages]


class Reading(msgspec.Struct, frozen=True):
    """One line of the table: a function of what the port told before, the sentence and the time, and what it makes."""

    read: Read
    messages: tuple[type[Message], ...]


HEADING = (VesselHeading,)
DEPTH = (WaterDepth,)
WAY = (CrossTrackError, NavigationData, NavigationRouteWpInformation)
READINGS: dict[type[Sentence], Reading] = {
    s.HDT: Reading(hdt, HEADING),
    s.THS: Reading(ths, HEADING),
    s.HDG: Reading(hdg, HEADING),
    s.HDM: Reading(hdm, HEADING),
    s.ROT: Reading(rot, (RateOfTurn,)),
    s.RSA: Reading(rsa, (Rudder,)),
    s.XDR: Reading(xdr, (Attitude,)),
    s.VHW: Reading(vhw, (Speed,)),
    s.VLW: Reading(vlw, (DistanceLog,)),
    s.DPT: Reading(dpt, DEPTH),
    s.DBT: Reading(dbt, DEPTH),
    s.DBS: Reading(dbs, DEPTH),
    s.DBK: Reading(dbk, DEPTH),
    s.MTW: Reading(mtw, (TemperatureExtendedRange, Temperature)),
    s.VDR: Reading(vdr, (SetDriftRapidUpdate,)),
    s.GLL: Reading(gll, (PositionRapidUpdate,)),
    s.GGA: Reading(gga, (GnssPositionData, PositionRapidUpdate)),
    s.RMC: Reading(rmc, (SystemTime, GnssPositionData, PositionRapidUpdate, CogSogRapidUpdate)),
    s.VTG: Reading(vtg, (CogSogRapidUpdate,)),
    s.ZDA: Reading(zda, (SystemTime,)),
    s.MWV: Reading(mwv, (WindData,)),
    s.MWD: Reading(mwd, (WindData,)),
    s.XTE: Reading(xte, (CrossTrackError,)),
    s.APB: Reading(apb, WAY),
    s.RMB: Reading(rmb, WAY),
}
"""Every sentence that is listened to, and how."""
FORMATTERS = frozenset(sentence.__name__.encode() for sentence in READINGS)


class Instruments:
    """The instruments' ports, and what they tell. `depth_offsets` are those that the owner knows, m, by port."""

    def __init__(self, depth_offsets: Mapping[str, float | None] | None = None) -> None:
        self._depth_offsets = depth_offsets or {}
        self._talks: dict[str, Talk] = {}
        self._numbers = Numbers()

    def receive(self, sentence: Sentence, port: str, now: float) -> Messages:
        """What a sentence tells that came in at `port`; nothing of one that is not in the table."""
        reading = READINGS.get(type(sentence))
        if reading is None:
            return ()
        talk = self._talks.get(port)
        if talk is None:
            talk = self._talks[port] = Talk(self._depth_offsets.get(port), self._numbers)
        return reading.read(talk, sentence, now)


VARIANTS: dict[type[Message], str] = {
    VesselHeading: "reference",
    WindData: "reference",
    Rudder: "instance",
    Temperature: "source",
    TemperatureExtendedRange: "source",
}
"""The field that tells streams of one PGN apart."""


class Ceilings:
    """How often messages go out on the bus: as often as their PGN is sent by the book, and no more."""

    def __init__(self) -> None:
        self._paces: dict[tuple[int, object], Pace] = {}

    def allow(self, message: Message, now: float) -> bool:
        """Whether `message` may go out now."""
        pgn = message.PGN
        interval = None if pgn is None else registry.interval(pgn)
        if pgn is None or interval is None:
            return True
        field = VARIANTS.get(type(message))
        key = pgn, None if field is None else getattr(message, field)
        pace = self._paces.get(key)
        if pace is None:
            pace = self._paces[key] = Pace(interval)
        if not pace.open(now):
            return False
        pace.count(now)
        return True
