"""What links of datagrams share: one socket, read when something came, written at once or not at all."""

import socket
from abc import abstractmethod
from collections.abc import Callable

from timonel.links.kept import Kept

DATAGRAM_MAX = 1400  # below every common path MTU
LONGEST = 65536


class DatagramLink(Kept[bytes]):
    """A datagram socket, which `_connect` makes and hands to `_attach`."""

    def __init__(self, *, url: str = "", name: str = "") -> None:
        super().__init__(url=url, name=name)
        self._socket: socket.socket | None = None

    @abstractmethod
    def _heard(self, data: bytes) -> None:
        """A datagram came, perhaps an empty one."""

    def _attach(self, datagram: socket.socket) -> None:
        self._socket = datagram
        self._loop.add_reader(datagram.fileno(), self._readable)

    async def _disconnect(self) -> None:
        datagram, self._socket = self._socket, None
        if datagram is not None:
            self._loop.remove_reader(datagram.fileno())
            datagram.close()

    def _readable(self) -> None:
        assert self._socket is not None
        try:
            data = self._socket.recv(LONGEST)
        except BlockingIOError:
            return
        except OSError:  # nobody listened to what we sent
            self._tally.errors += 1
            return
        self._tally.bytes_in += len(data)
        self._heard(data)

    def _write(self, write: Callable[[bytes], int], data: bytes, count: int) -> None:
        """Send `count` lines in one datagram by `write`; what cannot go now is dropped."""
        try:
            self._tally.bytes_out += write(data)
        except BlockingIOError:
            self._tally.dropped += count
        except OSError:
            self._tally.errors += 1
            self._tally.dropped += count
