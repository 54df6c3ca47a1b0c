"""What is known about the boat: one value of each kind, from the best source that is alive.

Several devices may tell the same thing, some of them nonsense. A datum keeps to one source while that one
tells something valid; a source of better rank takes over at once, any other when the present one has been
silent for `hold` seconds or takes back what it told (a heading that is not available, a fix that is lost). A
value older than the boat's age limit is no value. All values are in SI.

true = magnetic + variation, magnetic = compass + deviation, east positive.
"""

from collections.abc import Callable
from math import inf, tau
from typing import Any, Generic, TypeVar

import msgspec

from timonel.nmea2000.lookups import GnssMethod, HeadingReference, TemperatureSource, WindReference
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
    SetDriftRapidUpdate,
    Speed,
    SystemTime,
    TimeDate,
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

T = TypeVar("T")

Angle = float | None
VariationModel = Callable[[float, float, float], float]
"""Variation in rad at latitude and longitude (deg) and time (unix s)."""

FAST = 1.0  # s: ten periods of what comes at 10 Hz
SLOW = 2.0  # s: two periods of what comes at 1 Hz, so that another source is heard before the age limit
SECONDS_A_DAY = 86400
FIRST_DAY = 10957  # 2000-01-01: no NMEA 2000 device is older, but many say 1970 before they have a fix
MOST_WAYPOINTS = 1000  # names kept; a route has fewer
TIME_AGE = 2.0  # s that a clock reading may be used for a position
NEVER = float("-inf")
LOST = 1 << 12
"""Ranks from here on are of sources that say themselves that they have nothing: a receiver without a fix."""

WINDS = {
    WindReference.APPARENT: (WindReference.APPARENT, 0),
    WindReference.TRUE_WATER: (WindReference.TRUE_WATER, 0),
    WindReference.TRUE_BOAT: (WindReference.TRUE_WATER, 2),
    WindReference.TRUE_NORTH: (WindReference.TRUE_NORTH, 0),
    WindReference.MAGNETIC_NORTH: (WindReference.TRUE_NORTH, 2),
}
"""Which wind a reference tells of, and its rank: one is felt, one is against the water, one has a direction."""
WIND_NAMES: dict[int, str] = {
    WindReference.APPARENT: "apparent",
    WindReference.TRUE_WATER: "true",
    WindReference.TRUE_NORTH: "ground",
}


class Datum(Generic[T]):
    """The latest value of one kind and who told it."""

    __slots__ = ("_heard", "_hold", "_rank", "_source", "value")

    def __init__(self, hold: float) -> None:
        self._hold = hold
        self._source = -1
        self._rank = 0
        self._heard = NEVER
        self.value: T | None = None

    def offer(self, value: T, now: float, source: int, rank: int = 0) -> bool:
        """Take `value` if `source` is the one to listen to; a lower `rank` is a better source.

        A device that tells the same thing in several ways has a rank for each.
        """
        if rank >= self._rank and (source != self._source or rank > self._rank) and now - self._heard < self._hold:
            return False
        self._source, self._rank = source, rank
        self.value = value
        self._heard = now
        return True

    @property
    def heard(self) -> float:
        """When the value was told, s; minus infinity if there is none, or it was taken back."""
        return self._heard

    @property
    def source(self) -> int:
        """Who told it: an address on the bus, or more than that (`sources`); -1 if nobody has."""
        return self._source

    def told_by(self, source: int, now: float) -> bool:
        """Whether `source` told the value at `now`, and not for want of a better one (`LOST`)."""
        return source == self._source and now == self._heard and self._rank < LOST

    def withdraw(self, source: int) -> None:
        """`source` takes back what it told: there is no value, and whoever speaks next is heard."""
        if source == self._source:
            self._heard = NEVER

    def at(self, now: float, age: float) -> T | None:
        """The value if it is younger than `age` seconds."""
        return self.value if now - self._heard < age else None


class Heading(msgspec.Struct, frozen=True, gc=False):
    """Where the bow points, 0..2 pi, and the message that told it."""

    angle: float
    message: VesselHeading


class Clock:
    """UTC as the bus tells it: days since 1970 and seconds of the day."""

    __slots__ = ("day", "second")

    def __init__(self, day: int, second: float) -> None:
        self.day = day
        self.second = second

    @property
    def unix(self) -> float:
        """Seconds since 1970."""
        return self.day * SECONDS_A_DAY + self.second


NewDatum = Callable[[str, float], Datum[Any]]
"""Makes the datum of a name, and of a time that its source may be silent (s)."""


def plain(name: str, hold: float) -> Datum[Any]:
    """A datum whose sources are all alike."""
    return Datum(hold)


class Truth:
    """Everything known, by message; each `hear_` method returns whether the message was taken.

    A position whose HDOP is above `hdop_limit` counts as one without a fix.
    """

    def __init__(
        self,
        age: float,
        variation_model: VariationModel | None = None,
        datum: NewDatum = plain,
        hdop_limit: float | None = None,
    ) -> None:
        self._age = age
        self._model = variation_model
        self._modelled: tuple[tuple[int, int, int], float] | None = None
        self._datum = datum
        self._hdop_limit = inf if hdop_limit is None else hdop_limit
        self.true: Datum[Heading] = datum("true heading", FAST)
        self.magnetic: Datum[Heading] = datum("magnetic heading", FAST)
        self.told_variation: Datum[float] = datum("variation", SLOW)
        self.rate: Datum[RateOfTurn] = datum("rate of turn", FAST)
        self.attitude: Datum[Attitude] = datum("attitude", SLOW)
        self.rudder: Datum[float] = datum("rudder", FAST)
        self.position: Datum[tuple[float, float]] = datum("position", FAST)
        self.fix: Datum[GnssPositionData] = datum("fix", SLOW)
        self.course: Datum[CogSogRapidUpdate] = datum("course", FAST)
        self.clock: Datum[Clock] = datum("time", FAST)  # half of `TIME_AGE`
        self.speed: Datum[Speed] = datum("speed", SLOW)
        self.depth: Datum[WaterDepth] = datum("depth", SLOW)
        self.log: Datum[DistanceLog] = datum("log", SLOW)
        self.current: Datum[SetDriftRapidUpdate] = datum("current", SLOW)
        self.pilot: Datum[HeadingTrackControl] = Datum(SLOW)
        self.navigation: Datum[NavigationData] = datum("navigation", SLOW)
        self.cross_track: Datum[CrossTrackError] = datum("cross track", SLOW)
        self.waypoint_names: dict[int, str] = {}
        self.sea_temperature: Datum[float] = datum("water temperature", 2 * SLOW)  # 130312, 130316 come every 2 s
        self.winds: dict[int, Datum[WindData]] = {}
        self._without_fix: set[int] = set()

    # Hearing --------------------------------------------------------------------------------------

    def hear_heading(self, message: VesselHeading, source: int, now: float) -> bool:
        """127250. A heading without a reference, or with one in error, is no heading.

        One compass serves both headings where its variation is known, but never takes the place of one that
        tells what is asked for.
        """
        heading, variation = message.heading, message.variation
        if variation is None:
            if self._model is not None or now - self.told_variation._heard < self._age:
                variation = self.variation(now)
        else:
            self.told_variation.offer(variation, now, source, rank=1)
        if heading is None:
            self.true.withdraw(source)
            self.magnetic.withdraw(source)
            return False
        match message.reference:
            case HeadingReference.TRUE:
                taken = self.true.offer(Heading(heading % tau, message), now, source)
                if variation is not None:
                    taken |= self.magnetic.offer(Heading((heading - variation) % tau, message), now, source, rank=1)
                return taken
            case HeadingReference.MAGNETIC:
                # A compass that tells no deviation has none left: it corrects itself.
                magnetic = heading + (message.deviation or 0.0)
                taken = self.magnetic.offer(Heading(magnetic % tau, message), now, source)
                if variation is not None:
                    taken |= self.true.offer(Heading((magnetic + variation) % tau, message), now, source, rank=1)
                return taken
        return False

    def hear_rate(self, message: RateOfTurn, source: int, now: float) -> bool:
        """127251."""
        return message.rate is not None and self.rate.offer(message, now, source)

    def hear_attitude(self, message: Attitude, source: int, now: float) -> bool:
        """127257."""
        told = message.pitch is not None or message.roll is not None
        return told and self.attitude.offer(message, now, source)

    def hear_variation(self, message: MagneticVariation, source: int, now: float) -> bool:
        """127258."""
        return message.variation is not None and self.told_variation.offer(message.variation, now, source)

    def hear_rudder(self, message: Rudder, source: int, now: float) -> bool:
        """127245: the rudder itself, before any order to it. Some send position and order in messages of their own.

        Of two rudders it is the first one, or the starboard one: instance 0, or what has no number.
        """
        rank = 1 if message.instance == 1 else 0
        return message.position is not None and self.rudder.offer(message.position, now, source, rank)

    def hear_pilot(self, message: HeadingTrackControl, source: int, now: float) -> bool:
        """127237: its rudder order stands in for a rudder that nobody measures (spec/boat.md)."""
        if message.commanded_rudder_angle is not None:
            self.rudder.offer(message.commanded_rudder_angle, now, source, rank=2)
        return self.pilot.offer(message, now, source)

    def hear_speed(self, message: Speed, source: int, now: float) -> bool:
        """128259."""
        return message.speed_water_referenced is not None and self.speed.offer(message, now, source)

    def hear_depth(self, message: WaterDepth, source: int, now: float) -> bool:
        """128267."""
        return message.depth is not None and self.depth.offer(message, now, source)

    def hear_log(self, message: DistanceLog, source: int, now: float) -> bool:
        """128275."""
        told = message.log is not None or message.trip_log is not None
        return told and self.log.offer(message, now, source)

    def hear_current(self, message: SetDriftRapidUpdate, source: int, now: float) -> bool:
        """129291."""
        told = message.set is not None or message.drift is not None
        return told and self.current.offer(message, now, source)

    def hear_position(self, message: PositionRapidUpdate, source: int, now: float) -> bool:
        """129025. Of a receiver that says to have no fix, a position is the last resort."""
        if message.latitude is None or message.longitude is None:
            self.position.withdraw(source)
            return False
        rank = LOST if source in self._without_fix else 0
        return self.position.offer((message.latitude, message.longitude), now, source, rank)

    def hear_fix(self, message: GnssPositionData, source: int, now: float) -> bool:
        """129029: position, time and how good they are. A lost fix is told at once, unless another has one."""
        latitude, longitude = message.latitude, message.longitude
        vague = message.hdop is not None and message.hdop > self._hdop_limit
        lost = message.method is GnssMethod.NONE or latitude is None or longitude is None or vague
        if lost:
            self._without_fix.add(source)
            self.position.withdraw(source)
            self.fix.withdraw(source)
        else:
            self._without_fix.discard(source)
        if latitude is not None and longitude is not None:
            self.position.offer((latitude, longitude), now, source, rank=LOST + 1 if lost else 1)
        self._hear_clock(message.date, message.time, now, source, rank=0)
        return self.fix.offer(message, now, source, rank=LOST if lost else 0)

    def hear_course(self, message: CogSogRapidUpdate, source: int, now: float) -> bool:
        """129026."""
        if message.cog is None and message.sog is None:
            return False
        return self.course.offer(message, now, source)

    def hear_system_time(self, message: SystemTime, source: int, now: float) -> bool:
        """126992."""
        return self._hear_clock(message.date, message.time, now, source, rank=1)

    def hear_time_date(self, message: TimeDate, source: int, now: float) -> bool:
        """129033."""
        return self._hear_clock(message.date, message.time, now, source, rank=2)

    def _hear_clock(self, day: int | None, second: float | None, now: float, source: int, rank: int) -> bool:
        if day is None or second is None or day < FIRST_DAY:
            return False
        return self.clock.offer(Clock(day, second), now, source, rank)

    def hear_cross_track(self, message: CrossTrackError, source: int, now: float) -> bool:
        """129283. That there is no track to keep any more is told at once, unless another has one."""
        lost = message.xte is None
        if lost:
            self.cross_track.withdraw(source)
        return self.cross_track.offer(message, now, source, rank=LOST if lost else 0)

    def hear_navigation(self, message: NavigationData, source: int, now: float) -> bool:
        """129284."""
        told = (message.bearing_position_to_destination_waypoint, message.distance_to_waypoint) != (None, None)
        return told and self.navigation.offer(message, now, source)

    def hear_route(self, message: NavigationRouteWpInformation, source: int, now: float) -> bool:
        """129285: the names behind the numbers of waypoints."""
        if len(self.waypoint_names) > MOST_WAYPOINTS:
            self.waypoint_names.clear()
        for waypoint in message.waypoints:
            if waypoint.wp_id is not None and waypoint.wp_name is not None:
                self.waypoint_names[waypoint.wp_id] = waypoint.wp_name
        return True

    def hear_wind(self, message: WindData, source: int, now: float) -> bool:
        """130306. One that tells speed and angle is better than one that tells half."""
        if message.reference not in WINDS:
            return False
        wind, rank = WINDS[message.reference]
        told = (message.wind_speed is not None) + (message.wind_angle is not None)
        datum = self.winds.get(wind)
        if datum is None:
            datum = self.winds[wind] = self._datum(f"{WIND_NAMES[wind]} wind", FAST)
        return told > 0 and datum.offer(message, now, source, rank + 2 - told)

    def hear_extended_temperature(self, message: TemperatureExtendedRange, source: int, now: float) -> bool:
        """130316."""
        return self._hear_sea(message.source, message.temperature, now, source, rank=0)

    def hear_temperature(self, message: Temperature, source: int, now: float) -> bool:
        """130312."""
        return self._hear_sea(message.source, message.actual_temperature, now, source, rank=1)

    def hear_environment(self, message: EnvironmentalParameters, source: int, now: float) -> bool:
        """130311."""
        return self._hear_sea(message.temperature_source, message.temperature, now, source, rank=2)

    def hear_old_environment(self, message: EnvironmentalParametersObsolete, source: int, now: float) -> bool:
        """130310."""
        return self._hear_sea(TemperatureSource.SEA, message.water_temperature, now, source, rank=3)

    def _hear_sea(
        self, place: TemperatureSource | None, kelvin: float | None, now: float, source: int, rank: int
    ) -> bool:
        if place is not TemperatureSource.SEA or kelvin is None:
            return False
        return self.sea_temperature.offer(kelvin, now, source, rank)

    # Knowing --------------------------------------------------------------------------------------

    def variation(self, now: float) -> float | None:
        """East positive: as 127258 tells, else as a compass tells, else as the model computes."""
        told = self.told_variation.at(now, self._age)
        return self.model_variation() if told is None else told

    def model_variation(self) -> float | None:
        """At the last known position and date; computed anew after a tenth of a degree or a day."""
        if self._model is None or self.position.value is None or self.clock.value is None:
            return None
        latitude, longitude = self.position.value
        place = (round(latitude * 10), round(longitude * 10), self.clock.value.day)
        if self._modelled is None or self._modelled[0] != place:
            self._modelled = place, self._model(latitude, longitude, self.clock.value.unix)
        return self._modelled[1]

    def magnetic_heading(self, now: float) -> float | None:
        """0..2 pi: from a magnetic compass, else from a true one and the variation."""
        datum = self.magnetic
        return datum.value.angle if now - datum._heard < self._age and datum.value is not None else None

    def true_heading(self, now: float) -> float | None:
        """0..2 pi: as told, else from the magnetic one by its own variation, by 127258, by the model."""
        datum = self.true
        return datum.value.angle if now - datum._heard < self._age and datum.value is not None else None

    def to_true(self, angle: Angle, reference: HeadingReference | None, now: float) -> Angle:
        """A direction counted from `reference` as a true one; None where that cannot be known."""
        if angle is None or reference is HeadingReference.TRUE:
            return angle
        variation = self.variation(now) if reference is HeadingReference.MAGNETIC else None
        return None if variation is None else (angle + variation) % tau

    def to_magnetic(self, angle: Angle, reference: HeadingReference | None, now: float) -> Angle:
        """A direction counted from `reference` as a magnetic one; None where that cannot be known."""
        if angle is None or reference is HeadingReference.MAGNETIC:
            return angle
        variation = self.variation(now) if reference is HeadingReference.TRUE else None
        return None if variation is None else (angle - variation) % tau

    def rudder_angle(self, now: float) -> float | None:
        """Starboard positive."""
        datum = self.rudder
        return datum.value if now - datum._heard < self._age else None

    def position_at(self, now: float) -> tuple[float, float] | None:
        """Latitude and longitude in degrees."""
        datum = self.position
        return datum.value if now - datum._heard < self._age else None

    def method_at(self, now: float) -> GnssMethod | None:
        """How the position was found, if somebody tells."""
        datum = self.fix
        return datum.value.method if now - datum._heard < self._age and datum.value is not None else None

    def clock_at(self, now: float) -> Clock | None:
        """UTC of the last reading, if it may still go with a position of `now`."""
        datum = self.clock
        return datum.value if now - datum._heard < TIME_AGE else None

    def cross_track_at(self, now: float) -> CrossTrackError | None:
        return self.cross_track.at(now, self._age)
