"""Writes docs/rover_safety.md: the rules that stop a rover, and how long and how far it goes on, from the simulator."""

import sys
from collections.abc import Callable
from math import hypot
from pathlib import Path

import msgspec

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tests.rover_bench import PERIOD, REST, Bench, Station  # noqa: E402
from timonel.vehicles.rover.drive import FULL, SILENT, STALE, STOP_BURST, STOP_PERIOD  # noqa: E402
from timonel.vehicles.rover.helm import LOST  # noqa: E402

PAGE = ROOT / "docs" / "rover_safety.md"
RUNS = 20  # of each case, each at another moment
STANDS = 0.01  # m/s
GIVEN_UP = 3.0  # s after which a rover does not stop any more
LOSS = 0.01


class Case(msgspec.Struct, frozen=True):
    """Something that happens to a rover at full speed."""

    name: str
    happens: Callable[[Bench, Station], None]
    loss: float = 0.0
    module_timeout: float | None = None


class Run(msgspec.Struct, frozen=True):
    """What came of it: s until the set points were zero, s and m until it stood."""

    told: float
    stands: float
    metres: float


def pad_at_rest(bench: Bench, station: Station) -> None:
    station.stick = REST


def pad_silent(bench: Bench, station: Station) -> None:
    station.says_stick = False
    station.chatter = station.write(115, b"\x14")


def cut(bench: Bench, station: Station) -> None:
    station.up.cut = True


def unplugged(bench: Bench, station: Station) -> None:
    bench.unplug(station)


def stopped(bench: Bench, station: Station) -> None:
    station.chatter = station.write(101, b"\xce")


def controller_killed(bench: Bench, station: Station) -> None:
    bench.killed = True


CASES = (
    Case("the stick is let go, or the pad is gone and the program says a stick at rest", pad_at_rest),
    Case("a stop (101) of any station", stopped),
    Case("a stop that is repeated, 1 % of the bytes lost", stopped, loss=LOSS),
    Case("the pad is gone, and the program says no stick any more", pad_silent),
    Case("the same, 1 % of the bytes lost", pad_silent, loss=LOSS),
    Case("the link is cut, or the operator's program killed", cut),
    Case("the same, 1 % of the bytes lost", cut, loss=LOSS),
    Case("the link is cut, and the controller sees it (a USB plug is pulled, a connection closed)", unplugged),
    Case("the controller is killed; motor boards with a time-out of 200 ms", controller_killed, module_timeout=0.2),
    Case("the controller is killed; motor boards with a time-out of 500 ms", controller_killed, module_timeout=0.5),
    Case("the controller is killed; motor boards **without** a time-out", controller_killed),
)


def measure(case: Case, seed: int) -> Run | None:
    """One run; None if the rover drives on."""
    bench = Bench(loss=case.loss, jitter=0.005, seed=seed, module_timeout=case.module_timeout)
    station, modules = bench.stations[1], bench.modules
    assert modules is not None
    bench.start(station)
    bench.run(1.5 + bench.random.uniform(0, PERIOD))
    begin, north, east = bench.now, modules.body.north, modules.body.east
    case.happens(bench, station)
    told = None
    while bench.now < begin + GIVEN_UP:
        bench.run(0.002)
        if told is None and modules.setpoints == ((0, 0, 0), (0, 0, 0)):
            told = bench.now - begin
        if told is not None and abs(modules.body.speed) < STANDS:
            return Run(told, bench.now - begin, hypot(modules.body.north - north, modules.body.east - east))
    return None


def row(case: Case) -> str:
    """The longest of all runs."""
    runs = [measure(case, seed) for seed in range(RUNS)]
    known = [run for run in runs if run is not None]
    if len(known) < len(runs):
        return f"| {case.name} | never | never | - |"
    told, stands, metres = (max(getattr(run, field) for run in known) for field in Run.__struct_fields__)
    return f"| {case.name} | {told * 1000:.0f} ms | {stands:.2f} s | {metres:.2f} m |"


def page() -> str:
    """The whole page."""
    return TEXT.format(
        stale=STALE * 1000,
        silent=SILENT * 1000,
        lost=LOST,
        burst=STOP_BURST,
        again=STOP_PERIOD * 1000,
        runs=RUNS,
        full=FULL,
        table="\n".join(map(row, CASES)),
    )


TEXT = """# Safety of a rover: what stops it, and how far it goes on

Written by `scripts/make_stop_table.py`, the table from the simulator; do not edit.

timonel stops the wheels when it is told to, and when nobody tells it anything. It is a program on a computer: **an
emergency switch that cuts the motors' supply is not optional**, and neither is a time-out in the motor boards (see
the last rows).

## The ladder

| what happens | what the wheels are told | permission | command |
|---|---|---|---|
| frame 101 other than `'1'`, from any station, at any time | zero at once | withdrawn | stays |
| the stick is let go | zero at once | stays | stays |
| the commander's link is seen to be gone | zero at once | withdrawn | stays |
| command passes to another station | zero at once | withdrawn | passes |
| the last stick is {stale:.0f} ms old | zero | stays | stays |
| nothing of the commander came in for {silent:.0f} ms | zero | withdrawn | stays |
| nothing of the commander came in for {lost:g} s | zero | withdrawn | released: to who waits, else to nobody |

- **Permission is an event, not a level.** Only a frame 101 = `'1'` of the station in command counts, and only with
  its stick at rest. One that was given before a stop, or to somebody else, counts for nothing. Who still pushes the
  stick is not permitted anew.
- **The latest stick wins.** None is ever queued, so that none is executed late. Its age counts from its last byte,
  not from when the framing had proved it.
- **A stop is repeated**, 50 times a second for {burst:g} s, then every {again:.0f} ms until somebody is permitted to
  drive.
- **A value out of range is refused and counted**, never clipped into motion: a stick beyond +-{full:g}, a limit of 0
  or too much.
- **The operator (station 01) takes command** with its first frame 100 or 101; from then on no frame of another
  station has any effect but a stop. While 01 speaks, a request of another station comes to nothing: each of its
  frames takes command anew.
- **Telemetry and stops do not depend on each other.** Losing telemetry stops nothing in the role `controller`. In the
  role `operator` a rover that is silent for {silent:.0f} ms is told to stop.

## From full speed (1.2 m/s) to standing

The longest of {runs} runs each, every one at another moment, with `strzyga` over a 50 Hz link. The simulated rover
weighs 50 kg and stands on hard ground. Its boards look at what they were told 50 times a second, so up to 20 ms of
the times are theirs.

| what happens | set points are zero | it stands | after |
|---|---|---|---|
{table}

What the last rows say: when the controller's process is killed, nobody is left to say zero. What stops the wheels
then is a time-out in the motor boards (`module_timeout` in the simulator). The protocol states none, so **boards
without one drive on**. The same holds for a CAN bus that is cut. Give your boards one; 200 ms is ten missing set
points.

`docs/safety.md` has the rules of command, which are the boat's too, and how such machines are proven: exhaustive
exploration (`tests/property/test_rover_exploration.py`), mutation (`python -m tests.mutation`), a thousand cuts of
each kind in counted time (`tests/robustness/test_rover_cuts.py`), and programs that are really killed
(`tests/robustness/test_rover_kills.py`). Over a wire that loses 1 % of its bytes, a million set points were executed
with `strzyga` and a million with `strzyga-crc`, and none that nobody had sent
(`tests/robustness/test_rover_driving.py`). Without a check sum that is the framing's merit, and a matter of chance;
changed bits are another thing: only `strzyga-crc` finds them.
"""

if __name__ == "__main__":
    PAGE.write_text(page())
