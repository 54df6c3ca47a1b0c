"""The messages of a recording, from frames that are read thousands at a time. Needs the extra `columns`.

Fast packets are put together in columns; one by one, only the messages are made, each when it is asked for.
"""

from collections.abc import Iterator
from itertools import chain

import msgspec
import numpy as np
import numpy.typing as npt

from timonel.nmea2000.fastpacket import FastPacketCounters
from timonel.nmea2000.schedule import FAST, FAST_RANGES
from timonel.recording.assembly import PACE, Assembly, Group
from timonel.recording.chunks import FrameReader
from timonel.recording.decoded import ADDRESSES, Decoder, Message, OwnMessage, made
from timonel.recording.formats import LogReader
from timonel.recording.frames import EXTENDED, NO_STAMP, Frames, Identifiers, Stamps
from timonel.recording.part import STANDARD, Lengths, Payloads, pgns_of

CHUNK = 1 << 14
"""Frames at a time: enough that what is done once for all of them costs little, few enough for a processor's cache."""

Rows = npt.NDArray[np.int64]
Times = list[float | None]


class Lot(msgspec.Struct, frozen=True, eq=False):
    """Messages: the row of the frame that completed each, its stamp and identifier (see `frames`), and their data."""

    row: Rows
    stamp: Stamps
    identifier: Identifiers
    data: list[bytes]


class Messages:
    """The messages of the frames of a log; those of a rover are made by `decoder`."""

    def __init__(self, log: LogReader, decoder: Decoder) -> None:
        self._frames = FrameReader(log, CHUNK)
        self._decoder = decoder
        self._fast = _fast()
        places = np.flatnonzero(self._fast).astype(np.uint32)
        self._assembly = Assembly(pgns_of(places << np.uint32(8)).tolist())
        self._dated = log.dated
        self._tick, self._second = (1, 1e9) if log.format == "MCAP" else (1000, 1e6)

    @property
    def counters(self) -> FastPacketCounters:
        return self._assembly.counters

    # Once a message: all in one generator, for each one in another costs as much as the message.
    def __iter__(self) -> Iterator[Message | OwnMessage]:
        for frames in self._frames:
            lot = self._lot(frames)
            times, identifiers = self._times(lot.stamp), lot.identifier.tolist()
            if not np.all(lot.identifier >= EXTENDED):
                yield from self._with_own(lot, times, identifiers)
                continue
            for time, identifier, data in zip(times, identifiers, lot.data, strict=True):
                priority, pgn, source, destination, _, definition, find = ADDRESSES[identifier]
                yield Message(time, priority, source, destination, pgn, data, find(data) if find else definition)

    def _with_own(self, lot: Lot, times: Times, identifiers: list[int]) -> Iterator[Message | OwnMessage]:
        """The messages of a bus that a rover is on."""
        now = np.where(lot.stamp == NO_STAMP, lot.row * PACE, lot.stamp).tolist()
        for row, time, identifier, data in zip(now, times, identifiers, lot.data, strict=True):
            if identifier < EXTENDED:
                message = self._decoder.own(time, identifier, data, row)
                if message is not None:
                    yield message
            else:
                yield made(time, identifier, data)

    def _lot(self, frames: Frames) -> Lot:
        """The messages that these frames complete, in their order."""
        first = self._assembly.frames
        groups = self._assembly.receive(frames)
        return _ordered([self._single(frames, first), *map(_of_group, groups)])

    def _single(self, frames: Frames, first: int) -> Lot:
        """The frames that are messages, those of a rover, too; `first` is the row of the first of all."""
        identifier = frames.identifier
        place = np.flatnonzero((identifier < EXTENDED) | ~self._fast[identifier >> 8 & STANDARD - 1])
        some = frames[place]
        data = _cells(some.data, some.length.astype(np.intp))
        for row in np.flatnonzero(some.length > 8).tolist():
            data[row] = some.payload(row)
        return Lot(place + first, some.stamp, some.identifier, data)

    def _times(self, stamp: Stamps) -> Times:
        """Unix seconds: the same quotients as where frames are read one by one."""
        if not self._dated:
            return [None] * len(stamp)
        times: Times = (stamp // self._tick / self._second).tolist()
        for place in np.flatnonzero(stamp == NO_STAMP).tolist():
            times[place] = None
        return times


def _fast() -> npt.NDArray[np.bool_]:
    """Whether an identifier is that of a fast packet, by its PGN, with a destination in it or not."""
    fast = np.zeros(STANDARD, np.bool_)
    fast[list(FAST)] = True
    for first, last in FAST_RANGES:
        fast[first : last + 1] = True
    return fast


def _of_group(group: Group) -> Lot:
    return Lot(group.row, group.stamp, group.identifier | np.uint32(EXTENDED), _cells(group.payloads, group.lengths))


def _ordered(lots: list[Lot]) -> Lot:
    """All of them, in the order of their rows."""
    if len(lots) == 1:
        return lots[0]
    row = np.concatenate([lot.row for lot in lots])
    order = np.argsort(row)
    stamp = np.concatenate([lot.stamp for lot in lots])[order]
    identifier = np.concatenate([lot.identifier for lot in lots])[order]
    data = list(chain.from_iterable(lot.data for lot in lots))
    return Lot(row[order], stamp, identifier, list(map(data.__getitem__, order.tolist())))


def _cells(payloads: Payloads, lengths: Lengths) -> list[bytes]:
    """The first bytes of each row, as many as its length says, or all."""
    width = payloads.shape[1]
    if not width:
        return [b""] * len(payloads)
    cells: list[bytes] = np.ascontiguousarray(payloads).view(f"V{width}")[:, 0].tolist()
    short = np.flatnonzero(lengths < width)
    for place, length in zip(short.tolist(), lengths[short].tolist(), strict=True):
        cells[place] = cells[place][:length]
    return cells
