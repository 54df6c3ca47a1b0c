"""A rover's telemetry, and a radio link that spoils it."""

import struct
from bisect import bisect_right
from collections.abc import Callable, Iterator
from itertools import accumulate, groupby
from random import Random

import msgspec

Frame = tuple[int, bytes]

LENGTHS = {104: 6, 105: 6, 106: 6, 107: 6, 108: 8, 109: 6, 110: 8, 111: 12, 112: 6, 113: 3, 114: 3}
LENGTHS |= {116: 1, 117: 1, 118: 1}
"""The frames to the operator, with their number of data bytes."""

TICK = 0.02
"""s between two bursts of frames: the rover sends at 50 Hz what is due."""

EVERY = {111: 1, 112: 1, 104: 2, 105: 2, 106: 3, 107: 3, 108: 10, 110: 10}
"""Ticks between two frames of an id, 50 for all others: some 200 frames and 1.9 kB a second."""


class Traffic(msgspec.Struct, frozen=True):
    """Frames as they are sent, each with its tick."""

    frames: list[Frame]
    ticks: list[int]


class Wire(msgspec.Struct, frozen=True):
    """The same as bytes; `starts` holds where each frame begins, and the end."""

    data: bytes
    starts: list[int]
    ticks: list[int]


class Session(msgspec.Struct, frozen=True):
    """What one receiver hears from beginning to end: `origins` says where each byte was in `Wire.data`."""

    data: bytes
    origins: list[int]

    def portions(self, wire: Wire) -> Iterator[tuple[int, bytes]]:
        """What comes in one tick, with the tick."""
        ticks = [wire.ticks[bisect_right(wire.starts, origin) - 1] for origin in self.origins]
        place = 0
        for tick, group in groupby(ticks):
            size = sum(1 for _ in group)
            yield tick, self.data[place : place + size]
            place += size


Damage = Callable[[bytes, Random], list[Session]]
Payload = Callable[[int, Random], bytes]


def traffic(count: int, payload: Payload, random: Random) -> Traffic:
    """`count` frames in their usual mix."""
    frames: list[Frame] = []
    ticks: list[int] = []
    tick = 0
    while len(frames) < count:
        due = [number for number in LENGTHS if (tick + number) % EVERY.get(number, 50) == 0]
        frames += [(number, payload(number, random)) for number in due]
        ticks += [tick] * len(due)
        tick += 1
    return Traffic(frames[:count], ticks[:count])


def wire(sent: Traffic, write: Callable[[int, bytes], bytes]) -> Wire:
    written = [write(number, data) for number, data in sent.frames]
    return Wire(b"".join(written), list(accumulate(map(len, written), initial=0)), sent.ticks)


def realistic(number: int, random: Random) -> bytes:
    """Values as a driving rover has them, with their noise (idle currents at half the supply)."""

    def near(*values: float, noise: float, kind: str = "h") -> bytes:
        return struct.pack(f"<{len(values)}{kind}", *(round(random.gauss(value, noise)) for value in values))

    match number:
        case 104 | 105:
            return near(1990, 2010, 1975, noise=60)
        case 106 | 107:
            return b"\xff" * 6 if random.random() < 0.2 else near(337, 340, 335, noise=25)
        case 108:
            return near(3510, 3460, 3380, 3400, noise=6, kind="H")
        case 109 | 113 | 114:
            return near(*[66] * LENGTHS[number], noise=3, kind="B")
        case 110:
            return struct.pack("<2f", random.gauss(21.01, 1e-3), random.gauss(52.22, 1e-3))
        case 111:
            return near(120, -80, 16384, 10, -30, 200, noise=300)
        case 112:
            return near(1250, -1250, 2812, noise=40)
        case _:
            return b"\x01"


def full_of_starts(number: int, random: Random) -> bytes:
    """Any bytes, a quarter of them `#`."""
    return bytes(0x23 if random.random() < 0.25 else random.randrange(256) for _ in range(LENGTHS[number]))


def byte_loss(share: float) -> Damage:
    def damage(data: bytes, random: Random) -> list[Session]:
        return [_kept(data, [place for place in range(len(data)) if random.random() >= share])]

    return damage


def bit_errors(share: float) -> Damage:
    def damage(data: bytes, random: Random) -> list[Session]:
        spoilt = bytearray(data)
        for bit in random.sample(range(8 * len(data)), round(8 * len(data) * share)):
            spoilt[bit // 8] ^= 1 << bit % 8
        return [Session(bytes(spoilt), list(range(len(data))))]

    return damage


def bursts(every: int, shortest: int, longest: int) -> Damage:
    """From time to time a whole stretch is lost, on average one in `every` bytes."""

    def damage(data: bytes, random: Random) -> list[Session]:
        kept: list[int] = []
        place = 0
        while place < len(data):
            until = place + round(random.expovariate(1 / every))
            kept += range(place, min(until, len(data)))
            place = until + random.randint(shortest, longest)
        return [_kept(data, kept)]

    return damage


def joins(every: int) -> Damage:
    """Receiver after receiver joins at any byte and leaves at any byte, each hears `every` bytes on average."""

    def damage(data: bytes, random: Random) -> list[Session]:
        cuts = sorted(random.sample(range(1, len(data)), len(data) // every))
        return [_kept(data, list(range(start, end))) for start, end in zip([0, *cuts], [*cuts, len(data)], strict=True)]

    return damage


def _kept(data: bytes, places: list[int]) -> Session:
    return Session(bytes([data[place] for place in places]), places)
