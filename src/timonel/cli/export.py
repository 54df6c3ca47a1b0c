"""`timonel export`: the rover's frames for the tools of others."""

from typing import TextIO

import click

from timonel.gateway import own_frames
from timonel.interop import dbc
from timonel.vehicles.rover import reference
from timonel.vehicles.rover.calibration import CALIBRATIONS

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
    text = KINDS[what](own_frames.protocol(config, frames, calibration))
    output.write(text)
