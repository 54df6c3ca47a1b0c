"""Fast packets: messages of up to 223 bytes in up to 32 frames, taken apart and put together again.

    byte 0: sequence counter (3 bits), index (5 bits)
    index 0: byte 1 is the length, 6 bytes of the message follow; all others: 7 bytes

A reassembler must never join frames of two messages: half of one heading-to-steer and half of the next is a
course that nobody ordered (spec/boat.md, rule 10). Which message a frame is of, only a counter says that
comes round after eight messages, and that some senders never turn. So a frame is taken only if it is where a
frame of the same message would be, in time and in order; in doubt the message is lost, and counted.

    a slot is (source, destination, PGN, sequence counter), and lives while
        its first frame is younger than `max_age` (250 ms) and its last one not older than `max_gap` (100 ms)

    frame in a live slot                effect
    the next index                      taken
    one ahead of the next index         kept, and taken if the very next frame is the one between:
                                        two neighbours were exchanged on the way, `exchanged`
    the same as the frame before        ignored, `duplicates`
    index 0                             starts the message afresh; the other one is lost, `interrupted`
    anything else                       the message is lost, `broken`, and so are its later frames, `headless`

    frame without a live slot           effect
    index 0                             starts a message
    index 1                             waits for an exchanged index 0
    any other                           dropped, `headless`

Refused, because frames of two messages could come in the same way:
    - frame 0 of a two-frame message behind its frame 1 (canboat pull request 738): both are lost;
    - frame 0 that interrupts a two-frame message, whose frame 1 may still come: both are lost;
    - an exchange in a message that interrupted another one, or that begins where one was broken.

What holds, whatever is lost, and whichever neighbours are exchanged:
    - Messages of one slot are never joined if more than `max_gap` lies between their frames. (999 of 1,000
      frames of the busiest recordings follow within 25 ms, and a turning counter keeps the messages of a slot
      eight apart.)
    - Closer ones, which takes a counter that stands still, are joined wrongly only after two faults at least:
      two lost frames, or a lost and an exchanged one. For messages of four frames, as 127237: three lost
      frames, or two lost and an exchanged one.
    - No rule can do better than count: if the end of one message and the beginning of the next are lost
      within `max_gap`, what remains is a faultless message.
"""

import struct

import msgspec

from timonel.errors import EncodeError

LONGEST = 223
"""Bytes in the longest message: 6 + 31 * 7."""

HEADS = [[bytes((sequence << 5 | index,)) for index in range(32)] for sequence in range(8)]
"""The first byte of a frame, by sequence counter and index."""

_STREAM = 0x3FFFFFF  # an identifier without its priority, which a sender may change
_PADDINGS = [b"\xff" * (6 - rest) for rest in range(7)]
_CUTS = [struct.Struct("7s" * count).unpack for count in range(1, 33)]
_SIZES = [bytes((size,)) for size in range(LONGEST + 1)]
_CARRIED = [struct.Struct("x7s" * count).unpack for count in range(33)]  # what so many whole frames carry
_AHEAD, _SPENT = -1, -2  # no frame begins so


class FastPacketCounters(msgspec.Struct, gc=False):
    """What became of the frames so far: messages, and losses by cause."""

    completed: int = 0
    """Messages put together."""
    exchanged: int = 0
    """Frames that came one place late and were taken."""
    duplicates: int = 0
    """Frames that came twice in a row; nothing is lost."""
    interrupted: int = 0
    """Messages lost because the next one began in their slot."""
    broken: int = 0
    """Messages lost because a frame came where none of theirs could be."""
    expired: int = 0
    """Messages (or a lone early frame) not completed in time."""
    headless: int = 0
    """Frames without their message's first frame."""
    evicted: int = 0
    """Messages that gave way because every slot was taken."""
    malformed: int = 0
    """Frames that no fast packet has: no data, a length above 223, too short."""


class _Slot:
    """A message on its way in, an early frame 1, or what a lost message leaves.

    Each frame changes it, and the fields of a struct take longer to set than those of a plain class.
    """

    __slots__ = ("ahead", "due", "exchangeable", "first", "last", "parts", "stop")

    first: float  # when its first frame came
    last: float  # when its last frame came
    parts: list[bytes]  # its frames, in order
    due: int  # how the frame begins that is simply the next; _AHEAD if that has come already, _SPENT if all is lost
    stop: int  # `due` behind the last frame; 0 for an early frame 1, and if all is lost
    ahead: bytes | None  # the frame after `next`, come early; of a lost message, its latest frame
    exchangeable: bool

    @property
    def next(self) -> int:
        """Index that the next frame should have; one that no frame has if all is lost."""
        return 32 if self.due == _SPENT else len(self.parts)

    @property
    def end(self) -> int:
        """Number of frames of the message; 0 if that is not known."""
        return self.stop - self.parts[0][0] if self.parts else 0

    def take(self, frame: bytes) -> None:
        self.parts.append(frame)
        self.due = frame[0] + 1

    def lose(self, frame: bytes) -> None:
        """What stays of the message keeps its later frames out of the next."""
        self.parts, self.due, self.stop, self.ahead = [], _SPENT, 0, frame


class Reassembler:
    """Puts fast packets together, from any number of senders at once.

    `max_age` and `max_gap` are in seconds; at most `max_slots` messages are on their way in at a time (the
    oldest gives way). Which PGNs are fast packets the caller knows.
    """

    def __init__(self, max_age: float = 0.25, max_gap: float = 0.1, max_slots: int = 256) -> None:
        self.counters = FastPacketCounters()
        self._max_age = max_age
        self._max_gap = max_gap
        self._min_gap = -max_gap
        self._max_slots = max_slots
        self._slots: dict[int, _Slot] = {}

    @property
    def pending(self) -> int:
        """Messages on their way in."""
        return len(self._slots)

    @property
    def slots(self) -> list[int]:
        """The slots in use, oldest first: identifier without priority, then three bits of sequence counter."""
        return list(self._slots)

    # Once a frame, so the common case, a frame in its place, comes first and calls nothing.
    def receive(self, identifier: int, data: bytes, now: float) -> bytes | None:
        """Take one frame (`now` in s); the message, without padding, if the frame completes one."""
        if not data:
            self.counters.malformed += 1
            return None
        head = data[0]
        key = (identifier & _STREAM) << 3 | head >> 5
        slot = self._slots.get(key)
        if slot is not None and (
            not self._min_gap <= now - slot.last <= self._max_gap or now - slot.first >= self._max_age
        ):
            self._forget(key, slot)
            slot = None
        if slot is None:
            return self._wait(key, head & 31, data, now) if head & 31 else self._start(key, data, now)
        slot.last = now
        if head != slot.due or len(data) != 8:
            return self._out_of_place(key, slot, head & 31, data, now)
        slot.parts.append(data)
        slot.due = due = head + 1
        return self._complete(key, slot) if due == slot.stop else None

    def expire(self, now: float) -> None:
        """Give up what is too old, so that the counters are exact; never needed for safety."""
        for key, slot in list(self._slots.items()):
            if now - slot.first >= self._max_age or now - slot.last > self._max_gap:
                self._forget(key, slot)

    def _forget(self, key: int, slot: _Slot) -> None:
        del self._slots[key]
        if slot.due != _SPENT:
            self.counters.expired += 1

    def _wait(self, key: int, index: int, data: bytes, now: float) -> bytes | None:
        """The first frame that comes of a message, which is not its first."""
        if index == 1 and len(data) == 8:
            self._keep(key, [], _AHEAD, 0, now, True).ahead = data
        else:
            self.counters.headless += 1
        return None

    def _start(self, key: int, data: bytes, now: float, exchangeable: bool = True) -> bytes | None:
        """A message's frame 0."""
        end = 1 + data[1] // 7 if len(data) == 8 and data[1] <= LONGEST else _end(data)
        if end > 1:
            self._keep(key, [data], data[0] + 1, data[0] + end, now, exchangeable)
            return None
        if end == 0:
            self.counters.malformed += 1
            return None
        self.counters.completed += 1
        return data[2 : 2 + data[1]]

    def _out_of_place(self, key: int, slot: _Slot, index: int, data: bytes, now: float) -> bytes | None:
        """A frame in a live slot that is not simply the next one."""
        if _repeated(slot, index, data):
            self.counters.duplicates += 1
        elif index == 0:
            return self._restart(key, slot, data, now)
        elif slot.due == _SPENT:
            self.counters.headless += 1
        elif index == slot.next:
            return self._fill(key, slot, data)
        elif index == slot.next + 1 < slot.end and slot.ahead is None and slot.exchangeable:
            slot.ahead, slot.due = data, _AHEAD
        else:
            self._lose(slot, data)
        return None

    def _restart(self, key: int, slot: _Slot, data: bytes, now: float) -> bytes | None:
        """Frame 0 in a live slot."""
        end, early = _end(data), slot.next == 0
        if slot.parts:
            self.counters.interrupted += 1
        if (early and end == 2) or (slot.end == 2 and end > 1):
            self._lose(slot, data)
            return None
        del self._slots[key]
        message = self._start(key, data, now, exchangeable=early)
        if early and end > 2:
            started = self._slots[key]
            started.first = slot.first
            self._take_ahead(started, slot.ahead)
        return message

    def _fill(self, key: int, slot: _Slot, data: bytes) -> bytes | None:
        """The next frame, come after its successor or shorter than eight bytes."""
        if len(data) < 8 and slot.next + 1 < slot.end:
            self._lose(slot, data)
            return None
        slot.take(data)
        self._take_ahead(slot, slot.ahead)
        return self._complete(key, slot) if slot.next == slot.end else None

    def _take_ahead(self, slot: _Slot, ahead: bytes | None) -> None:
        if ahead is None:
            return
        slot.take(ahead)
        slot.ahead = None
        self.counters.exchanged += 1

    def _complete(self, key: int, slot: _Slot) -> bytes | None:
        del self._slots[key]
        parts = slot.parts
        data = b"".join(parts)
        whole = len(data) == 8 * len(parts)  # the last frame has all its padding
        data = b"".join(_CARRIED[len(parts)](data) if whole else [part[1:] for part in parts])
        if len(data) <= data[0]:
            self.counters.malformed += 1
            return None
        self.counters.completed += 1
        return data[1 : 1 + data[0]]

    def _lose(self, slot: _Slot, data: bytes) -> None:
        self.counters.broken += 1
        slot.lose(data)

    def _keep(self, key: int, parts: list[bytes], due: int, stop: int, now: float, exchangeable: bool) -> _Slot:
        if len(self._slots) >= self._max_slots:
            del self._slots[next(iter(self._slots))]
            self.counters.evicted += 1
        self._slots[key] = slot = _Slot()
        slot.first = slot.last = now
        slot.parts, slot.due, slot.stop, slot.ahead, slot.exchangeable = parts, due, stop, None, exchangeable
        return slot


def fragment(payload: bytes, sequence: int) -> list[bytes]:
    """The frames of a message, padded with 0xFF; of `sequence` the lowest three bits count.

    Raises EncodeError above 223 bytes.
    """
    heads = HEADS[sequence & 7]
    return [heads[index] + part for index, part in enumerate(cut(payload))]


def cut(payload: bytes) -> tuple[bytes, ...]:
    """What stands behind the first byte of each frame: the length and the message, in sevens, padded with 0xFF.

    Runs between a station's key and the rudder. Raises EncodeError above 223 bytes.
    """
    size = len(payload)
    if size > LONGEST:
        raise EncodeError(f"fast packet: {size} bytes are more than {LONGEST}")
    return _CUTS[size // 7](_SIZES[size] + payload + _PADDINGS[size % 7])


def _repeated(slot: _Slot, index: int, data: bytes) -> bool:
    if slot.ahead is not None:
        return data == slot.ahead
    return index == slot.next - 1 and data == slot.parts[-1]


def _end(first: bytes) -> int:
    """Number of frames of the message that begins with frame 0 `first`; 0 if none can."""
    if len(first) < 2 or first[1] > LONGEST or len(first) < min(8, first[1] + 2):
        return 0
    return 1 + first[1] // 7
