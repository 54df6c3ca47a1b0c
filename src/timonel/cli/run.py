"""`timonel run`: the gateway."""

import asyncio
import sys

import click

from timonel.cli.console import console
from timonel.cli.mqtt import broker
from timonel.gateway import log
from timonel.gateway.address_memory import remember, remembered
from timonel.gateway.assemble import assemble
from timonel.gateway.configuration import Configuration, load
from timonel.gateway.mdns import announced
from timonel.gateway.recording import recorded
from timonel.gateway.service import serve
from timonel.gateway.signalk import signalk


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
    configured, configuration = configuration, remembered(configuration)
    gateway = assemble(configuration)
    remember(gateway, configured)
    async with (
        recorded(gateway, configuration),
        console(gateway, configuration),
        broker(gateway, configuration),
        signalk(gateway, configuration),
        announced(configuration),
    ):
        return await serve(gateway)
