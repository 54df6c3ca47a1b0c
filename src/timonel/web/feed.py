"""What changed, for each who looks: everybody gets the newest, nobody a queue.

```
feed.update(topics, now)        # 10 to 20 times a second
feed.snapshot(you, now)         # for who has nothing yet
feed.since(sequence, now)       # for who has seen everything up to `sequence`
```
A topic is put into words once when it changes, and what several readers lack is put together once for all of them.
"""

import struct
from collections.abc import Mapping
from typing import Any, Literal

import msgspec

from timonel.web.messages import Changes, Snapshot, You
from timonel.web.state import seconds

TEXT = 0x81  # a frame that is the whole of a text
SILENCE = 1.0  # s after which a message without news says that we are here


def framed(text: bytes) -> bytes:
    """A text as a server sends it (RFC 6455, 5.2)."""
    size = len(text)
    if size < 126:
        return b"%c%c%b" % (TEXT, size, text)
    wide = struct.pack(">BBH", TEXT, 126, size) if size < 65536 else struct.pack(">BBQ", TEXT, 127, size)
    return wide + text


class Entry(msgspec.Struct):
    """A topic: its value, its words, and the number of the message that it changed with."""

    value: Any
    words: msgspec.Raw
    changed: int


class Feed:
    """The topics of one vehicle, and when they changed."""

    def __init__(self, vehicle: Literal["boat", "rover"], name: str) -> None:
        self.sequence = 0
        self.clock = 0.0
        self.vehicle: Literal["boat", "rover"] = vehicle
        self.name = name
        self._topics: dict[str, Entry] = {}
        self._said: dict[int, bytes] = {}

    def update(self, topics: Mapping[str, Any], now: float) -> bool:
        """Take over what changed; whether there is something to say."""
        changed = [name for name, value in topics.items() if self._differs(name, value)]
        if not changed and now < self.clock + SILENCE:
            return False
        self.sequence += 1
        self.clock = now
        self._said.clear()
        for name in changed:
            self._topics[name] = Entry(topics[name], msgspec.Raw(msgspec.json.encode(topics[name])), self.sequence)
        return True

    def _differs(self, name: str, value: Any) -> bool:
        entry = self._topics.get(name)
        return entry is None or entry.value != value

    def snapshot(self, you: You) -> bytes:
        """Everything."""
        words = {name: entry.words for name, entry in self._topics.items()}
        snapshot = Snapshot(self.sequence, seconds(self.clock), self.vehicle, self.name, you, words)
        return msgspec.json.encode(snapshot)

    def since(self, sequence: int) -> bytes:
        """What changed after the message numbered `sequence`, as a frame of the socket."""
        said = self._said.get(sequence)
        if said is None:
            words = {name: entry.words for name, entry in self._topics.items() if entry.changed > sequence}
            changes = Changes(sequence, self.sequence, seconds(self.clock), words)
            said = self._said[sequence] = framed(msgspec.json.encode(changes))
        return said
