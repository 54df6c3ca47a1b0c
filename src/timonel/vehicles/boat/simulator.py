"""A simulated boat: hull, rudder machine, pilot, sensors and the water around, on an NMEA 2000 backbone.

It has no clock: `step(dt)` moves it and returns the frames that its devices sent meanwhile, `receive` hands
it the frames of others. The same seed and the same calls give the same bytes.

    yaw      r' = (K (rudder - helm balance) - r) / T + waves, K growing and T shrinking with speed (Nomoto)
    rudder   follows its order at 5 degrees/s, within 35 degrees
    way      speed through water follows the engine, loses some in a turn; the current carries the rest
    pilot    obeys PGN 127237 of anybody: heading control steers the heading-to-steer of its reference, main
             steering lets go; without a compass it lets go by itself

The figures are those of a sailing yacht of eleven metres under engine, off Palma.
"""

from collections.abc import Callable, Iterator
from enum import StrEnum
from functools import lru_cache
from math import atan2, cos, degrees, hypot, pi, radians, sin, sqrt, tau
from random import Random
from typing import Protocol

import msgspec

from timonel.core.frame import Frame
from timonel.core.message import Message
from timonel.nmea2000.fastpacket import Reassembler, fragment
from timonel.nmea2000.identifier import GLOBAL, Identifier, join, split
from timonel.nmea2000.lookups import (
    CalculationType,
    DeviceClass,
    DirectionRudder,
    GnssMethod,
    GnssType,
    HeadingReference,
    IndustryCode,
    ManufacturerCode,
    SteeringMode,
    TemperatureSource,
    TimeSource,
    TurnMode,
    VariationSource,
    WaterReference,
    WindReference,
    XteMode,
    YesNo,
    YesNoBit,
)
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
from timonel.nmea2000.messages.network import IsoAddressClaim, IsoRequest, ProductInformation
from timonel.nmea2000.messages.steering import (
    Attitude,
    HeadingTrackControl,
    MagneticVariation,
    RateOfTurn,
    Rudder,
    VesselHeading,
)
from timonel.nmea2000.registry import is_fast, priority
from timonel.nmea2000.sender import Outgoing

TICK = 0.05
"""Seconds between two moments of the simulation."""

PILOT, COMPASS, GNSS, LOG, SOUNDER, ANEMOMETER, THERMOMETER, PLOTTER = 204, 40, 41, 42, 43, 44, 45, 46
"""Source addresses of the devices."""

FUNCTIONS = {
    PILOT: (DeviceClass.STEERING_AND_CONTROL, 150),
    COMPASS: (DeviceClass.NAVIGATION, 140),
    GNSS: (DeviceClass.NAVIGATION, 145),
    LOG: (DeviceClass.NAVIGATION, 155),
    SOUNDER: (DeviceClass.NAVIGATION, 135),
    ANEMOMETER: (DeviceClass.EXTERNAL_ENVIRONMENT, 130),
    THERMOMETER: (DeviceClass.EXTERNAL_ENVIRONMENT, 130),
    PLOTTER: (DeviceClass.DISPLAY, 130),
}
"""What each device says it is (class, function), in PGN 60928."""

RUDDER_LIMIT = radians(35)
RUDDER_RATE = radians(5)
VARIATION = radians(2.1)  # World Magnetic Model at 39.5 N 2.6 E, 2026
DEVIATION = radians(2)
CRUISE = 3.0  # m/s
EARTH = 6371008.8  # m
ZERO_CELSIUS = 273.15


class Fault(StrEnum):
    """What can be taken away from the boat."""

    HEADING = "heading"  # the compass is silent
    BACKBONE = "backbone"  # nothing passes, in either direction
    PILOT_DEAF = "pilot deaf"  # the pilot goes on, but obeys nobody
    GNSS = "gnss"  # neither position nor time


SILENT = {Fault.HEADING: COMPASS, Fault.GNSS: GNSS}


class Hull(msgspec.Struct):
    """How the boat turns and runs. Angles in rad, speed through water in m/s."""

    heading: float
    speed: float
    rate: float = 0.0
    rudder: float = 0.0

    def move(self, order: float, balance: float, push: float, dt: float) -> None:
        """`order` is the rudder asked for, `balance` the one that keeps it straight, `push` in rad/s^2 the sea's."""
        order = _clamp(order, RUDDER_LIMIT)
        self.rudder += _clamp(order - self.rudder, RUDDER_RATE * dt)
        way = max(self.speed / CRUISE, 0.1)
        self.rate += ((0.3 * way * (self.rudder - balance) - self.rate) * way / 3.0 + push) * dt
        self.heading = (self.heading + self.rate * dt) % tau

    def run(self, throttle: float, dt: float) -> None:
        """`throttle` is the speed that the engine gives straight ahead, in m/s."""
        self.speed += (throttle * (1 - 2 * min(abs(self.rate), 0.2)) - self.speed) / 8.0 * dt


class SimulatedPilot:
    """A pilot as the standard has it: PGN 127237 in and out."""

    def __init__(self) -> None:
        self.engaged = False
        self.setpoint = 0.0  # rad, in `reference`
        self.reference = HeadingReference.TRUE
        self.order = 0.0
        self._trim = 0.0

    def receive(self, command: HeadingTrackControl) -> None:
        """Obeys heading control with a course, and main steering; everything else is not for it."""
        match command:
            case HeadingTrackControl(steering_mode=SteeringMode.MAIN_STEERING):
                self.engaged = False
            case HeadingTrackControl(
                steering_mode=SteeringMode.HEADING_CONTROL | SteeringMode.HEADING_CONTROL_STANDALONE,
                heading_reference=(HeadingReference.TRUE | HeadingReference.MAGNETIC) as reference,
                heading_to_steer_course=float(course),
            ):
                self.hold(course, reference)

    def hold(self, course: float, reference: HeadingReference) -> None:
        """Steer `course`, in rad of `reference`."""
        self._trim = self._trim if self.engaged else 0.0
        self.engaged, self.setpoint, self.reference = True, course, reference

    def steer(self, heading: float, rate: float, speed: float, dt: float) -> float:
        """The rudder ordered, in rad; `heading` is in `reference`."""
        error = _wrap(self.setpoint - heading)
        if abs(error) < radians(5):
            self._trim = _clamp(self._trim + 0.05 * error * dt, radians(5))
        way = max(speed / CRUISE, 0.3)
        self.order = _clamp((1.6 * _clamp(error, radians(25)) - 4.0 * rate) / way + self._trim, RUDDER_LIMIT)
        return self.order

    def status(self, heading: float | None, rudder: float) -> HeadingTrackControl:
        """What it says of itself at 4 Hz."""
        off = heading is not None and self.engaged and abs(_wrap(self.setpoint - heading)) > radians(20)
        return HeadingTrackControl(
            rudder_limit_exceeded=YesNo(int(abs(rudder) > RUDDER_LIMIT - 1e-6)),
            off_heading_limit_exceeded=YesNo(int(off)),
            override=YesNo.NO,
            steering_mode=SteeringMode.HEADING_CONTROL if self.engaged else SteeringMode.MAIN_STEERING,
            turn_mode=TurnMode.RUDDER_LIMIT_CONTROLLED,
            heading_reference=self.reference,
            commanded_rudder_direction=_direction(self.order) if self.engaged else DirectionRudder.NO_ORDER,
            commanded_rudder_angle=self.order if self.engaged else None,
            heading_to_steer_course=self.setpoint if self.engaged else None,
            rudder_limit=RUDDER_LIMIT,
            off_heading_limit=radians(20),
            vessel_heading=heading,
        )


class Heard(msgspec.Struct, frozen=True, gc=False):
    """A whole message that somebody put on the bus."""

    pgn: int
    payload: bytes
    source: int
    destination: int


class Speaks(Protocol):
    """A pilot that has words of its own, and the law that it steers by. See `simulated_pilots`."""

    law: SimulatedPilot
    address: int
    maker: ManufacturerCode
    kind: tuple[DeviceClass, int]
    product: ProductInformation | None

    def receive(self, heard: Heard, heading: float) -> list[Outgoing]: ...
    def speak(self, tick: int, heading: float, rate: float) -> list[Outgoing]: ...


class Sea:
    """Wind, waves, current and seabed. Vectors are (north, east) in m/s, and of where a thing goes."""

    def __init__(self, random: Random) -> None:
        self.current = _vector(0.4, radians(120))
        self.wind = _vector(7.0, radians(70))
        self.gust = 0.0
        self._random = random
        self._phases = [random.random() * tau for _ in range(5)]

    def blow(self, dt: float) -> None:
        """Gusts of two minutes or so; their strength is a share of the wind."""
        self.gust += -self.gust * dt / 40.0 + 0.12 * sqrt(2 * dt / 40.0) * self._random.gauss()
        veer = radians(70) + 0.1 * sin(self._phases[3]) + 0.15 * self.gust
        self.wind = _vector(7.0 * max(0.2, 1 + self.gust), veer)

    def yaw(self, time: float) -> float:
        """What the waves do to the rate of turn, in rad/s^2."""
        return 0.002 * sin(time * tau / 6.5 + self._phases[0]) + 0.001 * sin(time * tau / 9.7 + self._phases[1])

    def roll(self, time: float) -> float:
        return 0.05 * sin(time * tau / 4.3 + self._phases[2])

    def pitch(self, time: float) -> float:
        return 0.02 * sin(time * tau / 3.9 + self._phases[1])

    def depth(self, north: float, east: float) -> float:
        """Below the transducer, in m, `north` and `east` of where the boat began."""
        hills = 6 * sin(north / 400 + self._phases[0]) + 3 * sin(east / 170 + self._phases[2])
        return 18 + hills + sin((north + east) / 45)

    def temperature(self, time: float) -> float:
        """Of the water, in K."""
        return ZERO_CELSIUS + 19.4 + 0.6 * sin(time * tau / 1800 + self._phases[4])


class SimulatedBoat:
    """The boat on its bus.

    `start` is the time in unix seconds, `heading` in rad true, `destination` a waypoint (latitude,
    longitude) that the plotter shows the way to. With `magnetic` the compass has deviation and says so, and
    variation comes in PGN 127258 alone; else it gives true headings. `helm` is the rudder (rad) that
    somebody holds while the pilot is off, `throttle` the speed (m/s) asked of the engine. The pilot is the standard's
    own, unless it speaks a `dialect`.
    """

    def __init__(
        self,
        seed: int = 1,
        *,
        start: float = 1_790_000_000.0,
        latitude: float = 39.5,
        longitude: float = 2.6,
        heading: float = radians(45),
        magnetic: bool = False,
        destination: tuple[float, float] | None = None,
        dialect: Speaks | None = None,
    ) -> None:
        self.hull = Hull(heading, CRUISE)
        self.pilot = SimulatedPilot() if dialect is None else dialect.law
        self.dialect = dialect
        self._pilot_address = PILOT if dialect is None else dialect.address
        self._devices = FUNCTIONS if dialect is None else _with_pilot(dialect)
        self.latitude, self.longitude = latitude, longitude
        self.helm, self.throttle = 0.0, CRUISE
        self._origin = (latitude, longitude)
        self._destination = destination
        self._magnetic = magnetic
        self._start = start
        self._ticks = 0
        self._owed = 0.0  # s of simulation not yet run
        self._logged = 0.0  # m through water
        self._random = Random(seed)
        self._sea = Sea(self._random)
        self._faults: set[Fault] = set()
        self._reassembler = Reassembler()
        self._sequences: dict[int, int] = {}
        self._waiting: list[tuple[int, Message]] = [(source, self._claim(source)) for source in self._devices]
        self._answers: list[Outgoing] = []
        if dialect is not None and dialect.product is not None:
            self._waiting.append((dialect.address, dialect.product))
        self._due = [list(self._schedule(tick)) for tick in range(40)]

    @property
    def time(self) -> float:
        """Unix seconds on board."""
        return self._start + self._ticks * TICK

    def silence(self, fault: Fault) -> None:
        """Take something away, until `restore`."""
        self._faults.add(fault)

    def restore(self, fault: Fault) -> None:
        self._faults.discard(fault)

    def step(self, dt: float) -> list[Frame]:
        """Let `dt` seconds pass; the frames that were sent in them, in order."""
        frames: list[Frame] = []
        self._owed += dt
        while self._owed > TICK / 2:
            self._owed -= TICK
            self._ticks += 1
            self._move()
            frames += self._speak()
        return frames

    def receive(self, frame: Frame) -> None:
        """A frame that somebody else put on the bus."""
        identifier = split(frame.identifier)
        if Fault.BACKBONE in self._faults or not frame.extended or identifier.source in self._devices:
            return
        if self.dialect is not None and identifier.pgn != IsoRequest.PGN:
            self._tell_pilot(self.dialect, identifier, frame)
        elif identifier.pgn == HeadingTrackControl.PGN:
            payload = self._reassembler.receive(frame.identifier, frame.data, self.time)
            if payload is not None and Fault.PILOT_DEAF not in self._faults:
                self.pilot.receive(HeadingTrackControl.decode(payload))
        elif identifier.pgn == IsoRequest.PGN and IsoRequest.decode(frame.data).pgn == IsoAddressClaim.PGN:
            self._waiting += [(source, self._claim(source)) for source in self._devices if _asked(identifier, source)]
        elif identifier.pgn == IsoRequest.PGN and self.dialect is not None:
            self._waiting += self._product(self.dialect, identifier, frame)

    def _product(self, dialect: Speaks, identifier: Identifier, frame: Frame) -> list[tuple[int, Message]]:
        """What the pilot says it is, if somebody asked for that."""
        asked = IsoRequest.decode(frame.data).pgn == ProductInformation.PGN and _asked(identifier, dialect.address)
        return [(dialect.address, dialect.product)] if asked and dialect.product is not None else []

    def tell(self, said: list[Outgoing]) -> None:
        """What the pilot says besides, at the next tick: somebody stood at its control head."""
        self._answers += said

    def _tell_pilot(self, dialect: Speaks, identifier: Identifier, frame: Frame) -> None:
        """Hand a whole message to a pilot with words of its own; it answers at the next tick."""
        payload: bytes | None = frame.data
        if is_fast(identifier.pgn):
            payload = self._reassembler.receive(frame.identifier, frame.data, self.time)
        if payload is None or Fault.PILOT_DEAF in self._faults:
            return
        heard = Heard(identifier.pgn, payload, identifier.source, identifier.destination)
        self._answers += dialect.receive(heard, self._heading_for_pilot())

    def _claim(self, source: int) -> IsoAddressClaim:
        pilot = self.dialect is not None and source == self.dialect.address
        maker = self.dialect.maker if pilot and self.dialect else ManufacturerCode.SIGNAL_K
        return _claim(source, self._devices[source], maker)

    # --- motion ------------------------------------------------------------------------------------------

    def _move(self) -> None:
        hull, sea, time = self.hull, self._sea, self._ticks * TICK
        if Fault.HEADING in self._faults:
            self.pilot.engaged = False
        if self._ticks % 20 == 0:
            sea.blow(20 * TICK)
        balance = radians(0.5) * (1 + sea.gust)
        hull.move(self._rudder_order(), balance, sea.yaw(time), TICK)
        hull.run(self.throttle, TICK)
        self._logged += hull.speed * TICK
        north, east = self.over_ground
        self.latitude += degrees(north * TICK / EARTH)
        self.longitude += degrees(east * TICK / (EARTH * cos(radians(self.latitude))))

    def _rudder_order(self) -> float:
        if not self.pilot.engaged:
            return self.helm
        return self.pilot.steer(self._heading_for_pilot(), self.hull.rate, self.hull.speed, TICK)

    def _heading_for_pilot(self) -> float:
        magnetic = self.pilot.reference is HeadingReference.MAGNETIC
        return (self.hull.heading - VARIATION) % tau if magnetic else self.hull.heading

    @property
    def over_ground(self) -> tuple[float, float]:
        """Velocity over ground, (north, east) in m/s."""
        north, east = _vector(self.hull.speed, self.hull.heading)
        return north + self._sea.current[0], east + self._sea.current[1]

    # --- what the devices send ---------------------------------------------------------------------------

    def _schedule(self, tick: int) -> Iterator[tuple[int, Callable[[], Message]]]:
        """(source, message) due at `tick` of the 40 that make two seconds."""
        plan: tuple[tuple[int, int, int, Callable[[], Message]], ...] = (
            # every so many ticks, at which of them
            (2, 0, COMPASS, self._heading),
            (2, 0, COMPASS, self._rate_of_turn),
            (2, 1, self._pilot_address, self._rudder),
            (2, 1, GNSS, self._position),
            *(((5, 0, PILOT, self._pilot_status),) if self.dialect is None else ()),
            (5, 2, GNSS, self._course_and_speed),
            (10, 4, ANEMOMETER, self._apparent_wind),
            (10, 9, ANEMOMETER, self._true_wind),
            (10, 6, THERMOMETER, self._environment),
            (20, 3, COMPASS, self._attitude),
            (20, 5, GNSS, self._system_time),
            (20, 6, GNSS, self._fix),
            (20, 8, COMPASS, self._variation),
            (20, 11, LOG, self._speed),
            (20, 12, LOG, self._log),
            (20, 13, SOUNDER, self._depth),
            (40, 14, THERMOMETER, self._sea_temperature),
            (40, 34, THERMOMETER, self._sea_temperature_fine),
        )
        route = ((20, 16, PLOTTER, self._cross_track), (20, 17, PLOTTER, self._navigation))
        for every, at, source, build in plan + (route if self._destination else ()):
            if tick % every == at:
                yield source, build

    def _speak(self) -> list[Frame]:
        waiting, self._waiting = self._waiting, []
        if Fault.BACKBONE in self._faults:
            return []
        silent = [SILENT[fault] for fault in self._faults if fault in SILENT]
        frames: list[Frame] = []
        for source, message in waiting:
            frames += self._frames(source, message)
        for source, build in self._due[self._ticks % 40]:
            if source not in silent:
                frames += self._frames(source, build())
        return frames if self.dialect is None else frames + self._said_by_pilot(self.dialect)

    def _said_by_pilot(self, dialect: Speaks) -> list[Frame]:
        """Its answers, and what it says by itself."""
        answers, self._answers = self._answers, []
        said = answers + dialect.speak(self._ticks, self._heading_for_pilot(), self.hull.rate)
        return [frame for message in said for frame in self._fragments(message, dialect.address)]

    def _fragments(self, message: Outgoing, source: int) -> list[Frame]:
        urgency = priority(message.pgn) if message.priority is None else message.priority
        return self._cut(join(urgency, message.pgn, source, message.destination), message.pgn, message.payload)

    # Some sixty times a second of simulated time.
    def _frames(self, source: int, message: Message) -> list[Frame]:
        identifier, fast = _route(message.PGN or 0, source)
        payload = message.encode()
        return self._cut(identifier, message.PGN or 0, payload) if fast else [Frame(identifier, payload)]

    def _cut(self, identifier: int, pgn: int, payload: bytes) -> list[Frame]:
        if not is_fast(pgn):
            return [Frame(identifier, payload)]
        sequence = self._sequences.get(identifier, 0)
        self._sequences[identifier] = sequence + 1
        return [Frame(identifier, data) for data in fragment(payload, sequence)]

    @property
    def _sid(self) -> int:
        """Messages of one tenth of a second belong together."""
        return self._ticks // 2 % 253

    @property
    def _date(self) -> int:
        return int(self.time // 86400)

    @property
    def _time_of_day(self) -> float:
        return self.time % 86400

    def _heading(self) -> VesselHeading:
        noisy = self.hull.heading + radians(0.03) * self._random.gauss()
        if not self._magnetic:
            return VesselHeading(
                sid=self._sid,
                heading=noisy % tau,
                deviation=None,
                variation=None,
                reference=HeadingReference.TRUE,
            )
        deviation = DEVIATION * sin(self.hull.heading)
        return VesselHeading(
            sid=self._sid,
            heading=(noisy - VARIATION - deviation) % tau,
            deviation=deviation,
            variation=None,
            reference=HeadingReference.MAGNETIC,
        )

    def _rate_of_turn(self) -> RateOfTurn:
        return RateOfTurn(sid=self._sid, rate=self.hull.rate)

    def _attitude(self) -> Attitude:
        heel = 0.06 * sin(self._apparent()[1]) * (1 + self._sea.gust)
        roll, pitch = self._sea.roll(self._ticks * TICK), self._sea.pitch(self._ticks * TICK)
        return Attitude(sid=self._sid, yaw=None, pitch=pitch, roll=roll - heel)

    def _variation(self) -> MagneticVariation:
        return MagneticVariation(
            sid=self._sid, source=VariationSource.WMM_2025, age_of_service=self._date, variation=VARIATION
        )

    def _rudder(self) -> Rudder:
        engaged = self.pilot.engaged
        return Rudder(
            instance=0,
            direction_order=_direction(self.pilot.order) if engaged else DirectionRudder.NO_ORDER,
            angle_order=self.pilot.order if engaged else None,
            position=self.hull.rudder,
        )

    def _pilot_status(self) -> HeadingTrackControl:
        heading = None if Fault.HEADING in self._faults else self._heading_for_pilot()
        return self.pilot.status(heading, self.hull.rudder)

    def _position(self) -> PositionRapidUpdate:
        return PositionRapidUpdate(latitude=self.latitude, longitude=self.longitude)

    def _course_and_speed(self) -> CogSogRapidUpdate:
        north, east = self.over_ground
        return CogSogRapidUpdate(
            sid=self._sid,
            cog_reference=HeadingReference.TRUE,
            cog=atan2(east, north) % tau,
            sog=hypot(north, east),
        )

    def _system_time(self) -> SystemTime:
        return SystemTime(sid=self._sid, source=TimeSource.GPS, date=self._date, time=self._time_of_day)

    def _fix(self) -> GnssPositionData:
        return GnssPositionData(
            sid=self._sid,
            date=self._date,
            time=self._time_of_day,
            latitude=self.latitude,
            longitude=self.longitude,
            altitude=2.5,
            gnss_type=GnssType.GPS_GLONASS,
            method=GnssMethod.GNSS_FIX,
            number_of_svs=11,
            hdop=0.9,
            pdop=1.6,
            geoidal_separation=48.9,
            reference_stations=0,
        )

    def _speed(self) -> Speed:
        return Speed(
            sid=self._sid,
            speed_water_referenced=self.hull.speed,
            speed_ground_referenced=None,
            speed_water_referenced_type=WaterReference.PADDLE_WHEEL,
            speed_direction=None,
        )

    def _log(self) -> DistanceLog:
        return DistanceLog(
            date=self._date,
            time=self._time_of_day,
            log=12_345_000 + int(self._logged),
            trip_log=int(self._logged),
        )

    def _depth(self) -> WaterDepth:
        depth = self._sea.depth(*self._from(self._origin))
        return WaterDepth(sid=self._sid, depth=depth, offset=0.4, range=None)

    def _apparent(self) -> tuple[float, float]:
        """The wind that is felt: speed in m/s, and where from, in rad from the bow."""
        return self._felt(self.over_ground)

    def _felt(self, moving: tuple[float, float]) -> tuple[float, float]:
        """The wind against something that moves: speed in m/s, and where from, in rad from the bow."""
        north, east = moving[0] - self._sea.wind[0], moving[1] - self._sea.wind[1]
        return hypot(north, east), (atan2(east, north) - self.hull.heading) % tau

    def _apparent_wind(self) -> WindData:
        speed, angle = self._apparent()
        return WindData(sid=self._sid, wind_speed=speed, wind_angle=angle, reference=WindReference.APPARENT)

    def _true_wind(self) -> WindData:
        speed, angle = self._felt(self._sea.current)
        return WindData(sid=self._sid, wind_speed=speed, wind_angle=angle, reference=WindReference.TRUE_WATER)

    def _environment(self) -> EnvironmentalParametersObsolete:
        return EnvironmentalParametersObsolete(
            sid=self._sid,
            water_temperature=self._sea.temperature(self._ticks * TICK),
            outside_ambient_air_temperature=ZERO_CELSIUS + 23.0,
            atmospheric_pressure=101_800,
        )

    def _sea_temperature(self) -> Temperature:
        return Temperature(
            sid=self._sid,
            instance=0,
            source=TemperatureSource.SEA,
            actual_temperature=self._sea.temperature(self._ticks * TICK),
            set_temperature=None,
        )

    def _sea_temperature_fine(self) -> TemperatureExtendedRange:
        return TemperatureExtendedRange(
            sid=self._sid,
            instance=0,
            source=TemperatureSource.SEA,
            temperature=self._sea.temperature(self._ticks * TICK),
            set_temperature=None,
        )

    # --- the way to the waypoint -------------------------------------------------------------------------

    def _cross_track(self) -> CrossTrackError:
        """Right of the track is positive: steer left."""
        north, east = self._from(self._origin)
        leg = self._leg()
        return CrossTrackError(
            sid=self._sid,
            xte_mode=XteMode.AUTONOMOUS,
            navigation_terminated=YesNo.NO,
            xte=east * cos(leg) - north * sin(leg),
        )

    def _navigation(self) -> NavigationData:
        destination = self._destination or self._origin
        north, east = (-value for value in self._from(destination))
        distance, bearing = hypot(north, east), atan2(east, north) % tau
        over_ground = self.over_ground
        return NavigationData(
            sid=self._sid,
            distance_to_waypoint=distance,
            course_bearing_reference=HeadingReference.TRUE,
            perpendicular_crossed=YesNo(int(cos(bearing - self._leg()) < 0)),
            arrival_circle_entered=YesNo(int(distance < 100)),
            calculation_type=CalculationType.RHUMB_LINE,
            bearing_origin_to_destination_waypoint=self._leg(),
            bearing_position_to_destination_waypoint=bearing,
            origin_waypoint_number=1,
            destination_waypoint_number=2,
            destination_latitude=destination[0],
            destination_longitude=destination[1],
            waypoint_closing_velocity=over_ground[0] * cos(bearing) + over_ground[1] * sin(bearing),
        )

    def _leg(self) -> float:
        """The bearing from where the boat began to the destination."""
        north, east = _offset(self._origin, self._destination or self._origin)
        return atan2(east, north) % tau

    def _from(self, place: tuple[float, float]) -> tuple[float, float]:
        """How far north and east of `place` the boat is, in m."""
        return _offset(place, (self.latitude, self.longitude))


@lru_cache
def _route(pgn: int, source: int) -> tuple[int, bool]:
    """The identifier of what a device sends, and whether it takes fast packets."""
    return join(priority(pgn), pgn, source), is_fast(pgn)


def _with_pilot(dialect: Speaks) -> dict[int, tuple[DeviceClass, int]]:
    """The devices with that pilot in the place of the standard's own."""
    return {source: kind for source, kind in FUNCTIONS.items() if source != PILOT} | {dialect.address: dialect.kind}


def _claim(source: int, kind: tuple[DeviceClass, int], maker: ManufacturerCode) -> IsoAddressClaim:
    return IsoAddressClaim(
        unique_number=0x1F0000 + source,
        manufacturer_code=maker,  # Signal K's is the one that free software may use
        device_instance_lower=0,
        device_instance_upper=0,
        device_function=kind[1],
        device_class=kind[0],
        system_instance=0,
        industry_group=IndustryCode.MARINE,
        arbitrary_address_capable=YesNoBit.NO,
    )


def _asked(identifier: Identifier, source: int) -> bool:
    return identifier.destination in (GLOBAL, source)


def _direction(order: float) -> DirectionRudder:
    return DirectionRudder.STARBOARD if order > 0 else DirectionRudder.PORT


def _vector(length: float, direction: float) -> tuple[float, float]:
    return length * cos(direction), length * sin(direction)


def _offset(origin: tuple[float, float], place: tuple[float, float]) -> tuple[float, float]:
    """(north, east) in m, on a plane: good for a day's sail of this boat."""
    middle = radians((origin[0] + place[0]) / 2)
    return radians(place[0] - origin[0]) * EARTH, radians(place[1] - origin[1]) * EARTH * cos(middle)


def _clamp(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))


def _wrap(angle: float) -> float:
    """An angle as -pi..pi."""
    return (angle + pi) % tau - pi
