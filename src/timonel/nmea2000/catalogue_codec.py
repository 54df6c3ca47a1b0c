"""Generates the function that makes a message of a payload, from a definition of the catalogue.

As in `core.codec`, one precompiled `struct.Struct` takes all fixed fields of a run at once; `source(definition)` shows
the Python that is made. A run that the payload cuts short takes the slow way: it is filled up, and the fields that were
not there whole are None.
"""

import keyword
import math
import struct
from collections.abc import Callable, Iterable
from functools import cache, partial
from typing import Any

import msgspec

from timonel.core import codec
from timonel.core.fields import Ascii
from timonel.nmea2000.catalogue import Definition, Field, Group, candidates, keys, pairs
from timonel.nmea2000.catalogue_layout import (
    Choice,
    Choices,
    Decimal,
    Octets,
    OddOctets,
    Place,
    Ranged,
    Real,
    Repeated,
    Run,
    Tail,
    constant,
    plan,
    single,
)

Decoder = Callable[[bytes], Any]
LAU = {0: "utf-16-le", 1: "utf-8"}
EVERYTHING = 1 << 16
EXACT = 1 << 53  # integers up to it are floats without loss: their quotient is that of the floats


class Flavour(msgspec.Struct, frozen=True):
    """How values are shown: lookups as labels or numbers, bytes as they are or in hex."""

    labels: bool
    hexadecimal: bool


# Types of messages ---------------------------------------------------------------------------------


def attribute(identifier: str) -> str:
    """The name by which Python has a field."""
    return identifier if identifier.isidentifier() and not keyword.iskeyword(identifier) else f"_{identifier}"


@cache
def message_type(definition: Definition) -> type[msgspec.Struct]:
    """See `Definition.message`."""
    inside = {number for group in definition.groups for number in range(group.first, group.end)}
    fields = [field for number, field in enumerate(definition.fields) if number not in inside]
    return _struct(definition.id, fields, [group.name for group in definition.groups])


@cache
def item_type(definition: Definition, group: Group) -> type[msgspec.Struct]:
    """The type of an item of a repeating set."""
    return _struct(f"{definition.id}_{group.name}", definition.fields[group.first : group.end], [])


def _struct(name: str, fields: Iterable[Field], lists: list[str]) -> type[msgspec.Struct]:
    ids = [field.id for field in fields if not field.silent] + lists
    return msgspec.defstruct(
        attribute(name),
        [(attribute(identifier), Any, None) for identifier in ids],
        rename={attribute(identifier): identifier for identifier in ids},
        frozen=True,
        gc=False,
        omit_defaults=True,
    )


# Values --------------------------------------------------------------------------------------------


def text(raw: bytes) -> str | None:
    """Text of a fixed size up to its padding (0xFF, 0x00 or `@`); None if nothing is left."""
    for pad in (b"\xff", b"\0", b"@"):
        raw = raw.split(pad, 1)[0]
    return _characters(raw).rstrip() or None


def _characters(raw: bytes) -> str:
    """UTF-8, as newer devices send it, else Latin-1."""
    try:
        return raw.decode()
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def lau(data: bytes, at: int) -> tuple[str | None, int]:
    """Text with a length byte, which counts itself and the kind byte that follows it; and where it ends."""
    if len(data) < at + 2:
        return None, len(data)
    end = at + max(data[at], 2)
    raw = data[at + 2 : end]
    match data[at + 1]:
        case 0:
            found = raw[: len(raw) & ~1].decode("utf-16-le", "ignore")
        case 1:
            found = _characters(raw.split(b"\xff", 1)[0])
        case _:
            return None, end
    return found.split("\0", 1)[0].rstrip("@ \t\r\n") or None, end


def lz(data: bytes, at: int) -> tuple[str | None, int]:
    """Text with a length byte, which counts neither itself nor the zero byte at the end; and where it ends."""
    if len(data) <= at:
        return None, at
    end = at + 1 + data[at]
    return _characters(data[at + 1 : end].split(b"\0", 1)[0]).rstrip() or None, end + 1


def real(raw: int, resolution: float) -> float | None:
    """The floating point number in 32 bits, times `resolution`; None unless it is finite."""
    number: float = struct.unpack("<f", raw.to_bytes(4, "little"))[0]
    return number * resolution if math.isfinite(number) else None


def decimal(raw: int, size: int) -> int | None:
    """The number whose bytes have two digits each; None if one has more."""
    number = 0
    for byte in raw.to_bytes(size, "little"):
        if byte > 99:
            return None
        number = 100 * number + byte
    return number


def _hexadecimal(raw: bytes | None) -> str | None:
    return None if raw is None else raw.hex().upper()


def _set_bits(labels: dict[int, str], bits: int, raw: int) -> list[str | int]:
    """The labels of the bits that are set; a bit without one is its value."""
    return [labels.get(bit, 1 << bit) for bit in range(bits) if raw >> bit & 1]


def table(place: Place, flavour: Flavour) -> Any:
    """What each raw value of a lookup means."""
    assert isinstance(place.kind, Choice)
    labels, highest = place.field.labels if flavour.labels else {}, place.kind.highest
    if place.bits > 8:
        return codec.Table(lambda raw: labels.get(raw, raw) if raw <= highest else None)
    return [labels.get(raw, raw) if raw <= highest else None for raw in range(place.kind.ones + 1)]


def _paired(field: Field, highest: int) -> Callable[[int, int], Any]:
    """The label of a number, by the number of another field."""
    labels = pairs(field.lookup)
    return lambda by, raw: labels.get(by, {}).get(raw, raw) if raw <= highest else None


# Generated functions -------------------------------------------------------------------------------


@cache
def decoder(definition: Definition, labels: bool = True, hexadecimal: bool = False) -> Decoder:
    """The function from payload to message."""
    made: Decoder = _Source(definition, Flavour(labels, hexadecimal)).function("decode")
    return made


def source(definition: Definition) -> str:
    """The Python that decodes it."""
    return _Source(definition, Flavour(True, False)).text()


class _Source:
    """Lines of Python, and the objects that they name."""

    def __init__(self, definition: Definition, flavour: Flavour) -> None:
        self.definition = definition
        self.flavour = flavour
        self.scope: dict[str, Any] = {"error": struct.error, "real": real, "decimal": decimal, "text": text}
        self.scope |= {"Table": codec.Table, "hexadecimal": _hexadecimal, "cls": message_type(definition)}
        self.numbers = {field.id: number for number, field in enumerate(definition.fields)}
        self.wanted = _wanted(definition)
        self.lines: list[str] = []
        self.runs = 0
        self._decode()

    def text(self) -> str:
        return "\n".join(self.lines) + "\n"

    def function(self, name: str) -> Any:
        exec(compile(self.text(), f"<decoder of {self.definition.id}>", "exec"), self.scope)
        return self.scope[name]

    def value(self) -> Callable[[bytes, int], Any]:
        """The value alone, of a definition with one field of fixed size; None without one (reserved bits)."""
        (part,) = plan(self.definition).parts
        assert isinstance(part, Run)
        run = self._run(part)
        otherwise = f"return (*short_{run}(data, at), None)[0]"
        value = (*self._values(part, "at"), "None")[0]
        self.lines += ["def value(data, at=0):", *self._unpacked(run, part, "data, at", otherwise), f" return {value}"]
        made: Callable[[bytes, int], Any] = self.function("value")
        return made

    def _decode(self) -> None:
        parts = plan(self.definition).parts
        if len(parts) == 1 and isinstance(parts[0], Run):
            self.lines += self._one_run(parts[0])
            return
        lines = [line for part in parts for line in self._part(part)]
        order = [f"v{self.numbers[field.id]}" for field in self._outside() if not field.silent]
        order += [f"v_{group.name}" for group in self.definition.groups]
        self.lines += ["def decode(data):", " at, end = 0, len(data)", *lines, f" return cls({', '.join(order)})"]

    def _outside(self) -> list[Field]:
        inside = {number for group in self.definition.groups for number in range(group.first, group.end)}
        return [field for number, field in enumerate(self.definition.fields) if number not in inside]

    def _one_run(self, part: Run) -> list[str]:
        run = self._run(part)
        return [
            "def decode(data):",
            *self._unpacked(run, part, "data", f"return cls(*short_{run}(data, 0))"),
            f" return cls({', '.join(self._values(part, ''))})",
        ]

    def _part(self, part: Run | Tail | Repeated) -> list[str]:
        """Lines that set the names of a part to its values, and `at` to where it ends."""
        match part:
            case Run():
                return self._run_lines(part)
            case Tail():
                return self._tail_lines(part)
        return self._repeated_lines(part)

    def _run_lines(self, part: Run) -> list[str]:
        run, words, names = self._run(part), self._words(part), self._names(part)
        given = [*codec.join_words(words), *map(" {} = {}".format, names, self._values(part, "at", raws=True))]
        unpacked = [
            " try:",
            f"  {codec.word_names(words)} = unpack_{run}(data, at)",
            " except error:",
            f"  {_tuple(names)} = short_{run}(data, at)",
            " else:",
            *_inside(given),
        ]
        lines = [*(unpacked if words.words else given), f" at += {part.size}"]
        if not part.conditional:
            return lines
        self.scope["proprietary"] = proprietary
        nothing = " = ".join([*names, "None"])
        return [f" if proprietary(v{self.numbers['pgn']}):", *_inside(lines), " else:", f"  {nothing}"]

    def _names(self, part: Run) -> list[str]:
        """What the values of a run are called, and the raw values that others need."""
        numbers = [self.numbers[place.field.id] for place in part.values]
        return [f"v{number}" for number in numbers] + [f"r{self.numbers[name]}" for name in self._raws(part)]

    def _tail_lines(self, part: Tail) -> list[str]:
        field, number = part.field, self.numbers[part.field.id]
        if field.kind == "DYNAMIC_FIELD_VALUE":
            key, length = self._keyed(field)
            kind = f"keyed_{number}[{key}, {length}]"
            return [f" size, value = {kind}", " first, at = at, at + size", *self._keyed_lines(number)]
        self.scope[f"tail_{number}"] = tail_reader(self.definition, field, self.flavour)
        context = f", v{self.numbers[field.length]}" if field.length else ""
        return [f" v{number}, at = tail_{number}(data, at{context})"]

    def _keyed(self, field: Field) -> tuple[str, str]:
        """Names what reads a value whose kind its key tells; the names of its key and its length."""
        key, length = announced_by(self.definition, field)
        number = self.numbers[field.id]
        self.scope[f"keyed_{number}"] = Keyed(key, length, self.flavour)
        self.scope["octets"] = partial(_octets, self.flavour.hexadecimal)
        return f"r{self.numbers[key.id]}" if key else "None", f"v{self.numbers[length.id]}" if length else "None"

    def _keyed_lines(self, number: int) -> list[str]:
        """Lines that read the value between `first` and `at`, if it is there whole."""
        return [
            " if value is not None and at <= end:",
            f"  v{number} = value(data, first)",
            " else:",
            f"  v{number}, at = octets(data, first, size)",
        ]

    def _repeated_lines(self, part: Repeated) -> list[str]:
        group = part.group
        count = f"v{self.numbers[group.counter]} or 0" if group.counter else str(EVERYTHING)
        name, item = f"v_{group.name}", item_type(self.definition, group)
        if any(isinstance(one, Tail) and one.field.kind == "VARIABLE" for one in part.parts):
            owner = "r" + str(self.numbers["manufacturerCode"]) if "manufacturerCode" in self.numbers else "None"
            self.scope[f"list_{name}"] = partial(parameters, item, self.flavour)
            return [f" {name}, at = list_{name}(data, at, {count}, v{self.numbers['pgn']}, {owner})"]
        if part.packed:
            assert isinstance(part.parts[0], Run)
            self.scope[f"list_{name}"] = partial(packed, item, table(part.parts[0].places[0], self.flavour))
            return [f" {name}, at = list_{name}(data, at, {count})"]
        self.scope[f"cls_{name}"] = item
        if len(part.parts) == 1 and isinstance(part.parts[0], Run) and self._is_words(part.parts[0]):
            return self._fixed_items(part.parts[0], part.least, name, count)
        order = [f"v{number}" for number in range(group.first, group.end) if not self.definition.fields[number].silent]
        counted = bool(group.counter)  # if not they go on to the end: each takes at least a byte
        return [
            f" {name} = []",
            *[f" left = {count}"] * counted,
            f" while {'left > 0 and ' * counted}at + {part.least} <= end:",
            *_inside(self._item_lines(part)),
            f"  {name}.append(cls_{name}({', '.join(order)}))",
            *["  left -= 1"] * counted,
            f" {name} = {name} or None",
        ]

    def _item_lines(self, part: Repeated) -> list[str]:
        """Lines that read an item: where two bytes tell its kind and its size, they are looked up as they are."""
        match part.parts:
            case (Run(size=size) as head, Tail(field=Field(kind="DYNAMIC_FIELD_VALUE") as field)) if size <= 2:
                key, length = self._keyed(field)
                number, names = self.numbers[field.id], [name for name in self._names(head) if name[0] == "v"]
                known = [*names, f"*keyed_{number}[{key}, {length}]"]
                self.lines += [f"def head_{number}(data, at=0):", *self._run_lines(head), f" return {_tuple(known)}"]
                self.lines += [f"heads_{number} = Table(head_{number})"]
                found = f" {_tuple([*names, 'size', 'value'])} = heads_{number}[data[at:first]]"
                return [f" first = at + {size}", found, " at = first + size", *self._keyed_lines(number)]
        return [line for one in part.parts for line in self._part(one)]

    def _fixed_items(self, part: Run, least: int, name: str, count: str) -> list[str]:
        """A repeating set whose items are one run: all that are whole are unpacked at once."""
        run = self._run(part)
        words = self._words(part)
        self.scope[f"each_{run}"] = struct.Struct(_format(words, part.size)).iter_unpack
        return [
            f" {name}, left = [], {count}",
            " if left and at <= end:",
            f"  behind = at + left * {part.size}",
            "  if behind > end:",
            f"   behind = at + (end - at) // {part.size} * {part.size}",
            f"  for {codec.word_names(words)} in each_{run}(data[at:behind]):",
            *_inside(_inside(codec.join_words(words))),
            f"   {name}.append(cls_{name}({', '.join(self._values(part, ''))}))",
            f"  if len({name}) < left and behind + {least} <= end:",
            f"   {name}.append(cls_{name}(*short_{run}(data, behind)))",
            f"   behind += {part.size}",
            "  at = behind",
            f" {name} = {name} or None",
        ]

    def _raws(self, part: Run) -> list[str]:
        """The fields of a run whose raw values others need."""
        return [place.field.id for place in part.values if place.field.id in self.wanted]

    def _is_words(self, part: Run) -> bool:
        """Whether all that is needed of a run stands in its words, and nobody needs more than the values."""
        return not self._raws(part) and not any(isinstance(place.kind, Octets) for place in part.places)

    def _words(self, part: Run) -> codec.Run:
        """The words of a run that have more than constants in them."""
        run, others = part.words(), self.wanted | {place.field.by for place in part.places}
        places = {str(number): place.field for number, place in enumerate(part.places)}
        read = {name for name, field in places.items() if field.match is None or field.id in others}
        words = [word for word in run.words if any(slot.name in read for slot in word.slots)]
        return msgspec.structs.replace(run, words=words)

    def _run(self, part: Run) -> int:
        """Names what a run and its slow way need; its number N."""
        run = self.runs
        self.runs += 1
        words = self._words(part)
        end = words.words[-1].end if words.words else 0
        self.scope[f"unpack_{run}"] = struct.Struct(_format(words)).unpack_from
        for place in part.values:
            self._name(place)
        self.scope[f"short_{run}"] = self._short(run, part, end)
        return run

    def _short(self, run: int, part: Run, end: int) -> Callable[[bytes, int], Any]:
        """The slow way: for each number of bytes that are left a function of its own, made when it is met."""
        made: dict[int, Callable[[bytes, int, bytes], Any]] = {}

        def function(have: int) -> Callable[[bytes, int, bytes], Any]:
            values = self._values(part, "at", raws=True, have=have)
            lines = ["def cut(data, at, filled):", *self._unpacked(run, part, "filled", "raise")]
            lines += [f" return {_tuple(values)}"]
            scope = dict(self.scope)
            exec(compile("\n".join(lines), f"<decoder of {self.definition.id}>", "exec"), scope)
            cut: Callable[[bytes, int, bytes], Any] = scope["cut"]
            return cut

        def short(data: bytes, at: int) -> Any:
            have = max(0, len(data) - at)
            if have not in made:
                made[have] = function(have)
            return made[have](data, at, data[at:] + b"\xff" * end)

        return short

    def _unpacked(self, run: int, part: Run, window: str, otherwise: str) -> list[str]:
        """Lines that set the words of a run to what stands in `window`."""
        words = self._words(part)
        return [
            " try:",
            f"  {codec.word_names(words)} = unpack_{run}({window})",
            " except error:",
            f"  {otherwise}",
            *codec.join_words(words),
        ]

    def _values(self, part: Run, at: str, raws: bool = False, have: int | None = None) -> list[str]:
        """Their expressions, in a run that begins at `at`; None for what `have` bytes are too few for."""
        words = part.words()
        word_of = {slot.name: word for word in words.words for slot in word.slots}
        expressions, raw_of = [], {}
        for number, place in enumerate(part.places):
            if word := word_of.get(str(number)):
                slot = next(slot for slot in word.slots if slot.name == str(number))
                raw_of[place.field.id] = codec.raw_value(slot, word, place.offset - 8 * word.start)
        cut = {place.field.id for place in part.values if have is not None and place.need > 8 * have}
        for place in part.values:
            value = "None" if place.field.id in cut else self._value(place, raw_of, at)
            expressions.append(value)
        if raws:
            expressions += ["None" if name in cut else raw_of[name] for name in self._raws(part)]
        return expressions

    def _name(self, place: Place) -> None:
        """Puts what a field's expression names into the scope."""
        number, field, kind = self.numbers[place.field.id], place.field, place.kind
        if field.match is not None:
            self.scope[f"constant_{number}"] = constant(field) if self.flavour.labels else field.match
        elif isinstance(kind, Choice) and field.by and self.flavour.labels:
            self.scope[f"pair_{number}"] = _paired(field, kind.highest)
        elif isinstance(kind, Choice):
            self.scope[f"table_{number}"] = table(place, self.flavour)
        elif isinstance(kind, Choices):
            self.scope[f"bits_{number}"] = partial(_set_bits, field.labels, place.bits)

    def _value(self, place: Place, raw_of: dict[str, str], at: str) -> str:
        """The expression of a field's value."""
        number, field = self.numbers[place.field.id], place.field
        raw = raw_of.get(field.id, "")
        if field.match is not None:
            return f"constant_{number}"
        match place.kind:
            case Ranged(shift=int(shift)) as kind:
                lowest, highest = kind.range
                return (
                    f"(t + {shift}) / {float(kind.inverse or 1)!r} if {lowest} <= (t := {raw}) <= {highest} else None"
                )
            case Ranged() as kind:
                return _number(kind, raw)
            case Choice():
                by = raw_of.get(field.by)
                return f"pair_{number}({by}, {raw})" if field.by and self.flavour.labels else f"table_{number}[{raw}]"
            case Choices():
                return f"bits_{number}({raw})" if self.flavour.labels else raw
            case Real(resolution=resolution):
                return f"real({raw}, {float(resolution)!r})"
            case Decimal():
                return f"decimal({raw}, {place.bits // 8})"
            case Ascii():
                return f"text({raw})"
            case OddOctets():
                return self._bytes(f"({raw}).to_bytes({-(-place.bits // 8)}, 'little')")
            case Octets():
                start = f"{at} + {place.first}" if at else str(place.first)
                return self._bytes(f"data[{start} : {start} + {place.bits // 8}] or None")
        raise AssertionError(field.kind)

    def _bytes(self, expression: str) -> str:
        return f"hexadecimal({expression})" if self.flavour.hexadecimal else expression


def _wanted(definition: Definition) -> set[str]:
    """The fields whose raw values others need."""
    found = {"manufacturerCode"} if any(field.kind == "VARIABLE" for field in definition.fields) else set()
    for field in definition.fields:
        if field.kind == "DYNAMIC_FIELD_VALUE" and (key := announced_by(definition, field)[0]):
            found.add(key.id)
    return found


def announced_by(definition: Definition, value: Field) -> tuple[Field | None, Field | None]:
    """The key that announces a value, and the field that tells its length."""
    before = definition.fields[: definition.fields.index(value)]
    key = next((field for field in before if field.kind == "DYNAMIC_FIELD_KEY"), None)
    return key, next((field for field in before if field.kind == "DYNAMIC_FIELD_LENGTH"), None)


def _number(kind: Ranged, raw: str) -> str:
    """`codec.number_value`, quicker: without a bound that nothing is below, and an integer divided by an integer."""
    (lowest, highest), most = kind.range, (1 << kind.bits - kind.signed) - 1
    once, again = (raw, raw) if raw.isidentifier() else (f"(t := {raw})", "t")
    if kind.inverse is None or kind.offset or max(most, kind.inverse) > EXACT:
        return codec.number_value(kind, raw)
    below = f"{lowest} <= " if lowest > (-most - 1 if kind.signed else 0) else ""
    return f"{again} / {kind.inverse} if {below}{once} <= {highest} else None"


def _tuple(names: Iterable[str]) -> str:
    return f"({''.join(f'{name}, ' for name in names)})"


def _inside(lines: Iterable[str]) -> list[str]:
    return [f" {line}" for line in lines]


def _format(words: codec.Run, size: int = 0) -> str:
    """The struct format up to the last word that is read, or of `size` bytes."""
    parts, at = ["<"], 0
    for word in words.words:
        parts += [f"{word.start - at}x"] if word.start > at else []
        parts += [letter for letter, _ in word.pieces]
        at = word.end
    return "".join([*parts, f"{size - at}x"] if size > at else parts)


# Fields of variable size ---------------------------------------------------------------------------


def tail_reader(definition: Definition, field: Field, flavour: Flavour) -> Any:
    """(data, at, context...) -> (value, end)."""
    if field.length:
        unit = next(one for one in definition.fields if one.id == field.length)
        return partial(_counted, flavour.hexadecimal, "bits" in unit.title.lower())
    match field.kind:
        case "STRING_LAU":
            return lau
        case "STRING_LZ":
            return lz
        case "DYNAMIC_FIELD_VALUE":
            key, length = announced_by(definition, field)
            return Keyed(key, length, flavour).read
    return partial(_counted, flavour.hexadecimal, False)


def _counted(hexadecimal: bool, bits: bool, data: bytes, at: int, length: int | None) -> tuple[Any, int]:
    """Bytes whose number, in bits or bytes, an earlier field tells; without it all that is left."""
    size = len(data) - at if length is None else -(-length // 8) if bits else length
    found = data[at : at + size] or None
    return _hexadecimal(found) if hexadecimal else found, at + size


class Keyed(dict[tuple[int | None, int | None], tuple[int, Any]]):
    """Reads values whose kind their key tells, and whose size a length or else the kind.

    Key and length -> size, and how the value is read, None for bytes; made as they are met. A length that does not
    even count what stands before the value (`overhead`) is none: the value is all that is left.
    """

    def __init__(self, key: Field | None, length: Field | None, flavour: Flavour) -> None:
        self._fields = keys(key.lookup) if key else {}
        self._overhead = length.overhead if length else 0
        self._flavour = flavour

    def told(self, key: int | None) -> Field | None:
        """What a key announces; None for a key that is not known, and without one."""
        return None if key is None else self._fields.get(key)

    def size(self, key: int | None, length: int | None) -> int | None:
        """How many bytes a value has; None for all that are left."""
        if length is not None:
            return length - self._overhead if length >= self._overhead else None
        told = self.told(key)
        return None if told is None else -(-(told.bits or 0) // 8)

    def __missing__(self, kind: tuple[int | None, int | None]) -> tuple[int, Any]:
        told, size = self.told(kind[0]), self.size(*kind)
        if told is None or size is None:
            return EVERYTHING if size is None else size, None
        field = sized(told, size)
        made = self[kind] = size, None if field is None else value_of(field, self._flavour)
        return made

    # Once a value, of which a message has many.
    def read(self, data: bytes, at: int, key: int | None, length: int | None) -> tuple[Any, int]:
        """The value and where it ends; bytes where its kind is not known."""
        size, value = self[key, length]
        if value is not None and at + size <= len(data):
            return value(data, at), at + size
        return _octets(self._flavour.hexadecimal, data, at, size)


def _octets(hexadecimal: bool, data: bytes, at: int, size: int) -> tuple[Any, int]:
    """Up to `size` bytes, None for none, and where they end."""
    found = data[at : at + size]
    return (_hexadecimal(found) if hexadecimal else found) if found else None, at + len(found)


def sized(field: Field, size: int) -> Field | None:
    """A field that is sent in `size` bytes: numbers are sent in fewer or more than they are listed with."""
    if 8 * size == field.bits:
        return field
    number = field.kind in ("NUMBER", "DURATION", "TIME") and 1 <= size <= 8
    return msgspec.structs.replace(field, bits=8 * size) if number else None


@cache
def reader(field: Field, flavour: Flavour) -> Any:
    """(data, at) -> (value, end) of a field on its own."""
    if isinstance(single(field), Tail):
        return tail_reader(_alone(field), _alone(field).fields[0], flavour)
    read, size = value_of(field, flavour), -(-(field.bits or 0) // 8)
    return lambda data, at: (read(data, at), at + size)


@cache
def value_of(field: Field, flavour: Flavour) -> Callable[[bytes, int], Any]:
    """(data, at) -> value of a field on its own."""
    if isinstance(single(field), Tail):
        read = reader(field, flavour)
        return lambda data, at: read(data, at)[0]
    return _Source(_alone(field), flavour).value()


def _alone(field: Field) -> Definition:
    return Definition(
        0, "value", "", "", (msgspec.structs.replace(field, id="value", match=None, by="", length="", when=""),)
    )


# PGN 126208 ----------------------------------------------------------------------------------------


def proprietary(pgn: int | None) -> bool:
    """Whether a PGN means something else for every manufacturer."""
    return pgn is not None and (pgn in (0xEF00, 0x1EF00) or 0xFF00 <= pgn <= 0xFFFF or 0x1FF00 <= pgn <= 0x1FFFF)


def parameters(
    cls: Any, flavour: Flavour, data: bytes, at: int, count: int, pgn: int | None, owner: int | None
) -> tuple[list[Any] | None, int]:
    """Fields of another message by their numbers; of one that could be several things, all bytes that are left."""
    targets = [target for target in candidates(pgn) if not target.fallback] if pgn is not None else []
    if owner is not None and owner <= 2044:
        targets = [target for target in targets if target.fields[0].match in (None, owner)]
    owned = _owner_fields(pgn)
    found: list[Any] = []
    while len(found) < count and at < len(data):
        index = data[at]
        field = owned.get(index) or _agreed(targets, index)
        value, end = _parameter(field, flavour, data, at + 1)
        targets = [target for target in targets if _fits(target, index, data[at + 1 : end])]
        found.append(cls(index, value) if index <= 252 else cls(None, value))
        at = end
    return found or None, at


def _owner_fields(pgn: int | None) -> dict[int, Field]:
    """The fields that all messages of a proprietary PGN begin with: whose it is."""
    fallback = next((target for target in candidates(pgn) if target.fallback), None) if pgn is not None else None
    return dict(enumerate(fallback.fields[:3], 1)) if fallback else {}


def _agreed(targets: list[Definition], index: int) -> Field | None:
    """The field with this number, if all that the target can be agree on its layout."""
    fields = [target.fields[index - 1] if 1 <= index <= len(target.fields) else None for target in targets]
    first = fields[0] if fields else None
    return first if first is not None and all(field is not None and _alike(field, first) for field in fields) else None


def _alike(one: Field, other: Field) -> bool:
    layouts = [
        (field.kind, field.bits, field.signed, field.resolution, field.offset, field.lookup) for field in (one, other)
    ]
    return layouts[0] == layouts[1]


def _fits(target: Definition, index: int, value: bytes) -> bool:
    field = target.fields[index - 1] if 1 <= index <= len(target.fields) else None
    return field is None or field.match is None or int.from_bytes(value, "little") == field.match


def _parameter(field: Field | None, flavour: Flavour, data: bytes, at: int) -> tuple[Any, int]:
    if field is None or field.kind in ("DYNAMIC_FIELD_VALUE", "VARIABLE") or field.length:
        return _counted(flavour.hexadecimal, False, data, at, None)
    if field.silent:
        field = Field(id=field.id, kind="BINARY", bits=field.bits)
    value, end = reader(field, flavour)(data, at)
    return value, end


def packed(cls: Any, table: Any, data: bytes, at: int, count: int) -> tuple[list[Any] | None, int]:
    """Lookups of four bits, two in a byte."""
    nibbles = [nibble for byte in data[at : at + (count + 1) // 2] for nibble in (byte & 15, byte >> 4)]
    return [cls(table[nibble]) for nibble in nibbles[:count]] or None, at + (count + 1) // 2
