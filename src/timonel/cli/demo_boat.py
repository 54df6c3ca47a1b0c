"""The boat of `timonel demo`."""

import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from timonel.cli.demo import HERE, Demo
from timonel.cli.view import LiveView
from timonel.core.effects import Effect, Say
from timonel.core.frame import Frame
from timonel.gateway.configuration import Configuration, Output, Station
from timonel.nmea0183 import parp
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.simulator import SimulatedBoat

PORT = 10110
PALMA = (39.55, 2.63)


def prepare(directory: Path, port: int | None, seed: int) -> Demo:
    """A boat off Palma with three helm stations; see `timonel.cli.demo.Prepare`."""
    port = port or PORT
    configuration = configure(directory, port)
    return Demo(
        configuration=configuration,
        simulated=SimulatedBoat(seed, start=time.time(), destination=PALMA),
        ports=(port, port + 4),
        hints=how_to_connect(configuration),
        lines=Lines(),
        view=partial(LiveView, title="timonel demo"),
    )


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
        bus_url="loop://demo",
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


class Lines:
    """An observer that prints what the stations hear."""

    def frames_received(self, frames: Sequence[Frame], now: float) -> None:
        """Not shown."""

    def effect(self, effect: Effect, now: float) -> None:
        if isinstance(effect, Say):
            print(effect.line.decode("ascii").rstrip(), flush=True)

    def port(self, name: str, connected: bool, now: float) -> None:
        """The log tells."""
