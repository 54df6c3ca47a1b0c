"""What a broker is to know: of what stands the newest, of what happened the last, however long it does not listen.

```
board.put("boat/heading", b"...")     # stands there from now on; b"" takes it back
board.tell("boat/event", b"...")      # happened
while (news := board.next()) is not None:
    ...                               # publish it, then
    board.told(news)
```
"""

from collections import deque

import msgspec

EVENTS = 64  # that wait


class News(msgspec.Struct, frozen=True):
    """Something to publish. What is `retained` stands at its topic for those who come later."""

    topic: str
    payload: bytes
    retained: bool


class Board:
    """Never waits and never grows: there are so many topics, and so many events."""

    def __init__(self) -> None:
        self.dropped = 0
        """Events that nobody will hear of."""
        self._standing: dict[str, bytes] = {}
        self._unknown: dict[str, None] = {}
        self._happened: deque[News] = deque(maxlen=EVENTS)

    def put(self, topic: str, payload: bytes) -> None:
        """It is so from now on; b"" takes back what stood there."""
        if self._standing.get(topic) != payload:
            self._standing[topic] = payload
            self._unknown[topic] = None

    def tell(self, topic: str, payload: bytes) -> None:
        """Something happened."""
        self.dropped += len(self._happened) == EVENTS
        self._happened.append(News(topic, payload, retained=False))

    def forget(self) -> None:
        """Somebody listens who may know nothing."""
        self._unknown = dict.fromkeys(self._standing)

    def next(self) -> News | None:
        """What is to be published now, first what stands; None if all is known."""
        for topic in self._unknown:
            return News(topic, self._standing[topic], retained=True)
        return self._happened[0] if self._happened else None

    def told(self, news: News) -> None:
        """That is known."""
        if not news.retained:
            if self._happened and self._happened[0] is news:
                self._happened.popleft()
        elif self._standing[news.topic] == news.payload:  # else it has changed meanwhile
            self._unknown.pop(news.topic, None)
