"""The page about a rover's safety says what the shipped machine does."""

import runpy
from pathlib import Path

SCRIPT = Path(__file__).parents[2] / "scripts" / "make_stop_table.py"


def test_the_table_of_stops_is_what_the_simulator_gives():
    script = runpy.run_path(str(SCRIPT))
    assert script["PAGE"].read_text() == script["page"](), "run scripts/make_stop_table.py"
