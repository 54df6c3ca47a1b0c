"""Frames in, messages out, in columns: grouped by PGN, fast packets put together. Needs the extra `columns`.

```python
assembly = Assembly()
for frames in chunks:
    for group in assembly.receive(frames):
        group.pgn, group.stamp, group.source, group.payloads
```
However a recording is cut into chunks, the messages and the counters are those of the live path, which takes one
frame after the other. For fast packets, a frame without a time comes `PACE` after the one before it.
"""

from collections.abc import Collection
from functools import cache

import msgspec
import numpy as np
import numpy.typing as npt

from timonel import native
from timonel.nmea2000.fastpacket import FastPacketCounters
from timonel.nmea2000.identifier import GLOBAL
from timonel.nmea2000.schedule import FAST, FAST_RANGES
from timonel.recording.fast_packets import FastPackets
from timonel.recording.frames import EXTENDED, NO_STAMP, SIXTEEN, WHOLE, Bytes, Frames, Identifiers, Rows, Stamps
from timonel.recording.part import STANDARD, Lengths, Part, Payloads, by_key, merged, stretches

PACE = 1_000_000
"""ns from frame to frame where a recording has no times."""

_PDU1 = 0xF000
_WHOLE = WHOLE << 40  # in the first word of a row

_EIGHT = np.array([8], np.intp)
_EIGHT.flags.writeable = False

Octets = npt.NDArray[np.uint8]
Ints = npt.NDArray[np.intp]
Words = npt.NDArray[np.uint64]
Codes = npt.NDArray[np.uint16]


class Group(msgspec.Struct, frozen=True, eq=False, gc=False):
    """Messages of one PGN, or of one standard identifier (`frame`), in the order in which they were complete.

    `row` int64[n] is the place in the recording, from 0, of the frame that completed each message; `stamp` int64[n]
    its time in unix ns (NO_STAMP: none), `identifier` uint32[n] its identifier. Of `payloads` uint8[n, width], the
    bytes behind a message's length mean nothing.
    """

    pgn: int | None
    frame: int | None
    row: npt.NDArray[np.int64]
    stamp: Stamps
    identifier: Identifiers
    payloads: Payloads
    lengths: Lengths

    @property
    def source(self) -> Octets:
        """uint8[n]; without meaning for standard identifiers, as destination and priority."""
        return self.identifier.astype(np.uint8)

    @property
    def destination(self) -> Octets:
        """uint8[n], 255 where the PGN has none."""
        if self.pgn is None or self.pgn & 0xFF00 >= _PDU1:
            return np.full(len(self.identifier), GLOBAL, np.uint8)
        return (self.identifier >> 8).astype(np.uint8)

    @property
    def priority(self) -> Octets:
        """uint8[n], 0 is the most urgent."""
        return (self.identifier >> 26).astype(np.uint8) & np.uint8(7)


class Assembly:
    """Puts the messages of a recording together: all, or those of some PGNs and of some standard identifiers.

    `counters` are of the fast packets among them, of which at most `max_slots` are on their way in at a time.
    """

    def __init__(
        self,
        pgns: Collection[int] | None = None,
        standard: Collection[int] | None = None,
        max_slots: int = 256,
    ) -> None:
        self.frames = 0
        everything = pgns is None and standard is None
        self._kinds = _all() if everything else _kinds(_sorted(pgns), _sorted(standard))
        self._fast_packets = FastPackets(max_slots)
        self._now = 0

    @property
    def counters(self) -> FastPacketCounters:
        return self._fast_packets.counters

    def receive(self, frames: Frames) -> list[Group]:
        """The messages that these frames complete, by PGN, then by standard identifier."""
        groups = None if native.kernels is None else self._compiled(frames)
        if groups is None:
            groups = self._merged(self._parts(frames), frames.stamp)
        self.frames += len(frames)
        return groups

    def _merged(self, found: list[Part], stamp: Stamps) -> list[Group]:
        """One group a channel."""
        parts: dict[int, list[Part]] = {}
        for part in found:
            parts.setdefault(part.channel, []).append(part)
        return [self._group(merged(parts[channel]), stamp) for channel in sorted(parts)]

    def _parts(self, frames: Frames) -> list[Part]:
        head = frames.rows.view("<u8").reshape(-1, 2)[:, 0].copy()
        codes = self._kinds.codes.take(_places(head))
        parts = []
        if np.bitwise_or.reduce(head) & _WHOLE:
            whole = (head & _WHOLE != 0) & (codes != 0)
            parts += _whole(frames, np.flatnonzero(whole), codes, self._kinds.channels)
            codes[whole] = 0
        fast = np.flatnonzero(codes >= self._kinds.fast)
        parts += self._fast_packets.receive(frames.rows, self._times(frames.stamp), fast)
        single = np.flatnonzero(codes - np.uint16(1) < self._kinds.fast - 1)
        return parts + _single(frames.rows, single, codes, self._kinds.channels)

    def _compiled(self, frames: Frames) -> list[Group] | None:
        """The same by compiled kernels; None if some of the frames are whole messages."""
        codes, counts = np.empty(len(frames), np.uint16), np.zeros(len(self._kinds.channels), np.uint32)
        if native.kernels.frame_codes(frames.rows, self._kinds.codes, codes, counts):
            return None
        packets = self._packets(frames, codes, counts)
        counts[0], counts[self._kinds.fast :] = 0, 0
        return sorted(self._singles(frames, codes, counts) + packets, key=_channel)

    def _packets(self, frames: Frames, codes: Codes, counts: npt.NDArray[np.uint32]) -> list[Group]:
        """The fast packets among them."""
        first = self._kinds.fast
        if first == len(counts):
            return []
        now, channels = self._times(frames.stamp), self._kinds.channels
        parts = self._fast_packets.receive_coded(frames.rows, now, codes, first, counts, channels)
        return self._merged(parts, frames.stamp)

    def _singles(self, frames: Frames, codes: Codes, counts: npt.NDArray[np.uint32]) -> list[Group]:
        """Frames that are messages; `counts` is how many there are of each code."""
        ends = np.cumsum(counts, dtype=np.int64)
        size = int(ends[-1])
        row, stamp, length = np.empty(size, np.int64), np.empty(size, np.int64), np.empty(size, np.uint8)
        identifier, data = np.empty(size, np.uint32), np.empty((size, 8), np.uint8)
        begin = np.where(counts > 0, ends - counts, -1)
        native.kernels.single_frames(frames.rows, frames.stamp, codes, begin, row, stamp, identifier, length, data)
        if self.frames:
            row += self.frames
        groups = []
        for code in np.flatnonzero(counts).tolist():
            pgn, frame = _named(self._kinds.channels[code])
            some = slice(int(ends[code] - counts[code]), int(ends[code]))
            lengths = _lengths(length[some])
            groups.append(Group(pgn, frame, row[some], stamp[some], identifier[some], data[some], lengths))
        return groups

    def _times(self, stamp: Stamps) -> Stamps:
        """The stamps, and times for what has none."""
        now = stamp
        if stamp.min(initial=0) == NO_STAMP:
            known = stamp != NO_STAMP
            place = np.arange(len(stamp))
            last = np.maximum.accumulate(np.where(known, place, -1))
            now = np.where(last < 0, self._now, stamp[last]) + (place - last) * PACE
        if len(now):
            self._now = int(now[-1])
        return now

    def _group(self, part: Part, stamp: Stamps) -> Group:
        row = part.row + self.frames
        pgn, frame = _named(part.channel)
        return Group(pgn, frame, row, stamp.take(part.row), part.identifier, part.payloads, part.lengths)


def _lengths(short: Octets) -> Lengths:
    """The same as long integers: of whole frames, which most are, one that all share."""
    if short.min() == _EIGHT[0] == short.max():
        return np.ndarray((len(short),), np.intp, _EIGHT, 0, (0,))
    return short.astype(np.intp)


def _named(channel: int) -> tuple[int | None, int | None]:
    """PGN, or standard identifier."""
    return (None, channel - STANDARD) if channel >= STANDARD else (channel, None)


def _channel(group: Group) -> int:
    return STANDARD + (group.frame or 0) if group.pgn is None else group.pgn


class _Kinds(msgspec.Struct, frozen=True):
    """What becomes of a frame: a code for each place (see `_places`), 0 for what is not wanted.

    `channels` tells what a code stands for; codes from `fast` on are fast packets.
    """

    codes: Codes
    channels: list[int]
    fast: int


@cache
def _all() -> _Kinds:
    """All PGNs and standard identifiers there can be."""
    pages = np.arange(0, STANDARD, 0x100)
    addressed = pages & 0xFF00 < _PDU1
    extensions = pages[~addressed, None] + np.arange(0x100)
    return _kinds(np.sort(np.concatenate((pages[addressed], extensions.ravel()))), np.arange(0x800))


def _kinds(pgns: Ints, standard: Ints) -> _Kinds:
    fast = _fast(pgns)
    channels = np.concatenate(([-1], pgns[~fast], STANDARD + standard, pgns[fast]))
    codes = np.zeros(STANDARD + 0x800, np.uint16)
    codes[channels[1:]] = np.arange(1, len(channels))
    for pgn in pgns[pgns & 0xFF00 < _PDU1].tolist():
        codes[pgn : pgn + 0x100] = codes[pgn]  # with any destination they are one channel
    return _Kinds(codes, channels.tolist(), len(channels) - int(fast.sum()))


def _fast(pgns: Ints) -> npt.NDArray[np.bool_]:
    """`is_fast` of many."""
    fast = np.isin(pgns, list(FAST))
    for first, last in FAST_RANGES:
        fast |= (pgns >= first) & (pgns <= last)
    return fast


def _sorted(numbers: Collection[int] | None) -> Ints:
    return np.array(sorted(set(numbers or ())), np.intp)


def _places(head: Words) -> Ints:
    """Where in the codes to look up a frame: its PGN with the destination, or `STANDARD` + identifier."""
    places = head >> 8 & STANDARD - 1
    if not np.bitwise_and.reduce(head) & EXTENDED:
        places = np.where(head & EXTENDED, places, STANDARD | head & 0x7FF)
    return places.view(np.intp)


def _single(rows: Rows, row: Ints, codes: Codes, channels: list[int]) -> list[Part]:
    """Frames that are messages."""
    ordered, row = by_key(codes.take(row), row)
    sorted_rows = rows.view(SIXTEEN).take(row).view(rows.dtype)
    identifier = sorted_rows["identifier"] & np.uint32(EXTENDED - 1)
    length = sorted_rows["length"].astype(np.intp)
    data = sorted_rows["data"]
    return [
        Part(channels[ordered[start]], row[start:end], identifier[start:end], data[start:end], length[start:end])
        for start, end in stretches(ordered)
    ]


def _whole(frames: Frames, row: Ints, codes: Codes, channels: list[int]) -> list[Part]:
    """Messages that the recorder had put together."""
    order = row[np.argsort(codes[row], kind="stable")]
    parts = []
    for start, end in stretches(codes[order]):
        same = order[start:end]
        identifier = frames.identifier[same] & np.uint32(EXTENDED - 1)
        length = frames.length[same].astype(np.intp)
        payloads = _spilled(frames.data[same], length, frames.spill)
        parts.append(Part(channels[codes[same[0]]], same, identifier, payloads, length))
    return parts


def _spilled(data: Bytes, length: Ints, spill: Bytes) -> Payloads:
    """The payloads of messages, the long ones of which stand in `spill`."""
    width = max(8, int(length.max()))
    payloads = np.zeros((len(data), width), np.uint8)
    payloads[:, :8] = data
    long = np.flatnonzero(length > 8)
    if len(long):
        place = np.arange(width)
        there = place < length[long, None]
        start = data[long].view("<u8").astype(np.intp)
        payloads[long] = np.where(there, spill.take(np.where(there, start + place, 0)), 0)
    return payloads
