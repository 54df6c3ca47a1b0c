"""`slcan:///dev/ttyACM0?bitrate=250000&baud=115200`: a CAN adapter that speaks Lawicel's ASCII protocol.

```
to the adapter     C Sn O          close the channel, set its bit rate, open it; C at the end
both ways          tiiildd..       data frame, 11-bit identifier, l bytes
                   Tiiiiiiiildd..  data frame, 29-bit identifier
from the adapter   z Z or nothing  taken;  BEL  not taken, counted
```
Each ends in CR. A time stamp of four digits after the data is accepted, remote frames (r R) and answers to
questions that others asked (V N F) are passed over, and anything else is a broken line: counted, never
fatal.
"""

import re
from collections.abc import Sequence
from functools import partial
from typing import TypeVar

from timonel.core.effects import Say
from timonel.core.frame import Frame
from timonel.links.link import Counters
from timonel.links.serial import OnSerial, close_serial
from timonel.links.wire import Wire

Incoming = TypeVar("Incoming")

SPEED = {
    10_000: b"S0",
    20_000: b"S1",
    50_000: b"S2",
    100_000: b"S3",
    125_000: b"S4",
    250_000: b"S5",
    500_000: b"S6",
    800_000: b"S7",
    1_000_000: b"S8",
}
DATA_FRAME = re.compile(rb"(?:T([0-9A-Fa-f]{8})|t([0-9A-Fa-f]{3}))([0-8])([0-9A-Fa-f]*)")
PASSED_OVER = frozenset(b"zZrRVNF")
LONGEST = len("Tiiiiiiii8") + 16 + len("ssss")
STAMP = 4
QUEUE = 64
STALE = 0.5


def encode(frame: Frame) -> bytes:
    """The line that sends a frame."""
    head = b"T%08X" if frame.extended else b"t%03X"
    return head % frame.identifier + b"%d" % len(frame.data) + frame.data.hex().upper().encode() + b"\r"


def decode(line: bytes) -> Frame | None:
    """The data frame of a line without its CR, None if it is not one to the last digit."""
    match = DATA_FRAME.fullmatch(line)
    if match is None:
        return None
    extended, standard, size, digits = match.groups()
    identifier = int(extended or standard, 16)
    length = 2 * int(size)
    if len(digits) not in (length, length + STAMP) or identifier > (0x1FFF_FFFF if extended else 0x7FF):
        return None
    return Frame(identifier, bytes.fromhex(digits[:length].decode()), extended is not None)


class SlcanParser:
    """Bytes of an adapter, however they are cut, to frames; counts broken lines and refusals."""

    def __init__(self, tally: Counters) -> None:
        self._tally = tally
        self._unfinished = b""

    def receive(self, data: bytes) -> list[Frame]:
        self._tally.errors += data.count(b"\a")
        lines = (self._unfinished + data.replace(b"\a", b"\r")).split(b"\r")
        self._unfinished = lines.pop()[: LONGEST + 1]  # one too long stays too long
        return [frame for line in lines if line and (frame := self._decode(line)) is not None]

    def _decode(self, line: bytes) -> Frame | None:
        frame = decode(line)
        if frame is None and line[0] not in PASSED_OVER:
            self._tally.rejected += 1
        return frame


class SlcanLink(OnSerial[list[Frame]]):
    """A bus behind a serial adapter. At most 64 frames wait for it, none of them longer than 0.5 s."""

    def __init__(self, path: str, *, bitrate: int = 250_000, baud: int = 115200, url: str = "", name: str = "") -> None:
        super().__init__(path, baud=baud, url=url, name=name)
        self.bitrate = bitrate

    async def _make_wire(self) -> Wire:
        port = await self._open_serial()
        wire = Wire(
            port.fileno(),
            receive=partial(self._parse, SlcanParser(self._tally)),
            lost=self._lost,
            release=partial(close_serial, port),
            tally=self._tally,
            urgent_max=QUEUE,
            stale_after=STALE,
        )
        wire.send([_command(b"C\r" + SPEED[self.bitrate] + b"\rO\r")])
        return wire

    def _parse(self, parser: SlcanParser, data: bytes) -> None:
        if frames := parser.receive(data):
            self._tally.frames_in += len(frames)
            self._receive(frames)

    def send(self, frames: Sequence[Frame]) -> None:
        if self._wire is None:
            self._tally.dropped += len(frames)
            return
        self._tally.frames_out += len(frames)
        self._wire.send([_command(encode(frame)) for frame in frames])

    async def close(self, drain: float = 0.5) -> None:
        if self._wire is not None:
            self._wire.send([_command(b"C\r")])
        await super().close(drain)


def _command(line: bytes) -> Say:
    return Say(line, "", urgent=True)
