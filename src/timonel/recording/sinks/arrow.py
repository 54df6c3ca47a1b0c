"""Arrow and Parquet files of decoded recordings: a table a message. Needs the extra `columns` with pyarrow.

    <name>.parquet        time (UTC, null without a date), source, destination, priority, and one column a field
    <name>.list.parquet   the items of its repeating set; `row` is the place, from 0, of the message they belong to
    unknown.parquet       messages that canboat does not know, as bytes

Values are SI and null where not available; lookups are words, dictionary-encoded, set bits lists of words. Unit,
resolution, description and source of a column are in its metadata. A rover's frames have no addresses.
"""

from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, BinaryIO

import msgspec
import numpy as np
import numpy.typing as npt

from timonel.errors import RecordingError
from timonel.nmea2000.catalogue import Definition, Field
from timonel.nmea2000.catalogue_columns import AnyColumn, Items, listed, words
from timonel.nmea2000.fixed_columns import Column
from timonel.recording.decoding import Pass
from timonel.recording.frames import NO_STAMP
from timonel.recording.sinks.notation import plain, set_bits
from timonel.recording.summary import Summary
from timonel.recording.tables import Table, Tables
from timonel.vehicles.rover.protocol import Protocol

try:
    import pyarrow as pa
except ImportError as missing:
    raise RecordingError("Arrow and Parquet need the extra `columns` (pip install 'timonel[columns]')") from missing

ROWS = 1 << 16
"""Rows of a table that are written at once."""

HELD = 48 << 20
"""Bytes that wait to be written, of all tables."""

AHEAD = 4
"""Tables that may wait for the thread that writes them."""

UNKNOWN = "unknown"
_MIXED = {"DYNAMIC_FIELD_VALUE", "VARIABLE"}
TIME = pa.timestamp("us", "UTC")

Batch = tuple[str, Any]


class Batches:
    """Makes record batches of tables; without `labels` lookups are numbers. `day` is `JsonLines`'."""

    def __init__(self, labels: bool = True, day: int | None = 0) -> None:
        self._labels = labels
        self._day = day
        self._rows: dict[str, int] = {}
        self._words: dict[tuple[str, str], _Words] = {}

    def receive(self, table: Table) -> Iterator[Batch]:
        """The name of a table and its rows, then those of its repeating sets."""
        name = table.name or UNKNOWN
        columns = self._head(table)
        if isinstance(table.definition, Definition):
            columns |= self._fields(table.definition, table.fields)
        elif table.definition is not None:
            columns |= _signals(table)
        yield name, _batch(columns, _about(table))
        for items in table.groups:
            if isinstance(table.definition, Definition) and len(items.rows):
                child = f"{name}.{items.group.name}"
                yield child, _batch(self._items(table.definition, items, self._rows.get(name, 0)), _about(table))
        self._rows[name] = self._rows.get(name, 0) + len(table.messages.row)

    def _head(self, table: Table) -> "Columns":
        messages = table.messages
        columns = {"time": (_times(messages.stamp, self._day), {"description": "when the message was complete"})}
        if messages.frame is None:
            columns["source"] = (pa.array(messages.source), {"description": "address of the sender"})
            columns["destination"] = (pa.array(messages.destination), {"description": "255: everybody"})
            columns["priority"] = (pa.array(messages.priority), {"description": "0 is the most urgent"})
        if table.definition is None:
            number = messages.frame if messages.pgn is None else messages.pgn
            kind = "frame" if messages.pgn is None else "pgn"
            columns[kind] = (pa.array(np.full(len(messages.row), number, np.uint32)), {})
            columns["data"] = (_bytes(messages.payloads, messages.lengths), {})
        return columns

    def _items(self, definition: Definition, items: Items, before: int) -> "Columns":
        row = pa.array(items.rows + before)
        return {"row": (row, {"description": "the message, from 0"})} | self._fields(definition, items.fields)

    def _fields(self, definition: Definition, columns: Mapping[str, AnyColumn]) -> "Columns":
        found: Columns = {}
        for name, column in columns.items():
            about = _field_about(definition, column.field)
            if column.field.kind in _MIXED:
                found[name], found[f"{name}_text"] = _numbers_and_text(column, about)
            elif isinstance(column, Column):
                found[name] = self._array(column, columns, self._words_of(definition, column.field)), about
        return found

    def _words_of(self, definition: Definition, field: Field) -> "_Words | None":
        if not (self._labels and (field.labels or field.by)):
            return None
        return self._words.setdefault((definition.id, field.id), _Words(field))

    def _array(self, column: Column, columns: Mapping[str, AnyColumn], known: "_Words | None") -> Any:
        field, values = column.field, column.values
        if values.ndim == 2 or field.kind == "BINARY":
            return pa.array(listed(column), pa.binary())
        if values.dtype == object:
            return pa.array(listed(column), pa.string())
        if known is not None:
            if field.kind == "BITLOOKUP":
                return known.lists(values, column.valid)
            return known.of(words(columns, field.id)) if field.by else known.array(values, column.valid)
        if values.dtype.kind == "f":
            return pa.array(values, from_pandas=True)
        return pa.array(values, mask=None if column.valid is None else ~column.valid)


Columns = dict[str, tuple[Any, dict[str, str]]]


class _Words:
    """The words of a lookup in the order in which they are met: dictionaries only grow."""

    def __init__(self, field: Field) -> None:
        self._field = field
        self._place: dict[Any, int] = {}
        self._found: list[str] = []
        self._slot = np.zeros(0, np.int32)

    def array(self, codes: npt.NDArray[Any], valid: npt.NDArray[np.bool_] | None) -> Any:
        """A dictionary array; a code without a word is its number."""
        distinct, which = _distinct(codes)
        labels = self._field.labels
        places = np.array([self._of(str(labels.get(code, code))) for code in distinct.tolist()], np.int32)
        return self._dictionary(places[which], None if valid is None else ~valid)

    def of(self, found: list[Any]) -> Any:
        """A dictionary array of words or numbers, one by one."""
        places = [-1 if word is None else self._of(str(word)) for word in found]
        indices = np.array(places, np.int32)
        return self._dictionary(indices, indices < 0)

    def lists(self, codes: npt.NDArray[Any], valid: npt.NDArray[np.bool_] | None) -> Any:
        """The words of the bits that are set."""
        distinct, which = _distinct(codes)
        made = [[str(word) for word in set_bits(self._field, code)] for code in distinct.tolist()]
        indices = pa.array(which.astype(np.int32), mask=None if valid is None else ~valid)
        return pa.array(made, pa.list_(pa.string())).take(indices)

    def _of(self, word: str) -> int:
        place = self._place.setdefault(word, len(self._found))
        if place == len(self._found):
            self._found.append(word)
        return place

    def _dictionary(self, indices: npt.NDArray[np.int32], missing: npt.NDArray[np.bool_] | None) -> Any:
        return pa.DictionaryArray.from_arrays(pa.array(indices, mask=missing), pa.array(self._found, pa.string()))


def _distinct(codes: npt.NDArray[Any]) -> tuple[npt.NDArray[Any], npt.NDArray[np.intp]]:
    """The codes that occur, and which of them each row has."""
    if codes.dtype.itemsize > 2:
        return np.unique(codes, return_inverse=True)
    places = codes.view(f"u{codes.dtype.itemsize}")
    there = np.zeros(1 << 8 * codes.dtype.itemsize, np.bool_)
    there[places] = True
    rank = np.cumsum(there) - 1
    return np.flatnonzero(there).astype(places.dtype).view(codes.dtype), rank.take(places)


def _times(stamp: npt.NDArray[np.int64], day: int | None) -> Any:
    if day is None:
        return pa.nulls(len(stamp), TIME)
    missing = stamp == NO_STAMP
    microseconds = (stamp + (day + 500)) // 1000
    return pa.array(microseconds, mask=missing if missing.any() else None).cast(TIME)


def _signals(table: Table) -> Columns:
    """A rover's signals; those that are codes are words."""
    declared: Any = table.definition
    units = {name: signal.unit for name, signal in declared.signals} | {
        name: derived.unit for name, derived in declared.DERIVED.items()
    }
    codes = {name: signal.codes for name, signal in declared.signals if signal.codes}
    found: Columns = {}
    for name, values in table.signals.items():
        array = pa.array(values, from_pandas=True)
        if name in codes:
            array = pa.array([None if value != value else codes[name](int(value)).name for value in values.tolist()])
            array = array.cast(pa.string()).dictionary_encode()
        found[name] = (array, {"unit": units.get(name, ""), "source": f"rover frame {declared.FRAME}"})
    return found


def _numbers_and_text(column: AnyColumn, about: dict[str, str]) -> tuple[Any, Any]:
    """Values whose kind the message tells, in two columns: those that are numbers, and all others as text."""
    rows = len(column.values) if isinstance(column, Column) else column.rows
    numbers, texts = np.full(rows, np.nan), np.full(rows, None, object)
    parts = ((np.arange(rows), column),) if isinstance(column, Column) else column.parts
    for which, part in parts:
        if part.values.dtype != object:
            missing = np.zeros(len(which), np.bool_) if part.valid is None else ~part.valid
            numbers[which] = np.where(missing, np.nan, part.values)
            continue
        for row, value in zip(which.tolist(), listed(part), strict=True):
            if type(value) is float or type(value) is int:
                numbers[row] = value
            elif value is not None:
                texts[row] = "; ".join(map(str, value)) if isinstance(value, list) else str(plain(value))
    return (pa.array(numbers, from_pandas=True), about), (pa.array(texts, pa.string()), about)


def _bytes(payloads: npt.NDArray[np.uint8], lengths: npt.NDArray[np.intp]) -> Any:
    return pa.array([row[:length].tobytes() for row, length in zip(payloads, lengths, strict=True)], pa.binary())


def _batch(columns: Columns, about: dict[str, str]) -> Any:
    fields = [pa.field(name, array.type, metadata=meta or None) for name, (array, meta) in columns.items()]
    return pa.RecordBatch.from_arrays([array for array, _ in columns.values()], schema=pa.schema(fields, about))


def _about(table: Table) -> dict[str, str]:
    definition = table.definition
    if isinstance(definition, Definition):
        return {
            "pgn": str(definition.pgn),
            "name": definition.id,
            "title": definition.title,
            "source": definition.source,
        }
    if definition is None:
        return {"name": UNKNOWN}
    return {"frame": str(definition.FRAME), "name": definition.__name__}


def _field_about(definition: Definition, field: Field) -> dict[str, str]:
    numeric = field.unit or (field.resolution != 1 and not field.labels)
    return {
        "title": field.title,
        "unit": field.unit,
        "resolution": str(field.resolution) if numeric else "",
        "description": field.description,
        "source": f"{definition.source}.{field.id}",
    }


def joined(batches: list[Any]) -> Any:
    """One table of batches of one schema."""
    return pa.Table.from_batches(batches).unify_dictionaries().combine_chunks()


class Choice(msgspec.Struct, frozen=True):
    """What is written of a recording: messages of these `names` (None: all), lookups as words or numbers, and the
    `date`, in ns, on which times begin that have none (None: they are null)."""

    names: Collection[str | None] | None = None
    labels: bool = True
    date: int | None = None


def write(
    recording: Pass, files: "Files", protocol: Protocol, choice: Choice, tell: Callable[[int], object]
) -> Summary:
    """Write a whole recording; `tell` is told how many bytes of it were read."""
    tables = Tables(protocol, choice.labels)
    batches = Batches(choice.labels, recording.day(choice.date))
    for chunk in recording:
        for table in tables.receive(chunk.groups):
            if choice.names is None or table.name in choice.names:
                for name, batch in batches.receive(table):
                    files.write(name, batch)
        tell(recording.log.bytes_read)
    files.close()
    return recording.summary


class Files:
    """A directory with a file a table, or one stream for the only one; `kind` is "parquet", "arrow" or "csv".

    Raises RecordingError for a second table on one stream, and where nothing can be written.
    """

    def __init__(self, where: Path | BinaryIO, kind: str) -> None:
        self._where = where
        self._kind = kind
        self._writers: dict[str, Any] = {}
        self._waiting: dict[str, list[Any]] = {}
        self._held: dict[str, int] = {}
        self._rows: dict[str, int] = {}
        self._thread = ThreadPoolExecutor(1)
        self._writing: deque[Future[None]] = deque()

    def write(self, name: str, batch: Any) -> None:
        """Keep a batch, and write what has become large, while the next ones are made."""
        self._waiting.setdefault(name, []).append(batch)
        self._held[name] = self._held.get(name, 0) + batch.nbytes
        self._rows[name] = self._rows.get(name, 0) + batch.num_rows
        if self._rows[name] >= ROWS:
            self._flush(name)
        while sum(self._held.values()) > HELD:
            self._flush(max(self._held, key=self._held.__getitem__))

    def close(self) -> None:
        """Write the rest."""
        with self._thread:
            for name in list(self._waiting):
                self._flush(name)
            while self._writing:
                self._writing.popleft().result()
        for writer in self._writers.values():
            writer.close()

    def _flush(self, name: str) -> None:
        del self._held[name], self._rows[name]
        if len(self._writing) == AHEAD:
            self._writing.popleft().result()
        self._writing.append(self._thread.submit(self._put, name, self._waiting.pop(name)))

    def _put(self, name: str, batches: list[Any]) -> None:
        table = joined(batches)
        try:
            if name not in self._writers:
                self._writers[name] = self._open(name, table.schema)
            self._writers[name].write_table(table)
        except OSError as error:
            raise RecordingError(f"{self._where}: {name}: {error}") from error

    def _open(self, name: str, schema: Any) -> Any:
        if isinstance(self._where, Path):
            self._where.mkdir(parents=True, exist_ok=True)
            return WRITERS[self._kind](str(self._where / f"{name}.{self._kind}"), schema)
        if self._writers:
            raise RecordingError(f"{name} is a second table beside {next(iter(self._writers))}: name a directory (-o)")
        return WRITERS[self._kind](self._where, schema)


def _parquet(where: str | BinaryIO, schema: Any) -> Any:
    from pyarrow import parquet

    words = [field.name for field in schema if pa.types.is_dictionary(field.type)]
    return parquet.ParquetWriter(where, schema, compression="zstd", compression_level=1, use_dictionary=words)


def _ipc(where: str | BinaryIO, schema: Any) -> Any:
    options = pa.ipc.IpcWriteOptions(compression="zstd", emit_dictionary_deltas=True)
    new = pa.ipc.new_file if isinstance(where, str) else pa.ipc.new_stream
    return new(where, schema, options=options)


def _csv(where: str | BinaryIO, schema: Any) -> Any:
    from timonel.recording.sinks.csv import CsvFile

    return CsvFile(where, schema)


WRITERS: dict[str, Callable[[str | BinaryIO, Any], Any]] = {"parquet": _parquet, "arrow": _ipc, "csv": _csv}
