"""NMEA 0183 logs to columns: one table a sentence type, millions of sentences a second. Needs the extra `columns`.

```python
log = open_sentences("log.nmea")
for table in log:
    table.formatter, table.line, table.columns["heading_deg"].values
```
A line that is not a plain sentence (`sentence_lines`), as one with a time before it, is left to the reader of single
lines, in its turn: what is read, and what is refused, is the same.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import cast

import msgspec
import numpy as np
import numpy.typing as npt

from timonel import native
from timonel.errors import RecordingError
from timonel.nmea0183.registry import SENTENCES
from timonel.nmea0183.sentence import Sentence
from timonel.recording.coded_sentences import coded, grouped
from timonel.recording.decimals import LONGEST, Flags, Places, Text
from timonel.recording.formats import Lines, Reader, open_any
from timonel.recording.frames import Stamps, nanoseconds
from timonel.recording.lines import LogSentence, Record, Unreadable
from timonel.recording.part import stretches
from timonel.recording.sentence_columns import LISTS, Column, Columns, Wires, count_of_wires, mended, unread, usual
from timonel.recording.sentence_lines import PADDING, Commas, Sentences, cut, lines_of, padded

PORTION = 1 << 21
"""Bytes at a time: enough that what is done once a table costs less than what is done once a sentence."""

MOST_NAMES = 60_000
"""Formatters of a log that are told apart, so that 16 bits number them: all others that nobody declared are one table
without a name."""

_HASHES = 1 << 15
_SHORTEST = len("$IIHDT,*hh")

Numbers = npt.NDArray[np.int64]
Words = npt.NDArray[np.uint64]
Codes = npt.NDArray[np.uint16]


class SentenceTable(msgspec.Struct, frozen=True, eq=False, gc=False):
    """Sentences of one formatter, in the order of the log.

    `kind` is None for a formatter that is not declared, and there are no columns then. `line` int64[n] counts the
    lines from 1, `stamp` int64[n] is unix ns (NO_STAMP: none).
    """

    formatter: str
    kind: type[Sentence] | None
    line: Numbers
    stamp: Stamps
    columns: dict[str, Column]
    text: Text
    begin: Places
    end: Places

    @property
    def talker(self) -> npt.NDArray[np.bytes_]:
        """S2[n]; of a proprietary sentence, `P` and what stands behind it."""
        letters = np.stack((self.text.take(self.begin + 1), self.text.take(self.begin + 2)), axis=1)
        return letters.view("S2")[:, 0]

    @property
    def sentences(self) -> list[bytes]:
        """Each from `$` or `!` to its check sum."""
        return cut(self.text, self.begin, self.end)


class SentenceReader:
    """The tables of a log, portion by portion: iterate over it once; at its end the file is closed.

    `log` tells name, format and size, how many sentences were read, and what could not be. `malformed` counts
    sentences with a right check sum, but a field that nobody understands; they are in no table.
    """

    def __init__(self, log: Reader[Record], size: int = PORTION) -> None:
        self.log = log
        self.malformed = 0
        self._size = size
        self._line = 0
        self._formatters = _Formatters()

    def __iter__(self) -> Iterator[SentenceTable]:
        with self.log:
            rest = b""
            for parts in self._portions():
                text = b"".join((PADDING, rest, *parts, PADDING))
                behind = max(LONGEST, text.rfind(b"\n", 0, -LONGEST) + 1)
                rest = text[behind:-LONGEST]
                yield from self._tables(np.frombuffer(text, np.uint8)[: behind + LONGEST])
            if rest:
                last = [(self._line + 1, one) for one in self._single(self._line, rest, True)]
                yield from self._tables(padded(b""), last)
            for damage in self.log.damage():
                self.log.refuse(damage)

    def _portions(self) -> Iterator[list[bytes]]:
        parts: list[bytes] = []
        size = 0
        for part in self.log.portions():
            parts.append(part)
            size += len(part)
            if size >= self._size:
                yield parts
                parts, size = [], 0
        yield parts

    def _tables(self, text: Text, found: Iterable[tuple[int, LogSentence]] = ()) -> Iterator[SentenceTable]:
        lines = lines_of(text)
        single = list(found)
        for place, line in lines.others():
            before = self._line + place
            single += [(before + 1, one) for one in self._single(before, line, False)]
        sentences = lines.sentences(self._line)
        self._line += len(lines)
        if single:
            sentences = sentences.joined(_read_singly(single))
        self.log.frames += len(sentences)
        yield from self._by_formatter(sentences)

    def _single(self, before: int, text: bytes, last: bool) -> Iterator[LogSentence]:
        reader = cast(Lines, self.log.stream)
        reader.number = before
        found = list(reader.receive(text))
        for one in [*found, *reader.finish()] if last else found:
            if isinstance(one, Unreadable):
                self.log.refuse(one)
            elif isinstance(one, LogSentence):
                yield one

    def _by_formatter(self, sentences: Sentences) -> Iterator[SentenceTable]:
        codes = self._formatters.codes(sentences)
        groups = _sorted(codes, sentences) if sentences.commas else grouped(codes, sentences)
        for code, some in groups:
            table = self._table(self._formatters.names[code], self._formatters.kinds[code], some)
            if len(table.line):
                yield table

    def _table(self, formatter: str, kind: type[Sentence] | None, some: Sentences) -> SentenceTable:
        columns: Columns = {}
        if kind is not None:
            columns, odd = _columns(kind, some)
            columns, malformed = mended(columns, odd, lambda rows: cut(some.text, some.begin[rows], some.end[rows]))
            if malformed.any():
                self.malformed += int(np.count_nonzero(malformed))
                kept = np.flatnonzero(~malformed)
                columns = {name: column.some(kept) for name, column in columns.items()}
                some = some[kept]
        return SentenceTable(formatter, kind, some.line, some.stamp, columns, some.text, some.begin, some.end)


def open_sentences(path: str | Path, strict: bool = False, size: int = PORTION) -> SentenceReader:
    """Open an NMEA 0183 log; `-` is standard input, `size` in bytes. Raises RecordingError as `open_any` does, and for
    a recording of anything else."""
    log = open_any(path, strict)
    if log.kind != "sentences":
        log.close()
        raise RecordingError(f"{log.name}: {log.kind} ({log.format}), not NMEA 0183 sentences")
    return SentenceReader(log, size)


def _read_singly(found: list[tuple[int, LogSentence]]) -> Sentences:
    """Sentences, with the number of its line each, that stood in lines of other shapes."""
    sentences = lines_of(padded(b"".join(one.line + b"\n" for _, one in found))).sentences(0)
    line = np.array([number for number, _ in found])
    return msgspec.structs.replace(sentences, line=line, stamp=np.array([nanoseconds(one.stamp) for _, one in found]))


def _sorted(codes: Codes, sentences: Sentences) -> Iterator[tuple[int, Sentences]]:
    """Those that have the same code, in their order."""
    order = np.argsort(codes, kind="stable")
    codes = codes[order]
    for start, end in stretches(codes):
        yield int(codes[start]), sentences[order[start:end]]


def _columns(kind: type[Sentence], sentences: Sentences) -> tuple[Columns, Flags]:
    if kind in LISTS:
        return unread(kind, len(sentences))
    return usual(kind, _wires(kind, sentences, sentences.commas)) if sentences.commas else coded(kind, sentences)


def _wires(kind: type[Sentence], sentences: Sentences, commas: Commas) -> Wires:
    """Where the fields of sentences are."""
    wire = np.arange(count_of_wires(kind) + 1)[:, None]
    marks = commas.marks.take(commas.first + wire, mode="clip")
    begin, end = marks[:-1] + 1, marks[1:]
    last, most = sentences.end - 3, int(commas.count.max())
    if commas.count.min() == most:
        end[most - 1 : most] = last
        begin[most:], end[most:] = 0, 0
        return Wires(sentences.text, begin, end)
    end = np.where(wire[:-1] == commas.count - 1, last, end)
    there = wire[:-1] < commas.count
    return Wires(sentences.text, begin * there, end * there)


class _Formatters:
    """Numbers for the formatters that occur, looked up by their letters; 0 for those that are too many."""

    def __init__(self) -> None:
        self.names = [""]
        self.kinds: list[type[Sentence] | None] = [None]
        self._letters = np.zeros(1, np.uint64)
        self._by_hash = np.zeros(_HASHES, np.uint16)
        self._proprietary: dict[bytes, int] = {}

    def codes(self, sentences: Sentences) -> Codes:
        """uint16[n]: the number of each sentence's formatter."""
        if sentences.commas:
            return self._found(sentences)
        codes = np.empty(len(sentences), np.uint16)
        native.kernels.sentence_codes(
            sentences.text, sentences.begin, sentences.end, self._by_hash, self._letters, codes
        )
        others = np.flatnonzero(codes == 0)
        codes[others] = self._found(sentences[others])
        return codes

    def _found(self, sentences: Sentences) -> Codes:
        head: Words = np.ndarray(len(sentences.text) - 7, "<u8", sentences.text, 0, (1,))[sentences.begin]
        letters = head >> np.uint64(24) & np.uint64(0xFFFFFF)
        usual = (head >> 48 & 0xFF == ord(",")) & (head >> 8 & 0xFF != ord("P"))
        usual &= sentences.end - sentences.begin >= _SHORTEST
        codes = self._by_hash.take(_hash(letters))
        new = np.flatnonzero(usual & (self._letters.take(codes) != letters))
        while len(new):
            same = letters[new] == letters[new[0]]
            codes[new[same]] = self._new(letters[new[0]])
            new = new[~same]
        others = np.flatnonzero(~usual)
        bodies = cut(sentences.text, sentences.begin[others] + 1, sentences.end[others] - 3)
        codes[others] = [self._address(body.partition(b",")[0]) for body in bodies]
        return codes

    def _new(self, letters: np.uint64) -> int:
        """The number of three letters, which is looked up next time unless others have the same hash."""
        known = np.flatnonzero(self._letters == letters)
        if len(known):
            return int(known[0])
        formatter = int(letters).to_bytes(3, "little")
        kind = SENTENCES.get(formatter)
        if kind is None and len(self.names) >= MOST_NAMES:
            return 0
        code = self._add(formatter, kind, letters)
        self._by_hash[_hash(np.array(letters))] = code
        return code

    def _address(self, address: bytes) -> int:
        """The number of an address that is not two letters of a talker and three of a formatter."""
        if address not in self._proprietary:
            if len(self.names) >= MOST_NAMES:
                return 0
            self._proprietary[address] = self._add(address, None, np.uint64(0))
        return self._proprietary[address]

    def _add(self, name: bytes, kind: type[Sentence] | None, letters: np.uint64) -> int:
        self.names.append(name.decode("latin-1"))
        self.kinds.append(kind)
        self._letters = np.append(self._letters, letters)
        return len(self.names) - 1


def _hash(letters: Words) -> Places:
    place = (letters & 31) << 10 | (letters >> 8 & 31) << 5 | letters >> 16 & 31
    return place.astype(np.intp)
