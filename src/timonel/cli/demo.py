"""`timonel demo`: the gateway on a simulated boat, for whoever wants to see it work."""

import asyncio
import os
import socket
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack, suppress
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
PORT = click.IntRange(1, 65531)  # station 4 listens four above
SPEED = click.FloatRange(0.1, 20)
PALMA = (39.55, 2.63)


@click.command()
@click.option("--seed", default=1, show_default=True, help="Another seed is another sea.")
@click.option("--speed", default=1.0, show_default=True, type=SPEED, help="How fast time passes for the boat.")
@click.option("--no-view", is_flag=True, help="Print what is said to the stations instead of the live view.")
@click.option("--directory", type=click.Path(path_type=Path), help="Where the pseudo-terminals of the stations are.")
@click.option("--port", default=10110, show_default=True, type=PORT, help="TCP for listeners; four above, station 4.")
def demo(seed: int, speed: float, no_view: bool, directory: Path | None, port: int) -> None:
    """Run the gateway on a simulated boat, until Ctrl-C.

    Plotters and gpsd listen on TCP; bridge, cockpit and flybridge have a pseudo-terminal each, station 4 a TCP port.
    """
    _check_free(port)
    _check_free(port + 4)
    directory = directory or _own_directory()
    directory.mkdir(parents=True, exist_ok=True)
    console = Console() if sys.stdout.isatty() and not no_view else None
    with ExitStack() as stack:
        log.start("info", sys.stderr if console is None else stack.enter_context(open(directory / "demo.log", "w")))
        boat = SimulatedBoat(seed, start=time.time(), destination=PALMA)
        status = asyncio.run(_run(configure(directory, port), boat, speed, console))
    sys.exit(status)


def _check_free(port: int) -> None:
    """Two demos would take each other's terminals away, so the second one is told now."""
    try:
        socket.create_server((HERE, port)).close()
    except OSError as fault:
        raise LinkError(f"{HERE}:{port}: {os.strerror(fault.errno or 0)}; --port takes another one") from fault


def _own_directory() -> Path:
    """A directory that only we can write to, so that nobody slips a terminal of theirs between us and a station."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    directory = Path(runtime, "timonel") if runtime else Path(tempfile.gettempdir(), f"timonel-{os.getuid()}")
    directory.mkdir(mode=0o700, parents=True, exist_ok=True)
    state = directory.lstat()
    if not S_ISDIR(state.st_mode) or state.st_uid != os.getuid() or state.st_mode & 0o022:
        raise LinkError(f"{directory} is not ours alone; --directory takes another one")
    return directory


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


def how_to_connect(configuration: Configuration) -> list[str]:
    """What to type in a second terminal."""
    bridge = str(configuration.stations[0].send_url).removeprefix("pty://")
    reserve = str(configuration.stations[-1].send_url).removeprefix("tcp-listen://")
    listeners = configuration.outputs[0].url.removeprefix("tcp-listen://")
    take = parp.command(parp.Verb.TAKECMD, 1).decode().strip()
    return [
        f"listen   OpenCPN: TCP, {listeners};  gpsd -N tcp://{listeners}",
        f"steer    timonel station serial://{bridge} --id 1",
        f"         timonel station tcp://{reserve} --id 4",
        "keys     t takes command, r requests it, a engages, arrows turn",
        f"by hand  echo '{take}' > {bridge}",
    ]


async def _run(configuration: Configuration, boat: SimulatedBoat, speed: float, console: Console | None) -> int:
    """Sail until told to stop; with a `console` there is something to see."""
    gateway = assemble(configuration)
    hints = how_to_connect(configuration)
    async with Simulation(boat, bus_link(BUS, name="boat"), speed):
        if console is None:
            click.echo("\n".join(hints), err=True)
            gateway.observers.append(Lines())
            return await serve(gateway)
        view = LiveView(hints, title="timonel demo")
        gateway.observers.append(view)
        showing = asyncio.get_running_loop().create_task(view.show(console))
        status = await serve(gateway)
        showing.cancel()
        with suppress(asyncio.CancelledError):
            await showing
        return status


class Lines:
    """An observer that prints what the stations hear."""

    def frames_received(self, frames: Sequence[Frame], now: float) -> None:
        """Not shown."""

    def effect(self, effect: Effect, now: float) -> None:
        if isinstance(effect, Say):
            print(effect.line.decode("ascii").rstrip(), flush=True)

    def port(self, name: str, connected: bool, now: float) -> None:
        """The log tells."""
