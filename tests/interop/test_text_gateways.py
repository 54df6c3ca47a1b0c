"""PyPI `nmea2000` as a client of our raw outputs, in all forms, both ways; and two gateways of ours in a row."""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from math import degrees

import pytest
from nmea2000.input_formats import N2KFormat
from nmea2000.ioclient import TextNmea2000Gateway
from nmea2000.message import NMEA2000Message

from tests.program import free_port, until
from timonel.core.frame import Frame
from timonel.gateway.assemble import assemble
from timonel.gateway.configuration import parse
from timonel.gateway.gateway import Gateway
from timonel.gateway.simulation import Simulation
from timonel.gateway.station import Station
from timonel.links.urls import bus_link
from timonel.vehicles.boat.simulator import SimulatedBoat
from timonel.vehicles.boat.vehicle import Boat

HERE = "127.0.0.1"
PEERS = {
    "ydraw": N2KFormat.CAN_FRAME_ASCII,
    "n2kascii": N2KFormat.N2K_ASCII,
    "seasmart": N2KFormat.PCDIN,
    "candump": N2KFormat.CANDUMP3,
}
OTHER = 0x42
SECOND = 0x24

pytestmark = pytest.mark.timeout(60)


def configuration(
    bus: str, output: int | None = None, form: str = "", station: int | None = None, own: int = 35
) -> str:
    text = f'[vehicle]\nkind = "boat"\n[bus]\nurl = "{bus}"\naddress = {own}\n[web]\n'
    if output is not None:
        text += f'[[output]]\nurl = "tcp-listen://{HERE}:{output}"\nformat = "{form}"\ntransmit = true\n'
    if station is not None:
        text += f'[[station]]\nid = 1\nurl = "tcp-listen://{HERE}:{station}"\n'
    return text


@asynccontextmanager
async def running(text: str) -> AsyncIterator[Gateway]:
    gateway = assemble(parse(text))
    await gateway.open()
    try:
        yield gateway
    finally:
        await gateway.close()


@asynccontextmanager
async def a_boat(form: str, output: int) -> AsyncIterator[tuple[Gateway, SimulatedBoat]]:
    """A gateway on a simulated boat, with a raw output."""
    simulated = SimulatedBoat(1, start=1_700_000_000.0)
    bus = f"loop://{form}-{output}"
    async with (
        Simulation(simulated, bus_link(bus, name="simulated")),
        running(configuration(bus, output, form)) as made,
    ):
        yield made, simulated


@asynccontextmanager
async def a_peer(port: int, form: str) -> AsyncIterator[tuple[TextNmea2000Gateway, list[NMEA2000Message]]]:
    heard: list[NMEA2000Message] = []

    async def receive(message: NMEA2000Message) -> None:
        heard.append(message)

    peer = TextNmea2000Gateway(HERE, port, PEERS[form], seed_network_map=False)
    peer.set_receive_callback(receive)
    await peer.connect()
    try:
        yield peer, heard
    finally:
        await peer.close()


def value(message: NMEA2000Message, field: str) -> object:
    return next(each.value for each in message.fields if each.id == field)


@pytest.mark.parametrize("form", PEERS)
def test_a_client_of_the_package_reads_the_boat_and_is_heard_by_it(form: str) -> None:
    async def scene() -> None:
        port = free_port()
        async with a_boat(form, port) as (gateway, _), a_peer(port, form) as (peer, heard):
            pgns = {127250, 129025, 129029, 128267}
            await until(lambda: pgns <= {message.PGN for message in heard}, "single frames and fast packets")
            heading = [message for message in heard if message.PGN == 127250][-1]
            assert isinstance(gateway.vehicle, Boat)
            shown = gateway.vehicle.truth.true.value
            assert shown is not None
            told = value(heading, "heading")
            assert isinstance(told, float)
            assert degrees(told) == pytest.approx(degrees(shown.angle), abs=5.0)  # it goes on turning meanwhile
            depth = [message for message in heard if message.PGN == 128267][-1]
            depth.source = OTHER
            before = gateway.health.counts["Rejected"]
            await peer.send(depth)
            name = f"tcp-listen://{HERE}:{port} frames"
            await until(lambda: gateway.health._watched[name]().get("transmitted"), "a message on the bus")
            assert gateway.health.counts["Rejected"] == before

    asyncio.run(scene())


def test_a_fast_packet_of_the_package_arrives_whole_on_our_bus() -> None:
    async def scene() -> None:
        port = free_port()
        async with a_boat("n2kascii", port) as _, a_peer(port, "n2kascii") as (peer, heard):
            on_bus: list[Frame] = []
            ear = bus_link(f"loop://n2kascii-{port}", name="ear")
            await ear.open(on_bus.extend, lambda connected, reason: None)
            await until(lambda: any(message.PGN == 129029 for message in heard), "a position")
            position = next(message for message in heard if message.PGN == 129029)
            position.source = OTHER
            await peer.send(position)
            await until(lambda: [f for f in on_bus if f.identifier & 0xFF == OTHER], "its frames")
            frames = [frame for frame in on_bus if frame.identifier & 0xFF == OTHER]
            assert [frame.data[0] & 0x1F for frame in frames] == list(range(len(frames)))
            assert len(frames) == 1 + (frames[0].data[1] // 7)
            await ear.close()

    asyncio.run(scene())


@pytest.mark.parametrize("form", ["ydraw", "n2kascii", "candump"])
def test_a_second_gateway_steers_the_boat_through_the_raw_output_of_the_first(
    form: str, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)  # should it fail, its report tells what both gateways saw

    async def scene() -> None:
        raw, helm = free_port(), free_port()
        async with a_boat(form, raw) as (_, boat):
            text = configuration(f"{form}+tcp://{HERE}:{raw}", station=helm, own=SECOND)
            async with running(text) as second, Station.open(f"tcp://{HERE}:{helm}", station=1) as station:
                await until(lambda: station.status.heading_deg is not None, "the heading of the far boat")
                await station.take()
                await station.engage()
                await station.turn(10)
                assert second.bus.counters.frames_out > 0
                await until(lambda: boat.pilot.engaged, "the far pilot engaged")

    asyncio.run(scene())


def test_the_package_reads_what_we_command_where_we_are_the_server_of_the_bus() -> None:
    """`ydraw+tcp-listen` as the bus: an ESP32 or the package connects to us."""

    async def scene() -> None:
        bus, helm = free_port(), free_port()
        text = configuration(f"ydraw+tcp-listen://{HERE}:{bus}", station=helm)
        helm_url = f"tcp://{HERE}:{helm}"
        async with running(text), a_peer(bus, "ydraw") as (_, heard), Station.open(helm_url, station=1) as station:
            await station.take()
            await station.disengage()
            await until(lambda: any(message.PGN == 127237 for message in heard), "the order to let go")

    asyncio.run(scene())
