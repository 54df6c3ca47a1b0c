"""The gateway as `timonel run` makes it, on a pair of sockets in place of the CAN interface."""

import asyncio
import logging
import socket
from collections.abc import Mapping
from multiprocessing.connection import Connection
from typing import Any

import msgspec

from benchmarks.processes import resident_mib
from benchmarks.traffic import settings
from timonel.cli.console import console
from timonel.gateway.assemble import boat
from timonel.gateway.configuration import Configuration
from timonel.gateway.gateway import Channel, Gateway
from timonel.gateway.web_settings import Web
from timonel.links.link import BusLink
from timonel.links.pty import PtyLink
from timonel.links.socketcan import SocketCanLink
from timonel.links.tcp_listen import TcpListenLink
from timonel.vehicles.boat.settings import BoatSettings, Port

HERE = "127.0.0.1"
ANY_PORT = 0


class Setup(msgspec.Struct, frozen=True):
    """A gateway to measure: how many sentences (ceilings in Hz), who listens, how data goes out, who looks."""

    rates: dict[str, float]
    terminals: int = 4
    clients: int = 8
    flush: float = 0.0
    consoles: int = 0


def bus_pair() -> tuple[socket.socket, socket.socket]:
    """Sockets that keep frames apart and block when full, as a raw CAN socket and its far end would be."""
    return socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)


def run_gateway(pipe: Connection, bus: int, directory: str, setup: Setup) -> None:
    """Orders: `("counters",)`."""
    asyncio.run(_run(pipe, bus, directory, setup))


async def _run(pipe: Connection, bus: int, directory: str, setup: Setup) -> None:
    # the loopback interface is up everywhere, and is not asked for anything else
    can = SocketCanLink("lo", make=lambda _: socket.socket(fileno=bus), name="bus")
    gateway, listeners = make(can, settings(setup.rates), directory, setup)
    await gateway.open()
    web = Web(HERE, ANY_PORT, stations=()) if setup.consoles else None
    async with console(gateway, Configuration("benchmark", settings(setup.rates), "", web=web)) as url:
        asyncio.get_running_loop().add_reader(pipe.fileno(), _answer, pipe, gateway)
        pipe.send((listeners.address, url))
        await gateway.failed.wait()


def make(bus: BusLink, boat_settings: BoatSettings, directory: str, setup: Setup) -> tuple[Gateway, TcpListenLink]:
    """The gateway on the running loop, and its port for listeners. Terminals are numbered in `directory`."""
    logging.disable()
    ports = [Port(f"Station {number}", number) for number in range(1, 1 + setup.terminals)]
    terminals = [PtyLink(f"{directory}/{port.station}", name=port.name) for port in ports]
    listeners = TcpListenLink(HERE, ANY_PORT, name="Listeners")
    channels = [Channel(link.name, link, link) for link in terminals] + [Channel("Listeners", None, listeners)]
    vehicle = boat(boat_settings, ports, asyncio.get_running_loop().time())
    return Gateway(vehicle, bus, channels, flush=setup.flush), listeners


def _answer(pipe: Connection, gateway: Gateway) -> None:
    pipe.recv()
    pipe.send(counters(gateway))


def counters(gateway: Gateway) -> Mapping[str, Any]:
    """What came in, and what of all outputs did not go out."""
    outputs = [link.counters for link in gateway.links if link is not gateway.bus]
    return {
        "frames": gateway.bus.counters.frames_in,
        "lost": sum(counter.dropped + counter.replaced for counter in outputs),
        "mib": resident_mib(),
    }
