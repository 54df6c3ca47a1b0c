"""Whole recordings at once: many payloads of one definition as NumPy columns. Needs the extra `columns`.

```python
for definition, rows in select(127250, payloads, lengths):
    found = columns(definition, payloads[rows], lengths[rows])
    found.fields["heading"].values              # float64[n], rad, NaN where not available
    found.fields["reference"].values, .valid    # uint8[n], bool[n]; .field.labels has the words
    found.groups[0].rows, .fields               # items of a repeating set, and the row each belongs to
```
Fixed fields are strided views, scaled; nothing is done row by row but for text, bytes, and the parameters of PGN
126208. The values are those of `Definition.decode_codes`, bit for bit.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cache, cached_property, partial, reduce
from itertools import pairwise
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from timonel import native
from timonel.core.fields import Number
from timonel.nmea2000 import catalogue_codec as scalar
from timonel.nmea2000.catalogue import Definition, Field, Group, candidates, find, keys, pairs
from timonel.nmea2000.catalogue_layout import Place, Repeated, Run, Tail, kind, plan, single
from timonel.nmea2000.fixed_columns import (
    Array,
    Column,
    Mask,
    Payloads,
    Rows,
    objects,
    pieces,
    reader,
    run_columns,
    with_room,
)

WINDOW = 256  # bytes that no item or field is longer than


class Mixed(msgspec.Struct, frozen=True, dict=True):
    """The values of a field whose kind the message tells, one a row; `parts` are those of one kind, with their rows."""

    field: Field
    rows: int
    parts: tuple[tuple[Rows, Column], ...]

    @cached_property
    def values(self) -> Array:
        """Objects: str, bytes, numbers, None. Made when they are asked for."""
        values = np.full(self.rows, None, object)
        for rows, column in self.parts:
            values[rows] = objects(listed(column))
        return values

    @property
    def valid(self) -> None:
        """As `Column` has it: the values themselves tell."""

    @property
    def sizes(self) -> None:
        """As `Column` has it."""


AnyColumn = Column | Mixed


class Items(msgspec.Struct, frozen=True):
    """The items of a repeating set of all rows, in order; `rows` says which row each belongs to."""

    group: Group
    rows: Rows
    fields: Mapping[str, AnyColumn]


class Columns(msgspec.Struct, frozen=True):
    """What `columns` makes: fields by canboat's id, and repeating sets."""

    definition: Definition
    fields: Mapping[str, AnyColumn]
    groups: tuple[Items, ...]


# Which variant a row is ----------------------------------------------------------------------------


def select(pgn: int, payloads: Payloads, lengths: Rows) -> list[tuple[Definition | None, Rows]]:
    """`find` for uint8[n, width] payloads: the definitions that occur, and intp[m] rows of each in ascending order."""
    left = np.arange(len(payloads))
    if not _distinction(pgn)[1]:
        return [(find(pgn, b""), left)] if len(left) else []
    found: dict[str, tuple[Definition | None, list[Rows]]] = {}
    heads = _heads(pgn, payloads, lengths)
    while len(left):
        first = left[0]
        definition = find(pgn, payloads[first, : lengths[first]].tobytes())
        other = reduce(np.bitwise_or, [head != head[0] for head in heads])
        rest = np.flatnonzero(other)
        same = left[~other] if len(rest) else left
        found.setdefault(definition.id if definition else "", (definition, []))[1].append(same)
        left, heads = left[rest], [head[rest] for head in heads]
    return [(definition, np.sort(np.concatenate(rows)) if rows[1:] else rows[0]) for definition, rows in found.values()]


def _heads(pgn: int, payloads: Payloads, lengths: Rows) -> list[Array]:
    """All that tells the variants of a PGN apart, and how much of it is there, as numbers, one a row."""
    masks, longest = _distinction(pgn)
    width = masks.nbytes
    words = with_room(payloads, width)[:, :width].view("<u8")
    heads: list[Array] = [words[:, place] & mask for place, mask in enumerate(masks) if mask]
    if lengths.min(initial=longest) < longest:
        heads.append(np.minimum(lengths, longest))
    return heads or [np.zeros(len(payloads), np.uint8)]


@cache
def _distinction(pgn: int) -> tuple[npt.NDArray[np.uint64], int]:
    """Words of which the bits matter that tell the variants of a PGN apart, and how many bytes these take."""
    union = longest = 0
    for definition in candidates(pgn):
        union |= definition.pattern[0]
        longest = max(longest, definition.pattern[2])
    return np.frombuffer(union.to_bytes(-(-longest // 8) * 8, "little"), "<u8"), longest


# Columns -------------------------------------------------------------------------------------------


def columns(definition: Definition, payloads: Payloads, lengths: Rows, labels: bool = True) -> Columns:
    """Decode uint8[n, width] payloads, of which row i has `lengths[i]` bytes.

    What a row is too short for is not available. `labels` is for lookups whose field is told by the message itself,
    PGN 126208's parameters and values with keys: words, or numbers.
    """
    table = _Table(definition, _Store(payloads, lengths), scalar.Flavour(labels, False))
    table.read(plan(definition).parts, ends_matter=False)
    order = [field.id for field in definition.fields if field.id in table.fields]
    return Columns(definition, {name: table.fields[name] for name in order}, tuple(table.groups))


class _Kind(msgspec.Struct, frozen=True, eq=False, gc=False):
    """Rows with one kind of value: their numbers, the fewest bytes that are left in one of them, and the first eight
    bytes of each, if they are known."""

    rows: Rows
    least: int
    words: Payloads | None


class _Store:
    """The payloads of all rows in one piece, to take windows from."""

    def __init__(self, payloads: Payloads, lengths: Rows) -> None:
        self.payloads = payloads
        self.lengths = lengths

    @cached_property
    def flat(self) -> Payloads:
        """All of them, one behind the other, and zeros."""
        return np.concatenate((self.payloads.ravel(), np.zeros(WINDOW, np.uint8)))

    @cached_property
    def _bytes(self) -> bytes:
        return self.flat.tobytes()

    def windows(self, places: Rows, size: int) -> Payloads:
        """uint8[m, size] from some places in `flat` on; what stands behind a payload's end is not its own."""
        if not size or not len(places):
            return np.zeros((len(places), size), np.uint8)
        if native.kernels is not None:
            cells = np.empty((len(places), size), np.uint8)
            native.kernels.gather(self.flat, np.ascontiguousarray(places), cells, size)
            return cells
        found: Payloads = _everywhere(self.flat, f"V{size}")[places].view(np.uint8).reshape(-1, size)
        return found

    def by_kind(self, kinds: Array, places: Rows, left: Rows) -> list[_Kind]:
        """What stands at some places, of which so much is left of their payloads, sorted by kind."""
        count = len(kinds)
        if native.kernels is None or kinds.dtype.itemsize > 2:
            order = np.argsort(kinds, kind="stable")
            bounds = [0, *(np.flatnonzero(np.diff(kinds.take(order))) + 1).tolist(), count] if count else []
            groups = [order[start:end] for start, end in pairwise(bounds)]
            return [_Kind(rows, int(left.take(rows).min()), None) for rows in groups]
        order, ends, least = (np.empty(count, np.intp) for _ in range(3))
        words = np.empty((count, 8), np.uint8)
        found = native.kernels.values_by_kind(self.flat, kinds, places, left, order, words, ends, least)
        spans = zip(pairwise((0, *ends[:found].tolist())), least[:found].tolist(), strict=True)
        return [_Kind(order[start:end], fewest, words[start:end]) for (start, end), fewest in spans]

    def pieces(self, places: Rows, sizes: Rows) -> list[bytes]:
        """Some bytes from some places in `flat` on."""
        flat = self._bytes
        return [flat[place : place + size] for place, size in zip(places.tolist(), sizes.tolist(), strict=True)]

    def whole(self, rows: Rows) -> list[bytes]:
        """The payloads of some rows as bytes."""
        return pieces(self.payloads[rows], self.lengths[rows])


def _everywhere(flat: Payloads, kind: str) -> Array:
    """What begins at each byte, as a type of NumPy's."""
    return np.ndarray(flat.size - np.dtype(kind).itemsize + 1, kind, flat.data, strides=(1,))


class _Table:
    """Rows that are read from left to right; `at` is where each of them is: one place for all, or one for each."""

    def __init__(
        self, definition: Definition, store: _Store, flavour: scalar.Flavour, rows: Rows | None = None
    ) -> None:
        self.definition = definition
        self.store = store
        self.lengths = store.lengths if rows is None else store.lengths.take(rows)
        self.flavour = flavour
        self._rows = rows
        self.at: int | Rows = 0
        self.fields: dict[str, AnyColumn] = {}
        self.groups: list[Items] = []

    def __len__(self) -> int:
        return len(self.lengths)

    # Of most tables these are not asked for.
    @cached_property
    def rows(self) -> Rows:
        """The rows of the store."""
        return np.arange(len(self)) if self._rows is None else self._rows

    @cached_property
    def begin(self) -> Rows:
        """Where they begin in all that the store has."""
        begin: Rows = self.rows * self.store.payloads.shape[1]
        return begin

    @cached_property
    def shortest(self) -> int:
        """The fewest bytes of a row; 0 if there are none."""
        return int(self.lengths.min()) if len(self) else 0

    def places(self, ats: Rows) -> Rows:
        """Where these are in all that the store has; at the payload's end, if they are beyond it."""
        places: Rows = self.begin + np.minimum(ats, self.lengths)
        return places

    def _places_and_left(self, ats: Rows) -> tuple[Rows, Rows]:
        """`places`, and how many bytes of each payload follow."""
        left = self.lengths - ats
        if len(left) and left.min() >= 0:
            return self.begin + ats, left
        return self.places(ats), np.maximum(left, 0)

    def read(self, parts: Sequence[Any], ends_matter: bool = True) -> None:
        """Read these parts; `at` is where they end, if that matters."""
        for number, part in enumerate(parts, 1):
            match part:
                case Run():
                    self._run(part)
                case Tail():
                    self._tail(part.field, ends_matter or number < len(parts))
                case Repeated():
                    self._repeated(part)

    def _run(self, run: Run) -> None:
        if run.conditional:
            there = np.fromiter(map(scalar.proprietary, listed(self.fields["pgn"])), np.bool_, len(self))
            self.fields |= run_columns(run, *self._block(run.size, there))
            self.at = self.at + run.size * there
            return
        self.fields |= run_columns(run, *self._block(run.size))
        self.at = self.at + run.size

    def _block(self, size: int, there: Mask | None = None) -> tuple[Payloads, Rows | None]:
        """uint8[n, size or less] from where the rows are, and how many bytes each has if not all have them all."""
        if isinstance(self.at, int):
            block = self.store.payloads[:, self.at : self.at + size]
            if there is None and self.shortest - self.at >= size:
                return block, None
        else:
            places, have = self._places_and_left(self.at)
            block = self.store.windows(places, size)
            if there is None:
                return block, None if len(have) and have.min() >= size else have
        have = self.lengths - self.at
        if there is not None:
            have = have * there
        return block, None if len(have) and have.min() >= size else np.maximum(have, 0)

    def _tail(self, field: Field, ends_matter: bool) -> None:
        ats = np.broadcast_to(np.asarray(self.at, np.intp), len(self))
        key, length = scalar.announced_by(self.definition, field)
        if field.kind == "DYNAMIC_FIELD_VALUE" and not field.length:
            self._keyed(field, key, length, ats, ends_matter)
            return
        read = scalar.tail_reader(self.definition, field, self.flavour)
        if not field.length and field.kind in _BEHIND:
            self._texts(field, read, ats)
            return
        context: list[list[Any]] = []
        if field.length:
            context = [listed(self.fields[field.length])]
        data = self.store.whole(self.rows)
        made = [read(*arguments) for arguments in zip(data, ats.tolist(), *context, strict=True)]
        self.fields[field.id] = Column(field, objects([value for value, _ in made]))
        self.at = np.fromiter((end for _, end in made), np.intp, len(made))

    def _texts(self, field: Field, read: Callable[[bytes, int], tuple[Any, int]], ats: Rows) -> None:
        """Texts that say their length: each of those that there are is read once."""
        ends = _BEHIND[field.kind](self.store.flat, self.begin + ats, self.begin + self.lengths) - self.begin
        found = self.store.pieces(self.places(ats), np.maximum(np.minimum(ends, self.lengths) - ats, 0))
        known = {raw: read(raw, 0)[0] for raw in set(found)}
        self.fields[field.id] = Column(field, objects([known[raw] for raw in found]))
        self.at = ends

    def _keyed(self, field: Field, key: Field | None, length: Field | None, ats: Rows, ends_matter: bool) -> None:
        """Values whose kind their key tells: those of one kind at a time."""
        keyed = scalar.Keyed(key, length, self.flavour)
        told = self.fields[key.id] if key else None, self.fields[length.id] if length else None
        places, left = self._places_and_left(ats)
        parts, ends = [], ats.copy() if ends_matter else ats
        for some in self.store.by_kind(_kinds(*told, len(self)), places, left):
            rows = some.rows
            code, size = _code(told[0], rows[0]), _code(told[1], rows[0])
            have = keyed.size(code, size)
            values = self._number(some, have, keyed, code, places)
            if values is None or ends_matter:
                sizes = left.take(rows) if have is None else np.minimum(left.take(rows), have)
            if values is None:
                values = self._of_kind(places.take(rows), sizes, keyed, code, size)
            if ends_matter:
                ends[rows] += sizes
            parts.append((rows, values))
        self.at = ends
        self.fields[field.id] = Mixed(field, len(self), tuple(parts))

    def _number(
        self, some: _Kind, have: int | None, keyed: scalar.Keyed, code: int | None, places: Rows
    ) -> Column | None:
        """The values of one key and of `have` bytes each, if that is a number and nothing is cut short."""
        told = keyed.told(code)
        if told is None or not have or some.least < have:
            return None
        number = scalar.sized(told, have)
        if number is None or not isinstance(kind(number), Number):
            return None
        (place,) = single(number).places  # type: ignore[union-attr]
        words = some.words
        cells = self.store.windows(places.take(some.rows), have) if words is None or have > 8 else words[:, :have]
        return reader(place)(cells, None)

    def _of_kind(self, places: Rows, sizes: Rows, keyed: scalar.Keyed, code: int | None, length: int | None) -> Column:
        """The values of one key and one length, each of which has some bytes."""
        found = self.store.pieces(places, sizes)
        known = {raw: keyed.read(raw, 0, code, length)[0] for raw in set(found)}
        return Column(keyed.told(code) or Field(), objects([known[raw] for raw in found]))

    def _repeated(self, part: Repeated) -> None:
        group, ats = part.group, np.broadcast_to(np.asarray(self.at, np.intp), len(self))
        counts = self._counts(group)
        if part.packed or any(isinstance(one, Tail) and one.field.kind == "VARIABLE" for one in part.parts):
            self._read_one_by_one(part, ats, counts)
        elif part.size is not None:
            self._fixed_items(part, part.size, ats, counts)
        else:
            self._items(part, ats, counts)

    def _counts(self, group: Group) -> Rows:
        if not group.counter:
            return np.full(len(self), scalar.EVERYTHING, np.intp)
        column = self.fields[group.counter]
        counts = column.values.astype(np.intp)
        return counts if column.valid is None else counts * column.valid

    def _fixed_items(self, part: Repeated, size: int, ats: Rows, counts: Rows) -> None:
        """Items of one size: all at once."""
        room = (self.lengths - ats - part.least) // size + 1
        counts = np.maximum(np.minimum(counts, room), 0)
        rows = np.repeat(np.arange(len(self)), counts)
        # The first item of each row is so far from where it would be if all items stood side by side.
        first = self.begin + ats - size * (np.cumsum(counts) - counts)
        places = np.repeat(first, counts) + np.arange(0, size * len(rows), size)
        (run,) = part.parts
        assert isinstance(run, Run)
        self.at = ats + size * counts
        have = None
        if not len(rows) or (self.at > self.lengths).any():
            have = np.maximum(np.repeat(self.begin + self.lengths, counts) - places, 0)
        self.groups.append(Items(part.group, rows, run_columns(run, self.store.windows(places, size), have)))

    def _items(self, part: Repeated, ats: Rows, counts: Rows) -> None:
        """Items of many sizes: where each of them stands is found first, then all are read at once."""
        walk = _walk(self.definition, part)
        if walk is None:
            self._item_after_item(part, ats, counts)
            return
        find_all = self._stepped if native.kernels is None or walk.steps is None else self._compiled
        found, places = find_all(walk, part.least, ats, counts)
        if not len(places):
            self.groups.append(_joined(self.definition, part.group, []))
            return
        rows = np.repeat(np.arange(len(self)), found)
        table = _Table(self.definition, self.store, self.flavour, self.rows[rows])
        table.at = places - table.begin
        table.read(part.parts, ends_matter=False)
        fields = self.definition.fields[part.group.first : part.group.end]
        kept = {field.id: table.fields[field.id] for field in fields if not field.silent}
        self.groups.append(Items(part.group, rows, kept))

    def _compiled(self, walk: "Walk", least: int, ats: Rows, counts: Rows) -> tuple[Rows, Rows]:
        """How many items each row has, and where all of them stand; `self.at` becomes where they end."""
        at, end = self.begin + ats, self.begin + self.lengths
        found, room = np.empty(len(self), np.intp), np.maximum(0, (self.lengths - ats) // least + 1)
        places = np.empty(int(np.minimum(room, counts).clip(0).sum()), np.intp)
        flat, values = self.store.flat, walk.values if walk.values is not None else _NO_VALUES
        count = native.kernels.item_places(flat, walk.steps, values, at, end, counts, least, found, places)
        self.at = at - self.begin
        return found, places[:count]

    def _stepped(self, walk: "Walk", least: int, ats: Rows, counts: Rows) -> tuple[Rows, Rows]:
        """The same by steps: the first items of all rows, the second ones, and so on."""
        steps, self.at = self._steps(walk.behind, least, ats, counts)
        if not steps:
            return np.zeros(len(self), np.intp), np.empty(0, np.intp)
        found = np.bincount(np.concatenate([rows for rows, _ in steps]), minlength=len(self))
        places = np.empty(int(found.sum()), np.intp)
        firsts = np.cumsum(found) - found
        for number, (some, at) in enumerate(steps):
            places[firsts.take(some) + number] = at
        return found, places

    def _steps(self, walk: "Behind", least: int, ats: Rows, counts: Rows) -> tuple[list[tuple[Rows, Rows]], Rows]:
        """Where the first items of all rows stand, the second of those that have one, and so on; where all end."""
        ends, steps = ats.copy(), []
        rows = np.flatnonzero((counts > 0) & (ats + least <= self.lengths))
        begin, counts = self.begin.take(rows), counts.take(rows)
        at, end = begin + ats.take(rows), begin + self.lengths.take(rows)
        while len(rows):
            steps.append((rows, at))
            at = walk(self.store.flat, at, end)
            on = at + least <= end
            if not (enough := counts > len(steps)).all():
                on &= enough
            off = np.flatnonzero(~on)
            ends[rows.take(off)] = at.take(off) - self.begin.take(rows.take(off))
            left = np.flatnonzero(on)
            rows, at, end, counts = rows.take(left), at.take(left), end.take(left), counts.take(left)
        return steps, ends

    def _item_after_item(self, part: Repeated, ats: Rows, counts: Rows) -> None:
        """The first item of all rows, the second of those that have one, and so on."""
        ends, steps = ats.copy(), []
        outer = {one.field.length for one in part.parts if isinstance(one, Tail)} & self.fields.keys()
        rows = np.flatnonzero((counts > 0) & (ats + part.least <= self.lengths))
        for number in range(1, scalar.EVERYTHING):
            if not len(rows):
                break
            table = _Table(self.definition, self.store, self.flavour, self.rows[rows])
            table.fields = {name: _taken(self.fields[name], rows) for name in outer}
            table.at = ends[rows]
            table.read(part.parts)
            ends[rows] = table.at
            steps.append((rows, table.fields))
            rows = rows[(counts[rows] > number) & (ends[rows] + part.least <= self.lengths[rows])]
        self.groups.append(_joined(self.definition, part.group, steps))
        self.at = ends

    def _read_one_by_one(self, part: Repeated, ats: Rows, counts: Rows) -> None:
        """What the decoder of single messages reads: PGN 126208."""
        item = scalar.item_type(self.definition, part.group)
        data, places = self.store.whole(self.rows), ats.tolist()
        if part.packed:
            (run,) = part.parts
            assert isinstance(run, Run)
            table = scalar.table(run.places[0], scalar.Flavour(False, False))
            made = [scalar.packed(item, table, *one) for one in zip(data, places, counts.tolist(), strict=True)]
        else:
            nothing: list[Any] = [None] * len(self)
            owner = listed(self.fields["manufacturerCode"]) if "manufacturerCode" in self.fields else nothing
            context = zip(data, places, counts.tolist(), listed(self.fields["pgn"]), owner, strict=True)
            made = [scalar.parameters(item, self.flavour, *one) for one in context]
        rows = np.repeat(np.arange(len(self)), [len(items or ()) for items, _ in made])
        values = [msgspec.structs.astuple(one) for items, _ in made for one in items or ()]
        fields = self.definition.fields[part.group.first : part.group.end]
        found = {
            field.id: _whole_numbers(field, [value[number] for value in values])
            for number, field in enumerate(field for field in fields if not field.silent)
        }
        self.groups.append(Items(part.group, rows, found))
        self.at = np.array([end for _, end in made], np.intp)


Behind = Callable[[Payloads, Rows, Rows], Rows]
"""(bytes of all payloads, where items begin in them, where their payloads end) -> where the items end."""

_RUN, _LAU, _LZ, _VALUE = range(4)  # as in native/items.c
_NO_VALUES = np.zeros(1 << 16, np.intp)


class Walk(msgspec.Struct, frozen=True, eq=False):
    """How to find the end of an item without reading it.

    For the kernel, `steps` is int64[n, 2], what stands in an item and its size, None if that is not enough to say; and
    `values` the sizes of values, by the two bytes that announce them.
    """

    behind: Behind
    steps: npt.NDArray[np.int64] | None
    values: Rows | None


@cache
def _walk(definition: Definition, part: Repeated) -> Walk | None:
    """How to find the end of an item without reading it; None if that takes more than the item."""
    steps: list[Behind] = []
    coded: list[tuple[int, int]] = []
    sizes: list[_ValueSizes] = []
    run = None
    for one in part.parts:
        match one:
            case Run(conditional=False):
                run = one
                steps.append(partial(_behind_run, one.size))
                coded.append((_RUN, one.size))
            case Tail(field=Field(kind="STRING_LAU" | "STRING_LZ" as kind, length="")):
                steps.append(_BEHIND[kind])
                coded.append((_LAU if kind == "STRING_LAU" else _LZ, 0))
            case Tail(field=Field(kind="DYNAMIC_FIELD_VALUE", length="") as field) if run is not None:
                key, length = scalar.announced_by(definition, field)
                inside = {place.field.id for place in run.values}
                if any(one.id not in inside for one in (key, length) if one):
                    return None
                sizes.append(_ValueSizes(run, key, length))
                steps.append(partial(_behind_value, sizes[-1]))
                coded.append((_VALUE, run.size))
            case _:
                return None
    by_two = [one.of_two for one in sizes if one.run.size == 2]
    plain = len(by_two) == len(sizes) <= 1
    return Walk(
        lambda flat, at, end: reduce(lambda behind, step: step(flat, behind, end), steps, at),
        np.array(coded, np.int64) if plain else None,
        by_two[0] if by_two else None,
    )


class _ValueSizes:
    """How many bytes a value has, by what announces it: a run with its key and, if it has one, its length."""

    def __init__(self, run: Run, key: Field | None, length: Field | None) -> None:
        self.run = run
        self._places = [place for place in run.values if place.field in (key, length)]
        self._key, self._length = key, length
        self._told = np.full((1 << (key.bits or 0) if key else 0) + 1, scalar.EVERYTHING, np.intp)
        keyed = scalar.Keyed(key, None, scalar.Flavour(False, False))
        for code in keys(key.lookup) if key else ():
            self._told[code] = keyed.size(code, None) or 0

    @cached_property
    def of_two(self) -> Rows:
        """Of all there can be of two bytes."""
        return self._sizes(np.arange(1 << 16, dtype="<u2").view(np.uint8).reshape(-1, 2))

    def __call__(self, flat: Payloads, places: Rows) -> Rows:
        """intp[m], at least that of a payload where all that is left is the value."""
        size = self.run.size
        if size == 2:
            return self.of_two.take(_everywhere(flat, "<u2")[places])
        return self._sizes(_everywhere(flat, f"V{size}")[places].view(np.uint8).reshape(-1, size))

    def _sizes(self, heads: Payloads) -> Rows:
        found = {place.field.id: _codes(reader(place)(heads, None)) for place in self._places}
        # Without a key it is the last one that is taken.
        told = self._told.take(found[self._key.id] if self._key else np.full(len(heads), -1))
        if self._length is None:
            return told
        length, overhead = found[self._length.id], self._length.overhead
        return np.where(length >= overhead, length - overhead, np.where(length < 0, told, scalar.EVERYTHING))


def _behind_run(size: int, flat: Payloads, at: Rows, end: Rows) -> Rows:
    return at + size


def _behind_lau(flat: Payloads, at: Rows, end: Rows) -> Rows:
    behind = at + np.maximum(flat.take(np.minimum(at, end)), 2)
    return np.where(end < at + 2, end, behind)


def _behind_lz(flat: Payloads, at: Rows, end: Rows) -> Rows:
    behind = at + flat.take(np.minimum(at, end)) + 2
    return np.where(end <= at, at, behind)


_BEHIND: dict[str, Behind] = {"STRING_LAU": _behind_lau, "STRING_LZ": _behind_lz}


def _behind_value(sizes: "_ValueSizes", flat: Payloads, at: Rows, end: Rows) -> Rows:
    """Behind the value that the run before it announces; where that is cut short, there is none."""
    size = sizes(flat, at - sizes.run.size)
    size += at
    return np.maximum(np.minimum(size, end, out=size), at, out=size)


def _joined(definition: Definition, group: Group, steps: Sequence[tuple[Rows, dict[str, AnyColumn]]]) -> Items:
    """Items that were read step by step, in the order of their rows."""
    fields = [field for field in definition.fields[group.first : group.end] if not field.silent]
    rows = np.concatenate([np.empty(0, np.intp), *(found for found, _ in steps)])
    order = np.argsort(rows, kind="stable")
    made: dict[str, AnyColumn] = {}
    for field in fields:
        parts = [columns_of[field.id] for _, columns_of in steps] or [_nothing(field)]
        if any(isinstance(part, Mixed) for part in parts):
            made[field.id] = _mixed(field, order, [part for part in parts if isinstance(part, Mixed)])
            continue
        values = np.concatenate([part.values for part in parts])[order]
        masks = np.concatenate([_valid(part) for part in parts])[order]
        sizes = np.concatenate([_sizes(part) for part in parts])[order]
        whole = values.ndim == 1 or (sizes == values.shape[1]).all()
        made[field.id] = Column(field, values, None if masks.all() else masks, None if whole else sizes)
    return Items(group, rows[order], made)


def _mixed(field: Field, order: Rows, steps: list[Mixed]) -> Mixed:
    """The values of all steps: those of one kind together."""
    places = np.empty(len(order), np.intp)
    places[order] = np.arange(len(order))
    kinds: dict[tuple[Field, str], list[tuple[Rows, Column]]] = {}
    before = 0
    for step in steps:
        for rows, column in step.parts:
            kinds.setdefault((column.field, column.values.dtype.str), []).append((places[before + rows], column))
        before += step.rows
    return Mixed(field, len(order), tuple(_one_kind(found) for found in kinds.values()))


def _one_kind(found: list[tuple[Rows, Column]]) -> tuple[Rows, Column]:
    if len(found) == 1:
        return found[0]
    rows = np.concatenate([rows for rows, _ in found])
    values = np.concatenate([column.values for _, column in found])
    masks = np.concatenate([_valid(column) for _, column in found])
    return rows, Column(found[0][1].field, values, None if masks.all() else masks)


def _sizes(column: AnyColumn) -> Rows:
    if column.sizes is not None:
        return column.sizes
    return np.full(len(column.values), column.values.shape[1] if column.values.ndim == 2 else 0)


def _nothing(field: Field) -> Column:
    """A column without rows, of the type that the values of a field are kept in."""
    if field.bits is None or field.length:
        return Column(field, np.empty(0, object))
    return reader(Place(field, kind(field), 0))(np.zeros((0, -(-field.bits // 8)), np.uint8), None)


def _whole_numbers(field: Field, values: list[Any]) -> Column:
    """What was read one by one, in the type that all values of the field have."""
    kept = _nothing(field).values.dtype
    if kept.kind == "O":
        return Column(field, objects(values))
    missing = np.array([value is None for value in values], np.bool_)
    return Column(field, np.array([value or 0 for value in values], kept), ~missing if missing.any() else None)


# Rows ----------------------------------------------------------------------------------------------


def _kinds(key: AnyColumn | None, length: AnyColumn | None, rows: int) -> Array:
    """A number for each key and length, of 16 bits if they are enough: those are sorted fastest."""
    kinds, bits = np.zeros(rows, np.uint16), 0
    for column in (key, length):
        if column is None:
            continue
        bits += column.field.bits or 0
        if column.valid is not None or bits > 16:
            codes = _codes(key) if key else np.full(rows, -1)
            together = codes << 32 | (_codes(length) if length else codes) + 1
            dense: Array = np.unique(together, return_inverse=True)[1]
            return dense
        kinds <<= np.uint16(column.field.bits or 0)
        kinds |= column.values.astype(np.uint16)
    return kinds


def _code(column: AnyColumn | None, row: int) -> int | None:
    """The whole number of a row."""
    if column is None or (column.valid is not None and not column.valid[row]):
        return None
    return int(column.values[row])


def _valid(column: AnyColumn) -> Mask:
    return np.ones(len(column.values), np.bool_) if column.valid is None else column.valid


def _codes(column: AnyColumn) -> npt.NDArray[np.int64]:
    """Whole numbers, -1 where there is none."""
    codes = column.values.astype(np.int64)
    return codes if column.valid is None else np.where(column.valid, codes, -1)


def _taken(column: AnyColumn, rows: Rows) -> Column:
    return Column(column.field, column.values[rows], None if column.valid is None else column.valid[rows])


def listed(column: AnyColumn) -> list[Any]:
    """The values as Python's own, None where there is none."""
    if column.values.ndim == 2:
        return _listed_bytes(column)
    values: list[Any] = column.values.tolist()
    if column.values.dtype.kind == "f":
        return [None if value != value else value for value in values]
    if column.valid is None:
        return values
    return [value if valid else None for value, valid in zip(values, column.valid.tolist(), strict=True)]


def _listed_bytes(column: AnyColumn) -> list[bytes | None]:
    found = pieces(np.ascontiguousarray(column.values), _sizes(column))
    return [one if one and valid else None for one, valid in zip(found, _valid(column).tolist(), strict=True)]


def words(found: Mapping[str, AnyColumn], name: str) -> list[Any]:
    """The labels of a lookup's values, numbers where there is no label, None where there is no value."""
    column = found[name]
    if column.field.by:
        labels = pairs(column.field.lookup)
        both = zip(listed(found[column.field.by]), listed(column), strict=True)
        return [labels.get(by, {}).get(code, code) for by, code in both]
    return [column.field.labels.get(code, code) for code in listed(column)]
