"""Drives over wires that lose bytes, and with two programs at the wheel, in counted time."""

from collections import deque
from itertools import pairwise
from math import hypot, pi

import pytest

from tests.rover_bench import FULL, PERIOD, REST, Bench, distance
from timonel.core.command import Transferred
from timonel.vehicles.rover.drive import STALE, STANDSTILL, Permission, Stick, Wheels, mixed

SIDE = 15.0  # m
LOST_BYTES = 0.01
JITTER = 0.01  # s
REMEMBERED = round(STALE / PERIOD) + 2  # sticks that may still be on their way or in force


@pytest.mark.parametrize(
    ("dialect", "loss"), [("strzyga", 0.0), ("strzyga", LOST_BYTES), ("strzyga-crc", LOST_BYTES), ("hal062", 0.0)]
)
def test_a_square_driven_by_gps_and_magnetometer_closes_within_five_percent(dialect: str, loss: float):
    bench = Bench(dialect=dialect, loss=loss, jitter=JITTER)
    station = bench.stations[1]
    bench.run(1.0)
    bench.start(station, REST)
    corners = [station.fix()]
    for leg in range(4):
        bench.turn_to(station, leg * pi / 2)
        bench.drive_leg(station, leg * pi / 2, SIDE)
        corners.append(station.fix())
    assert all(abs(distance(a, b) - SIDE) < 0.15 * SIDE for a, b in pairwise(corners))
    assert distance(corners[0], corners[2]) > 1.3 * SIDE, "a square, not four times the same way"
    assert distance(corners[0], corners[4]) < 0.05 * 4 * SIDE
    assert bench.modules is not None
    assert hypot(bench.modules.body.north, bench.modules.body.east) < 0.05 * 4 * SIDE
    assert [event.granted for event in bench.events if isinstance(event, Permission)] == [True], "never stopped"


def drive_about(dialect: str, set_points: int, seed: int = 1) -> tuple[int, float]:
    """Any stick 50 times a second, until the wheels executed so many set points.

    How many of them were never sent, and the share of the frames that came through.

    A set point counts as sent if its stick was within the last `STALE` s: one that is right by chance is rare.
    """
    bench = Bench(dialect=dialect, loss=LOST_BYTES, jitter=JITTER, seed=seed, simulated=False)
    station, random = bench.stations[1], bench.random
    bench.start(station, REST)
    recent: deque[Wheels] = deque(maxlen=REMEMBERED)
    sent = executed = strange = 0
    while executed < set_points:
        station.stick = Stick(random.randint(-100, 100), random.randint(-100, 100))
        recent.append(mixed(station.stick, 20))
        sent += 1
        bench.run(PERIOD)
        told = [order.wheels for order in bench.orders if order.wheels != STANDSTILL]
        bench.orders.clear()
        executed += len(told)
        strange += sum(wheels not in recent for wheels in told)
        assert bench.rover.drive.permitted
    return strange, bench.rover.framing()["1"].counters.frames / sent


SMALL, MILLION = 20_000, pytest.param(1_000_000, marks=[pytest.mark.slow, pytest.mark.timeout(1800)])


@pytest.mark.parametrize("set_points", [SMALL, MILLION])
@pytest.mark.parametrize("dialect", ["strzyga", "hal062"])
def test_with_one_percent_of_the_bytes_lost_at_most_one_set_point_in_ten_thousand_was_never_sent(
    dialect: str, set_points: int
):
    strange, through = drive_about(dialect, set_points)
    assert strange <= set_points / 10_000
    assert 0.8 < through < 0.97, "and the rover still drives"


@pytest.mark.parametrize("set_points", [SMALL, MILLION])
def test_with_a_check_sum_none_was(set_points: int):
    strange, through = drive_about("strzyga-crc", set_points)
    assert strange == 0
    assert 0.9 < through < 0.97


def test_the_operator_takes_over_from_the_jetson_whose_frames_have_no_effect_from_that_moment():
    bench = Bench((1, 2))
    operator, jetson = bench.stations.values()
    operator.says_stick = False
    bench.start(jetson)
    bench.run(2.0)
    assert bench.modules is not None
    assert bench.modules.body.speed > 1.1

    operator.stick, operator.says_stick = FULL, True
    bench.run(PERIOD + 0.006)
    assert [event for event in bench.events if isinstance(event, Transferred)] == [Transferred(0, 2), Transferred(2, 1)]
    assert bench.wheels == STANDSTILL
    bench.orders.clear()
    jetson.enable()
    bench.run(1.0)
    jetson.stick = FULL
    bench.run(1.0)
    assert {order.wheels for order in bench.orders} == {STANDSTILL}
    assert abs(bench.modules.body.speed) < 0.01

    jetson.chatter = jetson.write(119, b"\x01") + jetson.write(101, b"1")
    bench.start(operator, Stick(0, -50))
    bench.run(PERIOD + 0.006)
    bench.orders.clear()
    bench.run(30.0)
    assert {order.wheels for order in bench.orders} == {Wheels(50, 50)}
    assert bench.rover.helm.transfer.commander == 1


def test_who_waits_drives_when_the_operator_has_gone_but_not_before_it_permits_motion_itself():
    bench = Bench((1, 2))
    operator, jetson = bench.stations.values()
    bench.start(operator)
    bench.run(1.0)
    operator.up.cut = True
    bench.run(2.1)
    assert bench.rover.helm.transfer.commander == 2
    jetson.stick = FULL
    bench.run(0.5)
    assert bench.wheels == STANDSTILL
    bench.start(jetson)
    bench.run(0.1)
    assert bench.wheels == Wheels(100, 100)
