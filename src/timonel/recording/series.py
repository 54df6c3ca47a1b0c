"""Values over time, as people look at them. Needs the extra `columns`.

A name is a field of any message (`heading`), of one (`vesselHeading.heading`), or a message (`rudder`), of which all
values with a unit are meant. Every source, and every instance of it, is a series of its own.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from pathlib import Path

import msgspec
import numpy as np
import numpy.typing as npt

from timonel.core.mistakes import did_you_mean
from timonel.errors import RecordingError
from timonel.nmea2000 import catalogue
from timonel.nmea2000.catalogue import Definition, Field
from timonel.nmea2000.fixed_columns import Column
from timonel.recording.decoding import Pass
from timonel.recording.tables import Table, Tables
from timonel.recording.wanted import Wanted, wanted
from timonel.vehicles.rover.protocol import Protocol

Values = npt.NDArray[np.float64]

UNITS: dict[str, tuple[str, float, float]] = {
    "rad": ("°", 180 / np.pi, 0.0),
    "deg": ("°", 1.0, 0.0),
    "rad/s": ("°/min", 60 * 180 / np.pi, 0.0),
    "m/s": ("kn", 3600 / 1852, 0.0),
    "K": ("°C", 1.0, -273.15),
    "Pa": ("hPa", 0.01, 0.0),
}
"""What people read instead of a unit: its name, factor and offset."""

MOST = 20_000
"""Points of a series; of more, the highest and lowest of each stretch are kept."""

GAP = 10.0
"""Times the usual interval, but `SHORTEST_GAP` s at least, after which a line is interrupted."""

SHORTEST_GAP = 5.0
_TURN = 2 * np.pi
_TELLING = re.compile(r"([rR]eference|[sS]ource)$")


class Series(msgspec.Struct, frozen=True, eq=False):
    """`time` in s (unix time, or what the recording has) and `value` in `unit`, NaN where the line is interrupted.

    An angle that goes round is `circular`: it was unwrapped, and is to be read modulo 360.
    """

    name: str
    unit: str
    circular: bool
    time: Values
    value: Values


class Found(msgspec.Struct, frozen=True):
    """A field of a message with its values."""

    message: str
    field: str
    unit: str
    circular: bool


def series(path: str | Path, names: Sequence[str], protocol: Protocol | None = None) -> tuple[list[Series], bool]:
    """The series of some names, and whether their times have a date.

    Raises RecordingError for a name that nothing has, or of which the recording has no value.
    """
    protocol = protocol or Protocol()
    index = _index(protocol)
    meant = {name: _meant(name, index) for name in names}
    recording = Pass(path, protocol, _wanted(index, meant.values(), protocol))
    tables = Tables(protocol)
    kept: dict[str, list[Table]] = {}
    messages = {found.message for many in meant.values() for found in many}
    for chunk in recording:
        for table in tables.receive(chunk.groups):
            if table.name in messages:
                kept.setdefault(table.name or "", []).append(table)
    made = [one for name, many in meant.items() for one in _all_of(name, many, kept, recording.log.name)]
    return made, recording.log.dated


def _index(protocol: Protocol) -> dict[str, dict[str, Found]]:
    """All that can be drawn: by message, then by field."""
    index: dict[str, dict[str, Found]] = {}
    for pgn in catalogue.pgns():
        for definition in catalogue.variants(pgn):
            index[definition.id] = {field.id: _found(definition, field) for field in _outer(definition)}
    for declared in protocol.declarations.values():
        name = declared.__name__
        units = {field: signal.unit for field, signal in declared.signals}
        units |= {field: signal.unit for field, signal in declared.DERIVED.items()}
        index[name] = {field: Found(name, field, unit, False) for field, unit in units.items()}
    return index


def _outer(definition: Definition) -> Iterator[Field]:
    """The fields that are numbers, of messages and not of repeating sets."""
    inside = {number for group in definition.groups for number in range(group.first, group.end)}
    for number, field in enumerate(definition.fields):
        numeric = field.kind in ("NUMBER", "FLOAT", "DURATION", "DECIMAL") and field.match is None and not field.labels
        if number not in inside and numeric:
            yield field


def _found(definition: Definition, field: Field) -> Found:
    circular = field.unit == "rad" and not field.signed and (field.bits or 0) * field.resolution > 0
    return Found(definition.id, field.id, field.unit, circular)


def _meant(name: str, index: dict[str, dict[str, Found]]) -> list[Found]:
    message, _, field = name.partition(".")
    if field:
        if message not in index:
            raise RecordingError(f'no message is called "{message}"{did_you_mean(message, index)}')
        if field not in index[message]:
            raise RecordingError(f'{message} has no number "{field}"{did_you_mean(field, index[message])}')
        return [index[message][field]]
    if name in index:
        return [found for found in index[name].values() if found.unit]
    found = [fields[name] for fields in index.values() if name in fields]
    if not found:
        known = {one for fields in index.values() for one in fields}
        raise RecordingError(f'no field or message is called "{name}"{did_you_mean(name, known | set(index))}')
    return found


def _wanted(index: dict[str, dict[str, Found]], meant: Iterable[list[Found]], protocol: Protocol) -> Wanted:
    return wanted(sorted({found.message for many in meant for found in many}), protocol)


def _all_of(name: str, many: list[Found], kept: dict[str, list[Table]], file: str) -> list[Series]:
    """The series of a name: of the message that has most values, if it is a field of several ones."""
    made = {found: list(_split(found, kept.get(found.message, []))) for found in many}
    made = {found: some for found, some in made.items() if some}
    if not made:
        raise RecordingError(f"{file} has no values of {name}")
    if "." not in name and len({found.field for found in made}) == 1 and len(made) > 1:
        best = max(made, key=lambda found: sum(len(one.time) for one in made[found]))
        return made[best]
    return [one for some in made.values() for one in some]


def _split(found: Found, tables: list[Table]) -> Iterator[Series]:
    """One for each source, and for what else tells values apart, that has values."""
    rows: dict[tuple[int, ...], list[tuple[Values, Values]]] = {}
    kinds = _kinds(tables[0]) if tables else []
    for table in tables:
        time, value = table.time, _values(found, table)
        there = ~(np.isnan(time) | np.isnan(value))
        key = _keys(table, kinds)
        for one in np.unique(key[there]).tolist():
            which = there & (key == one)
            parts = tuple(one >> 16 * place & 0xFFFF for place in range(len(kinds), -1, -1))
            rows.setdefault(parts, []).append((time[which], value[which]))
    several = len({source for source, *_ in rows}) > 1
    for (source, *codes), made in sorted(rows.items()):
        words = [str(source)] if several else []
        words += [_word(kind, code - 1) for kind, code in zip(kinds, codes, strict=True) if code]
        label = f"{found.message}.{found.field}" + (f" ({', '.join(words)})" if words else "")
        time, value = (np.concatenate(column) for column in zip(*made, strict=True))
        yield _shown(found, label, time, value)


def _kinds(table: Table) -> list[Field]:
    """The fields that say what a value is of: which engine, which wind, which temperature."""
    fields = [column.field for column in table.fields.values() if isinstance(column, Column)]
    return [field for field in fields if field.id == "instance" or (field.labels and _TELLING.search(field.id))][:3]


def _keys(table: Table, kinds: Sequence[Field]) -> npt.NDArray[np.int64]:
    """Source and, in 16 bits each, what the `kinds` say, plus one; 0 for nothing."""
    key = table.messages.source.astype(np.int64)
    if table.messages.frame is not None:
        key[:] = 0
    for kind in kinds:
        column = table.fields[kind.id]
        code = column.values.astype(np.int64) + 1 & 0xFFFF
        key = key << 16 | (code if column.valid is None else code * column.valid)
    return key


def _word(kind: Field, code: int) -> str:
    return f"#{code}" if kind.id == "instance" else kind.labels.get(code, str(code))


def _values(found: Found, table: Table) -> Values:
    if found.field in table.signals:
        return table.signals[found.field]
    column = table.fields[found.field]
    value = column.values.astype(np.float64)
    return value if column.valid is None else np.where(column.valid, value, np.nan)


def _shown(found: Found, label: str, time: Values, value: Values) -> Series:
    order = np.argsort(time, kind="stable")
    time, value = time[order], value[order]
    if found.circular:
        value = np.unwrap(value, period=_TURN)
    unit, factor, offset = UNITS.get(found.unit, (found.unit, 1.0, 0.0))
    time, value = _thinned(time, value * factor + offset)
    return Series(label, unit, found.circular, *_interrupted(time, value))


def _thinned(time: Values, value: Values) -> tuple[Values, Values]:
    """The highest and the lowest of each stretch, if there are too many."""
    if len(time) <= MOST:
        return time, value
    size = -(-len(time) // (MOST // 2))
    starts = np.arange(0, len(time), size)
    whole = len(time) // size * size
    block = value[:whole].reshape(-1, size)
    first = starts[: len(block)]
    keep = np.concatenate((first + block.argmin(1), first + block.argmax(1), np.arange(whole, len(time))))
    keep = np.unique(keep)
    return time[keep], value[keep]


def _interrupted(time: Values, value: Values) -> tuple[Values, Values]:
    """A NaN in each gap."""
    if len(time) < 3:
        return time, value
    steps = np.diff(time)
    gaps = np.flatnonzero(steps > max(SHORTEST_GAP, GAP * float(np.median(steps))))
    middle = (time[gaps] + time[gaps + 1]) / 2
    return np.insert(time, gaps + 1, middle), np.insert(value, gaps + 1, np.nan)


def by_unit(found: Sequence[Series]) -> list[tuple[str, list[Series]]]:
    """Series that share an axis, in the order in which they were asked for."""
    order = list(dict.fromkeys((one.unit, one.circular) for one in found))
    ranked = sorted(found, key=lambda one: order.index((one.unit, one.circular)))
    return [(key[0], list(some)) for key, some in groupby(ranked, key=lambda one: (one.unit, one.circular))]
