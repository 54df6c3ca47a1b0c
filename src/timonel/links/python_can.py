"""`can+<interface>://channel?bitrate=250000`: any bus that python-can drives (gs_usb, pcan ...).

Its drivers block, so one thread receives and one sends; frames reach the loop in batches. python-can's own
Notifier is not used: one broken line ends it, and an unplugged adapter makes it spin. Here a broken line is
counted, a dead bus is shut down and opened again every second, a frame that could not be sent within half a
second is dropped, and a thread that ends for whatever reason is noticed. Further parameters of the URL go
to the driver as they are.

This module needs the extra `can`; it is imported when a link of this kind is made, not before.
"""

import asyncio
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from queue import Empty, Full, Queue
from typing import Any, ClassVar

import can

from timonel.core.frame import Frame
from timonel.links.kept import Kept

BATCH = 64
INBOX = 4096
OUTBOX = 256
POLL = 0.1
NAP = 0.01
SEND_WITHIN = 0.1
STALE = 0.5
STRIKES = 100

BROKEN_LINE = (ValueError, IndexError, KeyError)
DRIVER_FAULT = (
    can.CanError,
    OSError,
    ValueError,
    TypeError,
    AttributeError,
    ImportError,
    LookupError,
    RuntimeError,
)


def open_bus(interface: str, channel: str | int, parameters: dict[str, Any]) -> can.BusABC:
    """The bus; raises OSError whatever the driver raises."""
    try:
        return can.Bus(interface=interface, channel=channel, ignore_config=True, **parameters)
    except DRIVER_FAULT as fault:
        raise OSError(f"{type(fault).__name__}: {fault}") from fault


class Attendance:
    """An open bus and the two threads that attend it.

    From those threads are called `heard()` when messages are in `inbox`, `lost(reason)` when the bus is
    dead, and `count(field)` for what did not get through, by the name of its counter.
    """

    def __init__(
        self,
        bus: can.BusABC,
        *,
        heard: Callable[[], None],
        lost: Callable[[str], None],
        count: Callable[[str], None],
    ) -> None:
        self._bus = bus
        self._heard = heard
        self._lost = lost
        self._count = count
        self._stopping = threading.Event()
        self._outgoing: Queue[tuple[float, Frame] | None] = Queue(OUTBOX)
        self._strikes = 0
        self._patience = POLL
        self.inbox: deque[can.Message] = deque()
        self._threads = [threading.Thread(target=work, daemon=True) for work in (self._receive_on, self._send_on)]
        for thread in self._threads:
            thread.start()

    def send(self, frame: Frame) -> bool:
        """Queue a frame; False if there is no room."""
        try:
            self._outgoing.put_nowait((time.monotonic(), frame))
        except Full:
            return False
        return True

    def stop(self) -> None:
        """End both threads and shut the bus down; blocks for at most a second or so."""
        self._stopping.set()
        with suppress(Empty):
            while True:
                self._outgoing.get_nowait()
        self._outgoing.put_nowait(None)
        for thread in self._threads:
            thread.join(0.5)
        with suppress(*DRIVER_FAULT):
            self._bus.shutdown()

    def _receive_on(self) -> None:
        reason = "the driver ended"
        try:
            while not self._stopping.is_set():
                self._receive_batch()
        except DRIVER_FAULT as fault:
            reason = f"{type(fault).__name__}: {fault}"
        finally:
            if not self._stopping.is_set():
                self._lost(reason)

    def _receive_batch(self) -> None:
        worked = time.thread_time()
        message = self._next(self._patience)
        if message is None:
            self._rest(time.thread_time() - worked)
        count = 0
        while message is not None:
            self._put(message)
            count += 1
            message = self._next(0) if count < BATCH else None
        if count:
            self._heard()

    def _rest(self, worked: float) -> None:
        """Nothing came. A driver that does not wait makes python-can spin: from then on we nap instead."""
        if worked > POLL / 2:
            self._patience = 0.0
        if not self._patience:
            self._stopping.wait(NAP)

    def _next(self, timeout: float) -> can.Message | None:
        try:
            message = self._bus.recv(timeout)
        except BROKEN_LINE:
            self._count("rejected")
            self._strikes += 1
            if self._strikes == STRIKES:
                raise
            return None
        if message is not None:
            self._strikes = 0
        return message

    def _put(self, message: can.Message) -> None:
        if len(self.inbox) >= INBOX:
            self.inbox.popleft()
            self._count("overrun")
        self.inbox.append(message)

    def _send_on(self) -> None:
        while (item := self._outgoing.get()) is not None:
            queued, frame = item
            if time.monotonic() - queued > STALE:
                self._count("dropped")
            else:
                self._send_one(frame)

    def _send_one(self, frame: Frame) -> None:
        message = can.Message(arbitration_id=frame.identifier, data=frame.data, is_extended_id=frame.extended)
        try:
            self._bus.send(message, timeout=SEND_WITHIN)
        except DRIVER_FAULT:
            self._count("errors")
            self._count("dropped")
        else:
            self._count("frames_out")


class PythonCanLink(Kept[list[Frame]]):
    """A bus of python-can's."""

    PAUSE: ClassVar[float] = 1.0

    def __init__(
        self,
        interface: str,
        channel: str | int,
        *,
        url: str = "",
        name: str = "",
        **parameters: Any,
    ) -> None:
        super().__init__(url=url, name=name)
        self.interface = interface
        self.channel = channel
        self.parameters = parameters
        self._attendance: Attendance | None = None

    async def _connect(self) -> None:
        bus = await asyncio.to_thread(open_bus, self.interface, self.channel, self.parameters)
        self._attendance = Attendance(
            bus,
            heard=partial(self._from_thread, self._deliver),
            lost=partial(self._from_thread, self._lost),
            count=partial(self._from_thread, self._count),
        )

    async def _disconnect(self) -> None:
        attendance, self._attendance = self._attendance, None
        if attendance is not None:
            await asyncio.to_thread(attendance.stop)

    def _from_thread(self, call: Callable[..., None], *arguments: str) -> None:
        with suppress(RuntimeError):  # the loop is closed: nobody is left to tell
            self._loop.call_soon_threadsafe(call, *arguments)

    def _count(self, field: str) -> None:
        setattr(self._tally, field, getattr(self._tally, field) + 1)

    def _deliver(self) -> None:
        if self._attendance is None:
            return
        inbox = self._attendance.inbox
        frames = [frame for _ in range(len(inbox)) if (frame := self._frame(inbox.popleft())) is not None]
        if frames:
            self._tally.frames_in += len(frames)
            self._receive(frames)

    def _frame(self, message: can.Message) -> Frame | None:
        if message.is_error_frame:
            self._tally.errors += 1
        elif message.is_remote_frame or message.is_fd:
            self._tally.rejected += 1
        else:
            return Frame(message.arbitration_id, bytes(message.data), message.is_extended_id)
        return None

    def send(self, frames: Sequence[Frame]) -> None:
        for frame in frames:
            if self._attendance is None or not self._attendance.send(frame):
                self._tally.dropped += 1
