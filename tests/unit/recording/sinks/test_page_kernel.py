"""What the kernel that writes lines does not take."""

import numpy as np
import pytest

from timonel import native
from timonel.nmea2000 import catalogue
from timonel.recording.sinks import line_page
from timonel.recording.sinks.line_steps import CODE, NUMBER, LineSteps


def page(steps=None, **changed):
    """The arguments for two lines of a heading."""
    steps = steps or LineSteps()
    written = steps.written(127250, catalogue.variants(127250)[0])
    given = {
        "texts": steps.texts, "slots": steps.slots, "steps": steps.steps.copy(), "owners": np.ones(2, np.int32),
        "made": b"", "sizes": np.zeros(0, np.int64),
        "tables": np.array([[written.step, written.steps, written.head, written.head_size, 1, 2, 8, 0]], np.int64),
        "page": np.empty(1 << 12, np.uint8), "state": np.zeros(5, np.int64), "gaps": np.zeros((3, 3), np.int64),
        "columns": [np.zeros(2, np.int64), np.zeros(2, np.uint32), np.zeros((2, 8), np.uint8), np.full(2, 8, np.int64)],
    }  # fmt: skip
    return [*(given | changed).values(), 0, True]


def changed_table(column, value):
    arguments = page()
    arguments[6][0, column] = value
    return arguments


def changed_step(kind, column, value):
    arguments = page()
    steps = arguments[2]
    steps[np.flatnonzero(steps[:, 0] == kind)[0], column] = value
    return arguments


def changed_state(place, value):
    arguments = page()
    arguments[8][place] = value
    return arguments


WRONG = {
    "a table behind the steps": lambda: changed_table(0, 1 << 40),
    "more steps than there are": lambda: changed_table(1, 1 << 40),
    "a head behind the texts": lambda: changed_table(2, 1 << 40),
    "a head that is too long": lambda: changed_table(3, 1 << 16),
    "rows that are not there": lambda: changed_table(5, 3),
    "payloads that are not so wide": lambda: changed_table(6, 9),
    "a row below the first": lambda: changed_table(7, -1),
    "a step of no kind": lambda: changed_step(NUMBER, 0, 99),
    "a text behind the texts": lambda: changed_step(NUMBER, 1, 1 << 40),
    "a text that is too long": lambda: changed_step(NUMBER, 2, 1 << 40),
    "bits that are not together": lambda: changed_step(NUMBER, 4, 65),
    "bits that need not be there": lambda: changed_step(NUMBER, 5, 0),
    "too many places": lambda: changed_step(NUMBER, 11, 17),
    "slots that are not there": lambda: changed_step(CODE, 14, 1 << 40),
    "a frame below the first": lambda: changed_state(0, -1),
    "more than the page holds": lambda: changed_state(1, 1 << 13),
    "more gaps than frames": lambda: changed_state(4, 1),
    "too little room for gaps": lambda: page(gaps=np.zeros((1, 3), np.int64)),
    "a column too few": lambda: page(columns=[np.zeros(2, np.int64)] * 3),
    "a line that nobody made": lambda: page(owners=np.full(2, -1, np.int32)),
    "a line longer than what was made": lambda: page(owners=np.full(2, -1, np.int32), sizes=np.ones(2, np.int64)),
    "a table that is not there": lambda: page(owners=np.full(2, 2, np.int32)),
    "more lines than a table has": lambda: changed_table(7, 2),
}  # fmt: skip


@pytest.mark.parametrize("wrong", WRONG)
def test_the_kernel_refuses(wrong):
    with pytest.raises(ValueError, match=r"range|few|not there"):
        native.kernels.json_lines(*WRONG[wrong]())


def test_lines_of_payloads_that_are_longer_than_their_rows_are_left_out():
    arguments = page()
    lengths, gaps, state = np.full(2, 9, np.int64), arguments[9], arguments[8]
    arguments[10][3] = lengths
    assert native.kernels.json_lines(*arguments)[0] == line_page.Stop.DONE
    assert state.tolist() == [2, 0, 0, 0, 2]
    assert gaps[:2].tolist() == [[0, 0, 0], [0, 1, 0]]
