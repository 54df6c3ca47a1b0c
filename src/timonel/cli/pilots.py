"""`timonel pilots`: which pilots can be steered, how we know, and which of them a bus has."""

from collections.abc import Iterator

import click
import msgspec

from timonel.cli import devices as bus
from timonel.cli import report
from timonel.gateway.devices import DeviceShown
from timonel.nmea2000.devices import Device
from timonel.nmea2000.identifier import NULL
from timonel.nmea2000.messages.network import IsoAddressClaim, ProductInformation
from timonel.vehicles.boat.pilots import KINDS, Kind, finder_of
from timonel.vehicles.boat.pilots.finder import is_autopilot
from timonel.vehicles.boat.settings import BoatSettings

COLUMNS = ("pilot =", "steers", "evidence", "course", "counted from", "sends", "confirmed by", "known from")
FOUND = ("address", "maker", "model", "software", "steered with", "pilot_name =")


class Found(msgspec.Struct, frozen=True):
    """A pilot on the bus, and the drivers that take it for theirs."""

    device: DeviceShown
    drivers: list[str]


@click.command()
@click.argument("source", metavar="[URL|CONFIGURATION|RECORDING]", required=False)
@click.option("--json", "as_json", is_flag=True, help="For programs: one line of JSON a driver, or a pilot found.")
@click.option(
    "--seconds", type=click.FloatRange(1.0, 3600.0), default=5.0, show_default=True, help="How long to listen."
)
def pilots(source: str | None, as_json: bool, seconds: float) -> None:
    """Tell which drivers there are and how it is known what they send; with a bus, which pilots are on it.

    A bus is given as for `timonel devices`. A driver is chosen with `pilot` in the configuration's [vehicle].
    """
    if source is None:
        _show_kinds(as_json)
        return
    found = list(_found(bus.heard(source, seconds)))
    if as_json:
        for one in found:
            click.echo(msgspec.json.encode(one))
    elif found:
        report.console().print(report.table(FOUND, map(_row, found)))
    else:
        click.echo("no device says that it is an autopilot")


def _show_kinds(as_json: bool) -> None:
    if as_json:
        for kind in KINDS.values():
            click.echo(msgspec.json.encode(kind))
        return
    report.console().print(report.table(COLUMNS, map(_kind_row, KINDS.values())))
    click.echo("\nNo driver was ever tried on a real pilot by us. All but `standard` are off until they are chosen.")


def _kind_row(kind: Kind) -> list[str]:
    course = "commanded" if kind.absolute else "in steps"
    if kind.adopts:
        course += "; its own when engaged"
    return [
        kind.name,
        kind.steers,
        kind.evidence,
        course,
        kind.references,
        kind.sends,
        kind.confirmed_by,
        kind.sources,
    ]


def _found(shown: list[DeviceShown]) -> Iterator[Found]:
    """The devices that say to be autopilots, and those that stand before one."""
    for row in shown:
        if row.name is None or row.ours:
            continue
        device = _device(row)
        drivers = [name for name in KINDS if name != "sentence" and _fits(name, device)]
        if is_autopilot(device) or drivers:
            yield Found(row, drivers)


def _fits(driver: str, device: Device) -> bool:
    return bool(finder_of(BoatSettings(pilot=driver), [device]).candidates)  # type: ignore[arg-type]


def _device(row: DeviceShown) -> Device:
    name = int(row.name or "0", 16)
    claim = IsoAddressClaim.decode(name.to_bytes(8, "little"))
    product = msgspec.structs.replace(
        ProductInformation.decode(b""), model_id=row.model, software_version_code=row.software
    )
    return Device(name, NULL if row.address is None else row.address, claim, 0.0, 0.0, product)


def _row(found: Found) -> list[str]:
    device = found.device
    return [
        "none" if device.address is None else str(device.address),
        device.maker or "",
        device.model or "",
        device.software or "",
        ", ".join(found.drivers),
        f'"0x{device.name}"',
    ]
