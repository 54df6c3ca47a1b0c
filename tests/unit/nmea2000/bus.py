"""A bus for tests: nodes that hear each other, each told the time by the test."""

from timonel.core.effects import Effect, Transmit
from timonel.core.frame import Frame
from timonel.core.message import Message
from timonel.nmea2000 import registry
from timonel.nmea2000.devices import Devices
from timonel.nmea2000.fastpacket import Reassembler
from timonel.nmea2000.identifier import Identifier, split
from timonel.nmea2000.node import Node, NodeSettings
from timonel.nmea2000.sender import Outgoing, Sender, outgoing

STEP = 0.01  # s


def frames_of(effects: list[Effect]) -> list[Frame]:
    return [effect.frame for effect in effects if isinstance(effect, Transmit)]


def events_of(effects: list[Effect]) -> list[Effect]:
    return [effect for effect in effects if not isinstance(effect, Transmit)]


class Ear:
    """Puts frames together to messages."""

    def __init__(self) -> None:
        self._reassembler = Reassembler(0.25)

    def hear(self, frame: Frame, now: float) -> tuple[Identifier, bytes] | None:
        target = split(frame.identifier)
        fast = registry.is_fast(target.pgn)
        payload = self._reassembler.receive(frame.identifier, frame.data, now) if fast else frame.data
        return None if payload is None else (target, payload)


class End:
    """A node with what it needs; `happened` are its events."""

    def __init__(self, settings: NodeSettings | None, address: int = 35, now: float = 0.0) -> None:
        self.devices = Devices()
        self.sender = Sender(address)
        self.node = Node(settings, self.sender, self.devices, now)
        self.happened: list[Effect] = []
        self._ear = Ear()

    def hear(self, frame: Frame, now: float) -> list[Frame]:
        heard = self._ear.hear(frame, now)
        if heard is None:
            return []
        target, payload = heard
        message = registry.decode(target.pgn, payload)
        return self._done(self.node.receive(target.pgn, message, payload, target.source, target.destination, now))

    def expire(self, now: float) -> list[Frame]:
        return self._done(self.node.expire(now)) if now >= self.node.deadline else []

    def _done(self, effects: list[Effect]) -> list[Frame]:
        self.happened += events_of(effects)
        return frames_of(effects)


class Bus:
    """Ends on one wire, and all that was said on it, with its time."""

    def __init__(self, *ends: End) -> None:
        self.ends = list(ends)
        self.now = 0.0
        self.said: list[tuple[float, Identifier, bytes]] = []
        self._ear = Ear()

    def run(self, until: float) -> None:
        """Let time pass, in steps of 10 ms."""
        while self.now < until - 1e-9:
            self.now = round(self.now + STEP, 6)
            for end in self.ends:
                self._carry(end.expire(self.now), end)

    def _carry(self, frames: list[Frame], sender: End | None) -> None:
        waiting = [(frame, sender) for frame in frames]
        while waiting:
            frame, source = waiting.pop(0)
            if (heard := self._ear.hear(frame, self.now)) is not None:
                self.said.append((self.now, *heard))
            for end in self.ends:
                if end is not source:
                    waiting += [(answer, end) for answer in end.hear(frame, self.now)]

    def say(self, message: Message | Outgoing, source: int, destination: int = 255) -> list[tuple[Identifier, bytes]]:
        """Somebody with this address says it; what is said after it at once."""
        before = len(self.said)
        words = message if isinstance(message, Outgoing) else outgoing(message, destination)
        self._carry(Sender(source).frames(words), None)
        return [(target, payload) for _, target, payload in self.said[before + 1 :]]

    def claim(self, name: int, source: int) -> list[tuple[Identifier, bytes]]:
        """Somebody claims an address."""
        return self.say(Outgoing(60928, name.to_bytes(8, "little")), source)

    def heard(self, pgn: int) -> list[tuple[float, Identifier, bytes]]:
        """All that was said of one PGN."""
        return [(now, target, payload) for now, target, payload in self.said if target.pgn == pgn]
