"""Fast packets put together by the compiled kernels, frame by frame; what is not plain is left to others.

Runs and plain ones are those of `fast_packets`. Needs the extra `columns`.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from timonel import native
from timonel.recording.frames import EXTENDED, Rows, Stamps
from timonel.recording.part import FIRST_FAST, Part, Payloads, pgns_of, stretches

Ints = npt.NDArray[np.intp]
Flags = npt.NDArray[np.bool_]
Codes = npt.NDArray[np.uint16]
Octets = npt.NDArray[np.uint8]

SLOT_ROOM = 1 << 22
"""Bytes in which the kernel keeps what it knows of 65,536 slots; only of those that are there is it used."""


class CodedPackets:
    """Room for the runs of `frames` frames, and for the messages that those are which are plain."""

    def __init__(self, frames: int) -> None:
        def room(kind: type[Any], size: int = 1) -> npt.NDArray[Any]:
            return np.empty(size * frames, kind)

        self.row: Ints = room(np.intp)  # of each frame, as what follows
        self._run: npt.NDArray[np.int32] = room(np.int32)
        self.begin: Ints = room(np.intp)  # the row of the first frame of each run, as what follows
        self.last: Ints = room(np.intp)
        self.count: npt.NDArray[np.int32] = room(np.int32)
        self.slot: Codes = room(np.uint16)
        self.dirty: Flags = room(np.bool_)  # it is not plain
        self._message: npt.NDArray[np.int32] = room(np.int32)  # the run of each message that may be plain
        self._offset: Ints = room(np.intp)
        self._payloads: Payloads = room(np.uint8, 7)

    def read(
        self, rows: Rows, now: Stamps, codes: Codes, first: int, slots: Octets, streams: Codes, known: int,
        waiting: Codes, limits: tuple[int, int, int],
    ) -> int:  # fmt: skip
        """Find the runs of the rows whose code is `first` or more, in the slots of which some are `waiting`.

        `slots` is `SLOT_ROOM` to work in. `streams` that are new are numbered on from `known`: how many are known then,
        -1 if that are too many, or a frame has no data. `limits` are the longest age, the longest gap, both in ns, and
        the longest message.
        """
        room = (self.row, self._run, self.begin, self.last, self.count, self.slot, self.dirty)
        messages = (self._message, self._offset, self._payloads)
        known, runs, count = native.kernels.fast_packets(
            rows, now, codes, first, slots, streams, known, waiting, *room, *messages, *limits
        )
        self.begin, self.last, self.count = self.begin[:runs], self.last[:runs], self.count[:runs]
        self.slot, self.dirty = self.slot[:runs], self.dirty[:runs]
        self._message, self._offset = self._message[:count], self._offset[:count]
        return known

    @property
    def others(self) -> Ints:
        """The rows of runs that are not plain."""
        return self.row[self.dirty.take(self._run)] if self.dirty.any() else self.row[:0]

    def parts(self, rows: Rows) -> list[Part]:
        """The messages of plain runs, by PGN."""
        kept = np.flatnonzero(~self.dirty.take(self._message))
        row = self.last.take(self._message.take(kept))
        identifier = rows["identifier"][row] & np.uint32(EXTENDED - 1)
        pgn = pgns_of(identifier)
        order = np.argsort((pgn - np.uint32(FIRST_FAST)).astype(np.uint16), kind="stable")  # 16 bits are sorted fastest
        kept, row = kept.take(order), row.take(order)
        pgn, identifier = pgn.take(order), identifier.take(order)
        run = self._message.take(kept)
        size = rows["data"][self.begin.take(run), 1].astype(np.intp)
        offset = self._offset.take(kept)
        parts = []
        for start, stop in stretches(pgn):
            some = slice(start, stop)
            payloads = self._cut(offset[some], size[some])
            parts.append(Part(int(pgn[start]), row[some], identifier[some], payloads, size[some]))
        return parts

    def _cut(self, offset: Ints, size: Ints) -> Payloads:
        payloads = np.empty((len(size), max(6, int(size.max()))), np.uint8)
        native.kernels.cut_payloads(self._payloads, offset, size, payloads, payloads.shape[1])
        return payloads
