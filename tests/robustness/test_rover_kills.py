"""The programs themselves, killed and cut off while the rover drives, in real time.

What is bound to hold to the millisecond is proven in counted time (`test_rover_cuts`); here a busy computer may add
something.
"""

import asyncio
import subprocess
import sys
from pathlib import Path

import pytest

from tests.program import until
from tests.rover_yard import Yard
from tests.unit.cli.programs import ENVIRONMENT
from timonel.gateway.rover import Rover
from timonel.vehicles.rover.drive import STALE

MODULE_TIMEOUT = 0.4  # s
SLACK = 0.15  # s that a busy computer may add
TRIES = 3
DRIVER = """
import asyncio, sys
from timonel.gateway.rover import Rover

async def drive():
    async with Rover.open(f"serial://{sys.argv[1]}", station=1) as rover:
        await rover.enable()
        while True:
            await rover.drive(forward=0.6)
            await asyncio.sleep(0.05)

asyncio.run(drive())
"""


async def driven(yard: Yard) -> subprocess.Popen[bytes]:
    """A program of its own that drives at the far end of the UART."""
    program = subprocess.Popen([sys.executable, "-c", DRIVER, str(yard.client)], env=ENVIRONMENT)
    await until(lambda: yard.moving, "the rover moves", 20.0)
    await asyncio.sleep(0.5)
    return program


def ended(program: subprocess.Popen[bytes]) -> None:
    program.kill()
    program.wait()


@pytest.mark.parametrize(
    ("what", "within"), [("the operator's program", STALE), ("the link", STALE), ("the controller", MODULE_TIMEOUT)]
)
def test_kill_9_and_a_cut_stop_the_wheels_in_time(tmp_path: Path, what: str, within: float):
    """The controller itself cannot say anything any more when it is killed: there it is the boards' own time-out."""

    async def scene(directory: Path) -> float:
        async with Yard(directory, module_timeout=MODULE_TIMEOUT) as yard:
            program = await driven(yard)
            try:
                return await yard.stops_after(
                    {
                        "the operator's program": program.kill,
                        "the link": lambda: setattr(yard.relay, "cut", True),
                        "the controller": yard.program.kill,
                    }[what]
                )
            finally:
                ended(program)

    took: list[float] = []
    while not took or (min(took) > within + SLACK and len(took) < TRIES):
        directory = tmp_path / str(len(took))
        directory.mkdir()
        took.append(asyncio.run(scene(directory)))
    assert min(took) <= within + SLACK


@pytest.mark.parametrize("dialect", ["strzyga", "strzyga-crc"])
def test_over_a_uart_that_loses_one_byte_in_a_hundred_both_ways_a_program_drives_and_no_other_set_point_is_executed(
    tmp_path: Path, dialect: str
):
    async def scene() -> None:
        async with Yard(tmp_path, station=2, dialect=dialect, loss=0.01) as yard:
            async with Rover.open(f"serial://{yard.client}", station=2, dialect=dialect) as client:
                await client.enable()
                for forward in (20, 40, 60, 80):
                    for _ in range(20):
                        await client.drive(forward=forward / 100)
                        await asyncio.sleep(0.05)
            assert yard.rover.body.north > 1.0
            executed = {setpoints for _, setpoints in yard.rover.accepted}
            assert executed == {(percent,) * 3 for percent in (0, 20, 40, 60, 80)}
            await until(lambda: not yard.moving, "leaving the block stops it")

    asyncio.run(scene())
