"""The lines of an NMEA 0183 log, and which of them are plain sentences. Needs the extra `columns`.

Plain is a line from `$` or `!` to a right check sum, of printable characters. The check sum is the XOR of all
characters before a place, taken at two places: one pass over the text, eight characters at a time, for all lines.
"""

from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from timonel.recording.decimals import LONGEST, Flags, Places, Text

PADDING = bytes(LONGEST)
"""Stands before and behind the text, so that whole words can be read anywhere."""

_COMMA, _LINE_FEED, _RETURN, _STAR = b",\n\r*"
_FIRST = np.array([(1 << 8 * count) - 1 for count in range(8)], np.uint64)
_DIGITS = np.full(256, 255, np.uint8)
_DIGITS[list(b"0123456789ABCDEFabcdef")] = [*range(16), *range(10, 16)]


class LogLines(msgspec.Struct, frozen=True, eq=False, gc=False):
    """Lines of a text between paddings: where each begins, and where its characters end (before CR and LF).

    Its `commas[i]` commas are at `marks[first[i]]` and the next; behind the last of them stands a line feed.
    """

    text: Text
    begin: Places
    end: Places
    behind: Places
    """Where the next line begins."""
    marks: Places
    first: Places
    commas: Places

    def joined(self, other: "LogLines") -> "LogLines":
        """With the lines of another text behind these."""
        shift = len(self.text)
        return LogLines(
            np.concatenate((self.text, other.text)),
            np.concatenate((self.begin, other.begin + shift)),
            np.concatenate((self.end, other.end + shift)),
            np.concatenate((self.behind, other.behind + shift)),
            np.concatenate((self.marks, other.marks + shift)),
            np.concatenate((self.first, other.first + len(self.marks))),
            np.concatenate((self.commas, other.commas)),
        )


def lines_of(lines: bytes) -> LogLines:
    """The lines of a text whose last one has its end."""
    text = np.frombuffer(b"".join((PADDING, lines, PADDING)), np.uint8)
    marks = np.flatnonzero((text == _COMMA) | (text == _LINE_FEED))
    last = np.flatnonzero(text.take(marks) == _LINE_FEED)
    feeds = marks.take(last)
    begin = _behind(feeds, LONGEST)
    first = _behind(last, 0)
    end = feeds - (text.take(feeds - 1) == _RETURN)
    return LogLines(text, begin, np.maximum(end, begin), feeds + 1, marks, first, last - first)


def _behind(places: Places, start: int) -> Places:
    behind = np.empty_like(places)
    behind[:1] = start
    behind[1:] = places[:-1] + 1
    return behind


def plain(lines: LogLines) -> Flags:
    """Which lines are plain sentences."""
    text, begin, end = lines.text, lines.begin, lines.end
    lead = text.take(begin)
    high, low = (_DIGITS.take(text.take(end - place)) for place in (2, 1))
    value = _sums(text, begin + 1, np.maximum(end - 3, 0))
    fine: Flags = (lead == ord("$")) | (lead == ord("!"))
    fine &= text.take(end - 3) == _STAR
    fine &= (high | low) < 16
    fine &= high << 4 | low == value
    fine &= end - begin >= 4
    fine[_unprintable(lines)] = False
    return fine


def _sums(text: Text, begin: Places, end: Places) -> npt.NDArray[np.uint8]:
    """The XOR of the characters in `text[begin[i]:end[i]]`."""
    words = text[: len(text) & ~7].view("<u8")
    before = np.zeros(len(words) + 1, np.uint64)
    np.bitwise_xor.accumulate(words, out=before[1:])
    both = np.zeros(len(begin), np.uint64)
    for place in (begin, end):
        word = place >> 3
        some = words.take(word)
        some &= _FIRST.take(place & 7)
        some ^= before.take(word)
        both ^= some
    for half in (32, 16, 8):
        both ^= both >> half
    return both.astype(np.uint8)


def _unprintable(lines: LogLines) -> npt.NDArray[Any]:
    """The lines with other than printable characters."""
    other = lines.text - np.uint8(0x20) > 0x7E - 0x20
    ends = lines.behind - lines.end
    if np.count_nonzero(other) == 2 * LONGEST + ends.sum():
        return np.empty(0, np.intp)
    other[lines.behind - 1] = False
    other[lines.end] = False
    places = np.flatnonzero(other[LONGEST:-LONGEST]) + LONGEST
    return np.searchsorted(lines.behind, places, "right")
