"""Whatever an instrument says: no exception, nothing on the bus that another could not read, no invented value."""

from hypothesis import given, settings
from hypothesis import strategies as st

from timonel.core.effects import Transmit
from timonel.errors import EncodeError
from timonel.nmea0183.checksum import seal
from timonel.nmea2000 import registry
from timonel.nmea2000.identifier import split
from timonel.vehicles.boat.inputs import DAMAGED
from timonel.vehicles.boat.instruments import READINGS
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.vehicle import Boat

LETTERS = list("ATMNKFRLSEVWDCfGP")
FIELD = st.one_of(
    st.just(""),
    st.sampled_from(LETTERS),
    st.sampled_from(["0", "0.0", "360.0", "359.99", "-0.1", "9.99", "1e9", "nan", "99999999", "235959.99", "3645.00"]),
    st.sampled_from(["221126", "310226", "120000.00", "PITCH", "ROLL", "BUOY", "12", "HOME"]),
    st.floats(-1000, 1000).map(lambda value: f"{value:.2f}"),
)
FORMATTER = st.sampled_from(sorted(sentence.__name__ for sentence in READINGS))
SENTENCE = st.tuples(FORMATTER, st.lists(FIELD, max_size=16))


def boat() -> Boat:
    return Boat(BoatSettings(max_age=1.0), [Port("a", instrument=True), Port("b", instrument=True)], now=-10.0)


def sealed(formatter: str, fields: list[str]) -> bytes:
    try:
        return seal(",".join([f"II{formatter}", *fields]))
    except EncodeError:
        return b""  # longer than a sentence may be


@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(SENTENCE, st.booleans(), st.floats(0, 3)), max_size=8))
def test_any_sentences_give_messages_that_can_be_read(said):
    vessel, now = boat(), 0.0
    for (formatter, fields), port, pause in said:
        now += pause
        for effect in vessel.receive_bytes("b" if port else "a", sealed(formatter, fields), now):
            if isinstance(effect, Transmit):
                target = split(effect.frame.identifier)
                assert target.source == vessel.address
                assert registry.is_fast(target.pgn) or registry.decode(target.pgn, effect.frame.data) is not None


@settings(max_examples=200, deadline=None)
@given(st.lists(st.binary(max_size=80), max_size=6))
def test_any_bytes_are_survived(chunks):
    vessel = boat()
    for number, chunk in enumerate(chunks):
        vessel.receive_bytes("a", chunk, float(number))


@settings(max_examples=200, deadline=None)
@given(FORMATTER, st.integers(0, 16))
def test_empty_fields_tell_no_value(formatter, count):
    vessel = boat()
    vessel.receive_bytes("a", sealed(formatter, [""] * count), 0.0)
    truth = vessel.truth
    told = (
        truth.true,
        truth.position,
        truth.course,
        truth.speed,
        truth.depth,
        truth.rudder,
        truth.clock,
        truth.current,
    )
    assert [datum.value for datum in told] == [None] * len(told)
    assert all(wind.value is None for wind in truth.winds.values())


def test_what_counts_as_damaged_is_what_a_bad_line_makes():
    assert {str(fault) for fault in DAMAGED} == {"wrong check sum", "no check sum", "malformed"}
