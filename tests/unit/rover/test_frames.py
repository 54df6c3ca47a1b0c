"""The declarations are those of the specification."""

import pytest

from timonel.vehicles.rover.declaration import Derived, Party, RoverFrame
from timonel.vehicles.rover.frames import (
    FRAMES,
    BatteryVoltage,
    DriveCode,
    DriveCommand,
    DriveEnable,
    GpsPosition,
    Imu,
    Magnetometer,
    SpeedLimit,
)

LENGTHS = dict(zip(range(100, 121), (2, 1, 3, 3, 6, 6, 6, 6, 8, 6, 8, 12, 6, 3, 3, 1, 1, 1, 1, 1, 1), strict=True))
ROVER = {100, 101, 115, 119, 120}
MOTORS = {102, 103}


def test_all_frames_of_the_specification_are_declared_with_their_lengths():
    assert {frame.FRAME: frame.size for frame in FRAMES} == LENGTHS


def test_every_frame_goes_where_the_specification_says():
    assert {frame.FRAME for frame in FRAMES if frame.TO is Party.ROVER} == ROVER
    assert {frame.FRAME for frame in FRAMES if frame.TO is Party.MOTORS} == MOTORS
    assert {frame.FRAME for frame in FRAMES if frame.TO is Party.OPERATOR} == LENGTHS.keys() - ROVER - MOTORS


@pytest.mark.parametrize("frame", FRAMES, ids=lambda frame: frame.__name__)
def test_no_frame_is_sent_more_often_than_50_times_a_second_and_each_says_what_it_is(frame):
    assert 0 < frame.RATE <= 50
    assert frame.SENDER
    assert frame.__doc__.startswith(f"Frame {frame.FRAME}: ")


def test_the_imus_frame_is_the_only_one_that_is_longer_than_a_can_frame_and_it_stays_off_the_bus():
    assert [frame for frame in FRAMES if frame.size > 8] == [Imu]
    assert not Imu.SEGMENTED


def test_the_codes_for_permission_and_stop_differ_in_all_bits():
    assert ord("1") == DriveCode.PERMIT
    assert DriveCode.PERMIT ^ DriveCode.STOP == 0xFF


def test_frames_are_frozen_and_compare_by_value():
    assert DriveEnable(code=DriveCode.PERMIT) == DriveEnable(code=DriveCode(0x31))
    with pytest.raises(AttributeError):
        DriveEnable(code=DriveCode.STOP).code = DriveCode.PERMIT


def test_full_forward_is_minus_100_and_right_is_positive():
    stick = DriveCommand(y=100, x=-100)
    assert (stick.forward, stick.right) == (1.0, 1.0)


def test_a_limit_is_a_share_of_its_highest_step():
    assert SpeedLimit(steps=10).share == 0.5


def test_a_cell_is_the_difference_of_its_taps():
    battery = BatteryVoltage(tap1=4.0, tap2=8.25, tap3=12.0, tap4=16.5)
    assert (battery.cell1, battery.cell2, battery.cell3, battery.cell4) == (4.0, 4.25, 3.75, 4.5)


@pytest.mark.parametrize(
    ("x", "y", "degrees"), [(30, 0, 0), (0, -30, 270), (-30, 0, 180), (0, 30, 90), (20, 20, 45), (20, -20, 315)]
)
def test_the_heading_is_where_the_bow_points_from_north(x, y, degrees):
    field = Magnetometer(x=x * 1e-6, y=y * 1e-6, z=-40e-6)
    assert field.magnetic_heading == pytest.approx(degrees * 3.14159265 / 180, abs=1e-6)


def test_the_strength_is_that_of_all_axes():
    assert Magnetometer(x=20e-6, y=-20e-6, z=10e-6).strength == pytest.approx(30e-6)


def test_what_is_derived_of_nothing_is_not_available():
    assert BatteryVoltage(tap1=4.0).cell2 is None
    assert Magnetometer().magnetic_heading is None


def test_a_class_tells_its_derived_signals():
    assert isinstance(BatteryVoltage.cell2, Derived)
    assert {name: signal.unit for name, signal in Magnetometer.DERIVED.items()} == {
        "magnetic_heading": "rad",
        "strength": "T",
    }


def test_a_field_left_out_is_not_available():
    assert GpsPosition() == GpsPosition(longitude_deg=None, latitude_deg=None)
    assert issubclass(GpsPosition, RoverFrame)
