"""The boat of `timonel demo`."""

import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import click
from msgspec.structs import replace

from timonel.cli.demo import HERE, Demo
from timonel.cli.view import LiveView
from timonel.core.effects import Effect, Say
from timonel.core.frame import Frame
from timonel.gateway.configuration import Configuration
from timonel.gateway.identity import settle
from timonel.gateway.link_settings import Output, Station
from timonel.gateway.signalk_settings import SignalK
from timonel.nmea0183 import parp
from timonel.vehicles.boat.alert_settings import AlertSettings
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.simulated_pilots import DIALECTS
from timonel.vehicles.boat.simulator import SimulatedBoat

PORT = 10110
PALMA = (39.55, 2.63)
PILOTS = ("standard", *(name for name in DIALECTS if name != "sentence"))  # that one has a wire of its own


def prepare(directory: Path, port: int | None, seed: int) -> Demo:
    """A boat off Palma with three helm stations; see `timonel.cli.demo.Prepare`."""
    port = port or PORT
    configuration = configure(directory, port)
    return Demo(
        configuration=configuration,
        simulated=SimulatedBoat(seed, start=time.time(), destination=PALMA),
        ports=(port, port + 1, port + 2, port + 4),
        hints=how_to_connect(configuration),
        lines=Lines(),
        view=partial(LiveView, title="timonel demo"),
    )


def with_pilot(demo: Demo, pilot: str, seed: int) -> Demo:
    """A boat whose pilot obeys what the driver `pilot` says, and nothing else."""
    if pilot not in PILOTS:
        known = ", ".join(PILOTS)
        raise click.BadParameter(
            f"{pilot!r} has no simulated pilot here; there is one for {known}", param_hint="--pilot"
        )
    if pilot == "standard":
        return demo
    simulated = SimulatedBoat(seed, start=time.time(), destination=PALMA, dialect=DIALECTS[pilot]())
    vehicle = replace(demo.configuration.vehicle, pilot=pilot)
    return replace(demo, configuration=replace(demo.configuration, vehicle=vehicle), simulated=simulated)


def configure(directory: Path, port: int) -> Configuration:
    """The demo's gateway."""
    stations = [
        _station(number, name, f"pty://{directory / name.lower()}")
        for number, name in enumerate(("Bridge", "Cockpit", "Flybridge"), 1)
    ]
    stations.append(_station(4, "Reserve", f"tcp-listen://{HERE}:{port + 4}"))
    return Configuration(
        file="demo",
        vehicle=BoatSettings(name="demo", alerts=AlertSettings(), node=settle({}, "demo")),
        bus_url="loop://demo",
        stations=tuple(stations),
        outputs=(
            Output("Listeners", f"tcp-listen://{HERE}:{port}"),
            Output("Frames", f"tcp-listen://{HERE}:{port + 1}", "ydraw", transmit=True),
        ),
        signalk=SignalK(tcp=f"tcp-listen://{HERE}:{port + 2}"),
    )


def _station(number: int, name: str, url: str) -> Station:
    return Station(Port(name, number), url, url)


def how_to_connect(configuration: Configuration) -> list[str]:
    """What to type in a second terminal."""
    bridge = str(configuration.stations[0].send_url).removeprefix("pty://")
    reserve = str(configuration.stations[-1].send_url).removeprefix("tcp-listen://")
    listeners, frames = (output.url.removeprefix("tcp-listen://") for output in configuration.outputs)
    deltas = configuration.signalk.tcp if configuration.signalk is not None else None
    take = parp.command(parp.Verb.TAKECMD, 1).decode().strip()
    return [
        f"listen   OpenCPN: TCP, {listeners};  gpsd -N tcp://{listeners}",
        f"         YD RAW: TCP, {frames};  Signal K: TCP, {str(deltas).removeprefix('tcp-listen://')}",
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
