"""What buses share that are frames over a port: text of a gateway, a rover's UART."""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable

import msgspec

from timonel.core.frame import Frame
from timonel.links.link import ByteLink, Changed, Counters


class FramedBus(ABC):
    """Frames over `port`, which is opened, closed and counted with it."""

    def __init__(self, port: ByteLink) -> None:
        self.url = port.url
        self.name = port.name
        self._port = port
        self._frames_in = 0
        self._frames_out = 0
        self._dropped = 0

    @property
    def counters(self) -> Counters:
        """Those of the port, with frames."""
        tally = self._port.counters
        return msgspec.structs.replace(
            tally, frames_in=self._frames_in, frames_out=self._frames_out, dropped=tally.dropped + self._dropped
        )

    async def open(self, receive: Callable[[list[Frame]], None], changed: Changed) -> None:
        """Open the port."""
        self._receive = receive
        self._changed = changed
        self._loop = asyncio.get_running_loop()
        await self._port.open(self._hear, self._port_changed)

    async def close(self, drain: float = 0.5) -> None:
        """Close the port."""
        await self._port.close(drain)

    @abstractmethod
    def _hear(self, data: bytes) -> None:
        """Bytes came in on the port."""

    @abstractmethod
    def _port_changed(self, connected: bool, reason: str) -> None:
        """What comes from now on does not belong to what came before."""

    def _hand_over(self, frames: list[Frame]) -> None:
        if frames:
            self._frames_in += len(frames)
            self._receive(frames)
