"""Yacht Devices' RAW text, which other gateways (Actisense W2K-1) write too.

    17:33:21.107 R 19F51323 01 2F 30 70 00 2F 30 70     time, R received or T transmitted, identifier, data
    19f51323 01 2f 30 70 00 2f 30 70                    as a client sends it

Source: YDWG-02 manual, appendix E. The time has no date: it counts from 1970-01-01, and past midnight goes
on.
"""

from collections.abc import Sequence

from timonel.nmea2000.text import YDRAW
from timonel.recording.lines import Kind, LogFrame, TimeOfDay, is_comment


class YachtDevicesRaw:
    """Lines of YD RAW."""

    name = "YD RAW"
    kind: Kind = "frames"
    dated = False

    def __init__(self, sample: Sequence[str]) -> None:
        self._time = TimeOfDay()

    def read(self, line: str) -> LogFrame | None:
        """A frame; None for a comment. ValueError for any other line."""
        match = YDRAW.fullmatch(line)
        if match is None:
            if is_comment(line):
                return None
            raise ValueError("neither a comment nor a frame")
        hours, minutes, seconds, _, identifier, data = match.groups()
        number = int(identifier, 16)
        if number >> 29:
            raise ValueError("an identifier has 29 bits")
        stamp = self._time.read(hours, minutes, seconds) if hours else None
        return LogFrame(stamp, number, bytes.fromhex(data))
