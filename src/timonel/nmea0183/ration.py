"""A port that carries only so many bytes a second is filled by what matters, not by what comes first.

```
first   urgent lines (STATUS, transfer of command, alerts): at once, if need be ahead of the port by `burst` bytes;
        beyond that they wait, oldest first, at most 256; one that tells a state takes an older one's place
then    data, the newest line of each key: of the formatters that wait the one that has had least of its share
```
Shares are by weight (`WEIGHTS`): start-time fair queueing, in bytes. Whatever a formatter does not need, the others
get; none is starved, and an idle one saves nothing up. A line that was still waiting when a newer one of its key came
is counted in `skipped` under its formatter.
"""

from collections import Counter, deque
from collections.abc import Sequence

import msgspec

from timonel.core.effects import Say
from timonel.nmea0183.selection import formatter

WEIGHTS = {
    name: weight
    for weight, names in {
        8.0: "HDT THS HDG HDM ROT RSA HTD RMC GLL GGA VTG RMB APB XTE",
        4.0: "DPT DBT VHW MWV MWD",
        2.0: "VDM VDO",
    }.items()
    for name in names.split()
}
"""How much of a port a formatter may have beside the others that wait; what is not here weighs 1."""

SMALLEST_BURST = 256  # bytes: three of the longest sentences
BURST_SECONDS = 0.1
URGENT_MAX = 256
ROUNDING = 1e-6  # bytes: at its deadline a line has room
KEYS_MAX = 512  # of one formatter: AIS has one a ship


class _Flow(msgspec.Struct, gc=False):
    """What waits of one formatter: the newest line of each key, in the order of the keys' coming."""

    weight: float
    start: float = 0.0
    waiting: dict[str, Say] = {}


class Ration:
    """The lines of one port of `rate` bytes/s; told the time in s, which never goes back."""

    def __init__(self, rate: float) -> None:
        self.rate = rate
        self.burst = max(SMALLEST_BURST, rate * BURST_SECONDS)
        self.skipped: Counter[str] = Counter()
        self._room = self.burst
        self._then = 0.0
        self._urgent: deque[Say] = deque()
        self._flows: dict[str, _Flow] = {}
        self._busy: dict[str, _Flow] = {}
        self._virtual = 0.0

    @property
    def waiting(self) -> bool:
        """Whether something waits for its turn."""
        return bool(self._urgent or self._busy)

    # Runs once a batch and port; where there is room for all of it nothing is looked at.
    def give(self, lines: Sequence[Say], now: float) -> Sequence[Say]:
        """What goes out now: of `lines`, and of what waited."""
        self._refill(now)
        if not self.waiting and (size := sum([len(say.line) for say in lines])) <= self._room:
            self._room -= size
            return lines
        for say in lines:
            if say.urgent:
                self._add_urgent(say)
            else:
                self._add(say)
        return self._take()

    def take(self, now: float) -> Sequence[Say]:
        """What has its turn by now."""
        self._refill(now)
        return self._take()

    @property
    def deadline(self) -> float:
        """When the next line has its turn, infinity if none waits. Only as of the last `give` or `take`."""
        if self._urgent:
            return self._then + max(0.0, 1.0 - self.burst - self._room) / self.rate
        if not self._busy:
            return float("inf")
        needed = min(self.burst, len(self._next()[2].line))  # a line longer than that goes when nothing else could
        return self._then + max(0.0, needed - self._room) / self.rate

    def clear(self) -> None:
        """Forget what waits: it would be sent late."""
        for say in self._urgent:
            self.skipped[formatter(say.line)] += 1
        for name, flow in self._busy.items():
            self.skipped[name] += len(flow.waiting)
            flow.waiting = {}
        self._urgent.clear()
        self._busy.clear()

    def _refill(self, now: float) -> None:
        self._room = min(self.burst, self._room + (now - self._then) * self.rate)
        self._then = now

    def _add_urgent(self, say: Say) -> None:
        if say.state:
            older = [other for other in self._urgent if other.state and other.key == say.key]
            for other in older:
                self._urgent.remove(other)
                self.skipped[formatter(other.line)] += 1
        if len(self._urgent) == URGENT_MAX:
            self.skipped[formatter(self._urgent.popleft().line)] += 1
        self._urgent.append(say)

    def _add(self, say: Say) -> None:
        name = formatter(say.line)
        flow = self._flows.get(name)
        if flow is None:
            flow = self._flows[name] = _Flow(WEIGHTS.get(name, 1.0))
        if not flow.waiting:
            flow.start = max(flow.start, self._virtual)
            self._busy[name] = flow
        elif say.key in flow.waiting:
            self.skipped[name] += 1
        elif len(flow.waiting) == KEYS_MAX:
            flow.waiting.pop(next(iter(flow.waiting)))
            self.skipped[name] += 1
        flow.waiting[say.key] = say

    def _next(self) -> tuple[str, _Flow, Say]:
        """The formatter whose turn it is: that which would have had its share first."""
        best, due = "", float("inf")
        for name, flow in self._busy.items():
            end = flow.start + len(next(iter(flow.waiting.values())).line) / flow.weight
            if end < due:
                best, due = name, end
        flow = self._busy[best]
        return best, flow, next(iter(flow.waiting.values()))

    def _take(self) -> list[Say]:
        taken = []
        while self._urgent and self._room > -self.burst:
            taken.append(self._spend(self._urgent.popleft()))
        while self._busy:
            name, flow, say = self._next()
            if min(self.burst, len(say.line)) > self._room + ROUNDING:
                break
            taken.append(self._spend(say))
            self._virtual = max(self._virtual, flow.start)
            flow.start += len(say.line) / flow.weight
            del flow.waiting[say.key]
            if not flow.waiting:
                del self._busy[name]
        return taken

    def _spend(self, say: Say) -> Say:
        self._room -= len(say.line)
        return say
