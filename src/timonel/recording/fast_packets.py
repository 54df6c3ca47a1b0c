"""Fast packets put together in columns: the messages and counters that `nmea2000.fastpacket` gives, frame by frame.

Frames are sorted by slot (source, destination, PGN, sequence counter) and cut into runs, each of which begins at
frame 0. A run is plain if it is a whole message: all its frames in order, none missing or too late, and nothing of
the slot's before it still on its way. Plain runs become payloads at once. All others go, frame by frame in their
order, through the Reassembler of the live path, whose slots carry over what the next chunk will complete.

    the run before was             this run is whole and begins        goes through the Reassembler
    plain                          anyhow                              no
    not plain                      within `max_gap` of it              yes, and the next one is looked at likewise
    not plain                      later: no slot lives that long      yes (what is left is counted), the next one not
    still in a slot (last chunk)   anyhow                              yes, and the next one is looked at likewise

Only when slots could run out, the whole chunk goes through the Reassembler, because then the slots are no longer
independent of each other.
"""

import msgspec
import numpy as np
import numpy.typing as npt

from timonel.nmea2000.fastpacket import LONGEST, FastPacketCounters, Reassembler
from timonel.nmea2000.identifier import split
from timonel.recording.frames import Identifiers
from timonel.recording.part import Part, of_messages, pgns_of, stretches

MAX_AGE = 250_000_000
MAX_GAP = 100_000_000
"""In ns, as the Reassembler's own limits."""

FIRST = 0x1ED00
"""No PGN below this one travels as fast packet."""

_STREAM = 0x3FFFFFF  # an identifier without its priority
_NEW = 0xFFFF
_KEYS = 1 << 13  # streams whose slots fit in 16 bits, which are sorted fastest

Ints = npt.NDArray[np.intp]
Flags = npt.NDArray[np.bool_]
Words = npt.NDArray[np.uint64]


class Arrivals(msgspec.Struct, frozen=True, eq=False, gc=False):
    """Frames of fast packets in the order in which they came; `data` has the first byte lowest."""

    row: Ints  # place in the chunk
    now: npt.NDArray[np.int64]  # ns
    identifier: Identifiers
    length: npt.NDArray[np.uint8]
    data: Words

    def __getitem__(self, which: Ints) -> "Arrivals":
        return Arrivals(*(column.take(which) for column in msgspec.structs.astuple(self)))


class FastPackets:
    """Takes chunks of frames, gives the messages they complete. Which PGNs are fast packets the caller knows."""

    def __init__(self, max_slots: int = 256) -> None:
        # All that it does with times is to compare them: whole ns are as good as seconds, and exact.
        self._reassembler = Reassembler(MAX_AGE, MAX_GAP, max_slots)
        self._max_slots = max_slots
        self._streams = np.zeros((0x20000 - FIRST) << 8, np.uint16)
        self._known = 0

    @property
    def counters(self) -> FastPacketCounters:
        return self._reassembler.counters

    def receive(self, frames: Arrivals) -> list[Part]:
        """The messages that these frames complete; a part is of one PGN."""
        streams = self._streams_of(frames.identifier)
        if streams is None or not frames.length.all():
            return self._one_by_one(frames)
        key = streams << np.uint16(3)
        key |= frames.data.view(np.uint8)[::8] >> 5
        order = np.argsort(key, kind="stable")
        runs = _runs(frames, order, key.take(order))
        dirty = self._dirty(runs)
        if self._crowded(runs, dirty, order):
            return self._one_by_one(frames)
        plain = np.flatnonzero(~dirty)
        self.counters.completed += len(plain)
        others = np.sort(order[np.repeat(dirty, runs.count)])
        return self._one_by_one(frames[others]) + _plain(frames, order, runs, plain)

    def _streams_of(self, identifier: Identifiers) -> npt.NDArray[np.uint16] | None:
        """A number from 1 for each source, destination and PGN; None if there are too many."""
        place = (identifier & _STREAM) - np.uint32(FIRST << 8)
        streams = self._streams.take(place)
        if not streams.all():
            self._streams[place[streams == 0]] = _NEW
            new = np.flatnonzero(self._streams == _NEW)
            if self._known + len(new) >= _KEYS:
                self._streams[new] = 0
                return None
            self._streams[new] = np.arange(len(new)) + self._known + 1
            self._known += len(new)
            streams = self._streams.take(place)
        return streams

    def _dirty(self, runs: "_Runs") -> Flags:
        """The runs that are not plain."""
        seed = ~runs.whole
        slots = np.array(self._reassembler.slots, np.int64)
        keys = self._streams[(slots >> 3) - (FIRST << 8)].astype(np.int64) << 3 | slots & 7
        first = np.searchsorted(runs.key, keys)
        there = first < len(runs.key)
        first, keys = first[there], keys[there]
        seed[first[runs.key[first] == keys]] = True
        place = np.arange(len(seed))
        stop = np.where(runs.new & ~seed, place, -1)
        stop[1:] = np.maximum(stop[1:], np.where(runs.calm[:-1], place[:-1], -1))
        return np.maximum.accumulate(np.where(seed, place, -1)) > np.maximum.accumulate(stop)

    def _crowded(self, runs: "_Runs", dirty: Flags, order: Ints) -> bool:
        """Whether the Reassembler could have to give up a slot that is in use."""
        waiting = len(self._reassembler.slots)
        if waiting + np.count_nonzero(runs.new) <= self._max_slots:
            return False
        on_the_way = np.zeros(len(order), np.int8)
        several = ~dirty & (runs.count > 1)
        on_the_way[order[runs.start[several]]] = 1
        on_the_way[order[runs.last[several]]] = -1
        most = int(np.cumsum(on_the_way, dtype=np.int64).max())
        return waiting + len(np.unique(runs.key[dirty])) + most > self._max_slots

    def _one_by_one(self, frames: Arrivals) -> list[Part]:
        """Through the Reassembler, frame by frame."""
        messages: dict[int, list[tuple[int, int, bytes]]] = {}
        receive = self._reassembler.receive
        data = frames.data.tobytes()
        columns = (frames.row, frames.identifier, frames.length, frames.now)
        at = 0
        for row, identifier, length, now in zip(*(column.tolist() for column in columns), strict=True):
            message = receive(identifier, data[at : at + length], now)
            if message is not None:
                messages.setdefault(split(identifier).pgn, []).append((row, identifier, message))
            at += 8
        return [of_messages(pgn, some) for pgn, some in messages.items()]


class _Runs(msgspec.Struct, frozen=True, eq=False, gc=False):
    """Frames of one slot, the first of which is frame 0 or the slot's first; `data` is sorted by slot."""

    data: Words
    start: Ints
    count: Ints
    key: npt.NDArray[np.uint16]
    new: Flags  # it is the first of its slot
    whole: Flags  # it is a message, all frames in order and in time
    calm: Flags  # as well, and what was before it in the slot is older than a slot lives

    @property
    def last(self) -> Ints:
        return self.start + self.count - 1


def _runs(frames: Arrivals, order: Ints, key: npt.NDArray[np.uint16]) -> _Runs:
    """The runs of frames; `key` is sorted already."""
    data, now = frames.data.take(order), frames.now.take(order)
    index = data.view(np.uint8)[::8] & 31
    new = np.ones(len(key), np.bool_)
    np.not_equal(key[1:], key[:-1], out=new[1:])
    begins = new | (index == 0)
    start = np.flatnonzero(begins)
    count = np.diff(start, append=len(key))
    last = start + count - 1
    gap = np.diff(now, prepend=now[:1])
    wrong = gap.view(np.uint64) > MAX_GAP  # negative ones are enormous
    wrong[1:] |= index[1:] != index[:-1] + np.uint8(1)
    wrong &= ~begins
    size = (data[start] >> 8 & 0xFF).astype(np.intp)
    whole = (index[start] == 0) & (count == 1 + size // 7) & (size <= LONGEST)
    whole &= now[last] - now[start] < MAX_AGE
    whole[np.searchsorted(start, np.flatnonzero(wrong), "right") - 1] = False
    if frames.length.min(initial=8) < 8:
        length = frames.length.take(order)
        short = np.flatnonzero(length < 8)
        run = np.searchsorted(start, short, "right") - 1
        enough = (short == last[run]) & (7 * count[run] - 8 + length[short] > size[run])
        whole[run[~enough]] = False
    first = new[start]
    return _Runs(data, start, count, key[start], first, whole, whole & ~first & (gap[start] > MAX_GAP))


def _plain(frames: Arrivals, order: Ints, runs: _Runs, plain: Ints) -> list[Part]:
    """The messages of plain runs: sorted by PGN, then number of frames, then the row of their last frame."""
    plain = plain.take(_rising(order.take(runs.last[plain]), len(order)))
    plain = plain[np.argsort(runs.count[plain].astype(np.uint8), kind="stable")]
    pgn = pgns_of(frames.identifier.take(order.take(runs.last[plain])))
    by_pgn = np.argsort(pgn.astype(np.uint16), kind="stable")  # of fast packets the highest bits are the same
    plain, pgn = plain.take(by_pgn), pgn.take(by_pgn)
    begin, count, last = runs.start[plain], runs.count[plain], order.take(runs.last[plain])
    carried, row, identifier = _joined(runs.data, begin, count), frames.row.take(last), frames.identifier.take(last)
    size = (runs.data[begin] >> 8 & 0xFF).view(np.intp)
    end = 7 * np.cumsum(count)
    parts = []
    for start, stop in stretches(pgn.astype(np.intp) << 8 | count):
        width = 7 * int(count[start])
        payloads = carried[end[start] - width : end[stop - 1]].reshape(stop - start, width)[:, 1:]
        some = slice(start, stop)
        parts.append(Part(int(pgn[start]), row[some], identifier[some], payloads, size[some]))
    return parts


def _rising(values: Ints, limit: int) -> Ints:
    """Where the smallest of them is, the next ... All are below `limit`, and different: to sort would be slower."""
    place = np.full(limit, -1, np.int32)
    place[values] = np.arange(len(values), dtype=np.int32)
    return place[place >= 0].astype(np.intp)


def _joined(data: Words, begin: Ints, count: Ints) -> npt.NDArray[np.uint8]:
    """What the `count` frames from each of `begin` on carry: a message's length, then the message, and so on.

    Whole words are written, seven bytes apart in rising order: what one has too much, the next one overwrites.
    """
    behind = np.cumsum(count)
    total = int(behind[-1]) if len(behind) else 0
    frame = np.repeat(begin - behind + count, count) + np.arange(total)
    out = np.empty(7 * total + 1, np.uint8)
    np.ndarray(total, "<u8", out, 0, (7,))[:] = data.take(frame) >> 8
    return out[:-1]
