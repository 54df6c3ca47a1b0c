"""Arrow and Parquet files of decoded recordings: a table a message. Needs the extra `columns` with pyarrow.

    <name>.parquet        time (UTC, null without a date), source, destination, priority, and one column a field
    <name>.list.parquet   the items of its repeating set; `row` is the place, from 0, of the message they belong to
    unknown.parquet       messages that canboat does not know, as bytes

Values are SI and null where not available; lookups are words, dictionary-encoded, set bits lists of words. Unit,
resolution, description and source of a column are in its metadata. A rover's frames have no addresses.
"""

from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, BinaryIO

import msgspec
import numpy as np

from timonel.errors import RecordingError
from timonel.nmea2000.catalogue import Definition, Field
from timonel.nmea2000.catalogue_columns import AnyColumn, listed, words
from timonel.nmea2000.fixed_columns import Column
from timonel.recording.decoding import Pass
from timonel.recording.lots import Lots
from timonel.recording.sinks.arrays import Words, binary, numbers, pa, sparse_texts, times
from timonel.recording.sinks.notation import plain
from timonel.recording.summary import Summary
from timonel.recording.tables import Lot, Table, Tables
from timonel.vehicles.rover.protocol import Protocol

ROWS = 1 << 13
"""Rows of a table that are written at once, at least."""

HELD = 8 << 20
"""Bytes that wait to be written, of all tables."""

AHEAD = 2
"""Tables that may wait for the thread that writes them."""

UNKNOWN = "unknown"
_MIXED = {"DYNAMIC_FIELD_VALUE", "VARIABLE"}
_HEAD = {
    "time": {"description": "when the message was complete"},
    "source": {"description": "address of the sender"},
    "destination": {"description": "255: everybody"},
    "priority": {"description": "0 is the most urgent"},
}
_ROW = {"row": {"description": "the message, from 0"}}

Batch = tuple[str, Any]
Columns = dict[str, Any]
Abouts = dict[str, dict[str, str]]
"""By the name of a column, its metadata."""


class Batches:
    """Makes record batches of tables; without `labels` lookups are numbers. `day` is `JsonLines`'."""

    def __init__(self, labels: bool = True, day: int | None = 0) -> None:
        self._labels = labels
        self._day = day
        self._rows: dict[str, int] = {}
        self._words: dict[tuple[str, str], Words] = {}
        self._schemas: dict[str, Any] = {}

    def receive(self, table: Table) -> Iterator[Batch]:
        """The name of a table and its rows, then those of its repeating sets."""
        name = table.name or UNKNOWN
        columns = self._head(table)
        if isinstance(table.definition, Definition):
            columns |= self._fields(table.definition, table.fields, _HEAD)
        elif table.definition is not None:
            columns |= _signals(table)
        yield name, self._batch(name, table, columns, _HEAD)
        for items in table.groups:
            if isinstance(table.definition, Definition) and len(items.rows):
                child = f"{name}.{items.group.name}"
                row = {"row": numbers(items.rows + self._rows.get(name, 0))}
                columns = row | self._fields(table.definition, items.fields, _ROW)
                yield child, self._batch(child, table, columns, _ROW)
        self._rows[name] = self._rows.get(name, 0) + len(table.messages.row)

    def _head(self, table: Table) -> Columns:
        messages = table.messages
        columns = {"time": times(messages.stamp, self._day)}
        if messages.frame is None:
            columns["source"] = numbers(messages.source)
            columns["destination"] = numbers(messages.destination)
            columns["priority"] = numbers(messages.priority)
        if table.definition is None:
            number = messages.frame if messages.pgn is None else messages.pgn
            kind = "frame" if messages.pgn is None else "pgn"
            columns[kind] = numbers(np.full(len(messages.row), number, np.uint32))
            columns["data"] = binary(messages.payloads, messages.lengths)
        return columns

    def _fields(self, definition: Definition, columns: Mapping[str, AnyColumn], own: Abouts) -> Columns:
        """A column a field, beside those that the table has of its `own`."""
        found: Columns = {}
        for name, column in columns.items():
            name = _beside(own, name)
            if column.field.kind in _MIXED:
                found[name], found[f"{name}_text"] = _numbers_and_text(column)
            elif isinstance(column, Column):
                found[name] = self._column(column, columns, self._words_of(definition, column.field))
        return found

    def _words_of(self, definition: Definition, field: Field) -> Words | None:
        if not (self._labels and (field.labels or field.by)):
            return None
        key = definition.id, field.id
        if key not in self._words:
            self._words[key] = Words(field)
        return self._words[key]

    def _column(self, column: Column, columns: Mapping[str, AnyColumn], known: Words | None) -> Any:
        field, values = column.field, column.values
        if values.ndim == 2:
            return _bytes(column)
        if values.dtype == object:
            return pa.array(listed(column), pa.binary() if field.kind == "BINARY" else pa.string())
        if known is None:
            return numbers(values, column.valid)
        if field.kind == "BITLOOKUP":
            return known.lists(values, column.valid)
        return known.one_by_one(words(columns, field.id)) if field.by else known.array(values, column.valid)

    def _batch(self, name: str, table: Table, columns: Columns, own: Abouts) -> Any:
        """With the schema that was made of the first rows."""
        if name not in self._schemas:
            about = _columns_about(table, own)
            fields = [pa.field(one, array.type, metadata=about.get(one)) for one, array in columns.items()]
            self._schemas[name] = pa.schema(fields, _about(table))
        return pa.RecordBatch.from_arrays(list(columns.values()), schema=self._schemas[name])


def _bytes(column: Column) -> Any:
    """Bytes of fixed size; none at all are null."""
    values, sizes, valid = column.values, column.sizes, column.valid
    if sizes is not None:
        valid = sizes > 0 if valid is None else valid & (sizes > 0)
    return binary(values, sizes, valid)


def _signals(table: Table) -> Columns:
    """A rover's signals; those that are codes are words."""
    declared: Any = table.definition
    codes = {name: signal.codes for name, signal in declared.signals if signal.codes}
    found: Columns = {}
    for name, values in table.signals.items():
        array = numbers(values)
        if name in codes:
            array = pa.array([None if value != value else codes[name](int(value)).name for value in values.tolist()])
            array = array.cast(pa.string()).dictionary_encode()
        found[name] = array
    return found


def _numbers_and_text(column: AnyColumn) -> tuple[Any, Any]:
    """Values whose kind the message tells, in two columns: those that are numbers, and all others as text."""
    rows = len(column.values) if isinstance(column, Column) else column.rows
    values = np.full(rows, np.nan)
    texts: list[tuple[int, str]] = []
    parts = ((np.arange(rows), column),) if isinstance(column, Column) else column.parts
    for which, part in parts:
        if part.values.dtype != object:
            values[which] = part.values if part.valid is None else np.where(part.valid, part.values, np.nan)
            continue
        for row, value in zip(which.tolist(), listed(part), strict=True):
            if type(value) is float or type(value) is int:
                values[row] = value
            elif value is not None:
                texts.append((row, "; ".join(map(str, value)) if isinstance(value, list) else str(plain(value))))
    return numbers(values), sparse_texts(texts, rows)


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


def _beside(own: Abouts, name: str) -> str:
    """What the column of a field is called beside those that a table has of its `own`."""
    return f"{name}_field" if name in own else name


def _columns_about(table: Table, own: Abouts) -> Abouts:
    """What is to be known of each column of a table, or of its repeating set."""
    definition = table.definition
    if definition is None:
        return own
    if isinstance(definition, Definition):
        fields = {_beside(own, field.id): _field_about(definition, field) for field in definition.fields}
        return own | {f"{name}_text": about for name, about in fields.items()} | fields
    units = {name: signal.unit for name, signal in definition.signals}
    units |= {name: derived.unit for name, derived in definition.DERIVED.items()}
    return own | {name: {"unit": unit, "source": f"rover frame {definition.FRAME}"} for name, unit in units.items()}


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
    table = pa.Table.from_batches(batches)
    return table.unify_dictionaries().combine_chunks() if len(batches) > 1 else table


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
    tables, lots = Tables(protocol, choice.labels), Lots()
    batches = Batches(choice.labels, recording.day(choice.date))

    def put(some: Iterable[Lot]) -> None:
        for lot in some:
            for name, batch in batches.receive(tables.table(lot)):
                files.write(name, batch)

    for chunk in recording:
        found = tables.lots(chunk.groups, chunk.selected)
        put(lots.receive(lot for lot in found if choice.names is None or lot.name in choice.names))
        tell(recording.log.bytes_read)
    put(lots.finish())
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
    # From one time to the next it is not far: a third of a file less, and quicker than compressing them as they are.
    encoding = {field.name: "DELTA_BINARY_PACKED" for field in schema if pa.types.is_timestamp(field.type)}
    options: dict[str, Any] = {"use_dictionary": words, "column_encoding": encoding or None}
    return parquet.ParquetWriter(where, schema, compression="zstd", compression_level=1, **options)


def _ipc(where: str | BinaryIO, schema: Any) -> Any:
    options = pa.ipc.IpcWriteOptions(compression="zstd", emit_dictionary_deltas=True)
    new = pa.ipc.new_file if isinstance(where, str) else pa.ipc.new_stream
    return new(where, schema, options=options)


def _csv(where: str | BinaryIO, schema: Any) -> Any:
    from timonel.recording.sinks.csv import CsvFile

    return CsvFile(where, schema)


WRITERS: dict[str, Callable[[str | BinaryIO, Any], Any]] = {"parquet": _parquet, "arrow": _ipc, "csv": _csv}
