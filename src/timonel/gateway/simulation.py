"""A simulated vehicle on a bus, in the loop's time: something to steer where there is none."""

import asyncio
from contextlib import suppress
from types import TracebackType
from typing import Protocol

from timonel.core.frame import Frame
from timonel.links.link import BusLink

TICK = 0.02  # s
LONGEST_STEP = 1.0  # s: a computer that slept does not catch up


class Simulated(Protocol):
    """A model with no clock of its own: the simulated boat, the simulated rover."""

    def receive(self, frame: Frame) -> None:
        """A frame that somebody put on the bus."""

    def step(self, dt: float) -> list[Frame]:
        """Let `dt` seconds pass; the frames that were sent in them."""


class Simulation:
    """Moves `vehicle` while it is entered, `speed` times as fast as time goes, and closes `bus` at the end."""

    def __init__(self, vehicle: Simulated, bus: BusLink, speed: float = 1.0) -> None:
        self._vehicle = vehicle
        self._bus = bus
        self._speed = speed

    async def __aenter__(self) -> "Simulation":
        await self._bus.open(self._receive, lambda connected, reason: None)
        self._moving = asyncio.get_running_loop().create_task(self._move(), name="simulated vehicle")
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._moving.cancel()
        with suppress(asyncio.CancelledError):
            await self._moving
        await self._bus.close()

    def _receive(self, frames: list[Frame]) -> None:
        for frame in frames:
            self._vehicle.receive(frame)

    async def _move(self) -> None:
        loop = asyncio.get_running_loop()
        then = loop.time()
        while True:
            await asyncio.sleep(TICK)
            now = loop.time()
            self._bus.send(self._vehicle.step(min(now - then, LONGEST_STEP) * self._speed))
            then = now
