"""The same transcripts again, through the running program: real pseudo-terminals, and a CAN adapter played by the test.

Every transcript has a program of its own and all are played at once, so that it takes no longer than the longest.
"""

import asyncio
from contextlib import AsyncExitStack
from itertools import pairwise
from pathlib import Path

import msgspec
import pytest

from tests.conformance.transcript import LATE, Step, bus_frames, cases, check, steps
from tests.program import STATIONS, Bench, Kind
from tests.recordings import vectors
from timonel.nmea2000.lookups import SteeringMode

SESSION = "the example session"
TRANSCRIPTS: dict[str, list[Step]] = {SESSION: steps(vectors("boat_session.jsonl"))} | {
    case["name"]: case["steps"] for case in cases(vectors("boat_command_cases.jsonl"))
}
WIRE = 0.15  # s that the wires, the program and a busy computer may add
TRIES = 3
QUIET = 0.06  # s after STATUS: nothing is under way on any port, unless the computer is busy
UNDER_WAY = 4  # sentences: that many are not
AT_ONCE = 3  # programs that start, so that other tests on the same computer get their turn
KINDS: dict[int, Kind] = {1: "serial", 2: "serial", 3: "pty", 4: "pty"}

pytestmark = pytest.mark.timeout(240)


class Played(msgspec.Struct):
    """What came out, by station, with times from the transcript's beginning; `courses` went to the pilot."""

    said: dict[int, list[tuple[float, str]]]
    courses: list[tuple[float, SteeringMode | None, float | None]]


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Played]:
    """All transcripts; what did not hold is played again, for a busy computer may be late."""
    results: dict[str, Played] = {}
    for _ in range(TRIES):
        names = [name for name in TRANSCRIPTS if name not in results or not holds(name, results[name])]
        if not names:
            break
        results |= asyncio.run(play_all({name: tmp_path_factory.mktemp("boat") for name in names}))
    return results


def holds(name: str, result: Played) -> bool:
    try:
        for station in STATIONS:
            check(result.said[station], TRANSCRIPTS[name], WIRE)
    except AssertionError:
        return False
    return True


async def play_all(directories: dict[str, Path]) -> dict[str, Played]:
    ready, door = asyncio.Barrier(len(directories)), asyncio.Semaphore(AT_ONCE)
    async with asyncio.TaskGroup() as group:
        playing = {
            name: group.create_task(play(TRANSCRIPTS[name], directory, ready, door))
            for name, directory in directories.items()
        }
    return {name: task.result() for name, task in playing.items()}


async def play(transcript: list[Step], directory: Path, ready: asyncio.Barrier, door: asyncio.Semaphore) -> Played:
    """`door` lets a few programs start at a time, `ready` lets all begin when all have started."""
    loop = asyncio.get_running_loop()
    async with AsyncExitStack() as stack:
        async with door:
            bench = Bench(directory, kinds=KINDS, frames=bus_frames(transcript[0]["bus"]))
            await stack.enter_async_context(bench)
        await ready.wait()
        await asyncio.gather(*(out.hears("$PARP,STATUS", len(out.heard)) for out in bench.outs.values()))
        await asyncio.sleep(QUIET)
        began = loop.time()
        marks = {station: len(bench.outs[station].heard) for station in STATIONS}
        for step in transcript:
            await asyncio.sleep(began + step["t"] - loop.time())
            if "bus" in step:
                bench.bus.frames = [] if step["bus"] is None else bus_frames(step["bus"])
            if "in" in step:
                bench.say(int(step["in"]["port"].removeprefix("IN")), step["in"]["sentence"])
        await asyncio.sleep(LATE + WIRE)
        said = {
            station: [(when - began, line) for when, line in bench.outs[station].heard[marks[station] :]]
            for station in STATIONS
        }
        return Played(said, [(when - began, mode, course) for when, mode, course in bench.bus.commands()])


@pytest.mark.parametrize("name", TRANSCRIPTS)
def test_the_transcript_holds_on_the_wires_of_every_station(name: str, played: dict[str, Played]) -> None:
    for station in STATIONS:
        check(played[name].said[station], TRANSCRIPTS[name], WIRE)


@pytest.mark.parametrize("name", TRANSCRIPTS)
def test_every_station_hears_the_same(name: str, played: dict[str, Played]) -> None:
    first, *others = [[line for _, line in played[name].said[station]] for station in STATIONS]
    assert all(are_the_same(first, lines) for lines in others)


def are_the_same(one: list[str], other: list[str]) -> bool:
    """But for what was under way when the first step began, and when the last one was over."""
    shifts = [(0, 0), *((0, late) for late in range(1, UNDER_WAY)), *((late, 0) for late in range(1, UNDER_WAY))]
    for early, late in shifts:
        ours, theirs = one[early:], other[late:]
        whole = min(len(ours), len(theirs))
        if ours[:whole] == theirs[:whole] and whole > max(len(ours), len(theirs)) - UNDER_WAY:
            return True
    return False


def test_the_pilot_is_told_what_the_session_commands_and_nothing_else(played: dict[str, Played]) -> None:
    told = played[SESSION].courses
    changes = [told[0], *(after for before, after in pairwise(told) if after[1:] != before[1:])]
    assert [(mode, course) for _, mode, course in changes] == [
        (SteeringMode.HEADING_CONTROL, course) for course in (182.5, 192.5, 200.0)
    ]
    assert [when for when, _, _ in changes] == pytest.approx([3.0, 5.0, 16.0], abs=WIRE)


@pytest.mark.parametrize("name", [name for name, steps in TRANSCRIPTS.items() if "ENGAGE" not in str(steps)])
def test_without_an_engage_the_pilot_is_told_nothing(name: str, played: dict[str, Played]) -> None:
    assert played[name].courses == []
