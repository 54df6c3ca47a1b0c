"""Every message that canboat knows: its whole database, a definition a line of `catalogue.jsonl`.

The messages in `nmea2000.messages` are what this program speaks; these here are what it can read. A definition is
looked up by PGN and payload, because makers share proprietary PGNs and tell theirs apart by constants, and decodes
one payload (`Definition.decode`) or whole recordings (`catalogue_columns.columns`). Both are made when a definition
is first used, of the same kinds of field as the declared messages (`core.fields`).

```python
found = find(127250, payload)      # -> Definition, None for what canboat does not know
found.decode(payload)              # -> VesselHeading(heading=2.3154, reference="Magnetic")
found.as_dict(payload)             # -> {"heading": 2.3154, "reference": "Magnetic"}
found.as_json(payload)             # -> b'{"heading":2.3154,"reference":"Magnetic"}'
```
Units are those of canboat.json: SI, but for %, rpm, L, degrees of position and the like; `Field.unit` says which. Dates
are days since 1970-01-01, times s since midnight UTC. What the sender had no value for, said was wrong, reserved, or
what the message is too short for, is None; the last even where canboat makes a number of the bits that are left. A
number that makes no sense, a latitude of 107 degrees, is shown as canboat shows it: the declared messages, by which
somebody may steer, are stricter.

Source: canboat's database; `scripts/make_catalogue.py` says of which versions, so does the file's first line.
"""

import pkgutil
from collections.abc import Callable
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, Literal

import msgspec

if TYPE_CHECKING:
    from timonel.nmea2000.catalogue_codec import Decoder

# Where makers have PGNs of their own: the definition left when no variant fits, and the range it is for.
FALLBACKS = {
    0xEF00: (0xEF00, 0xEFFF),
    0xFF00: (0xFF00, 0xFFFF),
    0x1EF00: (0x1EF00, 0x1EFFF),
    0x1FF00: (0x1FF00, 0x1FFFF),
}


class Field(msgspec.Struct, frozen=True, dict=True):
    """A field of a definition, as canboat has it.

    `bits` is None where the content decides; value = raw * resolution + offset, in `unit`; `match` is the constant that
    the field must have; `range` the lowest and highest raw value, None where they follow from the number of bits;
    `lookup` names a list. `length` names the field that says how long this one is, `by` the one whose number makes
    the label together with this one's; `when` is "proprietary" where it is there for such a PGN only.
    """

    id: str = ""
    title: str = ""
    kind: str = "NUMBER"
    bits: int | None = None
    signed: bool = False
    resolution: int | float = 1
    offset: int = 0
    unit: str = ""
    match: int | None = None
    lookup: str = ""
    range: tuple[int, int] | None = None
    key: bool = False
    length: str = ""
    overhead: int = 0
    by: str = ""
    when: str = ""
    description: str = ""

    @property
    def silent(self) -> bool:
        """Whether it has no value: reserved and spare bits."""
        return self.kind in ("RESERVED", "SPARE")

    @cached_property
    def labels(self) -> dict[int, str]:
        """The words for its numbers, or for its bits by their place; none for a number."""
        if self.kind in ("LOOKUP", "BITLOOKUP"):
            return labels(self.lookup)
        if self.kind == "DYNAMIC_FIELD_KEY":
            return {number: field.title for number, field in keys(self.lookup).items()}
        return {}


class Group(msgspec.Struct, frozen=True, gc=False):
    """Fields `first` to before `end` of a definition, repeated as often as the field `counter` says; "" to the end."""

    name: Literal["list", "list2"]
    first: int
    end: int
    counter: str


class Definition(msgspec.Struct, frozen=True, dict=True):
    """A message, or one maker's variant of it. `transport` is "Single", "Fast", "ISO" or "Mixed"; `interval` in ms."""

    pgn: int
    id: str
    title: str
    transport: str
    fields: tuple[Field, ...]
    priority: int | None = None
    interval: int | None = None
    fallback: bool = False
    sets: tuple[tuple[int, int, int | None], ...] = ()

    @property
    def fast(self) -> bool:
        """Whether it travels as fast packet."""
        return self.transport == "Fast"

    @property
    def source(self) -> str:
        return f"canboat {VERSION} `{self.id}`"

    @cached_property
    def groups(self) -> tuple[Group, ...]:
        """Its repeating sets, in the order of their fields."""
        names: tuple[Literal["list", "list2"], ...] = ("list", "list2")
        return tuple(
            Group(name, first, first + size, "" if counter is None else self.fields[counter].id)
            for name, (first, size, counter) in zip(names, self.sets, strict=False)
        )

    @cached_property
    def pattern(self) -> tuple[int, int, int]:
        """The bits of a payload that it asks for, what they must be, and how many bytes that takes."""
        mask = value = end = at = 0
        for field in self.fields:
            if field.bits is None:
                break
            if field.match is not None:
                mask |= (1 << field.bits) - 1 << at
                value |= field.match << at
                end = -(-(at + field.bits) // 8)
            at += field.bits
        return mask, value, end

    @cached_property
    def message(self) -> type[msgspec.Struct]:
        """The type of its messages: frozen, canboat's field ids as attributes, None where there is no value.

        An id that Python cannot have as a name has `_` before it. Repeated fields are lists of such structs, `list`
        and `list2`, None where empty.
        """
        from timonel.nmea2000.catalogue_codec import message_type

        return message_type(self)

    @cached_property
    def decode(self) -> "Decoder":
        """Payload -> message, lookups as labels (a number without a label stays one), bytes as bytes. Never raises."""
        from timonel.nmea2000.catalogue_codec import decoder

        return decoder(self)

    @cached_property
    def decode_codes(self) -> "Decoder":
        """Payload -> message, lookups as numbers."""
        from timonel.nmea2000.catalogue_codec import decoder

        return decoder(self, labels=False)

    def as_dict(self, payload: bytes, labels: bool = True) -> dict[str, Any]:
        """The values by canboat's field ids; what is not available is left out, bytes are in hex."""
        found: dict[str, Any] = msgspec.to_builtins(self._text_decoder(labels)(payload))
        return found

    def as_json(self, payload: bytes, labels: bool = True) -> bytes:
        """`as_dict` as JSON."""
        return msgspec.json.encode(self._text_decoder(labels)(payload))

    def _text_decoder(self, labels: bool) -> "Decoder":
        return self._labelled if labels else self._numbered

    @cached_property
    def _labelled(self) -> "Decoder":
        from timonel.nmea2000.catalogue_codec import decoder

        return decoder(self, hexadecimal=True)

    @cached_property
    def _numbered(self) -> "Decoder":
        from timonel.nmea2000.catalogue_codec import decoder

        return decoder(self, labels=False, hexadecimal=True)


Finder = Callable[[bytes], Definition | None]


class _Index:
    """Where everything stands in the file; a line is parsed when it is asked for."""

    def __init__(self) -> None:
        data = pkgutil.get_data(__name__, "catalogue.jsonl")
        assert data is not None
        self.header, *lines = data.splitlines()
        self.definitions: dict[int, list[bytes]] = {}
        self.lists: dict[str, bytes] = {}
        self.pgn_of: dict[str, int] = {}
        for line in lines:
            if line.startswith(b'{"pgn":'):
                number, _, rest = line[7:].partition(b',"id":"')
                pgn = int(number)
                self.definitions.setdefault(pgn, []).append(line)
                self.pgn_of[rest[: rest.index(b'"')].decode()] = pgn
            else:
                self.lists[line.split(b'"', 4)[3].decode()] = line


class _List(msgspec.Struct):
    """A line with words for numbers."""

    labels: dict[int, str] = {}
    fields: dict[int, Field] = {}


class _Pairs(msgspec.Struct):
    """A line with words for pairs of numbers."""

    labels: dict[int, dict[int, str]]


_index = cache(_Index)
_definition = msgspec.json.Decoder(Definition).decode
_list = msgspec.json.Decoder(_List).decode
_pairs = msgspec.json.Decoder(_Pairs).decode


@cache
def labels(name: str) -> dict[int, str]:
    """The words for the numbers of a lookup, or for bits by their place."""
    return _list(_index().lists[name]).labels


@cache
def pairs(name: str) -> dict[int, dict[int, str]]:
    """The words for a number, by another field's number."""
    return _pairs(_index().lists[name]).labels


@cache
def keys(name: str) -> dict[int, Field]:
    """The fields that the keys of a list announce."""
    return _list(_index().lists[name]).fields


@cache
def variants(pgn: int) -> tuple[Definition, ...]:
    """Every definition of a PGN, in the order in which canboat tries them; none for one that it does not know."""
    return tuple(_definition(line) for line in _index().definitions.get(pgn, ()))


def by_id(identifier: str) -> Definition:
    """The definition that canboat calls `identifier`. Raises KeyError."""
    return next(found for found in variants(_index().pgn_of[identifier]) if found.id == identifier)


def identifiers() -> dict[str, int]:
    """The PGN of every definition, by what canboat calls it."""
    return _index().pgn_of


def pgns() -> list[int]:
    """Every PGN that has a definition. From 262144 on they are gateways' own and never on a bus."""
    return list(_index().definitions)


def find(pgn: int, payload: bytes) -> Definition | None:
    """The definition of a message: the first variant whose constants the payload has.

    Of a maker's own PGN that nobody explained, the one that reads the maker; None for any other unknown message.
    """
    return finder(pgn)(payload)


@cache
def finder(pgn: int) -> Finder:
    """`find` of one PGN, for the hot path."""
    found = candidates(pgn)
    single = only(pgn)
    if not found or single:
        return lambda payload: single
    patterns = [(*definition.pattern, definition) for definition in found]
    union, longest = _union(found)
    known: dict[int, Definition | None] = {}

    def first(head: int, size: int) -> Definition | None:
        for mask, value, end, definition in patterns:
            if head & mask == value and size >= end:
                return definition
        return None

    def search(payload: bytes) -> Definition | None:
        head = int.from_bytes(payload[:longest], "little") & union
        if len(payload) < longest:
            return first(head, len(payload))
        if head not in known:
            known[head] = first(head, longest)
        return known[head]

    return search


def only(pgn: int) -> Definition | None:
    """The definition of every message of a PGN; None where the payload decides, or nobody knows it."""
    found = candidates(pgn)
    return found[0] if found and not found[0].pattern[0] else None


def candidates(pgn: int) -> list[Definition]:
    """What a message of a PGN can be, in the order in which it is tried."""
    found = [definition for definition in variants(pgn) if not definition.fallback]
    for fallback, (first, last) in FALLBACKS.items():
        if first <= pgn <= last:
            found += [definition for definition in variants(fallback) if definition.fallback]
    return found


def _union(found: list[Definition]) -> tuple[int, int]:
    """All bits that tell variants apart, and how many bytes they take."""
    union = 0
    for definition in found:
        union |= definition.pattern[0]
    return union, max(definition.pattern[2] for definition in found)


VERSION = "9.0.0"
