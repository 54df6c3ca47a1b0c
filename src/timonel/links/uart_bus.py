"""A rover's UART as a bus: the frames of a dialect over a port, both ways, as CAN frames with 11-bit identifiers.

What waits for room on the port is the newest frame of each identifier, and a permission or stop goes ahead of all.
"""

import asyncio
import math
from collections.abc import Sequence

from timonel.core.effects import Say
from timonel.core.frame import Frame
from timonel.links.framed import FramedBus
from timonel.links.link import ByteLink
from timonel.vehicles.rover.frames import DriveEnable
from timonel.vehicles.rover.framing import Framer


class UartBus(FramedBus):
    """Frames over `port`; `framer` reads those of the far end's direction, and its counters are the link's quality."""

    def __init__(self, port: ByteLink, framer: Framer) -> None:
        super().__init__(port)
        self.framer = framer
        self._timer: asyncio.TimerHandle | None = None

    async def close(self, drain: float = 0.5) -> None:
        """Close the port."""
        await super().close(drain)
        self._disarm()

    def send(self, frames: Sequence[Frame]) -> None:
        """Write `frames`; one that the dialect cannot carry is dropped and counted."""
        lines = [_say(self.framer, frame) for frame in frames if self._fits(frame)]
        self._frames_out += len(lines)
        self._dropped += len(frames) - len(lines)
        self._port.send(lines)

    def _fits(self, frame: Frame) -> bool:
        return frame.identifier <= 0xFF and not frame.extended and len(frame.data) <= self.framer.LONGEST

    def _hear(self, data: bytes) -> None:
        self._hand_over(_frames(self.framer.receive(data, self._loop.time())))
        self._arm()

    def _port_changed(self, connected: bool, reason: str) -> None:
        """What comes from now on does not belong to what came before."""
        self._disarm()
        self._hand_over(_frames(self.framer.finish()))
        self._changed(connected, reason)

    def _arm(self) -> None:
        """See to it that silence is noticed."""
        self._disarm()
        if self.framer.deadline < math.inf:
            self._timer = self._loop.call_at(self.framer.deadline, self._expire)

    def _disarm(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _expire(self) -> None:
        self._hand_over(_frames(self.framer.expire(self._loop.time())))
        self._arm()


def _frames(read: list[tuple[int, bytes]]) -> list[Frame]:
    return [Frame(identifier, data, extended=False) for identifier, data in read]


def _say(framer: Framer, frame: Frame) -> Say:
    line = framer.write(frame.identifier, frame.data)
    urgent = frame.identifier == DriveEnable.FRAME
    return Say(line, str(frame.identifier), urgent=urgent, state=urgent)
