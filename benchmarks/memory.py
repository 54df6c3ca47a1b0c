"""Memory after an hour of simulated bus with twelve readers, in a process of its own and in the boat's time."""

import asyncio
import json
import os
import subprocess
import sys
import tempfile

from benchmarks.live_gateway import Setup, make
from benchmarks.processes import HARNESS, PROGRAM, Helper, Stamps, Where, ending, resident_mib, run_reader
from timonel.core.frame import Frame
from timonel.links.loop import LoopLink
from timonel.vehicles.boat.settings import BoatSettings
from timonel.vehicles.boat.simulator import SimulatedBoat

MINUTE = 60.0  # s
HOUR = 60 * MINUTE
STEP = 0.05  # s
TURNS = 4  # of the loop, for what one step brings about
CHANNEL = "memory"


def measure() -> dict[str, float]:
    """MiB after a minute and after the hour (with the simulated boat in them), and what went through in it."""
    command = [sys.executable, "-m", "benchmarks.memory"]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    result: dict[str, float] = json.loads(done.stdout)
    return result


class HurriedLoop(asyncio.SelectorEventLoop):
    """A loop that is told the time; it must always have something to do."""

    now = 0.0

    def time(self) -> float:
        return self.now


async def _sail(directory: str) -> dict[str, float]:
    setup = Setup({})
    gateway, listeners = make(LoopLink(CHANNEL, name="bus"), BoatSettings(), directory, setup)
    await gateway.open()
    terminals = tuple(f"{directory}/{number}" for number in range(1, 1 + setup.terminals))
    where = Where(-1, terminals, listeners.address, setup.clients)
    reader = Helper(HARNESS, run_reader, where, {}, 1, Stamps())
    with ending(reader):
        reader.answer()
        reader.order("count")
        boat, bus = SimulatedBoat(), LoopLink(CHANNEL)
        await bus.open(lambda frames: _hear(boat, frames), lambda connected, reason: None)
        await _step(boat, bus, MINUTE)
        after_a_minute = resident_mib()
        await _step(boat, bus, HOUR - MINUTE)
        reader.order("count")
        return {
            "MiB after a minute": after_a_minute,
            "MiB after an hour": resident_mib(),
            "frames": gateway.bus.counters.frames_in,
            "sentences read": sum(reader.answer().sentences),
        }


def _hear(boat: SimulatedBoat, frames: list[Frame]) -> None:
    for frame in frames:
        boat.receive(frame)


async def _step(boat: SimulatedBoat, bus: LoopLink, seconds: float) -> None:
    loop = asyncio.get_running_loop()
    assert isinstance(loop, HurriedLoop)
    for _ in range(round(seconds / STEP)):
        loop.now += STEP
        bus.send(boat.step(STEP))
        for _ in range(TURNS):
            await asyncio.sleep(0)


def main() -> None:
    os.sched_setaffinity(0, {PROGRAM})
    with tempfile.TemporaryDirectory() as directory, asyncio.Runner(loop_factory=HurriedLoop) as runner:
        print(json.dumps(runner.run(_sail(directory))))


if __name__ == "__main__":
    main()
