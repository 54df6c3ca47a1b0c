"""However it ends, a gateway that starts again has nobody in command and leaves the pilot alone."""

import asyncio
import socket
from pathlib import Path

from tests.program import STATIONS, Bench, free_port
from timonel.nmea0183 import parp
from timonel.nmea0183.parp import Verb
from timonel.nmea2000.lookups import SteeringMode

FIRST_STATUS = 2.0  # s
STOPPED = 1.0  # s
TRIES = 5  # a busy computer may spoil some


async def hold(bench: Bench) -> None:
    await bench.ask(1, parp.command(Verb.TAKECMD, 1), "$PARP,CMDTRANSFER,00,01")
    await bench.ask(1, parp.command(Verb.ENGAGE, 1), "$PARP,STATUS,HEADING_HOLD,182.5")


async def kill_and_start(bench: Bench) -> float:
    """Kill the program while it holds a course, start it anew, and wait for STATUS; how long that took, s."""
    loop = asyncio.get_running_loop()
    await hold(bench)
    bench.program.kill()
    await asyncio.sleep(0.1)  # what it said before is read by then
    for end in (bench.bus, *bench.ports):
        end.heard.clear()
    started = loop.time()
    bench.program.start()
    heard = await asyncio.gather(*(out.hears("$PARP,STATUS", within=10.0) for out in bench.outs.values()))
    assert all(line.startswith("$PARP,STATUS,STANDBY,000.0,") and ",00*" in line for _, line in heard)
    return max(when for when, _ in heard) - started


def test_after_kill_9_it_speaks_within_two_seconds_with_nobody_in_command_and_not_a_word_to_the_pilot(
    tmp_path: Path,
) -> None:
    async def scene() -> None:
        async with Bench(tmp_path) as bench:
            took: list[float] = []
            while not took or (min(took) > FIRST_STATUS and len(took) < TRIES):
                took.append(await kill_and_start(bench))
                await bench.program.running()
                for station in STATIONS:  # nobody is in command, so nothing of this is lawful
                    bench.say(station, parp.command(Verb.ENGAGE, station))
                    bench.say(station, parp.command(Verb.DISENGAGE, station))
                await asyncio.sleep(2.5)
                assert bench.bus.opened
                assert bench.bus.commands() == []
            assert min(took) <= FIRST_STATUS
            await hold(bench)
            assert [(mode, course) for _, mode, course in bench.bus.commands()][:1] == [
                (SteeringMode.HEADING_CONTROL, 182.5)
            ]

    asyncio.run(scene())


def test_sigterm_ends_it_within_a_second_though_a_reader_has_stopped_reading(tmp_path: Path) -> None:
    async def scene(directory: Path) -> float:
        port = free_port()
        outputs = [f"tcp-listen://127.0.0.1:{port}"]
        async with Bench(directory, outputs=outputs) as bench:
            await hold(bench)
            with socket.create_connection(("127.0.0.1", port)):
                bench.outs[2].pull()
                await asyncio.sleep(1.0)
                took = await bench.program.stop()
            assert bench.program.process is not None
            assert bench.program.process.returncode == 0
            assert bench.program.log()[-1]["text"] == "stopped"
            assert not [mode for _, mode, _ in bench.bus.commands() if mode is SteeringMode.MAIN_STEERING]
            return took

    took: list[float] = []
    while not took or (min(took) > STOPPED and len(took) < TRIES):
        directory = tmp_path / str(len(took))
        directory.mkdir()
        took.append(asyncio.run(scene(directory)))
    assert min(took) <= STOPPED
