"""Garmin's CSV, which its plotters' NMEA 2000 recorder writes: one message a line, whole.

    Sequence #,Timestamp,PGN,Name,Manufacturer,Remote Address,Local Address,Priority,Single Frame,Size,Packet
    0,486942,127508,Battery Status,Garmin,6,255,2,1,8,0x017505FF7FFFFFFF

    Sequence #,Month_Day_Year_Hours_Minutes_Seconds_msTicks,PGN,Processed PGN,Name,Manufacturer,Remote ...
    0,6_21_2015_16_11_14_24931648,127508,Processed,Battery Status,Garmin,6,255,2,1,8,0x017505FF7FFFFFFF

The remote address is the source. The first kind counts milliseconds since the plotter was switched on. The second
has the date to the second and, beside it, the milliseconds since then; they order what came within a second.
Source: canboat `parse.c`.
"""

import re
from collections.abc import Sequence
from datetime import UTC, datetime

from timonel.recording.lines import Kind, LogFrame, is_comment, moment
from timonel.recording.messages import message

# Names may have commas in them.
_LINE = re.compile(
    r"\d+,(?:(\d{1,15})|(\d+)_(\d+)_(\d+)_(\d+)_(\d+)_(\d+)_(\d{1,15})),"
    r"(\d+),.*,(\d+),(\d+),(\d+),[01],(\d+),0x((?:[0-9A-F]{2})*)\s*",
    re.IGNORECASE,
)


class GarminCsv:
    """Lines of Garmin's CSV."""

    name = "Garmin CSV"
    kind: Kind = "frames"

    def __init__(self, sample: Sequence[str]) -> None:
        self.dated = any("Month_Day_Year" in line for line in sample[:2])
        self._started: float | None = None  # when the milliseconds began, in unix s

    def read(self, line: str) -> LogFrame | None:
        """A message; None for the headings or a gateway's own PGN. ValueError for any other line."""
        match = _LINE.fullmatch(line)
        if match is None:
            if is_comment(line) or line.startswith("Sequence #,"):
                return None
            raise ValueError("neither the headings nor a message")
        elapsed, *date, pgn, source, destination, priority, size, text = match.groups()
        data = bytes.fromhex(text)
        if len(data) != int(size):
            raise ValueError(f"{size} bytes announced, {len(data)} found")
        stamp = moment(int(elapsed) / 1000) if elapsed else self._date(*map(int, date))
        return message(stamp, int(priority), int(pgn), int(source), int(destination), data)

    def _date(self, month: int, day: int, year: int, hour: int, minute: int, second: int, ticks: int) -> float:
        """Unix seconds; where the clock was set, the milliseconds begin at another time."""
        try:
            written = datetime(year, month, day, hour, minute, second, tzinfo=UTC).timestamp()
        except OverflowError as error:
            raise ValueError(str(error)) from error
        if self._started is None or abs(self._started + ticks / 1000 - written) > 1:
            self._started = written - ticks / 1000
        return moment(self._started + ticks / 1000)
