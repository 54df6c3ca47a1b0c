"""Which messages are meant by names and numbers."""

from collections.abc import Iterable

import msgspec

from timonel.core.mistakes import did_you_mean
from timonel.errors import RecordingError
from timonel.nmea2000 import catalogue
from timonel.vehicles.rover.protocol import Protocol

_GATEWAYS = 1 << 18  # canboat: PGNs from here on are a gateway's own


class Wanted(msgspec.Struct, frozen=True):
    """PGNs and standard identifiers to be read, None for all; and of them the `names` to be kept, None for all."""

    pgns: frozenset[int] | None = None
    standard: frozenset[int] | None = None
    names: frozenset[str | None] | None = None


def wanted(words: Iterable[str], protocol: Protocol) -> Wanted:
    """PGNs (`127250`), canboat's names (`vesselHeading`), a rover's frames (`104`, `MotorCurrentRight`).

    Raises RecordingError for a word that is nothing of the kind, with what may have been meant.
    """
    frames = {declared.__name__: number for number, declared in protocol.declarations.items()}
    pgns: set[int] = set()
    standard: set[int] = set()
    names: set[str | None] = set()
    for word in words:
        if word.isdigit():
            number = int(word)
            if number >= _GATEWAYS:
                raise RecordingError(f"{number} is no PGN of a bus: the highest is {_GATEWAYS - 1}")
            (standard if number < 0x800 else pgns).add(number)
            names |= _names_of(number, protocol)
        elif word in frames:
            standard.add(frames[word])
            names.add(word)
        else:
            pgns |= _pgns_of(word, frames)
            names.add(word)
    if not (pgns or standard):
        return Wanted()
    return Wanted(frozenset(pgns), frozenset(standard), frozenset(names))


def _names_of(number: int, protocol: Protocol) -> set[str | None]:
    """What messages of a number can be called; None for what has no name."""
    if number < 0x800:
        declared = protocol.declaration(number)
        return {declared.__name__, None} if declared else {None}
    return {None, *(definition.id for definition in catalogue.candidates(number))}


def _pgns_of(name: str, frames: Iterable[str]) -> set[int]:
    """The PGNs that can be a message of this name: one, but for those that stand for a range."""
    known = catalogue.identifiers()
    if name not in known:
        raise RecordingError(f'no message is called "{name}"{did_you_mean(name, [*known, *frames])}')
    pgn = known[name]
    first, last = catalogue.FALLBACKS.get(pgn, (pgn, pgn))
    definition = catalogue.by_id(name)
    return set(range(first, last + 1)) if definition.fallback else {pgn}
