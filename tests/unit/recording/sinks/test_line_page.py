"""Lines that the kernel writes, and those that it leaves to others."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from timonel.nmea2000 import catalogue
from timonel.nmea2000.identifier import join
from timonel.recording.assembly import Assembly
from timonel.recording.decoded import Decoder
from timonel.recording.frames import Frames, from_logframes
from timonel.recording.lines import LogFrame
from timonel.recording.sinks import line_page
from timonel.recording.sinks.jsonl import JsonLines

pytestmark = pytest.mark.usefixtures("each_way")

SIXTY_FOUR = st.integers(-(1 << 63), (1 << 63) - 1)
THIRTY_TWO = st.integers(-(1 << 31), (1 << 31) - 1)
EDGES = [
    0,
    1,
    -1,
    9,
    10,
    99,
    100,
    10**15 - 1,
    10**15,
    -(10**15),
    10**16 - 1,
    10**16 + 1,
    9 * 10**17,
    2**53 + 1,
    -(2**62),
]


def messages(pgn, payloads):
    return [LogFrame(1.5, join(3, pgn, 7), payload, whole=True) for payload in payloads]


def one_by_one(frames, labels=True):
    decoder = Decoder()
    return [decoder.receive(frame).line(labels) for frame in frames]


def at_once(frames, **options):
    part = from_logframes(frames)
    text = bytes(JsonLines(**options).lines(Assembly().receive(part), 0, len(part)))
    return text.decode().removesuffix("\n").split("\n")


def position(latitude, longitude, altitude):
    return struct.pack("<BHIqqqBBB", 1, 19000, 0, latitude, longitude, altitude, 0x12, 0xFC, 8)


@given(st.lists(st.tuples(SIXTY_FOUR, SIXTY_FOUR, SIXTY_FOUR), min_size=1))
def test_a_number_of_64_bits_has_the_fewest_digits_that_are_read_as_its_float(positions):
    frames = messages(129029, [position(*one) for one in positions])
    assert at_once(frames) == one_by_one(frames)


def test_numbers_around_powers_of_ten_and_of_two_are_printed_as_python_prints_them():
    powers = [sign * (base**exponent + more) for base, most in ((10, 19), (2, 63)) for exponent in range(most)
              for sign in (-1, 1) for more in (-1, 0, 1)]  # fmt: skip
    raws = [raw for raw in (*EDGES, *powers) if -(1 << 63) <= raw < 1 << 63]
    frames = messages(129029, [position(raw, raw, raw) for raw in raws])
    assert at_once(frames) == one_by_one(frames)


@given(st.lists(st.one_of(THIRTY_TWO, st.integers(-5000, 5000)), min_size=1))
def test_what_is_below_a_ten_thousandth_has_an_exponent(rates):
    frames = messages(127251, [struct.pack("<Bi3s", 0, rate, b"\xff\xff\xff") for rate in rates])
    assert at_once(frames) == one_by_one(frames)


NAMES = [
    b"TIMONEL", b"", b"@@@@@@@", b"with blank  ", b" first", b'a "quoted" word', rb"back\slash", b"tab\tin it",
    b"tab behind\t", b"\x01", b"caf\xe9", "café".encode(), b"a\0b", b"a\xffb", b"\xff\xff", b"\x1f \x1c", b"del\x7f",
]  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_text_of_fixed_size_is_written_as_that_of_single_messages(name):
    payload = b"\x18\x01\x02\x03\x0d" + name[:20].ljust(20, b"@") + b"\xff\xff"
    frames = messages(129809, [payload, payload[: 5 + len(name)], payload[:6]])
    assert at_once(frames) == one_by_one(frames)


@pytest.mark.parametrize("kind", [0, 1, 2, 255])
@pytest.mark.parametrize("name", NAMES)
def test_text_that_tells_its_length_is_written_as_that_of_single_messages(kind, name):
    texts = [bytes((size, kind)) + name for size in (0, 1, 2, 3, len(name), len(name) + 2, 255)]
    payloads = [bytes(2) + text + b"\x04\x01ok" for text in texts]
    frames = messages(126998, [payload[:size] for payload in payloads for size in (2, 3, 4, 5, 223)])
    assert at_once(frames) == one_by_one(frames)


def recorded():
    """A payload of each kind that may be cut anywhere: text, items that are counted, items with keys."""
    satellites = bytes((1, 0xFD, 2)) + bytes(range(12)) + bytes((7, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11))
    route = struct.pack("<HHHHB", 0, 2, 5, 9, 0xFF) + b"\x07\x01route\xff" + b"".join(
        struct.pack("<H", number) + b"\x06\x01wp-%d" % number + struct.pack("<ii", 10**8, -(10**8)) for number in (1, 2)
    )  # fmt: skip
    keys = bytes.fromhex("7d99") + bytes.fromhex("4121e803 4220ffff 0341 55aa55aa 9010 aa".replace(" ", ""))
    address = bytes.fromhex("3c0e631e00a032c0")
    return {129540: satellites, 129285: route, 130824: keys, 60928: address, 127501: b"\0" + b"\x1b" * 7}


@pytest.mark.parametrize("labels", [True, False])
@pytest.mark.parametrize("pgn", recorded())
def test_a_message_that_is_cut_short_anywhere_gives_the_line_of_a_single_message(pgn, labels):
    payload = recorded()[pgn]
    frames = messages(pgn, [payload[:size] for size in range(len(payload) + 1)])
    assert at_once(frames, labels=labels) == one_by_one(frames, labels)


@given(pgn=st.sampled_from([129540, 129285, 130824, 60928, 130820, 129809, 126464]), data=st.binary(max_size=223))
def test_any_bytes_behind_a_known_beginning_give_the_line_of_a_single_message(pgn, data):
    definition = catalogue.variants(pgn)[0]
    mask, value, size = definition.pattern
    begun = int.from_bytes(data, "little") & ~mask | value
    frames = messages(pgn, [data, begun.to_bytes(max(size, len(data)), "little")])
    assert at_once(frames) == one_by_one(frames)


def test_a_page_that_is_too_small_becomes_larger(monkeypatch):
    monkeypatch.setattr(line_page, "_START", 1)
    frames = messages(129809, [b"\x18\x01\x02\x03\x0d" + b"N" * 20] * 3 + [b"\x18\x01\x02\x03\x0dcaf\xe9"] * 3)
    assert at_once(frames) == one_by_one(frames)


def test_lines_that_are_written_otherwise_stand_in_their_place():
    heading = LogFrame(1.0, join(2, 127250, 7), bytes.fromhex("0083E9FF7FFF7FFD"))
    floats = LogFrame(2.0, join(2, 126720, 7), bytes.fromhex("E59804 0000") + struct.pack("<f", 1.5), whole=True)
    request = LogFrame(3.0, join(2, 126208, 7), bytes.fromhex("00 12F101 FFFFFFFF FFFF 00"), whole=True)
    frames = [heading, request, floats, heading, request] * 30
    assert at_once(frames) == one_by_one(frames)


def test_a_time_is_rounded_to_the_microsecond_however_rare_its_message_is():
    for count in (1, 50):
        rows = from_logframes([LogFrame(1.0, join(2, 127250, 7), bytes(8))] * count)
        frames = Frames(rows.rows, np.full(count, 1_000_000_600, np.int64), rows.spill)
        text = bytes(JsonLines().lines(Assembly().receive(frames), 0, count))
        assert text.count(b'{"time": 1.000001, ') == count
