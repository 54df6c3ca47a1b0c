"""Long messages in the manner of ISO 11783-3: announced to everybody (BAM) and sent in packets of seven bytes.

NMEA 2000 has fast packets for its own messages; what still comes this way is the commanded address (65240).

60416   byte 0 32 (BAM), 1..2 size, 3 packets, 4 255, 5..7 PGN
60160   byte 0 number of the packet from 1, 1..7 data

A source has one message under way. Packets must follow each other in order and within 750 ms; what does not is
dropped and counted. Only the PGNs that are wanted are put together, of at most `SESSIONS` sources at a time.
Source: ISO 11783-3 as in canboat's `isoTransportProtocol...`; J1939-21's T1.
"""

from collections import Counter
from collections.abc import Collection

import msgspec

CONTROL = 60416
DATA = 60160
BROADCAST = 32
PACKET_AGE = 0.75  # s
SESSIONS = 16
LONGEST = 1785  # bytes, 255 packets


class Session(msgspec.Struct):
    """A message under way; `next` is the number of the packet that must come."""

    pgn: int
    size: int
    packets: int
    heard: float
    next: int = 1
    parts: bytes = b""


class Transport:
    """Puts together what is announced, of the PGNs in `wanted`."""

    def __init__(self, wanted: Collection[int]) -> None:
        self.counters: Counter[str] = Counter()
        self._wanted = wanted
        self._sessions: dict[int, Session] = {}

    def receive(self, pgn: int, data: bytes, source: int, now: float) -> tuple[int, bytes] | None:
        """One frame of 60416 or 60160 to everybody; the PGN and payload of the message that it completes."""
        if pgn == CONTROL:
            self._announced(data, source, now)
            return None
        return self._packet(data, source, now)

    def _announced(self, data: bytes, source: int, now: float) -> None:
        if len(data) < 8 or data[0] != BROADCAST:
            return
        if self._sessions.pop(source, None) is not None:
            self.counters["transport: begun anew"] += 1
        pgn, size, packets = int.from_bytes(data[5:8], "little"), int.from_bytes(data[1:3], "little"), data[3]
        if pgn not in self._wanted:
            return
        if not 8 < size <= LONGEST or packets != -(-size // 7):
            self.counters["transport: malformed"] += 1
            return
        if len(self._sessions) >= SESSIONS:
            del self._sessions[next(iter(self._sessions))]
            self.counters["transport: evicted"] += 1
        self._sessions[source] = Session(pgn, size, packets, now)

    def _packet(self, data: bytes, source: int, now: float) -> tuple[int, bytes] | None:
        session = self._sessions.get(source)
        if session is None:
            return None
        if len(data) < 8 or data[0] != session.next or now > session.heard + PACKET_AGE:
            del self._sessions[source]
            self.counters["transport: broken"] += 1
            return None
        session.next, session.heard, session.parts = session.next + 1, now, session.parts + data[1:8]
        if session.next <= session.packets:
            return None
        del self._sessions[source]
        return session.pgn, session.parts[: session.size]
