import pytest
from hypothesis import given
from hypothesis import strategies as st

from timonel.nmea0183.sixbit import ARMOUR, LETTERS, armour, dearmour, read_text, write_text


def test_the_armour_of_every_value_is_the_standards() -> None:
    """IEC 61162-1, Annex C: 0 is `0`, 39 is `W`, 40 is a grave accent, 63 is `w`."""
    values = [dearmour(bytes((character,)), 0) for character in b"0W`w"]
    assert values == [(0, 6), (39, 6), (40, 6), (63, 6)]


@given(st.binary(min_size=1, max_size=60), st.integers(0, 7))
def test_what_is_armoured_comes_back(data: bytes, short: int) -> None:
    length = 8 * len(data) - short
    bits = int.from_bytes(data, "big") >> short
    payload, fill = armour(bits, length)
    assert (len(payload) * 6 - fill, fill < 6) == (length, True)
    assert dearmour(payload, fill) == (bits, length)


@pytest.mark.parametrize(
    ("payload", "fill"), [(b"", 0), (b"0", 6), (b"0X0", 0), (b"0 0", 0), (b"0\xff", 0), (b"0", -1)]
)
def test_what_no_transponder_writes_is_nothing(payload: bytes, fill: int) -> None:
    assert dearmour(payload, fill) is None


@given(st.text(alphabet=LETTERS[1:].decode(), min_size=1, max_size=20))
def test_letters_come_back_without_the_spaces_behind_them(text: str) -> None:
    assert read_text(write_text(text, 20), 20) == (text.rstrip() or None)


def test_what_has_no_letter_is_a_question_mark_and_small_letters_are_great() -> None:
    assert read_text(write_text("Ñandú ~", 8), 8) == "?AND? ?"


def test_both_alphabets_have_each_value_once() -> None:
    assert (len(set(ARMOUR)), len(set(LETTERS))) == (64, 64)
