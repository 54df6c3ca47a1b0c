"""Which message a PGN is, how it travels, how urgent it is and how often it is sent.

A PGN that is not declared has no message, but how it travels is known for every PGN: by its range (canboat's
fallback definitions), and where NMEA 2000 mixes both by the table `FAST`.
"""

from collections.abc import Callable, Iterator
from functools import cache

from timonel.core.fields import Match
from timonel.core.message import Message
from timonel.nmea2000.messages import group_function
from timonel.nmea2000.messages.group_function import TARGETS, declared

Decoder = Callable[[bytes], Message | None]

DEFAULT_PRIORITY = 6
HEAD = 8  # the bytes in which all that tells variants apart stands

MESSAGES: dict[int, list[type[Message]]] = TARGETS | declared(group_function)

# Of 126976..130815, where single frames and fast packets are mixed; source: canboat, `Type`.
FAST = frozenset(
    pgn
    for first, last in (
        (126983, 126988), (126996, 126996), (126998, 126998), (127233, 127233), (127237, 127237),
        (127489, 127491), (127494, 127498), (127503, 127504), (127506, 127507), (127509, 127514),
        (128275, 128275), (128520, 128520), (128538, 128538), (129029, 129029), (129038, 129041),
        (129044, 129045), (129284, 129285), (129301, 129302), (129538, 129538), (129540, 129542),
        (129545, 129545), (129547, 129547), (129549, 129549), (129551, 129551), (129556, 129556),
        (129792, 129816), (130052, 130054), (130060, 130061), (130064, 130074), (130320, 130324),
        (130329, 130330), (130561, 130575), (130577, 130578), (130580, 130581), (130583, 130584),
        (130586, 130586),
    )
    for pgn in range(first, last + 1)
)  # fmt: skip

# Priority, and interval in s (None: on event); source: canboat, `Priority` and `TransmissionInterval`. What
# canboat does not know has priority 7, as the recordings show it.
SCHEDULE: dict[int, tuple[int, float | None]] = {
    59392: (6, None), 59904: (6, None), 60928: (6, None), 65240: (6, None),
    65288: (7, None), 65305: (7, 1.0), 65340: (3, 1.0), 65341: (6, None), 65345: (7, None), 65359: (7, None),
    65360: (7, None), 65361: (7, None), 65379: (7, None), 65384: (7, None),
    126208: (3, None), 126464: (6, None), 126720: (7, None), 126983: (2, None), 126984: (2, None),
    126985: (2, None), 126992: (3, 1.0), 126993: (7, 60.0), 126996: (6, None), 126998: (6, None),
    127237: (2, 0.25), 127245: (2, 0.1), 127250: (2, 0.1), 127251: (2, 0.1), 127257: (3, 1.0),
    127258: (7, 1.0),
    128259: (2, 1.0), 128267: (3, 1.0), 128275: (6, 1.0),
    129025: (2, 0.1), 129026: (2, 0.25), 129029: (3, 1.0), 129033: (3, 1.0),
    129283: (3, 1.0), 129284: (3, 1.0), 129285: (6, None),
    130306: (2, 0.1), 130310: (5, 0.5), 130311: (5, 0.5), 130312: (5, 2.0), 130316: (5, 2.0),
    130850: (2, None), 130851: (7, None),
}  # fmt: skip


def is_fast(pgn: int) -> bool:
    """Whether a PGN travels as fast packet. ISO transport (65240) is not one."""
    return 0x1ED00 <= pgn <= 0x1EFFF or 0x1FF00 <= pgn <= 0x1FFFF or pgn in FAST


def priority(pgn: int) -> int:
    """The priority that a PGN is sent with, 0 (highest) to 7; 6 where nobody says otherwise."""
    return SCHEDULE.get(pgn, (DEFAULT_PRIORITY, None))[0]


def interval(pgn: int) -> float | None:
    """How often a PGN is sent by default, in s. None is on event, or not known."""
    return SCHEDULE.get(pgn, (DEFAULT_PRIORITY, None))[1]


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
