"""How a PGN travels, how urgent it is and how often it is sent. It knows no messages, so that it is quick to import.

How a PGN travels is known for every one: by its range (canboat's fallback definitions), and where NMEA 2000 mixes
single frames and fast packets by the table `FAST`.
"""

from functools import lru_cache

DEFAULT_PRIORITY = 6

FAST_RANGES = ((0x1ED00, 0x1EFFF), (0x1FF00, 0x1FFFF))
"""Where all PGNs are fast packets, first and last."""

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
    129038: (4, None), 129039: (4, None), 129040: (4, None), 129041: (4, None),
    129283: (3, 1.0), 129284: (3, 1.0), 129285: (6, None), 129291: (3, 1.0),
    129793: (7, None), 129794: (6, None), 129798: (4, None), 129802: (5, None), 129809: (6, None), 129810: (6, None),
    130306: (2, 0.1), 130310: (5, 0.5), 130311: (5, 0.5), 130312: (5, 2.0), 130316: (5, 2.0),
    130819: (7, None), 130825: (7, None), 130850: (2, None), 130851: (7, None), 130856: (7, None),
}  # fmt: skip


# Asked for each frame of a recording; a bus has a few hundred PGNs.
@lru_cache(maxsize=4096)
def is_fast(pgn: int) -> bool:
    """Whether a PGN travels as fast packet. ISO transport (65240) is not one."""
    return pgn in FAST or any(first <= pgn <= last for first, last in FAST_RANGES)


def priority(pgn: int) -> int:
    """The priority that a PGN is sent with, 0 (highest) to 7; 6 where nobody says otherwise."""
    return SCHEDULE.get(pgn, (DEFAULT_PRIORITY, None))[0]


def interval(pgn: int) -> float | None:
    """How often a PGN is sent by default, in s. None is on event, or not known."""
    return SCHEDULE.get(pgn, (DEFAULT_PRIORITY, None))[1]
