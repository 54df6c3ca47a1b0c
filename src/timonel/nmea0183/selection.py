"""Which sentences go out on one port, as whose, and how often.

```
of each line, in this order      only, but     it goes out on this port or not
                                 rates         not more often than so many times a second
                                 talkers       under another talker, with the check sum that belongs to it
urgent lines (STATUS, alerts)    pass a station's port whatever stands in `only`: who steers must know
```
A formatter is the three letters behind the talker, and of a proprietary sentence all behind the `$`: `PARP`.
Proprietary sentences and those that begin with `!` (AIS) keep their talker.
"""

from collections.abc import Sequence
from functools import lru_cache

import msgspec

from timonel.core.effects import Say
from timonel.core.pace import Pace
from timonel.nmea0183.checksum import checksum

NEVER = float("inf")


class Selection(msgspec.Struct, frozen=True):
    """What an owner says about one port. `only` None is all; `talkers` and `rates` (Hz) are by formatter.

    `talker` is for every formatter that is not in `talkers`, None leaves what the sentence has.
    """

    only: tuple[str, ...] | None = None
    but: tuple[str, ...] = ()
    talker: str | None = None
    talkers: dict[str, str] = {}
    rates: dict[str, float] = {}

    @property
    def all(self) -> bool:
        """Whether every line passes as it is."""
        return self == EVERYTHING


EVERYTHING = Selection()


class Hearing(msgspec.Struct, frozen=True):
    """What is heard of what a port says; `only` and `talkers` None are all of them."""

    only: tuple[str, ...] | None = None
    but: tuple[str, ...] = ()
    talkers: tuple[str, ...] | None = None

    def accepts(self, sentence: bytes) -> bool:
        """Whether a framed sentence is heard."""
        name = formatter(sentence)
        if (self.only is not None and name not in self.only) or name in self.but:
            return False
        return self.talkers is None or sentence[1:3].decode("latin-1") in self.talkers


def formatter(line: bytes) -> str:
    """The formatter of a line; of one that is no sentence something that no sentence has."""
    if line[1:2] == b"P":
        return line[1:].partition(b",")[0].decode("latin-1")
    return line[3:6].decode("latin-1")


class _Rule(msgspec.Struct):
    """What becomes of the lines with one beginning."""

    passes: bool
    pace: Pace | None
    talker: bytes | None


class Selector:
    """Applies a selection. `urgent_passes`: `only` and `but` say nothing about urgent lines."""

    def __init__(self, selection: Selection, urgent_passes: bool = False) -> None:
        self._selection = selection
        self._urgent_passes = urgent_passes
        self._paces = {name: Pace(1 / rate if rate else NEVER) for name, rate in selection.rates.items()}
        self._rules: dict[bytes, _Rule] = {}

    # Runs once a batch and port: one look-up a line.
    def choose(self, lines: Sequence[Say], now: float) -> list[Say]:
        """Those of `lines` that go out at `now` (s), as they go out."""
        chosen = []
        for say in lines:
            rule = self._rules.get(say.line[:6]) or self._rule(say.line)
            if not rule.passes and not (self._urgent_passes and say.urgent):
                continue
            pace = rule.pace
            if pace is not None:
                if pace.interval == NEVER or not pace.open(now):
                    continue
                pace.count(now)
            chosen.append(say if rule.talker is None else retold(say, rule.talker))
        return chosen

    def _rule(self, line: bytes) -> _Rule:
        wanted, name = self._selection, formatter(line)
        passes = (wanted.only is None or name in wanted.only) and name not in wanted.but
        talker = wanted.talkers.get(name, wanted.talker)
        own = line[:1] != b"$" or line[1:2] == b"P" or talker is None
        rule = _Rule(passes, self._paces.get(name), None if own or talker is None else talker.encode())
        if len(self._rules) < 1000:  # as many beginnings as we never say
            self._rules[line[:6]] = rule
        return rule


def retold(say: Say, talker: bytes) -> Say:
    """A line as another talker's."""
    return Say(with_talker(say.line, talker), say.key, say.urgent, say.state)


# A line goes to several ports one after the other, and most want the same talker.
@lru_cache(maxsize=256)
def with_talker(line: bytes, talker: bytes) -> bytes:
    """`line` (`$`, talker, ..., `*`, check sum, CR LF) from the talker of two letters, with its new check sum."""
    body, star, rest = line[1:].rpartition(b"*")
    if not star:
        return line
    body = talker + body[2:]
    return b"$%b*%02X%b" % (body, checksum(body), rest[2:])
