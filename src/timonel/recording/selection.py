"""One message of a recording in columns, for programs. Needs the extra `columns`.

```python
heading = timonel.columns("log.candump", "vesselHeading")
heading.time, heading["heading"], heading.units["heading"]      # float64[n] unix s, float64[n], "rad"
heading.to_polars()
```
"""

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from timonel.core.mistakes import did_you_mean
from timonel.nmea2000.catalogue import Definition, by_id
from timonel.nmea2000.catalogue_columns import AnyColumn, listed, words
from timonel.recording.decoding import Pass
from timonel.recording.frames import NO_STAMP
from timonel.recording.sinks.notation import set_bits
from timonel.recording.tables import Table, Tables, seconds
from timonel.recording.wanted import wanted
from timonel.vehicles.rover.protocol import Protocol

Array = npt.NDArray[Any]


class MessageColumns:
    """All messages of one name: `fields` are NumPy arrays of n values by canboat's ids, `units` what they are in.

    `time` float64[n] is in unix seconds, NaN where the recording has no date; `source`, `destination` and `priority`
    are uint8[n]. Numbers are float64, NaN where there is none, or an integer type if all are there; everything else
    (words of lookups, text, bytes) is an object, None where there is none. `items["list"]` are the fields of the
    repeating set, of all messages one after the other; `items["list"]["row"]` says which message, from 0, each is of.
    """

    def __init__(self, name: str, tables: Sequence[Table], dated: bool) -> None:
        self.name = name
        self._tables = tables
        self.dated = dated

    def __len__(self) -> int:
        return sum(len(table.messages.row) for table in self._tables)

    def __getitem__(self, field: str) -> Array:
        """A field's values. Raises KeyError that says what there is."""
        if field not in self.fields:
            raise KeyError(f"{self.name} has no {field}{did_you_mean(field, self.fields)}")
        return self.fields[field]

    def __repr__(self) -> str:
        return f"<{self.name}: {len(self)} messages, {', '.join(self.fields)}>"

    @property
    def time(self) -> npt.NDArray[np.float64]:
        return self.elapsed if self.dated else np.full(len(self), np.nan)

    @cached_property
    def elapsed(self) -> npt.NDArray[np.float64]:
        """float64[n], s: the same, or without a date what times there are, NaN without any."""
        stamp = self._column("stamp", np.int64)
        return np.where(stamp == NO_STAMP, np.nan, seconds(stamp))

    @property
    def source(self) -> npt.NDArray[np.uint8]:
        return self._column("source", np.uint8)

    @property
    def destination(self) -> npt.NDArray[np.uint8]:
        return self._column("destination", np.uint8)

    @property
    def priority(self) -> npt.NDArray[np.uint8]:
        return self._column("priority", np.uint8)

    @cached_property
    def fields(self) -> dict[str, Array]:
        names = _names(self.name)
        parts = [dict(table.signals) or _values(table.fields) for table in self._tables]
        found = names or (list(parts[0]) if parts else [])
        return {name: _joined([part[name] for part in parts]) for name in found}

    @cached_property
    def units(self) -> dict[str, str]:
        """By field; "" for what has none."""
        for table in self._tables:
            if isinstance(table.definition, Definition):
                return {field.id: field.unit for field in table.definition.fields if not field.silent}
            if table.definition is not None:
                declared = table.definition
                derived = {name: signal.unit for name, signal in declared.DERIVED.items()}
                return {name: signal.unit for name, signal in declared.signals} | derived
        return {}

    @cached_property
    def items(self) -> dict[str, dict[str, Array]]:
        before, found = 0, dict[str, list[dict[str, Array]]]()
        for table in self._tables:
            for items in table.groups:
                found.setdefault(items.group.name, []).append({"row": items.rows + before, **_values(items.fields)})
            before += len(table.messages.row)
        return {
            name: {field: _joined([p[field] for p in parts]) for field in parts[0]} for name, parts in found.items()
        }

    def to_arrow(self) -> Any:
        """A `pyarrow.Table`, as `timonel decode --to arrow` writes it."""
        from timonel.recording.sinks.arrow import Batches, joined

        batches = Batches(day=0 if self.dated else None)
        return joined([batch for table in self._tables for name, batch in batches.receive(table) if name == self.name])

    def to_polars(self) -> Any:
        """A `polars.DataFrame`; polars is not one of our extras."""
        import polars

        return polars.from_arrow(self.to_arrow())

    def _column(self, name: str, kind: Any) -> Array:
        return np.concatenate([np.empty(0, kind), *(getattr(table.messages, name) for table in self._tables)])


def columns(path: str | Path, name: str, protocol: Protocol | None = None) -> MessageColumns:
    """The messages of one name (canboat's, or a rover's frame) of a recording.

    Raises RecordingError for a file that cannot be read and for a name that nothing has.
    """
    protocol = protocol or Protocol()
    recording = Pass(path, protocol, wanted([name], protocol))
    tables = Tables(protocol)
    found = [table for chunk in recording for table in tables.receive(chunk.groups) if table.name == name]
    return MessageColumns(name, found, recording.log.dated)


def _names(name: str) -> list[str]:
    try:
        definition = by_id(name)
    except KeyError:
        return []
    inside = {number for group in definition.groups for number in range(group.first, group.end)}
    return [field.id for number, field in enumerate(definition.fields) if number not in inside and not field.silent]


def _values(fields: Mapping[str, AnyColumn]) -> dict[str, Array]:
    return {name: _plain(fields, name) for name in fields}


def _plain(fields: Mapping[str, AnyColumn], name: str) -> Array:
    column = fields[name]
    field, values = column.field, column.values
    if field.kind == "BITLOOKUP":
        return _objects([None if code is None else set_bits(field, code) for code in listed(column)])
    if field.labels or field.by:
        return _objects(words(fields, name))
    if values.ndim == 2 or values.dtype == object:
        return _objects(listed(column))
    return values if column.valid is None else np.where(column.valid, values.astype(np.float64), np.nan)


def _objects(values: list[Any]) -> Array:
    found = np.empty(len(values), object)
    found[:] = values
    return found


def _all(parts: list[dict[str, Array]]) -> dict[str, Array]:
    return {name: _joined([part[name] for part in parts]) for name in parts[0]}


def _joined(parts: list[Array]) -> Array:
    return np.concatenate(parts) if parts else np.empty(0)
