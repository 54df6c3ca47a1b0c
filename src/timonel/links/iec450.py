"""`iec450://NAVD?source=II0001`: sentences in the multicast datagrams of ships' networks (IEC 61162-450).

A datagram is `UdPbC`, a zero byte, and lines of a TAG block and a sentence each. Ours say who we are (`source`: a
talker and four digits), count their lines from 1 to 999, and mark the parts of what does not fit into one sentence
(AIS). Lines whose TAG block is broken, and lines for somebody else, are dropped and counted; our own that come back are
not heard. `interface` is the address of the network adapter to use, if there are several. Datagrams do not leave the
local network.
"""

import socket
from collections.abc import Iterator, Sequence

from timonel.core.effects import Say
from timonel.links.datagram import DATAGRAM_MAX, DatagramLink
from timonel.nmea0183.checksum import Fault
from timonel.nmea0183.tag_block import TagBlock, split, write

HEADER = b"UdPbC\0"
LINES_MAX = 999
GROUP_CODES = 99

ANY = "0.0.0.0"


class Iec450Link(DatagramLink):
    """A transmission group, heard and spoken to; `host` is its multicast address."""

    def __init__(
        self, host: str, port: int, *, source: str = "II0001", interface: str = ANY, url: str = "", name: str = ""
    ) -> None:
        super().__init__(url=url, name=name)
        self.host = host
        self.port = port
        self.source = source
        self.interface = interface
        self._line = 0
        self._group = 0

    async def _connect(self) -> None:
        datagram = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            datagram.setblocking(False)
            datagram.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            datagram.bind((self.host, self.port))
            adapter = socket.inet_aton(self.interface)
            datagram.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(self.host) + adapter)
            datagram.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, adapter)
            datagram.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 1)
        except OSError:
            datagram.close()
            raise
        self._attach(datagram)

    # In -------------------------------------------------------------------------------------------

    def _heard(self, data: bytes) -> None:
        if not data.startswith(HEADER):  # another kind of datagram: files, radar pictures
            self._tally.rejected += 1
        elif heard := b"".join(self._sentences(data[len(HEADER) :])):
            self._receive(heard)

    def _sentences(self, lines: bytes) -> Iterator[bytes]:
        for line in lines.replace(b"\r", b"\n").split(b"\n"):
            if not line:
                continue
            tag, sentence = split(line)
            if isinstance(tag, Fault) or tag.destination not in (None, self.source):
                self._tally.rejected += 1
            elif tag.source != self.source:
                yield sentence + b"\r\n"

    # Out ------------------------------------------------------------------------------------------

    def send(self, lines: Sequence[Say]) -> None:
        if self._socket is None:
            self._tally.dropped += len(lines)
            return
        data = HEADER
        for line in (line for say in lines for line in self._tagged(say.line)):
            if len(data) + len(line) > DATAGRAM_MAX and data != HEADER:
                self._send_one(self._socket, data)
                data = HEADER
            data += line
        if data != HEADER:
            self._send_one(self._socket, data)

    def _tagged(self, said: bytes) -> Iterator[bytes]:
        for line in said.splitlines(keepends=True):
            self._line = self._line % LINES_MAX + 1
            yield write(TagBlock(source=self.source, line=self._line, group=self._part(line))) + line

    def _part(self, line: bytes) -> tuple[int, int, int] | None:
        """Which part of how many a sentence of AIS is, and of which group."""
        fields = line.split(b",", 3)
        if line[:1] != b"!" or len(fields) < 4 or fields[1] == b"1" or not (fields[1] + fields[2]).isdigit():
            return None
        total, part = int(fields[1]), int(fields[2])
        if part == 1:
            self._group = self._group % GROUP_CODES + 1
        return part, total, self._group

    def _send_one(self, datagram: socket.socket, data: bytes) -> None:
        self._write(lambda data: datagram.sendto(data, (self.host, self.port)), data, data.count(b"\n"))
