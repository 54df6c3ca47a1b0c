"""`tcp-listen://host:port`: a server with many readers, each with a backlog of its own.

A reader that stops reading costs the others nothing, and gets the newest line of each kind when it goes on.
What the clients say is delivered line by line, so that their lines are never mixed.

`?raw=yes` is for what knows no lines: bytes are delivered as they come, of one client at a time, since the bytes of two
would make frames that nobody sent. Whoever speaks first has the voice, until he leaves or is silent for 2 s; what
others say meanwhile is dropped and counted, and all of them hear. Connected means then that somebody has the voice.
"""

import asyncio
import errno
import socket
from collections.abc import Callable, Sequence
from functools import partial

from timonel.core.effects import Say
from timonel.links.backlog import URGENT_MAX
from timonel.links.fan import Send, Served
from timonel.links.kept import text_of
from timonel.links.lines import WholeLines
from timonel.links.tcp import prepare
from timonel.links.wire import Wire

READERS_MAX = 256
ACCEPT_AT_ONCE = 16
REST = 1.0
SILENT = 2.0  # s after which a raw client may be gone without a word, and the next one is heard
OUT_OF_DESCRIPTORS = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)


class TcpListenLink(Served):
    """A line server; connected means that it listens, and `changed` tells the number of readers."""

    def __init__(self, host: str, port: int, *, raw: bool = False, url: str = "", name: str = "") -> None:
        super().__init__(url=url, name=name)
        self.host = host
        self.port = port
        self.raw = raw
        self.urgent_max = URGENT_MAX
        """Urgent lines that wait for one reader at most."""
        self.stale_after: float | None = None
        """See `Wire`."""
        self.greeting: Callable[[], bytes] | None = None
        """What every reader is told first."""
        self._speaker: int | None = None
        self._voice: int | None = None
        self._voice_heard = 0.0
        self._server: socket.socket | None = None
        self._resume: asyncio.TimerHandle | None = None
        self._readers: dict[int, Wire] = {}

    @property
    def address(self) -> tuple[str, int] | None:
        """Host and port where it listens (the real one if port 0 was asked for), None while it does not."""
        if self._server is None:
            return None
        host, port = self._server.getsockname()[:2]
        return host, port

    async def _connect(self) -> None:
        found = await self._loop.getaddrinfo(self.host, self.port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, kind, protocol, _, address = found[0]
        server = socket.socket(family, kind, protocol)
        try:
            server.setblocking(False)
            server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            server.bind(address)
            server.listen(64)
        except OSError:
            server.close()
            raise
        self._server = server
        self._accept_on()

    def _accept_on(self) -> None:
        if self._server is not None:
            self._loop.add_reader(self._server.fileno(), self._accept)

    def _accept(self) -> None:
        assert self._server is not None
        for _ in range(ACCEPT_AT_ONCE):
            try:
                stream, _ = self._server.accept()
            except (BlockingIOError, ConnectionAbortedError):
                return
            except OSError as fault:
                self._rest(fault)
                return
            self._welcome(stream)

    def _rest(self, fault: OSError) -> None:
        """Look away for a second: without descriptors, who knocks stays at the door and wakes us for ever."""
        assert self._server is not None
        self._tally.errors += 1
        if fault.errno not in OUT_OF_DESCRIPTORS:
            self._lost(text_of(fault))
        self._loop.remove_reader(self._server.fileno())
        self._resume = self._loop.call_later(REST, self._accept_on)

    def _welcome(self, stream: socket.socket) -> None:
        if len(self._readers) >= READERS_MAX:
            self._tally.rejected += 1
            stream.close()
            return
        prepare(stream)
        fd = stream.fileno()
        self._readers[fd] = Wire(
            fd,
            receive=partial(self._hear_raw, fd) if self.raw else partial(self._hear, fd, WholeLines(self._tally)),
            lost=partial(self._leave, fd),
            release=stream.close,
            tally=self._tally,
            urgent_max=self.urgent_max,
            stale_after=self.stale_after,
        )
        self._readers[fd].fan = self.fan
        if self.greeting is not None:
            self._readers[fd].send([Say(self.greeting(), "", urgent=True)])
        self._readers_changed()

    def _hear(self, fd: int, lines: WholeLines, data: bytes) -> None:
        if whole := lines.receive(data):
            self._speaker = fd
            self._receive(whole)
            self._speaker = None

    def _hear_raw(self, fd: int, data: bytes) -> None:
        now = self._loop.time()
        taken = self._voice is not None and now < self._voice_heard + SILENT
        if fd == self._voice:
            self._voice_heard = now
            self._receive(data)
        elif taken:
            self._tally.rejected += 1
        else:
            self._give_voice(fd, data, now)

    def _give_voice(self, fd: int, data: bytes, now: float) -> None:
        self._voice, self._voice_heard = fd, now
        self._told = None  # another one speaks: that is news even where the words are the same
        self._tell(True, "somebody speaks")
        self._loop.call_soon(self._receive, data)  # after the listener was told whom it hears

    def _leave(self, fd: int, _reason: str) -> None:
        if reader := self._readers.pop(fd, None):
            reader.close()
            self._readers_changed()
        if fd == self._voice:
            self._voice = None
            self._tell(False, "who spoke has left")

    def _readers_changed(self) -> None:
        self._tell_fan()
        if not self.raw:
            self._tell(True, f"readers: {len(self._readers)}" if self._readers else "")

    def outlets(self) -> tuple[Sequence[Wire], Sequence[Send]]:
        """See `timonel.links.fan`."""
        readers = self._readers.values()
        return [reader for reader in readers if reader.ready], [reader.send for reader in readers if not reader.ready]

    def send(self, lines: Sequence[Say]) -> None:
        for reader in self._readers.values():
            reader.send(lines)

    def send_others(self, lines: Sequence[Say]) -> None:
        """`send`, called while a client is heard: to all but that one."""
        for fd, reader in self._readers.items():
            if fd != self._speaker:
                reader.send(lines)

    def _pending(self) -> bool:
        return any(reader.pending for reader in self._readers.values())

    async def _disconnect(self) -> None:
        if self._resume is not None:
            self._resume.cancel()
        if self._server is not None:
            self._loop.remove_reader(self._server.fileno())
            self._server.close()
            self._server = None
        self._voice = None
        while self._readers:
            self._readers.popitem()[1].close()
        self._tell_fan()
