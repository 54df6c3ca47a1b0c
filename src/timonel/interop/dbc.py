"""The rover's frames as a DBC file, for the tools of others.

Signals that are linear are scaled by the calibration's constants. DBC knows no other formula, no value that means "not
available" and no frame in two segments: signals of another formula are raw and their comment has the formula, special
raw values are in `VAL_` and in the comment, frames that do not fit one CAN frame are left out and named in the file's
own comment. Source: the DBC format as cantools reads and writes it.
"""

import re
from collections.abc import Iterator

from timonel.core.fields import Code
from timonel.vehicles.rover.codec import Codec, Part
from timonel.vehicles.rover.conversions import Linear
from timonel.vehicles.rover.declaration import Party, RoverFrame
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.segments import SINGLE

LISTENERS = {Party.ROVER: "controller", Party.MOTORS: "motors", Party.OPERATOR: "operator"}
SHORT = 7  # significant digits of the calibrated bounds, which are for people


def export(protocol: Protocol) -> str:
    """The text of the file, in ASCII as far as names and comments allow it."""
    codecs = [protocol.codec(number) for number in sorted(protocol.declarations)]
    told = [codec for codec in codecs if codec.frame.size <= SINGLE]
    nodes = sorted({*LISTENERS.values(), *(_node(codec.frame) for codec in told)})
    attributes = [f'BA_ "GenMsgCycleTime" BO_ {codec.frame.FRAME} {round(1000 / codec.frame.RATE)};' for codec in told]
    sections = [
        ['VERSION ""'],
        ["NS_ :"],
        ["BS_:"],
        [f"BU_: {' '.join(nodes)}"],
        *(list(_message(codec)) for codec in told),
        list(_left_out(codecs)) + [line for codec in told for line in _comments(codec)],
        ['BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;', 'BA_DEF_DEF_ "GenMsgCycleTime" 0;', *attributes],
        [line for codec in told for line in _values(codec)],
        [line for codec in told for line in _floats(codec)],
    ]
    return "\n\n".join("\n".join(lines) for lines in sections if lines) + "\n"


def _node(frame: type[RoverFrame]) -> str:
    return re.sub(r"\W+", "_", frame.SENDER) or "Vector__XXX"  # what the format calls nobody


def _message(codec: Codec) -> Iterator[str]:
    frame = codec.frame
    yield f"BO_ {frame.FRAME} {frame.__name__}: {frame.size} {_node(frame)}"
    start = 0
    for part in codec.parts:
        sign = "-" if part.signal.signed else "+"
        factor, offset = _scale(part)
        unit = part.signal.unit if isinstance(part.formula, Linear) else ""
        lowest, highest = sorted(raw * factor + offset for raw in part.signal.range)
        yield (
            f" SG_ {part.name} : {start}|{part.signal.bits}@1{sign} ({factor!r},{offset!r})"
            f' [{lowest:.{SHORT}g}|{highest:.{SHORT}g}] "{unit}" {LISTENERS[frame.TO]}'
        )
        start += part.signal.bits


def _scale(part: Part) -> tuple[float, float]:
    return (part.formula.factor, part.formula.offset) if isinstance(part.formula, Linear) else (1, 0)


def _left_out(codecs: list[Codec]) -> Iterator[str]:
    names = ", ".join(f"{codec.frame.FRAME} {codec.frame.__name__}" for codec in codecs if codec.frame.size > SINGLE)
    if names:
        yield f'CM_ "Left out, for they are longer than a CAN frame: {names}.";'


def _comments(codec: Codec) -> Iterator[str]:
    frame = codec.frame
    if text := _quoted(" ".join([frame.__doc__ or "", *_derived(frame)])):
        yield f'CM_ BO_ {frame.FRAME} "{text}";'
    for part in codec.parts:
        if text := _quoted(" ".join([part.signal.about, *_meaning(part)])):
            yield f'CM_ SG_ {frame.FRAME} {part.name} "{text}";'


def _derived(frame: type[RoverFrame]) -> Iterator[str]:
    for name, signal in frame.DERIVED.items():
        yield f"{name} = {signal.formula} [{signal.unit}]."


def _meaning(part: Part) -> Iterator[str]:
    """What DBC cannot say otherwise."""
    if not isinstance(part.formula, Linear):
        yield f"Raw: {part.name} = {part.formula.text()} [{part.signal.unit}]."
    for raw, value in part.signal.special:
        yield f"Raw {raw} is {'not available' if value is None else f'{value:g}'}."


def _quoted(text: str) -> str:
    return " ".join(text.split()).replace("\\", "/").replace('"', "'")


def _values(codec: Codec) -> Iterator[str]:
    for part in codec.parts:
        named = {code.value: _words(code) for code in part.signal.codes or ()}
        named |= {raw: "not available" if value is None else f"{value:g}" for raw, value in part.signal.special}
        if named:
            entries = " ".join(f'{raw} "{name}"' for raw, name in sorted(named.items()))
            yield f"VAL_ {codec.frame.FRAME} {part.name} {entries} ;"


def _words(code: Code) -> str:
    return code.name.replace("_", " ").lower()


def _floats(codec: Codec) -> Iterator[str]:
    for part in codec.parts:
        if part.signal.real:
            yield f"SIG_VALTYPE_ {codec.frame.FRAME} {part.name} : 1;"
