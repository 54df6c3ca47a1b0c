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
        meaning = self.formula.value(self.name)
        if self.signal.codes:
            return f"code_{self.name}[{self.name}]"
        if self.signal.real:
            return f"{meaning} if {-LARGEST!r} <= {self.name} <= {LARGEST!r} else None"
        if self.signal.special:
            return f"{meaning} if {self.name} not in special_{self.name} else special_{self.name}[{self.name}]"
        return meaning

    def raw(self) -> list[str]:
        """Lines that give the name of the field to its raw value, or leave by way of `refusal`."""
        lowest, highest = self.signal.range
        exact = self.formula.raw("v")
        raw = "index(v)" if self.counted else exact if self.signal.real else f"round({exact})"
        formula = [
            f"{self.name} = {raw}",
            f"if not {lowest!r} <= {self.name} <= {highest!r}{self._taken()}:",
            " raise refusal(self)",
        ]
        if not self.signal.special:
            return [f"v = self.{self.name}", *formula]
        return [
            f"v = self.{self.name}",
            f"if v in said_{self.name}:",
            f" {self.name} = said_{self.name}[v]",
            "else:",
            *(f" {line}" for line in formula),
        ]

    def _taken(self) -> str:
        return f" or {self.name} in special_{self.name}" if self.signal.special else ""

    @property
    def scope(self) -> dict[str, Any]:
        special = dict(self.signal.special)
        return {
            f"special_{self.name}": special,
            f"said_{self.name}": {value: raw for raw, value in special.items()},
            f"code_{self.name}": Table(self.signal.codes) if self.signal.codes else None,
        }

    def fault(self, value: Any) -> str | None:
        """Why a value cannot be sent."""
        said = [meaning for _, meaning in self.signal.special]
        if value in said:
            return None
        if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
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
    """The codec of a frame, made once."""
    parts = tuple(Part(name, signal, signal.conversion(calibration)) for name, signal in frame.signals)
    layout = struct.Struct("<" + "".join(part.signal.kind for part in parts))
    scope: dict[str, Any] = {
        "frame": frame, "unpack": layout.unpack, "pack": layout.pack, "error": struct.error, "index": index,
        "MISTAKES": MISTAKES, "refusal": lambda given: _refusal(parts, given), "no_values": EncodeError,
    }  # fmt: skip
    for part in parts:
        scope |= part.scope
    text = "\n".join(_decode(frame, parts) + _encode(frame, parts))
    exec(compile(text, f"<codec of {frame.__name__}>", "exec"), scope)
    return Codec(frame, parts, text, scope["decode"], scope["encode"])


def _decode(frame: type[RoverFrame], parts: tuple[Part, ...]) -> list[str]:
    names = "".join(f"{part.name}, " for part in parts)
    return [
        "def decode(data):",
        " try:",
        f"  {names}= unpack(data)",
        " except error:",
        "  return None",
        *([f" if not ({frame.VALID}):", "  return frame()"] if frame.VALID else []),
        f" return frame({', '.join(part.value() for part in parts)})",
    ]


def _encode(frame: type[RoverFrame], parts: tuple[Part, ...]) -> list[str]:
    lines = ["def encode(self):"]
    if frame.VALID:
        lines += [" if self == frame():", f"  return bytes({frame.size})"]
    lines.append(" try:")
    for part in parts:
        lines += [f"  {line}" for line in part.raw()]
    names = ", ".join(part.name for part in parts)
    lines += [f"  data = pack({names})", " except MISTAKES:", "  raise refusal(self) from None"]
    if frame.VALID:
        lines += [
            f" {names}, = unpack(data)",
            f" if not ({frame.VALID}):",
            f"  raise no_values('{frame.__name__}: what these values say is that there are none')",
        ]
    return [*lines, " return data"]


def _refusal(parts: tuple[Part, ...], frame: RoverFrame) -> EncodeError:
    """Why a frame cannot be encoded, in the words of its first bad field."""
    for part in parts:
        if fault := part.fault(getattr(frame, part.name)):
            return EncodeError(f"{part.name}: {fault}")
    raise AssertionError("a codec refused what has no fault")
