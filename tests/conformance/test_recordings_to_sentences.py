"""Every recorded NMEA 2000 bus, converted: each sentence is well formed, and its numbers are those of its message.

The message is the one whose arrival brought the sentence about; its values are decoded by the PyPI package
`nmea2000` (see `oracle`). Commands, STATUS and alerts are not looked at here, and AIS is in `test_ais_recordings`.
"""

import gzip
from collections import Counter

import pynmea2
import pytest

from tests.conformance.oracle import Oracle
from tests.conformance.recorded import messages, recordings, timed
from tests.recordings import recording
from timonel.core.effects import Rejected, Say
from timonel.nmea2000.identifier import split
from timonel.vehicles.boat.conversion import CONVERSIONS, HEAR, RATES
from timonel.vehicles.boat.settings import BoatSettings
from timonel.vehicles.boat.vehicle import Boat

CANBOAT = "canboat_canboat/samples/"
AAVA = "SignalK_signalk-server/samples/aava-n2k.data"
RAYMARINE = f"{CANBOAT}raymarine-ev1.raw"
FURUNO = f"{CANBOAT}furuno-fap7011c-autopilot-off-then-on.raw"
NAMES = recordings()

NOBODY = 251  # an address that no recorded device has, so that all are heard
UNLIMITED = dict.fromkeys(RATES, 1000.0)
HEARD = {message.PGN for message in HEAR}
FORMATTERS = {conversion.formatter for conversion in CONVERSIONS}
UNKNOWN_TO_PYNMEA2 = {"THS", "HTD"}


def boat(rates=UNLIMITED):
    return Boat(BoatSettings(address=NOBODY, rates=rates, variation_model=False), [], now=0.0)


def heard(gateway, message):
    return gateway.receive_message(message.identifier, message.payload, message.now)


def sentences(effects):
    """What the conversion says, as text without CR LF."""
    for effect in effects:
        if isinstance(effect, Say) and not effect.urgent and effect.line[:1] == b"$":
            yield effect.line.decode("ascii").removesuffix("\r\n")


def converted(name, rates=UNLIMITED):
    """All sentences of a recording."""
    gateway = boat(rates)
    return [sentence for message in messages(recording(name)) for sentence in sentences(heard(gateway, message))]


def formatters(lines):
    return Counter(line[3:6] for line in lines)


# Each sentence ----------------------------------------------------------------------------------


def malformed(sentence):
    """What is wrong with the form of a sentence."""
    if len(sentence) + 2 > 82:
        return f"{sentence}: {len(sentence) + 2} characters"
    try:
        pynmea2.parse(sentence, check=True)
    except pynmea2.SentenceTypeError:
        return None if sentence[3:6] in UNKNOWN_TO_PYNMEA2 else f"{sentence}: not known to pynmea2"
    except pynmea2.ParseError as error:
        return str(error)
    return None


def mistakes(name):
    """Everything that is wrong with the sentences of a recording, at the default ceilings and without any."""
    oracle, wrong = Oracle(), []
    gateways = boat({}), boat(UNLIMITED)
    for message in messages(recording(name)):
        target = split(message.identifier)
        values = oracle.hear(target.pgn, target.source, message.payload, message.now) if target.pgn in HEARD else None
        for gateway in gateways:
            for sentence in sentences(heard(gateway, message)):
                wrong += filter(None, (malformed(sentence), oracle.mistakes(sentence[1:-3], values, message.now)))
    return wrong


@pytest.mark.parametrize("name", NAMES)
def test_sentences_of_a_recorded_bus_print_what_their_message_told(name):
    assert mistakes(name)[:10] == []


# All together -----------------------------------------------------------------------------------


def test_the_recordings_bring_every_sentence_about_and_only_an_absurd_altitude_is_rejected():
    said, rejected = set(), []
    for name in NAMES:
        gateway = boat({})
        for message in messages(recording(name)):
            effects = heard(gateway, message)
            said.update(sentence[3:6] for sentence in sentences(effects))
            rejected += [(name, effect.reason) for effect in effects if isinstance(effect, Rejected)]
    assert said == FORMATTERS
    assert rejected == [(FURUNO, "GGA.altitude_m: 1441151966657.9097 is outside -1e+06..1e+08")] * 4


def test_there_are_a_hundred_recordings_and_some_of_each_format():
    assert len(NAMES) >= 100
    assert {name.rpartition(".")[2] for name in NAMES} >= {"raw", "log", "txt", "pcap", "data"}


def test_a_magnetic_heading_without_variation_gives_no_true_one():
    said = formatters(converted(RAYMARINE))
    assert (said["HDM"], said["HDG"]) == (2620, 2620)
    assert said["HDT"] == said["THS"] == 0


# canboat's n2kd makes one sentence a message, from any source. Where it differs from these numbers:
#   aava       GLL and RMC are made from 129029; here GLL also from 129025, RMC and VTG from 129026
#   furuno     RMC is made from 129029, and MTW from all sources of temperature; here from the best
#   raymarine  RSA is made from both devices that tell the rudder angle; here from one
#   simulator  MTW as above
@pytest.mark.parametrize(
    ("name", "same"),
    [
        (AAVA, {"VHW", "MTW", "VLW", "MWV", "DPT", "VTG", "HDT"}),
        (FURUNO, {"HDG", "MWV", "GLL", "VHW", "VLW"}),
        (RAYMARINE, {"HDM"}),
        (f"{CANBOAT}candumpSample2.txt", {"HDM", "MWV"}),
        (f"{CANBOAT}simulator1.raw", {"VTG"}),
    ],
)
def test_there_are_as_many_sentences_as_another_converter_makes(name, same):
    with gzip.open(recording(f"{name}.n2kd.nmea.gz"), "rt", encoding="ascii") as lines:
        theirs = formatters(lines)
    ours = formatters(converted(name))
    assert {formatter: ours[formatter] for formatter in same} == {formatter: theirs[formatter] for formatter in same}


def speeds_and_temperatures(lines):
    """Of VHW `...,x.x,N,x.x,K*hh` and MTW `x.x,C*hh`."""
    for line in lines:
        fields = line.split(",")
        match line[3:6]:
            case "VHW":
                yield fields[-4], fields[-2]
            case "MTW":
                yield fields[1]


def test_speeds_and_temperatures_are_the_numbers_that_another_converter_prints():
    with gzip.open(recording(f"{AAVA}.n2kd.nmea.gz"), "rt", encoding="ascii") as lines:
        theirs = list(speeds_and_temperatures(lines))
    assert len(theirs) == 2401
    assert list(speeds_and_temperatures(converted(AAVA))) == theirs


@pytest.mark.parametrize("name", [AAVA, FURUNO, f"{CANBOAT}can0-2.pcap"])
def test_two_runs_say_the_same(name):
    assert converted(name, {}) == converted(name, {}) != []


@pytest.mark.parametrize(
    "name",
    [
        f"{CANBOAT}can0-2.pcap",
        f"{CANBOAT}can0-3.pcap",
        f"{CANBOAT}candumpSample2.txt",
        f"{CANBOAT}simulator1.raw",
        FURUNO,
    ],
)
def test_frame_by_frame_the_sentences_are_those_of_whole_messages(name):
    gateway, said = boat({}), []
    for frame, now in timed(recording(name)):
        said += sentences(gateway.receive_frames([frame.frame], now))
    assert said == converted(name, {}) != []
