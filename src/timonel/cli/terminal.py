"""The terminal as a keyboard, on the event loop."""

import asyncio
import os
import termios
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from timonel.cli.keys import Keys

ESCAPE_WAITS = 0.1  # s; a sequence that comes over a slow line must not look like the escape key

_CC, _IFLAG = 6, 0


@contextmanager
def keyboard(fd: int, press: Callable[[str], None], closed: Callable[[], None]) -> Iterator[None]:
    """Tells every key of terminal `fd` to `press`, and `closed` when the terminal is gone.

    Keys come without echo and at once. Ctrl-C still interrupts; Ctrl-Z and Ctrl-S do nothing, since a helm that
    stands still unseen is worse than none. The terminal is put back as it was, whatever happens.
    """
    before = termios.tcgetattr(fd)
    reader = _Reader(fd, press, closed)
    try:
        tty.setcbreak(fd)
        _leave_running(fd)
        reader.start()
        yield
    finally:
        reader.stop()
        termios.tcsetattr(fd, termios.TCSAFLUSH, before)


def _leave_running(fd: int) -> None:
    attributes = termios.tcgetattr(fd)
    attributes[_IFLAG] &= ~termios.IXON
    attributes[_CC][termios.VSUSP] = b"\0"
    termios.tcsetattr(fd, termios.TCSANOW, attributes)


class _Reader:
    def __init__(self, fd: int, press: Callable[[str], None], closed: Callable[[], None]) -> None:
        self._fd = fd
        self._press = press
        self._closed = closed
        self._keys = Keys()
        self._loop = asyncio.get_running_loop()
        self._timer: asyncio.TimerHandle | None = None

    def start(self) -> None:
        self._loop.add_reader(self._fd, self._readable)

    def stop(self) -> None:
        self._loop.remove_reader(self._fd)
        if self._timer is not None:
            self._timer.cancel()

    def _readable(self) -> None:
        try:
            data = os.read(self._fd, 1024)
        except OSError:
            data = b""
        if not data:
            self.stop()
            self._closed()
            return
        self._tell(self._keys.receive(data))
        if self._timer is not None:
            self._timer.cancel()
        if self._keys.pending:
            self._timer = self._loop.call_later(ESCAPE_WAITS, lambda: self._tell(self._keys.expire()))

    def _tell(self, keys: list[str]) -> None:
        for key in keys:
            self._press(key)
