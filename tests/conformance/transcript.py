"""Plays a transcript of the specification: what the backbone sends, what ports say, and what must come out.

A step is one of
    {"t", "bus"}         from `t` on the backbone sends heading (127250, true) and rudder (127245) at 10 Hz, null: none
    {"t", "in"}          a sentence arrives on a port
    {"t", "out"}         this sentence is said at `t`, at the latest 0.55 s after; announcements of command at once
    {"t", "out_prefix"}  the same of one that begins so
    {"t", "no_out"}      since the step before nothing was said that begins so
"""

import json
from math import radians
from pathlib import Path
from typing import Any

from timonel.core.effects import Effect, Say
from timonel.core.frame import Frame
from timonel.nmea2000.identifier import join
from timonel.nmea2000.lookups import HeadingReference
from timonel.nmea2000.messages.steering import Rudder, VesselHeading
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.vehicle import Boat

Step = dict[str, Any]
LATE = 0.55  # s, vectors/README
AT_ONCE = 0.0
TICK = 0.1  # s between the frames of a 10 Hz source
PORTS = [Port(f"IN{station}", station) for station in (1, 2, 3, 4)]


def steps(path: Path) -> list[Step]:
    """The steps of a file with one step a line."""
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    return [line for line in lines if "t" in line]


def cases(path: Path) -> list[Step]:
    """The cases of a file with one case a line."""
    return [json.loads(line) for line in path.read_text().splitlines()]


def bus_frames(bus: Step) -> list[Frame]:
    """What the backbone sends at one tick."""
    heading = VesselHeading(
        sid=None,
        heading=radians(bus["heading_deg"]),
        deviation=None,
        variation=None,
        reference=HeadingReference.TRUE,
    )
    rudder = Rudder(instance=0, direction_order=None, angle_order=None, position=radians(bus["rudder_deg"]))
    return [Frame(join(2, 127250, 10), heading.encode()), Frame(join(2, 127245, 11), rudder.encode())]


class Player:
    """A boat at work on simulated time; `said` is everything it said, with its time."""

    def __init__(self) -> None:
        self.boat = Boat(BoatSettings(), PORTS, now=0.0)
        self.said: list[tuple[float, str]] = []
        self.effects: list[tuple[float, Effect]] = []
        self._bus: Step | None = None
        self._tick = 0

    def run_until(self, end: float) -> None:
        """Let the bus and the machine's timers go on to `end`, inclusive."""
        while (now := min(self._tick * TICK, self.boat.deadline)) <= end:
            if self.boat.deadline <= now:
                self._carry_out(self.boat.expire(now), now)
            else:
                self._tick += 1
                if self._bus is not None:
                    self._carry_out(self.boat.receive_frames(bus_frames(self._bus), now), now)

    def set_bus(self, bus: Step | None, now: float) -> None:
        """From `now` on the backbone sends this."""
        self.run_until(now - 1e-6)
        self._bus = bus

    def hear(self, port: str, sentence: str, now: float) -> None:
        """A sentence arrives on `port`."""
        self.run_until(now)
        self._carry_out(self.boat.receive_bytes(port, sentence.encode() + b"\r\n", now), now)

    def _carry_out(self, effects: list[Effect], now: float) -> None:
        self.effects += [(now, effect) for effect in effects]
        self.said += [(now, e.line.decode().rstrip("\r\n")) for e in effects if isinstance(e, Say)]


def allowed_delay(wanted: str) -> float:
    return AT_ONCE if wanted.startswith(("$PARP,CMDTRANSFER", "$PARP,CMDREQUEST")) else LATE


def check(said: list[tuple[float, str]], all_steps: list[Step], late: float = 0.0) -> None:
    """Every `out` is in `said`, in order and in time; `late` is what a real wire may add."""
    place, before = 0, 0.0
    for step in all_steps:
        start = step["t"] - 1e-6
        if "no_out" in step:
            heard = [s for t, s in said if before + late < t <= start and s.startswith("$" + step["no_out"])]
            assert not heard, f"{step}: {heard}"
        wanted = step.get("out") or step.get("out_prefix")
        if wanted:
            end = step["t"] + allowed_delay(wanted) + late + 1e-6
            whole = "out" in step
            found = [
                index
                for index, (t, s) in enumerate(said)
                if index >= place and start <= t <= end and (s == wanted if whole else s.startswith(wanted))
            ]
            assert found, f"{step} is not among {[s for s in said if start - 0.2 <= s[0] <= end + 0.5]}"
            place = found[0] + 1
        before = step["t"]


def play(all_steps: list[Step]) -> Player:
    """Play all steps and check what was said."""
    player = Player()
    for step in all_steps:
        if "bus" in step:
            player.set_bus(step["bus"], step["t"])
        if "in" in step:
            player.hear(step["in"]["port"], step["in"]["sentence"], step["t"])
    player.run_until(all_steps[-1]["t"] + LATE)
    check(player.said, all_steps)
    return player
