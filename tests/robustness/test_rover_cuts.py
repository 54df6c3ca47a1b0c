"""Links cut and programs killed at any moment: the wheels are told to stand in time, every time. In counted time."""

from collections.abc import Callable

import pytest

from tests.rover_bench import REST, Bench, Station
from timonel.core.command import NOBODY
from timonel.vehicles.rover.drive import SILENT, STALE, STANDSTILL
from timonel.vehicles.rover.helm import LOST
from timonel.vehicles.rover.simulator import TICK

CUTS = 250  # of each case; each kind of cut has four
MODULE_TIMEOUT = 0.4  # s
ROUNDING = 1e-9  # s
LAST = b"#d\x00\x9c"


def cut(bench: Bench, station: Station) -> None:
    """In the middle of a frame, or between two; also what a killed program of the operator looks like."""
    bench.say(station, LAST[: bench.random.randint(0, len(LAST))])
    station.up.cut = True


def unplug(bench: Bench, station: Station) -> None:
    """A cut that the controller sees."""
    bench.unplug(station)


def lose_the_pad(bench: Bench, station: Station) -> None:
    """The program goes on, without sticks."""
    station.says_stick = False
    station.chatter = station.write(115, b"\x14")


def mend(bench: Bench, station: Station) -> None:
    bench.mend(station)
    station.says_stick, station.chatter = True, b""
    station.stick = REST
    bench.run(0.05)


def standing_since(bench: Bench, happened: float) -> float:
    """When the wheels were told to stand, and never again to turn."""
    moved = max((order.time for order in bench.orders if order.wheels != STANDSTILL), default=happened)
    return next(order.time for order in bench.orders if order.wheels == STANDSTILL and order.time >= moved)


@pytest.mark.parametrize("loss", [0.0, 0.01])
@pytest.mark.parametrize("number", [1, 2])
@pytest.mark.parametrize(
    ("happens", "within", "permitted"), [(cut, STALE, False), (unplug, 0.0, False), (lose_the_pad, STALE, True)]
)
def test_a_thousand_times_at_any_moment_the_wheels_are_told_to_stand_in_time(
    happens: Callable[[Bench, Station], None], within: float, permitted: bool, number: int, loss: float
):
    bench = Bench((number,), loss=loss, jitter=0.005, simulated=False)
    station = bench.stations[number]
    for _ in range(CUTS):
        bench.start(station)
        bench.run(bench.random.uniform(0.1, 0.2))
        assert bench.wheels != STANDSTILL
        bench.orders.clear()
        happened = bench.now
        happens(bench, station)
        bench.run(SILENT + ROUNDING)
        assert standing_since(bench, happened) <= happened + within + ROUNDING
        assert bench.rover.drive.permitted == permitted
        mend(bench, station)


@pytest.mark.parametrize("loss", [0.0, 0.01])
def test_a_commander_whose_link_was_cut_is_released_after_two_seconds_while_the_stop_is_repeated(loss: float):
    bench = Bench((2,), loss=loss, jitter=0.005, simulated=False)
    (station,) = bench.stations.values()
    for _ in range(100):
        bench.start(station)
        bench.run(bench.random.uniform(0.1, 0.2))
        cut(bench, station)
        bench.run(LOST + ROUNDING)
        assert bench.rover.helm.transfer.commander == NOBODY
        bench.orders.clear()
        bench.run(1.0)
        assert len(bench.orders) >= 5
        assert {order.wheels for order in bench.orders} == {STANDSTILL}
        mend(bench, station)


def test_a_stop_of_any_station_takes_effect_with_its_last_byte():
    bench = Bench((1, 3), dialect="strzyga-crc", simulated=False)
    driver, other = bench.stations.values()
    other.says_stick = False
    for _ in range(100):
        bench.start(driver)
        bench.run(bench.random.uniform(0.1, 0.2))
        bench.say(other, other.write(101, b"\xce"))
        assert bench.wheels == STANDSTILL
        assert not bench.rover.drive.permitted


def test_when_the_controller_is_killed_it_is_the_modules_time_out_that_stops_the_wheels():
    for seed in range(50):
        bench = Bench(module_timeout=MODULE_TIMEOUT, seed=seed)
        assert bench.modules is not None
        bench.start(bench.stations[1])
        bench.run(bench.random.uniform(0.5, 1.0))
        assert bench.modules.left.setpoints != (0, 0, 0)
        bench.killed = True
        bench.run(MODULE_TIMEOUT + 2 * TICK)  # a board looks once a tick, and a tick can just have passed
        assert bench.modules.setpoints == ((0, 0, 0), (0, 0, 0))


def test_modules_without_a_time_out_of_their_own_drive_on_for_ever():
    bench = Bench()
    assert bench.modules is not None
    bench.start(bench.stations[1])
    bench.run(0.5)
    bench.killed = True
    bench.run(60.0)
    assert bench.modules.body.speed > 1.0
