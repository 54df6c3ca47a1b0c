"""The MQTT broker beside a gateway, for the programs that run one; nothing of it is loaded where it is not wanted."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from timonel.gateway.configuration import Configuration
from timonel.gateway.gateway import Gateway


@asynccontextmanager
async def broker(gateway: Gateway, configuration: Configuration) -> AsyncIterator[None]:
    """While it is entered, a broker is told how the vehicle is, if the configuration wants that."""
    if configuration.mqtt is None:
        yield
        return
    from timonel.web.broker import published

    async with published(gateway, configuration):
        yield
