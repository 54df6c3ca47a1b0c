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

from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from timonel import native
from timonel.nmea2000.fastpacket import LONGEST, FastPacketCounters, Reassembler
from timonel.nmea2000.identifier import split
from timonel.recording.coded_packets import SLOT_ROOM, CodedPackets
from timonel.recording.frames import EXTENDED, SIXTEEN, Identifiers, Rows, Stamps
from timonel.recording.part import FIRST_FAST, Part, by_key, of_messages, pgns_of, stretches, windows

MAX_AGE = 250_000_000
MAX_GAP = 100_000_000
"""In ns, as the Reassembler's own limits."""
_LIMITS = MAX_AGE, MAX_GAP, LONGEST

_STREAM = 0x3FFFFFF  # an identifier without its priority
_NEW = 0xFFFF
_STEP = 64
_KEYS = 1 << 13  # streams whose slots fit in 16 bits, which are sorted fastest

Ints = npt.NDArray[np.intp]
Flags = npt.NDArray[np.bool_]
Words = npt.NDArray[np.uint64]
Codes = npt.NDArray[np.uint16]
Counts = npt.NDArray[np.uint32]


class Arrivals(msgspec.Struct, frozen=True, eq=False, gc=False):
    """Frames of fast packets: `head` of their rows, and `data` with the first byte lowest."""

    row: Ints  # place in the chunk
    now: Stamps  # ns
    head: Words
    data: Words

    @property
    def identifier(self) -> Identifiers:
        return _identifiers(self.head)

    @property
    def length(self) -> npt.NDArray[np.uint8]:
        return (self.head >> 32).astype(np.uint8)


def _arrivals(rows: Rows, now: Stamps, row: Ints) -> Arrivals:
    found = rows.view(SIXTEEN).take(row).view("<u8").reshape(-1, 2)
    return Arrivals(row, now.take(row), found[:, 0].copy(), found[:, 1].copy())


def _identifiers(head: Words) -> Identifiers:
    return head.astype(np.uint32) & np.uint32(EXTENDED - 1)


class FastPackets:
    """Takes chunks of frames, gives the messages they complete. Which PGNs are fast packets the caller knows."""

    def __init__(self, max_slots: int = 256) -> None:
        # All that it does with times is to compare them: whole ns are as good as seconds, and exact.
        self._reassembler = Reassembler(MAX_AGE, MAX_GAP, max_slots)
        self._max_slots = max_slots
        self._streams = np.zeros((0x20000 - FIRST_FAST) << 8, np.uint16)
        self._known = 0
        self._room = np.zeros(SLOT_ROOM if native.kernels else 0, np.uint8)

    @property
    def counters(self) -> FastPacketCounters:
        return self._reassembler.counters

    def receive(self, rows: Rows, now: Stamps, row: Ints) -> list[Part]:
        """The messages that some rows of a chunk complete; `now` is a time for each row of the chunk, in ns.

        A part is of one PGN.
        """
        octets = rows.view(np.uint8).reshape(-1, 16)
        streams = self._streams_of(rows["identifier"][row])
        if streams is None or not octets[:, 4][row].all():
            return self._one_by_one(_arrivals(rows, now, row))
        streams <<= np.uint16(3)
        streams |= octets[:, 8][row] >> 5
        key, row = by_key(streams, row)
        frames = _arrivals(rows, now, row)
        runs = _runs(frames, key)
        dirty = self._dirty(runs)
        several = ~dirty & (runs.count > 1)
        if self._crowded(runs.key[runs.new], runs.key[dirty], row[runs.start[several]], row[runs.last[several]]):
            return self._one_by_one(_arrivals(rows, now, np.sort(row)))
        plain = np.flatnonzero(~dirty)
        self.counters.completed += len(plain)
        others = np.sort(row[np.repeat(dirty, runs.count)])
        return self._one_by_one(_arrivals(rows, now, others)) + _plain(frames, runs, plain)

    def receive_coded(
        self, rows: Rows, now: Stamps, codes: Codes, first: int, counts: Counts, channels: Sequence[int]
    ) -> list[Part]:
        """The same by compiled kernels, of rows whose code is `first` or more: `counts` and `channels` are by code."""
        found = CodedPackets(first, counts)
        waiting = self._waiting().astype(np.uint16)
        known = found.read(rows, now, codes, self._room, self._streams, self._known, waiting, _LIMITS)
        if known < 0:
            self._streams[self._streams > self._known] = 0
            return self._one_by_one(_arrivals(rows, now, np.flatnonzero(codes >= first)))
        self._known = known
        plain, dirty = ~found.dirty & (found.count > 1), found.dirty
        if self._crowded(found.slot, found.slot[dirty], found.begin[plain], found.last[plain]):
            return self._one_by_one(_arrivals(rows, now, np.flatnonzero(codes >= first)))
        self.counters.completed += len(dirty) - int(np.count_nonzero(dirty))
        return self._one_by_one(_arrivals(rows, now, found.others)) + found.parts(channels)

    def _streams_of(self, identifier: Identifiers) -> npt.NDArray[np.uint16] | None:
        """A number from 1 for each source, destination and PGN; None if there are too many."""
        place = (identifier & _STREAM) - np.uint32(FIRST_FAST << 8)
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

    def _waiting(self) -> npt.NDArray[np.int64]:
        """The slots that are in use."""
        slots = np.array(self._reassembler.slots, np.int64)
        streams = self._streams[(slots >> 3) - (FIRST_FAST << 8)].astype(np.int64)
        keys: npt.NDArray[np.int64] = streams << 3 | slots & 7
        return keys

    def _dirty(self, runs: "_Runs") -> Flags:
        """The runs that are not plain."""
        seed = ~runs.whole
        keys = self._waiting()
        first = np.searchsorted(runs.key, keys)
        there = first < len(runs.key)
        first, keys = first[there], keys[there]
        seed[first[runs.key[first] == keys]] = True
        place = np.arange(len(seed))
        stop = np.where(runs.new & ~seed, place, -1)
        stop[1:] = np.maximum(stop[1:], np.where(runs.calm[:-1], place[:-1], -1))
        return np.maximum.accumulate(np.where(seed, place, -1)) > np.maximum.accumulate(stop)

    def _crowded(self, keys: npt.NDArray[Any], dirty: npt.NDArray[Any], begin: Ints, end: Ints) -> bool:
        """Whether the Reassembler could have to give up a slot that is in use.

        `keys` are those of all runs, and of those that are not plain; `begin` and `end` the rows of the others that
        have several frames.
        """
        waiting = len(self._reassembler.slots)
        if waiting + _distinct(keys) <= self._max_slots:
            return False
        # Looked at in steps of some rows, in which all that begin come before all that end: at least as many as are.
        begins, ends = np.bincount(begin // _STEP), np.bincount(end // _STEP)
        on_the_way = np.cumsum(begins) - np.cumsum(ends)[: len(begins)] + ends[: len(begins)]
        return waiting + _distinct(dirty) + int(on_the_way.max(initial=0)) > self._max_slots

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


def _distinct(keys: npt.NDArray[Any]) -> int:
    """How many keys there are. NumPy's own `unique` loads masked arrays, which takes longer than a whole short file."""
    return int(np.count_nonzero(np.bincount(keys.astype(np.intp))))


class _Runs(msgspec.Struct, frozen=True, eq=False, gc=False):
    """Frames of one slot, the first of which is frame 0 or the slot's first."""

    start: Ints
    count: Ints
    key: Words
    new: Flags  # it is the first of its slot
    whole: Flags  # it is a message, all frames in order and in time
    calm: Flags  # as well, and what was before it in the slot is older than a slot lives

    @property
    def last(self) -> Ints:
        return self.start + self.count - 1


def _runs(frames: Arrivals, key: Words) -> _Runs:
    """The runs of frames, which are sorted by slot, as `key` is."""
    data, now = frames.data, frames.now
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
    length = frames.length
    if length.min(initial=8) < 8:
        short = np.flatnonzero(length < 8)
        run = np.searchsorted(start, short, "right") - 1
        enough = (short == last[run]) & (7 * count[run] - 8 + length[short] > size[run])
        whole[run[~enough]] = False
    first = new[start]
    return _Runs(start, count, key[start], first, whole, whole & ~first & (gap[start] > MAX_GAP))


def _plain(frames: Arrivals, runs: _Runs, plain: Ints) -> list[Part]:
    """The messages of plain runs: sorted by PGN, then the row of their last frame."""
    last = runs.last[plain]
    row, identifier = frames.row.take(last), _identifiers(frames.head.take(last))
    pgn = pgns_of(identifier).astype(np.uint64)
    order = np.argsort(pgn << 32 | row.view(np.uint64))
    plain, pgn, row, identifier = plain.take(order), pgn.take(order), row.take(order), identifier.take(order)
    carried, begin, count = _carried(frames.data), runs.start[plain], runs.count[plain]
    size = (frames.data.take(begin) >> 8 & 0xFF).view(np.intp)
    begin = 7 * begin + 1
    parts = []
    for start, stop in stretches(pgn):
        some = slice(start, stop)
        payloads = windows(carried, begin[some], 7 * int(count[some].max()) - 1)
        parts.append(Part(int(pgn[start]), row[some], identifier[some], payloads, size[some]))
    return parts


def _carried(data: Words) -> npt.NDArray[np.uint8]:
    """What all frames carry behind their counters: of each run a message's length, then the message.

    Whole words are written, seven bytes apart in rising order: what one has too much, the next one overwrites.
    """
    out = np.zeros(7 * len(data) + LONGEST, np.uint8)
    np.right_shift(data, 8, out=np.ndarray(len(data), "<u8", out, 0, (7,)))
    return out
