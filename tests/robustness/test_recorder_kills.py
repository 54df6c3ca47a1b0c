"""kill -9 at random instants: what was flushed is read, nothing raises, and it replays to the same bytes."""

import asyncio
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from random import Random

import pytest

from tests.program import Program
from timonel.gateway.replay import verify
from timonel.recording.flight import Flight
from timonel.recording.flight_repair import repair

AT_ONCE = 4  # programs that run beside each other
FLUSHED = 1.0  # s between two flushes
WRITTEN = 2.0  # s that a disk may take which others write to as well
LONGEST = 2.5  # s until it is killed

CONFIGURATION = """
[vehicle]
kind = "boat"
name = "killed"

[bus]
url = "file://{log}?loop=yes"

[[output]]
url = "tcp-listen://127.0.0.1:0"

[recording]
directory = "recordings"
segment_size = "20 kB"
budget = "1 MB"
"""


def log(path: Path) -> Path:
    """Two hundred frames a second, a heading in each."""
    frames = [f"({1.6e9 + n / 200:.6f}) can0 09F11223#FF{n % 251:02X}2700000000FC\n" for n in range(2000)]
    path.write_text("".join(frames))
    return path


@contextmanager
def programs(directory: Path) -> Iterator[list[Program]]:
    with ExitStack() as stack:
        started = []
        for number in range(AT_ONCE):
            home = directory / str(number)
            home.mkdir(exist_ok=True)
            (home / "boat.toml").write_text(CONFIGURATION.format(log=log(home / "log")))
            program = Program(home, "run", str(home / "boat.toml"))
            program.start()
            stack.callback(program.kill)
            started.append(program)
        yield started


async def killed(directory: Path, random: Random) -> dict[Path, tuple[float, float]]:
    """When each of the programs ran and when it was killed (unix s), by its directory of recordings."""
    with programs(directory) as running:
        await asyncio.gather(*(program.running() for program in running))
        ran = time.time()
        waits = sorted((random.uniform(0.0, LONGEST), number) for number in range(len(running)))
        began, ends = time.monotonic(), {}
        for wait, number in waits:
            await asyncio.sleep(max(0.0, began + wait - time.monotonic()))
            running[number].kill()
            ends[running[number].log_path.parent / "recordings"] = (ran, time.time())
    return ends


def look_at(recordings: Path, killed_at: float, began: float) -> int:
    """Everything up to the last flush is there; how many chunks that is. It was recording at `began` (unix s)."""
    files = sorted(recordings.glob("*.mcap"), key=lambda path: path.stat().st_mtime_ns)
    chunks = 0
    last = began
    for path in files:
        flight = Flight(path)
        for page in flight.pages():
            chunks += 1
            last = max(last, max(record.stamp_ns for record in page) / 1e9)
        assert all(damage.reason == "the file is cut off" for damage in flight.damage)
    assert killed_at - last < FLUSHED + WRITTEN
    if files:
        verdict = verify(files[-1])
        assert verdict.difference is None
        assert repair(files[-1], recordings / "mended").chunks > 0
    return chunks


def kill(directory: Path, times: int, seed: int) -> None:
    random, chunks = Random(seed), 0
    for number in range(times // AT_ONCE):
        home = directory / str(number)
        home.mkdir()
        for recordings, (ran, killed_at) in asyncio.run(killed(home, random)).items():
            chunks += look_at(recordings, killed_at, ran)
    assert chunks > times / 2  # most of them lived for more than a second


def test_a_gateway_that_was_killed_has_recorded_up_to_its_last_flush(tmp_path: Path) -> None:
    kill(tmp_path, times=20, seed=1)


@pytest.mark.slow
def test_of_200_gateways_that_were_killed_all_have_recorded(tmp_path: Path) -> None:
    kill(tmp_path, times=200, seed=2)
