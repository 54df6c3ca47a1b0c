"""Consoles command a running gateway as wires do, beside wires, and what they said is replayed to the last byte."""

import asyncio
from functools import partial
from pathlib import Path
from typing import Any

from tests.program import Program, Terminal, free_port, until
from tests.unit.cli.programs import timonel
from tests.unit.cli.test_demo import two_free_ports
from tests.web_client import WebClient
from timonel.nmea0183 import parp
from timonel.nmea0183.parp import Verb

REQUEST_SECONDS = 10.0
SETTLED = 0.03  # rad
STOP_WITHIN = 0.5  # s from the last word of a driver to a rover that is told to stand
TRIES = 3  # a busy computer may spoil one


class Demo:
    """`timonel demo`, and consoles of it."""

    def __init__(self, directory: Path, vehicle: str, port: int) -> None:
        self.directory = directory
        self.web_port = free_port()
        self.program = Program(
            directory, "demo", vehicle, "--no-view", "--directory", str(directory), "--port", str(port),
            "--web-port", str(self.web_port),
        )  # fmt: skip

    async def console(self, station: int | None = None) -> WebClient:
        client = await WebClient(self.web_port).connect()
        client.wake()
        if station is not None:
            assert (await client.order("choose", station=station))["outcome"] == "confirmed"
        return client


def topic(client: WebClient, name: str) -> Any:
    return client.topics().get(name)


def waits(client: WebClient, name: str) -> bool:
    """Whether a console shows that a station asks for command."""
    return [waiting["name"] for waiting in topic(client, "command")["queue"]] == [name]


def commands(client: WebClient, name: str) -> bool:
    """Whether a console shows that a station has command."""
    return bool(topic(client, "command")["commander_name"] == name)


async def confirmed(client: WebClient, verb: str, within: float = 5.0, **parameter: float) -> None:
    answer = await client.order("command", within, verb=verb, **parameter)
    assert answer["outcome"] == "confirmed", answer


def turn(a: float, b: float) -> float:
    """From one direction to another, rad."""
    return abs((a - b + 3.14159265) % 6.2831853 - 3.14159265)


def test_two_consoles_and_a_wire_hand_command_to_each_other(tmp_path: Path) -> None:
    async def play() -> None:
        demo = Demo(tmp_path, "boat", two_free_ports())
        async with demo.program as program:
            await program.running()
            assert f"console  http://127.0.0.1:{demo.web_port}/" in program.log_path.read_text()
            bridge, cockpit = await demo.console(1), await demo.console(2)
            wire = Terminal(tmp_path / "flybridge")
            wire.plug()
            await until(lambda: topic(bridge, "heading")["quality"] == "fresh", "a heading")
            await confirmed(bridge, "TAKECMD")
            await confirmed(bridge, "ENGAGE")
            await confirmed(bridge, "STBDTEN")
            course = topic(bridge, "pilot")["setpoint"]
            assert topic(cockpit, "pilot")["setpoint"] == course
            await until(lambda: turn(topic(bridge, "heading")["value"], course) < SETTLED, "the course", 60.0)

            refused = await cockpit.order("command", verb="DISENGAGE")
            assert (refused["outcome"], refused["reason"]) == ("refused", "not in command")
            asked = asyncio.get_running_loop().time()
            waiting = asyncio.create_task(confirmed(cockpit, "REQCMD", REQUEST_SECONDS + 5))
            for client in (bridge, cockpit):
                await until(partial(waits, client, "Cockpit"), "the request")
                assert topic(client, "command")["deadline"] is not None
            await waiting
            assert REQUEST_SECONDS - 0.5 < asyncio.get_running_loop().time() - asked < REQUEST_SECONDS + 1.0
            for client in (bridge, cockpit):
                await until(partial(commands, client, "Cockpit"), "the transfer")
            assert topic(bridge, "pilot")["mode"] == "HEADING_HOLD", "bumpless"

            wire.say(parp.command(Verb.REQCMD, 3))
            await until(partial(waits, cockpit, "Flybridge"), "the request of the wire")
            await confirmed(cockpit, "ACKCMD")
            assert (await wire.hears("$PARP,CMDTRANSFER,02,03"))[1]
            await until(partial(commands, bridge, "Flybridge"), "the transfer")
            await confirmed(bridge, "TAKECMD")
            await confirmed(bridge, "DISENGAGE")
            for client in (bridge, cockpit):
                client.close()
            wire.pull()
            await program.stop()

    asyncio.run(play())
    verified = timonel("replay", "--verify", str(tmp_path / "recordings"))
    assert verified.returncode == 0, verified.stderr.decode() + verified.stdout.decode()
    assert b"the same to the last byte" in verified.stdout


async def killed_while_driving(directory: Path) -> float:
    """How long it takes from a driver's death until everybody sees the drives stopped, s."""
    demo = Demo(directory, "rover", two_free_ports())
    async with demo.program as program:
        await program.running()
        driver, onlooker = await demo.console(1), await demo.console()
        await confirmed(driver, "TAKECMD")
        assert (await driver.order("enable"))["outcome"] == "confirmed"
        for number in range(40):
            driver.say("stick", n=number, x=0.0, y=0.8)
            await asyncio.sleep(0.02)
        assert topic(onlooker, "drive")["left"] == 0.8
        assert topic(onlooker, "wheels")[0]["rpm"] > 0
        driver.close()
        stopped = await until(lambda: not topic(onlooker, "drive")["permitted"], "a stop")
        onlooker.close()
        return stopped


def test_a_driver_whose_socket_is_cut_stops_the_rover(tmp_path: Path) -> None:
    for place in range(TRIES):
        (tmp_path / str(place)).mkdir()
        stopped = asyncio.run(killed_while_driving(tmp_path / str(place)))
        if stopped < STOP_WITHIN:
            break
    assert stopped < STOP_WITHIN
