"""The 29 bits that say who sends what to whom, and how urgently.

    bits 26..28  priority, 0 first      bits 16..23  PDU format (PF)     bits 0..7  source address
    bits 24..25  data page, reserved    bits  8..15  PDU specific (PS)

PF below 240 is PDU1: PS is the destination and the PGN ends in 00. From 240 on it is PDU2: PS belongs to the
PGN and everybody is meant. Source: ISO 11783-3, as canboat's `getISO11783BitsFromCanId` has it.
"""

from functools import lru_cache
from typing import NamedTuple

from timonel.errors import EncodeError

GLOBAL = 255
"""The destination address that means everybody."""

NULL = 254
"""The source address of a device that has none."""


class Identifier(NamedTuple):
    """A CAN identifier taken apart; `destination` is 255 where the PGN has none."""

    priority: int
    pgn: int
    source: int
    destination: int


# Called once a frame: a bus has a few hundred identifiers, and a look-up costs a seventh of the arithmetic.
@lru_cache(maxsize=4096)
def split(identifier: int) -> Identifier:
    """Take a 29-bit identifier apart; higher bits (SocketCAN's flags) are not looked at."""
    pgn = identifier >> 8 & 0x3FFFF
    priority = identifier >> 26 & 7
    source = identifier & 0xFF
    if pgn & 0xFF00 < 0xF000:
        return Identifier(priority, pgn & 0x3FF00, source, pgn & 0xFF)
    return Identifier(priority, pgn, source, GLOBAL)


@lru_cache(maxsize=4096)
def join(priority: int, pgn: int, source: int, destination: int = GLOBAL) -> int:
    """The 29-bit identifier; a PDU2 PGN goes to everybody whatever `destination` says.

    Raises EncodeError for a value outside its bits and for a PDU1 PGN that does not end in 00.
    """
    _within("priority", priority, 7)
    _within("PGN", pgn, 0x3FFFF)
    _within("source", source, 0xFF)
    _within("destination", destination, 0xFF)
    if pgn & 0xFF00 < 0xF000:
        if pgn & 0xFF:
            raise EncodeError(f"PGN: {pgn} has a destination, so its low byte must be 0")
        pgn |= destination
    return priority << 26 | pgn << 8 | source


def _within(name: str, value: int, largest: int) -> None:
    if not 0 <= value <= largest:
        raise EncodeError(f"{name}: {value} is outside 0..{largest}")
