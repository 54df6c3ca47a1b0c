"""`file://log?speed=1`: a recording played as a bus, on its own time.

`speed=2` is twice as fast, `speed=max` as fast as the loop takes it; `loop=yes` starts again at the end.
The format is told from the content; a message that its recorder had put together goes out in fast-packet
frames as it came. Lines that could not be read are counted as rejected, what is sent to a recording as
dropped.
"""

import asyncio
import os
import stat
from collections.abc import Sequence
from contextlib import suppress

from timonel.core.frame import Frame
from timonel.errors import RecordingError
from timonel.links.kept import Kept
from timonel.nmea2000.fastpacket import fragment
from timonel.recording import LogFrame, LogReader, open_log

BATCH = 64
SOON = 0.001


class FileLink(Kept[list[Frame]]):
    """A recording as a bus. `speed` is a multiple of its own pace, None without any pace."""

    def __init__(
        self,
        path: str,
        *,
        speed: float | None = 1.0,
        loop: bool = False,
        url: str = "",
        name: str = "",
    ) -> None:
        super().__init__(url=url, name=name)
        self.path = path
        self.speed = speed
        self.loop = loop
        self._ended = ""
        self._sequence = 0
        self._player: asyncio.Task[None] | None = None

    async def _connect(self) -> None:
        if self._ended:
            raise OSError(self._ended)
        self._player = self._loop.create_task(self._play(self._open()), name=f"play {self.path}")

    def _open(self) -> LogReader:
        if not stat.S_ISREG(os.stat(self.path).st_mode):
            raise OSError("not a regular file")
        try:
            return open_log(self.path)
        except RecordingError as fault:
            raise OSError(str(fault)) from fault

    async def _disconnect(self) -> None:
        player, self._player = self._player, None
        if player is not None:
            player.cancel()
            with suppress(asyncio.CancelledError):
                await player

    def send(self, frames: Sequence[Frame]) -> None:
        self._tally.dropped += len(frames)

    async def _play(self, log: LogReader) -> None:
        try:
            await self._play_once(log)
            while self.loop:
                await self._play_once(self._open())
            self._ended = "end of the recording"
        except OSError as fault:
            self._ended = str(fault)
        self._lost(self._ended)

    async def _play_once(self, log: LogReader) -> None:
        pace = Pace(self.speed, self._loop.time())
        batch: list[Frame] = []
        with log:
            for entry in log:
                wait = pace.wait(entry.stamp, self._loop.time())
                if wait > SOON or len(batch) >= BATCH:
                    self._hand_over(batch)
                    batch = []
                    await asyncio.sleep(wait)
                batch += self._frames(entry)
        self._hand_over(batch)
        self._tally.rejected += log.unreadable_count
        await asyncio.sleep(0)

    def _frames(self, entry: LogFrame) -> list[Frame]:
        if not entry.whole:
            return [entry.frame]
        self._sequence = (self._sequence + 1) % 8
        return [Frame(entry.identifier, data) for data in fragment(entry.data, self._sequence)]

    def _hand_over(self, batch: list[Frame]) -> None:
        if batch:
            self._tally.frames_in += len(batch)
            self._receive(batch)


class Pace:
    """When the entries of a recording are due. Stamps that run backwards start the count anew."""

    def __init__(self, speed: float | None, now: float) -> None:
        self._speed = speed
        self._start = now
        self._first: float | None = None
        self._last = 0.0

    def wait(self, stamp: float | None, now: float) -> float:
        """Seconds from `now` until the entry with this stamp is due; 0 if it has none, or is late."""
        if stamp is None or self._speed is None:
            return 0.0
        if self._first is None or stamp < self._last:
            self._first, self._start = stamp, now
        self._last = stamp
        return max(0.0, self._start + (stamp - self._first) / self._speed - now)
