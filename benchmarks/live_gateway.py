"""The gateway as `timonel run` makes it, on a pair of sockets in place of the CAN interface."""

import asyncio
import logging
import socket
import time
from collections.abc import Mapping, Sequence
from multiprocessing.connection import Connection
from typing import Any

import msgspec

from benchmarks.processes import quantiles, resident_mib
from benchmarks.traffic import settings
from timonel.cli.console import console
from timonel.core.effects import Say
from timonel.gateway.assemble import boat
from timonel.gateway.configuration import Configuration
from timonel.gateway.gateway import Channel, Gateway
from timonel.gateway.web_settings import Web
from timonel.links.fan import Fan
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
    """Orders: `("counters",)`; a gateway that is stamped answers with its latencies since the last order."""
    asyncio.run(_run(pipe, bus, directory, setup))


def run_stamped_gateway(pipe: Connection, bus: int, directory: str, setup: Setup) -> None:
    """As `run_gateway`, with a look at the clock at the two ends of the program itself."""
    asyncio.run(_run(pipe, bus, directory, setup, Inside()))


async def _run(pipe: Connection, bus: int, directory: str, setup: Setup, inside: "Inside | None" = None) -> None:
    # the loopback interface is up everywhere, and is not asked for anything else
    opened = StampedSocket if inside else socket.socket
    can = SocketCanLink("lo", make=lambda _: opened(fileno=bus), name="bus")
    gateway, listeners = make(can, settings(setup.rates), directory, setup)
    if inside is not None:
        inside.watch(gateway._fan)
    await gateway.open()
    web = Web(HERE, ANY_PORT, stations=()) if setup.consoles else None
    async with console(gateway, Configuration("benchmark", settings(setup.rates), "", web=web)) as url:
        asyncio.get_running_loop().add_reader(pipe.fileno(), _answer, pipe, gateway, inside)
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


class StampedSocket(socket.socket):
    """Notes when it was read last."""

    read = 0

    def recv(self, size: int, flags: int = 0) -> bytes:
        data = super().recv(size, flags)
        StampedSocket.read = time.monotonic_ns()
        return data


class Inside:
    """From a frame read to its sentence written to the last reader, in us."""

    def __init__(self) -> None:
        self.latencies: list[float] = []

    def watch(self, fan: Fan) -> None:
        send = fan.send

        def timed(lines: Sequence[Say]) -> None:
            send(lines)
            self.latencies.append((time.monotonic_ns() - StampedSocket.read) / 1000)

        fan.send = timed  # type: ignore[method-assign]


def _answer(pipe: Connection, gateway: Gateway, inside: Inside | None) -> None:
    pipe.recv()
    if inside is None:
        pipe.send(counters(gateway))
        return
    pipe.send(quantiles(inside.latencies))
    inside.latencies.clear()


def counters(gateway: Gateway) -> Mapping[str, Any]:
    """What came in, and what of all outputs did not go out."""
    outputs = [link.counters for link in gateway.links if link is not gateway.bus]
    return {
        "frames": gateway.bus.counters.frames_in,
        "lost": sum(counter.dropped + counter.replaced for counter in outputs),
        "mib": resident_mib(),
    }
