"""`tcp://host:port`: a client that connects, and connects again.

`tcp-listen://host:port`: a server for many readers, in `tcp_listen`.
"""

import asyncio
import errno
import os
import socket
from typing import ClassVar

from timonel.links.wire import Port, Wire

CONNECT_WITHIN = 3.0
KEEPALIVE = ((socket.TCP_KEEPIDLE, 10), (socket.TCP_KEEPINTVL, 5), (socket.TCP_KEEPCNT, 3))
SEND_BUFFER = 32 * 1024  # so that what waits, waits here, where news replaces it


def prepare(stream: socket.socket) -> None:
    """Lines go out at once, little waits in the kernel, and a peer that vanished is noticed in 25 s."""
    stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    stream.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
    stream.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for option, value in KEEPALIVE:
        stream.setsockopt(socket.IPPROTO_TCP, option, value)


class TcpLink(Port):
    """A client of a line server."""

    PAUSE: ClassVar[float] = 0.5

    def __init__(self, host: str, port: int, *, url: str = "", name: str = "") -> None:
        super().__init__(url=url, name=name)
        self.host = host
        self.port = port

    async def _make_wire(self) -> Wire:
        try:
            async with asyncio.timeout(CONNECT_WITHIN):
                stream = await self._reach()
        except TimeoutError as fault:
            raise OSError("no answer") from fault
        return Wire(
            stream.fileno(),
            receive=self._receive,
            lost=self._lost,
            release=stream.close,
            tally=self._tally,
            stale_after=self.stale_after,
        )

    async def _reach(self) -> socket.socket:
        """A connection to the first of the host's addresses that takes one."""
        fault = OSError(f"{self.host} has no address")
        for family, kind, protocol, _, address in await self._loop.getaddrinfo(
            self.host, self.port, type=socket.SOCK_STREAM
        ):
            stream = socket.socket(family, kind, protocol)
            try:
                stream.setblocking(False)
                prepare(stream)
                await self._loop.sock_connect(stream, address)
                if stream.getsockname() == stream.getpeername():
                    # what trying again and again at a free port of one's own machine comes to in the end
                    raise OSError(errno.ECONNREFUSED, "connected to itself")
            except OSError as refusal:
                stream.close()
                # without the address, which asyncio puts into the text
                fault = OSError(os.strerror(refusal.errno or 0))
            except asyncio.CancelledError:
                stream.close()
                raise
            else:
                return stream
        raise fault
