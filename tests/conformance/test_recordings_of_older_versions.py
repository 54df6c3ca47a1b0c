"""Recordings that were made by an older version give the same bytes today.

`python -m tests.voyage` makes them anew. That is right only where a machine's answers were changed on purpose, and the
changelog tells its users.
"""

from pathlib import Path

import pytest

from timonel.gateway.replay import verify

DATA = Path(__file__).parents[1] / "data"


@pytest.mark.parametrize("name", ["boat.mcap", "rover.mcap"])
def test_an_old_recording_replays_to_the_same_bytes(name: str) -> None:
    verdict = verify(DATA / name)
    assert (verdict.difference, verdict.notes) == (None, [])
    assert verdict.steps > 500
    assert min(verdict.frames, verdict.sent, verdict.events, verdict.said) > 20
