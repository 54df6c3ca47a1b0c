"""Every recorded NMEA 2000 bus, converted: each sentence is well formed, and its numbers are those of its message.

The message is the one whose arrival brought the sentence about; its values are decoded by the PyPI package
`nmea2000` (see `oracle`). Commands and alerts are not looked at here.
"""

from collections import Counter
from functools import cache

import pynmea2
import pytest

from tests.conformance.oracle import Oracle
from tests.conformance.recorded import messages, recordings
from tests.recordings import recording
from timonel.core.effects import Rejected, Say
from timonel.nmea2000.identifier import split
from timonel.vehicles.boat.conversion import CONVERSIONS, HEAR, RATES
from timonel.vehicles.boat.settings import BoatSettings
from timonel.vehicles.boat.vehicle import Boat

UNLIMITED = dict.fromkeys(RATES, 1000.0)
HEARD = {message.PGN for message in HEAR}
FORMATTERS = {conversion.formatter for conversion in CONVERSIONS}
UNKNOWN_TO_PYNMEA2 = {"THS", "HTD"}
NAMES = recordings()


def boat(rates=UNLIMITED, **settings):
    return Boat(BoatSettings(rates=rates, variation_model=False, **settings), [], now=0.0)


def heard(gateway, message):
    """What a message brings about, and nothing that only time does."""
    gateway.expire(message.now)
    return gateway.receive_message(message.identifier, message.payload, message.now)


def sentences(effects):
    """Sentences of the conversion, as text without CR LF."""
    for effect in effects:
        if isinstance(effect, Say) and effect.line[3:6].decode() in FORMATTERS and not effect.urgent:
            yield effect.line.decode("ascii").removesuffix("\r\n")


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
