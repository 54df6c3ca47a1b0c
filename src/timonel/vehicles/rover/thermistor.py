"""The NTC thermistor of a battery module: the conversion that the module's own controller does.

T = 1 / (A1 + B1 ln(R1 / ((4096 / counts - 1) R0))) - 273.15, with the thermistor below a pull-up R1.
A1 and B1 are the part's data: 1 / 298.15 K and 1 / B for a part that is specified by its B and its R0 at 25 degC.
Source: spec/rover.md, Raw to SI.
"""

import math

PULL_UP_KOHM = 10.0
NOMINAL_KOHM = 22.0
ADC_COUNTS = 4096
ZERO_CELSIUS = 273.15  # K


def celsius(counts: float, a1: float, b1: float, r1_kohm: float = PULL_UP_KOHM, r0_kohm: float = NOMINAL_KOHM) -> float:
    """Temperature in degC; raises ValueError where `counts` is not between 0 and 4096, both excluded."""
    if not 0 < counts < ADC_COUNTS:
        raise ValueError(f"{counts} counts: a thermistor gives more than 0 and less than {ADC_COUNTS}")
    ratio = r1_kohm / ((ADC_COUNTS / counts - 1) * r0_kohm)
    return 1 / (a1 + b1 * math.log(ratio)) - ZERO_CELSIUS


def counts(
    degrees_c: float, a1: float, b1: float, r1_kohm: float = PULL_UP_KOHM, r0_kohm: float = NOMINAL_KOHM
) -> float:
    """The ADC counts, not rounded, that `celsius` reads as `degrees_c`."""
    ratio = math.exp((1 / (degrees_c + ZERO_CELSIUS) - a1) / b1)
    return ADC_COUNTS / (1 + r1_kohm / (ratio * r0_kohm))
