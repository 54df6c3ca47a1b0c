"""Which message a PGN is. How it travels, how urgent it is and how often it is sent is in `schedule`.

A PGN that is not declared has no message, but how it travels is known for every PGN.
"""

from collections.abc import Callable, Iterator
from functools import cache

from timonel.core.fields import Match
from timonel.core.message import Message
from timonel.nmea2000.messages import group_function
from timonel.nmea2000.messages.group_function import TARGETS, declared
from timonel.nmea2000.schedule import SCHEDULE as SCHEDULE
from timonel.nmea2000.schedule import interval as interval
from timonel.nmea2000.schedule import is_fast as is_fast
from timonel.nmea2000.schedule import priority as priority

Decoder = Callable[[bytes], Message | None]

HEAD = 8  # the bytes in which all that tells variants apart stands

MESSAGES: dict[int, list[type[Message]]] = TARGETS | declared(group_function)


def decode(pgn: int, data: bytes) -> Message | None:
    """The message in the payload `data`; None for a PGN, or a variant of it, that is not declared."""
    decoder_of_pgn = decoder(pgn)
    return decoder_of_pgn(data) if decoder_of_pgn else None


@cache
def decoder(pgn: int) -> Decoder | None:
    """The function that decodes payloads of a PGN, for the hot path; None for a PGN that is not declared."""
    variants = [(*_pattern(message), message) for message in MESSAGES.get(pgn, ())]
    if not variants:
        return None
    for _, _, message in variants:
        message.decode(b"")  # generates its codec
    if variants[0][0] == 0:
        return variants[0][2].decode
    choices = [(mask, value, message.decode) for mask, value, message in sorted(variants, key=_specific)]

    def select(data: bytes) -> Message | None:
        head = int.from_bytes(data[:HEAD], "little")
        for mask, value, decode_variant in choices:
            if head & mask == value:
                return decode_variant(data)
        return None

    return select


def _specific(variant: tuple[int, int, type[Message]]) -> int:
    """Variants that ask for more come first."""
    return -variant[0].bit_count()


def _pattern(message: type[Message]) -> tuple[int, int]:
    """The bits of a payload's head that a variant asks for, and what they must be."""
    mask = value = 0
    for slot in message.layout:
        if isinstance(slot.field, Match) and slot.offset is not None:
            mask |= slot.field.ones << slot.offset
            value |= int(slot.default) << slot.offset
    return mask, value


def variants() -> Iterator[type[Message]]:
    """Every declared message, by PGN."""
    for pgn in sorted(MESSAGES):
        yield from MESSAGES[pgn]
