"""Several sources of one datum: who is listened to, when another takes over, and what is mended in what they tell.

A source is a device on the bus, known by its NAME, or an instrument's port, known by its name. For each datum the
owner may list sources, the best first; those that are not listed come after them: devices on the bus, then instruments,
then what is computed (`derived`).

what happens                                       what becomes of it
the source that rules is silent for `hold`         the best of those that speak takes over at once
it tells a lost fix, an HDOP above the limit       whoever tells better takes over at once
more than `broken` of its sentences are damaged    its port comes last in everything until the line is clean again
a listed source speaks, better than the present    it takes over when it has spoken for `settle` without a pause
one that is not listed tells better                it takes over at once (a receiver's own position before its 129029)

Where two sources take turns every few seconds a course would swing with them: `settle` is what keeps it steady.
"""

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import radians, tau
from typing import Annotated, Any, Literal

import msgspec

from timonel.core.effects import Event
from timonel.core.message import Message
from timonel.nmea2000.lookups import WindReference
from timonel.nmea2000.messages.environment import WindData
from timonel.nmea2000.messages.navigation import WaterDepth
from timonel.nmea2000.messages.steering import RateOfTurn, Rudder, VesselHeading
from timonel.vehicles.boat.truth import LOST, Datum, T

Wanted = Literal[
    "heading", "rate_of_turn", "attitude", "rudder", "variation", "position", "course", "time", "speed", "depth",
    "log", "water_temperature", "wind", "current", "navigation",
]  # fmt: skip
"""What sources may be listed for."""
WANTED: dict[str, Wanted] = {
    "true heading": "heading",
    "magnetic heading": "heading",
    "rate of turn": "rate_of_turn",
    "attitude": "attitude",
    "rudder": "rudder",
    "variation": "variation",
    "position": "position",
    "fix": "position",
    "course": "course",
    "time": "time",
    "speed": "speed",
    "depth": "depth",
    "log": "log",
    "water temperature": "water_temperature",
    "apparent wind": "wind",
    "true wind": "wind",
    "ground wind": "wind",
    "current": "current",
    "navigation": "navigation",
    "cross track": "navigation",
}
"""For which list the sources of a datum stand."""

Derivable = Literal["true_wind", "ground_wind", "current", "variation"]
Name = Annotated[str, msgspec.Meta(min_length=1)]
Degrees = Annotated[float, msgspec.Meta(ge=-180, le=180)]

INSTRUMENTS = 256  # the first source that is a port; below are addresses on the bus
DERIVED = 1 << 16
PLACE = 16  # ranks within one place
LONGEST_LIST = 64
ON_THE_BUS, BY_WIRE, COMPUTED, DAMAGED = (LONGEST_LIST + place for place in (0, 1, 2, 3))
HISTORY = 50  # sentences of a port that are judged together
ENOUGH = 10  # sentences before a port is judged at all

UNLISTED = ON_THE_BUS * PLACE
"""Ranks from here on are of sources that the owner does not list."""
POOR = DAMAGED * PLACE
"""Ranks from here on are of sources that are not to be relied on: damaged on the way, or lost."""

assert POOR + PLACE <= LOST


class Correction(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What is wrong with the installation of a source, to be mended in all that it tells.

    `heading_deg`, `rudder_deg` and `wind_deg` are added to its angles, clockwise and to starboard positive, after the
    inversion. `depth_offset_m` takes the place of the sounder's own offset: from the transducer up to the waterline, or
    negative down to the keel.
    """

    source: Name
    heading_deg: Degrees = 0.0
    rudder_deg: Degrees = 0.0
    rudder_invert: bool = False
    rate_of_turn_invert: bool = False
    wind_deg: Degrees = 0.0
    wind_invert: bool = False
    depth_offset_m: Annotated[float, msgspec.Meta(ge=-30, le=30)] | None = None


class SourceSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What an owner may set about sources: the tables `[sources]` and `[[correction]]` of a configuration."""

    order: dict[Wanted, Annotated[tuple[Name, ...], msgspec.Meta(max_length=LONGEST_LIST)]] = {}
    """The sources of a datum, the best first: NAMEs as `0x` and 16 digits, or names of ports."""
    hold: Annotated[float, msgspec.Meta(ge=0.2, le=60)] | None = None
    """How long the source that rules may be silent, s; None is each datum's own time, 1 s to 4 s."""
    settle: Annotated[float, msgspec.Meta(ge=0, le=600)] = 5.0
    """How long a better source must have spoken without a pause before it takes over, s."""
    hdop_limit: Annotated[float, msgspec.Meta(gt=0, le=100)] | None = None
    """Positions with an HDOP above it count as lost."""
    broken: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.2
    """The share of a port's sentences with a wrong check sum above which it comes last."""
    derive: tuple[Derivable, ...] = ()
    """What is computed, said and sent where nobody tells it."""
    corrections: tuple[Correction, ...] = ()


class SourceChanged(Event, frozen=True, gc=False):
    """Another source rules a datum: a NAME, a port or `derived`; `previous` is empty where nobody did."""

    datum: str
    source: str
    previous: str = ""


class SourceDamaged(Event, frozen=True, gc=False):
    """What a port says is damaged on its way, or is no more; `share` of its last sentences."""

    port: str
    damaged: bool
    share: float


class Speaker(msgspec.Struct):
    """One that would tell the datum too: since when without a pause, last when, and how well."""

    since: float
    heard: float
    rank: int


class RankedDatum(Datum[T]):
    """A datum whose sources stand in an order that the owner has a say in."""

    __slots__ = ("_begin", "_changed", "_name", "_others", "_places", "_settle")

    def __init__(
        self,
        name: str,
        hold: float,
        settle: float,
        places: Mapping[int, int],
        changed: Callable[[str, int, int], None],
    ) -> None:
        super().__init__(hold)
        self._name = name
        self._settle = settle
        self._places = places
        self._changed = changed
        self._begin = 0  # where the ranks of the ruling source began when it was last heard
        self._others: dict[int, Speaker] = {}

    def offer(self, value: T, now: float, source: int, rank: int = 0) -> bool:
        """Take `value` if `source` is the one to listen to. Runs once a message: the common way comes first."""
        begin = self._places[source]
        rank += begin
        if source == self._source:
            if rank > self._rank and begin == self._begin and now - self._heard < self._hold:
                return False
        elif self._may_rule(source, rank, now):
            self._changed(self._name, self._source, source)
            self._source = source
            self._others.pop(source, None)
        else:
            return False
        self._begin = begin
        self._rank = rank
        self.value = value
        self._heard = now
        return True

    def _may_rule(self, source: int, rank: int, now: float) -> bool:
        speaker = self._speaker(source, rank, now)
        if now - self._heard >= self._hold:
            return not any(self._better(other, rank, now) for other in self._others.values() if other is not speaker)
        if rank >= self._rank:
            return False
        at_once = rank >= UNLISTED or rank // PLACE == self._rank // PLACE or self._rank >= POOR
        return at_once or now - speaker.since >= self._settle

    def _speaker(self, source: int, rank: int, now: float) -> Speaker:
        speaker = self._others.get(source)
        if speaker is None or now - speaker.heard > self._hold or rank < POOR <= speaker.rank:
            speaker = self._others[source] = Speaker(now, now, rank)
        speaker.heard = now
        speaker.rank = rank
        return speaker

    def _better(self, other: Speaker, rank: int, now: float) -> bool:
        return other.rank < rank and now - other.heard < self._hold


class Places(dict[int, int]):
    """The rank at which each source of one list begins, by source."""

    def __init__(self, order: Sequence[int | str]) -> None:
        self._order = {who: place * PLACE for place, who in enumerate(order)}
        self._damaged: set[int] = set()
        self._known: dict[int, int | str] = {}

    def __missing__(self, source: int) -> int:
        rank = self[source] = self._rank(source)
        return rank

    def _rank(self, source: int) -> int:
        if source in self._damaged:
            return POOR
        if (listed := self._order.get(self._known.get(source, ""))) is not None:
            return listed
        place = ON_THE_BUS if source < INSTRUMENTS else BY_WIRE if source < DERIVED else COMPUTED
        return place * PLACE

    def listed(self, source: int) -> bool:
        """Whether the owner put it into the list."""
        return self._known.get(source, "") in self._order

    def introduce(self, source: int, who: int | str) -> None:
        """`source` is the device with this NAME, or the port of this name."""
        self._known[source] = who
        self.pop(source, None)

    def damage(self, source: int, damaged: bool) -> None:
        """`source` comes last from now on, or no longer."""
        (self._damaged.add if damaged else self._damaged.discard)(source)
        self.pop(source, None)


class Line:
    """How well the sentences of a port arrive."""

    def __init__(self, broken: float) -> None:
        self._broken = broken
        self._sound: deque[bool] = deque(maxlen=HISTORY)
        self.damaged = False

    @property
    def share(self) -> float:
        """Of the last sentences, those that were damaged: 0..1."""
        return self._sound.count(False) / len(self._sound)

    def receive(self, sound: bool) -> bool:
        """A sentence came in; whether the line is to be judged otherwise now."""
        self._sound.append(sound)
        if sound and not self.damaged:
            return False
        worse = not self.damaged and len(self._sound) >= ENOUGH and self.share > self._broken
        better = self.damaged and len(self._sound) == HISTORY and self.share <= self._broken / 2
        if worse or better:
            self.damaged = worse
        return worse or better


Mend = Callable[[Any], Message]


class Sources:
    """All sources of a boat: their order, their health and their corrections. `ports` are those of instruments."""

    def __init__(self, settings: SourceSettings, ports: Iterable[str]) -> None:
        self._settings = settings
        self.ports = {name: INSTRUMENTS + number for number, name in enumerate(ports)}
        """The source that a port is."""
        self._places: dict[Wanted, Places] = {
            wanted: Places(tuple(map(who, settings.order.get(wanted, ())))) for wanted in WANTED.values()
        }
        self._lines = {name: Line(settings.broken) for name in self.ports}
        self._mend = {who(correction.source): mends(correction) for correction in settings.corrections}
        self._mends: dict[int, dict[type[Message], Mend]] = {}
        self._names: dict[int, int] = {}
        self.changes: list[Event] = []
        """What happened since it was last taken from here."""
        for name, source in self.ports.items():
            self._known(source, name)

    @property
    def hdop_limit(self) -> float | None:
        """Positions with an HDOP above it count as lost."""
        return self._settings.hdop_limit

    def datum(self, name: str, hold: float) -> Datum[Any]:
        """A datum whose sources stand in the owner's order."""
        places = self._places[WANTED[name]]
        settings = self._settings
        return RankedDatum(name, settings.hold or hold, settings.settle, places, self._changed)

    def introduce(self, address: int, name: int) -> None:
        """The device at `address` claimed it with this NAME."""
        if self._names.get(address) != name:
            self._names[address] = name
            self._known(address, name)

    def _known(self, source: int, who: int | str) -> None:
        self._mends.pop(source, None)
        if who in self._mend:
            self._mends[source] = self._mend[who]
        for places in self._places.values():
            places.introduce(source, who)

    def listed(self, wanted: Wanted, source: int) -> bool:
        """Whether `source` stands in the owner's list for `wanted`."""
        return self._places[wanted].listed(source)

    def sentence(self, port: str, sound: bool) -> bool:
        """A sentence came in at `port`, damaged or not; whether the port is judged otherwise now."""
        line = self._lines[port]
        if not line.receive(sound):
            return False
        for places in self._places.values():
            places.damage(self.ports[port], line.damaged)
        self.changes.append(SourceDamaged(port, line.damaged, round(line.share, 2)))
        return True

    def mended(self, message: Message, source: int) -> Message:
        """`message` as it would be if its sender were installed as it should be."""
        mends = self._mends.get(source)
        if mends is None:
            return message
        mend = mends.get(type(message))
        return message if mend is None else mend(message)

    def depth_offset(self, port: str) -> float | None:
        """Of a sounder at `port`, m, if the owner says it."""
        offsets = (c.depth_offset_m for c in self._settings.corrections if c.source == port)
        return next(offsets, None)

    def label(self, source: int) -> str:
        """A source in words: a NAME, an address that nobody claimed, a port, `derived`."""
        if source >= DERIVED:
            return "derived"
        if source >= INSTRUMENTS:
            return next(name for name, number in self.ports.items() if number == source)
        name = self._names.get(source)
        return f"address {source}" if name is None else f"0x{name:016x}"

    def _changed(self, name: str, previous: int, source: int) -> None:
        self.changes.append(SourceChanged(name, self.label(source), "" if previous < 0 else self.label(previous)))


def who(text: str) -> int | str:
    """The NAME that `text` is, or the name of a port that it is."""
    return int(text, 16) if text[:2] in ("0x", "0X") else text


# What is mended -------------------------------------------------------------------------------------

FROM_BOW = (WindReference.APPARENT, WindReference.TRUE_BOAT, WindReference.TRUE_WATER)


def turned(angle: float | None, by: float) -> float | None:
    """A direction turned clockwise, 0..2 pi."""
    return None if angle is None else (angle + by) % tau


def _heading(correction: Correction) -> Mend:
    by = radians(correction.heading_deg)

    def mend(message: VesselHeading) -> Message:
        return msgspec.structs.replace(message, heading=turned(message.heading, by))

    return mend


def _rudder(correction: Correction) -> Mend:
    sign, by = -1.0 if correction.rudder_invert else 1.0, radians(correction.rudder_deg)

    def mend(message: Rudder) -> Message:
        position = None if message.position is None else message.position * sign + by
        return msgspec.structs.replace(message, position=position)

    return mend


def _rate(correction: Correction) -> Mend:
    def mend(message: RateOfTurn) -> Message:
        return msgspec.structs.replace(message, rate=None if message.rate is None else -message.rate)

    return mend


def _wind(correction: Correction) -> Mend:
    sign, by = -1.0 if correction.wind_invert else 1.0, radians(correction.wind_deg)

    def mend(message: WindData) -> Message:
        if message.reference not in FROM_BOW or message.wind_angle is None:
            return message
        return msgspec.structs.replace(message, wind_angle=(message.wind_angle * sign + by) % tau)

    return mend


def _depth(correction: Correction) -> Mend:
    offset = correction.depth_offset_m

    def mend(message: WaterDepth) -> Message:
        return msgspec.structs.replace(message, offset=offset)

    return mend


def mends(correction: Correction) -> dict[type[Message], Mend]:
    """What a correction does to which message."""
    wanted: dict[type[Message], tuple[bool, Callable[[Correction], Mend]]] = {
        VesselHeading: (correction.heading_deg != 0, _heading),
        Rudder: (correction.rudder_invert or correction.rudder_deg != 0, _rudder),
        RateOfTurn: (correction.rate_of_turn_invert, _rate),
        WindData: (correction.wind_invert or correction.wind_deg != 0, _wind),
        WaterDepth: (correction.depth_offset_m is not None, _depth),
    }
    return {message: mend(correction) for message, (is_wanted, mend) in wanted.items() if is_wanted}
