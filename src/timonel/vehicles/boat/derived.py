"""What can be computed where nobody tells it: true wind, the current, the magnetic variation.

Angles are clockwise, winds are named by where they come from and currents by where they go. Nothing is known of
leeway, so the boat is taken to move through the water as her bow points.

derived       from                                                  becomes
true_wind     apparent wind, speed through the water                130306 against the water, from the bow
ground_wind   apparent wind, true heading, course and speed         130306 over ground, from true north
current       true heading, speed through water, course and speed   129291
variation     position, date, World Magnetic Model                  127258
"""

from collections.abc import Callable, Sequence
from math import atan2, cos, hypot, sin, tau

import msgspec

from timonel.core.message import Message
from timonel.core.pace import Pace
from timonel.nmea2000.lookups import HeadingReference, VariationSource, WindReference
from timonel.nmea2000.messages.environment import WindData
from timonel.nmea2000.messages.navigation import PositionRapidUpdate, SetDriftRapidUpdate, Speed
from timonel.nmea2000.messages.steering import MagneticVariation
from timonel.vehicles.boat.truth import SLOW, Truth

FULL_CIRCLE = 6.28315  # rad: what is more rounds to a full turn in steps of 1e-4, which is none


class Vector(msgspec.Struct, frozen=True):
    """A speed (m/s) and its direction (rad, 0..2 pi)."""

    speed: float
    angle: float

    def __sub__(self, other: "Vector") -> "Vector":
        x = self.speed * cos(self.angle) - other.speed * cos(other.angle)
        y = self.speed * sin(self.angle) - other.speed * sin(other.angle)
        angle = atan2(y, x) % tau
        return Vector(hypot(x, y), 0.0 if angle >= FULL_CIRCLE else angle)


def true_wind(apparent: Vector, speed_through_water: float) -> Vector:
    """The wind against the water, its angle from the bow as the apparent one's is."""
    return apparent - Vector(speed_through_water, 0.0)


def ground_wind(apparent: Vector, heading: float, over_ground: Vector) -> Vector:
    """The wind over ground, from true north; `heading` and course are true."""
    return Vector(apparent.speed, apparent.angle + heading) - over_ground


def current(heading: float, speed_through_water: float, over_ground: Vector) -> Vector:
    """Set and drift; `heading` and course are true."""
    return over_ground - Vector(speed_through_water, heading)


class Known(msgspec.Struct, frozen=True):
    """What is known now of that from which the rest is computed; None where it is not."""

    apparent: Vector | None
    heading: float | None
    through_water: float | None
    over_ground: Vector | None


def known(truth: Truth, now: float, age: float) -> Known:
    """What is told to the boat and younger than `age` (s)."""
    speed, course = truth.speed.at(now, age), truth.course.at(now, age)
    winds = truth.winds.get(WindReference.APPARENT)
    wind = None if winds is None else winds.at(now, age)
    return Known(
        None if wind is None else vector(wind.wind_speed, wind.wind_angle),
        truth.true_heading(now),
        None if speed is None else speed.speed_water_referenced,
        None if course is None else vector(course.sog, truth.to_true(course.cog, course.cog_reference, now)),
    )


def vector(speed: float | None, angle: float | None) -> Vector | None:
    """None unless both are known. What stands still needs no direction."""
    if speed is None or (angle is None and speed):
        return None
    return Vector(speed, angle or 0.0)


def derive_true_wind(truth: Truth, now: float, age: float) -> Message | None:
    have = known(truth, now, age)
    if have.apparent is None or have.through_water is None:
        return None
    wind = true_wind(have.apparent, have.through_water)
    return WindData(sid=None, wind_speed=wind.speed, wind_angle=wind.angle, reference=WindReference.TRUE_BOAT)


def derive_ground_wind(truth: Truth, now: float, age: float) -> Message | None:
    have = known(truth, now, age)
    if have.apparent is None or have.heading is None or have.over_ground is None:
        return None
    wind = ground_wind(have.apparent, have.heading, have.over_ground)
    return WindData(sid=None, wind_speed=wind.speed, wind_angle=wind.angle, reference=WindReference.TRUE_NORTH)


def derive_current(truth: Truth, now: float, age: float) -> Message | None:
    have = known(truth, now, age)
    if have.heading is None or have.through_water is None or have.over_ground is None:
        return None
    flow = current(have.heading, have.through_water, have.over_ground)
    return SetDriftRapidUpdate(sid=None, set_reference=HeadingReference.TRUE, set=flow.angle, drift=flow.speed)


def derive_variation(truth: Truth, now: float, age: float) -> Message | None:
    """The model's, not one that was told."""
    variation = None if truth.position_at(now) is None else truth.model_variation()
    if variation is None:
        return None
    source = VariationSource.AUTOMATIC_CALCULATION
    return MagneticVariation(sid=None, source=source, age_of_service=None, variation=variation)


Derive = Callable[[Truth, float, float], Message | None]
DERIVE: dict[str, tuple[type[Message], Derive]] = {
    "true_wind": (WindData, derive_true_wind),
    "ground_wind": (WindData, derive_ground_wind),
    "current": (Speed, derive_current),
    "variation": (PositionRapidUpdate, derive_variation),
}
"""What can be derived: the message at whose coming it is computed anew, and how."""


class Derived:
    """Computes what the owner wants, once a second at most, when what it is made of is told."""

    def __init__(self, wanted: Sequence[str], truth: Truth, age: float) -> None:
        self._truth = truth
        self._age = age
        self._by_message: dict[type[Message], list[tuple[Pace, Derive]]] = {}
        for name in wanted:
            message, derive = DERIVE[name]
            self._by_message.setdefault(message, []).append((Pace(SLOW / 2), derive))

    def receive(self, message: Message, now: float) -> list[Message]:
        """What is computed now that `message` came."""
        made = []
        for pace, derive in self._by_message.get(type(message), ()):
            if pace.open(now) and (derived := derive(self._truth, now, self._age)) is not None:
                pace.count(now)
                made.append(derived)
        return made


class Derivation(msgspec.Struct, frozen=True):
    """All that is derived at one time, for who shows it: None where something is missing."""

    true_wind: Vector | None
    ground_wind: Vector | None
    current: Vector | None


def derivation(truth: Truth, now: float, age: float) -> Derivation:
    """What follows from what is known, whether or not somebody tells it too. Directions are true."""
    have = known(truth, now, age)
    apparent, heading, water, ground = have.apparent, have.heading, have.through_water, have.over_ground
    return Derivation(
        None if apparent is None or water is None else true_wind(apparent, water),
        None if apparent is None or heading is None or ground is None else ground_wind(apparent, heading, ground),
        None if heading is None or water is None or ground is None else current(heading, water, ground),
    )
