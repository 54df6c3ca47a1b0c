"""Arrow arrays made of NumPy's memory are those that Arrow itself makes of the values."""

import sys
from importlib import import_module

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from timonel.errors import RecordingError
from timonel.nmea2000.catalogue import by_id
from timonel.recording.frames import NO_STAMP
from timonel.recording.sinks.arrays import TIME, Words, binary, distinct, numbers, sparse_texts, times
from timonel.recording.sinks.notation import set_bits

WHOLE = [np.dtype(code) for code in "bBhHiIqQ"]
SIZES = st.integers(0, 40)


@st.composite
def columns(draw, kinds=WHOLE):
    """Values, and which of them are valid, None for all."""
    size = draw(SIZES)
    values = draw(hnp.arrays(draw(st.sampled_from(kinds)), size))
    return values, draw(st.none() | hnp.arrays(np.bool_, size))


def field(message, name):
    return next(one for one in by_id(message).fields if one.id == name)


def sound(array):
    array.validate(full=True)
    return array


@given(columns())
def test_whole_numbers_are_null_where_they_are_not_valid(column):
    values, valid = column
    assert sound(numbers(values, valid)).equals(pa.array(values, mask=None if valid is None else ~valid))


@given(hnp.arrays(np.float64, SIZES))
def test_floats_are_null_where_they_are_nan(values):
    assert sound(numbers(values)).equals(pa.array(values, from_pandas=True))


def test_every_other_value_of_a_column_is_an_array_too():
    assert numbers(np.arange(10, dtype=np.uint16)[::2]).to_pylist() == [0, 2, 4, 6, 8]


@given(hnp.arrays(np.int64, SIZES, elements=st.just(NO_STAMP) | st.integers(0, 1 << 61)), st.sampled_from([0, 10**18]))
def test_times_are_rounded_to_microseconds_of_the_day(stamp, day):
    expected = [None if one == NO_STAMP else (one + day + 500) // 1000 for one in stamp.tolist()]
    assert sound(times(stamp, day)).equals(pa.array(expected, pa.int64()).cast(TIME))


def test_without_a_day_there_are_no_times():
    assert times(np.zeros(3, np.int64), None).equals(pa.nulls(3, TIME))


@given(st.data())
def test_bytes_are_those_of_each_row(data):
    payloads = data.draw(hnp.arrays(np.uint8, st.tuples(SIZES, st.integers(1, 9))))
    rows, width = payloads.shape
    sizes = data.draw(st.none() | hnp.arrays(np.intp, rows, elements=st.integers(0, width)))
    valid = data.draw(st.none() | hnp.arrays(np.bool_, rows))
    lengths = [width] * rows if sizes is None else sizes.tolist()
    there = [True] * rows if valid is None else valid.tolist()
    some = zip(payloads, lengths, there, strict=True)
    expected = [row[:size].tobytes() if is_there else None for row, size, is_there in some]
    assert sound(binary(payloads, sizes, valid)).to_pylist() == expected


@given(
    SIZES.flatmap(lambda rows: st.tuples(st.dictionaries(st.integers(0, max(rows - 1, 0)), st.text()), st.just(rows)))
)
def test_rows_without_a_text_are_null(case):
    texts, rows = case
    texts = {row: text for row, text in texts.items() if row < rows}
    assert sound(sparse_texts(list(texts.items()), rows)).to_pylist() == [texts.get(row) for row in range(rows)]


@given(st.lists(columns([np.dtype("B"), np.dtype("H"), np.dtype("b"), np.dtype("I")]), max_size=4))
def test_lookups_are_words_or_numbers_without_a_word(some):
    manufacturer = field("isoAddressClaim", "manufacturerCode")
    words = {kind: Words(manufacturer) for kind in "BHbI"}
    for codes, valid in some:
        made = sound(words[codes.dtype.char].array(codes, valid))
        there = [True] * len(codes) if valid is None else valid.tolist()
        told = [str(manufacturer.labels.get(code, code)) for code in codes.tolist()]
        assert made.to_pylist() == [word if is_there else None for word, is_there in zip(told, there, strict=True)]


def test_a_dictionary_only_grows():
    words = Words(field("vesselHeading", "reference"))
    first, second = (words.array(np.array(codes, np.uint8), None).dictionary.to_pylist() for codes in ([1], [0, 1, 7]))
    assert first == ["Magnetic"]
    assert second == ["Magnetic", "True", "7"]


@pytest.mark.parametrize("found", [[], [None], ["a", None, 3, "a"]])
def test_words_told_one_by_one_are_a_dictionary_too(found):
    made = sound(Words(field("vesselHeading", "reference")).one_by_one(found))
    assert made.to_pylist() == [None if one is None else str(one) for one in found]


@given(columns([np.dtype("B"), np.dtype("H"), np.dtype("I")]))
def test_set_bits_are_lists_of_words(column):
    codes, valid = column
    status = field("engineParametersDynamic", "discreteStatus1")
    there = [True] * len(codes) if valid is None else valid.tolist()
    expected = [
        [str(word) for word in set_bits(status, code)] if is_there else None
        for code, is_there in zip(codes.tolist(), there, strict=True)
    ]
    made = sound(Words(status).lists(codes, valid))
    assert made.equals(pa.array(expected, pa.list_(pa.string())))


@given(columns())
def test_each_value_that_occurs_is_told_once_and_each_row_has_its_own(column):
    values, _ = column
    found, which = distinct(values)
    assert set(found.tolist()) == set(values.tolist())
    assert len(found) == len(set(found.tolist()))
    assert found.take(which).tolist() == values.tolist()


def test_without_pyarrow_it_is_said_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.delitem(sys.modules, Words.__module__)
    with pytest.raises(RecordingError, match="the extra `columns`"):
        import_module(Words.__module__)
