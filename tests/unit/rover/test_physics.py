"""The mechanics and the electricity of the simulated rover."""

from itertools import pairwise
from math import hypot, pi

import pytest

from timonel.vehicles.rover.physics import (
    AIR,
    CAPACITY,
    CURRENT_LIMIT,
    FULL_SPEED,
    FULL_TURN,
    GRIP,
    HOT,
    LEVER,
    POWER_LIMIT,
    RADIUS,
    RAMP,
    TRACK,
    Battery,
    Body,
    Wheel,
    torque_of,
)

DT = 0.02


class Chassis:
    """A body on six wheels, with nothing that could go wrong between orders and wheels."""

    def __init__(self, friction=0.1):
        self.body = Body(0.0, friction=friction)
        self.left = [Wheel(AIR) for _ in range(3)]
        self.right = [Wheel(AIR) for _ in range(3)]

    def run(self, left, right, seconds, current_limit=CURRENT_LIMIT, power_limit=POWER_LIMIT):
        """`left` and `right` are shares of full speed."""
        for _ in range(round(seconds / DT)):
            forces = [
                sum(self.push(wheel, order, ground, torque_of(current_limit), power_limit) for wheel in wheels)
                for wheels, order, ground in (
                    (self.left, left, self.body.left),
                    (self.right, right, self.body.right),
                )
            ]
            self.body.move(*forces, DT)
        return self

    def push(self, wheel, order, ground, torque_limit, power_limit):
        wheel.follow(order * FULL_TURN, DT)
        return wheel.push(ground, torque_limit, power_limit, DT)

    @property
    def wheels(self):
        return self.left + self.right

    @property
    def current(self):
        return sum(wheel.current for wheel in self.wheels)


# --- motion


def test_full_orders_reach_full_speed_within_three_seconds():
    assert Chassis().run(1, 1, 3).body.speed == pytest.approx(FULL_SPEED, rel=0.05)


def test_backwards_is_forwards_with_the_sign_turned():
    forwards, backwards = Chassis().run(0.7, 0.7, 2), Chassis().run(-0.7, -0.7, 2)
    assert backwards.body.north == pytest.approx(-forwards.body.north)
    assert backwards.current == pytest.approx(forwards.current)


def test_equal_orders_keep_the_heading_and_the_line():
    body = Chassis().run(1, 1, 10).body
    assert body.heading == 0
    assert body.east == 0
    assert body.north == pytest.approx(11.5, abs=0.5)


def test_opposite_orders_turn_on_the_spot_clockwise_when_the_left_side_goes_forward():
    body = Chassis().run(1, -1, 1).body
    assert 1 < body.heading < pi
    assert hypot(body.north, body.east) < 1e-6


def test_a_skidding_rover_turns_slower_than_its_track_says():
    body = Chassis().run(1, -1, 3).body
    assert body.rate == pytest.approx(FULL_SPEED / LEVER, rel=0.05)
    assert body.rate < 0.7 * FULL_SPEED / (TRACK / 2)


def test_it_stops_within_half_a_metre_and_then_stands():
    chassis = Chassis().run(1, 1, 4)
    before = chassis.body.north
    chassis.run(0, 0, 1)
    assert 0.02 < chassis.body.north - before < 0.5
    assert chassis.body.speed == 0
    assert all(wheel.at_rest and wheel.current == 0 for wheel in chassis.wheels)


def test_an_order_grows_at_its_ramp_and_falls_at_once():
    wheel = Wheel(AIR)
    wheel.follow(5.0, DT)
    assert wheel.order == RAMP * DT
    wheel.follow(-5.0, DT)
    assert wheel.order == -RAMP * DT
    wheel.order = 5.0
    wheel.follow(1.0, DT)
    assert wheel.order == 1.0
    wheel.follow(0.0, DT)
    assert wheel.order == 0.0


def test_without_power_it_rolls_out():
    chassis = Chassis().run(1, 1, 3)
    for wheel in chassis.wheels:
        wheel.powered = False
    chassis.run(1, 1, 0.5)
    assert 0.5 < chassis.body.speed < 1.0
    assert chassis.current == 0
    assert chassis.left[0].speed == pytest.approx(chassis.body.speed / RADIUS, rel=0.1)
    assert chassis.run(1, 1, 2).body.speed == 0


# --- load


def test_current_rises_in_sand_and_in_turns():
    hard, sand, turn = Chassis().run(0.5, 0.5, 5), Chassis(friction=0.3).run(0.5, 0.5, 5), Chassis().run(0.5, -0.5, 5)
    assert hard.current < 0.6 * sand.current
    assert hard.current < 0.8 * turn.current


def test_a_motor_that_brakes_gives_back():
    chassis = Chassis().run(1, 1, 3).run(0, 0, 0.06)
    assert chassis.current < 0
    assert all(wheel.power < 15 for wheel in chassis.wheels)


def test_a_stalled_wheel_draws_up_to_its_limit_and_does_not_turn():
    chassis = Chassis()
    chassis.left[1].stalled = True
    chassis.run(0.6, 0.6, 4)
    assert chassis.left[1].speed == 0
    assert chassis.left[1].current == pytest.approx(CURRENT_LIMIT)
    assert all(wheel.current < 4 for wheel in chassis.wheels if wheel is not chassis.left[1])


def test_a_stalled_wheel_drags_with_all_its_grip():
    wheel = Wheel(AIR, powered=False, stalled=True)
    assert wheel.push(1.0, torque_of(CURRENT_LIMIT), POWER_LIMIT, DT) == -GRIP
    assert wheel.push(-1.0, torque_of(CURRENT_LIMIT), POWER_LIMIT, DT) == GRIP
    assert wheel.push(0.0, torque_of(CURRENT_LIMIT), POWER_LIMIT, DT) == 0


def test_no_wheel_pushes_harder_than_it_grips():
    wheel = Wheel(AIR, order=FULL_TURN)
    assert wheel.push(-FULL_SPEED, torque_of(CURRENT_LIMIT), POWER_LIMIT, DT) == pytest.approx(GRIP)


@pytest.mark.parametrize(("limit", "value"), [("current_limit", 1.5), ("power_limit", 10.0)])
def test_limits_make_it_slower(limit, value):
    limited = Chassis(friction=0.2).run(1, 1, 5, **{limit: value})
    assert limited.body.speed < 0.8 * Chassis(friction=0.2).run(1, 1, 5).body.speed


def test_a_current_limit_is_not_exceeded():
    chassis = Chassis()
    chassis.left[0].stalled = True
    chassis.run(1, 1, 4, current_limit=2.0)
    assert max(wheel.current for wheel in chassis.wheels) <= 2.0 + 1e-9


# --- heat


def taking(current):
    """A motor that pushes as hard as `current` lets it, in A."""
    wheel = Wheel(AIR, order=1.0, torque=torque_of(current))
    assert wheel.current == pytest.approx(current)
    return wheel


def test_a_motor_warms_with_the_square_of_its_current_and_cools_in_the_air():
    idle, loaded, doubly = Wheel(AIR), taking(5.0), taking(10.0)
    for wheel in (idle, loaded, doubly):
        wheel.warm(1.0)
    assert idle.temperature == AIR
    assert doubly.temperature - AIR == pytest.approx(4 * (loaded.temperature - AIR))
    doubly.powered = False
    warm = doubly.temperature
    doubly.warm(10.0)
    assert AIR < doubly.temperature < warm


def test_a_seized_bearing_heats_its_motor_past_any_limit_but_not_past_the_scale():
    wheel = Wheel(AIR, hot=True)
    for _ in range(120):
        wheel.warm(1.0)
    assert 110 < wheel.temperature < HOT


# --- battery


def battery(charge=0.95):
    return Battery([charge] * 4, [AIR] * 6)


def test_a_battery_drains_by_what_is_taken():
    pack = battery(0.5)
    for _ in range(3600):
        pack.drain(100.0, 1.0)
    taken = 0.5 - pack.charges[0]
    assert taken * CAPACITY == pytest.approx(100.0 / 15.2 * 3600, rel=0.05)


def test_voltage_falls_with_charge_and_with_load():
    voltages = [battery(charge).cells[0] for charge in (1.0, 0.9, 0.5, 0.2, 0.03, 0.0)]
    assert voltages == sorted(voltages, reverse=True)
    assert voltages[0] == pytest.approx(4.18)
    assert voltages[-1] == pytest.approx(3.0)
    pack = battery()
    rested = pack.cells
    pack.drain(500.0, 1.0)
    assert pack.cells[0] < rested[0] - 0.1


def test_a_battery_is_never_emptier_than_empty():
    pack = battery(0.0)
    pack.drain(100.0, 100.0)
    assert pack.charges == [0.0] * 4


def test_taps_are_the_sums_of_the_cells_below():
    pack = battery()
    pack.charges[2] = 0.02
    taps, cells = pack.taps, pack.cells
    assert [taps[0], *(above - below for below, above in pairwise(taps))] == pytest.approx(cells)
    assert cells[2] < 3.3 < cells[1]


def test_modules_warm_under_load_and_those_in_the_middle_most():
    pack = battery()
    for _ in range(1800):
        pack.drain(400.0, 1.0)
        pack.warm(1.0)
    assert AIR + 2 < pack.temperatures[0] < pack.temperatures[2] < 50
