"""Writes docs/pgns.md, the layouts of all declared PGNs, from their declarations."""

from pathlib import Path

from timonel.core.reference import section
from timonel.nmea2000.registry import variants

PAGE = Path(__file__).parents[1] / "docs" / "pgns.md"
INTRODUCTION = """# PGNs

Written by `scripts/make_reference.py` from the declarations in `timonel.nmea2000.messages`; do not edit.

`bit` is where a field begins, counted from the lowest bit of the first byte; numbers are little-endian. Fields
are numbered as PGN 126208 counts them. The highest values of a number or a list are those that mean "not
available", "out of range" and "reserved"; they read as None, and None is sent as "not available". Angles are in
rad, temperatures in K, all else in SI as the table says; positions are in degrees, dates in days since
1970-01-01, times in s since midnight UTC.
"""


def page() -> str:
    return "\n".join([INTRODUCTION, *map(section, variants())])


if __name__ == "__main__":
    PAGE.write_text(page())
