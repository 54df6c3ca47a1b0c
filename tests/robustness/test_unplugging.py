"""What is pulled is opened again when it is back, and command stays where it is meanwhile."""

import asyncio
from pathlib import Path
from statistics import median

import pytest

from tests.program import Bench, Kind, until
from timonel.nmea0183 import parp
from timonel.nmea0183.parp import Verb
from timonel.nmea2000.lookups import SteeringMode

KINDS: dict[int, Kind] = {1: "serial", 2: "serial", 3: "pty", 4: "pty"}
BACK = 1.0  # s until a link is open again
STATUS = 0.5  # s between two STATUS
SLACK = 0.5  # s that a busy computer may add
HOLDING = "$PARP,STATUS,HEADING_HOLD,182.5,182.5,+0.0,01*"


async def engage(bench: Bench) -> None:
    """Station 1 holds the boat's heading."""
    await bench.ask(1, parp.command(Verb.TAKECMD, 1), "$PARP,CMDTRANSFER,00,01")
    await bench.ask(1, parp.command(Verb.ENGAGE, 1), HOLDING)


async def unplug_everything(bench: Bench) -> float:
    """Pull all eight, plug them in again, and wait until every station hears; how long the slowest waited, s."""
    for port in bench.ports:
        port.pull()
    await asyncio.sleep(0.02)
    marks = {station: len(out.heard) for station, out in bench.outs.items()}
    plugged = asyncio.get_running_loop().time()
    for port in bench.ports:
        port.plug()
    heard = await asyncio.gather(*(out.hears("$PARP,STATUS", marks[s], 10.0) for s, out in bench.outs.items()))
    return max(when for when, _ in heard) - plugged


@pytest.mark.timeout(300)
@pytest.mark.parametrize("rounds", [13, pytest.param(100, marks=pytest.mark.slow)])
def test_eight_ports_pulled_again_and_again_come_back_leak_nothing_and_leave_command_alone(
    tmp_path: Path, rounds: int
) -> None:
    async def scene() -> None:
        async with Bench(tmp_path, kinds=KINDS) as bench:
            await engage(bench)
            descriptors = bench.program.descriptors()
            took = [await unplug_everything(bench) for _ in range(rounds)]
            assert median(took) <= BACK + STATUS  # a busy computer may spoil one or the other
            await until(lambda: bench.program.descriptors() == descriptors, "as many descriptors as before")
            for out in bench.outs.values():
                said = [line for _, line in out.heard if line.startswith("$PARP,STATUS,")]
                engaged = next(place for place, line in enumerate(said) if line.startswith(HOLDING))
                assert all(line.startswith(HOLDING) for line in said[engaged:])
            told = {(mode, course) for _, mode, course in bench.bus.commands()}
            assert told == {(SteeringMode.HEADING_CONTROL, 182.5)}
            health = await bench.program.health()
            reopened = {station: health[f"Station {station} OUT"]["reopened"] for station in bench.outs}
            assert reopened[1] == reopened[2] == rounds
            assert reopened[3] > 0  # a terminal that is open again before anybody looked was never lost
            assert reopened[4] > 0
            await every_in_port_is_heard(bench)

    asyncio.run(scene())


async def every_in_port_is_heard(bench: Bench) -> None:
    await bench.ask(1, parp.command(Verb.RELCMD, 1), "$PARP,CMDTRANSFER,01,00")
    for station in bench.ins:
        await bench.ask(station, parp.command(Verb.REQCMD, station), f"$PARP,CMDTRANSFER,00,0{station}")
        await bench.ask(station, parp.command(Verb.RELCMD, station), f"$PARP,CMDTRANSFER,0{station},00")


def test_the_wire_of_the_commander_is_pulled_and_another_station_gets_command_after_ten_seconds(tmp_path: Path) -> None:
    async def scene() -> None:
        async with Bench(tmp_path) as bench:
            await engage(bench)
            bench.ins[1].pull()
            bench.outs[1].pull()
            await bench.ask(2, parp.command(Verb.REQCMD, 2), "$PARP,CMDREQUEST,02")
            mark, began = len(bench.outs[2].heard), asyncio.get_running_loop().time()
            when, line = await bench.outs[2].hears("$PARP,CMDTRANSFER", mark, 11.0)
            assert line.startswith("$PARP,CMDTRANSFER,01,02*")
            assert when - began == pytest.approx(10.0, abs=SLACK)
            await bench.outs[2].hears("$PARP,STATUS,HEADING_HOLD,182.5,182.5,+0.0,02", mark)

    asyncio.run(scene())


def test_a_broken_line_of_the_adapter_is_counted_and_the_bus_goes_on(tmp_path: Path) -> None:
    async def scene() -> None:
        async with Bench(tmp_path) as bench:
            await engage(bench)
            for broken in (b"T09F1\r", b"\xff\x00\x80\r", b"x" * 3000 + b"\r", b"T09F112018ZZZZ\r", b"t9990\r"):
                bench.bus.say(broken)
            bench.bus.say(b"\a")
            await asyncio.sleep(1.0)
            health = await bench.program.health()
            assert health["bus"]["rejected"] == 5
            assert health["bus"]["errors"] == 1
            mark = len(bench.outs[1].heard)
            _, status = await bench.outs[1].hears("$PARP,STATUS", mark)
            assert status.startswith(HOLDING)

    asyncio.run(scene())


def test_without_its_adapter_the_gateway_alarms_after_three_seconds_and_is_back_within_one(tmp_path: Path) -> None:
    async def scene() -> None:
        loop = asyncio.get_running_loop()
        async with Bench(tmp_path) as bench:
            await engage(bench)
            bench.bus.pull()
            mark, pulled = len(bench.outs[3].heard), loop.time()
            alarm, _ = await bench.outs[3].hears("$PARP,STATUS,ALARM", mark)
            assert 2.8 < alarm - pulled < 3.0 + SLACK
            await bench.ask(1, parp.command(Verb.STBDTEN, 1), "$PARP,STATUS,ALARM")
            mark, plugged = len(bench.outs[3].heard), loop.time()
            bench.bus.plug()
            back, _ = await bench.outs[3].hears("$PARP,STATUS,STANDBY,000.0,182.5,+0.0,01", mark)
            assert back - plugged < BACK + SLACK
            await until(bench.bus.commands, "the pilot is told to let go")
            await asyncio.sleep(1.2)
            assert {mode for _, mode, _ in bench.bus.commands()} == {SteeringMode.MAIN_STEERING}
            await bench.ask(1, parp.command(Verb.ENGAGE, 1), HOLDING)

    asyncio.run(scene())
