"""CSV of decoded recordings (RFC 4180): the tables of `arrow`, as text. Needs the extra `columns` with pyarrow.

    "time","source","destination","priority","sid","heading",...
    2022-11-30 12:01:29.869107Z,204,255,2,255,2.3154,...

A field is empty where there is no value; several words (set bits) have a semicolon between them; bytes are in hex.
"""

from typing import Any, BinaryIO

import pyarrow as pa
from pyarrow import compute
from pyarrow import csv as arrow_csv


class CsvFile:
    """Writes record batches of one table to a path or a stream."""

    def __init__(self, where: str | BinaryIO, schema: Any) -> None:
        fields = [pa.field(field.name, _type(field.type)) for field in schema]
        self._schema = pa.schema(fields)
        self._writer = arrow_csv.CSVWriter(where, self._schema)

    def write_table(self, table: Any) -> None:
        columns = [_plain(column.combine_chunks()) for column in table.columns]
        self._writer.write_table(pa.Table.from_arrays(columns, schema=self._schema))

    def close(self) -> None:
        self._writer.close()


def _type(kind: Any) -> Any:
    return pa.string() if pa.types.is_dictionary(kind) or pa.types.is_list(kind) or pa.types.is_binary(kind) else kind


def _plain(column: Any) -> Any:
    if pa.types.is_dictionary(column.type):
        return column.cast(pa.string())
    if pa.types.is_list(column.type):
        return compute.binary_join(column, "; ")
    if pa.types.is_binary(column.type):
        return pa.array([None if one is None else one.hex().upper() for one in column.to_pylist()], pa.string())
    return column
