import pytest

from timonel.nmea0183.checksum import Fault, checksum
from timonel.nmea0183.tag_block import NOTHING, TagBlock, is_sound, read, split, write


def block(body: str) -> bytes:
    return b"%b*%02X" % (body.encode(), checksum(body.encode()))


def test_a_block_tells_who_when_and_which_part() -> None:
    told = read(block("g:1-2-34,s:VR0001,d:II0002,n:12,c:1700000000,x:new"))
    assert told == TagBlock("VR0001", "II0002", 12, (1, 2, 34), 1_700_000_000.0)


def test_a_time_in_milliseconds_is_told_from_one_in_seconds() -> None:
    assert read(block("c:1700000000123")) == TagBlock(time=1_700_000_000.123)


@pytest.mark.parametrize("tag", [NOTHING, TagBlock("II0001", "HE0001", 999, (2, 2, 7), 1_700_000_000.0)])
def test_what_is_written_is_read_back(tag) -> None:
    data = write(tag)
    assert is_sound(data)
    assert split(data + b"$IIHDT,1.0,T*2F") == (tag, b"$IIHDT,1.0,T*2F")


def test_a_line_without_a_block_has_an_empty_one() -> None:
    assert split(b"$IIHDT,1.0,T*2F") == (NOTHING, b"$IIHDT,1.0,T*2F")


BROKEN = {
    b"s:II0001": Fault.MALFORMED,
    b"s:II0001*7": Fault.MALFORMED,
    b"s:II0001*GG": Fault.MALFORMED,
    b"s:II0001*00": Fault.WRONG_CHECKSUM,
    b"s:\xe9*00": Fault.MALFORMED,
    block("n:many"): Fault.MALFORMED,
    block("g:1-2"): Fault.MALFORMED,
    block("g:1-2-x"): Fault.MALFORMED,
    block("c:now"): Fault.MALFORMED,
}


@pytest.mark.parametrize("data", BROKEN)
def test_a_broken_block_is_a_fault_and_not_a_guess(data) -> None:
    assert read(data) == BROKEN[data]
    assert split(b"\\" + data + b"\\$IIHDT") == (BROKEN[data], b"$IIHDT")


def test_half_a_block_is_a_fault() -> None:
    assert split(b"\\s:II0001*34")[0] == Fault.MALFORMED
    assert not is_sound(b"\\")
