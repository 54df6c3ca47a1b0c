"""canboat's PLAIN and FAST lines.

    2016-02-28T19:57:02.364Z,2,127250,7,255,8,ff,10,3b,ff,7f,ce,f5,fc
    time, priority, PGN, source, destination, length, data in hex

PLAIN has one frame a line, FAST one message a line, whatever its length, and many recordings have both: a
gateway puts together what it knows and passes on the frames of the rest. So a line of eight bytes of a
fast-packet PGN can be either. It is a message if the recording says `# format=FAST`; else what the first
lines have of that PGN decides: frames that make a longer message, or messages of another length. Where they
have neither, it is a message if all fast packets there are.

Source: canboat `README.md` and `analyzer.c`. PGNs from 262144 on are gateways' own and were never on the bus.
"""

from collections.abc import Sequence
from functools import lru_cache

from timonel.nmea2000.fastpacket import LONGEST, Reassembler
from timonel.recording.lines import DateTime, Kind, LogFrame, is_comment
from timonel.recording.messages import address


class Canboat:
    """Lines of canboat, PLAIN, FAST or mixed."""

    name = "canboat"
    kind: Kind = "frames"
    dated = True

    def __init__(self, sample: Sequence[str]) -> None:
        self._date_time = DateTime()
        self._messages, self._otherwise = _messages(sample)

    def read(self, line: str) -> LogFrame | None:
        """A frame or message; None for a comment or a gateway's own PGN. ValueError for any other line."""
        if is_comment(line):
            return None
        stamp, priority, pgn, source, destination, length, text = _fields(line)
        data, size = _bytes(text), int(length)
        if len(data) < size:
            raise ValueError(f"{size} bytes announced, {len(data)} found")
        if not 0 <= size <= LONGEST:
            raise ValueError(f"{size} bytes are not 0..{LONGEST}")
        identifier, fast = _address(priority, pgn, source, destination)
        if identifier is None:
            return None
        whole = size > 8 or (fast and (size < 8 or self._messages.get(pgn, self._otherwise)))
        return LogFrame(self._date_time.read(stamp), identifier, data[:size], True, whole)


def _fields(line: str) -> list[str]:
    fields = line.split(",", 6)
    if len(fields) < 7:
        raise ValueError("fewer than seven fields")
    return fields


def _bytes(text: str) -> bytes:
    try:
        return bytes.fromhex(text.replace(",", " "))
    except ValueError:  # written by hand: `0` for `00`
        return bytes.fromhex(" ".join(value.strip().rjust(2, "0") for value in text.split(",")))


# A bus has a few hundred of these, a recording millions.
@lru_cache(maxsize=4096)
def _address(priority: str, pgn: str, source: str, destination: str) -> tuple[int | None, bool]:
    """The identifier (None for a gateway's own PGN), and whether the PGN is a fast packet."""
    return address(int(priority), int(pgn), int(source), int(destination))


def _messages(sample: Sequence[str]) -> tuple[dict[str, bool], bool]:
    """Which PGNs' eight bytes are messages, as far as these lines tell, and whether all others' are."""
    if any(line.startswith("#") and "format=FAST" in line for line in sample):
        return {}, True
    reassembler = Reassembler()
    messages: dict[str, bool] = {}
    for pgn, identifier, data in filter(None, map(_fast_packet, sample)):
        if len(data) != 8:
            messages.setdefault(pgn, True)
        elif len(reassembler.receive(identifier, data, 0.0) or b"") > 6:
            messages[pgn] = False
    return messages, bool(messages) and all(messages.values())


def _fast_packet(line: str) -> tuple[str, int, bytes] | None:
    """PGN, identifier and data of a fast-packet PGN's line; None for any other line."""
    try:
        _, priority, pgn, source, destination, _, text = _fields(line)
        identifier, fast = _address(priority, pgn, source, destination)
        return (pgn, identifier, _bytes(text)) if fast and identifier is not None else None
    except ValueError:
        return None
