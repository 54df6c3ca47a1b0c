r"""TAG blocks: what stands between two backslashes before a sentence and tells of it.

    \g:1-2-34,s:VR0001,n:12,c:1700000000*hh\$...

```
s  who sent it     d  whom it is for     n  number of the line     t  text
c  when, unix s    g  part, of how many, code of the group         all others are passed over
```
A block has a check sum of its own over what stands between. Sources: NMEA 0183 4.10; IEC 61162-450, 7.2.3.
"""

import msgspec

from timonel.nmea0183.checksum import Fault, checksum


class TagBlock(msgspec.Struct, frozen=True):
    """What a block tells; None is what it does not."""

    source: str | None = None
    destination: str | None = None
    line: int | None = None
    group: tuple[int, int, int] | None = None
    """Which part, of how many, of which group."""
    time: float | None = None
    """Unix seconds; some write milliseconds."""


NOTHING = TagBlock()
_MILLISECONDS = 1e11  # a greater number is none of seconds for three thousand years


def split(line: bytes) -> tuple[TagBlock | Fault, bytes]:
    """The block that `line` begins with, and what stands behind it. A line without one has an empty one."""
    if line[:1] != b"\\":
        return NOTHING, line
    block, end, rest = line[1:].partition(b"\\")
    return (read(block) if end else Fault.MALFORMED), rest


def is_sound(data: bytes) -> bool:
    """Whether `data` is one whole block, backslashes and all, with the check sum that it says."""
    return len(data) > 1 and data[:1] == b"\\" == data[-1:] and not isinstance(_summed(data[1:-1]), Fault)


def read(block: bytes) -> TagBlock | Fault:
    """A block without its backslashes, or what is wrong with it."""
    body = _summed(block)
    if isinstance(body, Fault):
        return body
    fields = dict(field.partition(":")[::2] for field in body.split(","))
    try:
        return TagBlock(
            fields.get("s") or None,
            fields.get("d") or None,
            int(fields["n"]) if "n" in fields else None,
            _group(fields["g"]) if "g" in fields else None,
            _time(fields["c"]) if "c" in fields else None,
        )
    except ValueError:
        return Fault.MALFORMED


def write(tag: TagBlock) -> bytes:
    """A block with its backslashes."""
    fields = []
    if tag.group is not None:
        fields.append("g:{}-{}-{}".format(*tag.group))
    if tag.source is not None:
        fields.append(f"s:{tag.source}")
    if tag.destination is not None:
        fields.append(f"d:{tag.destination}")
    if tag.line is not None:
        fields.append(f"n:{tag.line}")
    if tag.time is not None:
        fields.append(f"c:{tag.time:.0f}")
    body = ",".join(fields).encode()
    return b"\\%b*%02X\\" % (body, checksum(body))


def _summed(block: bytes) -> str | Fault:
    """The fields of a block whose check sum is right."""
    body, star, digits = block.rpartition(b"*")
    if not star or len(digits) != 2 or not block.isascii():
        return Fault.MALFORMED
    try:
        said = int(digits, 16)
    except ValueError:
        return Fault.MALFORMED
    return body.decode() if checksum(body) == said else Fault.WRONG_CHECKSUM


def _group(text: str) -> tuple[int, int, int]:
    part, total, code = map(int, text.split("-"))
    return part, total, code


def _time(text: str) -> float:
    seconds = float(text)
    return seconds / 1000 if seconds > _MILLISECONDS else seconds
