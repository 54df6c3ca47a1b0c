"""The page of a rover's frames, from their declarations."""

from inspect import cleandoc

from timonel.core.fields import Code
from timonel.vehicles.rover.calibration import DOCUMENTED, PHYSICAL, Calibration
from timonel.vehicles.rover.codec import Codec, Part
from timonel.vehicles.rover.conversions import Linear
from timonel.vehicles.rover.protocol import Protocol

LETTERS = {"B": "u8", "b": "i8", "H": "u16", "h": "i16", "I": "u32", "i": "i32", "f": "f32"}
OVERVIEW = "| id | frame | from | to | bytes | Hz |\n|---|---|---|---|---|---|"
CONSTANTS = "| constant | documented | physical |\n|---|---|---|"
HEAD = "| field | byte | type | unit | value | sent |\n|---|---|---|---|---|---|"


def page(protocol: Protocol) -> str:
    """All frames of a protocol in Markdown: an overview, then a section each."""
    codecs = [protocol.codec(number) for number in sorted(protocol.declarations)]
    return "\n".join([OVERVIEW, *map(_line, codecs), "", *map(section, codecs)])


def constants() -> str:
    """The constants of both built-in calibrations."""
    rows = [
        f"| {name} | {_number(DOCUMENTED, name)} | {_number(PHYSICAL, name)} |"
        for name in Calibration.__struct_fields__
    ]
    return "\n".join(["## Constants of `[calibration]`\n", CONSTANTS, *rows]) + "\n"


def _number(calibration: Calibration, name: str) -> str:
    value = getattr(calibration, name)
    return ", ".join(f"{one:.6g}" for one in (value if isinstance(value, tuple) else (value,)))


def _line(codec: Codec) -> str:
    frame = codec.frame
    parties = f"{frame.SENDER} | {frame.TO.value}"
    return f"| {frame.FRAME} | {frame.__name__} | {parties} | {frame.size} | {frame.RATE:g} |"


def section(codec: Codec) -> str:
    """A frame: its name, its docstring and a table of its fields, derived signals behind them."""
    frame, rows, at = codec.frame, [HEAD], 0
    for part in codec.parts:
        rows.append(f"| {part.name} | {at} | {LETTERS[part.signal.kind]} | {part.signal.unit} | {_value(part)} |")
        at += part.signal.bits // 8
    for name, derived in frame.DERIVED.items():
        rows.append(f"| {name} | | derived | {derived.unit} | {_sentence(derived.formula, derived.about)} | |")
    text = "\n\n".join(filter(None, [f"### {frame.FRAME} {frame.__name__}", cleandoc(frame.__doc__ or "")]))
    return f"{text}\n\n" + "\n".join(rows) + "\n"


def _value(part: Part) -> str:
    """What raw values mean, and which of them are sent."""
    if part.signal.codes:
        return f"{', '.join(map(_word, part.signal.codes))} |"
    special = [f"{raw}: {'None' if value is None else f'{value:g}'}" for raw, value in part.signal.special]
    return f"{_sentence(part.formula.text(), *special, part.signal.about)} | {_sent(part)}"


def _sent(part: Part) -> str:
    """The limits, in the unit of the value."""
    if part.signal.limits is None or not isinstance(part.formula, Linear):
        return ""
    lowest, highest = sorted(raw * part.formula.factor + part.formula.offset for raw in part.signal.limits)
    return f"{lowest:.6g} to {highest:.6g}"


def _sentence(*parts: str) -> str:
    return "; ".join(filter(None, parts))


def _word(code: Code) -> str:
    return f"{code.value} {code.name.replace('_', ' ').lower()}"
