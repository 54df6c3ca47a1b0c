"""CSV is what Arrow would write, though times are not left to it."""

import io

import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyarrow import csv as arrow_csv

from timonel.recording.sinks.arrays import TIME
from timonel.recording.sinks.csv import CsvFile

MICROSECONDS = st.none() | st.integers(-(9 * 10**15), 9 * 10**15)
TEXTS = st.none() | st.sampled_from(["", "Magnetic", "a,b", 'said "so"', "two\nlines", "öß"])
ROWS = st.lists(st.tuples(MICROSECONDS, st.none() | st.floats(allow_nan=False), TEXTS), max_size=20)


def table(rows):
    times, numbers, texts = zip(*rows, strict=True) if rows else ((), (), ())
    words = pa.array(texts, pa.string()).dictionary_encode()
    columns = [pa.array(times, pa.int64()).cast(TIME), pa.array(numbers, pa.float64()), words]
    return pa.table(dict(zip(("time", "number", "text"), columns, strict=True)))


def written(*tables):
    stream = io.BytesIO()
    file = CsvFile(stream, tables[0].schema)
    for one in tables:
        file.write_table(one)
    file.close()
    return stream.getvalue()


@given(ROWS, ROWS)
def test_times_are_written_as_arrow_writes_them(rows, more):
    stream = io.BytesIO()
    expected = table([*rows, *more])
    arrow_csv.write_csv(expected.set_column(2, "text", expected["text"].cast(pa.string())), stream)
    assert written(table(rows), table(more)) == stream.getvalue()


def test_the_first_column_need_not_be_a_time():
    assert written(pa.table({"row": [1, 2], "prn": [5, None]})) == b'"row","prn"\n1,5\n2,\n'


@pytest.mark.parametrize(
    ("values", "kind", "text"),
    [([["a", "b"], [], None], pa.list_(pa.string()), '"a; b"'), ([b"\1\xab", b"", None], pa.binary(), '"01AB"')],
)
def test_several_words_have_a_semicolon_between_them_and_bytes_are_in_hex(values, kind, text):
    assert written(pa.table({"x": pa.array(values, kind)})) == f'"x"\n{text}\n""\n\n'.encode()


def test_a_file_is_whole_once_it_is_closed(tmp_path):
    file = CsvFile(str(tmp_path / "x.csv"), table([]).schema)
    file.write_table(table([(0, 1.5, "a")]))
    file.close()
    assert (tmp_path / "x.csv").read_bytes() == b'"time","number","text"\n1970-01-01 00:00:00.000000Z,1.5,"a"\n'
