"""The machine's time as a recording can hold it: a whole number of microseconds.

For 71 years of uptime (2**51 us) the way from a moment to its microseconds and back gives the same bits.
"""

A_SECOND = 1_000_000


def moment(seconds: float) -> float:
    """The machine's time, in s, of a clock's."""
    return round(seconds * A_SECOND) / A_SECOND


def microseconds(now: float) -> int:
    """A moment in whole microseconds."""
    return round(now * A_SECOND)


def seconds(us: int) -> float:
    """The moment of so many microseconds, in s."""
    return us / A_SECOND
