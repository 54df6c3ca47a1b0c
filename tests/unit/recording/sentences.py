"""NMEA 0183 logs in columns, compared with the sentences read one by one."""

from collections import defaultdict
from enum import Enum
from pathlib import Path
from typing import Any

from timonel.nmea0183.checksum import Fault, checksum
from timonel.nmea0183.registry import parse
from timonel.recording.fast_nmea0183 import SentenceReader, SentenceTable, open_sentences
from timonel.recording.formats import open_any
from timonel.recording.frames import nanoseconds
from timonel.recording.sentence_columns import Column


def sealed(body: str, start: str = "$") -> str:
    """The line of a sentence, ISO 8859-1."""
    return f"{start}{body}*{checksum(body.encode('latin-1')):02X}\n"


def compared(path: Path, size: int = 1 << 21) -> list[SentenceTable]:
    """The tables of a log, after a look at every value: all are those of the parser, bit for bit."""
    log, reader = open_any(path), open_sentences(path, size=size)
    records = [(record.stamp, record.line, parse(record.line)) for record in log]
    tables = list(reader)
    expected = [(nanoseconds(stamp), line, read) for stamp, line, read in records if read is not Fault.MALFORMED]
    found = sorted(row for table in tables for row in _rows(table))
    assert [(stamp, line) for _, stamp, line, *_ in found] == [(stamp, line) for stamp, line, _ in expected]
    for (*_, kind, values), (_, line, read) in zip(found, expected, strict=True):
        assert kind == ("" if isinstance(read, Fault) else type(read).__name__), line
        for name, value in values.items():
            _same(value, getattr(read, name), line)
    assert reader.malformed == len(records) - len(expected)
    _same_log(reader, log)
    return tables


def _rows(table: SentenceTable) -> list[tuple[Any, ...]]:
    columns = {name: listed(column) for name, column in table.columns.items()}
    kind = table.kind.__name__ if table.kind else ""
    rows = zip(table.line.tolist(), table.stamp.tolist(), table.sentences, strict=True)
    return [(*row, kind, {name: values[i] for name, values in columns.items()}) for i, row in enumerate(rows)]


def listed(column: Column) -> list[Any]:
    """The values as the sentences have them."""
    values = column.values.tolist()
    match column.values.dtype.kind:
        case "f":
            return [None if value != value else value for value in values]
        case "S":
            return [value.decode("latin-1") or None for value in values]
    if column.valid is None:
        return values
    return [value if valid else None for value, valid in zip(values, column.valid.tolist(), strict=True)]


def _same(found: Any, expected: Any, line: bytes) -> None:
    expected = expected.value if isinstance(expected, Enum) else expected
    assert (type(found), found) == (type(expected), expected), line
    if isinstance(found, float):
        assert found.hex() == expected.hex(), line


def _same_log(reader: SentenceReader, log: Any) -> None:
    assert reader.log.frames == log.frames
    assert reader.log.unreadable == log.unreadable
    assert reader.log.unreadable_count == log.unreadable_count


def by_formatter(tables: list[SentenceTable]) -> dict[str, list[SentenceTable]]:
    found = defaultdict(list)
    for table in tables:
        found[table.formatter].append(table)
    return dict(found)
