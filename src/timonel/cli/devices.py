"""`timonel devices`: who is on an NMEA 2000 bus."""

import asyncio
from pathlib import Path

import click
import msgspec
from rich.table import Table

from timonel.cli import report
from timonel.core.effects import Effect, Transmit
from timonel.core.frame import Frame
from timonel.errors import LinkError
from timonel.gateway.configuration import load
from timonel.gateway.devices import DeviceShown, roll
from timonel.gateway.identity import SILENT, unique_number
from timonel.gateway.playback import Playback
from timonel.links.urls import bus_link
from timonel.nmea2000.claim import CLAIM, AddressClaimed
from timonel.nmea2000.identifier import NULL, split
from timonel.nmea2000.node import CONFIGURATION, PRODUCT, NodeSettings
from timonel.vehicles.boat.settings import BoatSettings
from timonel.vehicles.boat.vehicle import Boat

TICK = 0.05  # s
ADDRESS = 250  # tried first: seldom taken


@click.command()
@click.argument("source", metavar="URL|CONFIGURATION|RECORDING")
@click.option("--json", "as_json", is_flag=True, help="For programs: one line of JSON a device.")
@click.option(
    "--seconds", type=click.FloatRange(1.0, 3600.0), default=5.0, show_default=True, help="How long to listen."
)
def devices(source: str, as_json: bool, seconds: float) -> None:
    """Tell who is on the bus at a URL (socketcan://can0), on that of a CONFIGURATION (boat.toml), or in a RECORDING.

    On a bus it claims an address and asks everybody; a recording is only read.
    """
    found = heard(source, seconds)
    if as_json:
        for device in found:
            click.echo(msgspec.json.encode(device))
    else:
        report.console().print(table(found))


def heard(source: str, seconds: float) -> list[DeviceShown]:
    """Who is on a bus, given as for `timonel devices`. Raises LinkError."""
    url = load(source).bus_url if source.endswith(".toml") else source
    if "://" not in url:
        return _recorded(url)
    if url.partition("://")[0] in SILENT:
        return _recorded(url.partition("://")[2].partition("?")[0])
    return asyncio.run(_asked(url, seconds))


class Ear:
    """A boat's machine that nobody steers: it keeps the table of devices, and as a node it asks them."""

    def __init__(self, node: NodeSettings | None, address: int, now: float) -> None:
        self.boat = Boat(BoatSettings(node=node, address=address, variation_model=False), [], now)
        self._spoke: set[int] = set()

    def hear(self, frames: list[Frame], now: float) -> list[Effect]:
        self._spoke.update(split(frame.identifier).source for frame in frames if frame.extended)
        return self.boat.receive_frames(frames, now)

    def roll(self, now: float) -> list[DeviceShown]:
        named = {device.address for device in self.boat.devices} | {self.boat.node.address, NULL, NULL + 1}
        return roll(self.boat.devices, now, self.boat.node, sorted(self._spoke - named))


def _recorded(path: str) -> list[DeviceShown]:
    ear, now = Ear(None, NULL, 0.0), 0.0
    for entry in Playback(Path(path), bus=True, allow_commands=True).entries():
        now = max(now, entry.now)
        ear.hear(entry.frames, now)
    return ear.roll(now)


async def _asked(url: str, seconds: float) -> list[DeviceShown]:
    """Be a device of the bus for so long. Raises LinkError for a bus that is not there."""
    loop = asyncio.get_running_loop()
    bus = bus_link(url, name="bus")
    ear = Ear(
        NodeSettings(unique_number=unique_number("timonel devices"), model="timonel devices"), ADDRESS, loop.time()
    )
    troubles: list[str] = []

    def carry_out(effects: list[Effect]) -> None:
        frames = [effect.frame for effect in effects if isinstance(effect, Transmit)]
        if any(isinstance(effect, AddressClaimed) for effect in effects):
            asked = [effect for pgn in (CLAIM, PRODUCT, CONFIGURATION) for effect in ear.boat.node.ask(pgn)]
            frames += [effect.frame for effect in asked if isinstance(effect, Transmit)]
        if frames:
            bus.send(frames)

    def changed(connected: bool, reason: str) -> None:
        troubles[:] = [] if connected else [reason]

    await bus.open(lambda frames: carry_out(ear.hear(frames, loop.time())), changed)
    try:
        end = loop.time() + seconds
        while loop.time() < end:
            if loop.time() >= ear.boat.deadline:
                carry_out(ear.boat.expire(loop.time()))
            await asyncio.sleep(TICK)
    finally:
        await bus.close()
    if troubles:
        raise LinkError(f"{url}: {troubles[0]}")
    return ear.roll(loop.time())


COLUMNS = (
    "address", "maker", "model", "software", "serial number", "class", "function", "instance", "installed", "heard for",
    "NAME",
)  # fmt: skip


def table(found: list[DeviceShown]) -> Table:
    """One row a device."""
    return report.table(COLUMNS, map(_row, found))


def _row(device: DeviceShown) -> list[str]:
    address = "none" if device.address is None else str(device.address)
    instance = "" if device.instance is None else f"{device.instance}/{device.system_instance}"
    return [
        f"{address} (us)" if device.ours else address,
        *(
            text or ""
            for text in (
                device.maker,
                device.model,
                device.software,
                device.serial,
                device.device_class,
                device.function,
                instance,
                device.installation,
            )
        ),
        "" if device.seconds is None else report.span(round(device.seconds)).replace(".000 s", " s"),
        device.name or "",
    ]
