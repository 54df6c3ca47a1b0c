import asyncio
import os
from functools import partial
from pathlib import Path

import pytest

from tests.program import free_port
from timonel.core.frame import Frame
from timonel.errors import LinkError
from timonel.gateway.assemble import assemble
from timonel.gateway.configuration import Configuration, parse
from timonel.links.urls import bus_link
from timonel.nmea0183 import parp
from timonel.vehicles.boat.simulator import SimulatedBoat


def configured(directory: Path, port: int) -> Configuration:
    return parse(f"""
        vehicle.kind = "boat"
        bus.url = "loop://assemble"
        [[station]]
        id = 1
        url = "pty://{directory}/bridge"
        [[station]]
        id = 2
        in = "pty://{directory}/cockpit-in"
        out = "pty://{directory}/cockpit-out"
        [[output]]
        url = "tcp-listen://127.0.0.1:{port}"
        """)


async def until(fd: int, word: bytes) -> bytes:
    """What is heard on a terminal until `word` is in it."""
    heard = b""
    while word not in heard:
        try:
            heard += os.read(fd, 4096)
        except BlockingIOError:
            await asyncio.sleep(0.01)
    return heard


def obey(boat: SimulatedBoat, frames: list[Frame]) -> None:
    for frame in frames:
        boat.receive(frame)


def opened(path: Path) -> int:
    return os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)


def test_stations_take_command_and_steer_over_real_terminals_while_a_listener_hears_all(tmp_path: Path) -> None:
    async def scene() -> None:
        port = free_port()
        gateway = assemble(configured(tmp_path, port))
        await gateway.open()
        sea = bus_link("loop://assemble")
        boat = SimulatedBoat(seed=1)
        await sea.open(partial(obey, boat), lambda *_: None)
        bridge, says, hears = (opened(tmp_path / name) for name in ("bridge", "cockpit-in", "cockpit-out"))
        listener, writer = await asyncio.open_connection("127.0.0.1", port)
        await asyncio.sleep(0.2)
        sea.send(boat.step(1.0))
        os.write(says, parp.command(parp.Verb.REQCMD, 2))
        assert b"CMDTRANSFER,00,02" in await until(hears, b",02*")
        os.write(says, parp.command(parp.Verb.ENGAGE, 2))
        assert b"STATUS,HEADING_HOLD" in await until(bridge, b"HEADING_HOLD")
        while not boat.pilot.engaged:  # the command waits for our address, half a second from the start
            await asyncio.sleep(0.01)
        await listener.readuntil(b"$IIHDT")
        for fd in (bridge, says, hears):
            os.close(fd)
        writer.close()
        await gateway.close()
        await sea.close()

    asyncio.run(asyncio.wait_for(scene(), 10))
    assert list(tmp_path.iterdir()) == []


def test_the_counters_of_all_links_and_of_the_boat_are_watched(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async def scene() -> None:
        gateway = assemble(configured(tmp_path, free_port()))
        gateway.health.report()

    caplog.set_level("INFO")
    asyncio.run(scene())
    watched = caplog.records[0].__dict__["fields"].keys()
    assert {"bus", "Station 1", "Station 2", "Station 2 OUT", "boat", "fast packet"} <= watched


def test_a_link_that_cannot_be_made_is_told() -> None:
    async def scene() -> None:
        assemble(Configuration("boat.toml", vehicle=parse(SOUND).vehicle, bus_url="sockcan://can0"))

    with pytest.raises(LinkError, match="did you mean"):
        asyncio.run(scene())


SOUND = 'vehicle.kind = "boat"\nbus.url = "loop://a"\n[[output]]\nurl = "udp://127.0.0.1:2000"\n'
