"""A message of `bus`, the topic of our own recordings with the frames: CDR of ROS 2's `SCHEMA`, a column a field.

Compressed, columns take three quarters of the bytes that rows of all fields take, and three quarters of the time to
unpack. Recordings from before had rows (`ROW`); the size of a message tells which it has.
"""

import struct
from collections.abc import Iterator
from itertools import accumulate
from typing import NamedTuple

SCHEMA_NAME = "timonel/msg/FrameColumns"
SCHEMA = """\
# CAN frames of a tenth of a second. Frame i is entry i of each column; its data begins at data[8 * i].
uint32[] identifier  # bit 31: 29 bits, else 11
uint8[] data         # eight bytes a frame
uint16[] since       # microseconds since the frame before; the first one has the time of the message
uint8[] steps        # steps since the frame before, 0: told together; the first one has that of the message
uint8[] length
uint8[] flags        # 1: sent by the gateway, 2: goes on with the data of the one before
"""
EXTENDED = 1 << 31
SENT, CONTINUED = 1, 2
LONGEST_PAUSE, MOST_STEPS = 0xFFFF, 0xFF
"""What `since` and `steps` hold."""

ROWS_AT = 8
ROW = struct.Struct("<IBBH8sII")
"""As messages had them before: identifier, length, flags, nothing, data, microseconds since the message's time, and the
step; behind CDR's header and their number."""

PACKED = struct.Struct("<I8sHBBB")
"""A frame before it is put into columns: identifier, data, since, steps, length, flags."""

_HEAD = b"\0\1\0\0"  # CDR, little-endian
_COUNT = struct.Struct("<I")
_WIDTHS = (4, 8, 2, 1, 1, 1)  # bytes of a frame in each column, as in `PACKED`
_DATA = 1  # the column whose numbers are its bytes
_ALIGNED = 4


class Layout(NamedTuple):
    """Of a message: how many frames it has, and where its columns begin, without any if it has rows."""

    frames: int
    columns: tuple[int, ...]


class BusFrame(NamedTuple):
    """A frame of `bus`; `elapsed` in microseconds since the message's own time."""

    identifier: int
    data: bytes
    extended: bool
    sent: bool
    elapsed: int
    step: int


def message_of(packed: bytes | bytearray) -> bytearray:
    """The message of some frames, one behind the other as `PACKED` has them."""
    count = len(packed) // PACKED.size
    message = bytearray(_HEAD)
    first = 0
    for number, width in enumerate(_WIDTHS):
        column = bytearray(width * count)
        for byte in range(width):
            column[byte::width] = packed[first + byte :: PACKED.size]
        message += bytes(-len(message) % _ALIGNED) + _COUNT.pack(_numbers(number, count)) + column
        first += width
    return message


def layout(message: bytes) -> Layout | None:
    """How its frames stand in a message; None if it is not made of frames."""
    if len(message) < ROWS_AT:
        return None
    (count,) = _COUNT.unpack_from(message, len(_HEAD))
    if len(message) == ROWS_AT + ROW.size * count:
        return Layout(count, ())
    end, columns = len(_HEAD), []
    for number, width in enumerate(_WIDTHS):
        begin = end + -end % _ALIGNED + _COUNT.size
        end = begin + width * count
        if end > len(message) or _COUNT.unpack_from(message, begin - _COUNT.size) != (_numbers(number, count),):
            return None
        columns.append(begin)
    return Layout(count, tuple(columns)) if end == len(message) else None


def frames_of(message: bytes, step: int) -> list[BusFrame]:
    """The frames of a message, which began in `step`; none if it is not made of frames.

    Runs once a frame: written for speed.
    """
    found = layout(message)
    if found is None:
        return []
    frames: list[BusFrame] = []
    cells = _columns(message, found, step) if found.columns else _rows(message)
    for number, length, flags, content, elapsed, own_step in cells:
        if flags & CONTINUED and frames:
            frames[-1] = frames[-1]._replace(data=frames[-1].data + content[:length])
            continue
        extended, sent = bool(number & EXTENDED), bool(flags & SENT)
        frames.append(BusFrame(number & ~EXTENDED, content[:length], extended, sent, elapsed, own_step & 0xFFFFFFFF))
    return frames


_Cells = tuple[int, int, int, bytes, int, int]
"""Of a frame: identifier, length, flags, eight bytes of data, microseconds since the message's time, and the step."""


def _columns(message: bytes, found: Layout, step: int) -> Iterator[_Cells]:
    count, (identifier, data, since, steps, length, flags) = found
    return zip(
        struct.unpack_from(f"<{count}I", message, identifier),
        message[length : length + count],
        message[flags : flags + count],
        (message[at : at + 8] for at in range(data, data + 8 * count, 8)),
        accumulate(struct.unpack_from(f"<{count}H", message, since)),
        (step + later for later in accumulate(message[steps : steps + count])),
        strict=True,
    )


def _rows(message: bytes) -> Iterator[_Cells]:
    for number, length, flags, _, content, elapsed, step in ROW.iter_unpack(message[ROWS_AT:]):
        yield number, length, flags, content, elapsed, step


def _numbers(column: int, count: int) -> int:
    """How many numbers the column of so many frames has."""
    return count * _WIDTHS[_DATA] if column == _DATA else count
