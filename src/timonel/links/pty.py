"""`pty://path`: a pseudo-terminal for programs on the same machine, who find it at `path`.

A program may open, close and reopen it as often as it likes. While none has it open the link is not
connected and lines are dropped, so that the next one starts with news. `path` is a symbolic link to the
terminal; one left behind is replaced, anything else that stands there is left alone, and ours is removed at
`close`.
"""

import os
import select
import termios
import tty
from contextlib import suppress
from typing import ClassVar

from timonel.links.wire import Port, Wire


class PtyLink(Port):
    """A pseudo-terminal; `mode` is the terminal's permission bits, `None` leaves what the system gives.

    The system tells its far end nothing when a program opens the terminal, so we look every 0.1 s.
    """

    PAUSE: ClassVar[float] = 0.1

    def __init__(self, path: str, *, mode: int | None = None, url: str = "", name: str = "") -> None:
        super().__init__(url=url, name=name)
        self.path = path
        self.mode = mode
        self._fd: int | None = None
        self._terminal = ""

    async def _make_wire(self) -> Wire:
        if self._fd is None:
            self._make_terminal()
        assert self._fd is not None
        if not in_use(self._fd):
            raise OSError("no program has it open")
        return Wire(
            self._fd,
            receive=self._receive,
            lost=self._lost,
            release=self._empty,
            tally=self._tally,
            stale_after=self.stale_after,
        )

    def _make_terminal(self) -> None:
        fd, program_end = os.openpty()
        try:
            tty.setraw(program_end)
            self._terminal = os.ttyname(program_end)
            if self.mode is not None:
                os.chmod(self._terminal, self.mode)
            place_symlink(self._terminal, self.path)
        except OSError:
            os.close(fd)
            raise
        finally:
            os.close(program_end)
        self._fd = fd

    def _empty(self) -> None:
        """Leave the next program neither what the last one did not read nor how it set the terminal."""
        with suppress(OSError, termios.error):
            program_end = os.open(self._terminal, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            try:
                tty.setraw(program_end, termios.TCSANOW)
                termios.tcflush(program_end, termios.TCIOFLUSH)  # reaches deeper than TCSAFLUSH
            finally:
                os.close(program_end)

    async def close(self, drain: float = 0.5) -> None:
        await super().close(drain)
        if self._fd is not None:
            with suppress(OSError):
                if os.readlink(self.path) == self._terminal:
                    os.unlink(self.path)
            os.close(self._fd)
            self._fd = None


def in_use(fd: int) -> bool:
    """Whether a program has the other end of the pseudo-terminal `fd` open, or has left something in it."""
    poll = select.poll()
    poll.register(fd, select.POLLIN)
    events = dict(poll.poll(0)).get(fd, 0)
    return bool(events & select.POLLIN) or not events & select.POLLHUP


def place_symlink(target: str, path: str) -> None:
    """Make `path` a symbolic link to `target`; raises FileExistsError if anything else is there."""
    if os.path.lexists(path) and not os.path.islink(path):
        raise FileExistsError("in the way: something that is not a symbolic link")
    with suppress(FileNotFoundError):
        os.unlink(path)
    os.symlink(target, path)
