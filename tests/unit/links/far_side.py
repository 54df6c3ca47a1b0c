"""The other ends of links, for tests: an ear, a USB adapter that can be pulled, and patience."""

import asyncio
import os
import tty
from collections.abc import Callable
from pathlib import Path

from timonel.core.effects import Say
from timonel.core.frame import Frame


class Ear:
    """Takes down what a link delivers and what it tells about itself."""

    def __init__(self) -> None:
        self.data = b""
        self.frames: list[Frame] = []
        self.batches = 0
        self.changes: list[tuple[bool, str]] = []

    def receive(self, data: bytes) -> None:
        self.data += data

    def receive_frames(self, frames: list[Frame]) -> None:
        self.frames += frames
        self.batches += 1

    def changed(self, connected: bool, reason: str) -> None:
        self.changes.append((connected, reason))

    @property
    def connected(self) -> bool:
        return bool(self.changes) and self.changes[-1][0]


class Adapter:
    """A USB serial adapter played by a pseudo-terminal: one path, a new device at every plugging."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.plug()

    def plug(self) -> None:
        self.fd, device = os.openpty()
        tty.setraw(device)
        os.set_blocking(self.fd, False)
        os.symlink(os.ttyname(device), self.path)
        os.close(device)

    def pull(self) -> None:
        os.unlink(self.path)
        os.close(self.fd)

    def say(self, data: bytes) -> None:
        os.write(self.fd, data)

    def hear(self) -> bytes:
        try:
            return os.read(self.fd, 65536)
        except OSError:
            return b""


async def until(condition: Callable[[], object], within: float = 10.0) -> None:
    """Wait for it, and fail when it does not come."""
    async with asyncio.timeout(within):
        while not condition():
            await asyncio.sleep(0.002)


async def hears(adapter: Adapter, expected: bytes) -> None:
    """Wait until exactly this came out of an adapter."""
    heard = b""
    async with asyncio.timeout(10):
        while len(heard) < len(expected):
            heard += adapter.hear()
            await asyncio.sleep(0.002)
    assert heard == expected


def line(text: str, key: str = "", *, urgent: bool = False) -> Say:
    return Say(text.encode() + b"\r\n", key or text, urgent)


def descriptors() -> int:
    return len(os.listdir("/proc/self/fd"))
