"""`serial:///dev/ttyUSB0?baud=115200`: a serial port, 8N1, opened by serialx and read and written as a wire.

Any path will do; one below `/dev/serial/by-id` finds the same adapter again in whatever socket it is
plugged. The port is locked for us alone. What the driver has taken but not yet sent is kept below a tenth
of a second, so that newer lines still have something to replace on a slow wire.
"""

import fcntl
import struct
import termios
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from timonel.links.wire import Port, Wire, Wired

if TYPE_CHECKING:
    from serialx import Serial

Incoming = TypeVar("Incoming")

DRIVER_HOLDS = 0.1  # seconds of the line's own time
LONGEST_LINE = 256


def open_serial(path: str, baud: int) -> "Serial":
    """The port, open, raw and locked; raises OSError. It can take milliseconds, so not on the loop."""
    import serialx

    port: Serial = serialx.Serial(path, baudrate=baud)  # type: ignore[abstract]  # chosen at run time
    try:
        port.open()
    except termios.error as fault:
        raise OSError(*fault.args) from fault
    except serialx.SerialException as fault:
        raise OSError(str(fault)) from fault
    return port


def held_by_driver(fd: int) -> int:
    """Bytes that the driver has taken and not sent yet."""
    with suppress(OSError):
        return int(struct.unpack("i", fcntl.ioctl(fd, termios.TIOCOUTQ, bytes(4)))[0])
    return 0


def close_serial(port: "Serial") -> None:
    """Close at once: a driver that still holds something may wait half a minute for a line that is stuck."""
    if held_by_driver(port.fileno()):
        with suppress(termios.error):
            termios.tcflush(port.fileno(), termios.TCOFLUSH)
    port.close()


def room_on_line(fd: int, baud: int) -> int:
    """Bytes that the driver may be given now: what the line sends in `DRIVER_HOLDS`, less what waits."""
    return max(LONGEST_LINE, int(baud / 10 * DRIVER_HOLDS)) - held_by_driver(fd)


class OnSerial(Wired[Incoming]):
    """Opens a serial port off the loop; shared with adapters that speak over one."""

    def __init__(self, path: str, *, baud: int = 115200, url: str = "", name: str = "") -> None:
        super().__init__(url=url, name=name)
        self.path = path
        self.baud = baud

    async def _open_serial(self) -> "Serial":
        # if we are cancelled meanwhile, nobody takes the result, and serialx closes what is collected
        return await self._loop.run_in_executor(None, open_serial, self.path, self.baud)


class SerialLink(OnSerial[bytes], Port):
    """A station's wire."""

    async def _make_wire(self) -> Wire:
        port = await self._open_serial()
        self._fd = fd = port.fileno()
        return Wire(
            fd,
            receive=self._receive,
            lost=self._lost,
            release=partial(close_serial, port),
            tally=self._tally,
            room=partial(room_on_line, fd, self.baud),
            stale_after=self.stale_after,
        )

    def _pending(self) -> bool:
        return self._wire is not None and (self._wire.pending or held_by_driver(self._fd) > 0)
