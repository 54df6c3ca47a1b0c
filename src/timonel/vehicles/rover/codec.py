"""Generates a frame's codec for one calibration: `decode`, `encode`, and the columns of many payloads.

What runs once a frame is written for speed: one `struct.Struct`, and the calibration's constants as numbers in the
text. The same expressions convert a value and a column of values, so that both give the same. `Codec.text` shows the
Python that is made.
"""

import math
import struct
from collections.abc import Callable
from functools import cache
from operator import index
from typing import TYPE_CHECKING, Any

import msgspec

from timonel.core.codec import Table
from timonel.errors import DecodeError, EncodeError
from timonel.vehicles.rover.calibration import Calibration
from timonel.vehicles.rover.conversions import LARGEST, Formula, Linear, Signal
from timonel.vehicles.rover.declaration import RoverFrame

if TYPE_CHECKING:
    from timonel.vehicles.rover.columns import Column, Payloads

Decoder = Callable[[bytes], RoverFrame | None]
MISTAKES = (TypeError, ValueError, OverflowError, ZeroDivisionError, struct.error)


class Part(msgspec.Struct, frozen=True):
    """A field of a frame with the formula that a calibration gives it."""

    name: str
    signal: Signal
    formula: Formula

    @property
    def counted(self) -> bool:
        """Whether the value is the raw value itself, a whole number."""
        return self.formula == Linear() and not self.signal.real

    def value(self) -> str:
        """The expression of what the raw value, which is called as the field is, means."""
        name, meaning = self.name, self.formula.value(self.name)
        if self.signal.codes:
            return f"_code_{name}[{name}]"
        if self.signal.real:
            return f"{meaning} if {-LARGEST!r} <= {name} <= {LARGEST!r} else None"
        if self.signal.special:
            return f"{meaning} if {name} not in _special_{name} else _special_{name}[{name}]"
        return meaning

    def raw(self) -> list[str]:
        """Lines that give the name of the field to its raw value, or leave by way of `_refusal`."""
        lowest, highest = self.signal.range
        exact = self.formula.raw("_v")
        raw = "_index(_v)" if self.counted else exact if self.signal.real else f"_round({exact})"
        taken = f" or {self.name} in _special_{self.name}" if self.signal.special else ""
        formula = [
            f"{self.name} = {raw}",
            f"if not {lowest!r} <= {self.name} <= {highest!r}{taken}:",
            " raise _refusal(_self)",
        ]
        if not self._said:
            return [f"_v = _self.{self.name}", *formula]
        return [
            f"_v = _self.{self.name}",
            f"if _v in _said_{self.name}:",
            f" {self.name} = _said_{self.name}[_v]",
            "else:",
            *(f" {line}" for line in formula),
        ]

    @property
    def _said(self) -> dict[float | None, float]:
        """Raw values by what they mean, where the formula does not hold."""
        return {value: raw for raw, value in self.signal.special} | ({None: math.nan} if self.signal.real else {})

    @property
    def scope(self) -> dict[str, Any]:
        """What the lines refer to."""
        return {
            f"_special_{self.name}": dict(self.signal.special),
            f"_said_{self.name}": self._said,
            f"_code_{self.name}": Table(self.signal.codes) if self.signal.codes else None,
        }

    def fault(self, value: Any) -> str | None:
        """Why a value cannot be sent."""
        if value in list(self._said):
            return None
        if not isinstance(value, int | float) or math.isnan(value):
            return f"{value!r} is not a number"
        if self.counted and not isinstance(value, int):
            return f"{value!r} is not a whole number"
        return self._out_of_range(value)

    def _out_of_range(self, value: float) -> str | None:
        lowest, highest = self.signal.range
        try:
            raw = eval(self.formula.raw("v"), {"v": value})
        except ZeroDivisionError:
            raw = math.inf
        if math.isfinite(raw) and not self.signal.real:
            raw = round(raw)
        if lowest <= raw <= highest and raw not in dict(self.signal.special):
            return None
        unit = f" {self.signal.unit}" if self.signal.unit else ""
        if not isinstance(self.formula, Linear):
            return f"{value}{unit} is no whole number of counts within {lowest:g}..{highest:g}"
        bounds = sorted(eval(self.formula.value("raw"), {"raw": raw}) for raw in (lowest, highest))
        return f"{value}{unit} is outside {'..'.join(f'{bound:.10g}' for bound in bounds)}"


class Codec(msgspec.Struct, frozen=True):
    """What one calibration makes of one frame."""

    frame: type[RoverFrame]
    parts: tuple[Part, ...]
    text: str
    decode: Decoder
    """A whole payload; None where the length is not the frame's."""
    encode: Callable[[RoverFrame], bytes]
    """Raises EncodeError."""

    def columns(self, payloads: "Payloads") -> "dict[str, Column]":
        """See `Protocol.columns`."""
        from timonel.vehicles.rover.columns import columns

        if payloads.ndim != 2 or payloads.shape[1] != self.frame.size:
            raise DecodeError(f"{self.frame.__name__}: payloads of shape {payloads.shape}, not (n, {self.frame.size})")
        return columns(self.frame, self.parts, payloads)


@cache
def codec(frame: type[RoverFrame], calibration: Calibration) -> Codec:
    """The codec of a frame, made once. All names but those of the frame's fields begin with an underscore."""
    parts = tuple(Part(name, signal, signal.conversion(calibration)) for name, signal in frame.signals)
    layout = struct.Struct("<" + "".join(part.signal.kind for part in parts))
    scope: dict[str, Any] = {
        "_frame": frame, "_nothing": frame(), "_unpack": layout.unpack, "_pack": layout.pack, "_error": struct.error,
        "_index": index, "_round": round, "_MISTAKES": MISTAKES, "_refusal": lambda given: _refusal(parts, given),
    }  # fmt: skip
    for part in parts:
        scope |= part.scope
    text = "\n".join(_decode(frame, parts) + _encode(frame, parts))
    exec(compile(text, f"<codec of {frame.__name__}>", "exec"), scope)
    return Codec(frame, parts, text, scope["_decode"], scope["_encode"])


def _decode(frame: type[RoverFrame], parts: tuple[Part, ...]) -> list[str]:
    return [
        "def _decode(_data):",
        " try:",
        f"  {_names(parts)} = _unpack(_data)",
        " except _error:",
        "  return None",
        *([f" if not ({frame.VALID}):", "  return _nothing"] if frame.VALID else []),
        f" return _frame({', '.join(part.value() for part in parts)})",
    ]


def _encode(frame: type[RoverFrame], parts: tuple[Part, ...]) -> list[str]:
    return [
        "def _encode(_self):",
        *([" if _self == _nothing:", f"  return {bytes(frame.size)!r}"] if frame.VALID else []),
        " try:",
        *(f"  {line}" for part in parts for line in part.raw()),
        f"  _data = _pack({_names(parts)})",
        " except _MISTAKES:",
        "  raise _refusal(_self) from None",
        *([" if _decode(_data) is _nothing:", "  raise _refusal(_self)"] if frame.VALID else []),
        " return _data",
    ]


def _names(parts: tuple[Part, ...]) -> str:
    return "".join(f"{part.name}, " for part in parts)


def _refusal(parts: tuple[Part, ...], frame: RoverFrame) -> EncodeError:
    """Why a frame cannot be encoded, in the words of its first bad field."""
    for part in parts:
        if fault := part.fault(getattr(frame, part.name)):
            return EncodeError(f"{part.name}: {fault}")
    return EncodeError(f"{type(frame).__name__}: {frame} cannot be told from having no values")
