"""Actisense's binary messages: the stream of an NGT-1 or W2K-1 as it came, and the log EBL that has it with times.

    10 02  93 13 02 02 F8 01 FF 7F AE 3A 0A 09 08 00 FC FF FF 00 00 FF FF E4  10 03
    DLE STX, a BST message with its check sum, each 10 in it twice, DLE ETX

    1B 01 03 20 5F 5E 92 B0 83 D7 01 1B 0A      EBL, before the messages: ESC SOH, a tag, ESC LF, each 1B twice
    1B 01 07 95 0E 28 9A ... 1B 0A              a BST message in a tag, without DLE, with or without its check sum

    BST   what                                          time
    93    a message that the gateway heard, whole       milliseconds since it was switched on
    94    a message for it to send, whole               none; its source is the gateway, and not told: 254
    95    a frame                                       16 bits of milliseconds, or of 100, 10, 1 us
    D0    a message, either way, whole                  milliseconds since it was switched on
    other the gateway's own                             passed over

A message's time is that of the tag before it in EBL (tag 3, 100 ns since 1601), else the gateway's own, which
counts from 1970-01-01 here. All bytes of a message, the check sum among them, add up to 0. Source: Actisense SDK,
`BST-93-NGT.md`, `BST-94-NGT.md`, `BST-95-can-frame.md`, `BST-D0.md` and the description of EBL; canboat `bst.rs`.
"""

import re
from collections.abc import Iterator

from timonel.nmea2000.identifier import NULL
from timonel.recording.lines import Kind, LogFrame, Unreadable, moment
from timonel.recording.messages import message
from timonel.recording.strays import Strays, unreadable_bytes

_LONGEST = 4096  # bytes of a message as it is sent; ISO transport's have 1785

# A message; or, at the end, the beginning of one.
_BDTP = re.compile(rb"\x10(?:\x02([^\x10]*(?:\x10\x10[^\x10]*)*)(?:\x10(?:(\x03)|\Z)|\Z)|\Z)")
# A tag; data, in which an ESC stands twice; or, at the end, the beginning of either.
_EBL = re.compile(
    rb"\x1b\x01([^\x1b]*(?:\x1b\x1b[^\x1b]*)*)\x1b\x0a|((?:[^\x1b]+|\x1b\x1b)+)|\x1b(?:\x01[^\x1b]*(?:\x1b\x1b[^\x1b]*)*\x1b?)?\Z"
)
_EBL_HEAD = re.compile(
    rb"\x1b\x01(?:\x01(?:[^\x1b]|\x1b\x1b){4}|\x03(?:[^\x1b]|\x1b\x1b){8}|\x07[\x93-\x95\xd0](?:[^\x1b]|\x1b\x1b)+)\x1b\x0a"
)
_TIME, _MESSAGE = 3, 7  # tags
_UNIX = 116_444_736_000_000_000  # 100 ns from 1601 to 1970
_TICKS = (1e-3, 1e-4, 1e-5, 1e-6)  # s, of BST 95

Results = Iterator[LogFrame | Unreadable]


class Ngt1:
    """The stream of a gateway."""

    name = "Actisense NGT-1"
    kind: Kind = "frames"
    dated = False

    @staticmethod
    def recognises(head: bytes) -> bool:
        return any(_adds_up(_plain(match[1])) for match in _BDTP.finditer(head) if match[2])

    def __init__(self, head: bytes) -> None:
        self._framer = _Bdtp()
        self._messages = _Messages()
        self._at = 0

    def receive(self, data: bytes) -> Results:
        for at, framed in self._framer.receive(data, self._at):
            yield from self._framer.strays.told()
            yield from self._messages.receive(at, framed)
        self._at += len(data)

    def finish(self) -> Results:
        yield from self._framer.finish()


class Ebl:
    """The log."""

    name = "Actisense EBL"
    kind: Kind = "frames"
    dated = True

    @staticmethod
    def recognises(head: bytes) -> bool:
        return _EBL_HEAD.search(head) is not None

    def __init__(self, head: bytes) -> None:
        self._framer = _Bdtp()
        self._messages = _Messages(own_time=False)
        self._rest = b""
        self._at = 0

    def receive(self, data: bytes) -> Results:
        data = self._rest + data
        start = 0
        while start < len(data):
            match = _EBL.match(data, start)
            tag, plain = match.groups() if match else (None, data[start : start + 1])
            if match and tag is None and plain is None:
                if len(data) - start <= _LONGEST:
                    break
                match, plain = None, data[start : start + 1]
            at = self._at + start
            start = match.end() if match else start + 1
            yield from self._plain(at, plain) if tag is None else self._tag(at, tag.replace(b"\x1b\x1b", b"\x1b"))
        self._rest = data[start:]
        self._at += start

    def finish(self) -> Results:
        yield from self._framer.finish()
        if self._rest:
            yield unreadable_bytes(self._at, self._rest, "cut off")

    def _plain(self, at: int, data: bytes) -> Results:
        for place, framed in self._framer.receive(data.replace(b"\x1b\x1b", b"\x1b"), at):
            yield from self._framer.strays.told()
            yield from self._messages.receive(place, framed)

    def _tag(self, at: int, tag: bytes) -> Results:
        kind, content = tag[:1], tag[1:]
        if kind == bytes((_TIME,)) and len(content) == 8:
            try:
                self._messages.stamp = moment((int.from_bytes(content, "little") - _UNIX) / 1e7)
            except ValueError as reason:
                yield unreadable_bytes(at, tag, str(reason))
        elif kind == bytes((_MESSAGE,)):
            unsigned = len(content) == _length(content)
            yield from self._messages.receive(at, content + bytes((-sum(content) & 0xFF,)) if unsigned else content)


class _Bdtp:
    """Finds what stands between DLE STX and DLE ETX, in a stream cut anywhere."""

    def __init__(self) -> None:
        self.strays = Strays()
        self._rest = b""
        self._rest_at = 0

    def receive(self, data: bytes, at: int) -> Iterator[tuple[int, bytes]]:
        """The messages that `data`, from offset `at` on, completes, with theirs."""
        at = self._rest_at if self._rest else at
        data = self._rest + data
        place = start = 0
        end = len(data)
        while match := _BDTP.search(data, start):
            if match[2] is None and end - match.start() <= _LONGEST:
                end = match.start()
                break
            start = match.start() + 1
            if match[2] is not None:
                self.strays.add(at + place, data[place : match.start()])
                yield at + match.start(), _plain(match[1])
                place = start = match.end()
        self.strays.add(at + place, data[place:end])
        self._rest, self._rest_at = data[end:], at + end

    def finish(self) -> Results:
        yield from self.strays.told()
        if self._rest:
            yield unreadable_bytes(self._rest_at, self._rest, "cut off")


class _Messages:
    """Reads messages of any kind; `stamp` is the time of those without one of their own."""

    def __init__(self, own_time: bool = True) -> None:
        self.stamp: float | None = None
        self._own_time = own_time
        self._elapsed = 0.0
        self._ticks = 0

    def receive(self, at: int, framed: bytes) -> Results:
        """What a message with its check sum, found at offset `at`, is."""
        try:
            frame = self._read(framed)
        except ValueError as reason:
            yield unreadable_bytes(at, framed, str(reason))
        else:
            if frame is not None:
                yield frame

    def _read(self, framed: bytes) -> LogFrame | None:
        if not _adds_up(framed):
            raise ValueError("wrong check sum")
        if len(framed) != _length(framed) + 1:
            raise ValueError("wrong length")
        match framed[0]:
            case 0x93:
                data = _counted(framed, 12)
                stamp = self._stamp(int.from_bytes(framed[8:12], "little"))
                return message(stamp, framed[2] & 7, _pgn(framed[3:6]), framed[7], framed[6], data)
            case 0x94:
                data = _counted(framed, 7)
                return message(self.stamp, framed[2] & 7, _pgn(framed[3:6]), NULL, framed[6], data)
            case 0x95:
                return self._frame(framed)
            case 0xD0:
                if len(framed) < 14:
                    raise ValueError("too short")
                stamp = self._stamp(int.from_bytes(framed[9:13], "little"))
                pgn = _pgn(framed[5:7] + bytes((framed[7] & 3,)))
                return message(stamp, framed[7] >> 2 & 7, pgn, framed[4], framed[3], framed[13:-1])
        return None

    def _frame(self, framed: bytes) -> LogFrame:
        if not 9 <= len(framed) <= 17:
            raise ValueError("not a frame of 0..8 bytes")
        ticks, identifier = int.from_bytes(framed[2:4], "little"), int.from_bytes(framed[4:8], "little")
        self._elapsed += (ticks - self._ticks & 0xFFFF) * _TICKS[identifier >> 29 & 3]
        self._ticks = ticks
        return LogFrame(self._elapsed if self._own_time else self.stamp, identifier & 0x1FFFFFFF, framed[8:-1])

    def _stamp(self, milliseconds: int) -> float | None:
        return milliseconds / 1000 if self._own_time else self.stamp


def _plain(framed: bytes) -> bytes:
    return framed.replace(b"\x10\x10", b"\x10")


def _adds_up(framed: bytes) -> bool:
    return len(framed) > 2 and sum(framed) & 0xFF == 0


def _length(framed: bytes) -> int:
    """Bytes of a message without its check sum, as it says itself."""
    if framed[:1] >= b"\xd0" and framed[:1] <= b"\xdf":
        return int.from_bytes(framed[1:3], "little")
    return 2 + int.from_bytes(framed[1:2], "little")


def _counted(framed: bytes, place: int) -> bytes:
    """The data that begin with their own length at `place` and end before the check sum."""
    if len(framed) < place + 2 or framed[place] != len(framed) - place - 2:
        raise ValueError("wrong length of its data")
    return framed[place + 1 : -1]


def _pgn(data: bytes) -> int:
    """A PGN of three bytes, lowest first; of one with a destination, the lowest is not its own."""
    pgn = int.from_bytes(data, "little")
    return pgn & ~0xFF if pgn & 0xFF00 < 0xF000 and pgn < 0x40000 else pgn
