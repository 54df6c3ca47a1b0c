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

from collections.abc import Iterable, Mapping, Sequence
from functools import cache, cached_property
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from timonel.core.fields import Ascii, Number
from timonel.nmea2000 import catalogue_codec as scalar
from timonel.nmea2000.catalogue import Definition, Field, Group, candidates, find, keys, pairs
from timonel.nmea2000.catalogue_layout import (
    Choice,
    Decimal,
    Octets,
    OddOctets,
    Place,
    Ranged,
    Real,
    Repeated,
    Run,
    Tail,
    kind,
    plan,
    single,
)

Array = npt.NDArray[Any]
Payloads = npt.NDArray[np.uint8]
Rows = npt.NDArray[np.intp]
Mask = npt.NDArray[np.bool_]
WIDTHS = (1, 2, 4, 8)
WINDOW = 256  # bytes that no item or field is longer than


class Column(msgspec.Struct, frozen=True):
    """The values of a field, one a row.

    float64 for a scaled number, NaN where there is none (`valid` is None then); an integer type for whole numbers,
    lookups and bit lookups, with `valid` False where there is none, None if all are valid; uint8[n, size] for bytes of
    fixed size, of which row i has `sizes[i]` (None: all of them); objects for text, and for fields whose size the
    message tells: str, bytes, None, numbers.
    """

    field: Field
    values: Array
    valid: Mask | None = None
    sizes: Rows | None = None


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
            values[rows] = _objects(listed(column))
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
    found: dict[str, tuple[Definition | None, list[Rows]]] = {}
    heads = _heads(pgn, payloads, lengths)
    while len(left):
        first = left[0]
        definition = find(pgn, payloads[first, : lengths[first]].tobytes())
        same = (heads[left] == heads[first]).all(1)
        found.setdefault(definition.id if definition else "", (definition, []))[1].append(left[same])
        left = left[~same]
    return [(definition, np.sort(np.concatenate(rows)) if rows[1:] else rows[0]) for definition, rows in found.values()]


def _heads(pgn: int, payloads: Payloads, lengths: Rows) -> npt.NDArray[np.uint64]:
    """uint64[n, k]: all that tells the variants of a PGN apart, and how much of it is there."""
    mask, longest = _distinction(pgn)
    if not longest:
        return np.zeros((len(payloads), 1), np.uint64)
    width = min(longest, payloads.shape[1])
    padded = np.zeros((len(payloads), -(-longest // 8) * 8), np.uint8)
    padded[:, :width] = payloads[:, :width] & mask[:width]
    words = padded.view(np.uint64)
    short = np.minimum(lengths, longest)
    return words if (short == longest).all() else np.column_stack((words, short.astype(np.uint64)))


@cache
def _distinction(pgn: int) -> tuple[Payloads, int]:
    union = longest = 0
    for definition in candidates(pgn):
        union |= definition.pattern[0]
        longest = max(longest, definition.pattern[2])
    return np.frombuffer(union.to_bytes(longest, "little"), np.uint8), longest


# Columns -------------------------------------------------------------------------------------------


def columns(definition: Definition, payloads: Payloads, lengths: Rows, labels: bool = True) -> Columns:
    """Decode uint8[n, width] payloads, of which row i has `lengths[i]` bytes.

    What a row is too short for is not available. `labels` is for lookups whose field is told by the message itself,
    PGN 126208's parameters and values with keys: words, or numbers.
    """
    table = _Table(definition, _Store(payloads, lengths), scalar.Flavour(labels, False))
    table.read(plan(definition).parts)
    order = [field.id for field in definition.fields if field.id in table.fields]
    return Columns(definition, {name: table.fields[name] for name in order}, tuple(table.groups))


class _Store:
    """The payloads of all rows in one piece, to take windows from."""

    def __init__(self, payloads: Payloads, lengths: Rows) -> None:
        self.payloads = payloads
        self.lengths = lengths

    @cached_property
    def _flat(self) -> Payloads:
        return np.concatenate((self.payloads.ravel(), np.zeros(WINDOW, np.uint8)))

    def windows(self, rows: Rows, ats: Rows, size: int) -> Payloads:
        """uint8[m, size] of some rows, each from its own byte on; what stands behind a row's end is not its own."""
        if not size or not len(rows):
            return np.zeros((len(rows), size), np.uint8)
        flat, width = self._flat, self.payloads.shape[1]
        all_windows: Array = np.ndarray(flat.size - size + 1, f"V{size}", flat.data, strides=(1,))
        found: Payloads = all_windows[rows * width + np.minimum(ats, width)].view(np.uint8).reshape(-1, size)
        return found

    def whole(self, rows: Rows) -> list[bytes]:
        """The payloads of some rows as bytes."""
        return _bytes(self.payloads[rows], self.lengths[rows])


class _Table:
    """Rows that are read from left to right; `at` is where each of them is: one place for all, or one for each."""

    def __init__(
        self, definition: Definition, store: _Store, flavour: scalar.Flavour, rows: Rows | None = None
    ) -> None:
        self.definition = definition
        self.store = store
        self.rows = np.arange(len(store.payloads)) if rows is None else rows
        self.lengths = store.lengths if rows is None else store.lengths[rows]
        self.flavour = flavour
        self.at: int | Rows = 0
        self.fields: dict[str, AnyColumn] = {}
        self.groups: list[Items] = []

    def __len__(self) -> int:
        return len(self.rows)

    def read(self, parts: Iterable[Any]) -> None:
        for part in parts:
            match part:
                case Run():
                    self._run(part)
                case Tail():
                    self._tail(part.field)
                case Repeated():
                    self._repeated(part)

    def _run(self, run: Run) -> None:
        if run.conditional:
            there = np.fromiter(map(scalar.proprietary, listed(self.fields["pgn"])), np.bool_, len(self))
            self.fields |= _run_columns(run, *self._block(run.size, there))
            self.at = self.at + run.size * there
            return
        self.fields |= _run_columns(run, *self._block(run.size))
        self.at = self.at + run.size

    def _block(self, size: int, there: Mask | None = None) -> tuple[Payloads, Rows | None]:
        """uint8[n, size or less] from where the rows are, and how many bytes each has if not all have them all."""
        have = self.lengths - self.at
        if there is not None:
            have = have * there
        if isinstance(self.at, int):
            block = self.store.payloads[:, self.at : self.at + size]
        else:
            block = self.store.windows(self.rows, self.at, size)
        return block, None if len(have) and have.min() >= size else np.maximum(have, 0)

    def _tail(self, field: Field) -> None:
        ats = np.broadcast_to(np.asarray(self.at, np.intp), len(self))
        key, length = scalar.announced_by(self.definition, field)
        if field.kind == "DYNAMIC_FIELD_VALUE" and key and not field.length:
            self._keyed(field, key, length, ats)
            return
        read = scalar.tail_reader(self.definition, field, self.flavour)
        nothing: list[Any] = [None] * len(self)
        context: list[list[Any]] = []
        if field.length:
            context = [listed(self.fields[field.length])]
        elif field.kind == "DYNAMIC_FIELD_VALUE":
            context = [nothing, listed(self.fields[length.id]) if length else nothing]
        data = self.store.whole(self.rows)
        made = [read(*arguments) for arguments in zip(data, ats.tolist(), *context, strict=True)]
        self.fields[field.id] = Column(field, _objects([value for value, _ in made]))
        self.at = np.fromiter((end for _, end in made), np.intp, len(made))

    def _keyed(self, field: Field, key: Field, length: Field | None, ats: Rows) -> None:
        """Values whose kind their key tells: those of one kind at a time."""
        parts = []
        wanted = np.empty(len(self), np.intp)
        readers = scalar.Readers(keys(key.lookup), self.flavour)
        codes = _codes(self.fields[key.id])
        lengths = _codes(self.fields[length.id]) if length else np.full(len(self), -1)
        kinds, of_row = np.unique(codes << 32 | lengths + 1, return_inverse=True)
        for number, both in enumerate(kinds.tolist()):
            rows = np.flatnonzero(of_row == number)
            code, told = both >> 32, (both & 0xFFFFFFFF) - 1
            column, wanted[rows] = self._of_kind(rows, ats[rows], code, told if told >= 0 else None, readers, length)
            parts.append((rows, column))
        self.fields[field.id] = Mixed(field, len(self), tuple(parts))
        self.at = ats + wanted

    def _of_kind(
        self, rows: Rows, ats: Rows, code: int, length: int | None, readers: Any, field: Field | None
    ) -> tuple[Column, Rows]:
        """The values of rows with one key and one length, and how many bytes they take."""
        overhead = field.overhead if field else 0
        told = readers.fields.get(code)
        size = scalar.value_size(told, overhead, length)
        if told is not None and size and (self.lengths[rows] - ats >= size).all():
            told = scalar.sized(told, size)
            if told is not None and isinstance(kind(told), Number):
                (place,) = single(told).places  # type: ignore[union-attr]
                column = _column(place, self.store.windows(self.rows[rows], ats, size), None)
                return column, np.full(len(rows), size, np.intp)
        data = self.store.whole(self.rows[rows])
        both = zip(data, ats.tolist(), strict=True)
        made = [scalar.keyed(readers, overhead, one, at, code, length) for one, at in both]
        kept = Column(told or Field(), _objects([value for value, _ in made]))
        return kept, np.array([end for _, end in made], np.intp) - ats

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
        firsts = np.cumsum(counts) - counts
        places = ats[rows] + size * (np.arange(len(rows)) - firsts[rows])
        have = self.lengths[rows] - places
        (run,) = part.parts
        assert isinstance(run, Run)
        whole = None if len(have) and have.min() >= size else np.maximum(have, 0)
        block = self.store.windows(self.rows[rows], places, size)
        self.groups.append(Items(part.group, rows, _run_columns(run, block, whole)))
        self.at = ats + size * counts

    def _items(self, part: Repeated, ats: Rows, counts: Rows) -> None:
        """Items of many sizes: the first of all rows, the second of those that have one, and so on."""
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
    return _column(Place(field, kind(field), 0), np.zeros((0, -(-field.bits // 8)), np.uint8), None)


# Fields of fixed size ------------------------------------------------------------------------------


def _run_columns(run: Run, block: Payloads, have: Rows | None) -> dict[str, Column]:
    return {place.field.id: _column(place, block, have) for place in run.values}


def _column(place: Place, block: Payloads, have: Rows | None) -> Column:
    """The values of one field of a run; `have` says how many bytes each row has, None that all have all."""
    field = place.field
    if field.match is not None:
        return Column(field, np.broadcast_to(np.array(field.match, _unsigned(place.bits)), len(block)))
    if isinstance(place.kind, Octets):
        part = block[:, place.first : place.first + place.bits // 8]
        return Column(field, part, None, None if have is None else np.clip(have - place.first, 0, part.shape[1]))
    if isinstance(place.kind, Ascii):
        return Column(field, _texts(place, block, have))
    short = None if have is None else 8 * have < place.need
    if short is not None and not short.any():
        short = None
    raw = _raw(place, block)
    match place.kind:
        case Ranged() as number:
            return _numbers(field, number, raw, short)
        case Choice() as choice:
            return _whole(field, raw, _either(short, raw > choice.highest if choice.highest < choice.ones else None))
        case Real(resolution=resolution):
            return Column(field, _finite(raw, short) * float(resolution))
        case Decimal():
            return _decimals(field, place.bits // 8, raw, short)
        case OddOctets():
            parts = raw.view(np.uint8).reshape(len(raw), -1)[:, : -(-place.bits // 8)]
            return _whole(field, parts, short)
    return _whole(field, raw, short)


def _raw(place: Place, block: Payloads) -> Array:
    """The raw values, cut from the smallest word that covers the field, in the smallest type that holds them."""
    bits, signed = place.bits, isinstance(place.kind, Number) and place.kind.signed
    last = -(-(place.offset + bits) // 8)
    if block.shape[1] < last:
        block = np.pad(block, ((0, 0), (0, last - block.shape[1])))
    size = next(width for width in WIDTHS if width >= last - place.first)
    first = min(place.first, block.shape[1] - size)
    if first < 0:
        block, first = np.pad(block, ((0, 0), (0, size - block.shape[1]))), 0
    shift, spare = place.offset - 8 * first, 8 * size - bits
    if block.strides[1] != 1:
        block = np.ascontiguousarray(block)
    word = block[:, first : first + size].view(f"<u{size}")[:, 0]
    if not spare:
        return np.ascontiguousarray(word.view(f"<i{size}") if signed else word)
    if signed:
        raw: Array = (word << spare - shift).view(f"<i{size}") >> spare
        return raw.astype(f"<i{_bytes_for(bits)}", copy=False)
    raw = word >> shift & (1 << bits) - 1
    return raw.astype(_unsigned(bits), copy=False)


def _bytes_for(bits: int) -> int:
    return next(width for width in WIDTHS if 8 * width >= bits)


def _unsigned(bits: int) -> str:
    return f"<u{_bytes_for(bits)}"


def _numbers(field: Field, number: Ranged, raw: Array, short: Mask | None) -> Column:
    invalid = _either(short, _outside(number, raw))
    if number.integral:
        if number.resolution != 1 or number.offset:
            raw = raw.astype(np.int64) * int(number.resolution) + int(number.offset)
        return _whole(field, raw, invalid)
    values = np.empty(len(raw))
    if number.shift is not None:
        raw = raw.astype(np.int64) + number.shift
    if number.inverse is not None:
        np.divide(raw, float(number.inverse), out=values, dtype=np.float64)
    else:
        np.multiply(raw, float(number.resolution), out=values, dtype=np.float64)
    if number.offset and number.shift is None:
        values += number.offset
    if invalid is not None:
        values[invalid] = np.nan
    return Column(field, values)


def _outside(number: Number, raw: Array) -> Mask | None:
    """The rows with a raw value that is none; None if there are none."""
    lowest, highest = number.range
    limits = np.iinfo(raw.dtype)
    above = raw > highest if highest < limits.max else None
    below = raw < lowest if lowest > limits.min else None
    return _either(
        above if above is not None and above.any() else None, below if below is not None and below.any() else None
    )


def _whole_numbers(field: Field, values: list[Any]) -> Column:
    """What was read one by one, in the type that all values of the field have."""
    kept = _nothing(field).values.dtype
    if kept.kind == "O":
        return Column(field, _objects(values))
    missing = np.array([value is None for value in values], np.bool_)
    return _whole(field, np.array([value or 0 for value in values], kept), missing)


def _either(one: Mask | None, other: Mask | None) -> Mask | None:
    return other if one is None else one if other is None else one | other


def _whole(field: Field, values: Array, invalid: Mask | None) -> Column:
    return Column(field, values, None if invalid is None or not invalid.any() else ~invalid)


def _finite(raw: Array, short: Mask | None) -> Array:
    with np.errstate(invalid="ignore"):  # signalling NaN
        values = raw.view("<f4").astype(np.float64)
    values[~np.isfinite(values) if short is None else ~np.isfinite(values) | short] = np.nan
    return values


def _decimals(field: Field, size: int, raw: Array, short: Mask | None) -> Column:
    values, invalid = np.zeros(len(raw), np.int64), short
    for place in range(size):
        byte = (raw >> np.uint64(8 * place) & np.uint64(255)).astype(np.int64)
        values = 100 * values + byte
        invalid = _either(invalid, byte > 99)
    return _whole(field, values, invalid)


def _texts(place: Place, block: Payloads, have: Rows | None) -> Array:
    """Text: what there is of it."""
    part = block[:, place.first : place.first + place.bits // 8]
    sizes = np.full(len(block), part.shape[1]) if have is None else np.clip(have - place.first, 0, part.shape[1])
    found = _bytes(part, sizes)
    known = {raw: scalar.text(raw) for raw in set(found)}
    return _objects([known[raw] for raw in found])


# Rows ----------------------------------------------------------------------------------------------


def _bytes(payloads: Payloads, lengths: Rows) -> list[bytes]:
    data, width = payloads.tobytes(), payloads.shape[1]
    starts = range(0, len(payloads) * width, width) if width else [0] * len(payloads)
    return [data[start : start + length] for start, length in zip(starts, lengths.tolist(), strict=True)]


def _objects(values: Sequence[Any]) -> Array:
    made = np.empty(len(values), object)
    made[:] = values
    return made


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
    found = _bytes(np.ascontiguousarray(column.values), _sizes(column))
    return [one if one and valid else None for one, valid in zip(found, _valid(column).tolist(), strict=True)]


def words(found: Mapping[str, AnyColumn], name: str) -> list[Any]:
    """The labels of a lookup's values, numbers where there is no label, None where there is no value."""
    column = found[name]
    if column.field.by:
        labels = pairs(column.field.lookup)
        both = zip(listed(found[column.field.by]), listed(column), strict=True)
        return [labels.get(by, {}).get(code, code) for by, code in both]
    return [column.field.labels.get(code, code) for code in listed(column)]
