r"""The bus as lines of text, as network gateways write it: four forms, each both ways.

```
ydraw     17:33:21.107 R 19F51323 01 2F 30 70 00 2F 30 70     frames; R from the bus, T put on it by the gateway
          19F51323 01 2F 30 70 00 2F 30 70                    as a client sends it
candump   (1620807235.135072) can0 09F8017F#3E17B322B320590D  frames
n2kascii  A173321.107 23FF7 1F513 012F3070002F30709F          whole messages; source, destination, priority; PGN
seasmart  $PCDIN,01F119,00000000,0F,2AAF00D1067414FF*59       whole messages; PGN, time, source: no destination
```
Sources: YDWG-02 manual, appendix E; can-utils `lib.c` (candump -L); Actisense SDK, `nmea2000-type-A.md`; SeaSmart.Net
protocol specification 1.6, `$PCDIN`. The patterns are shared with the readers of recordings.
"""

import re
from collections.abc import Callable, Sequence
from functools import lru_cache, reduce
from operator import xor
from typing import Literal, NamedTuple

from timonel.core.frame import Frame
from timonel.errors import EncodeError
from timonel.nmea2000.fastpacket import LONGEST, Reassembler, fragment
from timonel.nmea2000.identifier import GLOBAL, join, split
from timonel.nmea2000.schedule import is_fast, priority

FormName = Literal["ydraw", "candump", "n2kascii", "seasmart"]

YDRAW = re.compile(
    r"(?:(\d\d):(\d\d):(\d\d(?:\.\d+)?) )?(?:([RT]) )?([0-9A-F]{8})((?: [0-9A-F]{2}){0,8}) ?", re.IGNORECASE
)
"""Hours, minutes, seconds (or None), direction (or None), identifier, data."""

N2K_ASCII = re.compile(
    r"A(\d\d)(\d\d)(\d\d(?:\.\d+)?) ([0-9A-F]{2})([0-9A-F]{2})([0-9A-F]) ([0-9A-F]{5}) ((?:[0-9A-F]{2})+)\s*",
    re.IGNORECASE,
)
"""Hours, minutes, seconds, source, destination, priority, PGN, data."""

# Runs once a line: no IGNORECASE, no group that repeats. Ten digits of seconds are enough until 2286.
CANDUMP = re.compile(
    r"\((\d{1,10}\.\d+)\)\s+\S+\s+([0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})#([0-9A-Fa-f]{0,16}|R\d?)(?: [RT])?\s*"
)
"""Unix seconds, identifier, data or a remote request."""

PCDIN = re.compile(
    r"\$(PCDIN,([0-9A-F]{6}),[0-9A-Z]{1,8},([0-9A-F]{2}),((?:[0-9A-F]{2}){1,223}))\*([0-9A-F]{2})\s*", re.IGNORECASE
)
"""What is summed, PGN, source, data, check sum."""

GATEWAYS_OWN = 0x40000
"""PGNs from here on are a gateway's own and were never on the bus (canboat)."""

LONGEST_LINE = 1024
"""Characters; PCDIN with a message of 223 bytes has 480."""


class Heard(NamedTuple):
    """What one line says.

    `whole`: `data` is a fast-packet message, put together. `sent`: the gateway marks it as put on the bus by itself.
    """

    identifier: int
    data: bytes
    extended: bool = True
    whole: bool = False
    sent: bool = False


class Form(NamedTuple):
    """A form: `read` raises ValueError for what is no line of it, and gives None where a line carries nothing.

    `report` writes what a gateway tells of its bus: (identifier, data, unix seconds, whether we sent it); `command`
    what a client sends it: (identifier, data, unix seconds). None: this form cannot say it.
    """

    whole: bool
    marks: bool
    """Whether a line tells what the gateway itself put on the bus."""
    read: Callable[[str], Heard | None]
    report: Callable[[int, bytes, float, bool], bytes | None]
    command: Callable[[int, bytes, float], bytes | None]


# Yacht Devices ------------------------------------------------------------------------------------


def read_ydraw(line: str) -> Heard | None:
    match = YDRAW.fullmatch(line)
    if match is None:
        return _nothing(line)
    mark, identifier, data = match.group(4, 5, 6)
    return Heard(_identifier(identifier), bytes.fromhex(data), sent=mark in ("T", "t"))


def report_ydraw(identifier: int, data: bytes, now: float, sent: bool) -> bytes:
    mark = "T" if sent else "R"
    return f"{_time_of_day(int(now * 1000), ':')} {mark} {identifier:08X} {_hex(data, ' ')}\r\n".encode()


def command_ydraw(identifier: int, data: bytes, now: float) -> bytes:
    return f"{identifier:08X} {_hex(data, ' ')}\r\n".encode()


# candump ------------------------------------------------------------------------------------------


def read_candump(line: str) -> Heard | None:
    match = CANDUMP.fullmatch(line)
    if match is None:
        return _nothing(line)
    identifier, data = match.group(2, 3)
    if data[:1] == "R":
        return None
    return Heard(_identifier(identifier), bytes.fromhex(data), extended=len(identifier) == 8)


def report_candump(identifier: int, data: bytes, now: float, sent: bool) -> bytes:
    return f"({now:.6f}) can0 {identifier:08X}#{_hex(data)}\r\n".encode()


def command_candump(identifier: int, data: bytes, now: float) -> bytes:
    return report_candump(identifier, data, now, True)


# Whole messages -----------------------------------------------------------------------------------


def read_n2k_ascii(line: str) -> Heard | None:
    match = N2K_ASCII.fullmatch(line)
    if match is None:
        return _nothing(line)
    source, destination, urgency, pgn, data = match.group(4, 5, 6, 7, 8)
    return _message(int(urgency, 16) & 7, int(pgn, 16), int(source, 16), int(destination, 16), data)


def report_n2k_ascii(identifier: int, data: bytes, now: float, sent: bool) -> bytes:
    urgency, pgn, source, destination = split(identifier)
    time = _time_of_day(int(now * 1000), "")
    return f"A{time} {source:02X}{destination:02X}{urgency:X} {pgn:05X} {_hex(data)}\r\n".encode()


def command_n2k_ascii(identifier: int, data: bytes, now: float) -> bytes:
    return report_n2k_ascii(identifier, data, now, True)


def read_seasmart(line: str) -> Heard | None:
    """Other sentences carry nothing, whatever they are: gateways mix them in."""
    match = PCDIN.fullmatch(line)
    if match is None:
        return None if line[:1] in ("$", "!") and not line.startswith("$PCDIN") else _nothing(line)
    body, pgn, source, data, checksum = match.groups()
    if reduce(xor, body.encode()) != int(checksum, 16):
        raise ValueError("wrong check sum")
    number = int(pgn, 16)
    return _message(priority(number), number, int(source, 16), GLOBAL, data)


def report_seasmart(identifier: int, data: bytes, now: float, sent: bool) -> bytes | None:
    """None for a message to one device: a line without its address would be for all. The time is left at zero,
    which some read as base 32 and some as hexadecimal."""
    _, pgn, source, destination = split(identifier)
    if destination != GLOBAL:
        return None
    body = f"PCDIN,{pgn:06X},00000000,{source:02X},{_hex(data)}"
    return f"${body}*{reduce(xor, body.encode()):02X}\r\n".encode()


def command_seasmart(identifier: int, data: bytes, now: float) -> bytes | None:
    return report_seasmart(identifier, data, now, True)


FORMS: dict[FormName, Form] = {
    "ydraw": Form(False, True, read_ydraw, report_ydraw, command_ydraw),
    "candump": Form(False, False, read_candump, report_candump, command_candump),
    "n2kascii": Form(True, False, read_n2k_ascii, report_n2k_ascii, command_n2k_ascii),
    "seasmart": Form(True, False, read_seasmart, report_seasmart, command_seasmart),
}


# What they share ----------------------------------------------------------------------------------


def _nothing(line: str) -> Heard | None:
    """None for a comment; ValueError for any other line."""
    if line and line[0] != "#" and not line.isspace():
        raise ValueError("not a line of this form")
    return None


def _identifier(digits: str) -> int:
    number = int(digits, 16)
    if number >> 29:
        raise ValueError("an identifier has 29 bits")
    return number


# A bus has a few hundred of these.
@lru_cache(maxsize=4096)
def _address(urgency: int, pgn: int, source: int, destination: int) -> tuple[int, bool]:
    """Identifier, and whether the PGN is a fast packet. ValueError if no identifier has such parts."""
    try:
        return join(urgency, pgn, source, destination), is_fast(pgn)
    except EncodeError as fault:
        raise ValueError(str(fault)) from fault


def _message(urgency: int, pgn: int, source: int, destination: int, digits: str) -> Heard | None:
    if pgn >= GATEWAYS_OWN:
        return None
    identifier, fast = _address(urgency, pgn, source, destination)
    data = bytes.fromhex(digits)
    if len(data) > (LONGEST if fast else 8):
        raise ValueError(f"{len(data)} bytes are too many for PGN {pgn}")
    return Heard(identifier, data, whole=fast)


# Most lines are of the same millisecond as the one before.
@lru_cache(maxsize=4)
def _time_of_day(now_ms: int, colon: str) -> str:
    """UTC of unix milliseconds: hours, minutes and seconds, with three decimals."""
    seconds, ms = divmod(now_ms, 1000)
    minutes, seconds = divmod(seconds % 86400, 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours:02}{colon}{minutes:02}{colon}{seconds:02}.{ms:03}"


def _hex(data: bytes, separator: str = "") -> str:
    return (data.hex(separator) if separator else data.hex()).upper()


class TextReader:
    """Bytes of a peer, however they are cut, to what its lines say; `rejected` counts lines that say nothing."""

    def __init__(self, form: Form) -> None:
        self.rejected = 0
        self._read = form.read
        self._rest = b""
        self._sequence = 0

    def receive(self, data: bytes) -> list[Heard]:
        """What the lines say that `data` completes."""
        *lines, self._rest = (self._rest + data).replace(b"\r", b"\n").split(b"\n")
        self._rest = self._rest[: LONGEST_LINE + 1]  # one too long stays too long
        return [heard for line in lines if line and (heard := self._heard(line)) is not None]

    def _heard(self, line: bytes) -> Heard | None:
        if len(line) <= LONGEST_LINE:
            try:
                return self._read(line.decode("latin-1"))
            except ValueError:
                pass
        self.rejected += 1
        return None

    def frames(self, heard: Heard) -> list[Frame]:
        """As it was on the bus; a whole message is taken apart."""
        if not heard.whole:
            return [Frame(heard.identifier, heard.data, heard.extended)]
        self._sequence = (self._sequence + 1) % 8
        return [Frame(heard.identifier, data) for data in fragment(heard.data, self._sequence)]


class TextWriter:
    """Frames to the payloads that a form carries: as they are, or whole messages, put together on the way out."""

    def __init__(self, form: Form) -> None:
        self._reassembler = Reassembler() if form.whole else None

    def payloads(self, frames: Sequence[Frame], now: float) -> list[tuple[int, bytes]]:
        """Identifier and data of what is complete; `now` is monotonic, s. 11-bit frames are not of NMEA 2000."""
        together = self._reassembler
        if together is None:
            return [(frame.identifier, frame.data) for frame in frames if frame.extended]
        found = []
        for frame in frames:
            if not frame.extended:
                continue
            if not is_fast(split(frame.identifier).pgn):
                found.append((frame.identifier, frame.data))
            elif (data := together.receive(frame.identifier, frame.data, now)) is not None:
                found.append((frame.identifier, data))
        return found
