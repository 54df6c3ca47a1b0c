"""What one client of the stream wants to be told, and when. A pure machine.

```
policy     a value is told
instant    when it changes, at most every minPeriod
ideal      the same, and again when it has not changed for a period
fixed      every period, changed or not
```
A row that names a period and no policy is fixed, one that names neither is instant, as signalk-server has it.
Source: Signal K 1.7.0, Subscription Protocol.
"""

from collections.abc import Iterator
from typing import Annotated, Literal

import msgspec

from timonel.interop.signalk.model import Model

Millis = Annotated[float, msgspec.Meta(ge=0, le=3_600_000)]
Policy = Literal["instant", "ideal", "fixed"]

PERIOD = 1000.0  # ms
ROWS_MAX = 100
EARLY = 0.05  # s: half of what lies between two looks, so that a period of 1 s is one on average


class Row(msgspec.Struct, frozen=True):
    """One line of a subscription."""

    path: Annotated[str, msgspec.Meta(max_length=200)]
    period: Millis | None = None
    policy: Policy | None = None
    min_period: Millis = msgspec.field(default=0.0, name="minPeriod")

    @property
    def how(self) -> Policy:
        """The policy, where it is not said too."""
        return self.policy or ("instant" if self.period is None else "fixed")

    def due(self, changed: bool, since: float) -> bool:
        """Whether a value is to be told that was told `since` s ago, and has `changed` or not."""
        period = (PERIOD if self.period is None else self.period) / 1000 - EARLY
        if self.how == "fixed":
            return since >= period
        if changed:
            return since >= self.min_period / 1000
        return self.how == "ideal" and since >= period


class Unwanted(msgspec.Struct, frozen=True):
    """A path that is to be told no more."""

    path: Annotated[str, msgspec.Meta(max_length=200)] = "*"


class Message(msgspec.Struct, frozen=True):
    """What a client may say. All else in it is passed over; what it tells of itself (`updates`) is not taken."""

    context: str | None = None
    subscribe: list[Row] = []
    unsubscribe: list[Unwanted] = []
    put: object = None
    request_id: Annotated[str, msgspec.Meta(max_length=100)] | None = msgspec.field(default=None, name="requestId")


EVERYTHING = Row("*")


class Subscriptions:
    """The rows of one client, and what it was told of each path."""

    def __init__(self, *rows: Row) -> None:
        self._rows = list(rows)
        self._told: dict[str, tuple[int, float]] = {}
        self._fitting: dict[str, list[Row]] = {}

    @property
    def everything(self) -> bool:
        """Whether it wants all as it comes, which is told to all such clients in the same words."""
        return self._rows == [EVERYTHING]

    def subscribe(self, rows: list[Row]) -> bool:
        """More rows; False if they are too many."""
        if len(self._rows) + len(rows) > ROWS_MAX:
            return False
        self._rows += rows
        self._fitting.clear()
        return True

    def unsubscribe(self, pattern: str) -> None:
        """No more rows of that path; "*" is none at all."""
        self._rows = [row for row in self._rows if pattern not in ("*", row.path)]
        self._fitting.clear()

    def due(self, model: Model, now: float) -> list[str]:
        """The paths that are to be told at `now` (s)."""
        return list(self._due(model, now))

    def _due(self, model: Model, now: float) -> Iterator[str]:
        for path, entry in model.entries.items():
            number, when = self._told.get(path, (-1, float("-inf")))
            changed, since = entry.changed > number, now - when
            if any(row.due(changed, since) for row in self._rows_of(path)):
                yield path

    def _rows_of(self, path: str) -> list[Row]:
        rows = self._fitting.get(path)
        if rows is None:
            rows = self._fitting[path] = [row for row in self._rows if matches(row.path, path)]
        return rows

    def told(self, paths: list[str], model: Model, now: float) -> None:
        """These were told."""
        for path in paths:
            self._told[path] = model.entries[path].changed, now


def matches(pattern: str, path: str) -> bool:
    """Whether a path fits a pattern, in which `*` is any number of characters. Takes time as long as the path."""
    first, *middle = pattern.split("*")
    if not middle:
        return pattern == path
    last = middle.pop()
    if not (path.startswith(first) and path.endswith(last) and len(path) >= len(first) + len(last)):
        return False
    place, end = len(first), len(path) - len(last)
    for part in middle:
        place = path.find(part, place, end)
        if place < 0:
            return False
        place += len(part)
    return True
