"""Whole messages, as gateways log them that put fast packets together."""

from functools import lru_cache

from timonel.errors import EncodeError
from timonel.nmea2000.fastpacket import LONGEST
from timonel.nmea2000.identifier import join
from timonel.nmea2000.schedule import is_fast
from timonel.recording.lines import LogFrame

_GATEWAY = 0x40000  # canboat: PGNs from here on are a gateway's own and were never on the bus


# A bus has a few hundred of these, a recording millions.
@lru_cache(maxsize=4096)
def address(priority: int, pgn: int, source: int, destination: int) -> tuple[int | None, bool]:
    """The identifier (None for a gateway's own PGN), and whether the PGN is a fast packet.

    ValueError if no identifier has such parts.
    """
    if pgn >= _GATEWAY:
        return None, False
    try:
        return join(priority, pgn, source, destination), is_fast(pgn)
    except EncodeError as error:
        raise ValueError(str(error)) from error


def message(
    stamp: float | None, priority: int, pgn: int, source: int, destination: int, data: bytes
) -> LogFrame | None:
    """A whole message; None if its PGN is a gateway's own.

    ValueError if no message has such parts, or so many bytes: those of ISO transport are longer than a
    fast packet, and are not read here.
    """
    identifier, fast = address(priority, pgn, source, destination)
    if identifier is None:
        return None
    if len(data) > LONGEST:
        raise ValueError(f"{len(data)} bytes are not 0..{LONGEST}")
    return LogFrame(stamp, identifier, data, True, fast or len(data) > 8)
