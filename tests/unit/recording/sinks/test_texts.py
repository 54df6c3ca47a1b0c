"""Texts in arrays: numbers as they are printed, and lines put together."""

import json

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from timonel.recording.sinks.texts import SPARE, Page, Texts, constant, decimals, listed, where

WHOLE = st.integers(-(10**15) + 1, 10**15 - 1)


def shown(texts):
    cells, sizes = texts.block(slice(0, len(texts.sizes)))
    return [bytes(row[:size]) for row, size in zip(cells, sizes, strict=True)]


@given(st.lists(WHOLE, min_size=1, max_size=20))
def test_whole_numbers_are_printed_as_python_prints_them(numbers):
    assert shown(decimals(np.array(numbers, np.int64), 0)) == [str(number).encode() for number in numbers]


@given(st.lists(WHOLE, min_size=1, max_size=20), st.integers(1, 12))
def test_fractions_are_printed_as_json_prints_them_unless_they_need_an_exponent(numbers, places):
    fine = [number for number in numbers if number == 0 or abs(number / 10**places) >= 1e-4]
    expected = [json.dumps(number / 10**places).encode() for number in fine]
    assert shown(decimals(np.array(fine, np.int64), places)) == expected


def test_a_text_in_some_rows_is_nothing_in_the_others():
    assert shown(where(np.array([True, False]), b"rpm")) == [b"rpm", b""]
    assert shown(constant(b"rpm", 2)) == [b"rpm", b"rpm"]
    assert shown(listed([b"a", b"long", b""])) == [b"a", b"long", b""]


def test_texts_put_in_their_order_cover_what_does_not_count():
    page = Page(7)
    for at, text in ((0, b"ab......"), (2, b"cde....."), (5, b"fg......")):
        page.put(np.array([at]), np.frombuffer(text, np.uint8)[None], np.array([2]))
    assert bytes(page.content) == b"abcdefg"[:2] + b"cd" + b"e" + b"fg"


def test_long_texts_spoil_no_more_than_what_is_spare():
    width = 5 * SPARE
    page = Page(2 * width)
    page.put_all(np.array([0]), b"." * 2 * width)
    sizes = np.array([0, 3, 2 * SPARE, width])
    cells = np.full((4, width), ord("x"), np.uint8)
    for size in sizes.tolist():
        page.put_all(np.array([0]), b"." * 2 * width)
        page.put(np.array([0]), cells[:1], np.array([size]))
        text = bytes(page.content)
        assert text[:size] == b"x" * size
        assert set(text[size + SPARE :]) == {ord(".")}


def test_a_page_is_used_again():
    page = Page()
    for text in (b"first", b"2"):
        page.clear(len(text))
        page.put_one(0, text)
        assert bytes(page.content) == text


def test_rows_choose_their_text():
    texts = Texts(np.frombuffer(b"abcd", np.uint8).reshape(2, 2), np.array([1, 2]), np.array([1, 0, 1]))
    assert shown(texts) == [b"cd", b"a", b"cd"]
    assert texts.sizes.tolist() == [2, 1, 2]
