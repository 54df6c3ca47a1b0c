"""What every link is: a port that carries bytes, or a bus that carries frames.

A link is made by `timonel.links.urls` from its URL, opened once, and then looks after itself: when the far
side goes away it is opened again, at the latest a second after it is back, until `close`. All calls and all
callbacks happen on the loop that `open` was called on; `send` neither waits nor raises for anything a peer
does.
"""

from collections.abc import Callable, Sequence
from typing import Protocol

import msgspec

from timonel.core.effects import Say
from timonel.core.frame import Frame

Changed = Callable[[bool, str], None]
"""Told at every change: whether the link is connected, and why or in what state (`""`: nothing to say)."""


class Counters(msgspec.Struct, gc=False):
    """What went through a link, and what did not, since it was made. What `counters` gives is a copy."""

    bytes_in: int = 0
    bytes_out: int = 0
    frames_in: int = 0
    frames_out: int = 0
    replaced: int = 0
    """Unsent lines whose place a newer line of the same key took."""
    dropped: int = 0
    """Lines or frames that were not sent: nobody there, no room, or too old."""
    rejected: int = 0
    """Incoming lines, frames or readers that were not accepted."""
    overrun: int = 0
    """Incoming frames that were lost because we did not take them fast enough."""
    errors: int = 0
    """Error frames of the bus and errors that the adapter or the system reported."""
    reopened: int = 0
    """How often the link came back after it was lost."""


class Link(Protocol):
    """What ports and buses share."""

    url: str
    name: str

    @property
    def counters(self) -> Counters: ...

    async def close(self, drain: float = 0.5) -> None:
        """End the link; what still waits to be sent has `drain` seconds to go."""


class ByteLink(Link, Protocol):
    """A port: bytes both ways."""

    async def open(self, receive: Callable[[bytes], None], changed: Changed) -> None:
        """Start; returns when the first attempt was made and `changed` has told how it went."""

    def send(self, lines: Sequence[Say]) -> None:
        """Write `lines` at once, or what there is room for; see `timonel.links.backlog` for the rest."""


class BusLink(Link, Protocol):
    """A CAN bus: frames both ways. Frames that it sent itself do not come back."""

    async def open(self, receive: Callable[[list[Frame]], None], changed: Changed) -> None:
        """Start; returns when the first attempt was made and `changed` has told how it went."""

    def send(self, frames: Sequence[Frame]) -> None:
        """Put `frames` on the bus; what there is no room for is dropped: a late command is a wrong one."""
