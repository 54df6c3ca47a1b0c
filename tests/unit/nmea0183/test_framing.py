import pytest
from hypothesis import given
from hypothesis import strategies as st

from timonel.nmea0183.framing import SentenceFramer

HDT = b"$IIHDT,182.3,T*2A"
ROT = b"$IIROT,-3.0,A*08"


@pytest.mark.parametrize("end", [b"\r\n", b"\n", b"\r", b"\r\r\n\n"])
def test_a_line_ends_with_cr_lf_or_both(end: bytes) -> None:
    framer = SentenceFramer()
    assert framer.receive(HDT + end + ROT + end) == [HDT, ROT]


def test_a_sentence_comes_out_when_its_line_ends_and_not_before() -> None:
    framer = SentenceFramer()
    assert framer.receive(HDT) == []
    assert framer.receive(b"\r") == [HDT]
    assert framer.receive(b"\n") == []


def test_an_encapsulated_sentence_begins_with_an_exclamation_mark() -> None:
    assert SentenceFramer().receive(b"!AIVDM,1,1,,A,13u,0*00\r\n") == [b"!AIVDM,1,1,,A,13u,0*00"]


@pytest.mark.parametrize("start", [b"$GPGGA,12", b"!AIVDM,1,1", b"\x00\xff$"])
def test_the_last_start_in_a_line_wins(start: bytes) -> None:
    framer = SentenceFramer()
    assert framer.receive(start + HDT + b"\r\n") == [HDT]
    assert framer.garbage_bytes == len(start)


def test_a_tag_block_is_stripped_and_is_not_garbage() -> None:
    framer = SentenceFramer()
    assert framer.receive(b"\\s:II1,c:1700000000*0B\\" + HDT + b"\r\n") == [HDT]
    assert framer.garbage_bytes == 0


@pytest.mark.parametrize("half", [b"\\", b"\\s:II1*78", b"s:II1*78\\", b"\\s:II1*79\\"])
def test_half_a_tag_block_or_a_broken_one_is_garbage(half: bytes) -> None:
    framer = SentenceFramer()
    assert framer.receive(half + HDT + b"\r\n") == [HDT]
    assert framer.garbage_bytes == len(half)


def test_garbage_before_a_sentence_is_dropped_and_counted() -> None:
    framer = SentenceFramer()
    assert framer.receive(b"\x00\x00\x80hello\r\n\x00" + HDT + b"\r\n") == [HDT]
    assert framer.garbage_bytes == 9


@pytest.mark.parametrize("bad", [b"\x00", b"\x1b", b"\x7f", b"\x80", b"\xff", b"\t"])
def test_a_sentence_with_a_control_or_8_bit_byte_is_dropped_and_counted(bad: bytes) -> None:
    framer = SentenceFramer()
    assert framer.receive(HDT[:8] + bad + HDT[8:] + b"\r\n" + ROT + b"\r\n") == [ROT]
    assert (framer.unprintable, framer.garbage_bytes, framer.overlong) == (1, 0, 0)


def test_a_sentence_as_long_as_allowed_passes_and_one_more_is_dropped_and_counted() -> None:
    framer = SentenceFramer(longest=20)
    assert framer.receive(b"$" + b"x" * 19 + b"\r\n") == [b"$" + b"x" * 19]
    assert framer.receive(b"$" + b"x" * 20 + b"\r\n" + HDT + b"\r\n") == [HDT]
    assert (framer.overlong, framer.garbage_bytes) == (1, 0)


def test_a_stream_without_line_ends_is_not_kept() -> None:
    framer = SentenceFramer(longest=20)
    for _ in range(1000):
        framer.receive(b"$" + b"x" * 30)
        assert len(framer._rest) <= 21
    assert framer.receive(b"\r\n" + HDT + b"\r\n") == [HDT]
    assert framer.overlong == 1


def test_a_sentence_behind_endless_garbage_is_understood() -> None:
    framer = SentenceFramer(longest=20)
    assert framer.receive(b"\x55" * 100_000) == []
    assert framer.receive(HDT + b"\r\n") == [HDT]
    assert framer.garbage_bytes == 100_000


@given(
    st.text("$!,A9\\\r\n\x00\xff", max_size=24), st.sampled_from(["$", "!", ""]), st.sampled_from(["\r\n", "\n", ""])
)
def test_a_line_that_comes_at_once_is_cut_as_if_it_came_byte_by_byte(middle: str, start: str, end: str) -> None:
    data = (start + middle + end).encode("latin-1")
    whole, trickle = SentenceFramer(longest=20), SentenceFramer(longest=20)
    assert whole.receive(data) == [s for byte in data for s in trickle.receive(bytes((byte,)))]
    assert whole.receive(HDT + b"\r\n") == trickle.receive(HDT + b"\r\n")
    counted = ("overlong", "garbage_bytes", "unprintable")
    assert [getattr(whole, name) for name in counted] == [getattr(trickle, name) for name in counted]
