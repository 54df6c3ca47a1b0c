"""`timonel.Station` at both ends of a hand-over, each on a pseudo-terminal of the running program."""

import asyncio
from itertools import groupby
from pathlib import Path

import pytest

from tests.program import Backbone, Program, heading, until, write_configuration
from timonel import Station
from timonel.errors import RefusedError
from timonel.gateway.verdict import Grant
from timonel.nmea0183.parp import PilotMode


def test_two_stations_engage_turn_and_hand_over(tmp_path: Path) -> None:
    async def scene() -> None:
        bus = Backbone(tmp_path / "can")
        bus.frames = [heading(182.5)]
        bus.plug()
        sailing = asyncio.create_task(bus.sail())
        paths = {number: tmp_path / f"station{number}" for number in (2, 3)}
        stations = {number: f'url = "pty://{path}"' for number, path in paths.items()}
        configuration = write_configuration(tmp_path / "boat.toml", f"slcan://{bus.path}", stations)
        async with Program(tmp_path, "run", str(configuration)) as program:
            await program.running()
            await until(lambda: program.events("AddressClaimed"), "an address on the bus")
            async with (
                Station.open(f"serial://{paths[2]}", station=2) as cockpit,
                Station.open(f"serial://{paths[3]}", station=3) as flybridge,
            ):
                await hand_over(cockpit, flybridge)
            told = [course for course, _ in groupby(course for _, _, course in bus.commands())]
            assert told == [182.5, 192.5, 182.5, None]
        sailing.cancel()
        bus.pull()

    asyncio.run(scene())


async def hand_over(cockpit: Station, flybridge: Station) -> None:
    assert await cockpit.request() is Grant.NOBODY
    await until(lambda: cockpit.status.heading_deg == 182.5, "the heading")
    await cockpit.engage()
    await cockpit.turn(+10)
    with pytest.raises(RefusedError):
        await flybridge.turn(-10)
    asking = asyncio.create_task(flybridge.request())
    await until(lambda: [request.station for request in cockpit.requests] == [3], "the request")
    await cockpit.acknowledge()
    assert await asking is not Grant.NOBODY
    await flybridge.turn(-10)
    await until(lambda: cockpit.status.setpoint_deg == 182.5, "the same on the other station")
    assert cockpit.status.mode is PilotMode.HEADING_HOLD
    assert cockpit.status.commander == 3
    await flybridge.disengage()
    await flybridge.release()
