"""The thermistor's own conversion, for the simulated modules."""

import pytest

from timonel.vehicles.rover.thermistor import celsius, counts

A1, B1 = 1 / 298.15, 1 / 3740


@pytest.mark.parametrize(
    ("adc", "degrees"), [(1000, 78.835), (2048, 44.997), (2816, 25.0), (3500, 3.358), (4000, -31.630)]
)
def test_counts_are_a_temperature_and_the_other_way_round(adc, degrees):
    assert celsius(adc, A1, B1) == pytest.approx(degrees, abs=0.001)
    assert counts(degrees, A1, B1) == pytest.approx(adc, abs=0.1)


@pytest.mark.parametrize("adc", [0, 4096, -1, 5000])
def test_a_broken_wire_is_no_temperature(adc):
    with pytest.raises(ValueError, match="a thermistor gives more than 0 and less than 4096"):
        celsius(adc, A1, B1)
