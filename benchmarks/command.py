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

TIMES = 2000
EVERY = 0.1  # s between two commands


def measure() -> dict[str, float]:
    """Median and 99th percentile of one `STBDTEN`, in us."""
    helper = Helper(PROGRAM, _measure)
    with ending(helper):
        result: dict[str, float] = helper.answer()
        return result


def _measure(pipe: Connection) -> None:
    boat = Boat(settings(USUAL), [Port("Bridge", 1)], 0.0)
    line = parp.command(parp.Verb.STBDTEN, 1)
    heading = cycle()[0]
    boat.receive_frames([heading], 0.0)
    boat.receive_bytes("Bridge", parp.command(parp.Verb.TAKECMD, 1) + parp.command(parp.Verb.ENGAGE, 1), 0.0)
    times = sorted(_one(boat, line, heading, EVERY * number) for number in range(1, TIMES))
    pipe.send({"p50": median(times), "p99": times[int(0.99 * len(times))]})


def _one(boat: Boat, line: bytes, heading: Frame, now: float) -> float:
    boat.receive_frames([heading], now)
    boat.expire(now)
    boat.deadline  # noqa: B018 - the gateway has asked for it before it goes to sleep
    begun = time.perf_counter_ns()
    effects = boat.receive_bytes("Bridge", line, now)
    took = time.perf_counter_ns() - begun
    assert sum(type(effect) is Transmit for effect in effects) == 4
    return took / 1000
