"""A port on which not everything goes out: some sentences only, and no more bytes than it carries.

What may go out is `timonel.nmea0183.selection`'s matter, what first where there is not room for all
`timonel.nmea0183.ration`'s. Ports without such wishes are not wrapped in this, and cost nothing more.
"""

import asyncio
from collections.abc import Callable, Mapping, Sequence

from timonel.core.effects import Say
from timonel.links.link import ByteLink, Changed, Counters
from timonel.nmea0183.ration import Ration
from timonel.nmea0183.selection import Selector

TICK = 0.005  # s: what may go out within so little time goes out together


class Shaped:
    """`port`, with what is sent on it chosen and rationed."""

    def __init__(self, port: ByteLink, selector: Selector | None, ration: Ration | None) -> None:
        self.url = port.url
        self.name = port.name
        self._port = port
        self._selector = selector
        self._ration = ration
        self._loop = asyncio.get_running_loop()
        self._connected = False
        self._timer: asyncio.TimerHandle | None = None

    @property
    def counters(self) -> Counters:
        return self._port.counters

    @property
    def skipped(self) -> Mapping[str, int]:
        """Lines for which there was no room before a newer one came, by formatter."""
        return {} if self._ration is None else self._ration.skipped

    async def open(self, receive: Callable[[bytes], None], changed: Changed) -> None:
        self._changed = changed
        await self._port.open(receive, self._port_changed)

    async def close(self, drain: float = 0.5) -> None:
        """End; what waits for its share goes as far as there is time."""
        end = self._loop.time() + drain
        while self._ration is not None and self._ration.waiting and self._loop.time() < end:
            await asyncio.sleep(0.01)
        if self._timer is not None:
            self._timer.cancel()
        await self._port.close(max(0.0, end - self._loop.time()))

    # Once a batch and port.
    def send(self, lines: Sequence[Say]) -> None:
        self.send_whatever(lines if self._selector is None else self._selector.choose(lines, self._loop.time()))

    def send_whatever(self, lines: Sequence[Say]) -> None:
        """`send` without choosing: for what is meant for this port alone."""
        if self._ration is not None and self._connected:
            lines = self._ration.give(lines, self._loop.time())
            if self._ration.waiting:
                self._arm(self._ration)
        if lines:
            self._port.send(lines)

    def _arm(self, ration: Ration) -> None:
        due = max(ration.deadline, self._loop.time() + TICK)
        if self._timer is not None:
            if self._timer.when() <= due:
                return
            self._timer.cancel()
        self._timer = self._loop.call_at(due, self._take, ration)

    def _take(self, ration: Ration) -> None:
        self._timer = None
        if lines := ration.take(self._loop.time()):
            self._port.send(lines)
        if ration.waiting:
            self._arm(ration)

    def _port_changed(self, connected: bool, reason: str) -> None:
        """Who was not there does not hear later what waited."""
        self._connected = connected
        if self._ration is not None and not connected:
            self._ration.clear()
        self._changed(connected, reason)
