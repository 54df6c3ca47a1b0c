"""A port whose far end is in this program: the console speaks on one for each station.

It is a link as any other, so that what it says goes the way of the wires: recorded, replayed, limited, and bound to its
station.
"""

from collections.abc import Callable, Sequence

import msgspec

from timonel.core.effects import Say
from timonel.links.link import Changed, Counters


class InnerLink:
    """Bytes given to `say` are what comes in. Not connected until `plug` says so; what is sent is heard by nobody."""

    def __init__(self, *, name: str) -> None:
        self.url = "inner://"
        self.name = name
        self.connected = False
        self._tally = Counters()
        self._receive: Callable[[bytes], None] | None = None
        self._changed: Changed | None = None

    @property
    def counters(self) -> Counters:
        return msgspec.structs.replace(self._tally)

    async def open(self, receive: Callable[[bytes], None], changed: Changed) -> None:
        self._receive, self._changed = receive, changed

    async def close(self, drain: float = 0.5) -> None:
        self._receive = self._changed = None

    def send(self, lines: Sequence[Say]) -> None:
        """Whoever is here sees what happened without being told."""

    def say(self, data: bytes) -> None:
        """Let `data` come in; all that follows from it has happened on return."""
        if self._receive is not None:
            self._tally.bytes_in += len(data)
            self._receive(data)

    def plug(self, connected: bool, reason: str = "") -> None:
        """Somebody is here, or has left."""
        self.connected = connected
        if self._changed is not None:
            self._changed(connected, reason)
