"""What is computed where nobody tells it, against worked examples and against each other."""

from math import pi, radians

import pytest

from tests.unit.boat.test_inputs import ALIVE, Aboard, decoded, formatters
from tests.unit.boat.test_vehicle import heading
from timonel.core.message import Message
from timonel.nmea2000.lookups import HeadingReference, VariationSource, WindReference
from timonel.nmea2000.messages.environment import WindData
from timonel.nmea2000.messages.navigation import (
    CogSogRapidUpdate,
    PositionRapidUpdate,
    SetDriftRapidUpdate,
    Speed,
    SystemTime,
)
from timonel.nmea2000.messages.steering import MagneticVariation
from timonel.vehicles.boat.derived import Derivation, Vector, current, derivation, ground_wind, true_wind, vector
from timonel.vehicles.boat.sources import SourceSettings
from timonel.vehicles.boat.truth import Truth

TRUE, MAGNETIC = HeadingReference.TRUE, HeadingReference.MAGNETIC


def close(value: Vector | None, speed: float, degrees: float) -> bool:
    assert value is not None
    turn = (value.angle - radians(degrees) + pi) % (2 * pi) - pi
    return value.speed == pytest.approx(speed, abs=1e-9) and turn == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("apparent", "through_water", "expected"),
    [
        (Vector(10.0, 0.0), 4.0, (6.0, 0)),  # into the wind: what the boat makes herself is taken off
        (Vector(4.0, pi), 3.0, (7.0, 180)),  # before the wind it is added
        (Vector(5.0, radians(36.86989764584402)), 4.0, (3.0, 90)),
        (Vector(5.0, radians(360 - 36.86989764584402)), 4.0, (3.0, 270)),
        (Vector(7.0, 1.0), 0.0, (7.0, 57.29577951308232)),
        (Vector(3.0, 0.0), 3.0, (0.0, 0)),  # a calm has no direction
    ],
)
def test_true_wind_is_the_apparent_one_without_the_boats_own(
    apparent: Vector, through_water: float, expected: tuple[float, float]
):
    assert close(true_wind(apparent, through_water), *expected)


def test_wind_over_ground_is_counted_from_north():
    assert close(ground_wind(Vector(10.0, 0.0), radians(90), Vector(4.0, radians(90))), 6.0, 90)
    assert close(ground_wind(Vector(10.0, 0.0), radians(350), Vector(0.0, 0.0)), 10.0, 350)
    assert close(ground_wind(Vector(4.0, radians(90)), radians(0), Vector(3.0, radians(0))), 5.0, 126.86989764584402)


def test_the_current_is_what_the_boat_does_not_make_herself():
    assert close(current(radians(90), 4.0, Vector(5.0, radians(90))), 1.0, 90)
    assert close(current(radians(90), 5.0, Vector(4.0, radians(90))), 1.0, 270)
    assert close(current(radians(0), 4.0, Vector(5.0, radians(36.86989764584402))), 3.0, 90)


def test_in_still_water_wind_over_ground_is_that_over_water():
    apparent, course = Vector(8.0, radians(40)), radians(130)
    water = true_wind(apparent, 3.0)
    ground = ground_wind(apparent, course, Vector(3.0, course))
    assert close(ground, water.speed, (water.angle + course) * 180 / pi)


def test_what_stands_still_needs_no_direction():
    assert vector(0.0, None) == Vector(0.0, 0.0)
    assert vector(1.0, None) is None
    assert vector(None, 1.0) is None


# Aboard -----------------------------------------------------------------------------------------

APPARENT = WindData(sid=1, wind_speed=5.0, wind_angle=radians(36.87), reference=WindReference.APPARENT)
STW = Speed(
    sid=1,
    speed_water_referenced=4.0,
    speed_ground_referenced=None,
    speed_water_referenced_type=None,
    speed_direction=None,
)
COG = CogSogRapidUpdate(sid=1, cog_reference=TRUE, cog=radians(90), sog=5.0)
MAGNETIC_COG = CogSogRapidUpdate(sid=1, cog_reference=MAGNETIC, cog=radians(88), sog=5.0)
CLOCK = SystemTime(sid=1, source=None, date=20779, time=43200.0)
PLACE = PositionRapidUpdate(latitude=36.0, longitude=-3.0)


def derived(wanted: str, *messages: Message) -> list[Message | None]:
    """What the bus gets of it after these messages; true course and heading differ by 2 degrees of variation."""
    aboard = Aboard(sources=SourceSettings(derive=(wanted,)))  # type: ignore[arg-type]
    return [message for told in messages for message in decoded(aboard.bus(told))]


def test_true_wind_is_said_and_sent():
    [wind] = derived("true_wind", STW, APPARENT)
    assert isinstance(wind, WindData)
    assert (wind.wind_speed, wind.wind_angle) == (3.0, pytest.approx(pi / 2, abs=1e-4))
    assert wind.reference is WindReference.TRUE_BOAT
    aboard = Aboard(sources=SourceSettings(derive=("true_wind",)))
    aboard.bus(STW)
    assert formatters(aboard.bus(APPARENT)) == ["MWV", "MWV"]


@pytest.mark.parametrize("course", [COG, MAGNETIC_COG])
def test_wind_over_ground_needs_a_true_heading_and_takes_any_course(course: CogSogRapidUpdate):
    [wind] = derived("ground_wind", CLOCK, PLACE, heading(90), course, APPARENT)
    assert isinstance(wind, WindData)
    assert wind.reference is WindReference.TRUE_NORTH
    assert wind.wind_angle == pytest.approx(radians(198.44), abs=1e-3)


def test_the_current_is_sent_from_true_north():
    [flow] = derived("current", heading(90), COG, STW)
    assert flow == SetDriftRapidUpdate(sid=None, set_reference=TRUE, set=1.5708, drift=1.0)


def test_the_variation_of_the_model_is_sent_as_computed():
    [variation] = derived("variation", CLOCK, PLACE)
    assert isinstance(variation, MagneticVariation)
    assert (variation.source, variation.variation) == (
        VariationSource.AUTOMATIC_CALCULATION,
        pytest.approx(radians(2), abs=1e-4),
    )


@pytest.mark.parametrize(
    ("wanted", "messages"),
    [
        ("true_wind", (APPARENT,)),
        ("ground_wind", (heading(90), APPARENT)),
        ("ground_wind", (COG, APPARENT)),
        ("current", (heading(90), STW)),
        ("current", (COG, STW)),
        ("variation", (PLACE,)),
    ],
)
def test_without_all_that_it_takes_nothing_is_derived(wanted: str, messages: tuple[Message, ...]):
    assert derived(wanted, *messages) == []


@pytest.mark.parametrize("wanted", ["ground_wind", "current", "variation"])
def test_only_what_the_owner_wants_is_derived(wanted: str):
    assert derived(wanted, STW, APPARENT) == []


def test_who_is_told_need_not_compute():
    aboard = Aboard(sources=SourceSettings(derive=("true_wind",)))
    aboard.bus(STW)
    aboard.bus(WindData(sid=1, wind_speed=9.0, wind_angle=1.0, reference=WindReference.TRUE_WATER))
    assert decoded(aboard.bus(APPARENT)) == []
    told = aboard.boat.truth.winds[WindReference.TRUE_WATER].value
    assert told is not None
    assert told.wind_speed == 9.0


def test_it_is_computed_once_a_second_and_not_of_what_is_old():
    aboard = Aboard(sources=SourceSettings(derive=("true_wind",)))
    times = []
    aboard.bus(STW)
    for tick in range(50):
        aboard.now = tick / 10
        aboard.boat.receive_frames([ALIVE], aboard.now)
        times += [aboard.now] * len(decoded(aboard.bus(APPARENT)))
    assert times == [0.0, 0.1, 1.0, 2.0]  # the speed is 3 s old then


def test_all_can_be_asked_for_at_once():
    truth = Truth(3.0)
    assert derivation(truth, 0.0, 3.0) == Derivation(None, None, None)
    for told in (heading(90), STW, COG, APPARENT):
        kind = {"VesselHeading": truth.hear_heading, "Speed": truth.hear_speed}
        kind |= {"CogSogRapidUpdate": truth.hear_course, "WindData": truth.hear_wind}
        kind[type(told).__name__](told, 10, 0.0)
    known = derivation(truth, 1.0, 3.0)
    assert known.true_wind is not None
    assert known.true_wind.speed == pytest.approx(3.0, abs=1e-3)
    assert known.current is not None
    assert known.current.speed == pytest.approx(1.0)
    assert known.ground_wind is not None
