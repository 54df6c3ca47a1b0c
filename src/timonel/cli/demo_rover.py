"""The rover of `timonel demo`."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from timonel.cli.demo import HERE, Demo
from timonel.cli.rover_view import RoverView
from timonel.core.effects import Effect, Event
from timonel.core.frame import Frame
from timonel.gateway.configuration import Configuration
from timonel.gateway.health import describe
from timonel.gateway.link_settings import Station
from timonel.vehicles.boat.settings import Port
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.settings import RoverSettings
from timonel.vehicles.rover.simulator import SimulatedRover

PORT = 5001


def prepare(directory: Path, port: int | None, seed: int) -> Demo:
    """A rover with its operator, its Jetson and a pseudo-terminal; see `timonel.cli.demo.Prepare`."""
    port = port or PORT
    protocol = Protocol()
    configuration = configure(directory, port, protocol)
    return Demo(
        configuration=configuration,
        simulated=SimulatedRover(seed),
        ports=(port, port + 1),
        hints=how_to_connect(configuration),
        lines=Happenings(),
        view=partial(RoverView, protocol, title="timonel demo rover"),
    )


def configure(directory: Path, port: int, protocol: Protocol) -> Configuration:
    """The demo's controller."""
    urls = {
        "Operator": f"tcp-listen://{HERE}:{port}",
        "Jetson": f"tcp-listen://{HERE}:{port + 1}",
        "UART": f"pty://{directory / 'rover'}",
    }
    stations = [Station(Port(name, number), url, url) for number, (name, url) in enumerate(urls.items(), 1)]
    return Configuration(
        file="demo",
        vehicle=RoverSettings(name="demo"),
        bus_url="loop://demo",
        stations=tuple(stations),
        protocol=protocol,
    )


def how_to_connect(configuration: Configuration) -> list[str]:
    """What to type in a second terminal."""
    operator, jetson, uart = (str(station.send_url).partition("://")[2] for station in configuration.stations)
    return [
        f"drive    timonel drive tcp://{operator}",
        f"         timonel drive tcp://{jetson} --station 2",
        f"         timonel drive serial://{uart} --station 3",
        "keys     e enables, hold an arrow to drive, space stops, q leaves",
    ]


class Happenings:
    """An observer that prints who commands, who may drive, and alerts."""

    def frames_received(self, frames: Sequence[Frame], now: float) -> None:
        """Not shown."""

    def effect(self, effect: Effect, now: float) -> None:
        if isinstance(effect, Event):
            print(describe(effect), flush=True)

    def port(self, name: str, connected: bool, now: float) -> None:
        """The log tells."""
