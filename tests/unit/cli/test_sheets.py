"""What is written without rich is what rich would draw."""

import io
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from tests.recordings import recording
from timonel.cli import report, sheets
from timonel.cli.sheets import WIDE, Screen, Sheet
from timonel.recording.decoding import Pass

CELLS = st.text("ab  19:[]/\\.é\t", max_size=12) | st.just("x" * 150)
NAMES = st.lists(st.text("ab :[", min_size=1, max_size=6), min_size=1, max_size=4, unique=True)


def drawn(*printed):
    file = io.StringIO()
    console = Console(file=file, highlight=False, width=WIDE)
    for what in printed:
        console.print(what, markup=False, highlight=False)
    return file.getvalue()


def shown(monkeypatch, *printed):
    """What a screen shows where there is no terminal, and whether rich had to draw some of it."""
    file, asked = io.StringIO(), []
    monkeypatch.setattr(sys, "stdout", file)
    monkeypatch.setattr(sheets, "console", lambda stderr: asked.append(stderr) or Console(file=file, width=WIDE))
    screen = Screen()
    for what in printed:
        screen.print(what)
    return file.getvalue(), bool(asked)


@given(st.data(), NAMES)
def test_a_table_is_as_rich_draws_it_or_left_to_it(data, names):
    rows = data.draw(st.lists(st.lists(CELLS, min_size=len(names), max_size=len(names)), max_size=4))
    sheet = Sheet(names, rows, frozenset(names[:1]))
    assert sheet.text() in (None, drawn(sheet))


@given(st.lists(st.tuples(CELLS, CELLS), max_size=4))
def test_a_list_of_names_and_values_too(rows):
    sheet = Sheet((), rows)
    assert sheet.text() in (None, drawn(sheet))


def test_columns_in_which_nothing_stands_are_left_out_and_numbers_are_set_to_the_right():
    sheet = Sheet(("name", "count", "maker"), [("a", "5", ""), ("bc", "1 000", "")], frozenset({"count"}))
    assert sheet.text() == "name  count  \na         5  \nbc    1 000  \n"


@pytest.mark.parametrize("line", ["log, line 202: fewer than seven fields: 2020", "a" * 200, "[b]", ":cat:", "é", ""])
def test_a_line_is_as_rich_prints_it(monkeypatch, line):
    assert shown(monkeypatch, line)[0] == drawn(line)


@pytest.mark.parametrize("name", ["susteranna2020.raw", "can0-2.pcap", "candumpSample2.txt"])
def test_what_is_told_of_a_recording_needs_no_rich(monkeypatch, name):
    recorded = Pass(recording(f"canboat_canboat/samples/{name}"))
    for _ in recorded:
        pass
    summary = recorded.summary
    facts = [report._facts(summary), report.messages(summary.messages), report.devices(summary.devices)]
    assert shown(monkeypatch, *facts) == (drawn(*facts), False)


def test_a_program_whose_output_nobody_watches_does_not_load_rich():
    program = (
        "import sys; from timonel.cli import report; from timonel.recording.summary import Summary; "
        "report.overview([Summary('a')] * 2, report.Screen(stderr=True)); print('rich' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


@pytest.mark.parametrize("name", ["FORCE_COLOR", "TTY_COMPATIBLE"])
def test_whoever_asks_for_a_terminal_gets_one(monkeypatch, name):
    monkeypatch.setenv(name, "1")
    assert shown(monkeypatch, Sheet((), [("a", "b")]))[1]
