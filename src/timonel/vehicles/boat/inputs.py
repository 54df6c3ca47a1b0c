"""The instruments of a boat beside her backbone, and the order of all that tell her something.

It belongs to a boat that has ports of instruments, or whose owner has a say in the order of sources; another one does
without, and is as fast as ever. What is decided here is carried out by `vehicle`.
"""

from collections.abc import Iterable, Sequence

import msgspec

from timonel.core.effects import Effect, Event
from timonel.core.message import Message
from timonel.nmea0183.checksum import Fault
from timonel.nmea0183.registry import parse
from timonel.vehicles.boat.derived import Derived
from timonel.vehicles.boat.instruments import FORMATTERS, Instruments, Messages
from timonel.vehicles.boat.onto_bus import Echoes, OntoBus, data
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.sources import Sources, SourceSettings
from timonel.vehicles.boat.truth import Truth

DAMAGED = frozenset({Fault.WRONG_CHECKSUM, Fault.NO_CHECKSUM, Fault.MALFORMED})


def sources(settings: BoatSettings, ports: Iterable[Port]) -> Sources | None:
    """The order of the sources, if the boat needs one."""
    instruments = [port.name for port in ports if port.instrument]
    if settings.sources is None and not instruments:
        return None
    return Sources(settings.sources or SourceSettings(), instruments)


class Ruler(msgspec.Struct, frozen=True):
    """Who rules a datum: a NAME, a port or `derived`, and when it was last told, s."""

    source: str
    heard: float


class Inputs:
    """What comes in by the ports of instruments, and what of it the bus gets."""

    def __init__(self, settings: BoatSettings, sources: Sources, truth: Truth, now: float) -> None:
        self.sources = sources
        self._truth = truth
        self._instruments = Instruments({name: sources.depth_offset(name) for name in sources.ports})
        self._onto_bus = OntoBus(truth, sources, settings.max_age, now)
        self._echoes = Echoes()
        self._derived = Derived(() if settings.sources is None else settings.sources.derive, truth, settings.max_age)

    def wants(self, sentence: bytes) -> bool:
        """Whether it is one that instruments say."""
        return sentence[3:6] in FORMATTERS and sentence[6:7] == b","

    def read(self, sentence: bytes, port: str, now: float) -> Messages | Fault:
        """What a sentence of an instrument tells, or why it tells nothing."""
        typed = parse(sentence)
        self.sources.sentence(port, typed not in DAMAGED)
        return typed if isinstance(typed, Fault) else self._instruments.receive(typed, port, now)

    def is_echo(self, sentence: bytes, now: float) -> bool:
        """Whether we said the same of late."""
        return self._echoes.has(sentence, now)

    def rules(self, message: Message, source: int) -> bool:
        """Whether `source` is the one that is listened to for what `message` tells."""
        return self._onto_bus.rules(message, source)

    def admits(self, message: Message, source: int, now: float) -> bool:
        """Whether a port is heard for what `message` tells."""
        return self._onto_bus.admits(message, source, now)

    def allow(self, message: Message, source: int, now: float) -> bool:
        """Whether the bus gets `message`."""
        return self._onto_bus.allow(message, source, now)

    def heard(self, message: Message, source: int, said: Sequence[Effect], now: float) -> list[Event]:
        """`message` was heard and brought `said` about; what has changed by it. Runs once a message."""
        self._onto_bus.heard(message, source, now)
        if said:
            self._echoes.note(said, now)
        if not self.sources.changes:
            return []
        changes, self.sources.changes = self.sources.changes, []
        return changes

    def derive(self, message: Message, now: float) -> list[Message]:
        """What is computed now that `message` came."""
        return self._derived.receive(message, now)


def rulers(truth: Truth, sources: Sources | None) -> dict[str, Ruler]:
    """Who rules which datum, of those that were ever told."""
    label = address if sources is None else sources.label
    return {name: Ruler(label(datum.source), datum.heard) for name, datum in data(truth).items() if datum.source >= 0}


def address(source: int) -> str:
    """A source of a boat whose sources have no order."""
    return f"address {source}"
