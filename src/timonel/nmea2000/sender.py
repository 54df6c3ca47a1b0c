"""From messages to frames of the bus: our address, a priority, and fast packets with counters of their own."""

from functools import lru_cache

import msgspec

from timonel.core.effects import Effect, Transmit
from timonel.core.frame import Frame
from timonel.core.message import Message
from timonel.nmea2000.fastpacket import HEADS, cut
from timonel.nmea2000.identifier import GLOBAL, join
from timonel.nmea2000.schedule import is_fast, priority


class Outgoing(msgspec.Struct, frozen=True, gc=False):
    """A message on its way out, before it has an address to come from. `priority` None is the PGN's own."""

    pgn: int
    payload: bytes
    destination: int = GLOBAL
    priority: int | None = None


def outgoing(message: Message, destination: int = GLOBAL) -> Outgoing:
    """A declared message to one device, or to everybody."""
    assert message.PGN is not None
    return Outgoing(message.PGN, message.encode(), destination)


@lru_cache(maxsize=1024)
def _way(pgn: int, urgency: int | None, address: int, destination: int) -> tuple[int, bool]:
    """The identifier, and whether it travels as fast packet."""
    return join(priority(pgn) if urgency is None else urgency, pgn, address, destination), is_fast(pgn)


class Sender:
    """Makes frames that come from `address`, which may change while we run."""

    def __init__(self, address: int) -> None:
        self.address = address
        self._sequences: dict[int, int] = {}

    def transmit(self, message: Outgoing) -> list[Effect]:
        """Put one message on the bus. Runs between a station's key and the rudder: keep it short.

        The counter of a PGN's fast packets turns with each message. Raises EncodeError for a payload above 223 bytes.
        """
        pgn = message.pgn
        identifier, fast = _way(pgn, message.priority, self.address, message.destination)
        if not fast:
            return [Transmit(Frame(identifier, message.payload))]
        sequence = self._sequences.get(pgn, 0)
        self._sequences[pgn] = (sequence + 1) % 8
        heads = HEADS[sequence]
        effects: list[Effect] = []
        for index, part in enumerate(cut(message.payload)):
            effects.append(Transmit(Frame(identifier, heads[index] + part)))
        return effects

    def frames(self, message: Outgoing) -> list[Frame]:
        """The frames of one message, as `transmit` puts them on the bus."""
        return [effect.frame for effect in self.transmit(message) if type(effect) is Transmit]
