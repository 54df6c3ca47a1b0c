"""`timonel run`: the gateway."""

import asyncio
import sys

import click

from timonel.cli.console import console
from timonel.gateway import log
from timonel.gateway.assemble import assemble
from timonel.gateway.configuration import Configuration, load
from timonel.gateway.recording import recorded
from timonel.gateway.service import serve


@click.command()
@click.argument("configuration", type=click.Path())
def run(configuration: str) -> None:
    """Run the gateway that CONFIGURATION (boat.toml, rover.toml) describes, until SIGTERM or Ctrl-C.

    The log goes to standard error: text on a terminal, else one JSON object a line. SIGUSR1 logs all counters.
    """
    loaded = load(configuration)
    log.start(loaded.log)
    sys.exit(asyncio.run(_run(loaded)))


async def _run(configuration: Configuration) -> int:
    gateway = assemble(configuration)
    async with recorded(gateway, configuration), console(gateway, configuration):
        return await serve(gateway)
