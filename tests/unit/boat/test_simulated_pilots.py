"""The simulated pilots answer with the bytes of the recorded ones."""

import pytest

from tests.unit.boat.pilots.test_bytes import recorded
from timonel.nmea2000.lookups import HeadingReference
from timonel.nmea2000.messages.garmin import GarminAutopilotModeState
from timonel.vehicles.boat.simulated_pilots import GarminDialect, NavicoDialect, RaymarineDialect
from timonel.vehicles.boat.simulator import Heard

EV1, TP32, REACTOR = "raymarine-ev1.raw", "simnet-tp32.raw", "garmin-ap-reactor-126720.raw"


def told(dialect, pgn, payload, destination=255, heading=1.0):
    """What a pilot answers at once, as (PGN, payload)."""
    heard = Heard(pgn, bytes.fromhex(payload), 35, destination)
    return [(answer.pgn, answer.payload.hex()) for answer in dialect.receive(heard, heading)]


def said_in(name):
    return {(pgn, payload) for pgn, _, _, payload in recorded(name)}


@pytest.mark.parametrize("mode", ["4000", "0000"])
def test_a_raymarine_pilot_acknowledges_a_mode_and_tells_it(mode):
    answers = told(RaymarineDialect(), 126208, f"0163ff00f804013b07030404{mode}05ffff", destination=93)
    assert set(answers[:2]) < said_in(EV1)
    assert [pgn for pgn, _ in answers[:2]] == [126208, 65379]


def test_a_raymarine_pilot_acknowledges_a_course_and_tells_it():
    pilot = RaymarineDialect()
    pilot.engage(1.0)
    answers = told(pilot, 126208, "0150ff00f803013b07030406c1f2", destination=93)
    assert answers[0] in said_in(EV1)
    assert (65360, "3b9fffffffc1f2ff") in answers
    assert (65360, "3b9fffffffc1f2ff") in said_in(EV1)


def test_a_raymarine_pilot_that_stands_by_takes_no_course():
    pilot = RaymarineDialect()
    told(pilot, 126208, "0150ff00f803013b07030406c1f2", destination=93)
    assert not pilot.law.engaged


@pytest.mark.parametrize("command", ["419f00ffff0a0900ffffffff", "419f00ffff0a1a0003ae00ff"])
def test_a_navico_pilot_copies_what_was_addressed_to_it(command):
    pilot = NavicoDialect()
    pilot.address = 0
    answers = told(pilot, 130850, command)
    assert answers[0] == (130851, command)
    assert answers[0] in said_in(TP32)


@pytest.mark.parametrize(
    ("command", "obeys", "answers"),
    [
        ("419f5dffff0a0900ffffffff", True, True),
        ("419fffffff0a0900ffffffff", True, False),
        ("419f02ffff0a0900ffffffff", False, False),
        ("419f5dffff0a09ffffffffff", False, False),
        ("419fffffff01174900ffffff", False, False),
    ],
)
def test_a_navico_pilot_obeys_what_is_for_it_and_has_00_in_byte_7(command, obeys, answers):
    pilot = NavicoDialect()
    said = told(pilot, 130850, command)
    assert pilot.law.engaged is obeys
    assert any(pgn == 130851 for pgn, _ in said) is answers


def test_a_navico_pilot_tells_its_state_as_recorded_ones_do():
    state = {(one.pgn, one.payload.hex()) for one in NavicoDialect().speak(0, 1.0, 0.0) if one.pgn != 127237}
    assert state < said_in("can0-2.pcap")


def test_a_garmin_pilot_repeats_its_mode_to_everybody_and_tells_the_new_heading():
    pilot = GarminDialect()
    assert told(pilot, 126720, "e5981017040405 0a 00 05 00", destination=93) == [
        (126720, "e5981017040405" + "0a000500")
    ]
    assert told(pilot, 126720, "e5981017040405 0a 00 02 00", destination=93)[0] in said_in(REACTOR)
    pilot.law.hold(1.0, HeadingReference.MAGNETIC)
    ((_, heading),) = told(pilot, 126720, "e59810170404260200", destination=93)
    assert heading.startswith("e59810170404000b00")
    assert pilot.law.setpoint == pytest.approx(1.0174533)


def test_a_garmin_pilot_hears_what_is_for_it_and_turns_only_when_engaged():
    pilot = GarminDialect()
    engage = GarminAutopilotModeState(mode_state=5).encode().hex()
    assert told(pilot, 126720, engage, destination=7) == []
    assert told(pilot, 126720, "e59810170404260200", destination=93) == []
    assert told(pilot, 126720, engage, destination=255) != []
