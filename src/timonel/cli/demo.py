"""`timonel demo`: the gateway on a simulated vehicle, for whoever wants to see it work."""

import asyncio
import os
import socket
import sys
import tempfile
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from importlib import import_module
from pathlib import Path
from stat import S_ISDIR
from typing import Protocol, cast

import click
import msgspec
from rich.console import Console

from timonel.errors import LinkError
from timonel.gateway import log
from timonel.gateway.assemble import assemble
from timonel.gateway.configuration import Configuration
from timonel.gateway.gateway import Observer
from timonel.gateway.service import serve
from timonel.gateway.simulation import Simulated, Simulation
from timonel.links.urls import bus_link

HERE = "127.0.0.1"
DEMOS = {"boat": "timonel.cli.demo_boat:prepare", "rover": "timonel.cli.demo_rover:prepare"}
PORT = click.IntRange(1, 65531)  # the boat's station 4 listens four above
SPEED = click.FloatRange(0.1, 20)


class View(Observer, Protocol):
    """An observer with a screen."""

    async def show(self, console: Console) -> None:
        """Draw until cancelled."""


class Demo(msgspec.Struct, frozen=True):
    """A vehicle to be shown: `ports` are the TCP ports that it takes, `hints` what to type in a second terminal.

    `lines` prints what happens, `view` makes the screen.
    """

    configuration: Configuration
    simulated: Simulated
    ports: tuple[int, ...]
    hints: Sequence[str]
    lines: Observer
    view: Callable[[], View]


Prepare = Callable[[Path, int | None, int], Demo]
"""Makes a demo of the directory for its pseudo-terminals, the first TCP port (None: its own) and the seed."""


@click.command()
@click.argument("vehicle", type=click.Choice(list(DEMOS)), default="boat")
@click.option("--seed", default=1, show_default=True, help="Another seed is another sea, or another ground.")
@click.option("--speed", default=1.0, show_default=True, type=SPEED, help="How fast time passes for the vehicle.")
@click.option("--no-view", is_flag=True, help="Print what happens instead of the live view.")
@click.option("--directory", type=click.Path(path_type=Path), help="Where the pseudo-terminals of the stations are.")
@click.option("--port", type=PORT, help="TCP: the boat's listeners (10110; four above, station 4), or the rover's "
              "operator (5001; one above, the Jetson).")  # fmt: skip
def demo(vehicle: str, seed: int, speed: float, no_view: bool, directory: Path | None, port: int | None) -> None:
    """Run the gateway on a simulated VEHICLE, until Ctrl-C: the boat, or the rover.

    The boat has a pseudo-terminal for bridge, cockpit and flybridge, a TCP port for station 4 and one for listeners;
    the rover a TCP port for the operator and one for the Jetson, and a pseudo-terminal for station 3.
    """
    module, _, name = DEMOS[vehicle].partition(":")
    directory = directory or _own_directory()
    shown = cast(Prepare, getattr(import_module(module), name))(directory, port, seed)
    for number in shown.ports:
        _check_free(number)
    directory.mkdir(parents=True, exist_ok=True)
    console = Console() if sys.stdout.isatty() and not no_view else None
    with ExitStack() as stack:
        log.start("info", sys.stderr if console is None else stack.enter_context(open(directory / "demo.log", "w")))
        status = asyncio.run(_run(shown, speed, console))
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


async def _run(demo: Demo, speed: float, console: Console | None) -> int:
    """Move until told to stop; with a `console` there is something to see."""
    gateway = assemble(demo.configuration)
    async with Simulation(demo.simulated, bus_link(demo.configuration.bus_url, name="simulated"), speed):
        if console is None:
            click.echo("\n".join(demo.hints), err=True)
            gateway.observers.append(demo.lines)
            return await serve(gateway)
        view = demo.view()
        gateway.observers.append(view)
        showing = asyncio.get_running_loop().create_task(view.show(console))
        status = await serve(gateway)
        showing.cancel()
        with suppress(asyncio.CancelledError):
            await showing
        return status
