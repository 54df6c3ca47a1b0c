"""Magnetic variation from the World Magnetic Model, for boats whose bus does not tell it.

The model is one of the five-year models of pygeomag, WMM 2010 to 2025, whichever covers the date; earlier dates are
taken as 2010.0 and later ones as 2030.0, the ends of what they cover. Over a tenth of a degree and a month the
variation changes by less than the model's own uncertainty of half a degree (WMM 2025 technical report), except near the
magnetic poles, so it is worked out once for each such cell.
"""

from functools import lru_cache
from math import radians
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pygeomag import GeoMag

MODELS = {2010: "WMM_2010", 2015: "WMM_2015v2", 2020: "WMM_2020", 2025: "WMM_2025"}  # by first year
FIRST, LAST, SPAN = min(MODELS), max(MODELS), 5
YEAR = 365.2425 * 86400  # s
MONTHS = 12


def variation(latitude_deg: float, longitude_deg: float, unix_seconds: float) -> float:
    """Variation at sea level in rad, east positive. Raises ValueError beyond the poles and for no numbers."""
    month = int((1970 + unix_seconds / YEAR) * MONTHS)
    month = max(FIRST * MONTHS, min(month, (LAST + SPAN) * MONTHS))
    if not abs(latitude_deg) <= 90:
        raise ValueError(f"latitude {latitude_deg}")
    return _in_cell(round(latitude_deg * 10), round((longitude_deg + 180) % 360 * 10), month)


@lru_cache(maxsize=1024)
def _in_cell(tenths_north: int, tenths_east: int, month: int) -> float:
    year = month / MONTHS
    model = _model(min(LAST, int(year) // SPAN * SPAN))
    return radians(model.calculate(tenths_north / 10, tenths_east / 10 - 180, 0.0, year).d)


@lru_cache
def _model(first_year: int) -> "GeoMag":
    from pygeomag import GeoMag

    return GeoMag(coefficients_file=f"wmm/{MODELS[first_year]}.COF")
