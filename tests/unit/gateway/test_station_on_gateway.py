"""Stations on the gateway itself, with the simulated boat, in counted time."""

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from contextlib import AsyncExitStack

import pytest

from tests.unit.gateway.concentrator import Cable, run
from timonel.core.effects import Say
from timonel.errors import RefusedError
from timonel.gateway.gateway import Channel, Gateway
from timonel.gateway.simulation import Simulation
from timonel.gateway.station import Station
from timonel.gateway.verdict import Grant
from timonel.links.link import Changed, Counters
from timonel.links.urls import bus_link
from timonel.nmea0183.parp import PilotMode
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.simulator import Fault, SimulatedBoat
from timonel.vehicles.boat.vehicle import Boat

NAMES = {1: "bridge", 2: "cockpit", 3: "flybridge"}


class Socket:
    """The gateway's end of a cable."""

    url = ""

    def __init__(self, name: str) -> None:
        self.name = name
        self.counters = Counters()
        self._say: Callable[[bytes], None] | None = None

    async def open(self, receive: Callable[[bytes], None], changed: Changed) -> None:
        self.receive, self._changed = receive, changed

    def send(self, lines: Sequence[Say]) -> None:
        for say in lines if self._say else ():
            self._say(say.line)

    async def close(self, drain: float = 0.5) -> None:
        self._say = None

    def plug(self, say: Callable[[bytes], None]) -> None:
        self._say = say
        self._changed(True, "")

    def unplug(self) -> None:
        self._say = None
        self._changed(False, "unplugged")


Scene = Callable[[dict[int, Station], SimulatedBoat], Awaitable[None]]


def play(scene: Scene) -> None:
    """Bridge, cockpit and flybridge on a gateway, three seconds after the boat's devices were switched on."""

    async def main() -> None:
        now = asyncio.get_running_loop().time()
        boat = SimulatedBoat(seed=1)
        sockets = {number: Socket(name) for number, name in NAMES.items()}
        vehicle = Boat(BoatSettings(), [Port(name, number) for number, name in NAMES.items()], now)
        channels = [Channel(socket.name, socket, socket) for socket in sockets.values()]
        gateway = Gateway(vehicle, bus_link("loop://test", name="bus"), channels)
        async with AsyncExitStack() as stack:
            await gateway.open()
            stack.push_async_callback(gateway.close, 0.0)
            await stack.enter_async_context(Simulation(boat, bus_link("loop://test", name="boat")))
            stations = {
                number: await stack.enter_async_context(Station(Cable(socket, delay=0.01), station=number))
                for number, socket in sockets.items()
            }
            await asyncio.sleep(3.0)
            await scene(stations, boat)

    run(main())


async def refusal(command: Awaitable[object]) -> tuple[str, float]:
    """Why a command was refused, and after how many seconds."""
    began = asyncio.get_running_loop().time()
    with pytest.raises(RefusedError) as refused:
        await command
    return str(refused.value), asyncio.get_running_loop().time() - began


def test_command_is_taken_the_boat_turns_and_command_is_handed_over():
    async def scene(s: dict[int, Station], boat: SimulatedBoat) -> None:
        assert await s[2].request() is Grant.NOBODY
        await s[2].engage()
        start = s[2].status.setpoint_deg
        assert start is not None
        await s[2].turn(+40)
        await asyncio.sleep(60.0)
        heading = s[3].status.heading_deg
        assert heading is not None
        assert abs((heading - start - 40 + 180) % 360 - 180) < 5.0
        asking = asyncio.create_task(s[3].request())
        await asyncio.sleep(1.0)
        await s[2].acknowledge()
        assert await asking is Grant.ANSWERED
        assert s[3].status.mode is PilotMode.HEADING_HOLD
        await s[3].disengage()
        await s[3].release()
        assert s[1].status.commander == 0

    play(scene)


def test_every_refusal_is_told_at_once_with_its_reason():
    async def scene(s: dict[int, Station], boat: SimulatedBoat) -> None:
        await s[1].request()
        assert await refusal(s[2].engage()) == ("ENGAGE: station 01 is in command", pytest.approx(0.02, abs=0.01))
        reason, seconds = await refusal(s[1].turn(+10))
        assert reason == "STBDTEN: no heading is being held (STANDBY)"
        assert seconds < 0.1

    play(scene)


def test_a_silent_commander_loses_command_and_a_denying_one_does_not():
    async def scene(s: dict[int, Station], boat: SimulatedBoat) -> None:
        await s[1].request()
        assert await s[2].request() is Grant.SILENCE
        asking = asyncio.create_task(refusal(s[3].request()))
        await asyncio.sleep(1.0)
        await s[2].deny()
        reason, seconds = await asking
        assert reason == "REQCMD: denied; station 02 stays in command"
        assert 11.0 <= seconds <= 11.6

    play(scene)


def test_the_bridge_overrides_commander_and_queue():
    async def scene(s: dict[int, Station], boat: SimulatedBoat) -> None:
        await s[2].request()
        asking = asyncio.create_task(refusal(s[3].request()))
        await asyncio.sleep(1.0)
        await s[1].take()
        assert await asking == ("REQCMD: station 01 has taken command", pytest.approx(1.0, abs=0.05))
        assert (await refusal(s[2].disengage()))[0] == "DISENGAGE: station 01 is in command"

    play(scene)


def test_when_the_backbone_falls_silent_engaging_is_refused_for_the_alarm():
    async def scene(s: dict[int, Station], boat: SimulatedBoat) -> None:
        await s[2].request()
        await s[2].engage()
        boat.silence(Fault.BACKBONE)
        await asyncio.sleep(4.0)
        assert s[2].status.mode is PilotMode.ALARM
        assert (await refusal(s[2].engage()))[0] == "ENGAGE: the far end is in ALARM"
        await s[2].disengage()

    play(scene)


def test_a_long_turn_is_not_cut_short_by_the_allowance_of_the_port():
    async def scene(s: dict[int, Station], boat: SimulatedBoat) -> None:
        await s[2].request()
        await s[2].engage()
        start = s[2].status.setpoint_deg
        assert start is not None
        await s[2].turn(-175)
        assert s[2].status.setpoint_deg == pytest.approx((start - 175) % 360)

    play(scene)
