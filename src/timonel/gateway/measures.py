"""Sizes and times as people write them in a configuration: "64 MB", "1 h"."""

import re

SIZES = {"kB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12}
TIMES = {"s": 1, "min": 60, "h": 3600, "d": 86400}
_MEASURE = re.compile(r"\s*(\d+(?:\.\d+)?)\s*([A-Za-z]+)\s*")


def size(text: str) -> int:
    """Bytes; raises ValueError that says what would be right."""
    return round(_measure(text, SIZES, 'a size like "64 MB"'))


def duration(text: str) -> float:
    """Seconds; raises ValueError that says what would be right."""
    return _measure(text, TIMES, 'a time like "1 h"')


def _measure(text: str, units: dict[str, int], wanted: str) -> float:
    match = _MEASURE.fullmatch(text)
    value = float(match[1]) * units.get(match[2], 0) if match else 0.0
    if not value:
        raise ValueError(f'"{text}" should be {wanted} ({", ".join(units)})')
    return value
