"""`strzyga-crc`: `#`, id, data, CRC. For teams that can change their firmware; in C it is in `firmware/`.

The CRC is CRC-16/CCITT-FALSE (polynomial 0x1021, initially 0xFFFF, nothing reflected or inverted; of "123456789"
it is 0x29B1) over id and data. It is sent high byte first, unlike the numbers in the data: so the CRC over id,
data and CRC together is 0, and errors within any two neighbouring bytes of them are always found. A frame is
emitted with its last byte; nothing needs to follow.

Source: spec/rover.md, Framing without a check sum (the order of the two bytes is ours).
"""

from binascii import crc_hqx

from timonel.vehicles.rover.framing.framer import Framer, check
from timonel.vehicles.rover.framing.strzyga import any_byte

_INITIAL = 0xFFFF


class StrzygaCrc(Framer):
    """The parser and writer of the documented framing with a CRC behind it."""

    @staticmethod
    def write(number: int, data: bytes) -> bytes:
        """`#`, id, data, CRC."""
        check(number, data, StrzygaCrc.LONGEST)
        body = b"%c%b" % (number, data)
        return b"#%b%b" % (body, crc_hqx(body, _INITIAL).to_bytes(2, "big"))

    @staticmethod
    def _id(numbers: bytes) -> bytes:
        return any_byte(numbers)

    @staticmethod
    def _frame(number: bytes, length: int) -> bytes:
        return number + b".{%d}" % (length + 2)

    @staticmethod
    def _begun(number: bytes, length: int) -> bytes:
        return number + b".{0,%d}" % (length + 1)

    @staticmethod
    def _parse(frame: bytes) -> tuple[int, bytes] | None:
        return None if crc_hqx(frame, _INITIAL) else (frame[0], frame[1:-2])
