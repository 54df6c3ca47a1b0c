"""Recorded instruments onto the bus: what others read in the sentences is what others read in the messages.

The sentences are read by pynmea2, the payloads by the PyPI package `nmea2000`; neither knows anything of us.
"""

from collections import Counter
from functools import cache
from math import degrees, radians

import pynmea2
import pytest
from nmea2000 import backend

from tests.conformance.test_nmea0183_recordings import RECORDINGS
from tests.recordings import recording
from timonel.nmea0183.framing import SentenceFramer
from timonel.nmea0183.registry import parse
from timonel.nmea0183.sentence import Sentence
from timonel.nmea2000.messages.navigation import PositionRapidUpdate
from timonel.vehicles.boat.instruments import READINGS, Instruments

KNOT = 1852 / 3600
MOST = 2000
"""Sentences of a recording that are compared, evenly over it."""
NUMBERS = {"reference", "cogReference", "source"}


def number(text):
    return None if text in (None, "") else float(text)


def bearing(text):
    """rad of degrees."""
    return None if number(text) is None else radians(number(text) % 360)


def signed(magnitude, letter):
    if number(magnitude) is None or letter in (None, ""):
        return None
    return radians(number(magnitude)) * (-1 if letter == "W" else 1)


def knots(text):
    return None if number(text) is None else number(text) * KNOT


def place(sentence):
    if not sentence.lat or not sentence.lon:
        return {}
    return {"latitude": sentence.latitude, "longitude": sentence.longitude}


UNITS = {"N": KNOT, "M": 1.0, "K": 1 / 3.6}


def mwv(sentence):
    if sentence.status != "A":
        return {}
    return {
        130306: {
            "windAngle": bearing(sentence.wind_angle),
            "windSpeed": number(sentence.wind_speed) * UNITS[sentence.wind_speed_units],
            "reference": {"R": 2, "T": 3}[sentence.reference],
        }
    }


def rmc(sentence):
    if sentence.status != "A":
        return {}
    course = {"cog": bearing(sentence.true_course), "sog": knots(sentence.spd_over_grnd), "cogReference": 0}
    return {129025: place(sentence), 129026: course}


EXPECTED = {
    "HDT": lambda s: {127250: {"heading": bearing(s.heading), "reference": 0}},
    "HDM": lambda s: {127250: {"heading": bearing(s.heading), "reference": 1}},
    "HDG": lambda s: {
        127250: {
            "heading": bearing(s.heading),
            "deviation": signed(s.deviation, s.dev_dir),
            "variation": signed(s.variation, s.var_dir),
            "reference": 1,
        }
    },
    "ROT": lambda s: {127251: {"rate": radians(number(s.rate_of_turn)) / 60}},
    "VHW": lambda s: {128259: {"speedWaterReferenced": knots(s.water_speed_knots)}},
    "DPT": lambda s: {128267: {"depth": number(s.depth), "offset": number(s.offset)}},
    "DBT": lambda s: {128267: {"depth": number(s.depth_meters), "offset": None}},
    "MTW": lambda s: {130316: {"temperature": number(s.temperature) + 273.15, "source": 0}},
    "MWV": mwv,
    "GLL": lambda s: {129025: place(s)} if s.status == "A" else {},
    "GGA": lambda s: {129029: place(s)} if s.gps_qual in (1, 2) else {},
    "RMC": rmc,
}
ANGLES = dict.fromkeys(("heading", "deviation", "variation", "cog", "windAngle"), 1e-4)
STEPS = ANGLES | {"latitude": 1e-7, "longitude": 1e-7, "rate": 4e-8, "offset": 1e-3, "temperature": 1e-3}


def lines(name):
    sentences = [line for line in SentenceFramer().receive(recording(name).read_bytes()) if known(line)]
    return sentences[:: max(1, len(sentences) // MOST)]


def known(line):
    return line[3:6].decode("ascii", "replace") in EXPECTED and type(parse(line)) in READINGS


def told(line):
    """What the bus gets of a sentence, as another package reads it: the fields by PGN."""
    typed = parse(line)
    assert isinstance(typed, Sentence)
    found = {}
    for message in Instruments().receive(typed, "", 0.0):
        decoded = backend.decode(message.PGN, message.encode(), 35, units="si")
        if message != PositionRapidUpdate(latitude=None, longitude=None):
            found[message.PGN] = {f.id: f.raw_value if f.id in NUMBERS else f.value for f in decoded.fields}
    return found


def mistakes(line):
    theirs = EXPECTED[line[3:6].decode()](pynmea2.parse(line.decode(), check=True))
    ours = told(line)
    for pgn, fields in theirs.items():
        values = {name: value for name, value in fields.items() if name not in NUMBERS}
        if all(value is None for value in values.values()):
            continue
        for name, value in fields.items():
            back = ours.get(pgn, {}).get(name, "not told")
            if value is None or back in (None, "not told"):
                if back is not value:
                    yield f"{line!r}: {pgn} {name} {value} is {back}"
            elif abs(value - back) > STEPS.get(name, 0.01) * 0.51:
                yield f"{line!r}: {pgn} {name} {value} is {back} ({degrees(back):.3f})"


@cache
def compared(name):
    seen = Counter(line[3:6].decode() for line in lines(name))
    return seen, [text for line in lines(name) for text in mistakes(line)]


@pytest.mark.parametrize("name", RECORDINGS)
def test_the_bus_is_told_what_the_instruments_told(name):
    assert compared(name)[1][:5] == []


def test_the_recordings_have_instruments_of_every_kind():
    seen = sum((compared(name)[0] for name in RECORDINGS), Counter())
    assert set(seen) == set(EXPECTED)
