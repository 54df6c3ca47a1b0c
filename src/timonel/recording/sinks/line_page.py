"""A page of lines that are written by the kernel (`native/page.c`), in the steps of `line_steps`. Needs `columns`."""

from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from timonel import native
from timonel.recording.assembly import Group
from timonel.recording.sinks.line_steps import LineSteps, Written
from timonel.recording.sinks.texts import Sizes
from timonel.recording.tables import some

_START = 1 << 20  # bytes of a page, until more are needed

# Of what native/page.c has: numbers of a table, of a line that is left out, and of where the page is.
_TABLE, _GAP, _STATE = 8, 3, 5
_SIZE, _GAPS = 1, 4

Ints = npt.NDArray[np.int64]
ByHand = Callable[[Group, str | None], bytes]
"""(one message, its name) -> its line, written as that of a single message."""


class Stop(IntEnum):
    """Why the kernel stopped, as in native/page.c: for more room, or for the text of a code."""

    DONE, ROOM, NEW_CODE = range(3)


class Stepped(msgspec.Struct, frozen=True, eq=False, gc=False):
    """Messages of one kind that are written in steps."""

    written: Written
    name: str | None
    messages: Group

    @property
    def row(self) -> tuple[int, ...]:
        """A table, as in native/page.c."""
        return *msgspec.structs.astuple(self.written), *self.messages.payloads.shape, 0

    @property
    def columns(self) -> list[npt.NDArray[Any]]:
        """As in native/page.c."""
        group = self.messages
        return [np.ascontiguousarray(one) for one in (group.stamp, group.identifier, group.payloads, group.lengths)]


class LinePage:
    """Writes lines of many messages, chunk by chunk, on a page that is used again. `day` is `JsonLines`'."""

    def __init__(self, steps: LineSteps, day: int | None, by_hand: ByHand) -> None:
        self._steps = steps
        self._day = day
        self._by_hand = by_hand
        self._page = np.empty(_START, np.uint8)

    def lines(self, lots: Sequence[Stepped], first: int, made: memoryview, sizes: Sizes) -> memoryview:
        """The lines of a chunk, whose first frame is number `first`, in the order of its frames.

        Lines that were `made` otherwise are among them: of `sizes[frame]` bytes, none where that is 0.
        """
        owners = np.where(sizes > 0, np.int32(-1), np.int32(0))
        for number, lot in enumerate(lots, 1):
            owners[lot.messages.row - first] = number
        tables = np.array([lot.row for lot in lots], np.int64).reshape(-1, _TABLE)
        columns = [column for lot in lots for column in lot.columns]
        state, gaps, sizes = np.zeros(_STATE, np.int64), np.empty((len(owners), _GAP), np.int64), sizes[sizes > 0]
        clock = self._day or 0, self._day is not None
        why = -1
        while why != Stop.DONE:
            known = self._steps.texts, self._steps.slots, self._steps.steps
            chunk = owners, made, sizes, tables, self._page, state, gaps
            why, step, code = native.kernels.json_lines(*known, *chunk, columns, *clock)
            if why == Stop.ROOM:
                self._page = np.concatenate((self._page, np.empty_like(self._page)))
            elif why == Stop.NEW_CODE:
                self._steps.learn(step, code)
        written = self._page[: state[_SIZE]].data
        return self._filled(lots, written, gaps[: state[_GAPS]]) if state[_GAPS] else written

    def _filled(self, lots: Sequence[Stepped], written: memoryview, gaps: Ints) -> memoryview:
        """The same with the lines that the kernel left out."""
        pieces: list[memoryview | bytes] = []
        before = 0
        for number, row, place in gaps.tolist():
            message = some(lots[number].messages, np.array([row]))
            pieces += [written[before:place], self._by_hand(message, lots[number].name)]
            before = place
        return memoryview(b"".join([*pieces, written[before:]]))
