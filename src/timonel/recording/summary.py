"""What a recording has, told without decoding it all: what is sent how often, by whom, and what was lost.

Needs the extra `columns`.
"""

from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np

from timonel.nmea2000.catalogue import Definition, variants
from timonel.nmea2000.catalogue_columns import select
from timonel.nmea2000.fastpacket import FastPacketCounters
from timonel.recording.assembly import Assembly, Group
from timonel.recording.formats import LogReader
from timonel.recording.frames import NO_STAMP, Identifiers
from timonel.recording.lines import Unreadable
from timonel.recording.tables import Selected, Selection
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.segments import SINGLE

CLAIM, PRODUCT = 60928, 126996
"""The PGNs in which a device tells who it is."""

LOSSES = ("interrupted", "broken", "expired", "headless", "evicted", "malformed")
"""The counters of fast packets that stand for something lost."""


class Tally(msgspec.Struct, gc=False):
    """Messages of one kind: how many, and when the first and the last one came (unix ns, None without times)."""

    name: str | None
    title: str
    count: int = 0
    first: int | None = None
    last: int | None = None

    @property
    def rate(self) -> float | None:
        """Messages a second, from the first to the last one; None where that cannot be said."""
        if self.first is None or self.last is None or self.last == self.first:
            return None
        return (self.count - 1) * 1e9 / (self.last - self.first)


class Device(msgspec.Struct, gc=False):
    """Who sends from an address; `claim`, `product` and its NAME (in hex) are what it last said of itself."""

    messages: int = 0
    name: str | None = None
    claim: dict[str, Any] | None = None
    product: dict[str, Any] | None = None


class Summary(msgspec.Struct):
    """Of one recording. `messages` are by (PGN, name) or (-1 - frame, name), `devices` by address."""

    file: str
    format: str = ""
    timed: bool = False
    dated: bool = False
    frames: int = 0
    unreadable_count: int = 0
    unreadable: list[Unreadable] = []
    messages: dict[tuple[int, str | None], Tally] = {}
    devices: dict[int, Device] = {}
    counters: FastPacketCounters = msgspec.field(default_factory=FastPacketCounters)
    first: int | None = None
    last: int | None = None

    @property
    def count(self) -> int:
        """Whole messages."""
        return sum(tally.count for tally in self.messages.values())

    @property
    def lost(self) -> int:
        """Fast packets, or frames of them, that came to nothing."""
        return sum(getattr(self.counters, name) for name in LOSSES)

    @property
    def seconds(self) -> float | None:
        """From the first frame to the last; None without times."""
        return None if self.first is None or self.last is None else (self.last - self.first) / 1e9


def _widened(known: Tally | Summary, first: int, last: int) -> tuple[int, int]:
    """The span of both."""
    if known.first is None or known.last is None:
        return first, last
    return min(known.first, first), max(known.last, last)


class Summariser:
    """Takes the groups of a recording as they come."""

    def __init__(self, file: str, protocol: Protocol) -> None:
        self.summary = Summary(file)
        self._protocol = protocol

    def receive(self, groups: Sequence[Group]) -> Selected:
        """Count them; what had to be looked at for it need not be looked at again."""
        selected: dict[int, Selection] = {}
        self._sources([group.identifier for group in groups if group.pgn is not None])
        for group in groups:
            if group.frame is not None:
                self._own(group)
            elif group.pgn is not None:
                self._bus(group, group.pgn, selected)
        return selected

    def finish(self, log: LogReader, assembly: Assembly) -> Summary:
        """What the reader and the assembly have counted goes with it."""
        summary = self.summary
        summary.format, summary.timed, summary.dated = log.format, log.timed, log.dated
        summary.frames = log.frames
        summary.unreadable_count, summary.unreadable = log.unreadable_count, log.unreadable
        summary.counters = assembly.counters
        return summary

    def _sources(self, identifiers: Sequence[Identifiers]) -> None:
        """How many messages each address has sent: told apart once a chunk, not once a PGN."""
        if not identifiers:
            return
        counts = np.bincount(np.concatenate(identifiers).astype(np.uint8))
        for source in np.flatnonzero(counts).tolist():
            self.summary.devices.setdefault(source, Device()).messages += int(counts[source])

    def _bus(self, group: Group, pgn: int, selected: dict[int, Selection]) -> None:
        known = variants(pgn)
        if len(known) == 1 and pgn not in (CLAIM, PRODUCT) and not known[0].pattern[0]:
            self._count(pgn, known[0], group)
        else:
            selected[pgn] = select(pgn, group.payloads, group.lengths)
            for definition, rows in selected[pgn]:
                self._count(pgn, definition, group, rows)
        if pgn in (CLAIM, PRODUCT):
            self._introduce(group, pgn)

    def _own(self, group: Group) -> None:
        assert group.frame is not None
        declared = self._protocol.declaration(group.frame)
        name = declared.__name__ if declared else None
        halves = declared is not None and declared.SEGMENTED and declared.size > SINGLE
        rows = np.flatnonzero(group.lengths != SINGLE) if halves else np.arange(len(group.row))
        if len(rows):
            self._tally((-1 - group.frame, name), name or "", group, rows)

    def _count(self, pgn: int, definition: Definition | None, group: Group, rows: Any = slice(None)) -> None:
        name, title = (definition.id, definition.title) if definition else (None, "")
        self._tally((pgn, name), title, group, rows)

    def _tally(self, key: tuple[int, str | None], title: str, group: Group, rows: Any) -> None:
        stamps = group.stamp[rows]
        first, last = int(stamps.min()), int(stamps.max())
        if first == NO_STAMP and last != NO_STAMP:
            first = int(stamps[stamps != NO_STAMP].min())
        summary = self.summary
        tally = summary.messages.get(key)
        if tally is None:
            tally = summary.messages[key] = Tally(key[1], title)
        tally.count += len(stamps)
        if last != NO_STAMP:
            tally.first, tally.last = _widened(tally, first, last)
            summary.first, summary.last = _widened(summary, first, last)

    def _introduce(self, group: Group, pgn: int) -> None:
        """The last word of each device about itself."""
        latest = dict(zip(group.source.tolist(), range(len(group.row)), strict=True))
        for source, row in latest.items():
            payload = group.payloads[row, : group.lengths[row]].tobytes()
            fields = variants(pgn)[0].as_dict(payload)
            device = self.summary.devices[source]
            if pgn == CLAIM:
                device.claim, device.name = fields, payload[::-1].hex().upper()
            else:
                device.product = fields
