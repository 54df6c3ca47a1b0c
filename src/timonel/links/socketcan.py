"""`socketcan://can0`: a CAN interface of the Linux kernel, by a raw socket on the loop.

Frames are drained up to 64 a wake-up; where they come one by one they are mostly taken so, for to find that
there is no other one costs more than to take one. What the kernel has no room for is dropped and counted: it
waits for a bus that does not acknowledge, and a late command is a wrong one. The controller's error frames are
counted and its state is told by `changed`. An interface that goes down says so once and is silent from then
on, so its flags are looked at every 0.5 s, together with the number of frames that we took too late. Bit
rate and restart after bus-off are set on the interface (`ip link set can0 up type can bitrate 250000
restart-ms 100`).

Source: linux/can.h, linux/can/error.h, linux/can/raw.h.
"""

import asyncio
import errno
import fcntl
import socket
import struct
from collections.abc import Callable, Sequence

from timonel.core.frame import Frame
from timonel.links.kept import Kept, text_of

CAN_FRAME = struct.Struct("=IB3x8s")
FRAME_SIZE = CAN_FRAME.size
EXTENDED, REMOTE, ERROR = 0x8000_0000, 0x4000_0000, 0x2000_0000
IDENTIFIER, ERROR_CLASS = 0x1FFF_FFFF, 0x1FFF_FFFF
CAN_RAW_ERR_FILTER = 2
BATCH = 64
ONE_BY_ONE = 4  # wake-ups that take one frame each after one that found no other
RECEIVE_BUFFER = 1 << 20
WATCH = 0.5

SIOCGIFFLAGS = 0x8913
INTERFACE_FLAGS = struct.Struct("=16sH22x")
UP_AND_RUNNING = 0x1 | 0x40
SO_MEMINFO = 55
MEMINFO = struct.Struct("=9I")  # the last of these is the number of frames dropped

CONTROLLER, BUS_OFF, RESTARTED = 0x4, 0x40, 0x100
PASSIVE, WARNING, ACTIVE = 0x30, 0x0C, 0x40


def can_socket(channel: str) -> socket.socket:
    """A raw socket on the CAN interface `channel` that hears error frames too; raises OSError."""
    can = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    try:
        can.setsockopt(socket.SOL_CAN_RAW, CAN_RAW_ERR_FILTER, socket.CAN_ERR_MASK)
        can.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        can.bind((channel,))
    except OSError:
        can.close()
        raise
    return can


def is_running(interface: socket.socket, channel: str) -> bool:
    """Whether the network interface `channel` is up and has a carrier; raises OSError if there is none."""
    request = INTERFACE_FLAGS.pack(channel.encode(), 0)
    _, flags = INTERFACE_FLAGS.unpack(fcntl.ioctl(interface, SIOCGIFFLAGS, request))
    return bool(flags & UP_AND_RUNNING == UP_AND_RUNNING)


def overrun_of(can: socket.socket) -> int:
    """Frames that the kernel has dropped so far because the socket's queue was full."""
    return int(MEMINFO.unpack(can.getsockopt(socket.SOL_SOCKET, SO_MEMINFO, MEMINFO.size))[-1])


def pack(frame: Frame) -> bytes:
    """`struct can_frame` of a frame."""
    identifier = frame.identifier | EXTENDED if frame.extended else frame.identifier
    return CAN_FRAME.pack(identifier, len(frame.data), frame.data)


def controller_state(error: int, data: bytes) -> tuple[bool, str] | None:
    """Whether the controller takes part, and how; None if the error frame does not tell."""
    if error & BUS_OFF:
        return False, "bus-off"
    if error & RESTARTED:
        return True, ""
    if not error & CONTROLLER:
        return None
    if data[1] & PASSIVE:
        return True, "error passive"
    if data[1] & WARNING:
        return True, "error warning"
    return (True, "") if data[1] & ACTIVE else None


class SocketCanLink(Kept[list[Frame]]):
    """A CAN interface of the kernel; `make` opens its socket."""

    def __init__(
        self,
        channel: str,
        *,
        make: Callable[[str], socket.socket] = can_socket,
        url: str = "",
        name: str = "",
    ) -> None:
        super().__init__(url=url, name=name)
        self.channel = channel
        self._make = make
        self._socket: socket.socket | None = None
        self._watch: asyncio.TimerHandle | None = None
        self._off = False
        self._overrun = 0
        self._one_by_one = 0

    async def _connect(self) -> None:
        can = self._make(self.channel)
        try:
            can.setblocking(False)
            if not is_running(can, self.channel):
                raise OSError(errno.ENETDOWN, "interface is down")
        except OSError:
            can.close()
            raise
        self._socket = can
        self._off = False
        self._overrun = 0
        self._loop.add_reader(can.fileno(), self._readable)
        self._watch = self._loop.call_later(WATCH, self._look)

    def _look(self) -> None:
        assert self._socket is not None
        try:
            running = is_running(self._socket, self.channel)
            overrun = overrun_of(self._socket)
        except OSError as fault:
            self._fail(fault)
            return
        self._tally.overrun += overrun - self._overrun
        self._overrun = overrun
        if running:
            self._watch = self._loop.call_later(WATCH, self._look)
        else:
            self._fail(OSError("interface is down"))

    def _readable(self) -> None:
        assert self._socket is not None
        receive = self._socket.recv
        unpack = CAN_FRAME.unpack
        frames: list[Frame] = []
        self._one_by_one -= 1
        try:
            for _ in range(BATCH if self._one_by_one < 0 else 1):
                identifier, size, data = unpack(receive(FRAME_SIZE))
                if identifier & (REMOTE | ERROR):
                    self._receive_other(identifier, data)
                else:
                    frames.append(Frame(identifier & IDENTIFIER, data[:size], identifier >= EXTENDED))
        except BlockingIOError:
            self._one_by_one = ONE_BY_ONE if len(frames) == 1 else 0
        except OSError as fault:
            self._fail(fault)
        if not frames:
            return
        self._tally.frames_in += len(frames)
        if self._off:  # a bus that talks is not off, whether or not the driver told of its restart
            self._off = False
            self._tell(True, "")
        self._receive(frames)

    def _receive_other(self, identifier: int, data: bytes) -> None:
        if not identifier & ERROR:
            self._tally.rejected += 1
            return
        self._tally.errors += 1
        if state := controller_state(identifier & ERROR_CLASS, data):
            self._off = not state[0]
            self._tell(*state)

    def send(self, frames: Sequence[Frame]) -> None:
        for frame in frames:
            self._send_one(frame)

    def _send_one(self, frame: Frame) -> None:
        if self._socket is None:
            self._tally.dropped += 1
            return
        try:
            self._socket.send(pack(frame))
        except BlockingIOError:
            self._tally.dropped += 1
        except OSError as fault:
            self._tally.dropped += 1
            if fault.errno != errno.ENOBUFS:
                self._fail(fault)
        else:
            self._tally.frames_out += 1

    def _fail(self, fault: OSError) -> None:
        """Stop at once; the keeper opens another socket when the interface is back."""
        self._shut()
        self._lost(text_of(fault))

    def _shut(self) -> None:
        if self._watch is not None:
            self._watch.cancel()
        can, self._socket = self._socket, None
        if can is not None:
            self._loop.remove_reader(can.fileno())
            can.close()

    async def _disconnect(self) -> None:
        self._shut()
