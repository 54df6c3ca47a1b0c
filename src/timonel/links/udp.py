"""`udp://host:port` sends datagrams there and hears that address alone; `udp://:port` hears everybody.

A datagram holds whole lines, at most 1400 bytes of them; a batch goes out as one if it fits. What arrives
is whole too: a last line without an end gets one, so that it is not joined to the next datagram. A
broadcast address may be sent to. With `?local=port` that port is ours, for a far side that does not answer to where
it was asked from but always sends to the same port, as Wi-Fi gateways do.
"""

import socket
from collections.abc import Iterator, Sequence

from timonel.core.effects import Say
from timonel.links.datagram import DATAGRAM_MAX, DatagramLink


def datagrams(lines: Sequence[Say]) -> Iterator[tuple[bytes, int]]:
    """`lines` packed in order into datagrams of at most 1400 bytes, each with the number of its lines."""
    data, count = b"", 0
    for say in lines:
        if data and len(data) + len(say.line) > DATAGRAM_MAX:
            yield data, count
            data, count = b"", 0
        data += say.line
        count += 1
    if data:
        yield data, count


class UdpLink(DatagramLink):
    """A datagram socket; without a `host` it only listens on `port`, and what is sent to it is dropped.

    `local` is our own port, 0 any.
    """

    def __init__(self, host: str | None, port: int, *, local: int = 0, url: str = "", name: str = "") -> None:
        super().__init__(url=url, name=name)
        self.host = host
        self.port = port
        self.local = local

    @property
    def address(self) -> tuple[str, int] | None:
        """Our own host and port, None while it is not open."""
        if self._socket is None:
            return None
        host, port = self._socket.getsockname()[:2]
        return host, port

    async def _connect(self) -> None:
        found = await self._loop.getaddrinfo(
            self.host, self.port, type=socket.SOCK_DGRAM, flags=0 if self.host else socket.AI_PASSIVE
        )
        family, kind, protocol, _, address = found[0]
        datagram = socket.socket(family, kind, protocol)
        try:
            datagram.setblocking(False)
            datagram.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
            if self.host:
                if self.local:
                    datagram.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                    datagram.bind(("", self.local))
                datagram.connect(address)
            else:
                datagram.bind(address)
        except OSError:
            datagram.close()
            raise
        self._attach(datagram)

    def _heard(self, data: bytes) -> None:
        if data:
            self._receive(data if data.endswith(b"\n") else data + b"\r\n")

    def send(self, lines: Sequence[Say]) -> None:
        if self._socket is None or not self.host:
            self._tally.dropped += len(lines)
            return
        for data, count in datagrams(lines):
            self._write(self._socket.send, data, count)
