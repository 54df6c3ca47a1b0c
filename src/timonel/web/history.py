"""The last hour at 1 Hz, in memory: a ring of 32-bit numbers for each value, NaN where there was none.

Degrees of a position would lose metres in 32 bits: they are kept in 64.
"""

from array import array
from collections.abc import Iterable, Mapping
from math import isnan, nan

HOUR = 3600  # samples kept
PERIOD = 1.0  # s between two
PRECISE = ("latitude", "longitude")


class History:
    """Values by name, one sample a second."""

    def __init__(self, names: Iterable[str], samples: int = HOUR) -> None:
        self.samples = samples
        self.count = 0
        """How many were taken in all."""
        self.ended = 0.0
        """When the last one was taken, s."""
        self._rings = {name: array("d" if name in PRECISE else "f", [nan]) * samples for name in names}

    @property
    def names(self) -> list[str]:
        """What is kept."""
        return list(self._rings)

    def take(self, values: Mapping[str, float | None], now: float) -> None:
        """One more sample of everything, taken at `now`; seconds that were missed are left empty."""
        missed = round(now - self.ended - PERIOD) if self.count else 0
        for _ in range(min(missed, self.samples)):
            self._put({})
        self._put(values)
        self.ended = now

    def _put(self, values: Mapping[str, float | None]) -> None:
        place = self.count % self.samples
        for name, ring in self._rings.items():
            value = values.get(name)
            ring[place] = nan if value is None else value
        self.count += 1

    def copy(self) -> "History":
        """As it stands now, for somebody who takes his time."""
        copy = History((), self.samples)
        copy.count, copy.ended = self.count, self.ended
        copy._rings = {name: ring[:] for name, ring in self._rings.items()}
        return copy

    def last(self, name: str, samples: int, step: int = 1) -> list[float | None]:
        """The last `samples` of a value, every `step`-th, oldest first; fewer if there are no more."""
        ring = self._rings[name]
        last = self.count - 1
        begin = max(0, self.count - min(samples, self.samples))
        places = range(begin + (last - begin) % step, self.count, step)
        return [_number(ring[place % self.samples], name) for place in places]


def _number(value: float, name: str) -> float | None:
    return None if isnan(value) else round(value, 7 if name in PRECISE else 5)
