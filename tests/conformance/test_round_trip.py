"""Every recorded NMEA 2000 bus, to NMEA 0183 and back: what both can carry comes back, with its sign and reference.

One message after the other goes through a converter that says everything at once; each sentence that it brings about is
read by an instruments' port, and the messages that come of it are compared with what was told. A value may differ by
half of the coarser resolution of both sides; a reference, an identifier or a flag not at all.
"""

from collections import Counter
from math import radians, tau

import pytest

from tests.conformance.recorded import messages, recordings
from tests.recordings import recording
from timonel.core.effects import Say
from timonel.nmea0183.registry import parse
from timonel.nmea0183.sentences import Mode
from timonel.nmea2000 import registry
from timonel.nmea2000.identifier import split
from timonel.nmea2000.lookups import HeadingReference, WindReference
from timonel.nmea2000.messages.environment import Temperature, TemperatureExtendedRange, WindData
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
from timonel.nmea2000.messages.steering import Attitude, RateOfTurn, Rudder, VesselHeading
from timonel.vehicles.boat.conversion import HEAR, RATES, Converter
from timonel.vehicles.boat.instruments import Instruments
from timonel.vehicles.boat.truth import Truth

NAMES = recordings()
UNLIMITED = dict.fromkeys(RATES, 1000.0)
PORT = "all"
CLOCKS = {"GLL", "ZDA"}

KNOT, MILE = 1852 / 3600, 1852.0
TENTH_DEG, TENTH_KN = radians(0.1), 0.1 * KNOT
DIRECTION = (max(1e-4, TENTH_DEG), tau)

# What comes back of a message, and in which sentence: field -> (coarser resolution, what a full turn is).
Tolerance = tuple[float, float | None]
CARRIED: dict[type, dict[str, dict[str, Tolerance]]] = {
    VesselHeading: {
        "HDT": {"heading": DIRECTION},
        "THS": {"heading": DIRECTION},
        "HDM": {"heading": DIRECTION},
        "HDG": {"heading": DIRECTION, "deviation": (TENTH_DEG, None), "variation": (TENTH_DEG, None)},
    },
    RateOfTurn: {"ROT": {"rate": (TENTH_DEG / 60, None)}},
    Attitude: {"XDR": {"pitch": (TENTH_DEG, None), "roll": (TENTH_DEG, None)}},
    Rudder: {"RSA": {"position": (TENTH_DEG, None)}},
    Speed: {"VHW": {"speed_water_referenced": (TENTH_KN, None)}},
    DistanceLog: {"VLW": {"log": (0.01 * MILE, None), "trip_log": (0.01 * MILE, None)}},
    WaterDepth: {
        "DPT": {"depth": (0.1, None), "offset": (0.1, None), "range": (10, None)},
        "DBT": {"depth": (0.1, None)},
    },
    SetDriftRapidUpdate: {"VDR": {"set": DIRECTION, "drift": (TENTH_KN, None)}},
    TemperatureExtendedRange: {"MTW": {"temperature": (0.1, None)}},
    Temperature: {"MTW": {"actual_temperature": (0.1, None)}},
    PositionRapidUpdate: {"GLL": {"latitude": (1e-7, None), "longitude": (1e-7, None)}},
    CogSogRapidUpdate: {"VTG": {"cog": DIRECTION, "sog": (TENTH_KN, None)}},
    GnssPositionData: {
        "GGA": {
            "time": (0.01, None),
            "latitude": (2e-8, None),
            "longitude": (2e-8, None),
            "altitude": (0.1, None),
            "hdop": (0.1, None),
            "geoidal_separation": (0.1, None),
        }
    },
    SystemTime: {"ZDA": {"date": (0, None), "time": (0.01, None)}},
    WindData: {
        "MWV": {"wind_speed": (TENTH_KN, None), "wind_angle": DIRECTION},
        "MWD": {"wind_speed": (0.1, None), "wind_angle": DIRECTION},
    },
    CrossTrackError: {"XTE": {"xte": (0.001 * MILE, None)}},
    NavigationData: {
        "RMB": {
            "distance_to_waypoint": (0.1 * MILE, None),
            "destination_latitude": (1e-7, None),
            "destination_longitude": (1e-7, None),
            "waypoint_closing_velocity": (TENTH_KN, None),
        },
        "APB": {
            "bearing_origin_to_destination_waypoint": DIRECTION,
            "bearing_position_to_destination_waypoint": DIRECTION,
        },
    },
}
SAME: dict[tuple[type, str], tuple[str, ...]] = {
    (CogSogRapidUpdate, "VTG"): (),
    (GnssPositionData, "GGA"): ("method",),
    (CrossTrackError, "XTE"): ("xte_mode",),
    (NavigationData, "APB"): ("course_bearing_reference", "perpendicular_crossed", "arrival_circle_entered"),
}
"""What comes back as it was, not nearly."""
DIRECTIONS = {
    CogSogRapidUpdate: (("cog", "cog_reference"),),
    SetDriftRapidUpdate: (("set", "set_reference"),),
    WindData: (("wind_angle", "reference"),),
}
MADE_TRUE = {
    (HeadingReference.MAGNETIC, HeadingReference.TRUE),
    (WindReference.MAGNETIC_NORTH, WindReference.TRUE_NORTH),
}
"""Where a sentence has both references, the true one comes back."""
MISSING = object()


def near(told, back, tolerance):
    """Whether a value came back within half of the coarser step, and the rounding of both sides."""
    step, turn = tolerance
    difference = abs(told - back)
    if turn is not None:
        difference = min(difference % turn, -difference % turn)
    return difference <= step / 2 + 1.0001e-4 * (step >= 1e-3) + step * 1e-6 + abs(told) * 1e-12


class Bridge:
    """A converter whose sentences an instrument's port reads, as it were at once."""

    def __init__(self):
        self.truth = Truth(3.0)
        self.converter = Converter(self.truth, UNLIMITED, "standard")
        self.seen = Counter()
        self.wrong = []

    def play(self, told, source, now):
        """One message; every sentence is read by a port of its own, so that none is preferred to another."""
        effects, _ = self.converter.receive(told, source, now)
        for effect in effects:
            if isinstance(effect, Say):
                self.compare(told, effect.line.rstrip(), now)

    def compare(self, told, line, now):
        formatter = line[3:6].decode()
        if formatter not in CARRIED.get(type(told), {}):
            return
        sentence = parse(line)
        back = [m for m in Instruments().receive(sentence, PORT, now) if comparable(told, m)]
        if invalid(sentence):
            told_all_the_same = [m for m in back if any(getattr(m, n) is not None for n in values(told, formatter))]
            self.wrong += [(line, told, "an invalid sentence told something")] * bool(told_all_the_same)
        elif not back:
            self.wrong.append((line, told, "nothing came back"))
        else:
            self.seen[type(told).__name__, formatter] += 1
            self.wrong += [
                (line, told, text) for text in mistakes(told, formatter, back[0], self.known(told, back[0], now))
            ]

    def known(self, told, back, now):
        """The direction that was told, in the reference that came back, by the variation that the sentence has too."""
        for name, reference in DIRECTIONS.get(type(told), ()):
            if (getattr(told, reference), getattr(back, reference)) in MADE_TRUE:
                return {name: self.truth.to_true(getattr(told, name), HeadingReference.MAGNETIC, now)}
        return {}


def values(told, formatter):
    return [name for name in CARRIED[type(told)][formatter] if name not in ("time", "hdop")]


def comparable(told, back):
    """Whether `back` is a message of the kind that was told, in the same reference."""
    if type(back) is not type(told):
        return False
    reference = getattr(told, "reference", None)
    if isinstance(told, WindData):
        return wind(reference) == wind(back.reference) or (reference, back.reference) in MADE_TRUE
    return not isinstance(told, VesselHeading) or back.reference is not None


def wind(reference):
    """MWV,T does not tell the wind against the water from that of the boat."""
    return WindReference.TRUE_BOAT if reference is WindReference.TRUE_WATER else reference


def invalid(sentence):
    """Whether a sentence says that what it has counts for nothing."""
    return (
        getattr(sentence, "valid", True) is False
        or getattr(sentence, "quality", 1) == 0
        or getattr(sentence, "mode", None) is Mode.NOT_VALID
    )


def mistakes(told, formatter, back, known):
    for name, tolerance in CARRIED[type(told)][formatter].items():
        value, returned = known.get(name, expected(told, formatter, name)), getattr(back, name)
        if value is MISSING:
            continue
        both = value is not None and returned is not None
        if not (near(value, returned, tolerance) if both else value is returned):
            yield f"{name}: {value} came back as {returned}"
    for name in SAME.get((type(told), formatter), ()):
        if getattr(told, name) not in (getattr(back, name), None):
            yield f"{name}: {getattr(told, name)!r} came back as {getattr(back, name)!r}"
    if isinstance(told, VesselHeading) and formatter in ("HDT", "THS", "HDM", "HDG"):
        wanted = HeadingReference.TRUE if formatter in ("HDT", "THS") else HeadingReference.MAGNETIC
        if back.reference is not wanted:
            yield f"{formatter} came back counted from {back.reference!r}"


def expected(told, formatter, name):
    """What should come back of a field."""
    value = getattr(told, name)
    if isinstance(told, VesselHeading):
        return heading(told, formatter, name)
    if isinstance(told, GnssPositionData) and name != "time" and not found(told):
        return MISSING
    if isinstance(told, SystemTime) and name == "time" and value is not None:
        return min(value, 86399.99)
    if isinstance(told, NavigationData) and name == "distance_to_waypoint" and value is not None:
        return min(value, 999.9 * MILE)
    return value


def found(told):
    return told.method is not None and told.method.value in range(1, 9)


def heading(told, formatter, name):
    """Of a compass only what stands in the sentence: HDT of a magnetic one has its corrections in it."""
    if formatter != "HDG":
        corrections = {"HDT": HeadingReference.TRUE, "THS": HeadingReference.TRUE, "HDM": HeadingReference.MAGNETIC}
        same = told.reference is corrections[formatter] and not (formatter == "HDM" and told.deviation)
        return told.heading if same else MISSING
    if told.reference is not HeadingReference.MAGNETIC:
        return MISSING
    if name == "variation" and told.variation is None:
        return MISSING  # that of another message may stand in
    return getattr(told, name)


def played(name):
    """What is wrong with what came back of one recording, and what was seen."""
    bridge = Bridge()
    for message in messages(recording(name)):
        target = split(message.identifier)
        told = registry.decode(target.pgn, message.payload)
        if type(told) in HEAR:
            bridge.play(told, target.source, message.now)
    return bridge


@pytest.mark.parametrize("name", NAMES)
def test_what_both_can_carry_comes_back_from_a_recorded_bus(name):
    assert played(name).wrong[:5] == []


def test_the_recordings_bring_back_every_message_that_can_come_back():
    seen = sum((played(name).seen for name in NAMES), Counter())
    assert {(kind.__name__, formatter) for kind, told in CARRIED.items() for formatter in told} - set(seen) == set()
    assert sum(seen.values()) > 50_000
