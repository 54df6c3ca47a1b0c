"""The simulated boat on a bus, in the loop's time: something to steer where there is no boat."""

import asyncio
from contextlib import suppress
from types import TracebackType

from timonel.core.frame import Frame
from timonel.links.link import BusLink
from timonel.vehicles.boat.simulator import TICK, SimulatedBoat

LONGEST_STEP = 1.0  # s: a computer that slept does not catch up


class Simulation:
    """Moves `boat` while it is entered, `speed` times as fast as time goes, and closes `bus` at the end."""

    def __init__(self, boat: SimulatedBoat, bus: BusLink, speed: float = 1.0) -> None:
        self.boat = boat
        self._bus = bus
        self._speed = speed

    async def __aenter__(self) -> "Simulation":
        await self._bus.open(self._receive, lambda connected, reason: None)
        self._sailing = asyncio.get_running_loop().create_task(self._sail(), name="simulated boat")
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._sailing.cancel()
        with suppress(asyncio.CancelledError):
            await self._sailing
        await self._bus.close()

    def _receive(self, frames: list[Frame]) -> None:
        for frame in frames:
            self.boat.receive(frame)

    async def _sail(self) -> None:
        loop = asyncio.get_running_loop()
        then = loop.time()
        while True:
            await asyncio.sleep(TICK)
            now = loop.time()
            self._bus.send(self.boat.step(min(now - then, LONGEST_STEP) * self._speed))
            then = now
