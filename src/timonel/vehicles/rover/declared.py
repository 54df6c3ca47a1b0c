"""An owner's own frames: for the manipulator, the laboratory and what else is on board.

```toml
[[frame]]
id = 160
name = "ArmJoints"
to = "operator"
fields = [{ name = "base", type = "i16", scale = 1e-4, unit = "rad", special = { "0x7FFF" = "none" } }]
```
A Python file declares the same as classes. Either way they are frames like the built-in ones. `docs/own_frames.md`
describes every key.
"""

import keyword
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator
from enum import EnumType
from typing import Annotated, Any, Literal

from msgspec import Meta

from timonel.core.fields import Code
from timonel.core.mistakes import Mistakes, convert, did_you_mean, syntax_error, written
from timonel.vehicles.rover.conversions import Linear, Signal, signal
from timonel.vehicles.rover.declaration import FrameMeta, Party, RoverFrame
from timonel.vehicles.rover.frames import FRAMES
from timonel.vehicles.rover.segments import LONGEST, SINGLE

Table = dict[str, Any]
Wrong = Callable[[str, str], None]

FREE = {"the platform's own": range(121, 160), "the manipulator": range(160, 200), "the laboratory": range(200, 240)}
HIGHEST_RATE = 50  # Hz, of any frame on the bus
CLASS_NAME = re.compile(r"[A-Z][A-Za-z0-9]{0,31}")  # as long as a DBC name may be
FIELD_NAME = re.compile(r"[a-z][a-z0-9_]{0,31}")
FRAME_KEYS: Table = {
    "id": int,
    "name": str,
    "to": Literal["rover", "motors", "operator"],
    "sender": str,
    "rate": Annotated[float, Meta(gt=0, le=HIGHEST_RATE)],
    "segmented": bool,
    "doc": str,
}
FIELD_KEYS: Table = {
    "name": str,
    "type": Literal["u8", "i8", "u16", "i16", "u32", "i32", "f32"],
    "scale": float,
    "offset": float,
    "unit": str,
    "doc": str,
    "min": float,
    "max": float,
}
TABLES = ("special", "labels")


def parse(text: str, file: str) -> tuple[type[RoverFrame], ...]:
    """The frames that a TOML text called `file` declares; raises ConfigError with one line for each mistake."""
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as fault:
        raise syntax_error(file, text, fault) from fault
    mistakes = Mistakes(file, text)
    for name in document.keys() - {"frame"}:
        mistakes.add(name, f"unknown table{did_you_mean(name, ['frame'])}")
    tables = _list(document.get("frame"), "frame", mistakes.add)
    frames = [_frame(f"frame[{number}]", table, mistakes.add) for number, table in enumerate(tables, 1)]
    check(frames, mistakes.add, "frame[{}].{}")
    if mistakes:
        raise mistakes.error()
    return tuple(frames)


def check(frames: Iterable[type[RoverFrame]], wrong: Wrong, place: str = "{1}") -> None:
    """Tell `wrong` what cannot be: of each frame by itself, and of all of them together.

    `place` makes a key of a frame's number from 1 and a key's name.
    """
    taken = {frame.FRAME: frame.__name__ for frame in FRAMES}
    for number, frame in enumerate(frames, 1):
        for key, text in _faults(frame, taken):
            wrong(place.format(number, key), text)
        taken.setdefault(frame.FRAME, frame.__name__)


def _faults(frame: type[RoverFrame], taken: dict[int, str]) -> Iterator[tuple[str, str]]:
    if first := taken.get(frame.FRAME):
        yield "id", f"{frame.FRAME} is {first} already; take another"
    elif not any(frame.FRAME in numbers for numbers in FREE.values()):
        ranges = ", ".join(f"{numbers.start}..{numbers.stop - 1} ({whose})" for whose, numbers in FREE.items())
        yield "id", f"{frame.FRAME} is not free; free are {ranges}"
    if frame.__name__ in taken.values():
        yield "name", f'"{frame.__name__}" is another frame already'
    if not frame.size:
        yield "fields", "missing; a frame needs at least one"
    elif frame.size > LONGEST:
        yield "fields", f"{frame.size} bytes are too many; at most {LONGEST}, in two segments"
    elif frame.size > SINGLE and not frame.SEGMENTED:
        yield "segmented", f"{frame.size} bytes do not fit a CAN frame of {SINGLE}; say segmented = true"
    if not 0 < frame.RATE <= HIGHEST_RATE:
        yield "rate", f"{frame.RATE:g} should be a number above 0, at most {HIGHEST_RATE}"


def _frame(place: str, table: Table, wrong: Wrong) -> type[RoverFrame]:
    """The frame with everything that is right about it."""
    values = _values(place, table, FRAME_KEYS, wrong, others=("fields",))
    for key in ("id", "name", "to"):
        if key not in table:
            wrong(f"{place}.{key}", "missing")
    name = _name(values.get("name", "Frame"), CLASS_NAME, "a word like ArmJoints", f"{place}.name", wrong)
    tables = _list(table.get("fields"), f"{place}.fields", wrong)
    fields: dict[str, Signal] = {}
    for number, field in enumerate(tables, 1):
        key, declared = _field(f"{place}.fields[{number}]", field, wrong)
        if key in fields:
            wrong(f"{place}.fields[{number}].name", f'"{key}" is another field already')
        fields[key] = declared
    return _made(name, fields, values)


def _made(name: str, fields: dict[str, Signal], values: Table) -> type[RoverFrame]:
    hints = {key: Annotated[float | None, field] for key, field in fields.items()}
    keywords = {key: values[key] for key in ("sender", "rate", "segmented") if key in values}
    frame = FrameMeta(
        name,
        (RoverFrame,),
        {"__annotations__": hints, "__doc__": values.get("doc", ""), "__module__": __name__},
        frame=values.get("id", 0),
        to=Party(values.get("to", "operator")),
        **keywords,
    )
    assert issubclass(frame, RoverFrame)
    return frame


def _field(place: str, table: Table, wrong: Wrong) -> tuple[str, Signal]:
    values = _values(place, table, FIELD_KEYS, wrong, others=TABLES)
    for key in ("name", "type"):
        if key not in table:
            wrong(f"{place}.{key}", "missing")
    name = _name(values.get("name", "field"), FIELD_NAME, "a word like base_angle", f"{place}.name", wrong)
    formula = Linear(values.get("scale", 1), values.get("offset", 0))
    if formula.factor == 0:
        wrong(f"{place}.scale", "0 makes every value the same")
        formula = Linear()
    plain = signal(values.get("type", "u8"))
    labels = _labels(place, table.get("labels"), formula, plain, wrong)
    return name, signal(
        values.get("type", "u8"),
        values.get("unit", ""),
        conversion=lambda constants: formula,
        special=_special(place, table.get("special"), plain, wrong),
        limits=_limits(place, values, formula, plain, wrong),
        codes=_codes(name, labels) if labels else None,
        about=values.get("doc", ""),
    )


def _limits(place: str, values: Table, formula: Linear, plain: Signal, wrong: Wrong) -> tuple[float, float] | None:
    """`min` and `max` as raw values."""
    if not {"min", "max"} & values.keys():
        return None
    names = ("min", "max") if formula.factor > 0 else ("max", "min")
    raws = []
    for name, bound in zip(names, plain.range, strict=True):
        exact = (values[name] - formula.offset) / formula.factor if name in values else bound
        raws.append(exact if plain.real else round(exact))
        if not plain.range[0] <= exact <= plain.range[1]:
            wrong(f"{place}.{name}", f"{values[name]:g} does not fit the field's type")
    lowest, highest = raws
    if lowest > highest:
        wrong(f"{place}.max", "should be above min")
    return lowest, highest


def _special(place: str, table: object, plain: Signal, wrong: Wrong) -> tuple[tuple[int, float | None], ...]:
    """Raw values that the formula does not hold for."""
    special: dict[int, float | None] = {}
    for raw, key, meaning in _by_raw(f"{place}.special", table, plain, wrong):
        if meaning == "none":
            special[raw] = None
        elif isinstance(meaning, int | float) and not isinstance(meaning, bool):
            special[raw] = float(meaning)
        else:
            wrong(key, f'{written(meaning)} should be a number or "none"')
    return tuple(special.items())


def _labels(place: str, table: object, formula: Linear, plain: Signal, wrong: Wrong) -> dict[str, int]:
    """Raw values by the names of what they mean."""
    labels: dict[str, int] = {}
    for raw, key, meaning in _by_raw(f"{place}.labels", table, plain, wrong):
        name = re.sub(r"\W+", "_", str(meaning)).upper().strip("_")
        if not isinstance(meaning, str) or not name.isidentifier():
            wrong(key, f"{written(meaning)} should be a word or two")
        elif name in labels:
            wrong(key, f'"{meaning}" is {labels[name]} already')
        else:
            labels[name] = raw
    if labels and formula != Linear():
        wrong(f"{place}.labels", "a labelled field has neither scale nor offset")
    return labels


def _by_raw(place: str, table: object, plain: Signal, wrong: Wrong) -> Iterator[tuple[int, str, object]]:
    """Raw value, key and meaning of each entry of a table that is keyed by raw values."""
    if table is None:
        return
    if not isinstance(table, dict) or plain.real:
        wrong(place, "this belongs to whole numbers only" if plain.real else "should be a table of raw values")
        return
    for key, meaning in table.items():
        lowest, highest = plain.range
        try:
            raw = int(key, 0)
        except ValueError:
            wrong(f"{place}.{key}", f'"{key}" should be a raw value, like 7 or 0xFFFF')
            continue
        if plain.signed and highest < raw <= plain.ones:
            raw -= plain.ones + 1  # 0xFFFF is how people write an int16 of -1
        if lowest <= raw <= highest:
            yield raw, f"{place}.{key}", meaning
        else:
            wrong(f"{place}.{key}", f"{key} does not fit the field's type")


def _values(place: str, table: Table, keys: Table, wrong: Wrong, others: tuple[str, ...]) -> Table:
    """The values of a table that are right."""
    values = {}
    for key, value in table.items():
        if key in others:
            continue
        if key not in keys:
            wrong(f"{place}.{key}", f"unknown key{did_you_mean(key, [*keys, *others])}")
            continue
        try:
            values[key] = convert(value, keys[key])
        except ValueError as fault:
            wrong(f"{place}.{key}", str(fault))
    return values


def _list(tables: object, place: str, wrong: Wrong) -> list[Table]:
    if tables is None:
        return []
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        wrong(place, f"should be a list of tables: [[{place}]]")
        return []
    return tables


def _name(name: str, pattern: re.Pattern[str], wanted: str, place: str, wrong: Wrong) -> str:
    if pattern.fullmatch(name) and not keyword.iskeyword(name) and name != "layout":
        return name
    wrong(place, f"{written(name)} should be {wanted}")
    return "Frame" if pattern is CLASS_NAME else "field"


def _codes(field: str, labels: dict[str, int]) -> type[Code]:
    made = EnumType.__call__(Code, "".join(part.capitalize() for part in field.split("_")), labels)
    assert issubclass(made, Code)
    return made
