"""A frame of 9 to 15 bytes on classic CAN: two frames of one identifier, the first full, the rest behind it.

Their lengths tell which is which. A half without its partner is dropped and counted. Source: spec/rover.md, Frames.
"""

from collections.abc import Mapping

SINGLE = 8  # bytes, the most that one frame carries
LONGEST = 15  # bytes; a rest of 8 would look like a first half
PARTNER = 0.02  # s in which the rest must follow its first half


def split(data: bytes) -> list[bytes]:
    """The halves in the order in which they are sent; up to 8 bytes are one frame."""
    return [data[:SINGLE], data[SINGLE:]] if len(data) > SINGLE else [data]


class Joiner:
    """Joins the halves of segmented frames, told the time; `lengths` are those of the whole frames by identifier."""

    def __init__(self, lengths: Mapping[int, int]) -> None:
        self._lengths = lengths
        self._halves: dict[int, tuple[bytes, float]] = {}
        self.dropped = 0

    def receive(self, identifier: int, data: bytes, now: float) -> bytes | None:
        """The whole frame once its second half comes."""
        self.expire(now)
        first, _ = self._halves.pop(identifier, (b"", now))
        if len(data) == SINGLE:
            self._halves[identifier] = data, now
            self.dropped += bool(first)
            return None
        if first and len(first + data) == self._lengths.get(identifier):
            return first + data
        self.dropped += 1 + bool(first)
        return None

    @property
    def deadline(self) -> float | None:
        """When `expire` is due."""
        return min((since + PARTNER for _, since in self._halves.values()), default=None)

    def expire(self, now: float) -> None:
        """Drop first halves whose rest did not come in time."""
        for late in [key for key, (_, since) in self._halves.items() if now >= since + PARTNER]:
            del self._halves[late]
            self.dropped += 1
