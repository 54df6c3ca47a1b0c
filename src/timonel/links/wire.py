"""A descriptor on the loop, and the links that have one: bytes in as they come, lines out as there is room.

Written for speed where a batch passes: one write for a batch of lines, no task and no timer unless the port
is full.
"""

import asyncio
import os
from abc import abstractmethod
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TypeVar

from timonel.core.effects import Say
from timonel.links.backlog import URGENT_MAX, Backlog
from timonel.links.fan import Fan, Send, Served
from timonel.links.kept import Kept, text_of
from timonel.links.link import Counters

Incoming = TypeVar("Incoming")

READ_AT_ONCE = 4096  # no more at a time from one port, so that a flood on it leaves the others their turn
WRITE_AT_ONCE = 65536
LAST_WORDS = 16  # such pieces at most
RETRY = 0.02


class Wire:
    """An open non-blocking descriptor: serial port, pseudo-terminal or stream socket.

    `lost(reason)` is called once, from the loop, when it breaks; after that nothing is read or written any
    more, and its owner calls `close`, which gives the descriptor back by `release`. With `room`, which
    tells how many bytes the system may be given now, room is asked for every 20 ms instead of waiting for
    the descriptor to be writable. With `stale_after`, lines that could not move for so many seconds are
    dropped instead of being sent late.
    """

    def __init__(
        self,
        fd: int,
        *,
        receive: Callable[[bytes], None],
        lost: Callable[[str], None],
        release: Callable[[], None],
        tally: Counters,
        room: Callable[[], int] | None = None,
        urgent_max: int = URGENT_MAX,
        stale_after: float | None = None,
    ) -> None:
        os.set_blocking(fd, False)
        self.fd = fd
        self.tally = tally
        self.fan: Fan | None = None
        """What writes to it instead of us while it is ready."""
        self._receive = receive
        self._lost = lost
        self._release = release
        self._room = room
        self._stale_after = stale_after
        self._backlog = Backlog(tally, urgent_max=urgent_max)
        self._broken = False
        self._closed = False
        self.ready = room is None
        """Whether nothing waits, and room need not be asked for."""
        self._moved = 0.0
        self._retry: asyncio.TimerHandle | None = None
        self._loop = asyncio.get_running_loop()
        self._loop.add_reader(fd, self._readable)

    @property
    def pending(self) -> bool:
        """Whether lines wait that could still be written."""
        return bool(self._backlog) and not self._broken

    # Once a batch and link: what is ready costs one write and little else.
    def send(self, lines: Sequence[Say]) -> None:
        if self.ready and lines:
            self._send_now(lines[0].line if len(lines) == 1 else b"".join([say.line for say in lines]), lines)
        else:
            self._send_unready(lines)

    def _send_now(self, data: bytes, lines: Sequence[Say]) -> None:
        written = self._write(data)
        if written != len(data):
            self.keep(lines, written)

    def keep(self, lines: Sequence[Say], written: int) -> None:
        """Only the first `written` bytes of `lines` went out; nothing may be waiting."""
        self._backlog.keep(lines, written)
        self._wait_for_room()

    def _set_ready(self, ready: bool) -> None:
        self.ready = ready
        if self.fan is not None:
            self.fan.changed()

    def _send_unready(self, lines: Sequence[Say]) -> None:
        if self._broken:
            self.tally.dropped += len(lines)
        elif self._backlog:
            self._backlog.add(lines)
        elif self._room is not None and lines:
            self._send_by_room(lines, self._room())

    def _send_by_room(self, lines: Sequence[Say], room: int) -> None:
        data = b"".join([say.line for say in lines])
        if len(data) <= room:
            self._send_now(data, lines)
        else:
            self._backlog.add(lines)
            self._moved = self._loop.time()
            self._flush()

    def _write(self, data: bytes) -> int:
        try:
            written = os.write(self.fd, data)
        except OSError as fault:
            return self.refused(fault)
        self.tally.bytes_out += written
        return written

    def refused(self, fault: OSError) -> int:
        """A write failed: 0 bytes went out. If it was not for want of room, the wire is broken now."""
        if not isinstance(fault, BlockingIOError):
            self._break(text_of(fault))
        return 0

    def _wait_for_room(self) -> None:
        if self._broken:
            return
        self._moved = self._loop.time()
        if self._room is None:
            self._set_ready(False)
            self._loop.add_writer(self.fd, self._flush)
        else:
            self._retry = self._loop.call_later(RETRY, self._flush)

    def _flush(self) -> None:
        now = self._loop.time()
        if self._stale_after is not None and now - self._moved > self._stale_after:
            self._backlog.clear()
        data = self._backlog.head(WRITE_AT_ONCE if self._room is None else self._room())
        if data and (written := self._write(data)):
            self._moved = now
            self._backlog.written(written)
        if self._broken:
            return
        if not self._backlog:
            self._set_ready(self._room is None)
            self._loop.remove_writer(self.fd)
        elif self._room is not None:
            self._retry = self._loop.call_later(RETRY, self._flush)

    def _readable(self) -> None:
        try:
            data = os.read(self.fd, READ_AT_ONCE)
        except BlockingIOError:
            return
        except OSError as fault:
            self._break(text_of(fault))
            return
        if data:
            self._hear(data)
        else:
            self._break("closed by the other side")

    def _hear(self, data: bytes) -> None:
        self.tally.bytes_in += len(data)
        self._receive(data)

    def _break(self, reason: str) -> None:
        if not self._broken:
            self._stop()
            self._loop.call_soon(self._end, reason)

    def _end(self, reason: str) -> None:
        """Hear the last words (a write can fail before we have read them), then tell of the loss."""
        if self._closed:
            return
        with suppress(OSError):
            for _ in range(LAST_WORDS):
                if data := os.read(self.fd, READ_AT_ONCE):
                    self._hear(data)
        self._lost(reason)

    def _stop(self) -> None:
        self._broken = True
        self._set_ready(False)
        self._loop.remove_reader(self.fd)
        self._loop.remove_writer(self.fd)
        if self._retry is not None:
            self._retry.cancel()

    def close(self) -> None:
        """Give the descriptor back; what still waits is dropped and counted."""
        if not self._broken:
            self._stop()
        self._closed = True
        self._backlog.clear()
        self._release()


class Wired(Kept[Incoming]):
    """A link over one wire."""

    _wire: Wire | None = None

    @abstractmethod
    async def _make_wire(self) -> Wire:
        """Open the descriptor; raises OSError."""

    async def _connect(self) -> None:
        self._wire = await self._make_wire()

    async def _disconnect(self) -> None:
        wire, self._wire = self._wire, None
        if wire is not None:
            wire.close()

    def _pending(self) -> bool:
        return self._wire is not None and self._wire.pending


class Port(Served, Wired[bytes]):
    """A port over one wire. With `stale_after` it sends nothing that had to wait longer; see `Wire`."""

    stale_after: float | None = None

    async def _connect(self) -> None:
        await super()._connect()
        if self.fan is not None:
            assert self._wire is not None
            self._wire.fan = self.fan
            self._tell_fan()

    async def _disconnect(self) -> None:
        await super()._disconnect()
        self._tell_fan()

    def outlets(self) -> tuple[Sequence[Wire], Sequence[Send]]:
        """See `timonel.links.fan`."""
        wire = self._wire
        return ((), (self.send,)) if wire is None or not wire.ready else ((wire,), ())

    def send(self, lines: Sequence[Say]) -> None:
        if self._wire is None:
            self._tally.dropped += len(lines)
        else:
            self._wire.send(lines)
