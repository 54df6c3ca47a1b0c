"""Recordings as tables: one a message, with a column a field. Needs the extra `columns`.

```python
for table in decode_file("log.candump", pgns={127250}):
    table.name, table.time, table.messages.source, table.fields["heading"].values
```
A file of any size is read in chunks, each of which gives its own tables; the rows of a table are in the order of the
recording. What no definition explains is a table too, with its payloads.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path

import msgspec
import numpy as np
import numpy.typing as npt

from timonel.nmea2000.catalogue import Definition
from timonel.nmea2000.catalogue_columns import AnyColumn, Items, columns, select
from timonel.recording.assembly import PACE, Assembly, Group
from timonel.recording.chunks import open_frames
from timonel.recording.frames import NO_STAMP
from timonel.recording.part import STANDARD, of_messages
from timonel.vehicles.rover.declaration import RoverFrame
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.segments import SINGLE, Joiner

CHUNK = 1 << 20
"""Frames at a time: what is done once a table and chunk costs less than what is done once a row, and the memory stays
below 150 MiB."""

_LARGEST = (1 << 25) - (1 << 13)  # bytes of the largest block that glibc may keep, with what stands around it


Selection = Sequence[tuple[Definition | None, npt.NDArray[np.intp]]]
"""The definitions that occur, and the rows of each."""
Selected = Mapping[int, Selection]
"""By PGN."""
NOTHING: Selected = {}


class Lot(msgspec.Struct, frozen=True, eq=False, gc=False):
    """Messages of one kind, not decoded yet. `definition` is canboat's or the rover's frame, None if there is none."""

    definition: Definition | type[RoverFrame] | None
    messages: Group

    @property
    def name(self) -> str | None:
        """As `vesselHeading`, or `MotorCurrentRight`."""
        match self.definition:
            case None:
                return None
            case Definition():
                return self.definition.id
        return self.definition.__name__


class Table(Lot, frozen=True, eq=False, gc=False):
    """Messages of one kind with their values.

    `fields` are by canboat's id, with `groups` for repeating sets; `signals`, float64[n] each, by the rover's name.
    """

    fields: Mapping[str, AnyColumn] = {}
    groups: tuple[Items, ...] = ()
    signals: dict[str, npt.NDArray[np.float64]] = {}

    @property
    def time(self) -> npt.NDArray[np.float64]:
        """float64[n], unix seconds, NaN where the recording does not tell."""
        stamp = self.messages.stamp
        return np.where(stamp == NO_STAMP, np.nan, seconds(stamp))


def seconds(stamp: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
    """Of ns: whole microseconds are what a float of unix seconds holds."""
    return stamp // 1000 / 1e6


class Tables:
    """Makes tables of messages, chunk by chunk; those of standard identifiers by a rover's `protocol`."""

    def __init__(self, protocol: Protocol | None = None, labels: bool = True) -> None:
        self._protocol = protocol or Protocol()
        self._labels = labels
        self._joiner = Joiner({number: frame.size for number, frame in self._protocol.declarations.items()})

    def receive(self, groups: Iterable[Group]) -> Iterator[Table]:
        """The tables of a chunk's messages. `labels` is `catalogue_columns.columns`'."""
        return map(self.table, self.lots(groups))

    def lots(self, groups: Iterable[Group], selected: Selected = NOTHING) -> Iterator[Lot]:
        """A chunk's messages by what explains them, which for some PGNs was `selected` before."""
        for group in groups:
            if group.pgn is not None:
                known = selected.get(group.pgn)
                for definition, rows in known or select(group.pgn, group.payloads, group.lengths):
                    yield Lot(definition, group if len(rows) == len(group.row) else some(group, rows))
            elif group.frame is not None:
                yield from self._rover(group.frame, group)

    def table(self, lot: Lot) -> Table:
        """The values of some messages of one kind."""
        definition, messages = lot.definition, lot.messages
        if isinstance(definition, Definition):
            found = columns(definition, messages.payloads, messages.lengths, self._labels)
            return Table(definition, messages, found.fields, found.groups)
        if definition is None:
            return Table(None, messages)
        signals = self._protocol.columns(definition.FRAME, messages.payloads[:, : definition.size])
        return Table(definition, messages, signals=signals)

    def _rover(self, number: int, group: Group) -> Iterator[Lot]:
        declared = self._protocol.declaration(number)
        if declared is None:
            yield Lot(None, group)
            return
        if declared.SEGMENTED and declared.size > SINGLE:
            group = self._joined(group)
        fits = group.lengths == declared.size
        for definition, there in ((declared, fits), (None, ~fits)):
            if (rows := np.flatnonzero(there)).size:
                yield Lot(definition, some(group, rows))

    def _joined(self, group: Group) -> Group:
        """The halves of segmented frames put together, one after the other."""
        found: list[tuple[int, int, bytes]] = []
        now = np.where(group.stamp == NO_STAMP, group.row * PACE, group.stamp) / 1e9
        columns = (group.lengths, group.identifier, now)
        for place, (length, number, time) in enumerate(zip(*(column.tolist() for column in columns), strict=True)):
            data: bytes | None = group.payloads[place, :length].tobytes()
            if length <= SINGLE:
                data = self._joiner.receive(number, group.payloads[place, :length].tobytes(), time)
            if data is not None:
                found.append((place, number, data))
        if not found:
            return some(group, np.empty(0, np.intp))
        part = of_messages(STANDARD + found[0][1], found)
        kept = some(group, part.row)
        return Group(None, group.frame, kept.row, kept.stamp, kept.identifier, part.payloads, part.lengths)


def some(group: Group, rows: npt.NDArray[np.intp]) -> Group:
    """Some of the messages."""
    kept = (column.take(rows, axis=0) for column in msgspec.structs.astuple(group)[2:])
    return Group(group.pgn, group.frame, *kept)


def decode_file(
    path: str | Path,
    pgns: Collection[int] | None = None,
    standard: Collection[int] | None = None,
    *,
    protocol: Protocol | None = None,
    strict: bool = False,
    chunk: int = CHUNK,
) -> Iterator[list[Table]]:
    """The tables of each chunk of a recording, of some PGNs and standard identifiers only or, with neither, of all.

    `strict` and the errors are those of `open_log`.
    """
    keep_memory()
    assembly, tables = Assembly(pgns, standard), Tables(protocol)
    for frames in open_frames(path, strict, chunk):
        yield list(tables.receive(assembly.receive(frames)))


@cache
def keep_memory() -> None:
    """Have the C library keep the memory that a chunk took for the next one.

    glibc gives blocks of more than 128 KiB back at once, and getting them again, page by page, costs more than most of
    what is done with them; but having seen a larger one come back, it keeps all that are smaller.
    """
    np.empty(_LARGEST, np.uint8)
