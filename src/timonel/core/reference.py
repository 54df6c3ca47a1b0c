"""The protocol page: a declaration as Markdown, so that no layout is written down twice."""

from enum import IntEnum
from inspect import cleandoc
from typing import Any

from timonel.core.fields import (
    Ascii,
    Binary,
    Bits,
    Field,
    Flags,
    Float32,
    Lookup,
    Match,
    Number,
    Packed,
    Repeat,
    Reserved,
    Spare,
    StringLau,
)
from timonel.core.message import Message, Slot

HEAD = "| no. | field | bit | bits | values |\n|---|---|---|---|---|"
MOST_NAMES = 20
WORDS: dict[type[Field], str] = {
    Bits: "a bit pattern",
    Reserved: "ones",
    Spare: "zeros",
    Ascii: "text",
    Binary: "bytes",
    StringLau: "text, ASCII or UTF-16",
    Float32: "a number in IEEE 754",
}


def section(message: type[Message]) -> str:
    """A message: its name, its docstring and a table of its fields."""
    text = cleandoc(message.__doc__ or "")
    return f"### {message.__name__}\n\n{text}\n\n{HEAD}\n" + "\n".join(rows(message)) + "\n"


def rows(message: type[Message]) -> list[str]:
    """A row of the table for each field, numbered as PGN 126208 counts them; a group's fields follow the group."""
    result, number = [], 1
    for slot in message.layout:
        if isinstance(slot.field, Repeat):
            group: tuple[Slot, ...] = slot.field.group.layout
            result.append(_row("", slot))
            result += [_row(number + place, part, "- ") for place, part in enumerate(group)]
            number += len(group)
        else:
            result.append(_row(number, slot))
            number += 1
    return result


def _row(number: int | str, slot: Slot, mark: str = "") -> str:
    offset = "" if mark or slot.offset is None else slot.offset
    length = "" if slot.length is None else slot.length
    return f"| {number} | {mark}{slot.name} | {offset} | {length} | {_values(slot)} |"


def _values(slot: Slot) -> str:
    match slot.field:
        case Number() as field:
            return _number(field)
        case Lookup() as field:
            return _names([f"{code.value} {_words(code)}" for code in field.codes])
        case Flags() as field:
            return _names([f"bit {flag.bit_length() - 1} {_words(flag)}" for flag in field.flags])
        case Match() if isinstance(slot.default, IntEnum):
            return f"always {slot.default:d} ({_words(slot.default)})"
        case Match():
            return f"always {slot.default:d}"
        case Repeat() as field:
            return f"`{field.group.__name__}`, {_counted(field.count)}"
        case Packed() as field:
            return f"of {field.element.bits} bits each, {_counted(field.count)}"
    return WORDS.get(type(slot.field), f"`{type(slot.field).__name__}`")


def _number(field: Number) -> str:
    lowest, highest = (f"{bound:.10g}" for bound in field.span)
    scale = "" if field.resolution == 1 else f", in steps of {field.resolution:g}"
    return f"{lowest} to {highest} {field.unit}".rstrip() + scale


def _names(names: list[str]) -> str:
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    return ", ".join(names[:MOST_NAMES]) + more


def _words(code: Any) -> str:
    return str(code.name).replace("_", " ").lower()


def _counted(counter: str) -> str:
    return f"as many as `{counter}` says" if counter else "up to the end"
