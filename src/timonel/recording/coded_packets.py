"""Fast packets put together by the compiled kernels, frame by frame; what is not plain is left to others.

Runs and plain ones are those of `fast_packets`. Needs the extra `columns`.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from timonel import native
from timonel.recording.frames import Rows, Stamps
from timonel.recording.part import Part, Payloads

Ints = npt.NDArray[np.intp]
Flags = npt.NDArray[np.bool_]
Codes = npt.NDArray[np.uint16]
Counts = npt.NDArray[np.uint32]
Octets = npt.NDArray[np.uint8]

SLOT_ROOM = 1 << 22
"""Bytes in which the kernel keeps what it knows of 65,536 slots; only of those that are there is it used."""
_FRAME_SHARE = 14  # bytes that the kernel may take of the room for payloads: some messages stay without all frames


class CodedPackets:
    """Room for the runs of frames whose codes are `first` or more, `counts` of each, and for the messages of those runs
    that are plain."""

    def __init__(self, first: int, counts: Counts) -> None:
        frames = int(counts[first:].sum())

        def room(kind: type[Any], size: int = 1) -> npt.NDArray[Any]:
            return np.empty(size * frames, kind)

        self._first, self._counts = first, counts
        self.others: Ints = room(np.intp)  # the rows of runs that are not plain
        self.begin: Ints = room(np.intp)  # the row of the first frame of each run, as what follows
        self.last: Ints = room(np.intp)
        self.count: npt.NDArray[np.int32] = room(np.int32)
        self.slot: Codes = room(np.uint16)
        self.dirty: Flags = room(np.bool_)  # it is not plain
        self._run: npt.NDArray[np.int32] = room(np.int32)  # of each message that may be plain, by code
        self._row: Ints = room(np.intp)
        self._identifier: Counts = room(np.uint32)
        self._size: Ints = room(np.intp)
        self._offset: Ints = room(np.intp)
        self._payloads: Payloads = room(np.uint8, _FRAME_SHARE)
        self._ends = np.zeros(len(counts), np.intp)  # of the messages of each code

    def read(
        self, rows: Rows, now: Stamps, codes: Codes, slots: Octets, streams: Codes, known: int, waiting: Codes,
        limits: tuple[int, int, int],
    ) -> int:  # fmt: skip
        """Find the runs of the rows with these codes, in the slots of which some are `waiting`.

        `slots` is `SLOT_ROOM` to work in. `streams` that are new are numbered on from `known`: how many are known then,
        -1 if that are too many, or a frame has no data. `limits` are the longest age, the longest gap, both in ns, and
        the longest message.
        """
        known, runs, others = native.kernels.fast_packets(
            rows, now, codes, self._first, self._counts, limits, slots, streams, known, waiting,
            self.others, self.begin, self.last, self.count, self.slot, self.dirty,
            self._ends, self._run, self._row, self._identifier, self._size, self._offset, self._payloads,
        )  # fmt: skip
        self.others = self.others[:others]
        self.begin, self.last, self.count = self.begin[:runs], self.last[:runs], self.count[:runs]
        self.slot, self.dirty = self.slot[:runs], self.dirty[:runs]
        return known

    def parts(self, channels: Sequence[int]) -> list[Part]:
        """The messages of plain runs, in the order of their codes, whose `channels` these are."""
        parts = []
        end = 0
        for code in np.flatnonzero(self._counts[self._first :]).tolist():
            code += self._first
            begin, end = end, end + int(self._counts[code])
            if (part := self._part(channels[code], slice(begin, int(self._ends[code])))) is not None:
                parts.append(part)
        return parts

    def _part(self, channel: int, some: slice) -> Part | None:
        row, identifier = self._row[some], self._identifier[some]
        size, offset = self._size[some], self._offset[some]
        dirty = self.dirty.take(self._run[some])
        if dirty.any():
            kept = np.flatnonzero(~dirty)
            row, identifier, size, offset = row.take(kept), identifier.take(kept), size.take(kept), offset.take(kept)
        if not len(row):
            return None
        return Part(channel, row, identifier, self._payloads_of(offset, size), size)

    def _payloads_of(self, offset: Ints, size: Ints) -> Payloads:
        """Of messages that stand at an offset each."""
        first, width = int(offset[0]), 7 * (int(size[0]) // 7 + 1) + 1
        equal = int(size[-1]) // 7 == int(size[0]) // 7
        if equal and (np.diff(offset) == width).all() and int(size.max()) <= width:  # they lie side by side
            return self._payloads[first : first + width * len(size)].reshape(-1, width)
        payloads = np.empty((len(size), max(6, int(size.max()))), np.uint8)
        native.kernels.cut_payloads(self._payloads, offset, size, payloads, payloads.shape[1])
        return payloads
