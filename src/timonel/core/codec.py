"""Generates `decode`, `read` and `encode` of a message from its layout.

What runs once a frame is written for speed: one precompiled `struct.Struct` takes all fixed fields of a run
at once, odd bits are cut from the smallest words that cover them, reserved bytes are skipped, lookups are one
subscript. `source(message)` shows the Python that is made.
"""

import math
import struct
from collections.abc import Callable
from functools import cache
from itertools import groupby
from typing import TYPE_CHECKING, Any

import msgspec

from timonel.core.fields import (
    Ascii,
    Binary,
    Bits,
    Fixed,
    Flags,
    Lookup,
    Match,
    Number,
    Reserved,
    Spare,
    Variable,
)
from timonel.errors import EncodeError

if TYPE_CHECKING:
    from timonel.core.message import Message, Slot

CODES = ((8, "Q"), (4, "I"), (2, "H"), (1, "B"))
MISTAKES = (TypeError, ValueError, OverflowError, AttributeError, struct.error)


class Table(dict[int, Any]):
    """Raw value -> member, filled as values are met."""

    def __init__(self, meaning: Callable[[int], Any]) -> None:
        self.meaning = meaning

    def __missing__(self, raw: int) -> Any:
        member = self[raw] = self.meaning(raw)
        return member


@cache
def table(field: Lookup | Flags) -> list[Any] | Table:
    """What each raw value of a field means: all at once where they are few, as they come where they are many."""
    meaning = field.meaning if isinstance(field, Lookup) else field.flags
    return [meaning(raw) for raw in range(field.ones + 1)] if field.bits <= 8 else Table(meaning)


class Word(msgspec.Struct):
    """The bytes that cover one field, or several that share bytes."""

    start: int
    end: int
    slots: "list[Slot]"

    @property
    def pieces(self) -> list[tuple[str, int]]:
        """Format characters and the shift of each."""
        field = self.slots[0].field
        if isinstance(field, Ascii | Binary):
            return [(f"{field.size}s", 0)]
        pieces, size, shift = [], self.end - self.start, 0
        for width, letter in CODES:
            while size >= width:
                pieces.append((letter, shift))
                size, shift = size - width, shift + 8 * width
        return [(pieces[0][0].lower(), 0)] if self.signed and len(pieces) == 1 else pieces

    @property
    def signed(self) -> bool:
        field = self.slots[0].field
        return isinstance(field, Number) and field.signed and field.bits == 8 * (self.end - self.start)


class Run(msgspec.Struct):
    """Fields of fixed size that follow each other, cut into words."""

    slots: "list[Slot]"
    size: int
    words: list[Word]

    @property
    def template(self) -> bytes:
        """The bytes of the run with every constant in place and every value zero."""
        bits, at = 0, 0
        for slot in self.slots:
            assert slot.length is not None
            bits |= _constant(slot) << at
            at += slot.length
        return bits.to_bytes(self.size, "little")

    def layout(self, gap: str) -> str:
        """The struct format; `gap` stands for bytes that hold no value."""
        parts, at = ["<"], 0
        for word in self.words:
            parts += [f"{word.start - at}{gap}"] if word.start > at else []
            parts += [letter for letter, _ in word.pieces]
            at = word.end
        return "".join(parts + ([f"{self.size - at}{gap}"] if self.size > at else []))


def _constant(slot: "Slot") -> int:
    match slot.field:
        case Reserved() as field:
            return field.ones
        case Match():
            return int(slot.default)
    return 0


def run(slots: "list[Slot]") -> Run:
    """Cut a run of fixed fields into words; two fields that share a byte share a word."""
    words: list[Word] = []
    bit = 0
    for slot in slots:
        assert slot.length is not None
        start, end = bit // 8, -(-(bit + slot.length) // 8)
        if not isinstance(slot.field, Reserved | Spare | Match):
            if words and start < words[-1].end:
                words[-1].slots.append(slot)
                words[-1].end = max(words[-1].end, end)
            else:
                words.append(Word(start, end, [slot]))
        bit += slot.length
    return Run(slots, -(-bit // 8), words)


def parts(message: "type[Message]") -> "list[Run | Slot]":
    """The layout as runs of fixed fields and the variable fields between them."""
    result: list[Run | Slot] = []
    for variable, group in groupby(message.layout, lambda slot: isinstance(slot.field, Variable)):
        slots = list(group)
        result += slots if variable else [run(slots)]
    return result


class Blank(msgspec.Struct, frozen=True):
    """What a run is filled with that ends early: `bits` says not available in every field, `ends` are theirs."""

    size: int
    bits: int
    ends: tuple[int, ...]

    def kept(self, size: int) -> int:
        """How many bits of a payload of `size` bytes are whole fields."""
        return max(end for end in self.ends if end <= 8 * size)


def blank(run: Run) -> Blank:
    bits, at, ends = 0, 0, {0}
    for slot in run.slots:
        assert slot.length is not None
        bits |= _absent(slot) << at
        ends.update(range(at, at + slot.length, 8) if isinstance(slot.field, Ascii | Binary) else ())
        at += slot.length
        ends.add(at)
    return Blank(run.size, bits, tuple(sorted(ends)))


def _absent(slot: "Slot") -> int:
    match slot.field:
        case Number() as field:
            return field.not_available
        case Spare() | Flags():
            return 0
        case Match():
            return int(slot.default)
    assert slot.length is not None
    return (1 << slot.length) - 1


def fit(data: bytes, blank: Blank) -> bytes:
    """Cut what is too long (a newer version of the message), fill what is too short with "not available"."""
    have = bytes(data[: blank.size])
    if len(have) == blank.size:
        return have
    mask = (1 << blank.kept(len(have))) - 1
    return (int.from_bytes(have, "little") & mask | blank.bits & ~mask).to_bytes(blank.size, "little")


def text(raw: bytes) -> str | None:
    """Fixed text up to its padding; None if nothing is left."""
    for pad in (b"\xff", b"\0", b"@"):
        raw = raw.split(pad, 1)[0]
    return raw.decode("ascii", "ignore").rstrip() or None


def fill(value: str | None, size: int) -> bytes:
    raw = (value or "").encode("ascii")
    if len(raw) > size:
        raise ValueError
    return raw.ljust(size, b"\xff")


@cache
def install(message: "type[Message]") -> None:
    """Put the generated functions into the class, once."""
    scope = _scope(message)
    exec(compile(source(message), f"<codec of {message.__name__}>", "exec"), scope)
    for name in ("decode", "read"):
        setattr(message, name, staticmethod(scope[name]))
    message.encode = scope["encode"]  # type: ignore[method-assign]


def _scope(message: "type[Message]") -> dict[str, Any]:
    scope: dict[str, Any] = {
        "cls": message, "error": struct.error, "fit": fit, "text": text, "fill": fill,
        "refusal": refusal, "MISTAKES": MISTAKES,
    }  # fmt: skip
    for number, part in enumerate(parts(message)):
        if isinstance(part, Run):
            scope[f"unpack_{number}"] = struct.Struct(part.layout("x")).unpack
            scope[f"blank_{number}"] = blank(part)
            scope[f"pack_{number}"] = struct.Struct(part.layout("s")).pack
    for slot in message.layout:
        match slot.field:
            case Lookup() | Flags() as field:
                scope[f"table_{slot.name}"] = table(field)
            case Variable() as variable:
                scope[f"field_{slot.name}"] = variable
            case Match():
                scope[f"match_{slot.name}"] = slot.default
    return scope


def source(message: "type[Message]") -> str:
    """The Python of the three functions."""
    cut = parts(message)
    lines = _read(message, cut) + _encode(message, cut)
    if len(cut) == 1 and isinstance(cut[0], Run):
        lines += _decode(message, cut[0])
    else:
        lines += ["def decode(data):", " return read(bytes(data), 0)[0]"]
    return "\n".join(lines) + "\n"


def _made(message: "type[Message]", values: dict[str, str]) -> str:
    """The call that makes the message; by position, which is three times as fast as by name."""
    constants = {slot.name: f"match_{slot.name}" for slot in message.layout if isinstance(slot.field, Match)}
    return f"cls({', '.join((constants | values).get(name, 'None') for name in message.__struct_fields__)})"


def _decode(message: "type[Message]", run: Run) -> list[str]:
    names = word_names(run)
    return [
        "def decode(data):",
        " try:",
        f"  {names} = unpack_0(data)",
        " except error:",
        f"  {names} = unpack_0(fit(data, blank_0))",
        *join_words(run),
        f" return {_made(message, dict(_values(run)))}",
    ]


def _read(message: "type[Message]", cut: "list[Run | Slot]") -> list[str]:
    lines, names = ["def read(data, at):"], []
    for number, part in enumerate(cut):
        if isinstance(part, Run):
            lines.append(f" {word_names(part)} = unpack_{number}(fit(data[at : at + {part.size}], blank_{number}))")
            lines += [f" at += {part.size}", *join_words(part)]
            values = _values(part)
            lines += [f" v_{name} = {value}" for name, value in values]
            names += [name for name, _ in values]
        else:
            assert isinstance(part.field, Variable)
            context = "".join(f", v_{name}" for name in part.field.context)
            lines.append(f" v_{part.name}, at = field_{part.name}.read(data, at{context})")
            names.append(part.name)
    return [*lines, f" return {_made(message, {name: f'v_{name}' for name in names})}, at"]


def word_names(run: Run) -> str:
    """The names of the words of a run, as `unpack` gives them."""
    return "(" + "".join(f"w{word.start}_{shift}, " for word in run.words for _, shift in word.pieces) + ")"


def join_words(run: Run) -> list[str]:
    """Join words that the struct module knows no letter for."""
    return [
        f" w{word.start}_0 = " + " | ".join(f"w{word.start}_{shift} << {shift}" for _, shift in word.pieces)
        for word in run.words
        if len(word.pieces) > 1
    ]


def _values(run: Run) -> list[tuple[str, str]]:
    """Field names and the expressions that make their values of the words."""
    values, bit, word_of = [], 0, {slot.name: word for word in run.words for slot in word.slots}
    for slot in run.slots:
        assert slot.length is not None
        if word := word_of.get(slot.name):
            values.append((slot.name, _value(slot, raw_value(slot, word, bit - 8 * word.start))))
        bit += slot.length
    return values


def raw_value(slot: "Slot", word: Word, shift: int) -> str:
    """The expression that cuts a field out of its word; `shift` is where it begins in it."""
    name, field = f"w{word.start}_0", slot.field
    if isinstance(field, Ascii | Binary) or (word.signed and len(word.pieces) == 1):
        return name
    assert isinstance(field, Fixed)
    shifted = f"{name} >> {shift}" if shift else name
    raw = shifted if shift + field.bits == 8 * (word.end - word.start) else f"{shifted} & {field.ones}"
    if isinstance(field, Number) and field.signed:
        sign = 1 << field.bits - 1
        return f"({raw} ^ {sign}) - {sign}"
    return raw


def _value(slot: "Slot", raw: str) -> str:
    match slot.field:
        case Lookup() | Flags():
            return f"table_{slot.name}[{raw}]"
        case Number() as field:
            return number_value(field, raw)
        case Ascii():
            return f"text({raw})"
    return raw


def number_value(field: Number, raw: str) -> str:
    """The expression that makes a number of the raw value `raw`; None where that is not valid."""
    lowest, highest = field.range
    once, again = (raw, raw) if raw.isidentifier() else (f"(t := {raw})", "t")
    guard = f"{lowest} <= {once} <= {highest}" if lowest or field.signed else f"{once} <= {highest}"
    if field.inverse is not None:
        scaled = f"{again} / {float(field.inverse)!r}"
    else:
        scaled = again if field.resolution == 1 else f"{again} * {field.resolution!r}"
    return f"{scaled}{f' + {field.offset!r}' if field.offset else ''} if {guard} else None"


def _encode(message: "type[Message]", cut: "list[Run | Slot]") -> list[str]:
    counted = {slot.field.counter: slot.name for slot in message.layout if isinstance(slot.field, Variable)}
    lines, results = ["def encode(self):", " try:"], []
    for number, part in enumerate(cut):
        if isinstance(part, Run):
            for slot in part.slots:
                lines += [f"  {line}" for line in _raw_of(slot, counted.get(slot.name))]
            results.append(f"pack_{number}({', '.join(_packed(part))})")
        else:
            assert isinstance(part.field, Variable)
            context = "".join(f", self.{name}" for name in part.field.context)
            results.append(f"field_{part.name}.write(self.{part.name}{context})")
    lines.append(f"  return {' + '.join(results) or repr(b'')}")
    return [*lines, " except MISTAKES:", "  raise refusal(self) from None"]


def _raw_of(slot: "Slot", counted: str | None) -> list[str]:
    """Lines that set `r_name` to the raw value of a field, or leave by way of `refusal`."""
    value, raw = f"self.{slot.name}", f"r_{slot.name}"
    refuse = " raise refusal(self)"
    match slot.field:
        case Number() as field:
            lowest, highest = field.range
            given = "v" if not counted else f"len(self.{counted}) if v is None else v"
            scaled = given if not field.offset else f"(v - {field.offset!r})"
            if field.inverse is not None:
                scaled = f"round({scaled} * {float(field.inverse)!r})"
            elif field.resolution != 1 or not field.integral:
                scaled = f"round({scaled} / {field.resolution!r})"
            check = [f"if not {lowest} <= {raw} <= {highest}:", refuse]
            if counted:
                return [f"v = {value}", f"{raw} = {scaled}", *check]
            return [
                f"v = {value}",
                "if v is None:",
                f" {raw} = {field.not_available}",
                "else:",
                f" {raw} = {scaled}",
                *(f" {line}" for line in check),
            ]
        case Lookup() as field:
            absent = [f"if {raw} is None:", f" {raw} = {field.ones}"] if field.highest < field.ones else []
            bounds = f"{'el' if absent else ''}if not 0 <= {raw} <= {field.highest}:"
            return [f"{raw} = {value}", *absent, bounds, refuse]
        case Flags() | Bits() as field:
            return [f"{raw} = {value}", f"if not 0 <= {raw} <= {field.ones}:", refuse]
        case Match():
            return [f"if {value} != match_{slot.name}:", refuse]
        case Ascii() as ascii_field:
            return [f"{raw} = fill({value}, {ascii_field.size})"]
        case Binary() as binary:
            return [f"{raw} = {value}", f"if len({raw}) != {binary.size}:", refuse]
    return []


def _packed(run: Run) -> list[str]:
    """The arguments of `pack`: constant bytes between words, and the words."""
    template, arguments, at = run.template, [], 0
    offsets, bit = {}, 0
    for slot in run.slots:
        assert slot.length is not None
        offsets[slot.name] = bit
        bit += slot.length
    for word in run.words:
        arguments += [repr(template[at : word.start])] if word.start > at else []
        arguments += _word(word, offsets, int.from_bytes(template[word.start : word.end], "little"))
        at = word.end
    return arguments + ([repr(template[at:])] if run.size > at else [])


def _word(word: Word, offsets: dict[str, int], constant: int) -> list[str]:
    if len(word.slots) == 1 and len(word.pieces) == 1 and (word.signed or _fills(word)):
        return [f"r_{word.slots[0].name}"]
    terms = [str(constant)] if constant else []
    for slot in word.slots:
        field, shift = slot.field, offsets[slot.name] - 8 * word.start
        assert isinstance(field, Fixed)
        bits = f"(r_{slot.name} & {field.ones})" if isinstance(field, Number) and field.signed else f"r_{slot.name}"
        terms.append(f"{bits} << {shift}" if shift else bits)
    whole = " | ".join(terms)
    if len(word.pieces) == 1:
        return [whole]
    masks = {letter: (1 << 8 * size) - 1 for size, letter in CODES}
    return [f"({whole}) >> {shift} & {masks[letter]}" for letter, shift in word.pieces]


def _fills(word: Word) -> bool:
    return word.slots[0].length == 8 * (word.end - word.start)


def refusal(message: "Message") -> EncodeError:
    """Why a message cannot be encoded, in the words of its first bad field."""
    for slot in type(message).layout:
        value = getattr(message, slot.name)
        if fault := _fault(slot, value):
            return EncodeError(f"{slot.name}: {fault}")
    return EncodeError(f"{type(message).__name__}: more in a list than can be counted")


def _fault(slot: "Slot", value: Any) -> str | None:
    match slot.field:
        case Number() as field:
            return None if value is None else _number_fault(field, value)
        case Lookup() as field:
            absent = value is None and field.highest < field.ones
            return None if absent else _code_fault(field.highest, value)
        case Flags() | Bits() as field:
            return _code_fault(field.ones, value)
        case Match():
            return None if value == slot.default else f"{value!r} is not {slot.default!r}"
        case Ascii() as field:
            fits = isinstance(value, str | None) and len(value or "") <= field.size and (value or "").isascii()
            return None if fits else f"{value!r} is not ASCII text of at most {field.size} characters"
        case Binary() as field:
            fits = isinstance(value, bytes) and len(value) == field.size
            return None if fits else f"{value!r} is not {field.size} bytes"
        case Variable():
            return None if isinstance(value, str | tuple | None) else f"{value!r} is neither text nor a tuple"
    return None


def _number_fault(field: Number, value: Any) -> str | None:
    if not isinstance(value, int | float) or math.isnan(value):
        return f"{value!r} is not a number"
    if field.integral and field.resolution == 1 and not isinstance(value, int):
        return f"{value!r} is not a whole number"
    lowest, highest = field.range
    if lowest <= (value - field.offset) / field.resolution <= highest:
        return None
    span = "..".join(f"{bound:.10g}" for bound in field.span)
    return f"{value} {field.unit + ' ' if field.unit else ''}is outside {span}"


def _code_fault(highest: int, value: Any) -> str | None:
    if not isinstance(value, int):
        return f"{value!r} is not a whole number"
    return None if 0 <= value <= highest else f"{value:d} is outside 0..{highest}"
