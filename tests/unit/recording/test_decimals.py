"""Numbers in a text, many at once: those that `float` reads, bit for bit."""

import random
import re

import numpy as np
import pytest

from timonel.recording.decimals import LONGEST, decimals

PLAIN = re.compile(r"-?(\d+\.?\d*|\.\d+)")


def read(*texts):
    """The numbers of some texts, which stand side by side; None where there is none."""
    begin = np.cumsum([LONGEST, *(len(text) + 1 for text in texts)])[:-1]
    end = begin + [len(text) for text in texts]
    joined = "9" * LONGEST + ",".join(texts) + "," + "9" * LONGEST
    found = decimals(np.frombuffer(joined.encode("latin-1"), np.uint8), begin, end)
    return [value if fine else None for value, fine in zip(found.values.tolist(), found.fine.tolist(), strict=True)]


@pytest.mark.parametrize("text", [
        "0", "7", "-7", "338", "13.41", ".5", "5.", "-.5", "-0", "0.0", "00012.50", "6005.071", "02332.346",
        "-02332.346", "3854.508712", "12345678", "123456789", "123456789012345", "12345678.1234567",
        "-1234567.1234567", "0.12345678901234",
])  # fmt: skip
def test_a_plain_number_is_what_float_makes_of_it(text):
    (value,) = read(text)
    assert value.hex() == float(text).hex()


@pytest.mark.parametrize(
    "text",
    [
        "", ".", "-", "-.", "--1", "1-", "1.2.3", "1..2", "12345678.9.1", "1234.5678.90", "1e5", "+1", " 1", "1_0",
        "nan", "inf", "1/2", "1:2", "0x1", "\xb2", "1234567890123456", "12345678901234567",
],
)  # fmt: skip
def test_anything_else_is_none(text):
    assert read(text) == [None]


def test_numbers_of_all_lengths_are_read_beside_each_other():
    draw = random.Random(4)
    texts = [f"{draw.uniform(-10, 10) ** draw.randrange(1, 7):.{draw.randrange(7)}f}" for _ in range(5000)]
    texts += ["".join(draw.choices("0123456789.-", k=draw.randrange(19))) for _ in range(5000)]
    texts += ["".join(draw.choices("0123456789.-:/+ eA;\x80\xff", k=draw.randrange(12))) for _ in range(2000)]
    for text, value in zip(texts, read(*texts), strict=True):
        if value is None:
            assert not PLAIN.fullmatch(text) or len(text) > 15, text
        else:
            assert PLAIN.fullmatch(text), text
            assert value.hex() == float(text).hex(), text
