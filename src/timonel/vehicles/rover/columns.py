"""Whole recordings at once: the signals of many payloads of one frame as NumPy columns. Needs the extra `columns`."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

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
    formulas = [compile(part.formula.value(part.name), "<formula>", "eval") for part in parts]
    valid = compile(frame.VALID, "<valid>", "eval") if frame.VALID else None
    derived = list(frame.DERIVED.items())

    def convert(raws: Any, block: Column) -> None:
        found = {part.name: raws[part.name].astype(np.float64) for part in parts}
        values: dict[str, Any] = {}
        for part, formula, column in zip(parts, formulas, block, strict=False):
            column[:] = eval(formula, found)
            _mark(column, part, found[part.name])
            values[part.name] = column
        if valid:
            block[: len(parts), ~eval(valid, found)] = np.nan
        for (name, signal), column in zip(derived, block[len(parts) :], strict=True):
            column[:] = eval(signal.code, FUNCTIONS | CONSTANTS | values)
            values[name] = column

    return convert


def _mark(column: Column, part: "Part", raw: Column) -> None:
    """Put in what special raw values mean, and what is not available."""
    for special, value in part.signal.special:
        column[raw == special] = np.nan if value is None else value
    if part.signal.real:
        column[~np.isfinite(raw)] = np.nan
