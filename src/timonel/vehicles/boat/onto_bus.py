"""What of a port's words is heard, and what goes out on the bus: nothing that it has already, and never in a circle.

Two gateways that take each other's sentences for instruments' make a loop in which a value outlives its source: it goes
round and never ages. And each converts a little (a true heading out of a magnetic one), so that what comes back looks
new. These rules keep the circle open:

* A port is heard for a kind of datum, say heading, only when no device on the bus has told that kind for 2 s, in
  whatever form; of several ports only the one that began, until it has been silent as long. A position, the time and
  the way to a waypoint are said some time after they were heard, for which they must have been silent four times the
  age limit.
* It goes onto the bus only when no device there has told that kind for 3 s.
* A port does not take over with what we said ourselves in the last seconds.
* What nobody ranks (AIS) is not sent while another device on the bus sends the same PGN.

The first two do not hold for a port that the owner lists for that kind (`sources`): then the list decides, and it
decides at once. Such a port must not be another gateway's.
"""

from collections.abc import Callable, Sequence
from typing import Any

from timonel.core.effects import Effect, Say
from timonel.core.message import Message
from timonel.nmea2000.lookups import HeadingReference, TemperatureSource
from timonel.nmea2000.messages import environment, navigation, steering
from timonel.vehicles.boat.instruments import NO_POSITION, Ceilings
from timonel.vehicles.boat.sources import DERIVED, INSTRUMENTS, Sources, Wanted
from timonel.vehicles.boat.truth import NEVER, WIND_NAMES, WINDS, Datum, Truth

QUIET = 2.0  # s after which the last one that told a kind of datum no longer stands for it
AGED = 4  # times the age limit, for what is said some time after it was heard: three gateways may be in the circle
LISTEN = 3.0  # s that no device on the bus must have told a kind before we do
SAID_AGED = frozenset({"position", "time", "navigation"})
SAME_PGN = 60.0  # s, for what nobody ranks: static data comes as seldom as this, and less
ECHO = 2.0  # s

Own = Callable[[Truth, Any], Datum[Any] | None]


def _heading(truth: Truth, message: steering.VesselHeading) -> Datum[Any]:
    return truth.true if message.reference is HeadingReference.TRUE else truth.magnetic


def _wind(truth: Truth, message: environment.WindData) -> Datum[Any] | None:
    return None if message.reference is None else truth.winds.get(WINDS[message.reference][0])


def _sea(truth: Truth, message: environment.Temperature | environment.TemperatureExtendedRange) -> Datum[Any] | None:
    return truth.sea_temperature if message.source is TemperatureSource.SEA else None


def _environment(truth: Truth, message: environment.EnvironmentalParameters) -> Datum[Any] | None:
    return truth.sea_temperature if message.temperature_source is TemperatureSource.SEA else None


OWN: dict[type[Message], Own] = {
    steering.VesselHeading: _heading,
    steering.RateOfTurn: lambda truth, _: truth.rate,
    steering.Attitude: lambda truth, _: truth.attitude,
    steering.Rudder: lambda truth, _: truth.rudder,
    steering.MagneticVariation: lambda truth, _: truth.told_variation,
    navigation.PositionRapidUpdate: lambda truth, _: truth.position,
    navigation.GnssPositionData: lambda truth, _: truth.fix,
    navigation.CogSogRapidUpdate: lambda truth, _: truth.course,
    navigation.SystemTime: lambda truth, _: truth.clock,
    navigation.TimeDate: lambda truth, _: truth.clock,
    navigation.Speed: lambda truth, _: truth.speed,
    navigation.WaterDepth: lambda truth, _: truth.depth,
    navigation.DistanceLog: lambda truth, _: truth.log,
    navigation.SetDriftRapidUpdate: lambda truth, _: truth.current,
    navigation.CrossTrackError: lambda truth, _: truth.cross_track,
    navigation.NavigationData: lambda truth, _: truth.navigation,
    navigation.NavigationRouteWpInformation: lambda truth, _: truth.navigation,
    environment.WindData: _wind,
    environment.Temperature: _sea,
    environment.TemperatureExtendedRange: _sea,
    environment.EnvironmentalParameters: _environment,
    environment.EnvironmentalParametersObsolete: lambda truth, _: truth.sea_temperature,
}
"""The datum that a message tells."""


def data(truth: Truth) -> dict[str, Datum[Any]]:
    """Everything that several sources may tell, by the name that `sources` has for it."""
    told: dict[str, Datum[Any]] = {
        "true heading": truth.true,
        "magnetic heading": truth.magnetic,
        "rate of turn": truth.rate,
        "attitude": truth.attitude,
        "rudder": truth.rudder,
        "variation": truth.told_variation,
        "position": truth.position,
        "fix": truth.fix,
        "course": truth.course,
        "time": truth.clock,
        "speed": truth.speed,
        "depth": truth.depth,
        "log": truth.log,
        "water temperature": truth.sea_temperature,
        "current": truth.current,
        "navigation": truth.navigation,
        "cross track": truth.cross_track,
    }
    return told | {f"{WIND_NAMES[wind]} wind": datum for wind, datum in truth.winds.items()}


KINDS: dict[type[Message], Wanted] = {
    steering.VesselHeading: "heading",
    steering.RateOfTurn: "rate_of_turn",
    steering.Attitude: "attitude",
    steering.Rudder: "rudder",
    steering.MagneticVariation: "variation",
    navigation.PositionRapidUpdate: "position",
    navigation.GnssPositionData: "position",
    navigation.CogSogRapidUpdate: "course",
    navigation.SystemTime: "time",
    navigation.TimeDate: "time",
    navigation.Speed: "speed",
    navigation.WaterDepth: "depth",
    navigation.DistanceLog: "log",
    navigation.SetDriftRapidUpdate: "current",
    navigation.CrossTrackError: "navigation",
    navigation.NavigationData: "navigation",
    navigation.NavigationRouteWpInformation: "navigation",
    environment.WindData: "wind",
    environment.Temperature: "water_temperature",
    environment.TemperatureExtendedRange: "water_temperature",
    environment.EnvironmentalParameters: "water_temperature",
    environment.EnvironmentalParametersObsolete: "water_temperature",
}
"""For which list the sources of a message stand."""


class Echoes:
    """What we said of late, whoever the talker."""

    def __init__(self) -> None:
        self._said: set[bytes] = set()
        self._before: set[bytes] = set()
        self._since = 0.0

    def note(self, effects: Sequence[Effect], now: float) -> None:
        """Lines go out."""
        self._turn(now)
        for effect in effects:
            if type(effect) is Say:
                self._said.add(effect.line[3:-5])

    def has(self, sentence: bytes, now: float) -> bool:
        """Whether a sentence, as it was framed, is one that we said."""
        self._turn(now)
        body = sentence[3:-3]
        return body in self._said or body in self._before

    def _turn(self, now: float) -> None:
        """Forget what is older than twice the time."""
        if now - self._since >= ECHO:
            self._before = self._said if now - self._since < 2 * ECHO else set()
            self._said = set()
            self._since = now


class OntoBus:
    """Decides what of a port is heard, and whether the bus gets it. `age` is how long a value counts, s."""

    def __init__(self, truth: Truth, sources: Sources, age: float, now: float) -> None:
        self._aged = AGED * age
        self._began = now
        self._truth = truth
        self._sources = sources
        self._ceilings = Ceilings()
        self._on_the_bus: dict[Wanted, float] = {}
        self._by_wire: dict[Wanted, tuple[int, float]] = {}
        self._pgns: dict[int, float] = {}

    def heard(self, message: Message, source: int, now: float) -> None:
        """`source` told something, and `truth` has heard it. Runs once a message."""
        kind = KINDS.get(type(message))
        if kind is None:
            if source < INSTRUMENTS and message.PGN is not None:
                self._pgns[message.PGN] = now
            return
        own = OWN[type(message)](self._truth, message)
        if own is None or not own.told_by(source, now):
            return
        if source < INSTRUMENTS:
            self._on_the_bus[kind] = now
        elif source < DERIVED:
            self._by_wire[kind] = source, now

    def admits(self, message: Message, source: int, now: float) -> bool:
        """Whether a port is heard for what `message` tells."""
        kind = KINDS.get(type(message))
        if kind is None or self._sources.listed(kind, source):
            return True
        quiet = self._aged if kind in SAID_AGED else QUIET
        if now - self._on_the_bus.get(kind, NEVER) < quiet:
            return False
        first, heard = self._by_wire.get(kind, (source, now))
        return first == source or now - heard >= quiet

    def rules(self, message: Message, source: int) -> bool:
        """Whether `source` is the one that is listened to for what `message` tells."""
        own = OWN.get(type(message))
        if own is None:
            return False
        datum = own(self._truth, message)
        return datum is not None and datum.source == source

    def allow(self, message: Message, source: int, now: float) -> bool:
        """Whether `message` of `source` goes out now."""
        if message is NO_POSITION or self._bus_has_it(message, source, now):
            return False
        return self._ceilings.allow(message, now)

    def _bus_has_it(self, message: Message, source: int, now: float) -> bool:
        """At first we listen: nothing is known of the bus then."""
        kind = KINDS.get(type(message))
        if kind is None:
            return message.PGN is not None and now - self._pgns.get(message.PGN, NEVER) < SAME_PGN
        if not self.rules(message, source):
            return True
        if source >= DERIVED or self._sources.listed(kind, source):
            return False
        return now - self._on_the_bus.get(kind, self._began) < LISTEN
