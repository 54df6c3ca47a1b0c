"""Recorded NMEA 0183 logs in columns: every value is the parser's."""

import pytest

from tests.recordings import ROOT, recording
from tests.unit.recording.sentences import compared
from timonel.errors import RecordingError
from timonel.recording.formats import open_any

pytestmark = pytest.mark.usefixtures("each_way")


def logs():
    """Every file of sentences below the recordings' folder, by its path."""
    found = []
    for path in sorted(ROOT.rglob("*")):
        if path.is_file():
            try:
                with open_any(path) as log:
                    if log.kind == "sentences":
                        found.append(str(path.relative_to(ROOT)))
            except RecordingError:
                continue
    return found


@pytest.mark.parametrize("name", logs())
def test_every_value_is_that_of_the_parser_in_any_portions(name):
    assert compared(recording(name))
    if recording(name).stat().st_size < 100_000:
        assert compared(recording(name), 700)
