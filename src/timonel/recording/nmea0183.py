"""Logs of NMEA 0183: one sentence a line, alone or behind the time at which it was heard.

    $GPRMC,125106,V,3854.5087,N,07726.4523,W,0.0,0.0,241011,10.5,W,S*28
    \\s:gps,c:1319460666*44\\$GPRMC,...*28          a TAG block; c: seconds, or milliseconds, since 1970-01-01
    1402160417499;N;$GPRMC,...*28                   Signal K's server: milliseconds; source; sentence
    1402160417.499 $GPRMC,...*28                    seconds since 1970-01-01, or since the log began
    2023-09-02T12:41:35.168+00:00 $GPRMC,...*28     a date, in brackets too
    12:41:35.168 gps $GPRMC,...*28                  a time of day, which counts from 1970-01-01; source; sentence

Only a sentence whose check sum is right is read; what kind it is does not matter. Source: NMEA 0183 (IEC 61162-1),
7.2.4; TAG blocks: NMEA 0183 4.10; Signal K server, `log.ts`.
"""

import re
from collections.abc import Sequence

from timonel.nmea0183.checksum import Fault, checksum, verify
from timonel.recording.lines import DateTime, Kind, LogSentence, TimeOfDay, is_comment, moment

_LINE = re.compile(r"(?:([^$!\\]*)|\\([^\\]*)\*([0-9A-Fa-f]{2})\\)([$!][\x20-\x7e]+?)\s*")
_TIME = re.compile(
    r"[\[(]?(?:"
    r"(?P<date>\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(?:\.\d+)?(?:Z|[+-]\d\d:?\d\d)?)"
    r"|(?P<hours>\d\d):(?P<minutes>\d\d):(?P<seconds>\d\d(?:\.\d+)?)"
    r"|(?P<milliseconds>\d{12,13})"
    r"|(?P<count>\d{1,10}(?:\.\d+)?)"
    r")[\])]?(?:;[^;]*;|[\s;,:]+(?:[\w./:-]+[\s;,:]+)?)?"
)
_TAG_TIME = re.compile(r"(?:^|,)c:(\d+(?:\.\d+)?)(?:,|$)")
_A_DATE = 1e8  # s: a smaller time, before 1973, counts from the start of something
_MILLISECONDS = 1e11  # a larger time, after the year 5000, is in these


class Nmea0183:
    """Lines with a sentence each."""

    name = "NMEA 0183"
    kind: Kind = "sentences"

    def __init__(self, sample: Sequence[str]) -> None:
        self._date_time = DateTime()
        self._time_of_day = TimeOfDay()
        self.dated = False

    def read(self, line: str) -> LogSentence | None:
        """A sentence; None for a comment. ValueError for any other line."""
        if is_comment(line):
            return None
        match = _LINE.fullmatch(line)
        if match is None:
            raise ValueError("neither a comment nor a sentence")
        before, tag, tag_sum, text = match.groups()
        sentence = text.encode("ascii")
        body = verify(sentence)
        if isinstance(body, Fault):
            raise ValueError(body.value)
        stamp = self._tag(tag, tag_sum) if tag is not None else self._time(before)
        return LogSentence(stamp, sentence)

    def _tag(self, block: str, digits: str) -> float | None:
        if checksum(block.encode("latin-1")) != int(digits, 16):
            raise ValueError("wrong check sum of the TAG block")
        time = _TAG_TIME.search(block)
        return None if time is None else self._seconds(float(time[1]))

    def _time(self, text: str) -> float | None:
        if not text or text.isspace():
            return None
        match = _TIME.fullmatch(text)
        if match is None:
            raise ValueError("neither a time nor a TAG block before the sentence")
        if match["date"]:
            self.dated = True
            return moment(self._date_time.read(match["date"]))
        if match["hours"]:
            return self._time_of_day.read(match["hours"], match["minutes"], match["seconds"])
        return self._seconds(float(match["milliseconds"] or match["count"]))

    def _seconds(self, time: float) -> float:
        seconds = time / 1000 if time >= _MILLISECONDS else time
        self.dated = self.dated or seconds >= _A_DATE
        return moment(seconds)
