"""A definition of the catalogue as a layout: runs of fixed fields, and what stands between them.

The kinds of field are those of `core.fields`, and the few that only canboat's database has. Both decoders, that of
one payload and that of whole recordings, are made of the same `Plan`.
"""

from functools import cache
from itertools import groupby
from typing import Any

import msgspec

from timonel.core import codec
from timonel.core.fields import Ascii, Fixed, Number, Reserved
from timonel.core.message import Slot
from timonel.nmea2000.catalogue import Definition, Field, Group

UNBOUNDED = {"PGN", "ADDRESS"}
VARIABLE = {"STRING_LAU", "STRING_LZ", "DYNAMIC_FIELD_VALUE", "VARIABLE"}
ISO_NAMES = (1 << 64) - 3  # above it is nobody


class Ranged(Number, frozen=True):
    """A number that is shown wherever canboat shows it: `bounds`, or all that does not mean something else.

    The declared messages are stricter: they keep a latitude of 107 degrees from who steers by it.
    """

    bounds: tuple[int, int] | None = None

    @property
    def shift(self) -> int | None:
        """`offset` as a raw value: added before the scaling it leaves numbers as short as they are sent."""
        if self.integral or not self.offset or self.inverse is None:
            return None
        return round(self.offset * self.inverse)

    @property
    def range(self) -> tuple[int, int]:
        if self.bounds is not None:
            return self.bounds
        return -(1 << self.bits - 1) if self.signed else 0, self.not_available - self.specials


class Choice(Fixed, frozen=True):
    """One of a list; above `highest` is not available."""

    highest: int


class Choices(Fixed, frozen=True):
    """Any of a list, a bit each."""


class Real(Fixed, frozen=True):
    """A floating point number of 32 bits, times `resolution`."""

    resolution: float


class Decimal(Fixed, frozen=True):
    """A number with two decimal digits in each byte."""


class OddOctets(Fixed, frozen=True):
    """Bits that nobody has explained, between bytes."""


class Octets(Reserved, frozen=True):
    """Bytes that nobody has explained: as many of them as there are. They are not read with the other fields."""


class Place(msgspec.Struct, frozen=True):
    """A field in its place: `offset` in bits from where its run begins."""

    field: Field
    kind: Fixed | Ascii
    offset: int

    @property
    def bits(self) -> int:
        return self.kind.bits

    @property
    def first(self) -> int:
        """The byte in which it begins."""
        return self.offset // 8

    @property
    def need(self) -> int:
        """How many bits of the run must be there for it to have a value: text and bytes may be cut short.

        A constant is what the message was told by, and needs nothing.
        """
        if self.field.match is not None:
            return 0
        return self.offset + (8 if isinstance(self.kind, Ascii | Octets) else self.bits)


class Run(msgspec.Struct, frozen=True):
    """Fields of fixed size that follow each other, reserved bits included; `size` in bytes."""

    places: tuple[Place, ...]
    size: int

    @property
    def values(self) -> tuple[Place, ...]:
        """Those that have a value."""
        return tuple(place for place in self.places if not place.field.silent)

    @property
    def conditional(self) -> bool:
        """Whether it is there for proprietary PGNs only."""
        return bool(self.places[0].field.when)

    @property
    def least(self) -> int:
        """How many bytes must be there for the first value."""
        return -(-min((place.need for place in self.values), default=8 * self.size) // 8)

    def words(self) -> codec.Run:
        """The run cut into words, for the decoder; fields are named by their number."""
        slots = [Slot(str(number), place.offset, place.kind, None) for number, place in enumerate(self.places)]
        return codec.run(slots)


class Tail(msgspec.Struct, frozen=True):
    """One field whose size the content decides."""

    field: Field


class Repeated(msgspec.Struct, frozen=True):
    """A repeating set: what an item is made of."""

    group: Group
    parts: "tuple[Run | Tail, ...]"

    @property
    def size(self) -> int | None:
        """Of an item in bytes; None where the content decides."""
        (part, *others) = self.parts
        return part.size if isinstance(part, Run) and not others else None

    @property
    def least(self) -> int:
        """How many bytes must be there for an item to be one."""
        part = self.parts[0]
        return part.least if isinstance(part, Run) else 1

    @property
    def packed(self) -> bool:
        """Whether items stand without gaps between bytes; they have one field then."""
        return isinstance(self.parts[0], Run) and self.parts[0].places[-1].offset + self.parts[0].places[-1].bits < 8


Part = Run | Tail | Repeated


class Plan(msgspec.Struct, frozen=True):
    """What a payload is made of, in order."""

    parts: tuple[Part, ...]


@cache
def plan(definition: Definition) -> Plan:
    """The layout of a definition."""
    owner = {number: group for group in definition.groups for number in range(group.first, group.end)}
    parts: list[Part] = []
    for group, numbers in groupby(range(len(definition.fields)), owner.get):
        fields = [definition.fields[number] for number in numbers]
        made = _parts(definition, fields)
        parts += made if group is None else [Repeated(group, tuple(made))]
    return Plan(tuple(parts))


def single(field: Field) -> Run | Tail:
    """The layout of one field on its own, from a byte's beginning."""
    return Tail(field) if variable(field) else _run([field])


def variable(field: Field) -> bool:
    return field.kind in VARIABLE or bool(field.length) or field.bits is None


def _parts(definition: Definition, fields: list[Field]) -> list[Run | Tail]:
    parts: list[Run | Tail] = []
    for (is_variable, _), found in groupby(fields, lambda field: (variable(field), field.when)):
        group = list(found)
        parts += [Tail(field) for field in group] if is_variable else [_run(group)]
    return parts


def _run(fields: list[Field]) -> Run:
    places, offset = [], 0
    for field in fields:
        place = Place(field, kind(field, offset), offset)
        places.append(place)
        offset += place.bits
    return Run(tuple(places), -(-offset // 8))


def kind(field: Field, offset: int = 0) -> Fixed | Ascii:
    """What a field of fixed size is, at bit `offset`."""
    bits = field.bits
    assert bits is not None
    match field.kind:
        case "RESERVED" | "SPARE":
            return Reserved(bits)
        case "LOOKUP" | "INDIRECT_LOOKUP" | "DYNAMIC_FIELD_KEY":
            return _choice(field, bits)
        case "BITLOOKUP":
            return Choices(bits)
        case "FLOAT":
            return Real(bits, field.resolution)
        case "DECIMAL":
            return Decimal(bits)
        case "STRING_FIX":
            return Ascii(bits // 8)
        case "BINARY":
            return OddOctets(bits) if offset % 8 or bits % 8 else Octets(bits)
    return Ranged(bits, field.signed, field.resolution, field.unit, field.offset, None, _bounds(field, bits))


def _choice(field: Field, bits: int) -> Choice:
    """Of two bits, too, the second highest number is an error where it has no name."""
    ordinary = Choice(bits, 0)
    special = 2 if bits == 2 else ordinary.specials
    return Choice(bits, min(ordinary.ones, max(ordinary.ones - special, *field.labels, 0)))


def _bounds(field: Field, bits: int) -> tuple[int, int] | None:
    if field.kind in UNBOUNDED:
        return 0, (1 << bits) - 1
    if field.kind == "ISO_NAME":
        return 0, ISO_NAMES
    return field.range


def constant(field: Field) -> Any:
    """What a field that tells variants apart always says: its label, or its number."""
    assert field.match is not None
    return field.labels.get(field.match, field.match)
