"""The kinds of field a message is declared with: what stands in `Annotated[...]` behind a value's type.

```
U8 U16 U24 U32 U64  I8 I16 I24 I32 I64   a number: (resolution, unit, offset=, limit=)
Unsigned(bits)                           the same for odd lengths
Date  TimeOfDay                          days since 1970-01-01; seconds since midnight UTC
Bits(bits)                               a bit pattern: every value is valid, there is no "not available"
Lookup(bits, Enum)  Flags(bits, Enum)    one of a list; any of a list
Match(bits)                              a constant, the field's default, that tells variants of one PGN apart
Reserved(bits)  Spare(bits)              ones; zeros
Ascii(size)  Binary(size)                text and bytes of fixed size
StringLau()                              text of variable size
Float32(unit, limit)                     a number as IEEE 754 has it
Repeat(group, count)  Packed(field, count)   many of them; without `count`, up to the end
```
NMEA 2000 gives the highest values of a number a meaning of their own: not available, out of range, reserved.
From 8 bits there are all three, from 4 to 7 bits the first two, below that only the first; all of them read
as None. So does a value outside the range that the unit allows: a latitude of 107 degrees is none.
Source: canboat's database, `RangeMin`, `RangeMax` and `FieldTypes`.
"""

import math
import struct
from enum import IntEnum, IntFlag
from functools import cached_property, partial
from typing import Any, ClassVar, Protocol, Self

import msgspec

from timonel.errors import EncodeError

FULL_CIRCLE = {False: 2 * math.pi, True: math.pi}
PADDING = "@ \t\r\n"
FLOAT = struct.Struct("<f")
SECONDS_OF_DAY = 86401  # a leap second may make it one more than a day has


class Code(IntEnum):
    """Base of all lookups. A number without a name is a value too, `UNKNOWN_6`, and stays distinguishable."""

    @classmethod
    def _missing_(cls, value: object) -> Self | None:
        if not isinstance(value, int) or value < 0:
            return None
        unknown = int.__new__(cls, value)
        unknown._name_ = f"UNKNOWN_{value}"
        unknown._value_ = value
        return unknown


class Field(msgspec.Struct, frozen=True, dict=True):
    """Base of all kinds of field."""


class Fixed(Field, frozen=True):
    """A field of a fixed number of bits."""

    bits: int

    @property
    def ones(self) -> int:
        return (1 << self.bits) - 1

    @property
    def specials(self) -> int:
        """How many of the highest values have a meaning of their own."""
        return 3 if self.bits >= 8 else 2 if self.bits >= 4 else 1 if self.bits >= 2 else 0


class Number(Fixed, frozen=True):
    """A scaled number: value = raw * resolution + offset, in `unit`; an int if both of them are ints.

    `limit` is the largest magnitude that makes sense; angles in rad have theirs by their unit.
    """

    signed: bool
    resolution: float = 1
    unit: str = ""
    offset: float = 0
    limit: float | None = None

    @cached_property
    def integral(self) -> bool:
        return isinstance(self.resolution, int) and isinstance(self.offset, int)

    @cached_property
    def inverse(self) -> int | None:
        """The integer that raw is divided by, where there is one: division prints short, exact floats."""
        inverse = round(1 / self.resolution)
        return inverse if inverse > 1 and math.isclose(inverse * self.resolution, 1) else None

    @cached_property
    def not_available(self) -> int:
        return self.ones >> 1 if self.signed else self.ones

    @cached_property
    def range(self) -> tuple[int, int]:
        """The lowest and highest valid raw value."""
        highest = self.not_available - self.specials
        lowest = -self.not_available if self.signed else 0
        if self.magnitude is None:
            return lowest, highest
        bound = round(self.magnitude / self.resolution)
        return max(lowest, -bound), min(highest, bound)

    @cached_property
    def magnitude(self) -> float | None:
        return FULL_CIRCLE[self.signed] if self.limit is None and self.unit == "rad" else self.limit

    @cached_property
    def span(self) -> tuple[float, float]:
        """The lowest and highest value, rounded towards zero."""
        lowest, highest = self.range
        if self.magnitude is not None:
            bound = math.floor(self.magnitude / self.resolution * (1 + 1e-12))
            lowest, highest = max(lowest, -bound), min(highest, bound)
        return self.value(lowest), self.value(highest)

    def value(self, raw: int) -> float:
        """What the valid raw value `raw` means."""
        scaled = raw * self.resolution if self.inverse is None else raw / float(self.inverse)
        return scaled + self.offset if self.offset else scaled


class Bits(Fixed, frozen=True):
    """A bit pattern, as an unsigned int."""


class Lookup(Fixed, frozen=True):
    """One of a list. The highest values are None as those of a number are, up to the highest one with a name."""

    codes: type[Code]

    @cached_property
    def highest(self) -> int:
        return max(self.ones - self.specials, *(int(code) for code in self.codes))

    def meaning(self, raw: int) -> Code | None:
        return None if raw > self.highest else self.codes(raw)


class Flags(Fixed, frozen=True):
    """Any of a list, as an IntFlag."""

    flags: type[IntFlag]


class Match(Fixed, frozen=True):
    """A constant, which is the field's default."""


class Reserved(Fixed, frozen=True):
    """Sent as ones, not read."""


class Spare(Fixed, frozen=True):
    """Sent as zeros, not read."""


class Ascii(Field, frozen=True):
    """Text in a fixed number of bytes, padded with 0xFF; read up to 0xFF, 0x00 or `@`. Empty is None."""

    size: int

    @property
    def bits(self) -> int:
        return self.size * 8


class Binary(Field, frozen=True):
    """A fixed number of bytes that nobody has explained."""

    size: int

    @property
    def bits(self) -> int:
        return self.size * 8


U8, U16, U24, U32, U64 = (partial(Number, bits, False) for bits in (8, 16, 24, 32, 64))
I8, I16, I24, I32, I64 = (partial(Number, bits, True) for bits in (8, 16, 24, 32, 64))
Date = partial(Number, 16, False, 1, "d")
TimeOfDay = partial(Number, 32, False, 1e-4, "s", limit=SECONDS_OF_DAY)


def Unsigned(bits: int, resolution: float = 1, unit: str = "") -> Number:
    """An unsigned number of an odd length."""
    return Number(bits, False, resolution, unit)


class Variable(Field, frozen=True):
    """A field whose size is told by its content, or by earlier fields."""

    @property
    def counter(self) -> str:
        """The earlier field that says how many there are; sent as their number when it is None."""
        return ""

    @property
    def context(self) -> tuple[str, ...]:
        """The earlier fields that `read` and `write` are given."""
        return (self.counter,) if self.counter else ()

    def read(self, data: bytes, at: int, *context: Any) -> tuple[Any, int]:
        """The value at byte `at`, and where the next field begins: beyond the end if there was too little."""
        raise NotImplementedError

    def write(self, value: Any, *context: Any) -> bytes:
        """Raises EncodeError."""
        raise NotImplementedError


class StringLau(Variable, frozen=True):
    """Text with a length byte and a kind byte: 0 is UTF-16, 1 is ASCII. Empty or of another kind is None.

    Spaces and `@` at its end are padding, as canboat has it.
    """

    ENCODINGS: ClassVar = {0: "utf-16-le", 1: "utf-8"}

    def read(self, data: bytes, at: int, *context: Any) -> tuple[str | None, int]:
        if len(data) < at + 2:
            return None, at + 2
        end = at + max(data[at], 2)
        encoding = self.ENCODINGS.get(data[at + 1])
        text = data[at + 2 : end].decode(encoding, "ignore") if encoding else ""
        return text.split("\0")[0].rstrip(PADDING) or None, end

    def write(self, value: str | None, *context: Any) -> bytes:
        text = value or ""
        kind = 1 if text.isascii() else 0
        content = text.encode(self.ENCODINGS[kind], "surrogatepass")
        if len(content) > 253:
            raise EncodeError(f"{text[:20]!r}... has {len(content)} bytes, a string at most 253")
        return bytes((len(content) + 2, kind)) + content


class Float32(Variable, frozen=True):
    """A number in four bytes of IEEE 754, in `unit`. None is what is no number, or is not below `limit`.

    The makers who send floats have no value for *not available*: one that cannot be stands for it.
    """

    unit: str = ""
    limit: float = math.inf
    bits: ClassVar[int] = 32

    def read(self, data: bytes, at: int, *context: Any) -> tuple[float | None, int]:
        if len(data) < at + 4:
            return None, at + 4
        value: float = FLOAT.unpack_from(data, at)[0]
        return value if abs(value) < self.limit else None, at + 4

    def write(self, value: float | None, *context: Any) -> bytes:
        if value is None:
            return FLOAT.pack(self.limit)
        if abs(value) < self.limit:
            return FLOAT.pack(value)
        raise EncodeError(f"{value} {self.unit} is outside -{self.limit:g}..{self.limit:g}")


class Group(Protocol):
    """What `Repeat` needs to know of the message that is repeated."""

    layout: ClassVar[tuple[Any, ...]]

    @classmethod
    def read(cls, data: bytes, at: int) -> tuple[Any, int]: ...
    def encode(self) -> bytes: ...


class Repeat(Variable, frozen=True):
    """A tuple of `group`s: as many as the earlier field `count` says, or to the end of the message.

    A count that promises more than there is gives what is there; a group cut short is left out.
    """

    group: type[Group]
    count: str = ""

    @property
    def counter(self) -> str:
        return self.count

    def read(self, data: bytes, at: int, *context: Any) -> tuple[tuple[Any, ...], int]:
        wanted = (context[0] or 0) if context else len(data)
        groups: list[Any] = []
        while len(groups) < wanted and at < len(data):
            group, at = self.group.read(data, at)
            if at > len(data):
                break
            groups.append(group)
        return tuple(groups), at

    def write(self, value: Any, *context: Any) -> bytes:
        return b"".join(group.encode() for group in value)


class Packed(Variable, frozen=True):
    """A tuple of bit patterns or lookups without gaps between them, filled up with ones to whole bytes."""

    element: Bits | Lookup
    count: str = ""

    @property
    def counter(self) -> str:
        return self.count

    def read(self, data: bytes, at: int, *context: Any) -> tuple[tuple[Any, ...], int]:
        room = max(0, len(data) - at) * 8 // self.element.bits
        number = min(room, context[0] or 0) if context else room
        end = at + -(-number * self.element.bits // 8)
        packed = int.from_bytes(data[at:end], "little")
        raws = (packed >> place * self.element.bits & self.element.ones for place in range(number))
        if isinstance(self.element, Lookup):
            return tuple(self.element.meaning(raw) for raw in raws), end
        return tuple(raws), end

    def write(self, value: Any, *context: Any) -> bytes:
        packed, bits = 0, 0
        for item in value:
            raw = self.element.ones if item is None else int(item)
            if not 0 <= raw <= self.element.ones:
                raise EncodeError(f"{raw} is outside 0..{self.element.ones}")
            packed |= raw << bits
            bits += self.element.bits
        return (packed | (1 << -bits % 8) - 1 << bits).to_bytes(-(-bits // 8), "little")
