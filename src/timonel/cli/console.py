"""The console beside a gateway, for the programs that run one; nothing of it is loaded where it is not wanted."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from timonel.gateway.configuration import Configuration
from timonel.gateway.gateway import Gateway


@asynccontextmanager
async def console(gateway: Gateway, configuration: Configuration) -> AsyncIterator[str | None]:
    """While it is entered, the console is served at this address, if the configuration wants one. Raises LinkError."""
    if configuration.web is None:
        yield None
        return
    from timonel.web.server import served

    async with served(gateway, configuration) as url:
        yield url
