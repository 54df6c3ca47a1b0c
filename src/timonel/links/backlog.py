"""What waits for room on a port that cannot keep up.

```
order   what                              when it is full
first   the rest of a line cut in two     (always one at most: a line is never torn)
then    urgent lines, oldest first        the oldest is dropped and counted; one that tells a state as a whole
                                          takes away an older one of its key, and comes last itself
then    the newest line of each key       replaced in its place by a newer one of that key, and counted
```
A key keeps its place when its line is replaced, so a busy key cannot be put off for ever by the others.
"""

from collections import deque
from collections.abc import Iterable
from itertools import chain

from timonel.core.effects import Say
from timonel.links.link import Counters

URGENT_MAX = 256
KEYS_MAX = 512


class Backlog:
    """The lines that wait; true while there is one."""

    def __init__(self, tally: Counters, *, urgent_max: int = URGENT_MAX) -> None:
        self._tally = tally
        self._urgent_max = urgent_max
        self._cut = b""
        self._urgent: deque[Say] = deque()
        self._newest: dict[str, bytes] = {}

    def __bool__(self) -> bool:
        return bool(self._cut or self._urgent or self._newest)

    def add(self, lines: Iterable[Say]) -> None:
        for say in lines:
            if say.urgent:
                self._add_urgent(say)
            else:
                self._add_newest(say.key, say.line)

    def _add_urgent(self, say: Say) -> None:
        if say.state:
            waiting = len(self._urgent)
            self._urgent = deque(older for older in self._urgent if not (older.state and older.key == say.key))
            self._tally.replaced += waiting - len(self._urgent)
        if len(self._urgent) == self._urgent_max:
            self._urgent.popleft()
            self._tally.dropped += 1
        self._urgent.append(say)

    def _add_newest(self, key: str, line: bytes) -> None:
        if key in self._newest:
            self._tally.replaced += 1
        elif len(self._newest) == KEYS_MAX:
            self._newest.pop(next(iter(self._newest)))
            self._tally.dropped += 1
        self._newest[key] = line

    def keep(self, lines: Iterable[Say], written: int) -> None:
        """Add what is left of `lines` after their first `written` bytes; nothing may be waiting."""
        for say in lines:
            if written <= 0:
                self.add((say,))
            elif written < len(say.line):
                self._cut = say.line[written:]
            written -= len(say.line)

    def head(self, room: int) -> bytes:
        """What should be written next: whole lines from the front until `room` bytes are filled."""
        lines: list[bytes] = []
        for line in chain((self._cut,), (say.line for say in self._urgent), self._newest.values()):
            if room <= 0:
                break
            lines.append(line)
            room -= len(line)
        return b"".join(lines)

    def written(self, count: int) -> None:
        """Forget the first `count` bytes of what `head` gave."""
        while count > 0:
            line = self._pop()
            self._cut = line[count:]
            count -= len(line)

    def _pop(self) -> bytes:
        if self._cut:
            return self._cut
        if self._urgent:
            return self._urgent.popleft().line
        return self._newest.pop(next(iter(self._newest)))

    def clear(self) -> None:
        """Drop and count every line of which nothing was written yet."""
        self._tally.dropped += len(self._urgent) + len(self._newest)
        self._urgent.clear()
        self._newest.clear()
