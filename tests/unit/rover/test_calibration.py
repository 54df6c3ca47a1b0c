"""Constants have names, two built-in sets, and are configuration."""

import pytest

from timonel.vehicles.rover.calibration import DOCUMENTED, PHYSICAL, Calibration, calibrated


def understood(table: dict[str, object]) -> Calibration:
    def wrong(key: str, text: str) -> None:
        raise AssertionError(f"{key}: {text}")

    return calibrated(table, wrong)


def mistakes(table: dict[str, object]) -> list[tuple[str, str]]:
    found: list[tuple[str, str]] = []
    calibrated(table, lambda key, text: found.append((key, text)))
    return found


def test_the_physical_calibration_knows_the_sensors_idle_reading_and_the_encoders_pulses():
    assert PHYSICAL.current_zero_right == pytest.approx([1861.82] * 3, abs=0.005)
    assert PHYSICAL.encoder_pulses == 1024


def test_the_documented_calibration_differs_in_what_the_original_leaves_out():
    differing = {name for name in Calibration.__struct_fields__ if getattr(DOCUMENTED, name) != getattr(PHYSICAL, name)}
    assert differing == {"current_zero_right", "current_zero_left", "current_zero_arm", "encoder_pulses"}


def test_without_a_word_the_calibration_is_physical():
    assert understood({}) == PHYSICAL


def test_constants_of_ones_own_stand_above_a_base():
    found = understood({"base": "documented", "encoder_pulses": 256, "current_zero_left": [1, 2.5, 3]})
    assert (found.encoder_pulses, found.current_zero_left) == (256, (1, 2.5, 3))
    assert found.current_zero_right == DOCUMENTED.current_zero_right


@pytest.mark.parametrize(
    ("table", "mistake"),
    [
        ({"base": "physicall"}, ("calibration.base", '"physicall" should be "documented" or "physical"')),
        ({"encoder_pulse": 1}, ("calibration.encoder_pulse", 'unknown key (did you mean "encoder_pulses"?)')),
        ({"encoder_pulses": 0}, ("calibration.encoder_pulses", "0 should be a number above 0")),
        ({"adc_volts": "3.3"}, ("calibration.adc_volts", '"3.3" should be a number above 0')),
        (
            {"tap_r1_kohm": [1, 2, 3]},
            ("calibration.tap_r1_kohm", "a list should be a list of 4, each a number above 0"),
        ),
        (
            {"current_zero_left": [1, 2, 99999]},
            ("calibration.current_zero_left", "a list should be a list of 3, each a number -32768..32767"),
        ),
    ],
)
def test_what_is_no_constant_is_told_with_what_would_be_right(table: dict[str, object], mistake: tuple[str, str]):
    [(key, text)] = mistakes(table)
    assert key == mistake[0]
    assert text.startswith(mistake[1])


def test_all_mistakes_are_told_at_once():
    assert len(mistakes({"adc_volts": -1, "adc_counts": True, "pulses": 1})) == 3
