"""Lines of `candump -L` to frames, thousands at a time. Needs the extra `columns`.

    (1669809600.001488) can0 0DF11917#00FF7F1F02A3FFFF

Lines of one shape (the same lengths of the interface's name and of the identifier) are read eight characters at
a time, as 64-bit words. Every character is looked at: a line that has another one in any place is not of the
shape, and not guessed at.
"""

import re
from functools import cached_property

import msgspec
import numpy as np
import numpy.typing as npt

from timonel.recording.decimals import Words, eight_digits, repeated
from timonel.recording.frames import Bytes, Rows, Stamps

BLOCK = 1 << 13
"""Lines at a time, so that what is worked on stays in the processor's cache."""
ROW = 64
"""Bytes of the longest line of a shape, with its end."""

Flags = npt.NDArray[np.bool_]
Ints = npt.NDArray[np.intp]

SHAPE = re.compile(rb"\([0-3]\d{9}\.\d{6}\) ([!-~]{1,15}) ([01][0-9A-F]{7}|[0-7][0-9A-F]{2})#(?:[0-9A-F]{2}){0,8}\n")
"""A line that `parse` can read; the groups are the interface's name and the identifier."""
_SECONDS = re.compile(rb"\([0-3]\d{9}")
_LINE_FEED = 10
_NAME = 19  # where the blank before the interface's name stands


_ZEROS = int.from_bytes(b"00000000", "little")
_POINT_AND_BRACKET = int.from_bytes(b".000000)", "little")
_SIXES_BETWEEN = 0x0006060606060600
_DIGITS_BETWEEN = 0xFFF0F0F0F0F0F0FF
# By the number of hexadecimal digits of data, of the first and the second word: what is data, and zeros for the rest.
_DATA = np.array([[(1 << 8 * min(8, n)) - 1, (1 << 8 * max(0, n - 8)) - 1] for n in range(17)], np.uint64).T
_NO_DATA = ~_DATA & np.uint64(_ZEROS)


class Shape(msgspec.Struct, frozen=True, dict=True):
    """What lines have in common: the name's length (its letters may differ) and the identifier's digits."""

    name: bytes
    digits: int

    @cached_property
    def hash(self) -> int:
        """Where `#` stands."""
        return _NAME + 2 + len(self.name) + self.digits

    @cached_property
    def unused(self) -> int:
        """Mask of the eight characters before `#` of those that are not the identifier's."""
        return (1 << 8 * (8 - self.digits)) - 1

    @cached_property
    def bits(self) -> int:
        return 29 if self.digits == 8 else 11

    @cached_property
    def flag(self) -> int:
        """SocketCAN's mark of an extended identifier."""
        return 1 << 31 if self.digits == 8 else 0


class Lines(msgspec.Struct, frozen=True):
    """Lines in memory: each begins `stride` bytes after the one before; `size` is without the end of the line.

    `text` must be readable for `ROW` bytes from where the last one begins.
    """

    text: Bytes
    count: int
    stride: int
    size: int | Ints

    def word(self, at: int) -> Words:
        """Characters `at` to `at + 7` of each line, the first one lowest."""
        return np.ndarray((self.count,), "<u8", self.text, at, (self.stride,)).copy()

    def byte(self, at: int) -> Bytes:
        return np.ndarray((self.count,), np.uint8, self.text, at, (self.stride,))


def equal_lines(text: Bytes, end: int, size: int) -> Lines:
    """The lines at the beginning of `text[:end]` that are as long as the first one (`size`), at most a block."""
    count = min(end // size, BLOCK)
    ends = np.ndarray((count,), np.uint8, text, size - 1, (size,)) == _LINE_FEED
    return Lines(text, count if ends.all() else int(ends.argmin()), size, size - 1)


def any_lines(text: Bytes, end: int) -> tuple[Lines, Ints, Ints]:
    """The lines of `text[:end]`, at most a block, cut to what a line of a shape has; where they begin and end."""
    ends = np.flatnonzero(text[:end] == _LINE_FEED)[:BLOCK]
    starts = np.concatenate(([0], ends[:-1] + 1))
    rows = np.ndarray((len(text) - ROW + 1,), f"V{ROW}", text, 0, (1,))[starts]
    return Lines(rows.view(np.uint8), len(starts), ROW, ends - starts), starts, ends


class Parser:
    """Reads blocks of lines; what it works in, it keeps."""

    def __init__(self) -> None:
        self._words = np.empty(3 * BLOCK, np.uint64)
        self._spare = np.empty(3 * BLOCK, np.uint64)
        self._fine = np.empty(24 * BLOCK, np.bool_)

    def parse(self, lines: Lines, shape: Shape, rows: Rows, stamps: Stamps) -> Flags | None:
        """Fill in a row and a stamp a line; which lines are not of the shape (their rows mean nothing), or None."""
        size = np.atleast_1d(lines.size - shape.hash - 1)
        fault = _stamps(lines, stamps)
        fault |= _name(lines, shape)
        fault |= lines.byte(shape.hash) ^ ord("#")
        if (wrong := (size & 1 != 0) | (size < 0) | (size > 16)).any():
            fault |= wrong
            size = np.where(wrong, 0, size)
        words = self._words[: 3 * lines.count].reshape(3, -1)
        _digits(lines, shape, size, words)
        fault |= self._not_hexadecimal(words)
        values = self._bytes(words)
        identifiers = values[0].view(">u4").astype(np.uint64)
        fault |= identifiers >> shape.bits
        table = rows.view("<u8").reshape(-1, 2)
        np.bitwise_or(identifiers, (size << 31 | shape.flag).astype(np.uint64), out=table[:, 0])
        halves = table.view("<u4")
        halves[:, 2] = values[1].view("<u4")
        halves[:, 3] = values[2].view("<u4")
        return fault != 0 if fault.any() else None

    def _not_hexadecimal(self, words: Words) -> Words | int:
        """Not zero where a character is none of 0-9 and A-F."""
        characters = words.view(np.uint8)
        shifted = self._spare[: words.size].reshape(3, -1).view(np.uint8)
        fine = self._fine[: characters.size].reshape(3, -1)
        np.subtract(characters, ord("0"), out=shifted)
        np.less_equal(shifted, 9, out=fine)
        shifted -= ord("A") - ord("0")
        fine |= shifted <= 5
        if fine.all():
            return 0
        faults: Words = np.bitwise_or.reduce(fine.view(np.uint64) ^ repeated(1), axis=0)
        return faults

    def _bytes(self, words: Words) -> Bytes:
        """uint8[3, 4n]: the four bytes of the eight digits of each word, in their order. The words are lost."""
        letters = self._spare[: words.size].reshape(3, -1)
        np.right_shift(words, 6, out=letters)
        letters &= repeated(1)
        letters *= 9
        words &= repeated(15)
        words += letters
        np.right_shift(words, 8, out=letters)
        words <<= 4
        words |= letters
        return words.view("<u2").astype(np.uint8)


def _stamps(lines: Lines, stamps: Stamps) -> Words:
    """`(1669809600.001488)`. The seconds are the same in many lines: only those that differ are worked out."""
    digits = lines.word(11)
    digits ^= _POINT_AND_BRACKET
    fault = digits + _SIXES_BETWEEN
    fault |= digits
    fault &= _DIGITS_BETWEEN
    out = eight_digits(digits, stamps.view(np.uint64))  # the eighth digit is the bracket: 0
    out *= 100
    first = _where_seconds_change(lines)
    for start, end in zip(first, [*first[1:], lines.count], strict=True):
        begin = start * lines.stride
        seconds = _seconds(lines.text[begin : begin + 11].tobytes())
        if seconds is None:
            fault[start:end] = 1
        else:
            out[start:end] += seconds * 1_000_000_000
    return fault


def _where_seconds_change(lines: Lines) -> list[int]:
    head, tail = lines.word(0), lines.word(3)
    change = head[1:] != head[:-1]
    change |= tail[1:] != tail[:-1]
    return [0, *(np.flatnonzero(change) + 1).tolist()]


def _seconds(text: bytes) -> int | None:
    """Of `(1669809600`; None if it is nothing of the kind, or a time beyond 2096 that nobody recorded."""
    return int(text[1:]) if _SECONDS.fullmatch(text) else None


def _name(lines: Lines, shape: Shape) -> Words:
    """A blank, the interface's name, a blank; nearly always those of the shape's own line."""
    expected = b" " + shape.name + b" "
    fault = np.zeros(lines.count, np.uint64)
    for at in range(0, len(expected), 8):
        part = expected[at : at + 8]
        fault |= (lines.word(_NAME + at) ^ int.from_bytes(part, "little")) & (1 << 8 * len(part)) - 1
    if fault.any():
        other = np.flatnonzero(fault)
        fault[other] = _no_name(lines, other, len(expected))
    return fault


def _no_name(lines: Lines, which: Ints, size: int) -> Flags:
    """Which of these lines have anything but a blank, letters and a blank there."""
    letters = lines.text[(which * lines.stride + _NAME)[:, None] + np.arange(size)]
    wrong = (letters <= ord(" ")) | (letters > ord("~"))
    wrong[:, [0, -1]] = letters[:, [0, -1]] != ord(" ")
    found: Flags = wrong.any(axis=1)
    return found


def _digits(lines: Lines, shape: Shape, size: Ints, words: Words) -> None:
    """The characters of the identifier, and of `size` digits of data; zeros for those that are not there."""
    for word, at in zip(words, (shape.hash - 8, shape.hash + 1, shape.hash + 9), strict=True):
        word[:] = np.ndarray((lines.count,), "<u8", lines.text, at, (lines.stride,))
    if shape.unused:
        words[0] &= ~np.uint64(shape.unused)
        words[0] |= np.uint64(shape.unused & _ZEROS)
    short = np.flatnonzero(size != 16)
    if len(size) == 1 and len(short):
        words[1:] = words[1:] & _DATA[:, size] | _NO_DATA[:, size]
    elif len(short):
        words[1:, short] = words[1:, short] & _DATA[:, size[short]] | _NO_DATA[:, size[short]]
