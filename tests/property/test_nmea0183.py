"""What holds for every sentence and every byte."""

import datetime
import random
from decimal import Decimal
from functools import reduce
from itertools import pairwise
from operator import xor
from typing import Any

import pynmea2
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from timonel.nmea0183 import fields, parp
from timonel.nmea0183.checksum import Fault, checksum, verify
from timonel.nmea0183.framing import SentenceFramer
from timonel.nmea0183.parp import Command, Verb
from timonel.nmea0183.registry import SENTENCES, parse
from timonel.nmea0183.sentence import Sentence, layout
from timonel.nmea0183.sentences import ALC, GGA, RMB, XDR, Listed, Mode, Transducer

MUTATIONS = 100_000
"""Mutated sentences in one run; a long run sets a million."""

TYPES = sorted((kind for kind in SENTENCES.values() if kind not in (ALC, XDR)), key=lambda kind: kind.__name__)
PRINTABLE = st.text(
    st.characters(min_codepoint=0x20, max_codepoint=0xFF).filter(str.isprintable), min_size=1, max_size=4
)


def values(kind: fields.Field) -> st.SearchStrategy[Any]:
    """Values of one kind, as they can be printed without loss, small enough that sentences stay short."""
    match kind:
        case fields.Angle():
            return st.integers(0, 3599).map(lambda tenths: tenths / 10)
        case fields.Number(decimals=decimals, low=low, high=high, ceiling=ceiling):
            scale = 10**decimals
            top = min(high, 99.0 if ceiling is None else ceiling)
            return st.integers(int(max(low, -9.0) * scale), int(top * scale)).map(lambda number: number / scale)
        case fields.Signed(decimals=decimals, high=high):
            scale = 10**decimals
            return st.integers(int(-min(high, 9.0) * scale), int(min(high, 9.0) * scale)).map(lambda n: n / scale)
        case fields.Position(limit=limit):
            return st.floats(-limit, limit)
        case fields.TimeOfDay():
            return st.integers(0, 8_650_099).filter(lambda n: n < 8_640_100).map(lambda n: n / 100)
        case fields.Date():
            return st.dates(datetime.date(1980, 1, 1), datetime.date(2079, 12, 31))
        case fields.Integer(low=low, high=high):
            return st.integers(low, high)
        case fields.Letter(choices=choices):
            return st.sampled_from(list(choices))
        case fields.Status():
            return st.booleans()
        case fields.Text():
            return PRINTABLE
    raise AssertionError(kind)


def consistent(sentence: Sentence) -> bool:
    """Whether the status goes with the mode, as it always does in what is read."""
    return not (getattr(sentence, "valid", None) and getattr(sentence, "mode", None) not in fields.VALID_MODES)


def sentences(kind: type[Sentence]) -> st.SearchStrategy[Sentence]:
    attributes = {name: st.none() | values(field) for name, field in layout(kind).items()}
    if kind is GGA:
        attributes["reference_station"] = st.none()  # with everything else in it, GGA has no room for it
    if kind is RMB:
        attributes["origin"] = st.none()  # nor has RMB for two names all of whose characters are escaped
    return st.builds(kind, **attributes).filter(consistent)


@pytest.mark.parametrize("kind", TYPES, ids=lambda kind: kind.__name__)
@settings(max_examples=30)
@given(data=st.data())
def test_every_sentence_survives_the_round_trip(kind: type[Sentence], data: st.DataObject) -> None:
    sentence = data.draw(sentences(kind))
    written = sentence.encode()
    read = parse(written[:-2])
    assert len(written) <= 82
    assert type(read) is kind
    assert read.encode() == written
    for name, field in layout(kind).items():
        before, after = getattr(sentence, name), getattr(read, name)
        if isinstance(field, fields.Position | fields.TimeOfDay):
            assert after == pytest.approx(before, abs=1e-8), name
        else:
            assert after == before, name


@given(
    st.lists(
        st.builds(
            Transducer,
            kind=st.none() | PRINTABLE,
            value=st.none() | st.integers(-9_999_999, 9_999_999).map(lambda n: n / 1e5),
            unit=st.none() | PRINTABLE,
            name=st.none() | PRINTABLE,
        ),
        min_size=1,
        max_size=1,
    )
)
def test_transducers_survive_the_round_trip(transducers: list[Transducer]) -> None:
    sentence = XDR(tuple(transducers))
    assert parse(sentence.encode()[:-2]) == sentence


@settings(max_examples=50)
@given(
    st.lists(
        st.builds(
            Listed,
            maker=st.none() | st.just("ARP"),
            alarm=st.none() | st.integers(0, 9_999_999),
            instance=st.none() | st.integers(0, 999_999),
            revision=st.none() | st.integers(0, 99),
        ),
        max_size=2,
    )
)
def test_lists_of_alerts_survive_the_round_trip(alerts: list[Listed]) -> None:
    sentence = ALC(1, 1, 0, tuple(alerts))
    assert parse(sentence.encode()[:-2]) == sentence


@pytest.mark.parametrize("kind", TYPES, ids=lambda kind: kind.__name__)
@settings(max_examples=30)
@given(data=st.data())
def test_everything_written_is_a_sentence_to_pynmea2(kind: type[Sentence], data: st.DataObject) -> None:
    written = data.draw(sentences(kind)).encode().decode("ascii")
    if kind.__name__.encode() in KNOWN_TO_PYNMEA2:
        theirs = pynmea2.parse(written, check=True)
        assert theirs.sentence_type == kind.__name__
        assert theirs.data == written[7:-5].split(",")


KNOWN_TO_PYNMEA2 = frozenset(SENTENCES) & {name.encode() for name in pynmea2.TalkerSentence.sentence_types}


def test_pynmea2_knows_most_of_the_sentences() -> None:
    assert len(KNOWN_TO_PYNMEA2) >= 20


@given(st.floats(-1e6, 1e6))
def test_a_number_is_the_exact_value_rounded_half_even_to_its_last_digit(value: float) -> None:
    printed = SENTENCES[b"ROT"](value, True).encode()[7:-7]  # type: ignore[call-arg]
    assert Decimal(printed.decode()) == Decimal(value).quantize(Decimal("0.1"))
    assert printed != b"-0.0"


@given(st.binary())
def test_the_check_sum_is_the_xor_of_the_bytes(body: bytes) -> None:
    assert checksum(body) == reduce(xor, body, 0)


@given(st.integers(-99_999_999, 99_999_999))
def test_set_headings_are_the_decimal_number_rounded_and_wrapped(ten_thousandths: int) -> None:
    number = Decimal(ten_thousandths).scaleb(-4)
    expected = int(number.quantize(Decimal("0.1")).scaleb(1)) % 3600
    assert parp.parse_command(f"PARP,SETHEADING,{number:f},01".encode()) == Command(
        Verb.SETHEADING, station=1, heading_tenths=expected
    )


# Pieces of a hostile stream: starts, ends, TAG block marks, garbage, good sentences, very long ones.
PIECES = st.sampled_from(
    [b"$", b"!", b"\r", b"\n", b"\r\n", b"\\", b"*", b"\x00", b"\xff", b"abc", b"x" * 30,
     b"\\s:a*00\\", b"$IIHDT,1.0,T*1C\r\n"]
)  # fmt: skip


@given(st.lists(PIECES, max_size=40), st.lists(st.integers(0, 400), max_size=20))
def test_chunking_changes_neither_sentences_nor_counters(pieces: list[bytes], cuts: list[int]) -> None:
    stream = b"".join(pieces) + b"\n"
    whole, cut = SentenceFramer(longest=40), SentenceFramer(longest=40)
    edges = sorted({0, len(stream), *(place for place in cuts if place < len(stream))})
    received = [line for start, end in pairwise(edges) for line in cut.receive(stream[start:end])]
    assert received == whole.receive(stream)
    for counter in ("garbage_bytes", "overlong", "unprintable"):
        assert getattr(cut, counter) == getattr(whole, counter)


@given(st.binary(max_size=300))
def test_the_next_good_sentence_is_understood_after_any_garbage(garbage: bytes) -> None:
    framer = SentenceFramer()
    framer.receive(garbage)
    assert framer.receive(b"\r\n$PARP,REQCMD,000.0,01*1C\r\n")[-1] == b"$PARP,REQCMD,000.0,01*1C"


def _seeds() -> list[bytes]:
    commands = [parp.command(verb, station, 123.4)[:-2] for verb in Verb for station in (1, 4)]
    short = [b"$PARP,RELCMD,02*00", b"$PARP,DENYCMD,02*4D", b"$PARP,ACKCMD,02*12"]
    data = [
        b"$GPRMC,120000.25,A,4330.000000,N,00815.000000,W,6.1,84.4,010826,3.1,W,D*5C",
        b"$AGHTD,V,,,H,N,25.0,20.0,,,190.4,,,T,A,A,A,186.4*35",
        b"$IIXDR,A,-2.5,D,ROLL,P,1.026,B,*30",
        b"$GPGGA,120000,4330.000000,N,00815.000000,W,1,08,0.9,12.3,M,54.1,M,3,0120*57",
        b"$IIALR,120000,041,A,V,PILOT OFF COURSE*5A",
        b"$GPAPB,A,A,0.250,L,N,V,V,213.9,T,CABO,213.9,T,211.0,M,A*5D",
    ]
    return commands + short + data


def _mutated(chance: random.Random, seed: bytes) -> bytes:
    """`seed` with one to three bytes changed, taken out, put in or doubled; half of them with a right check sum."""
    line = bytearray(seed)
    for _ in range(chance.randint(1, 3)):
        place = chance.randrange(len(line) + 1)
        match chance.randrange(5):
            case 0:
                line[place : place + 1] = bytes([chance.randrange(256)])
            case 1:
                line[place : place + 1] = chance.choice(b"0123456789,.-*$!+eE \x00").to_bytes()
            case 2:
                del line[place : place + chance.randint(1, 4)]
            case 3:
                line[place:place] = line[place : place + chance.randint(1, 6)]
            case 4:
                line[place:place] = chance.choice([b",", b"0", b"nan", b"1e9", b"\xff", b" "])
    body, star, _ = bytes(line).rpartition(b"*")
    return b"%b*%02X" % (body, reduce(xor, body[1:], 0)) if star and chance.random() < 0.5 else bytes(line)


def _lawful(line: bytes) -> bool:
    """The grammar of commands, stated once more and independently of the parser."""
    body, digits = line[1:-3], line[-2:]
    if line[:1] != b"$" or line[-3:-2] != b"*" or digits.upper() != b"%02X" % reduce(xor, body, 0):
        return False
    match body.decode("latin-1").split(","):
        case ["PARP", word, parameter, "01" | "02" | "03" | "04"] if word in list(Verb):
            return _is_number(parameter) or (parameter == "" and word != "SETHEADING")
        case ["PARP", "RELCMD" | "ACKCMD" | "DENYCMD", "01" | "02" | "03" | "04"]:
            return True
    return False


def _is_number(text: str) -> bool:
    whole, point, fraction = text.removeprefix("-").partition(".")
    digits = set("0123456789")
    return (
        1 <= len(whole) <= 4
        and set(whole) <= digits
        and (not point or 1 <= len(fraction) <= 4)
        and set(fraction) <= digits
    )


def test_no_mutated_sentence_raises_and_no_unlawful_one_commands() -> None:
    chance = random.Random(20260801)
    seeds = _seeds()
    commands = 0
    for _ in range(MUTATIONS):
        line = _mutated(chance, chance.choice(seeds))
        command = parp.read_command(line)
        commands += isinstance(command, Command)
        assert isinstance(command, Command) == _lawful(line), line
        parse(line)
        parp.read_report(line)
    assert commands > MUTATIONS / 100  # the mutations still reach the far side of the check sum


@given(st.binary(max_size=100))
def test_arbitrary_bytes_are_never_a_sentence_without_a_right_check_sum(line: bytes) -> None:
    for reading in (parse(line), parp.read_command(line), parp.read_report(line)):
        assert isinstance(reading, Fault)
    assert isinstance(verify(line), Fault) or reduce(xor, line[1:-3], 0) == int(line[-2:], 16)


@given(st.sampled_from(list(SENTENCES)), st.lists(st.text(st.characters(max_codepoint=0x7F), max_size=8), max_size=20))
def test_arbitrary_fields_behind_a_right_check_sum_give_a_sentence_or_a_fault(
    formatter: bytes, texts: list[str]
) -> None:
    body = b"II" + formatter + "".join("," + text for text in texts).encode()
    read = parse(b"$%b*%02X" % (body, checksum(body)))
    assert isinstance(read, Sentence | Fault)
    if isinstance(read, Sentence) and getattr(read, "mode", None) is Mode.NOT_VALID:
        assert not getattr(read, "valid", False)
