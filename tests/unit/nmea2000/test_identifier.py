"""Identifiers: who sends what to whom."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from timonel.errors import EncodeError
from timonel.nmea2000.identifier import GLOBAL, Identifier, join, split


def test_heading_track_control_of_source_35_has_the_published_identifier():
    assert join(priority=2, pgn=127237, source=0x23) == 0x09F10523
    assert split(0x09F10523) == Identifier(priority=2, pgn=127237, source=0x23, destination=GLOBAL)


def test_a_request_to_everybody_has_the_published_identifier():
    assert join(priority=6, pgn=59904, source=0x23, destination=GLOBAL) == 0x18EAFF23
    assert split(0x18EAFF23) == Identifier(priority=6, pgn=59904, source=0x23, destination=GLOBAL)


def test_a_request_to_one_device_names_it_and_keeps_its_pgn():
    assert split(0x18EA2A23) == Identifier(priority=6, pgn=59904, source=0x23, destination=0x2A)


def test_the_last_pdu1_and_the_first_pdu2_pgn_are_told_apart():
    assert split(join(6, 0x1EF00, 1, 7)).destination == 7
    assert split(join(6, 0x1F000, 1, 7)) == Identifier(6, 0x1F000, 1, GLOBAL)


def test_socketcans_flag_bits_are_not_looked_at():
    assert split(0x80000000 | 0x09F10523) == split(0x09F10523)


@given(st.integers(0, (1 << 29) - 1))
def test_joining_what_was_split_gives_the_identifier_back(identifier):
    assert join(*split(identifier)) == identifier


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ((8, 127237, 1), "priority: 8 is outside 0..7"),
        ((2, 0x40000, 1), "PGN: 262144 is outside 0..262143"),
        ((2, 127237, 256), "source: 256 is outside 0..255"),
        ((2, 59904, 1, -1), "destination: -1 is outside 0..255"),
        ((2, 59905, 1, 255), "PGN: 59905 has a destination, so its low byte must be 0"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(arguments, text):
    with pytest.raises(EncodeError, match=text.replace(".", r"\.")):
        join(*arguments)
