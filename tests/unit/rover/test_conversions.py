"""Formulas compose, and write themselves as Python and for people."""

import pytest

from timonel.vehicles.rover.calibration import DOCUMENTED, PHYSICAL
from timonel.vehicles.rover.conversions import ArmCurrent, Linear, Reciprocal, Tap, WheelSpeed, signal


def value(formula: Linear | Reciprocal, raw: float) -> float:
    return eval(formula.value("raw"), {"raw": raw})


def raw(formula: Linear | Reciprocal, value: float) -> float:
    return eval(formula.raw("value"), {"value": value})


def test_linear_formulas_follow_each_other():
    assert Linear(1, -10) >> Linear(2) >> Linear(1, 3) == Linear(2, -17)
    assert value(Linear(2, -17), 10) == 3


def test_a_formula_undoes_itself():
    assert raw(Linear(0.5, -40), value(Linear(0.5, -40), 77)) == 77
    assert raw(Reciprocal(33750), value(Reciprocal(33750), -337)) == -337


def test_what_does_nothing_is_not_written():
    assert Linear().value("steps") == "steps"
    assert (Linear().text(), Linear(2, -3).text(), Linear(1, 3).text()) == ("raw", "raw * 2 - 3", "raw + 3")
    assert Reciprocal(33750).text() == "33750 / raw"


@pytest.mark.parametrize(("calibration", "amperes"), [(DOCUMENTED, 41.6663), (PHYSICAL, 16.6663)])
def test_the_arms_sensor_is_finer_than_the_drives(calibration, amperes):
    assert value(ArmCurrent().conversion(calibration), 3103) == pytest.approx(amperes, abs=1e-4)


def test_each_tap_has_a_divider_of_its_own():
    full = [value(Tap(number).conversion(PHYSICAL), 4095) for number in (1, 2, 3, 4)]
    assert full == pytest.approx([4.319, 9.153, 14.187, 18.805], abs=0.001)


def test_the_slowest_wheel_is_the_longest_period():
    assert value(WheelSpeed().conversion(PHYSICAL), 32767) == pytest.approx(1.03, abs=0.001)
    assert value(WheelSpeed().conversion(DOCUMENTED), 32767) == pytest.approx(1054.72, abs=0.01)


@pytest.mark.parametrize(
    ("type_", "range_"),
    [
        ("u8", (0, 255)),
        ("i8", (-128, 127)),
        ("i16", (-32768, 32767)),
        ("u32", (0, 2**32 - 1)),
        ("i32", (-(2**31), 2**31 - 1)),
    ],
)
def test_a_type_has_the_range_of_its_bits(type_, range_):
    assert signal(type_).range == range_


def test_limits_narrow_what_is_sent():
    assert signal("u8", limits=(1, 20)).range == (1, 20)
