"""The messages of a recording, made thousands at a time. Needs the extra `columns`.

Frames are read and fast packets put together in columns; one by one, only the messages are made.
"""

from collections.abc import Iterator, Sequence
from itertools import chain, repeat

import numpy as np
import numpy.typing as npt

from timonel.nmea2000.catalogue import finder, only
from timonel.nmea2000.fastpacket import FastPacketCounters
from timonel.recording.assembly import PACE, Assembly, Group
from timonel.recording.chunks import FrameReader
from timonel.recording.decoded import Decoder, Message, OwnMessage
from timonel.recording.formats import LogReader
from timonel.recording.frames import NO_STAMP, Stamps

CHUNK = 1 << 14
"""Frames at a time: enough that what is done once for all of them, and for each PGN, costs little."""

Times = list[float | None]
Made = tuple[npt.NDArray[np.int64], Sequence[Message | OwnMessage]]
"""The rows of the frames that completed messages, and the messages."""


class Messages:
    """The messages of the frames of a log; those of a rover are made by `decoder`."""

    def __init__(self, log: LogReader, decoder: Decoder) -> None:
        self._frames = FrameReader(log, CHUNK)
        self._decoder = decoder
        self._assembly = Assembly()
        self._dated = log.dated
        self._tick, self._second = (1, 1e9) if log.format == "MCAP" else (1000, 1e6)

    @property
    def counters(self) -> FastPacketCounters:
        return self._assembly.counters

    def __iter__(self) -> Iterator[Message | OwnMessage]:
        for frames in self._frames:
            yield from self._in_order(self._assembly.receive(frames))

    def _in_order(self, groups: list[Group]) -> Iterator[Message | OwnMessage]:
        """The messages in the order of the frames that completed them."""
        made = [self._messages(group) for group in groups if group.pgn is not None]
        made.append(self._own([group for group in groups if group.pgn is None]))
        order = np.argsort(np.concatenate([rows for rows, _ in made]))
        messages = list(chain.from_iterable(some for _, some in made))
        return map(messages.__getitem__, order.tolist())

    def _messages(self, group: Group) -> Made:
        """The messages of a PGN."""
        assert group.pgn is not None
        times, data, definition = self._times(group.stamp), payloads(group), only(group.pgn)
        addresses = [column.tolist() for column in (group.priority, group.source, group.destination)]
        definitions = repeat(definition) if definition else map(finder(group.pgn), data)
        return group.row, list(map(Message, times, *addresses, repeat(group.pgn), data, definitions))

    def _own(self, groups: list[Group]) -> Made:
        """What the frames of a rover complete."""
        frames: list[tuple[int, int, float | None, int, bytes]] = []
        for group in groups:
            assert group.frame is not None
            rows, stamps, times = group.row.tolist(), group.stamp.tolist(), self._times(group.stamp)
            frames += zip(rows, stamps, times, repeat(group.frame), payloads(group), strict=False)
        rows, made = [], []
        for row, stamp, time, number, data in sorted(frames):
            now = row * PACE if stamp == NO_STAMP else stamp
            if (message := self._decoder.own(time, number, data, now)) is not None:
                rows.append(row)
                made.append(message)
        return np.array(rows, np.int64), made

    def _times(self, stamp: Stamps) -> Times:
        """Unix seconds: the same quotients as where frames are read one by one."""
        if not self._dated:
            return [None] * len(stamp)
        times: Times = (stamp // self._tick / self._second).tolist()
        for place in np.flatnonzero(stamp == NO_STAMP).tolist():
            times[place] = None
        return times


def payloads(group: Group) -> list[bytes]:
    """What the messages of a group carry."""
    width = group.payloads.shape[1]
    if not width:
        return [b""] * len(group.row)
    cells: list[bytes] = np.ascontiguousarray(group.payloads).view(f"V{width}")[:, 0].tolist()
    for place in np.flatnonzero(group.lengths < width).tolist():
        cells[place] = cells[place][: group.lengths[place]]
    return cells
