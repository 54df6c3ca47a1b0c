"""The constants that turn raw values into SI, by name: all of them are configuration.

```
current [A]     = (raw - zero) * adc_volts / adc_counts * (r1 + r2) / r2 / sensor
speed [rpm]     = clock * input prescaler * 60 / (timer prescaler * pulses * raw)
voltage [V]     = raw * adc_volts / adc_counts * (r1 + r2) / r1
```
`DOCUMENTED` is the protocol's original text to the letter; `PHYSICAL` mends what it leaves out.
"""

from collections.abc import Callable, Mapping
from typing import Annotated, Literal, get_type_hints

import msgspec

from timonel.core.mistakes import convert, did_you_mean

Positive = Annotated[float, msgspec.Meta(gt=0)]
Counts = Annotated[float, msgspec.Meta(ge=-32768, le=32767)]
Three = tuple[Counts, Counts, Counts]
Four = tuple[Positive, Positive, Positive, Positive]

IDLE = 4096 * 1.5 / 3.3
"""ADC counts of an ACS714 without current: half of its 5 V supply behind the divider."""


class Calibration(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Constants of a rover; the defaults are `PHYSICAL`. Three values are those of the front, middle and rear wheel.

    Source: spec/rover.md, Raw to SI.
    """

    adc_volts: Positive = 3.3
    adc_counts: Positive = 4096
    current_zero_right: Three = (IDLE, IDLE, IDLE)
    """Raw value of each motor's current sensor without current, in ADC counts."""
    current_zero_left: Three = (IDLE, IDLE, IDLE)
    current_zero_arm: Counts = IDLE
    current_r1_kohm: Positive = 1.0
    current_r2_kohm: Positive = 1.5
    current_sensor_drive: Positive = 0.040
    """V/A: the 50 A sensor of the drive motors."""
    current_sensor_arm: Positive = 0.100
    """V/A: the 20 A sensor of the manipulator."""
    encoder_clock_hz: Positive = 36e6
    encoder_input_prescaler: Positive = 4
    encoder_timer_prescaler: Positive = 250
    encoder_pulses: Positive = 1024
    """Rising edges a revolution."""
    tap_r1_kohm: Four = (22, 12.4, 10, 10)
    """The lower resistor of each tap's divider."""
    tap_r2_kohm: Four = (6.8, 22, 33, 47)
    temperature_counts_per_degree: Positive = 2
    acceleration_counts_per_g: Positive = 16384
    rate_counts_per_degree_per_second: Positive = 131
    magnetic_milligauss_per_count: Positive = 0.160


PHYSICAL = Calibration()
DOCUMENTED = Calibration(
    current_zero_right=(0, 0, 0), current_zero_left=(0, 0, 0), current_zero_arm=0, encoder_pulses=1
)
CALIBRATIONS = {"documented": DOCUMENTED, "physical": PHYSICAL}


def calibrated(table: Mapping[str, object], wrong: Callable[[str, str], None]) -> Calibration:
    """A configuration's table `[calibration]`: `base` (documented or physical, the default) and constants of its own.

    What is wrong is told to `wrong` as key and text, and left out.
    """
    keys = get_type_hints(Calibration, include_extras=True)
    values = {}
    for key, value in table.items():
        wanted = Literal["documented", "physical"] if key == "base" else keys.get(key)
        if wanted is None:
            wrong(f"calibration.{key}", f"unknown key{did_you_mean(key, ['base', *keys])}")
            continue
        try:
            values[key] = convert(value, wanted)
        except ValueError as fault:
            wrong(f"calibration.{key}", str(fault))
    return msgspec.structs.replace(CALIBRATIONS[values.pop("base", "physical")], **values)
