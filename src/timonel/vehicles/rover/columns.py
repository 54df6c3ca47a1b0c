"""Whole recordings at once: the signals of many payloads of one frame as NumPy columns. Needs the extra `columns`."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from timonel.vehicles.rover.conversions import Linear, Reciprocal
from timonel.vehicles.rover.declaration import CONSTANTS, RoverFrame

if TYPE_CHECKING:
    from timonel.vehicles.rover.codec import Part

Column = npt.NDArray[np.float64]
Payloads = npt.NDArray[np.uint8]
FUNCTIONS: dict[str, Callable[..., Any]] = {"atan2": np.arctan2, "sqrt": np.sqrt}
CHUNK = 1 << 14  # rows at a time, so that what is worked on stays in the processor's cache


def columns(frame: type[RoverFrame], parts: "tuple[Part, ...]", payloads: Payloads) -> dict[str, Column]:
    """One float64[n] per signal and derived signal of uint8[n, size], NaN where not available."""
    raws = np.ascontiguousarray(payloads).view(_layout(parts))[:, 0]
    names = [part.name for part in parts] + list(frame.DERIVED)
    block = np.empty((len(names), len(raws)))  # in one piece: the kernel gives it in huge pages
    convert = _converter(frame, parts)
    with np.errstate(all="ignore"):
        for start in range(0, len(raws), CHUNK):
            chunk = slice(start, start + CHUNK)
            convert(raws[chunk], block[:, chunk])
    return dict(zip(names, block, strict=True))


def _layout(parts: "tuple[Part, ...]") -> np.dtype[np.void]:
    return np.dtype([(part.name, f"<{part.signal.kind}") for part in parts])


def _converter(frame: type[RoverFrame], parts: "tuple[Part, ...]") -> Callable[[Any, Column], None]:
    """Fills the rows of a block, one a signal, with the values of raw payloads."""
    valid = compile(frame.VALID, "<valid>", "eval") if frame.VALID else None
    derived = [(name, signal, len(parts) + place) for place, (name, signal) in enumerate(frame.DERIVED.items())]

    def convert(raws: Any, block: Column) -> None:
        for part, column in zip(parts, block, strict=False):
            _fill(column, part, raws[part.name])
        if valid:
            nothing = ~eval(valid, {part.name: raws[part.name] for part in parts})
            for column in block[: len(parts)]:
                _put(column, nothing, np.nan)
        values = {part.name: column for part, column in zip(parts, block, strict=False)}
        for name, signal, place in derived:
            values[name] = block[place]
            block[place] = eval(signal.code, FUNCTIONS | CONSTANTS | values)

    return convert


def _fill(column: Column, part: "Part", raw: npt.NDArray[Any]) -> None:
    """The same sums in the same order as the formula's expression."""
    match part.formula:
        case Linear(factor, offset):
            np.multiply(raw, factor, out=column, dtype=np.float64)
            if offset:
                column += offset
        case Reciprocal(numerator):
            np.divide(numerator, raw, out=column, dtype=np.float64)
    for special, value in part.signal.special:
        _put(column, raw == special, np.nan if value is None else value)
    if part.signal.real:
        _put(column, ~np.isfinite(raw), np.nan)


def _put(column: Column, where: npt.NDArray[np.bool_], value: float) -> None:
    if where.any():
        np.copyto(column, value, where=where)
