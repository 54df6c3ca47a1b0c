"""How often a thing may happen: ceilings that let a jittering source through at its own rate."""


class Pace:
    """A ceiling of one event each `interval` seconds on average, and never a burst of more than two.

    Virtual scheduling (ITU-T I.371, generic cell rate algorithm) with a tolerance of one interval: an event may
    come early, and the next is due that much later. A 10 Hz source whose events come early or late by less than
    half an interval passes a 10 Hz ceiling whole; a plain "at least 100 ms since the last" lets half of it
    through.
    """

    __slots__ = ("_due", "interval", "opens")

    def __init__(self, interval: float) -> None:
        self.interval = interval
        self.opens = self._due = float("-inf")
        """When the next event is within the ceiling, s."""

    def open(self, now: float) -> bool:
        """Whether an event at `now` (s) is within the ceiling."""
        return now >= self.opens

    def count(self, now: float) -> None:
        """An event happened at `now`."""
        self.opens = now if now > self._due else self._due
        self._due = self.opens + self.interval


class Allowance:
    """At most `count` events in any `window` of seconds; the rest is refused."""

    def __init__(self, count: int, window: float = 1.0) -> None:
        self.count = count
        self.window = window
        self._past: list[float] = []

    def take(self, now: float) -> bool:
        """Whether one more event at `now` (s) is allowed."""
        past = self._past
        while past and past[0] <= now - self.window:
            del past[0]
        if len(past) >= self.count:
            return False
        past.append(now)
        return True
