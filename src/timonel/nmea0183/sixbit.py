"""Six bits a character: how AIS messages travel in VDM and VDO sentences, and the letters inside them.

The bits of a message are kept as one int, first bit highest, and their number. Armour and letters are both base 64
with an alphabet of their own, so that the interpreter's base 64 does the work.
Source: IEC 61162-1, Annex C (armour); ITU-R M.1371-5, table 47 (letters).
"""

from binascii import a2b_base64, b2a_base64

BASE64 = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"
ARMOUR = bytes(range(48, 88)) + bytes(range(96, 120))
LETTERS = bytes(range(64, 96)) + bytes(range(32, 64))

_FROM_ARMOUR = bytes.maketrans(ARMOUR, BASE64)
_TO_ARMOUR = bytes.maketrans(BASE64, ARMOUR)
_FROM_LETTERS = bytes.maketrans(LETTERS, BASE64)
_TO_LETTERS = bytes.maketrans(BASE64, LETTERS)
_NO_LETTERS = bytes(range(256)).translate(None, LETTERS)
_UNKNOWN = bytes.maketrans(_NO_LETTERS, b"?" * len(_NO_LETTERS))


def _unpacked(text: bytes) -> int:
    """The bits of base-64 characters."""
    short = -len(text) % 4
    return int.from_bytes(a2b_base64(text + b"A" * short), "big") >> 6 * short


def _packed(bits: int, characters: int) -> bytes:
    """So many base-64 characters for the lowest bits."""
    short = -characters % 4
    size = 3 * (characters + short) // 4
    return b2a_base64((bits << 6 * short).to_bytes(size, "big"), newline=False)[:characters]


def dearmour(payload: bytes, fill: int) -> tuple[int, int] | None:
    """The bits of a payload and their number; the last `fill` (0..5) are not the message's. None for no payload."""
    length = 6 * len(payload) - fill
    if not 0 <= fill <= 5 or length <= 0 or payload.translate(None, ARMOUR):
        return None
    return _unpacked(payload.translate(_FROM_ARMOUR)) >> fill, length


def armour(bits: int, length: int) -> tuple[bytes, int]:
    """The payload for `length` bits, and how many bits fill up its last character."""
    fill = -length % 6
    return _packed(bits << fill, (length + fill) // 6).translate(_TO_ARMOUR), fill


def read_text(bits: int, characters: int) -> str | None:
    """The text in `characters` letters: up to the first `@`, without spaces at its end. None where there is none."""
    letters = _packed(bits, characters).translate(_TO_LETTERS)
    return letters.partition(b"@")[0].rstrip().decode("ascii") or None


def write_text(text: str | None, characters: int) -> int:
    """Text as letters, cut or padded with `@`. What has no letter becomes a question mark."""
    letters = (text or "").upper().encode("ascii", "replace").translate(_UNKNOWN)[:characters]
    return _unpacked(letters.ljust(characters, b"@").translate(_FROM_LETTERS))
