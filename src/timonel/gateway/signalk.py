"""A gateway as a source for Signal K servers: ten times a second what is new, over TCP and to a server's stream.

```
tcp    lines: hello, all that is known, then a delta for each thing that is told; who cannot keep up gets the newest
push   a WebSocket of ours to a server: all that is known, then deltas; opened anew after 1 s, at last every 30 s
```
What we tell a server is about its own boat, `vessels.self`.
"""

import asyncio
import time
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING

import msgspec

from timonel.core.effects import Say
from timonel.gateway.configuration import Configuration
from timonel.gateway.gateway import Gateway
from timonel.gateway.signalk_settings import SignalK
from timonel.interop.signalk.boat import known
from timonel.interop.signalk.deltas import SELF, delta, hello
from timonel.interop.signalk.model import Model, grouped
from timonel.links.link import ByteLink
from timonel.links.tcp_listen import TcpListenLink
from timonel.links.urls import byte_link
from timonel.vehicles.boat.vehicle import Boat

if TYPE_CHECKING:
    from websockets.asyncio.client import ClientConnection

PERIOD = 0.1  # s
AGAIN, AGAIN_AT_LAST = 1.0, 30.0  # s until a server that cannot be reached is tried once more
END_WITHIN = 0.5  # s
TCP, PUSH = "Signal K TCP", "Signal K server"
END = b"\r\n"


@asynccontextmanager
async def signalk(gateway: Gateway, configuration: Configuration) -> AsyncIterator[None]:
    """While it is entered, Signal K servers are told what the configuration wants them to be told."""
    wanted = configuration.signalk
    if wanted is None or (wanted.tcp, wanted.push) == (None, None):
        yield
        return
    source = Source(gateway, configuration)
    routines = [asyncio.create_task(source.run(), name="Signal K")]
    try:
        if wanted.tcp is not None:
            await source.open(byte_link(wanted.tcp, name=TCP))
        if wanted.push is not None:
            routines.append(asyncio.create_task(source.push(wanted.push, wanted), name=PUSH))
        yield
    finally:
        for routine in routines:
            routine.cancel()
        for routine in routines:
            with suppress(asyncio.CancelledError):
                await routine
        await source.close()


def epoch(gateway: Gateway) -> float:
    """When the machine's time was 0, by this computer's clock, s since 1970."""
    return time.time() - gateway.now


class Source:
    """What is known about a gateway's boat, told to whoever wants it."""

    def __init__(self, gateway: Gateway, configuration: Configuration) -> None:
        assert isinstance(gateway.vehicle, Boat)
        self._gateway = gateway
        self._boat = gateway.vehicle
        self._names = configuration.names
        self._model = Model()
        self._link: ByteLink | None = None
        self._pushing = False, ""

    async def run(self) -> None:
        """For ever."""
        while True:
            self._gateway.guarded("Signal K", self._look)
            await asyncio.sleep(PERIOD)

    def _look(self) -> None:
        now = self._gateway.now
        news = self._model.update(known(self._boat, self._names, now), now)
        if self._link is not None and news:
            since = epoch(self._gateway)
            self._link.send([Say(delta(SELF, [told], since) + END, told.key) for told in news])

    # Lines over TCP -----------------------------------------------------------------------------------

    async def open(self, link: ByteLink) -> None:
        """Tell who listens on a port, or whom it reaches."""
        self._link = link
        if isinstance(link, TcpListenLink):
            link.greeting = self._greeting
        self._gateway.health.watch(link.name, lambda: _counters(link))
        await link.open(_unheard, self._changed)

    def _greeting(self) -> bytes:
        now, since = self._gateway.now, epoch(self._gateway)
        return hello(SELF, now, since) + END + delta(SELF, self._model.everything(), since) + END

    def _changed(self, connected: bool, reason: str) -> None:
        assert self._link is not None
        self._gateway.health.link(TCP, connected, reason)
        if connected and not isinstance(self._link, TcpListenLink):
            self._link.send([Say(self._greeting(), "", urgent=True)])

    async def close(self) -> None:
        """End the port."""
        if self._link is not None:
            await self._link.close()

    # A server's stream --------------------------------------------------------------------------------

    async def push(self, url: str, wanted: SignalK) -> None:
        """For ever."""
        headers = {} if wanted.token is None else {"Authorization": f"Bearer {wanted.token}"}
        pause = AGAIN
        while True:
            reason = await self._pushed(f"{url}?subscribe=none", headers)
            pause = AGAIN if self._pushing[0] else pause
            self._push_changed(False, reason)
            await asyncio.sleep(pause)
            pause = min(2 * pause, AGAIN_AT_LAST)

    async def _pushed(self, url: str, headers: Mapping[str, str]) -> str:
        """Tell it as long as it listens; why that ended."""
        from websockets.asyncio.client import connect
        from websockets.exceptions import WebSocketException

        try:
            async with connect(url, additional_headers=headers, compression=None, close_timeout=END_WITHIN) as stream:
                self._push_changed(True, "")
                await self._push_over(stream)
        except (OSError, WebSocketException, TimeoutError) as fault:
            return str(fault)[:200]
        return "closed by the server"

    def _push_changed(self, connected: bool, reason: str) -> None:
        """Log it, once."""
        if (connected, reason) != self._pushing:
            self._pushing = connected, reason
            self._gateway.health.link(PUSH, connected, reason)

    async def _push_over(self, stream: "ClientConnection") -> None:
        """Until the stream ends: what is new, and while it cannot take that, later the newest."""
        listening = asyncio.create_task(_hear_out(stream))
        told = 0
        try:
            while not listening.done():
                entries = {path: entry for path, entry in self._model.entries.items() if entry.changed > told}
                told = self._model.sequence
                if entries:
                    await stream.send(delta(SELF, grouped(entries), epoch(self._gateway)).decode())
                await asyncio.sleep(PERIOD)
            await listening
        finally:
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)
            await stream.close()


async def _hear_out(stream: "ClientConnection") -> None:
    """A server's words are not for us, but lie in the way of its pings."""
    async for _ in stream:
        pass


def _unheard(_: bytes) -> None:
    """What a listener says."""


def _counters(link: ByteLink) -> dict[str, int]:
    return msgspec.structs.asdict(link.counters)
