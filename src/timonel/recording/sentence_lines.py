"""The lines of an NMEA 0183 log, and which of them are plain sentences. Needs the extra `columns`.

Plain is a line from `$` or `!` to a right check sum, of printable characters; the compiled kernel also knows the usual
times before one. Without it the check sum is the XOR of all characters before a place, taken at two places: one pass
over the text, eight characters at a time, for all lines.
"""

from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from timonel import native
from timonel.recording.decimals import LONGEST, Flags, Places, Text
from timonel.recording.frames import NO_STAMP, Stamps

PADDING = bytes(LONGEST)
"""Stands before and behind the text, so that whole words can be read anywhere."""

Which = Places | Flags | slice

_COMMA, _LINE_FEED, _RETURN, _STAR = b",\n\r*"
_FIRST = np.array([(1 << 8 * count) - 1 for count in range(8)], np.uint64)
_DIGITS = np.full(256, 255, np.uint8)
_DIGITS[list(b"0123456789ABCDEFabcdef")] = [*range(16), *range(10, 16)]


class Commas(msgspec.Struct, frozen=True, eq=False, gc=False):
    """The `count[i]` commas of a line are at `marks[first[i]]` and the next; behind the last stands a line feed."""

    marks: Places
    first: Places
    count: Places

    def __getitem__(self, which: Which) -> "Commas":
        return Commas(self.marks, self.first[which], self.count[which])

    def joined(self, other: "Commas", shift: int) -> "Commas":
        return Commas(
            np.concatenate((self.marks, other.marks + shift)),
            np.concatenate((self.first, other.first + len(self.marks))),
            np.concatenate((self.count, other.count)),
        )


class Sentences(msgspec.Struct, frozen=True, eq=False, gc=False):
    """Sentences in a text between paddings, each from `begin` to `end`; `line` and `stamp` are those of the log.

    `commas` are None where the compiled kernels look for them.
    """

    text: Text
    begin: Places
    end: Places
    line: Places
    stamp: Stamps
    commas: Commas | None

    def __len__(self) -> int:
        return len(self.begin)

    def __getitem__(self, which: Which) -> "Sentences":
        commas = None if self.commas is None else self.commas[which]
        return Sentences(self.text, self.begin[which], self.end[which], self.line[which], self.stamp[which], commas)

    def joined(self, other: "Sentences") -> "Sentences":
        """With those of another text, in the order of their lines."""
        shift = len(self.text)
        both = Sentences(
            np.concatenate((self.text, other.text)),
            np.concatenate((self.begin, other.begin + shift)),
            np.concatenate((self.end, other.end + shift)),
            np.concatenate((self.line, other.line)),
            np.concatenate((self.stamp, other.stamp)),
            self.commas and other.commas and self.commas.joined(other.commas, shift),
        )
        return both[np.argsort(both.line, kind="stable")]


class LogLines(msgspec.Struct, frozen=True, eq=False, gc=False):
    """Lines of a text between paddings: where each or its sentence begins, where its characters end (before CR and LF),
    where the next one begins, the time before its sentence, and which have a plain one."""

    text: Text
    begin: Places
    end: Places
    behind: Places
    stamp: Stamps
    plain: Flags
    commas: Commas | None

    def __len__(self) -> int:
        return len(self.begin)

    def others(self) -> list[tuple[int, bytes]]:
        """The place and the text, with its end, of each line without a plain sentence."""
        places = np.flatnonzero(~self.plain)
        return list(zip(places.tolist(), cut(self.text, self.begin[places], self.behind[places]), strict=True))

    def sentences(self, before: int) -> Sentences:
        """The plain ones, behind so many lines of the log."""
        line = np.arange(before + 1, before + 1 + len(self))
        found = Sentences(self.text, self.begin, self.end, line, self.stamp, self.commas)
        return found if self.plain.all() else found[self.plain]


def padded(text: bytes) -> Text:
    """A text between paddings."""
    return np.frombuffer(b"".join((PADDING, text, PADDING)), np.uint8)


def cut(text: Text, begin: Places, end: Places) -> list[bytes]:
    """Parts of a text."""
    return [text[start:stop].tobytes() for start, stop in zip(begin.tolist(), end.tolist(), strict=True)]


def lines_of(text: Text) -> LogLines:
    """The lines of a text between paddings, of any characters; its last line has its end."""
    return _interpreted(text) if native.kernels is None else _compiled(text)


def _compiled(text: Text) -> LogLines:
    count = np.count_nonzero(text[LONGEST:-LONGEST] == _LINE_FEED)
    begin, end, behind = (np.empty(count, np.intp) for _ in range(3))
    stamp, plain = np.empty(count, np.int64), np.empty(count, np.bool_)
    native.kernels.sentence_lines(text, begin, end, behind, stamp, plain)
    return LogLines(text, begin, end, behind, stamp, plain, None)


def _interpreted(text: Text) -> LogLines:
    inner = text[LONGEST:-LONGEST]
    marks = np.flatnonzero((inner == _COMMA) | (inner == _LINE_FEED)) + LONGEST
    last = np.flatnonzero(text.take(marks) == _LINE_FEED)
    feeds = marks.take(last)
    begin, behind = _behind(feeds, LONGEST), feeds + 1
    first = _behind(last, 0)
    end = np.maximum(feeds - (text.take(feeds - 1) == _RETURN), begin)
    stamp, plain = np.full(len(begin), NO_STAMP), _plain(text, begin, end, behind)
    return LogLines(text, begin, end, behind, stamp, plain, Commas(marks, first, last - first))


def _behind(places: Places, start: int) -> Places:
    behind = np.empty_like(places)
    behind[:1] = start
    behind[1:] = places[:-1] + 1
    return behind


def _plain(text: Text, begin: Places, end: Places, behind: Places) -> Flags:
    """Which lines are plain sentences."""
    lead = text.take(begin)
    high, low = (_DIGITS.take(text.take(end - place)) for place in (2, 1))
    value = _sums(text, begin + 1, np.maximum(end - 3, 0))
    fine: Flags = (lead == ord("$")) | (lead == ord("!"))
    fine &= text.take(end - 3) == _STAR
    fine &= (high | low) < 16
    fine &= high << 4 | low == value
    fine &= end - begin >= 4
    fine[_unprintable(text, end, behind)] = False
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


def _unprintable(text: Text, end: Places, behind: Places) -> npt.NDArray[Any]:
    """The lines with other than printable characters."""
    other = text[LONGEST:-LONGEST] - np.uint8(0x20) > 0x7E - 0x20
    if np.count_nonzero(other) == (behind - end).sum():
        return np.empty(0, np.intp)
    other[behind - 1 - LONGEST] = False
    other[end - LONGEST] = False
    return np.searchsorted(behind, np.flatnonzero(other) + LONGEST, "right")
