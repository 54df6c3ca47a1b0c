"""The bus of the benchmarks: six PGNs in turn, one sentence each, every frame with a value of its own.

So a sentence tells which frame it was made from, whatever became of those before it.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from math import radians

from timonel.core.effects import Say
from timonel.core.frame import Frame
from timonel.core.message import Message
from timonel.links.socketcan import pack
from timonel.nmea2000.identifier import join
from timonel.nmea2000.lookups import HeadingReference, WaterReference, WindReference
from timonel.nmea2000.messages.environment import WindData
from timonel.nmea2000.messages.navigation import CogSogRapidUpdate, PositionRapidUpdate, Speed
from timonel.nmea2000.messages.steering import RateOfTurn, VesselHeading
from timonel.vehicles.boat.conversion import RATES
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.vehicle import Boat

ROUNDS = 600  # headings 0.6 degrees apart go once round
SOURCE = 34
FORMATTERS = ("HDT", "ROT", "GLL", "VTG", "VHW", "MWV")

USUAL: dict[str, float] = {}
ONE_A_FRAME = dict.fromkeys(RATES, 0.0) | dict.fromkeys(FORMATTERS, float("inf"))
EVERYTHING = dict.fromkeys(RATES, float("inf"))


def messages(number: int) -> list[Message]:
    """The six of round `number`."""
    angle = radians(0.6 * number)
    true = HeadingReference.TRUE
    return [
        VesselHeading(sid=1, heading=angle, deviation=None, variation=None, reference=true),
        RateOfTurn(sid=1, rate=0.01 + 0.0001 * number),
        PositionRapidUpdate(latitude=39.5 + 1e-5 * number, longitude=2.6 + 1e-5 * number),
        CogSogRapidUpdate(sid=1, cog_reference=true, cog=angle, sog=0.01 * number),
        Speed(
            sid=1,
            speed_water_referenced=0.01 * number,
            speed_ground_referenced=None,
            speed_water_referenced_type=WaterReference.PADDLE_WHEEL,
            speed_direction=None,
        ),
        WindData(sid=1, wind_speed=5.0, wind_angle=angle, reference=WindReference.APPARENT),
    ]


def cycle() -> list[Frame]:
    """All frames once; the bus repeats them."""
    return [
        Frame(join(2, message.PGN, SOURCE), message.encode())
        for number in range(ROUNDS)
        for message in messages(number)
    ]


def raw_cycle() -> list[bytes]:
    """The same as the kernel has them (`struct can_frame`)."""
    return [pack(frame) for frame in cycle()]


def settings(rates: Mapping[str, float]) -> BoatSettings:
    """A boat with ceilings `rates` in Hz; `inf` for none."""
    return BoatSettings(name="benchmark", rates=dict(rates), variation_model=False, commands_per_second=10_000)


def places() -> dict[bytes, int]:
    """Which frame of the cycle each sentence is made from. Sentences that two frames could give are left out."""
    boat = Boat(settings(EVERYTHING), [Port("Bridge", 1)], 0.0)
    said = [(boat.receive_frames([frame], 0.1), place) for _ in range(2) for place, frame in enumerate(cycle())]
    lines = [(effect.line, place) for effects, place in said[ROUNDS * 6 :] for effect in effects if type(effect) is Say]
    return unambiguous(lines)


def unambiguous(lines: Iterable[tuple[bytes, int]]) -> dict[bytes, int]:
    """The places of those lines that occur once."""
    listed = list(lines)
    count = Counter(line for line, _ in listed)
    return {line: place for line, place in listed if count[line] == 1}
