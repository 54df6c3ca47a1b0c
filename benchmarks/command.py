"""What a station's key costs inside the machine: from its `$PARP` line to the frames for the pilot."""

import time
from multiprocessing.connection import Connection
from statistics import median

from benchmarks.processes import PROGRAM, Helper, ending
from benchmarks.traffic import USUAL, cycle, settings
from timonel.core.effects import Transmit
from timonel.core.frame import Frame
from timonel.nmea0183 import parp
from timonel.vehicles.boat.settings import Port
from timonel.vehicles.boat.vehicle import Boat

ROUNDS = 400
IN_A_ROW = 10
EVERY = 1.0  # s between two rounds, so that nobody is told that he commands too much


def measure() -> dict[str, float]:
    """Microseconds a command: the first after other work, and one after the other; median and the least.

    `SETHEADING` is to another course each time, so that its sentence was never read before.
    """
    helper = Helper(PROGRAM, _measure)
    with ending(helper):
        result: dict[str, float] = helper.answer()
        return result


def _measure(pipe: Connection) -> None:
    boat = Boat(settings(USUAL), [Port("Bridge", 1)], 0.0)
    turn = parp.command(parp.Verb.STBDTEN, 1)
    heading = cycle()[0]
    boat.receive_frames([heading], 0.0)
    boat.receive_bytes("Bridge", parp.command(parp.Verb.TAKECMD, 1) + parp.command(parp.Verb.ENGAGE, 1), 0.0)
    first, again, courses = [], [], []
    for number in range(1, ROUNDS):
        times = _round(boat, heading, [turn] * IN_A_ROW, 2 * EVERY * number)
        first.append(times[0])
        again += times[1:]
        lines = [parp.command(parp.Verb.SETHEADING, 1, (number * IN_A_ROW + step) / 10) for step in range(IN_A_ROW)]
        courses += _round(boat, heading, lines, (2 * number + 1) * EVERY)[1:]
    pipe.send(
        {
            "first": median(first),
            "STBDTEN": median(again),
            "STBDTEN_least": min(again),
            "SETHEADING": median(courses),
            "SETHEADING_least": min(courses),
        }
    )


def _round(boat: Boat, heading: Frame, lines: list[bytes], now: float) -> list[float]:
    """What each line took, after a heading from the bus and what the passing of time had brought about."""
    boat.receive_frames([heading], now)
    boat.expire(now)
    return [_one(boat, line, now + 0.001 * step) for step, line in enumerate(lines)]


def _one(boat: Boat, line: bytes, now: float) -> float:
    boat.deadline  # noqa: B018 - the gateway has asked for it before it goes to sleep
    begun = time.perf_counter_ns()
    effects = boat.receive_bytes("Bridge", line, now)
    took = time.perf_counter_ns() - begun
    assert sum(type(effect) is Transmit for effect in effects) == 4
    return took / 1000
