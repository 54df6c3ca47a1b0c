"""`loop://name`: a bus within this process. Every end opened on a name hears what the others send, in order.

Frames arrive by the loop, never within `send`. An end that falls behind loses its oldest frames, counted as
overrun.
"""

from asyncio import AbstractEventLoop
from collections.abc import Sequence
from weakref import WeakKeyDictionary

from timonel.core.frame import Frame
from timonel.links.kept import Kept

QUEUE = 4096


class LoopLink(Kept[list[Frame]]):
    """One end of an in-process bus."""

    def __init__(self, channel: str, *, url: str = "", name: str = "") -> None:
        super().__init__(url=url, name=name)
        self.channel = channel
        self._ends: list[LoopLink] | None = None
        self._waiting: list[Frame] = []

    async def _connect(self) -> None:
        self._ends = _buses.setdefault(self._loop, {}).setdefault(self.channel, [])
        self._ends.append(self)

    async def _disconnect(self) -> None:
        if self._ends is not None:
            self._ends.remove(self)
            self._ends = None

    def send(self, frames: Sequence[Frame]) -> None:
        if self._ends is None:
            self._tally.dropped += len(frames)
            return
        self._tally.frames_out += len(frames)
        for end in self._ends:
            if end is not self:
                end._arrive(frames)

    def _arrive(self, frames: Sequence[Frame]) -> None:
        if not self._waiting:
            self._loop.call_soon(self._deliver)
        self._waiting.extend(frames)
        if (excess := len(self._waiting) - QUEUE) > 0:
            del self._waiting[:excess]
            self._tally.overrun += excess

    def _deliver(self) -> None:
        frames, self._waiting = self._waiting, []
        if frames and self._ends is not None:
            self._tally.frames_in += len(frames)
            self._receive(frames)


_buses: WeakKeyDictionary[AbstractEventLoop, dict[str, list[LoopLink]]] = WeakKeyDictionary()
