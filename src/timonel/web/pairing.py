"""How a console becomes a station: by six digits that only those see who may decide.

```
the console       asks to be a station
the gateway       shows six digits to the station in command, to admins, and in its log; for two minutes
the console       tells the digits, and is that station from then on
```
Who tells them was told by somebody at the helm or at the gateway. Three wrong ones, two minutes or a refusal end it.
"""

import hmac
import itertools
import secrets
from collections.abc import Callable

import msgspec

LIFETIME = 120.0  # s
GUESSES = 3
AT_ONCE = 8  # that may wait at the same time


class Asked(msgspec.Struct):
    """Somebody at `address` who calls himself `name` wants to be `station`, until `deadline` (s)."""

    number: int
    station: int
    name: str
    address: str
    code: str
    deadline: float
    guesses: int = GUESSES


class Pairings:
    """Those who ask. `began` and `ended` are told of each."""

    def __init__(self, began: Callable[[Asked], object], ended: Callable[[Asked], object]) -> None:
        self._began = began
        self._ended = ended
        self._asked: dict[int, Asked] = {}
        self._numbers = itertools.count(secrets.randbelow(2**40))

    def waiting(self, now: float) -> list[Asked]:
        """Those that wait at `now` (s)."""
        for asked in [each for each in self._asked.values() if now >= each.deadline]:
            self._end(asked)
        return list(self._asked.values())

    def ask(self, station: int, name: str, address: str, now: float) -> Asked | None:
        """A console asks; None if too many do. Who asks again forgets what he asked before."""
        for asked in self.waiting(now):
            if asked.address == address and asked.station == station:
                self._end(asked)
        if len(self._asked) >= AT_ONCE:
            return None
        code = f"{secrets.randbelow(1_000_000):06d}"
        asked = Asked(next(self._numbers), station, name, address, code, now + LIFETIME)
        self._asked[asked.number] = asked
        self._began(asked)
        return asked

    def tell(self, number: int, code: str, now: float) -> int | None:
        """The digits; the station, or None if they are wrong or too late."""
        self.waiting(now)
        asked = self._asked.get(number)
        if asked is None:
            return None
        if hmac.compare_digest(asked.code.encode(), code.encode()):
            self._end(asked)
            return asked.station
        asked.guesses -= 1
        if not asked.guesses:
            self._end(asked)
        return None

    def refuse(self, number: int) -> bool:
        """That one is not to be; whether it still asked."""
        asked = self._asked.get(number)
        if asked is not None:
            self._end(asked)
        return asked is not None

    def _end(self, asked: Asked) -> None:
        self._asked.pop(asked.number, None)
        self._ended(asked)
