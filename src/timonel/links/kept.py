"""A link that is kept open: tried until it succeeds, and again whenever it is lost."""

import asyncio
import copy
from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import suppress
from typing import ClassVar, Generic, TypeVar

from timonel.links.link import Changed, Counters

Incoming = TypeVar("Incoming")


def text_of(fault: OSError) -> str:
    """What the system says about it, without number and file name (the link's own name stands beside it)."""
    return fault.strerror or str(fault)


class Kept(ABC, Generic[Incoming]):
    """Base of the links: one task that opens, waits for the loss, and opens again after `PAUSE` seconds."""

    PAUSE: ClassVar[float] = 0.5

    def __init__(self, *, url: str = "", name: str = "") -> None:
        self.url = url
        self.name = name or url
        self._tally = Counters()
        self._connected = False
        self._was_connected = False
        self._told: tuple[bool, str] | None = None
        self._keeper: asyncio.Task[None] | None = None

    @property
    def counters(self) -> Counters:
        return copy.copy(self._tally)

    @abstractmethod
    async def _connect(self) -> None:
        """Make one attempt; raises OSError when it fails, and leaves nothing open then."""

    @abstractmethod
    async def _disconnect(self) -> None:
        """Give everything back. Called after a loss and at the end, whether or not it is connected."""

    def _pending(self) -> bool:
        """Whether something is still to be sent."""
        return False

    @property
    def busy(self) -> bool:
        """Whether something waits for room on the link."""
        return self._pending()

    async def open(self, receive: Callable[[Incoming], None], changed: Changed) -> None:
        self._receive = receive
        self._changed = changed
        self._loop = asyncio.get_running_loop()
        await self._attempt()
        self._keeper = self._loop.create_task(self._keep(), name=f"link {self.name}")
        await asyncio.sleep(0)  # so that `changed` was called when this returns

    async def close(self, drain: float = 0.5) -> None:
        if self._keeper is None:
            return
        deadline = self._loop.time() + drain
        while self._pending() and self._loop.time() < deadline:
            await asyncio.sleep(0.01)
        self._keeper.cancel()
        with suppress(asyncio.CancelledError):
            await self._keeper
        self._keeper = None
        self._connected = False
        await self._disconnect()

    async def _keep(self) -> None:
        while True:
            if self._connected:
                reason = await self._loss
                self._connected = False
                await self._disconnect()
                self._tell(False, reason)
            await asyncio.sleep(self.PAUSE)
            await self._attempt()

    async def _attempt(self) -> None:
        self._loss: asyncio.Future[str] = self._loop.create_future()
        try:
            await self._connect()
        except OSError as fault:
            self._tell(False, text_of(fault))
        else:
            self._tally.reopened += self._was_connected
            self._connected = self._was_connected = True
            self._tell(True, "")

    def _lost(self, reason: str) -> None:
        """The link broke; the keeper does the rest."""
        if not self._loss.done():
            self._loss.set_result(reason)

    def _tell(self, connected: bool, reason: str) -> None:
        # through the loop, so that a listener's own fault cannot end the keeper
        if (connected, reason) != self._told:
            self._told = (connected, reason)
            self._loop.call_soon(self._changed, connected, reason)
