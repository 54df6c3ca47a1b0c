"""JSON lines of millions of messages: columns to text without a step for a single one. Needs the extra `columns`.

    {"time": 1669809600.001488, "priority": 2, "source": 204, "destination": 255, "pgn": 127250, "name": ...}

The bytes are those of `decoded.Message.line`, in the order of the recording. Where there are compiled kernels, one of
them writes what can be told in steps (`line_steps`), which is nearly all. Of the rest, lines that are few of their
kind, and a rover's, are written as those of single messages.
"""

from collections.abc import Collection, Iterator, Sequence

import msgspec
import numpy as np
import numpy.typing as npt

from timonel import native
from timonel.nmea2000.catalogue import Definition, find
from timonel.nmea2000.catalogue_columns import Columns, Items, columns
from timonel.nmea2000.identifier import split
from timonel.recording.assembly import Group
from timonel.recording.decoded import Message, OwnMessage
from timonel.recording.frames import NO_STAMP
from timonel.recording.sinks.line_page import LinePage, Stepped
from timonel.recording.sinks.line_steps import LineSteps
from timonel.recording.sinks.notation import HEXADECIMAL, Known, Notation
from timonel.recording.sinks.texts import Page, Sizes, Texts, listed
from timonel.recording.tables import NOTHING, Selected, Tables
from timonel.vehicles.rover.protocol import Protocol

FEW = 20
"""Messages of a kind that are quicker written one by one."""

BLOCK = 1 << 12
"""Lines at a time, so that what is worked on stays in the processor's cache."""

_END, _END_WITHOUT_FIELDS = b"}}\n", b'"}\n'
_FIELDS = b'", "fields": {'
_ITEM = b", {"
_COMMA = 2  # bytes before each field, which the first one has not
_PGN = b'"pgn": '
_PRIORITY = b', "priority": '
_ADDRESSES = 20  # bits: priority, destination (or 255) and source
_THREE = np.array([b"%03d" % number for number in range(1000)]).view("V3")
_NEVER = -(1 << 63)

Rows = npt.NDArray[np.intp]
Line = tuple[int, bytes]


class JsonLines:
    """Writes the messages of a recording, chunk by chunk; without `labels` lookups are numbers.

    `day` is when the times of a recording begin, in ns: 0 if they are unix time, None if they have no date. Only
    messages of these `names`, if given, are written.
    """

    def __init__(
        self,
        labels: bool = True,
        day: int | None = 0,
        protocol: Protocol | None = None,
        names: Collection[str | None] | None = None,
    ) -> None:
        self._labels = labels
        self._day = day
        self._names = names
        self._protocol = protocol or Protocol()
        self._own = Tables(self._protocol)
        self._notation = Notation(labels)
        self._addresses = Known(_ADDRESSES, _address)
        self._paper = Page()
        self._steps = LineSteps(labels)
        self._told_lines = LinePage(self._steps, day, self._by_hand)

    def lines(self, groups: Sequence[Group], first: int, frames: int, selected: Selected = NOTHING) -> memoryview:
        """The lines of the messages that `frames` frames complete, of which the first one is number `first`.

        `selected` is `Tables.lots`'. They are there until the next ones are written.
        """
        lots: list[Stepped] = []
        tables: list[_Table] = []
        single: list[Line] = []
        for group in groups:
            if group.pgn is None:
                for lot in self._own.lots([group]):
                    single += self._one_by_one(lot.messages, lot.name, first)
            elif native.kernels is None:
                self._split(group, first, selected, tables, single)
            else:
                self._told(group, group.pgn, first, selected, lots, tables, single)
        made, sizes = self._page(tables, single, frames)
        return self._told_lines.lines(lots, first, made, sizes) if lots else made

    def _told(
        self, group: Group, pgn: int, first: int, selected: Selected, lots: list[Stepped], tables: list["_Table"],
        single: list[Line],
    ) -> None:  # fmt: skip
        """Each variant of a PGN is a lot that the kernel writes, if it can."""
        for definition, name, part in self._variants(group, selected):
            written = self._steps.written(pgn, definition)
            if written is not None:
                lots.append(Stepped(written, name, part))
            elif len(part.row) < FEW:
                single += self._one_by_one(part, name, first)
            else:
                tables.append(self._table(definition, part, first))

    def _split(self, group: Group, first: int, selected: Selected, tables: list["_Table"], single: list[Line]) -> None:
        """Each variant of a PGN is a table, unless it is rare."""
        if len(group.row) < FEW and self._names is None:
            single += self._one_by_one(group, None, first)
            return
        for definition, name, part in self._variants(group, selected):
            if len(part.row) < FEW:
                single += self._one_by_one(part, name, first)
            else:
                tables.append(self._table(definition, part, first))

    def _variants(self, group: Group, selected: Selected) -> Iterator[tuple[Definition | None, str | None, Group]]:
        """The definitions of a PGN that are asked for, their names, and the messages of each."""
        for lot in self._own.lots([group], selected):
            if self._names is None or lot.name in self._names:
                definition = lot.definition if isinstance(lot.definition, Definition) else None
                yield definition, lot.name, lot.messages

    def _one_by_one(self, group: Group, name: str | None, first: int) -> Iterator[Line]:
        """The lines of a few messages, and the place in the chunk of each."""
        if group.frame is not None and self._names is not None and name not in self._names:
            return
        data, width = group.payloads.tobytes(), group.payloads.shape[1]
        starts = [width * place for place in range(len(group.row))]
        columns_of = (group.row, group.stamp, group.identifier, group.lengths)
        for start, row, stamp, identifier, length in zip(starts, *(c.tolist() for c in columns_of), strict=True):
            payload = data[start : start + length]
            time = None if stamp == NO_STAMP or self._day is None else (stamp + self._day + 500) // 1000 / 1e6
            if group.frame is None:
                priority, pgn, source, destination = split(identifier)
                line = Message(time, priority, source, destination, pgn, payload, find(pgn, payload)).line(self._labels)
            else:
                value = self._protocol.decode(group.frame, payload)
                line = OwnMessage(time, group.frame, payload, value).line(self._labels)
            yield row - first, f"{line}\n".encode()

    def _by_hand(self, message: Group, name: str | None) -> bytes:
        ((_, line),) = self._one_by_one(message, name, 0)
        return line

    def _table(self, definition: Definition | None, group: Group, first: int) -> "_Table":
        head = Message(None, 0, 0, 0, group.pgn or 0, b"", definition).head.encode().removeprefix(_PGN)
        data = Texts(HEXADECIMAL[group.payloads].view(np.uint8), 2 * group.lengths)
        stamp = group.stamp if not self._day else np.where(group.stamp == NO_STAMP, NO_STAMP, group.stamp + self._day)
        if self._day is None:
            stamp = np.full(len(group.row), NO_STAMP)
        if definition is None:
            return _Table(group.row - first, stamp, group.identifier, head, data, None, ())
        found = columns(definition, group.payloads, group.lengths, self._labels)
        pieces = self._notation.pieces(definition, found.fields)
        lists = tuple(self._list(found, items) for items in found.groups if len(items.rows))
        return _Table(group.row - first, stamp, group.identifier, head, data, pieces, lists)

    def _list(self, found: Columns, items: Items) -> "_List":
        opening = f', "{items.group.name}": [{{'.encode()
        pieces = self._notation.pieces(found.definition, items.fields)
        ordinal = np.arange(len(items.rows)) - np.searchsorted(items.rows, items.rows)
        sizes = np.maximum(_total(pieces, len(ordinal)), _COMMA) - _COMMA + len(_ITEM) + 1
        sizes += (ordinal == 0) * (len(opening) - len(_ITEM))
        return _List(items.rows, ordinal, opening, pieces, sizes)

    def _page(self, tables: list["_Table"], single: list[Line], frames: int) -> tuple[memoryview, Sizes]:
        """All lines in the order of the frames that completed them, and bytes a frame."""
        sizes = np.zeros(frames, np.intp)
        for one, line in single:
            sizes[one] = len(line)
        stamps, identifiers = np.full(frames, _NEVER), np.zeros(frames, np.uint32)
        for table in tables:
            sizes[table.place] = table.sizes
            stamps[table.place], identifiers[table.place] = table.stamp, table.identifier
        within = np.zeros(frames, np.bool_)
        for table in tables:
            within[table.place] = True
        place = np.flatnonzero(within)
        time = _times(stamps[place])
        key = _key(identifiers[place])
        address = self._addresses.texts(key, key)
        heads = time.sizes + address.sizes + len(_PGN)
        sizes[place] += heads
        at = np.cumsum(sizes) - sizes
        page = self._paper
        page.clear(int(sizes.sum()))
        ahead = np.zeros(frames, np.intp)
        ahead[place] = at[place] + heads
        for table in tables:
            table.put(page, ahead[table.place])
        for start in range(0, len(place), BLOCK):
            block = slice(start, start + BLOCK)
            end = _put(page, at[place[block]], (time, address), block)
            page.put_all(end, _PGN)
        for one, line in single:
            page.put_one(int(at[one]), line)
        return page.content, sizes


class _List(msgspec.Struct, frozen=True, eq=False, gc=False):
    """Items of repeating sets, in the order of the rows they belong to: `, "list": [{...}`, then `, {...}`.

    `ordinal` counts the items of a row.
    """

    rows: Rows
    ordinal: Rows
    opening: bytes
    pieces: list[Texts]
    lengths: Sizes

    def sizes(self, rows: int) -> Sizes:
        """Bytes of the list of each row."""
        sizes = np.bincount(self.rows, self.lengths, rows).astype(np.intp)
        return sizes + (sizes > 0)

    def put(self, page: Page, at: Sizes, block: slice) -> Sizes:
        """Put the lists of some rows; where they end. The first items of all, then the second ones, and so on."""
        start, end = np.searchsorted(self.rows, (block.start, block.start + len(at)))
        at = at.copy()
        rows, ordinal = self.rows[start:end] - block.start, self.ordinal[start:end]
        for number in range(int(ordinal.max(initial=-1)) + 1):
            which = np.flatnonzero(ordinal == number)
            at[rows[which]] = self._put(page, at[rows[which]], start + which, _ITEM if number else self.opening)
        ends = at[rows[ordinal == 0]]
        page.put_all(ends, b"]")
        at[rows[ordinal == 0]] = ends + 1
        return at

    def _put(self, page: Page, at: Sizes, which: Rows, opening: bytes) -> Sizes:
        first = at + (len(opening) - _COMMA)
        ends = np.maximum(_put(page, first, self.pieces, which), first + _COMMA)
        page.put_all(at, opening)
        page.put_all(ends, b"}")
        return ends + 1


class _Table(msgspec.Struct, frozen=True, eq=False):
    """The lines of one definition behind their time and addresses. `pieces` is None for what canboat does not know."""

    place: Rows
    stamp: npt.NDArray[np.int64]
    identifier: npt.NDArray[np.uint32]
    head: bytes
    data: Texts
    pieces: list[Texts] | None
    lists: tuple[_List, ...]

    @property
    def sizes(self) -> Sizes:
        sizes = self.data.sizes + len(self.head)
        if self.pieces is None:
            return sizes + len(_END_WITHOUT_FIELDS)
        fields = _total(self.pieces, len(sizes)) + sum(one.sizes(len(sizes)) for one in self.lists)
        sizes += np.maximum(fields, _COMMA) + (len(_FIELDS) - _COMMA + len(_END))
        return sizes

    def put(self, page: Page, at: Sizes) -> None:
        for start in range(0, len(at), BLOCK):
            block = slice(start, start + BLOCK)
            self._put(page, at[block], block)

    def _put(self, page: Page, at: Sizes, block: slice) -> None:
        cells, sizes = self.data.block(block)
        page.put(at + len(self.head), cells, sizes)
        ends = at + len(self.head) + sizes
        if self.pieces is not None:
            first = ends + len(_FIELDS) - _COMMA
            after = _put(page, first, self.pieces, block)
            for one in self.lists:
                after = one.put(page, after, block)
            page.put_all(ends, _FIELDS)
            ends = np.maximum(after, first + _COMMA)
        page.put_all(ends, _END if self.pieces is not None else _END_WITHOUT_FIELDS)
        page.put_all(at, self.head)


def _put(page: Page, at: Sizes, pieces: Sequence[Texts], block: slice | Rows) -> Sizes:
    """Put texts side by side; where they end."""
    for piece in pieces:
        cells, sizes = piece.block(block)
        page.put(at, cells, sizes)
        at = at + sizes
    return at


def _total(pieces: Sequence[Texts], rows: int) -> Sizes:
    total = np.zeros(rows, np.intp)
    for piece in pieces:
        total += piece.sizes
    return total


def _key(identifier: npt.NDArray[np.uint32]) -> npt.NDArray[np.intp]:
    """Source, destination and priority of identifiers, in 19 bits."""
    form = identifier >> 16 & 0xFF
    destination = np.where(form < 240, identifier >> 8 & 0xFF, 255)
    return (identifier & 0xFF | destination << 8 | (identifier >> 26 & 7) << 16).astype(np.intp)


def _address(key: int) -> bytes:
    return b'%d, "source": %d, "destination": %d, ' % (key >> 16, key & 0xFF, key >> 8 & 0xFF)


def _times(stamps: npt.NDArray[np.int64]) -> Texts:
    """`{"time": 1669809600.001488, "priority": `; what is the same for a second is made once for it."""
    never = stamps == _NEVER
    microseconds = (np.where(never, 0, stamps) + 500) // 1000
    seconds = microseconds // 1_000_000
    change = np.ones(len(stamps), np.bool_)
    np.not_equal(seconds[1:], seconds[:-1], out=change[1:])
    begins = listed([b'{"time": %d.' % second for second in seconds[change].tolist()])
    if never.any() or seconds.min(initial=0) < 0 or len(set(begins.lengths.tolist())) > 1:
        return listed([_time(one, nothing) for one, nothing in zip(microseconds.tolist(), never.tolist(), strict=True)])
    thousands, units = np.divmod((microseconds - seconds * 1_000_000).astype(np.uint32), np.uint32(1000))
    width = begins.cells.shape[1]
    form = [("second", f"V{width}"), ("thousands", "V3"), ("units", "V3"), ("rest", f"V{len(_PRIORITY)}")]
    cells = np.empty(len(stamps), form)
    cells["second"] = begins.cells.view(f"V{width}")[:, 0].take(np.cumsum(change) - 1)
    cells["thousands"] = _THREE.take(thousands)
    cells["units"] = _THREE.take(units)
    cells["rest"] = np.frombuffer(_PRIORITY, f"V{len(_PRIORITY)}")
    return Texts(cells.view(np.uint8).reshape(len(stamps), cells.itemsize), np.full(len(stamps), cells.itemsize))


def _time(microseconds: int, never: bool) -> bytes:
    sign = b"-" if microseconds < 0 else b""
    time = b"null" if never else b"%s%d.%06d" % (sign, *divmod(abs(microseconds), 1_000_000))
    return b'{"time": %s%s' % (time, _PRIORITY)
