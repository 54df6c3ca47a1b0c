"""What a raw value means: formulas that compose, know their inverse and write themselves as Python.

```python
volts = Linear(3.3 / 4096)
Linear(1, -1862) >> volts >> Linear(1 / 0.040)   # -> Linear(0.0201..., -37.5...): counts -> A
```
A conversion is what a frame is declared with: it gives the formula that a calibration makes of it. Values that mean
something special to the sender, as 0xFFFF for a standing wheel, stand beside the formula as data.
"""

import math
from collections.abc import Callable
from typing import Any

import msgspec

from timonel.core.fields import Code, Fixed
from timonel.vehicles.rover.calibration import Calibration

STANDARD_GRAVITY = 9.80665  # m/s2
TESLA_PER_MILLIGAUSS = 1e-7


class Linear(msgspec.Struct, frozen=True):
    """value = raw * factor + offset."""

    factor: float = 1
    offset: float = 0

    def __rshift__(self, then: "Linear") -> "Linear":
        """This one first, `then` on its result."""
        return Linear(self.factor * then.factor, self.offset * then.factor + then.offset)

    def value(self, raw: str) -> str:
        """The value as a Python expression of `raw`; it serves numbers and columns of numbers alike."""
        scaled = raw if self.factor == 1 else f"{raw} * {self.factor!r}"
        return f"{scaled} + {self.offset!r}" if self.offset else scaled

    def raw(self, value: str) -> str:
        """The raw value, not yet rounded, as a Python expression of `value`."""
        return f"({value} - {self.offset!r}) / {self.factor!r}"

    def text(self) -> str:
        """The formula for people."""
        scaled = "raw" if self.factor == 1 else f"raw * {self.factor:.9g}"
        return scaled + (f" {'-' if self.offset < 0 else '+'} {abs(self.offset):.9g}" if self.offset else "")


class Reciprocal(msgspec.Struct, frozen=True):
    """value = numerator / raw."""

    numerator: float

    def value(self, raw: str) -> str:
        return f"{self.numerator!r} / {raw}"

    def raw(self, value: str) -> str:
        return f"{self.numerator!r} / {value}"

    def text(self) -> str:
        return f"{self.numerator:.9g} / raw"


Formula = Linear | Reciprocal
Conversion = Callable[[Calibration], Formula]
Special = tuple[tuple[int, float | None], ...]


class Signal(Fixed, frozen=True):
    """A field of a rover's frame: whole little-endian bytes and what they mean.

    `kind` is the struct module's letter. `special` are raw values that the formula does not hold for; `limits` are the
    lowest and highest raw value that we send (what is outside is read all the same: judging it is not the codec's).
    """

    kind: str = "B"
    unit: str = ""
    conversion: Conversion = lambda calibration: Linear()
    special: Special = ()
    limits: tuple[float, float] | None = None
    codes: type[Code] | None = None
    about: str = ""

    @property
    def signed(self) -> bool:
        return self.kind.islower()

    @property
    def real(self) -> bool:
        """Whether it is an IEEE 754 number; what is no number or infinite is not available then."""
        return self.kind == "f"

    @property
    def range(self) -> tuple[float, float]:
        """The lowest and highest raw value that may be sent."""
        if self.limits is not None:
            return self.limits
        if self.real:
            return -LARGEST, LARGEST
        return (-(1 << self.bits - 1), (1 << self.bits - 1) - 1) if self.signed else (0, self.ones)


LARGEST = (2 - 2**-23) * 2.0**127  # of 32 bits
KINDS = {"u8": "B", "i8": "b", "u16": "H", "i16": "h", "u32": "I", "i32": "i", "f32": "f"}


def signal(type_: str, unit: str = "", **about: Any) -> Signal:
    """A signal of a type that is written as in the specification: `u8`, `i16`, `f32` ..."""
    return Signal(int(type_[1:]), KINDS[type_], unit, **about)


# What the rover's frames are made of ------------------------------------------------------------


def Percent() -> Signal:
    """-100..100 %."""
    return signal("i8", "%", limits=(-100, 100))


def Steps(highest: int) -> Signal:
    """1..`highest`, of which `highest` is full."""
    return signal("u8", limits=(1, highest))


def Coded(codes: type[Code]) -> Signal:
    """One of a list; a number that is not on it stays distinguishable (`UNKNOWN_7`)."""
    return signal("u8", codes=codes)


def Current(side: str, wheel: int) -> Signal:
    """Current of a drive motor in A, from ADC counts; `wheel` 0..2 from the front."""

    def conversion(constants: Calibration) -> Linear:
        zero = (constants.current_zero_right if side == "right" else constants.current_zero_left)[wheel]
        return _current(constants, zero, constants.current_sensor_drive)

    return signal("i16", "A", conversion=conversion)


def ArmCurrent() -> Signal:
    """Current of a manipulator's motor in A, from ADC counts, by the 20 A sensor."""
    return signal(
        "i16", "A", conversion=lambda with_: _current(with_, with_.current_zero_arm, with_.current_sensor_arm)
    )


def _current(constants: Calibration, zero: float, volts_per_ampere: float) -> Linear:
    r1, r2 = constants.current_r1_kohm, constants.current_r2_kohm
    return Linear(1, -zero) >> _volts(constants) >> Linear((r1 + r2) / r2) >> Linear(1 / volts_per_ampere)


def _volts(constants: Calibration) -> Linear:
    """At the ADC's input."""
    return Linear(constants.adc_volts / constants.adc_counts)


def WheelSpeed() -> Signal:
    """Speed of a wheel in rpm, from the timer's counts between two edges.

    What is slower than the counter can tell (1.03 rpm with 1024 pulses) has to be sent as standing.
    """

    def conversion(constants: Calibration) -> Reciprocal:
        ticks = constants.encoder_clock_hz * constants.encoder_input_prescaler / constants.encoder_timer_prescaler
        return Reciprocal(ticks * 60 / constants.encoder_pulses)

    # 0xFFFF, which is -1, is a standing wheel, not a fast one (enkPrędkość); 0 would be infinitely fast
    return signal("i16", "rpm", conversion=conversion, special=((-1, 0.0), (0, None)))


def Tap(number: int) -> Signal:
    """Voltage of tap 1..4 of the battery against ground in V, from 12-bit ADC counts behind a divider."""

    def conversion(constants: Calibration) -> Linear:
        r1, r2 = constants.tap_r1_kohm[number - 1], constants.tap_r2_kohm[number - 1]
        return _volts(constants) >> Linear((r1 + r2) / r1)

    return signal("u16", "V", conversion=conversion, limits=(0, 4095))


def HalfDegrees() -> Signal:
    """A temperature in degC."""
    return signal("u8", "degC", conversion=lambda constants: Linear(1 / constants.temperature_counts_per_degree))


def Degrees(limit: float) -> Signal:
    """A coordinate in degrees, east and north positive, within +-`limit`."""
    return signal("f32", "deg", limits=(-limit, limit))


def Acceleration() -> Signal:
    """In m/s2."""
    return signal("i16", "m/s2", conversion=lambda with_: Linear(STANDARD_GRAVITY / with_.acceleration_counts_per_g))


def Rate() -> Signal:
    """A rate of turn in rad/s."""
    return signal(
        "i16", "rad/s", conversion=lambda with_: Linear(math.pi / 180 / with_.rate_counts_per_degree_per_second)
    )


def MagneticField() -> Signal:
    """A magnetic flux density in T."""
    return signal(
        "i16", "T", conversion=lambda with_: Linear(TESLA_PER_MILLIGAUSS * with_.magnetic_milligauss_per_count)
    )
