"""A gateway with its recorder, if its configuration wants one; without, nothing of the recorder is even loaded."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from timonel.gateway.configuration import Configuration
from timonel.gateway.gateway import Gateway


@asynccontextmanager
async def recorded(
    gateway: Gateway, configuration: Configuration, *, simulated: bool = False, seed: int | None = None
) -> AsyncIterator[None]:
    """While it is entered, `gateway` is recorded as its configuration wants.

    `simulated` and `seed` are noted: whether the vehicle is, and what its model was begun with. Raises ConfigError
    where the rover's own frames cannot be read any more.
    """
    if configuration.recording is None:
        yield
        return
    from timonel.gateway.recorder import Keeper, front

    keeper = Keeper(gateway, configuration, front(gateway, configuration, simulated, seed))
    keeper.start()
    try:
        yield
    finally:
        await keeper.close()
