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
from msgspec.structs import replace
from rich.console import Console

from timonel.cli.console import console as serving_console
from timonel.cli.mqtt import broker
from timonel.core.mistakes import Mistakes
from timonel.errors import LinkError
from timonel.gateway import log
from timonel.gateway.assemble import assemble
from timonel.gateway.broker import settle
from timonel.gateway.configuration import Configuration
from timonel.gateway.extras import recorder_installed, web_installed
from timonel.gateway.gateway import Observer
from timonel.gateway.recording import recorded
from timonel.gateway.recording_settings import RECORDINGS, Recording
from timonel.gateway.service import serve
from timonel.gateway.signalk import signalk
from timonel.gateway.simulation import Simulated, Simulation
from timonel.gateway.web_settings import Web
from timonel.links.urls import bus_link
from timonel.vehicles.boat.settings import BoatSettings

HERE = "127.0.0.1"
DEMOS = {"boat": "timonel.cli.demo_boat:prepare", "rover": "timonel.cli.demo_rover:prepare"}
PORT = click.IntRange(1, 65531)  # the boat's station 4 listens four above
WEB_PORT = 8080
BUDGET = 50_000_000  # bytes of recordings that a demo leaves behind; its directory may be in memory
SPEED = click.FloatRange(0.1, 20)


class View(Observer, Protocol):
    """An observer with a screen."""

    async def show(self, console: Console) -> None:
        """Draw until cancelled."""


class Demo(msgspec.Struct, frozen=True):
    """A vehicle to be shown: `ports` are the TCP ports that it takes, `hints` what to type in a second terminal.

    `lines` prints what happens, `view` makes the screen, with hints on it.
    """

    configuration: Configuration
    simulated: Simulated
    ports: tuple[int, ...]
    hints: Sequence[str]
    lines: Observer
    view: Callable[[Sequence[str]], View]


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
@click.option(
    "--web-port", type=click.IntRange(1, 65535), help="Where the console is served (8080, or one that is free)."
)
@click.option("--no-web", is_flag=True, help="Leave the console off.")
@click.option("--pilot", metavar="DRIVER", help="What the boat's pilot obeys: raymarine, navico ... (timonel pilots).")
@click.option("--mqtt", metavar="URL", help="Tell a broker too, like mqtt://127.0.0.1:1883.")
@click.option("--no-recording", is_flag=True, help="Leave the flight recorder off.")
def demo(
    vehicle: str,
    seed: int,
    speed: float,
    no_view: bool,
    directory: Path | None,
    port: int | None,
    web_port: int | None,
    no_web: bool,
    pilot: str | None,
    mqtt: str | None,
    no_recording: bool,
) -> None:
    """Run the gateway on a simulated VEHICLE, until Ctrl-C: the boat, or the rover.

    The boat has a pseudo-terminal for bridge, cockpit and flybridge, a TCP port for station 4 and one for listeners;
    the rover a TCP port for the operator and one for the Jetson, and a pseudo-terminal for station 3.
    """
    module, _, name = DEMOS[vehicle].partition(":")
    directory = directory or _own_directory()
    shown = cast(Prepare, getattr(import_module(module), name))(directory, port, seed)
    if pilot is not None:
        shown = with_pilot(shown, pilot, seed)
    if not no_recording:
        shown = with_recording(shown, directory / RECORDINGS)
    if not no_web:
        shown = with_console(shown, web_port)
    if mqtt is not None:
        shown = with_broker(shown, mqtt)
    for number in shown.ports:
        _check_free(number)
    directory.mkdir(parents=True, exist_ok=True)
    console = Console() if sys.stdout.isatty() and not no_view else None
    with ExitStack() as stack:
        log.start("info", sys.stderr if console is None else stack.enter_context(open(directory / "demo.log", "w")))
        status = asyncio.run(_run(shown, speed, seed, console))
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


def with_console(demo: Demo, port: int | None) -> Demo:
    """The demo with the console on, and its address as the first hint. Raises LinkError for a port that is taken."""
    if not web_installed():
        return replace(demo, hints=["console  pip install timonel[web], and there is one in the browser", *demo.hints])
    if port is None:
        port = WEB_PORT if _is_free(WEB_PORT) else _some_port()
    elif not _is_free(port):
        raise LinkError(f"{HERE}:{port}: taken already; --web-port takes another one")
    hint = f"console  http://{HERE}:{port}/"
    return replace(demo, configuration=replace(demo.configuration, web=Web(HERE, port)), hints=[hint, *demo.hints])


def with_pilot(demo: Demo, pilot: str, seed: int) -> Demo:
    """The demo with a simulated pilot that has words of its own, and the driver for it."""
    if not isinstance(demo.configuration.vehicle, BoatSettings):
        raise click.BadParameter("only the boat has a pilot", param_hint="--pilot")
    shown: Demo = import_module("timonel.cli.demo_boat").with_pilot(demo, pilot, seed)
    return shown


def with_broker(demo: Demo, url: str) -> Demo:
    """The demo with a broker that is told. Raises ConfigError."""
    mistakes = Mistakes("demo", "")
    settings = settle({"url": url}, demo.configuration.vehicle.name, Path(), mistakes.add)
    if mistakes:
        raise mistakes.error()
    return replace(demo, configuration=replace(demo.configuration, mqtt=settings))


def _is_free(port: int) -> bool:
    try:
        socket.create_server((HERE, port)).close()
    except OSError:
        return False
    return True


def _some_port() -> int:
    with socket.create_server((HERE, 0)) as server:
        return int(server.getsockname()[1])


def with_recording(demo: Demo, directory: Path) -> Demo:
    """The demo with the flight recorder on, and a hint how to look at what it writes."""
    if not recorder_installed():
        return replace(demo, hints=[*demo.hints, "record   pip install timonel[recording], and this is recorded"])
    recording = Recording(str(directory), segment_size=BUDGET // 5, budget=BUDGET)
    hint = f"record   timonel replay --verify {directory}"
    return replace(demo, configuration=replace(demo.configuration, recording=recording), hints=[*demo.hints, hint])


async def _run(demo: Demo, speed: float, seed: int, console: Console | None) -> int:
    """Move until told to stop; with a `console` there is something to see."""
    gateway = assemble(demo.configuration)
    async with (
        Simulation(demo.simulated, bus_link(demo.configuration.bus_url, name="simulated"), speed),
        recorded(gateway, demo.configuration, simulated=True, seed=seed),
        serving_console(gateway, demo.configuration),
        broker(gateway, demo.configuration),
        signalk(gateway, demo.configuration),
    ):
        if console is None:
            click.echo("\n".join(demo.hints), err=True)
            gateway.observers.append(demo.lines)
            return await serve(gateway)
        view = demo.view(demo.hints)
        gateway.observers.append(view)
        showing = asyncio.get_running_loop().create_task(view.show(console))
        status = await serve(gateway)
        showing.cancel()
        with suppress(asyncio.CancelledError):
            await showing
        return status
