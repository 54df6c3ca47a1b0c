"""`timonel sql`: questions to recordings, in SQL."""

import csv
import sys
from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

import click
import duckdb
import msgspec
import pyarrow as pa

from timonel import __version__
from timonel.cli import report
from timonel.cli.many import Tell, Work, carry_out
from timonel.recording import cache

ROWS = 10_000
"""Rows of an answer that are fetched at once."""


@click.command()
@click.argument("query")
@click.argument("files", nargs=-1, required=True, type=click.Path())
@click.option("--json", "as_json", is_flag=True, help="JSON lines, an object a row.")
@click.option("--jobs", type=click.IntRange(1), help="Files at a time; as many as there are processors, if not given.")
def sql(query: str, files: tuple[str, ...], as_json: bool, jobs: int | None) -> None:
    """Answer QUERY (DuckDB's SQL) about FILES.

    A message is a table by canboat's name, with its file, time, source, destination, priority and fields; a
    repeating set has its own: gnssSatsInView_list. `show tables` and `describe vesselHeading` tell what there is.
    FILES are decoded once, to Parquet in FILE.timonel/. A table on a terminal, else CSV.

    timonel sql "select source, avg(heading) from vesselHeading group by source" log.candump
    """
    outcome = carry_out([Work(file, _tables) for file in files], jobs)
    if outcome.failures:
        outcome.leave()
    try:
        connection = _connection(files, outcome.results)
        answer = connection.sql(query)
        names, rows = ([], iter(())) if answer is None else (answer.columns, _rows(answer))
        if as_json:
            _json(names, rows)
        elif sys.stdout.isatty():
            report.console().print(report.table(names, ([_shown(value) for value in row] for row in rows)))
        else:
            _csv(names, rows)
    except duckdb.Error as error:
        raise click.ClickException(str(error)) from error


def _tables(file: str, tell: Tell) -> str:
    return cache.tables(file, __version__, tell)


def _connection(files: Sequence[str], places: Sequence[str]) -> duckdb.DuckDBPyConnection:
    """A view a message, over all files that have it."""
    connection = duckdb.connect()
    connection.execute("SET TimeZone = 'UTC'")
    parts: dict[str, list[str]] = {}
    for file, place in zip(files, places, strict=True):
        for path in sorted(Path(place).glob("*.parquet")):
            name = path.name.removesuffix(".parquet").replace(".", "_")
            parts.setdefault(name, []).append(f"SELECT {_text(file)} AS file, * FROM read_parquet({_text(str(path))})")
    for name, selects in parts.items():
        connection.execute(f'CREATE VIEW "{name}" AS {" UNION ALL BY NAME ".join(selects)}')
    return connection


def _text(value: str) -> str:
    quoted = value.replace("'", "''")
    return f"'{quoted}'"


def _rows(answer: duckdb.DuckDBPyRelation) -> Iterator[Sequence[Any]]:
    for batch in answer.to_arrow_reader(ROWS):
        yield from zip(*(_column(column).to_pylist() for column in batch.columns), strict=True)


def _column(column: Any) -> Any:
    """Times in UTC need no table of time zones."""
    return column.cast(pa.timestamp("us")) if pa.types.is_timestamp(column.type) else column


def _json(names: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    encoder = msgspec.json.Encoder(enc_hook=str)
    for row in rows:
        sys.stdout.buffer.write(encoder.encode(dict(zip(names, map(_plain, row), strict=True))) + b"\n")
    sys.stdout.buffer.flush()


def _csv(names: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([_shown(value) for value in row] for row in rows)


def _plain(value: Any) -> Any:
    match value:
        case datetime():
            return f"{value:%Y-%m-%dT%H:%M:%S.%f}Z"
        case bytes():
            return value.hex().upper()
    return value


def _shown(value: Any) -> str:
    match value:
        case None:
            return ""
        case list():
            return "; ".join(map(str, value))
    return str(_plain(value))
