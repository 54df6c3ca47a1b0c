"""`hal062`: `#`, two hex digits id, sixteen hex digits data padded with `x`; 19 characters, always.

`#65` `31` `xxxxxxxxxxxxxx` is frame 101 with the data 0x31. Both cases are read, capital digits and small `x` are
written. The id fixes how many digits are data, and all others must be `x`. More than eight bytes of data do not
fit. A `#` is never data, so a frame needs no other proof than its characters, and is emitted with the last of them.

Source: spec/rover.md, Framing without a check sum; `Komunikacja.md` of KNR-PW/HAL062_STM32.
"""

from binascii import unhexlify

from timonel.vehicles.rover.framing.framer import Framer, check

_DIGITS = 16


class Hal062(Framer):
    """The parser and writer of the ASCII framing."""

    LONGEST = _DIGITS // 2

    @staticmethod
    def write(number: int, data: bytes) -> bytes:
        """One frame of 19 characters. Raises EncodeError above eight bytes of data."""
        check(number, data, Hal062.LONGEST)
        return b"#%02X%b" % (number, data.hex().upper().encode().ljust(_DIGITS, b"x"))

    @staticmethod
    def _id(numbers: bytes) -> bytes:
        return b"(?i:%s)" % b"|".join(b"%02x" % number for number in numbers) if numbers else b"(?!)"

    @staticmethod
    def _frame(number: bytes, length: int) -> bytes:
        return number + b"(?i:[0-9a-f]{%d}x{%d})" % (2 * length, _DIGITS - 2 * length)

    @staticmethod
    def _begun(number: bytes, length: int) -> bytes:
        return b"(?i:[0-9a-fx]{0,%d})" % (_DIGITS + 1)

    @staticmethod
    def _parse(frame: bytes) -> tuple[int, bytes]:
        raw = unhexlify(frame.rstrip(b"xX"))
        return raw[0], raw[1:]
