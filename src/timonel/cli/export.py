"""`timonel export`: the rover's frames for the tools of others."""

from typing import TextIO

import click

from timonel.gateway import own_frames
from timonel.gateway.configuration import load
from timonel.interop import dbc
from timonel.vehicles.rover import reference
from timonel.vehicles.rover.calibration import CALIBRATIONS
from timonel.vehicles.rover.protocol import Protocol

KINDS = {"dbc": dbc.export, "markdown": reference.page}


@click.command()
@click.argument("what", type=click.Choice(list(KINDS)))
@click.option(
    "-o", "--output", type=click.File("w", encoding="utf-8"), default="-", help="Where to; - is standard output."
)
@click.option("--config", type=click.Path(), help="A rover.toml whose calibration and own frames are used.")
@click.option("--frames", type=click.Path(), help="A TOML or Python file with frames of one's own.")
@click.option("--calibration", type=click.Choice(list(CALIBRATIONS)), help="Whose constants; physical if not given.")
def export(what: str, output: TextIO, config: str | None, frames: str | None, calibration: str | None) -> None:
    """Write the layout of the rover's frames: as a DBC file, which CAN tools read, or as a page of tables.

    From a DBC file frames of more than 8 bytes are left out; a comment in it names them.
    """
    protocol = configured(config) if config else Protocol()
    own = own_frames.load(frames) if frames else protocol.own
    constants = CALIBRATIONS[calibration] if calibration else protocol.calibration
    text = KINDS[what](Protocol(constants, own))
    output.write(text)


def configured(config: str) -> Protocol:
    """The protocol of the rover that a configuration describes."""
    protocol = load(config).protocol
    if protocol is None:
        raise click.UsageError(f"{config} describes no rover")
    return protocol
