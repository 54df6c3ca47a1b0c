"""CSV of decoded recordings (RFC 4180): the tables of `arrow`, as text. Needs the extra `columns` with pyarrow.

    "time","source","destination","priority","sid","heading",...
    2022-11-30 12:01:29.869107Z,204,255,2,255,2.3154,...

A field is empty where there is no value; several words (set bits) have a semicolon between them; bytes are in hex.
"""

from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt
import pyarrow as pa
from pyarrow import csv as arrow_csv

Text = npt.NDArray[np.uint8]

_WITHOUT_ZONE = pa.timestamp("us")
_TIME = len("2022-11-30 12:01:29.869107")
"""Characters of a time without its zone."""


class CsvFile:
    """Writes tables of one schema to a path or a stream."""

    def __init__(self, where: str | BinaryIO, schema: Any) -> None:
        self._owned = isinstance(where, str)
        self._file = pa.output_stream(where, compression=None)
        self._schema = pa.schema([pa.field(field.name, _type(field.type)) for field in schema])
        self._file.write(_text([pa.array([], field.type) for field in self._schema], self._schema, header=True))

    def write_table(self, table: Any) -> None:
        columns = [_plain(column.combine_chunks()) for column in table.columns]
        timed = pa.types.is_timestamp(columns[0].type)
        text = _timed(columns, self._schema) if timed else None
        self._file.write(_text(columns, self._schema) if text is None else text)

    def close(self) -> None:
        if self._owned:
            self._file.close()


def _text(columns: list[Any], schema: Any, header: bool = False) -> Text:
    stream = pa.BufferOutputStream()
    options = arrow_csv.WriteOptions(include_header=header)
    with arrow_csv.CSVWriter(stream, schema, write_options=options) as writer:
        writer.write_batch(pa.RecordBatch.from_arrays(columns, schema=schema))
    return np.frombuffer(stream.getvalue(), np.uint8)


# A time in a zone takes Arrow longer to write than all other fields together.
def _timed(columns: list[Any], schema: Any) -> Text | None:
    """Lines that begin with times: written without their zone, which is put in; None if a text has a line end."""
    times = columns[0].view(_WITHOUT_ZONE)
    text = _text([times, *columns[1:]], schema.set(0, pa.field(schema.names[0], times.type)))
    ends = np.flatnonzero(text == ord("\n"))
    if len(ends) != len(times):
        return None
    begins = np.concatenate((np.zeros(1, np.intp), ends + 1))[:-1]
    there = ~np.isnat(times.to_numpy(zero_copy_only=False))
    return np.insert(text, begins[there] + _TIME, ord("Z"))


def _type(kind: Any) -> Any:
    return pa.string() if pa.types.is_list(kind) or pa.types.is_binary(kind) else kind


def _plain(column: Any) -> Any:
    if pa.types.is_list(column.type):
        from pyarrow import compute

        return compute.binary_join(column, "; ")
    if pa.types.is_binary(column.type):
        return pa.array([None if one is None else one.hex().upper() for one in column.to_pylist()], pa.string())
    return column
