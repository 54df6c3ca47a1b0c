"""Check sums: the XOR of the characters between the start and the `*`, as two hexadecimal digits.

Upper-case digits are written; either case is read. Source: NMEA 0183 (IEC 61162-1), 7.2.4.
"""

from enum import StrEnum
from functools import reduce
from operator import xor

from timonel.errors import EncodeError

LONGEST = 82
"""Characters of a written sentence, from `$` to the line feed."""

ENDINGS = tuple(b"*%02X\r\n" % value for value in range(256))
"""What a sentence ends with, by check sum."""

_STARTS = b"$!"
_DIGITS = "0123456789ABCDEFabcdef"
_VALUES = {(high + low).encode(): int(high + low, 16) for high in _DIGITS for low in _DIGITS}


class Fault(StrEnum):
    """Why a received sentence was not understood: a cause to count, not an exception."""

    NO_CHECKSUM = "no check sum"
    WRONG_CHECKSUM = "wrong check sum"
    MALFORMED = "malformed"
    UNKNOWN_SENTENCE = "unknown sentence"
    UNKNOWN_COMMAND = "unknown command"


def checksum(body: bytes) -> int:
    """XOR of all bytes of `body`. To fold one integer is faster than to go through the bytes, if they are many."""
    size = len(body)
    if size < 20 or size > 128:
        return reduce(xor, body, 0)
    folded = int.from_bytes(body, "little")
    if size > 64:
        folded ^= folded >> 512
    if size > 32:
        folded ^= folded >> 256
    folded ^= folded >> 128
    folded ^= folded >> 64
    folded ^= folded >> 32
    folded ^= folded >> 16
    return (folded ^ folded >> 8) & 0xFF


def verify(sentence: bytes) -> bytes | Fault:
    """The body of `sentence` (what stands between its start and its `*`), or why there is none.

    `sentence` begins with `$` or `!` and ends with exactly two hexadecimal digits, without CR and LF.
    """
    body = sentence[1:-3]
    if checksum(body) == _VALUES.get(sentence[-2:]) and sentence[-3:-2] == b"*" and sentence[0] in _STARTS:
        return body
    if b"*" not in sentence:
        return Fault.NO_CHECKSUM
    well_formed = sentence[-3:-2] == b"*" and sentence[-2:] in _VALUES and sentence[0] in _STARTS
    return Fault.WRONG_CHECKSUM if well_formed else Fault.MALFORMED


def seal(body: str) -> bytes:
    """`body` as a sentence to send: `$`, the body, its check sum, CR LF.

    Raises EncodeError if that makes more than the 82 characters a listener must be able to take.
    """
    data = body.encode()
    if len(data) > LONGEST - 6:
        raise EncodeError(f"{body[:5]}: {len(data) + 6} characters, a sentence has at most {LONGEST}")
    return b"$" + data + ENDINGS[checksum(data)]
