"""The simulated rover: what its modules say, and what becomes of what they are told."""

from math import cos, degrees, hypot, pi, radians, tau

import pytest

from timonel.core.frame import Frame
from timonel.vehicles.rover.calibration import DOCUMENTED
from timonel.vehicles.rover.declaration import Party
from timonel.vehicles.rover.frames import (
    FRAMES,
    BatteryState,
    BatteryTemperature,
    BatteryVoltage,
    BmsStatus,
    CurrentLimit,
    DriveCode,
    DriveEnable,
    DriverState,
    GpsPosition,
    Imu,
    Magnetometer,
    MotorCurrentLeft,
    MotorCurrentRight,
    MotorDriverStatusLeft,
    MotorDriverStatusRight,
    MotorTemperatureLeft,
    MotorTemperatureRight,
    PowerLimit,
    SpeedLimit,
    WheelSpeedLeft,
    WheelSpeedRight,
    WheelSpeedSetLeft,
    WheelSpeedSetRight,
)
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.simulator import VARIATION, Fault, SimulatedRover

PROTOCOL = Protocol()
TELEMETRY = [frame for frame in FRAMES if frame.TO is Party.OPERATOR]
RIGHT_SIDE = (MotorCurrentRight, WheelSpeedRight, MotorTemperatureRight, MotorDriverStatusRight)


def frame(message):
    return Frame(*PROTOCOL.encode(message), extended=False)


def order(rover, left, right):
    rover.receive(frame(WheelSpeedSetRight(front_percent=right, middle_percent=right, rear_percent=right)))
    rover.receive(frame(WheelSpeedSetLeft(front_percent=left, middle_percent=left, rear_percent=left)))


def drive(rover, left, right, seconds):
    """Set points in percent at 50 Hz, as a controller sends them; what the modules said meanwhile."""
    frames = []
    for _ in range(round(seconds * 50)):
        order(rover, left, right)
        frames += rover.step(0.02)
    return frames


def turn_to(rover, heading):
    """On the spot, clockwise, slower the nearer."""
    while (error := (heading - rover.body.heading + pi) % tau - pi) > radians(0.5):
        speed = 60 if error > radians(15) else 12
        drive(rover, speed, -speed, 0.02)
    drive(rover, 0, 0, 0.5)


def of(kind, frames):
    return [PROTOCOL.decode(one.identifier, one.data) for one in frames if one.identifier == kind.FRAME]


def values(message):
    return [getattr(message, name) for name in message.__struct_fields__]


# --- the bus


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others():
    assert drive(SimulatedRover(seed=7), 80, 40, 5) == drive(SimulatedRover(seed=7), 80, 40, 5)
    assert drive(SimulatedRover(seed=7), 80, 40, 5) != drive(SimulatedRover(seed=8), 80, 40, 5)


def test_the_bytes_do_not_depend_on_how_time_is_cut():
    fine, coarse = SimulatedRover(), SimulatedRover()
    order(fine, 50, 50)
    order(coarse, 50, 50)
    assert [one for _ in range(700) for one in fine.step(0.01)] == coarse.step(7.0)
    assert fine.time == coarse.time == 7.0


@pytest.mark.parametrize("kind", TELEMETRY)
def test_every_frame_of_telemetry_is_sent_at_its_declared_rate(kind):
    assert len(of(kind, SimulatedRover().step(4.0))) == 4 * kind.RATE


def test_frames_are_spread_over_the_moments_of_a_second():
    rover = SimulatedRover()
    assert max(len(rover.step(0.02)) for _ in range(50)) <= 7


def test_every_frame_has_its_declared_length_and_eleven_bits_of_identifier():
    lengths = PROTOCOL.lengths(Party.OPERATOR)
    for one in SimulatedRover().step(1.0):
        assert len(one.data) == lengths[one.identifier]
        assert not one.extended


def test_nothing_but_telemetry_is_sent():
    assert {one.identifier for one in SimulatedRover().step(1.0)} == {kind.FRAME for kind in TELEMETRY}


# --- driving


def test_equal_set_points_drive_straight_and_at_full_speed_with_1_2_metres_a_second():
    rover = SimulatedRover(heading=radians(90))
    drive(rover, 100, 100, 5)
    assert rover.body.speed == pytest.approx(1.2, rel=0.05)
    assert degrees(rover.body.heading) == pytest.approx(90)
    assert rover.body.east > 4.5
    assert abs(rover.body.north) < 0.01


def test_opposite_set_points_turn_on_the_spot():
    rover = SimulatedRover()
    drive(rover, 50, -50, 1.5)
    assert rover.body.rate > 0.5
    assert hypot(rover.body.north, rover.body.east) < 1e-6


def test_it_stops_within_half_a_metre_from_full_speed():
    rover = SimulatedRover()
    drive(rover, 100, 100, 4)
    before = rover.body.north
    drive(rover, 0, 0, 1)
    assert rover.body.speed == 0
    assert 0 < rover.body.north - before < 0.5


def test_speed_is_a_share_of_full_speed():
    fast, slow = SimulatedRover(), SimulatedRover()
    drive(fast, 80, 80, 6)
    drive(slow, 20, 20, 6)
    assert slow.body.speed == pytest.approx(fast.body.speed / 4, rel=0.1)


def test_a_square_closes_in_truth_and_by_gps():
    rover = SimulatedRover()
    frames = rover.step(1.0)
    for side in range(4):
        frames += drive(rover, 60, 60, 14)
        drive(rover, 0, 0, 0.5)
        turn_to(rover, (side + 1) * pi / 2)
    frames += rover.step(1.0)
    assert hypot(rover.body.north, rover.body.east) < 0.4
    first, *_, last = of(GpsPosition, frames)
    north = (last.latitude_deg - first.latitude_deg) * 111_195
    east = (last.longitude_deg - first.longitude_deg) * 111_195 * cos(radians(52.2))
    assert hypot(north, east) < 0.05 * 4 * 10


def test_wheels_of_a_side_can_be_told_different_things():
    rover = SimulatedRover()
    rover.receive(frame(WheelSpeedSetRight(front_percent=10, middle_percent=-20, rear_percent=30)))
    assert rover.setpoints == ((0, 0, 0), (10, -20, 30))


# --- what the boards heed


def test_set_points_are_counted_by_side_and_value():
    rover = SimulatedRover()
    drive(rover, 30, 40, 0.2)
    order(rover, 0, 40)
    assert rover.setpoints == ((0, 0, 0), (40, 40, 40))
    assert rover.accepted == {(102, (40, 40, 40)): 11, (103, (30, 30, 30)): 10, (103, (0, 0, 0)): 1}


@pytest.mark.parametrize("data", [b"\x65\x00\x00", b"\x00\x00\x9b", b"\x00\x80\x00", b"\x01\x02", b""])
def test_a_set_point_out_of_range_or_of_another_length_is_counted_and_not_followed(data):
    rover = SimulatedRover()
    order(rover, 10, 10)
    rover.receive(Frame(102, data, extended=False))
    assert rover.setpoints == ((10, 10, 10), (10, 10, 10))
    assert rover.rejected == {102: 1}


def test_the_ends_of_the_range_are_followed():
    rover = SimulatedRover()
    order(rover, 100, -100)
    assert rover.setpoints == ((100, 100, 100), (-100, -100, -100))
    assert not rover.rejected


def test_frames_of_others_do_nothing():
    rover = SimulatedRover()
    rover.receive(Frame(102, b"\x32\x32\x32"))  # 29 bits of identifier
    rover.receive(Frame(170, b"\x32\x32\x32", extended=False))
    rover.receive(Frame(104, bytes(6), extended=False))
    rover.receive(frame(SpeedLimit(steps=1)))
    assert rover.setpoints == ((0, 0, 0), (0, 0, 0))
    assert not rover.rejected
    assert not rover.accepted


def test_a_stop_on_the_bus_stops_and_a_permission_alone_moves_nothing():
    rover = SimulatedRover()
    drive(rover, 60, 60, 2)
    rover.receive(frame(DriveEnable(code=DriveCode.STOP)))
    assert rover.setpoints == ((0, 0, 0), (0, 0, 0))
    drive(rover, 60, 60, 1)
    assert rover.body.speed == 0
    assert rover.rejected == {102: 50, 103: 50}
    rover.receive(frame(DriveEnable(code=DriveCode.PERMIT)))
    rover.step(1.0)
    assert rover.body.speed == 0
    drive(rover, 60, 60, 1)
    assert rover.body.speed > 0.4


def test_standing_still_needs_no_permission():
    rover = SimulatedRover()
    rover.receive(frame(DriveEnable(code=DriveCode.STOP)))
    order(rover, 0, 0)
    assert rover.accepted == {(102, (0, 0, 0)): 1, (103, (0, 0, 0)): 1}
    assert not rover.rejected


@pytest.mark.parametrize("code", [0x30, 0x01, 0xCE, 0x00, 0x33])
def test_anything_but_the_character_one_is_a_stop(code):
    rover = SimulatedRover()
    order(rover, 60, 60)
    rover.receive(Frame(101, bytes([code]), extended=False))
    assert rover.setpoints == ((0, 0, 0), (0, 0, 0))


def test_without_a_time_out_boards_follow_their_last_set_point():
    rover = SimulatedRover()
    order(rover, 60, 60)
    rover.step(5.0)
    assert rover.body.speed > 0.6


def test_a_module_time_out_stops_a_board_that_hears_nothing():
    rover = SimulatedRover(module_timeout=0.2)
    drive(rover, 60, 60, 2)
    rover.step(0.16)
    assert rover.setpoints == ((60, 60, 60), (60, 60, 60))
    rover.step(0.06)
    assert rover.setpoints == ((0, 0, 0), (0, 0, 0))
    rover.step(1.0)
    assert rover.body.speed == 0


@pytest.mark.parametrize("limit", [PowerLimit(steps=1), CurrentLimit(steps=8)])
def test_limits_slow_it_down(limit):
    limited, free = SimulatedRover(), SimulatedRover()
    limited.receive(frame(limit))
    drive(limited, 100, 100, 4)
    drive(free, 100, 100, 4)
    assert limited.body.speed < 0.8 * free.body.speed


@pytest.mark.parametrize(("identifier", "value"), [(115, 0), (115, 21), (120, 0), (120, 201)])
def test_a_limit_out_of_range_is_counted_and_not_followed(identifier, value):
    rover, free = SimulatedRover(), SimulatedRover()
    rover.receive(Frame(identifier, bytes([value]), extended=False))
    assert rover.rejected == {identifier: 1}
    assert drive(rover, 100, 100, 1) == drive(free, 100, 100, 1)


@pytest.mark.parametrize("limit", [PowerLimit(steps=20), CurrentLimit(steps=200)])
def test_the_highest_limit_is_none(limit):
    rover, free = SimulatedRover(), SimulatedRover()
    rover.receive(frame(PowerLimit(steps=1)))
    rover.receive(frame(CurrentLimit(steps=1)))
    rover.receive(frame(PowerLimit(steps=20)))
    rover.receive(frame(CurrentLimit(steps=200)))
    rover.receive(frame(limit))
    assert drive(rover, 100, 100, 1) == drive(free, 100, 100, 1)


# --- what the modules say


def test_a_rover_at_rest_says_so():
    frames = SimulatedRover().step(2.0)
    assert all(values(message) == [0, 0, 0] for message in of(WheelSpeedRight, frames) + of(WheelSpeedLeft, frames))
    for message in of(MotorCurrentRight, frames) + of(MotorCurrentLeft, frames):
        assert values(message) == pytest.approx([0, 0, 0], abs=0.3)
    assert {message.status for message in of(MotorDriverStatusLeft, frames)} == {DriverState.STOPPED}
    assert {message.status for message in of(BmsStatus, frames)} == {BatteryState.OK}


def test_standing_wheels_are_sent_as_0xffff():
    speeds = [one.data for one in SimulatedRover().step(1.0) if one.identifier == 106]
    assert set(speeds) == {b"\xff" * 6}


def test_wheel_speeds_are_those_of_the_ground():
    rover = SimulatedRover()
    frames = drive(rover, 100, 100, 5)
    for rpm in values(of(WheelSpeedRight, frames)[-1]) + values(of(WheelSpeedLeft, frames)[-1]):
        assert rpm * 2 * pi * 0.12 / 60 == pytest.approx(rover.body.speed, rel=0.05)


def test_wheels_that_turn_backwards_have_negative_speeds_and_positive_currents():
    frames = drive(SimulatedRover(), -60, -60, 3)
    assert all(rpm < -50 for rpm in values(of(WheelSpeedLeft, frames)[-1]))
    assert all(current > 0.5 for current in values(of(MotorCurrentLeft, frames)[-1]))


def test_a_wheel_too_slow_for_the_counter_is_sent_as_standing():
    rover = SimulatedRover()
    rpm = values(of(WheelSpeedLeft, drive(rover, 1, 1, 3))[-1])
    assert rpm == [0, 0, 0]
    assert 0 < rover.left.wheels[0].rpm < 1.03


def test_current_rises_with_the_load():
    hard, sand = SimulatedRover(), SimulatedRover()
    sand.body.friction = 0.3
    on_ground = of(MotorCurrentLeft, drive(hard, 50, 50, 4))[-1]
    in_sand = of(MotorCurrentLeft, drive(sand, 50, 50, 4))[-1]
    assert 0.5 < on_ground.middle < 0.6 * in_sand.middle < 5


def test_drivers_run_while_they_are_told_to_move():
    rover = SimulatedRover()
    assert of(MotorDriverStatusRight, drive(rover, 20, 20, 1))[-1].status == DriverState.RUNNING
    assert of(MotorDriverStatusRight, drive(rover, 0, 0, 1))[-1].status == DriverState.STOPPED


def test_drivers_run_from_a_permission_to_a_stop():
    rover = SimulatedRover()
    rover.receive(frame(DriveEnable(code=DriveCode.PERMIT)))
    assert of(MotorDriverStatusLeft, drive(rover, 0, 0, 1))[-1].status == DriverState.RUNNING
    rover.receive(frame(DriveEnable(code=DriveCode.STOP)))
    assert of(MotorDriverStatusLeft, drive(rover, 0, 0, 1))[-1].status == DriverState.STOPPED


def test_motors_warm_with_work():
    rover = SimulatedRover()
    order(rover, 100, -100)
    frames = rover.step(120.0)
    for kind in (MotorTemperatureRight, MotorTemperatureLeft):
        first, *_, last = of(kind, frames)
        assert values(first) == [20, 20, 20]
        assert all(21 < temperature < 60 for temperature in values(last))


def test_the_battery_drains_and_sags_and_its_cells_add_up():
    rover = SimulatedRover()
    rested = of(BatteryVoltage, rover.step(1.0))[-1]
    order(rover, 100, -100)
    working = of(BatteryVoltage, rover.step(60.0))[-1]
    assert 16 < rested.tap4 < 16.8
    assert working.tap4 < rested.tap4 - 0.05
    for cell in (working.cell1, working.cell2, working.cell3, working.cell4):
        assert 3.9 < cell < 4.2
    assert rover.battery.charges[0] < 0.949


def test_battery_modules_have_the_temperature_of_the_air_at_first():
    assert values(of(BatteryTemperature, SimulatedRover().step(1.0))[-1]) == [20] * 6


def test_an_empty_battery_stops_the_rover():
    rover = SimulatedRover(charge=0.0003)
    order(rover, 100, 100)
    frames = rover.step(30.0)
    assert of(MotorDriverStatusLeft, frames)[0].status == DriverState.RUNNING
    assert of(MotorDriverStatusLeft, frames)[-1].status == DriverState.NO_SUPPLY
    assert of(BmsStatus, frames)[-1].status == BatteryState.UNDER_VOLTAGE
    assert rover.body.speed == 0


def test_gps_is_where_the_rover_is():
    rover = SimulatedRover(latitude=-33.9, longitude=151.2, heading=radians(60))
    rover.body.north, rover.body.east = 5000.0, -3000.0
    for fix in of(GpsPosition, rover.step(5.0)):
        assert (fix.latitude_deg + 33.9) * 111_195 == pytest.approx(5000, abs=2)
        assert (fix.longitude_deg - 151.2) * 111_195 * cos(radians(33.9)) == pytest.approx(-3000, abs=2)


def test_fixes_wander_by_decimetres():
    fixes = [fix.longitude_deg for fix in of(GpsPosition, SimulatedRover().step(60.0))]
    spread = (max(fixes) - min(fixes)) * 111_195 * cos(radians(52.2))
    assert 0.1 < spread < 3


def test_gravity_points_up_at_rest():
    messages = of(Imu, SimulatedRover().step(2.0))
    assert sum(message.acceleration_z for message in messages) / len(messages) == pytest.approx(9.81, abs=0.05)
    assert all(abs(message.acceleration_x) < 0.2 for message in messages)


def test_the_imu_feels_what_the_rover_does():
    rover = SimulatedRover()
    starting = of(Imu, drive(rover, 100, 100, 0.5))
    assert sum(message.acceleration_x for message in starting) / len(starting) == pytest.approx(
        rover.body.speed / 0.5, abs=0.15
    )
    turning = of(Imu, drive(rover, 100, 50, 5))[-100:]
    rate = sum(message.rate_z for message in turning) / len(turning)
    sideways = sum(message.acceleration_y for message in turning) / len(turning)
    assert rate == pytest.approx(-rover.body.rate, rel=0.05)
    assert sideways == pytest.approx(-rover.body.speed * rover.body.rate, abs=0.15)
    assert rover.body.rate > 0.3


@pytest.mark.parametrize("heading", [0, 45, 180, 300])
def test_the_magnetometer_points_to_magnetic_north(heading):
    message = of(Magnetometer, SimulatedRover(heading=radians(heading)).step(1.0))[-1]
    apart = (message.magnetic_heading + VARIATION - radians(heading) + pi) % tau - pi
    assert abs(degrees(apart)) < 2
    assert message.strength == pytest.approx(50.6e-6, rel=0.02)


def test_iron_on_board_leads_the_magnetometer_astray():
    message = of(Magnetometer, SimulatedRover(hard_iron=(0.0, 20e-6, 0.0)).step(1.0))[-1]
    assert 30 < degrees(message.magnetic_heading) < 60


def test_the_frames_read_alike_in_the_calibration_that_the_sensors_have():
    rover = SimulatedRover(calibration=DOCUMENTED)
    currents = [one.data for one in rover.step(1.0) if one.identifier == 104]
    assert values(Protocol(DOCUMENTED).decode(104, currents[-1])) == pytest.approx([0, 0, 0], abs=0.3)


# --- faults


def test_a_stalled_wheel_stands_and_draws_while_the_others_turn():
    rover = SimulatedRover()
    rover.silence(Fault.STALLED_WHEEL)
    frames = drive(rover, 60, 60, 5)
    speeds, currents = of(WheelSpeedLeft, frames)[-1], of(MotorCurrentLeft, frames)[-1]
    assert speeds.middle_rpm == 0
    assert min(speeds.front_rpm, speeds.rear_rpm) > 50
    assert currents.middle > 15 > 3 * max(currents.front, currents.rear)
    rover.restore(Fault.STALLED_WHEEL)
    assert of(WheelSpeedLeft, drive(rover, 60, 60, 5))[-1].middle_rpm > 50


def test_a_stuck_rover_stands_with_all_motors_at_their_limit_until_the_bms_complains():
    rover = SimulatedRover()
    rover.silence(Fault.STUCK)
    frames = drive(rover, 100, 100, 4)
    assert rover.body.speed == 0
    assert values(of(WheelSpeedRight, frames)[-1]) == [0, 0, 0]
    assert all(current > 19 for current in values(of(MotorCurrentRight, frames)[-1]))
    assert of(BmsStatus, frames)[-1].status == BatteryState.OVER_CURRENT


def test_a_hot_motor_stops_its_side_until_it_has_cooled_down():
    rover = SimulatedRover()
    rover.silence(Fault.HOT_MOTOR)
    order(rover, 40, 40)
    frames = rover.step(60.0)
    assert of(MotorTemperatureRight, frames)[-1].rear_c > 105
    assert of(MotorTemperatureRight, frames)[-1].front_c < 40
    assert of(MotorDriverStatusRight, frames)[-1].status == DriverState.FAULT
    assert of(MotorDriverStatusLeft, frames)[-1].status == DriverState.RUNNING
    assert values(of(MotorCurrentRight, frames)[-1]) == pytest.approx([0, 0, 0], abs=0.3)
    rover.restore(Fault.HOT_MOTOR)
    assert of(MotorDriverStatusRight, drive(rover, 0, 0, 5))[-1].status == DriverState.FAULT
    rover.right.wheels[2].temperature = 91.0
    assert of(MotorDriverStatusRight, rover.step(1.0))[-1].status == DriverState.FAULT
    rover.right.wheels[2].temperature = 89.0
    assert of(MotorDriverStatusRight, rover.step(1.0))[-1].status == DriverState.STOPPED


def test_a_low_cell_is_told_by_its_voltage_and_by_the_bms():
    rover = SimulatedRover()
    rover.silence(Fault.LOW_CELL)
    frames = rover.step(1.0)
    voltage = of(BatteryVoltage, frames)[-1]
    assert voltage.cell3 < 3.2 < voltage.cell2
    assert of(BmsStatus, frames)[-1].status == BatteryState.UNDER_VOLTAGE
    rover.restore(Fault.LOW_CELL)
    assert of(BmsStatus, rover.step(1.0))[-1].status == BatteryState.OK


def test_hot_battery_modules_are_told_by_the_bms():
    rover = SimulatedRover()
    rover.battery.temperatures[4] = 65.0
    frames = rover.step(1.0)
    assert of(BmsStatus, frames)[-1].status == BatteryState.OVER_TEMPERATURE
    assert of(BatteryTemperature, frames)[-1].module5_c == pytest.approx(65, abs=0.5)


def test_a_lost_board_neither_speaks_nor_hears_nor_drives():
    rover = SimulatedRover()
    drive(rover, 60, 60, 2)
    rover.silence(Fault.RIGHT_BOARD)
    before = rover.accepted.copy()
    frames = drive(rover, 40, 40, 2)
    assert not any(of(kind, frames) for kind in RIGHT_SIDE)
    assert len(of(MotorCurrentLeft, frames)) == 40
    assert {key for key in rover.accepted - before if key[0] == 102} == set()
    assert all(wheel.torque == 0 for wheel in rover.right.wheels)
    rover.receive(frame(DriveEnable(code=DriveCode.STOP)))
    assert rover.setpoints == ((0, 0, 0), (60, 60, 60))
    rover.restore(Fault.RIGHT_BOARD)
    assert all(of(kind, rover.step(1.0)) for kind in RIGHT_SIDE)


def test_without_motor_supply_both_drivers_say_so_and_the_wheels_roll_out():
    rover = SimulatedRover()
    drive(rover, 100, 100, 3)
    rover.silence(Fault.MOTOR_SUPPLY)
    frames = drive(rover, 100, 100, 3)
    for kind in (MotorDriverStatusRight, MotorDriverStatusLeft):
        assert {message.status for message in of(kind, frames)} == {DriverState.NO_SUPPLY}
    assert rover.body.speed == 0
    rover.restore(Fault.MOTOR_SUPPLY)
    drive(rover, 100, 100, 0.1)
    assert 0 < rover.left.wheels[0].order < 2


def test_without_gps_there_are_frames_without_a_fix():
    rover = SimulatedRover()
    rover.silence(Fault.GPS)
    frames = rover.step(1.0)
    assert {one.data for one in frames if one.identifier == 110} == {bytes(8)}
    assert {message.latitude_deg for message in of(GpsPosition, frames)} == {None}
    rover.restore(Fault.GPS)
    assert of(GpsPosition, rover.step(1.0))[-1].latitude_deg == pytest.approx(52.2194, abs=1e-4)


def test_a_lost_imu_is_silent_and_the_magnetometer_goes_on():
    rover = SimulatedRover()
    rover.silence(Fault.IMU)
    frames = rover.step(1.0)
    assert not of(Imu, frames)
    assert len(of(Magnetometer, frames)) == Magnetometer.RATE
    rover.restore(Fault.IMU)
    assert len(of(Imu, rover.step(1.0))) == Imu.RATE
