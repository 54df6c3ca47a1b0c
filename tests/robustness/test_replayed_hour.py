"""An hour of simulated time in which everything goes wrong: forty minutes of the boat, twenty of the rover."""

from pathlib import Path

import pytest

from tests.voyage import BOAT, ROVER, Voyage
from timonel.gateway.configuration import Configuration
from timonel.gateway.replay import verify
from timonel.recording.flight_writer import Limits

PARTS = {"boat 1": (BOAT, 20), "boat 2": (BOAT, 20), "rover 1": (ROVER, 10), "rover 2": (ROVER, 10)}
MINUTE = 60  # s
LIMITS = Limits(segment_size=500_000)


def replays(directory: Path, configuration: Configuration, seed: int, minutes: int) -> None:
    run = Voyage(directory, configuration, seed, limits=LIMITS, flush=10.0)
    verdict = verify(run.sail(minutes * MINUTE))
    assert (verdict.difference, verdict.notes) == (None, [])
    assert verdict.steps == run.told == run.writer.written.steps
    assert verdict.seconds == pytest.approx(minutes * MINUTE, abs=1)
    assert run.writer.written.segments > 3
    assert min(verdict.frames / 1000, verdict.sent / 50, verdict.events / 100, verdict.said / 10_000) > minutes / 10


@pytest.mark.timeout(600)
@pytest.mark.parametrize("part", PARTS)
def test_an_hour_of_everything_that_goes_wrong_replays_to_the_same_bytes(tmp_path: Path, part: str) -> None:
    configuration, minutes = PARTS[part]
    replays(tmp_path, configuration, seed=list(PARTS).index(part) + 10, minutes=minutes)


@pytest.mark.slow
@pytest.mark.parametrize("configuration", [BOAT, ROVER], ids=["boat", "rover"])
@pytest.mark.parametrize("seed", range(100, 104))
def test_an_hour_of_each_replays_to_the_same_bytes(tmp_path: Path, configuration: Configuration, seed: int) -> None:
    replays(tmp_path, configuration, seed, minutes=60)
