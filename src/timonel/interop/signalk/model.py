"""The newest of every path, and when it changed: what REST shows, and what of it a client has not been told yet."""

from collections.abc import Iterable, Mapping

import msgspec

from timonel.interop.signalk.told import Told, Value, Values


class Entry(msgspec.Struct, frozen=True, gc=False):
    """The newest value of a path: who told it, when (s), and the number of the update that brought it."""

    value: Value
    source: str
    heard: float
    changed: int


class Model:
    """What was told so far. `sequence` counts the updates that brought something new."""

    def __init__(self) -> None:
        self.sequence = 0
        self.entries: dict[str, Entry] = {}
        self._told: dict[str, Told] = {}
        self._nothing: dict[str, Values] = {}
        """Null for every path that a key ever had, so that its newest says it all."""

    def update(self, known: Iterable[Told], now: float) -> list[Told]:
        """Take over all that is known at `now` (s): what is new in it, with null for what is no more."""
        latest = {told.key: told for told in known}
        gone = [self._vanished(key, now) for key in self._told.keys() - latest.keys()]
        news = [self._new(told, now) for told in latest.values() if self._told.get(told.key) != told]
        self._told = latest
        if changed := [told for told in gone + news if told.values]:
            self.sequence += 1
            for told in changed:
                self._keep(told, now)
        return changed

    def _new(self, told: Told, now: float) -> Told:
        nothing = self._nothing.setdefault(told.key, {})
        nothing |= dict.fromkeys(told.values)
        return Told(told.key, told.source, now if told.heard is None else told.heard, nothing | told.values)

    def _vanished(self, key: str, now: float) -> Told:
        return Told(key, self._told[key].source, now, dict(self._nothing[key]))

    def _keep(self, told: Told, now: float) -> None:
        heard = now if told.heard is None else told.heard
        for path, value in told.values.items():
            self.entries[path] = Entry(value, told.source, heard, self.sequence)

    def everything(self) -> list[Told]:
        """All that is known, as for somebody who has been told nothing."""
        return grouped(self.entries)


def grouped(entries: Mapping[str, Entry]) -> list[Told]:
    """Entries by path as what was told at once, from the same source at the same time."""
    groups: dict[tuple[str, float], Values] = {}
    for path, entry in entries.items():
        groups.setdefault((entry.source, entry.heard), {})[path] = entry.value
    return [Told("", source, heard, values) for (source, heard), values in groups.items()]
