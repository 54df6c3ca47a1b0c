from datetime import UTC, datetime
from math import degrees

import pytest

from timonel.gateway.variation import variation


def at(year: int, month: int = 1) -> float:
    return datetime(year, month, 15, tzinfo=UTC).timestamp()


@pytest.mark.parametrize(
    ("latitude", "longitude", "year", "expected"),
    [  # test values of the WMM reports for altitude 0 and the first of January, deg
        (80.0, 0.0, 2025, 1.28),
        (0.0, 120.0, 2025, -0.16),
        (-80.0, -120.0, 2025, 68.78),
        (80.0, 0.0, 2020, -1.28),
        (0.0, 120.0, 2020, 0.16),
        (-80.0, -120.0, 2020, 69.36),
    ],
)
def test_the_variation_is_that_of_the_model(latitude: float, longitude: float, year: int, expected: float) -> None:
    assert degrees(variation(latitude, longitude, at(year))) == pytest.approx(expected, abs=0.05)


def test_a_recording_of_2016_gets_the_model_of_2015() -> None:
    seattle = degrees(variation(47.6205, -122.3493, at(2016, 6)))
    assert seattle == pytest.approx(15.9, abs=0.15)
    assert seattle > degrees(variation(47.6205, -122.3493, at(2025))) + 0.5


def test_dates_that_no_model_covers_get_the_nearest_that_one_does() -> None:
    assert variation(40.0, 0.0, at(1990)) == variation(40.0, 0.0, at(2010))
    assert variation(40.0, 0.0, at(2060)) == variation(40.0, 0.0, at(2030))


def test_both_names_of_the_date_line_are_one_place() -> None:
    assert variation(10.0, 180.0, at(2026)) == variation(10.0, -180.0, at(2026))


def test_the_poles_have_a_value() -> None:
    assert -180 <= degrees(variation(90.0, 0.0, at(2026))) <= 180


@pytest.mark.parametrize("latitude", [90.1, float("nan")])
def test_a_latitude_that_is_none_is_refused(latitude: float) -> None:
    with pytest.raises(ValueError, match="latitude"):
        variation(latitude, 0.0, at(2026))
