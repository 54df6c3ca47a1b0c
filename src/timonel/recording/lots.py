"""Messages of one kind, kept until they are many: what a table costs however few rows it has is paid once for them.

As payloads they take a fraction of the memory that their values will take. Needs the extra `columns`.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from timonel.recording.assembly import Group
from timonel.recording.tables import Lot, some

ROWS = 1 << 16
"""Messages of a kind that are enough."""

ENOUGH = 1 << 21
"""Bytes of a kind that are enough, so that those of long messages do not become too much when they are decoded."""

HELD = 16 << 20
"""Bytes that are kept, of all kinds."""


class Lots:
    """Takes the lots of one chunk after the other, gives larger ones, the messages in the order of the recording."""

    def __init__(self) -> None:
        self._kept: dict[tuple[str, int | None], _Kind] = {}

    def receive(self, lots: Iterable[Lot]) -> Iterator[Lot]:
        """What has become enough; what nothing explains is not kept, for it may be of any number of PGNs."""
        for lot in lots:
            if (name := lot.name) is None:
                yield lot
            else:
                self._kept.setdefault((name, lot.messages.frame), _Kind()).add(lot)
        for key in [key for key, kind in self._kept.items() if kind.rows >= ROWS or kind.size >= ENOUGH]:
            yield self._kept.pop(key).whole()
        while sum(kind.size for kind in self._kept.values()) > HELD:
            largest = max(self._kept, key=lambda key: self._kept[key].size)
            yield self._kept.pop(largest).whole()

    def finish(self) -> Iterator[Lot]:
        """What is left."""
        while self._kept:
            yield self._kept.popitem()[1].whole()


class _Kind:
    """Lots of one kind, in memory of their own: as they came, they are pieces of whole chunks."""

    def __init__(self) -> None:
        self.rows = 0
        self.size = 0
        self._lots: list[Lot] = []

    def add(self, lot: Lot) -> None:
        columns = [column.copy() for column in _columns(lot.messages)]
        self.rows += len(columns[0])
        self.size += sum(column.nbytes for column in columns)
        self._lots.append(Lot(lot.definition, _group(lot.messages, columns)))

    def whole(self) -> Lot:
        lots, first = self._lots, self._lots[0]
        if len(lots) == 1:
            return first
        columns = map(_joined, zip(*(_columns(lot.messages) for lot in lots), strict=True))
        return Lot(first.definition, _in_order(_group(first.messages, columns)))


def _in_order(group: Group) -> Group:
    """Messages of several PGNs that share a definition came one PGN after the other."""
    row = group.row
    return group if (row[1:] >= row[:-1]).all() else some(group, np.argsort(row, kind="stable"))


def _columns(group: Group) -> tuple[npt.NDArray[Any], ...]:
    return msgspec.structs.astuple(group)[2:]


def _group(like: Group, columns: Iterable[npt.NDArray[Any]]) -> Group:
    return Group(like.pgn, like.frame, *columns)


def _joined(parts: Sequence[npt.NDArray[Any]]) -> npt.NDArray[Any]:
    """One behind the other; payloads as wide as the widest."""
    widths = {part.shape[1:] for part in parts}
    if len(widths) == 1:
        return np.concatenate(parts)
    joined = np.zeros((sum(map(len, parts)), *max(widths)), parts[0].dtype)
    end = 0
    for part in parts:
        start, end = end, end + len(part)
        joined[start:end, : part.shape[1]] = part
    return joined
