from functools import reduce
from operator import xor

import pytest

from timonel.errors import EncodeError
from timonel.nmea0183.checksum import Fault, checksum, seal, verify


@pytest.mark.parametrize("length", [0, 1, 16, 17, 19, 20, 21, 32, 33, 63, 64, 65, 82, 128, 129, 256])
def test_a_check_sum_is_the_xor_of_all_bytes_whatever_the_length(length: int) -> None:
    body = bytes((index * 37 + 11) % 256 for index in range(length))
    assert checksum(body) == reduce(xor, body, 0)


@pytest.mark.parametrize(
    ("sentence", "result"),
    [
        (b"$IIHDT,182.3,T*2A", b"IIHDT,182.3,T"),
        (b"!IIHDT,182.3,T*2A", b"IIHDT,182.3,T"),
        (b"$PARP,CMDREQUEST,02*0A", b"PARP,CMDREQUEST,02"),
        (b"$PARP,CMDREQUEST,02*0a", b"PARP,CMDREQUEST,02"),
        (b"$PARP,CMDREQUEST,02*1B", Fault.WRONG_CHECKSUM),
        (b"$PARP,CMDREQUEST,02", Fault.NO_CHECKSUM),
        (b"$PARP,CMDREQUEST,02*", Fault.MALFORMED),
        (b"$PARP,CMDREQUEST,02*A", Fault.MALFORMED),
        (b"$PARP,CMDREQUEST,02*+A", Fault.MALFORMED),
        (b"$PARP,CMDREQUEST,02* A", Fault.MALFORMED),
        (b"$PARP,CMDREQUEST,02*0A ", Fault.MALFORMED),
        (b"$PARP,CMDREQUEST,02*0A0", Fault.MALFORMED),
        (b"PARP,CMDREQUEST,02*0A", Fault.MALFORMED),
        (b"$PARP,CMDREQUEST,020A", Fault.NO_CHECKSUM),
        (b"", Fault.NO_CHECKSUM),
        (b"00", Fault.NO_CHECKSUM),
        (b"*", Fault.MALFORMED),
        (b"*00", Fault.MALFORMED),
        (b"$*00", b""),
    ],
)
def test_only_exactly_two_right_digits_at_the_end_verify_a_sentence(sentence: bytes, result: bytes | Fault) -> None:
    assert verify(sentence) == result
    assert isinstance(verify(sentence), Fault) == isinstance(result, Fault)


@pytest.mark.parametrize(
    ("body", "printed", "right"),
    [
        ("PARP,STATUS,HEADING_HOLD,180.0,180.0,+0.0,01", b"*4F", b"*1B"),
        ("PARP,CMDTRANSFER,01,02", b"*3A", b"*7D"),
        ("PARP,CMDREQUEST,02", b"*1B", b"*0A"),
    ],
)
def test_the_rule_holds_not_the_printed_digits(body: str, printed: bytes, right: bytes) -> None:
    assert seal(body)[-5:-2] == right
    assert verify(seal(body)[:-5] + printed) is Fault.WRONG_CHECKSUM


def test_a_written_sentence_has_at_most_82_characters() -> None:
    assert len(seal("IITXT," + "x" * 70)) == 82
    with pytest.raises(EncodeError, match="IITXT: 83 characters, a sentence has at most 82"):
        seal("IITXT," + "x" * 71)
