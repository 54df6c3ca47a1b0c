"""Actisense's N2K ASCII, which the W2K-1, WGX and their kin write: one message a line, whole.

    A173321.107 23FF7 1F513 012F3070002F30709F
    A, time of day (hhmmss, milliseconds may be missing); source, destination and priority; PGN; data: all in hex

Source: Actisense SDK, `nmea2000-type-A.md`. The time has no date: it counts from 1970-01-01, and past midnight
goes on.
"""

from collections.abc import Sequence

from timonel.nmea2000.text import N2K_ASCII
from timonel.recording.lines import Kind, LogFrame, TimeOfDay, is_comment
from timonel.recording.messages import message


class ActisenseAscii:
    """Lines of N2K ASCII."""

    name = "Actisense N2K ASCII"
    kind: Kind = "frames"
    dated = False

    def __init__(self, sample: Sequence[str]) -> None:
        self._time = TimeOfDay()

    def read(self, line: str) -> LogFrame | None:
        """A message; None for a comment or a gateway's own PGN. ValueError for any other line."""
        match = N2K_ASCII.fullmatch(line)
        if match is None:
            if is_comment(line):
                return None
            raise ValueError("neither a comment nor a message")
        hours, minutes, seconds, source, destination, priority, pgn, data = match.groups()
        stamp = self._time.read(hours, minutes, seconds)
        parts = int(priority, 16) & 7, int(pgn, 16), int(source, 16), int(destination, 16)
        return message(stamp, *parts, bytes.fromhex(data))
