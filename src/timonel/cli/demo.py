"""`timonel demo`: the gateway on a simulated boat, for whoever wants to see it work."""

import asyncio
import logging
import os
import socket
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from stat import S_ISDIR

import click
from rich.console import Console

from timonel.cli.view import LiveView
from timonel.core.effects import Effect, Say
from timonel.core.frame import Frame
from timonel.errors import LinkError
from timonel.gateway import log
from timonel.gateway.assemble import assemble
from timonel.gateway.configuration import Configuration, Output, Station
from timonel.gateway.service import serve
from timonel.gateway.simulation import Simulation
from timonel.links.urls import bus_link
from timonel.nmea0183 import parp
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.simulator import SimulatedBoat

BUS = "loop://demo"
HERE = "127.0.0.1"
PORTS = range(1, 65532)  # station 4 listens four above
PALMA = (39.55, 2.63)


@click.command()
@click.option("--seed", default=1, show_default=True, help="Another seed is another sea.")
@click.option("--speed", default=1.0, show_default=True, type=click.FloatRange(0.1, 20), help="Times the boat's own time.")
@click.option("--no-view", is_flag=True, help="Print what is said to the stations instead of the live view.")
@click.option("--directory", type=click.Path(path_type=Path), help="Where the pseudo-terminals of the stations are.")
@click.option("--port", default=10110, show_default=True, type=click.IntRange(PORTS[0], PORTS[-1]), help="TCP port for listeners; station 4 has the fourth after it.")
def demo(seed: int, speed: float, no_view: bool, directory: Path | None, port: int) -> None:
    """Run the gateway on a simulated boat, until Ctrl-C.

    Plotters and gpsd listen on TCP; bridge, cockpit and flybridge have a pseudo-terminal each, station 4 a TCP port.
    """
    _check_free(port)
    _check_free(port + 4)
    configuration = configure(directory or _own_directory(), port)
    boat = SimulatedBoat(seed, start=time.time(), destination=PALMA)
    sys.exit(asyncio.run(_run(configuration, boat, speed, view=sys.stdout.isatty() and not no_view)))


def configure(directory: Path, port: int) -> Configuration:
    """The demo's gateway."""
    stations = [
        _station(number, name, f"pty://{directory / name.lower()}")
        for number, name in enumerate(("Bridge", "Cockpit", "Flybridge"), 1)
    ]
    stations.append(_station(4, "Reserve", f"tcp-listen://{HERE}:{port + 4}"))
    return Configuration(
        file="demo",
        vehicle=BoatSettings(name="demo"),
        bus_url=BUS,
        stations=tuple(stations),
        outputs=(Output("Listeners", f"tcp-listen://{HERE}:{port}"),),
    )


def _station(number: int, name: str, url: str) -> Station:
    return Station(Port(name, number), url, url)


def how_to_connect(directory: Path, port: int) -> list[str]:
    """What to type in a second terminal."""
    bridge = directory / "bridge"
    take = parp.command(parp.Verb.TAKECMD, 1).decode().strip()
    return [
        f"listen   OpenCPN: network connection, TCP, {HERE} port {port};  gpsd -N tcp://{HERE}:{port}",
        f"steer    timonel station serial://{bridge} --id 1    (t takes command, a engages, arrows turn)",
        f"         timonel station tcp://{HERE}:{port + 4} --id 4    (r requests command)",
        f"by hand  printf '{take}\\r\\n' > {bridge}",
    ]


async def _run(configuration: Configuration, boat: SimulatedBoat, speed: float, *, view: bool) -> int:
    gateway = assemble(configuration)
    async with Simulation(boat, bus_link(BUS, name="boat"), speed):
        if not view:
            gateway.observers.append(Lines())
            log.start("info")
            return await serve(gateway)
        ...


class Lines:
    """An observer that prints what the stations hear."""

    def frames_received(self, frames: Sequence[Frame], now: float) -> None:
        """Not shown."""

    def effect(self, effect: Effect, now: float) -> None:
        if isinstance(effect, Say):
            print(effect.line.decode("ascii").rstrip(), flush=True)

    def port(self, name: str, connected: bool, now: float) -> None:
        """The log tells."""
