"""Identifiers to values and back, by a calibration."""

import struct

import numpy as np
import pytest

from timonel.errors import ConfigError, DecodeError, EncodeError
from timonel.vehicles.rover.calibration import DOCUMENTED, PHYSICAL
from timonel.vehicles.rover.declaration import Party, RoverFrame
from timonel.vehicles.rover.frames import (
    BatteryTemperature,
    BatteryVoltage,
    DriveCode,
    DriveCommand,
    DriveEnable,
    DriverState,
    GpsPosition,
    Imu,
    Magnetometer,
    MotorCurrentRight,
    MotorDriverStatusLeft,
    SpeedLimit,
    WheelSpeedRight,
    WheelSpeedSetLeft,
)
from timonel.vehicles.rover.protocol import Protocol

PROTOCOL = Protocol()


def rpm(front: float | None, middle: float | None = 0.0, rear: float | None = 0.0) -> WheelSpeedRight:
    return WheelSpeedRight(front_rpm=front, middle_rpm=middle, rear_rpm=rear)


def test_a_payload_is_typed_values_in_si():
    found = PROTOCOL.decode(111, bytes.fromhex("00000000004083007dff0000"))
    assert found == Imu(
        acceleration_x=0.0,
        acceleration_y=0.0,
        acceleration_z=pytest.approx(9.80665),
        rate_x=pytest.approx(0.0174533, abs=1e-7),
        rate_y=pytest.approx(-0.0174533, abs=1e-7),
        rate_z=0.0,
    )
    assert PROTOCOL.decode(112, bytes.fromhex("e2041efbfc0a")) == Magnetometer(
        x=pytest.approx(20e-6), y=pytest.approx(-20e-6), z=pytest.approx(44.992e-6)
    )


def test_the_calibration_decides_what_counts_mean():
    data = struct.pack("<3h", 1862, 1862, 1862)
    assert PROTOCOL.decode(104, data).front == pytest.approx(0.0061, abs=1e-4)
    assert Protocol(DOCUMENTED).decode(104, data).front == pytest.approx(62.5061, abs=1e-4)


def test_what_is_not_declared_or_of_another_length_is_nothing():
    assert PROTOCOL.decode(99, b"\0") is None
    assert PROTOCOL.decode(160, b"\0") is None
    assert PROTOCOL.decode(101, b"") is None
    assert PROTOCOL.decode(101, b"11") is None


def test_a_decoder_is_the_hot_path_of_the_same():
    assert PROTOCOL.decoder(101)(b"1") == PROTOCOL.decode(101, b"1") == DriveEnable(code=DriveCode.PERMIT)


def test_lengths_are_by_direction():
    assert PROTOCOL.lengths(Party.ROVER) == {100: 2, 101: 1, 115: 1, 119: 1, 120: 1}
    assert PROTOCOL.lengths(Party.MOTORS) == {102: 3, 103: 3}
    assert PROTOCOL.lengths(Party.OPERATOR)[111] == 12


def test_a_declaration_is_found_by_its_identifier():
    assert PROTOCOL.declaration(111) is Imu
    assert PROTOCOL.declaration(121) is None


def test_the_stick_is_read_as_it_is_and_sent_only_within_its_range():
    assert PROTOCOL.decode(100, b"\x65\x80") == DriveCommand(y=101, x=-128)
    with pytest.raises(EncodeError, match=r"y: 101 % is outside -100\.\.100"):
        PROTOCOL.encode(DriveCommand(y=101, x=0))


def test_a_state_that_nobody_has_named_stays_distinguishable():
    assert PROTOCOL.decode(117, b"\x03") == MotorDriverStatusLeft(status=DriverState.NO_SUPPLY)
    unknown = PROTOCOL.decode(117, b"\x63")
    assert unknown.status == 99
    assert unknown.status not in list(DriverState)
    assert PROTOCOL.encode(unknown) == (117, b"\x63")


def test_anything_but_the_character_1_is_no_permission():
    assert [code for code in range(256) if PROTOCOL.decode(101, bytes((code,))).code == DriveCode.PERMIT] == [0x31]


@pytest.mark.parametrize(
    ("frame", "identifier", "data"),
    [
        (DriveCommand(y=35, x=-35), 100, "23dd"),
        (DriveEnable(code=DriveCode.STOP), 101, "ce"),
        (WheelSpeedSetLeft(front_percent=100, middle_percent=-100, rear_percent=0), 103, "649c00"),
        (MotorCurrentRight(front=0.0, middle=12.5, rear=50.0), 104, "4607ba08170d"),
        (rpm(0.0, 100.148, -100.148), 106, "ffff5101affe"),
        (rpm(None), 106, "0000ffffffff"),
        (BatteryVoltage(tap1=4.2, tap2=8.4, tap3=12.6, tap4=16.8), 108, "8e0fae0e350e4a0e"),
        (GpsPosition(longitude_deg=21.010556, latitude_deg=52.219444), 110, "9e15a841b6e05042"),
        (GpsPosition(), 110, "0000000000000000"),
        (SpeedLimit(steps=10), 119, "0a"),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, RoverFrame) else "",
)
def test_values_are_sent_as_the_nearest_raw_value(frame, identifier, data):
    assert PROTOCOL.encode(frame) == (identifier, bytes.fromhex(data))


@pytest.mark.parametrize(
    ("frame", "text"),
    [
        (MotorCurrentRight(front=2000.0, middle=0.0, rear=0.0), r"front: 2000.0 A is outside -1162.5\.\.1037.466\d+"),
        (MotorCurrentRight(front=0.0, middle=None, rear=0.0), r"middle: None is not a number"),
        (MotorCurrentRight(front=0.0, middle=0.0, rear=float("nan")), r"rear: nan is not a number"),
        (MotorCurrentRight(front=0.0, middle=0.0, rear=float("inf")), r"rear: inf A is outside"),
        (BatteryVoltage(tap1=4.4, tap2=8.0, tap3=12.0, tap4=16.0), r"tap1: 4.4 V is outside 0\.\.4.318945312"),
        (BatteryTemperature(module1_c=-1), r"module1_c: -1 degC is outside 0\.\.127.5"),
        (SpeedLimit(steps=0), r"steps: 0 is outside 1\.\.20"),
        (SpeedLimit(steps=21), r"steps: 21 is outside 1\.\.20"),
        (SpeedLimit(steps=1.5), r"steps: 1.5 is not a whole number"),
        (SpeedLimit(steps="20"), r"steps: '20' is not a number"),
        (rpm(0.5), r"front_rpm: 0.5 rpm is no whole number of counts within -32768\.\.32767"),
        (rpm(-33750.0), r"front_rpm: -33750.0 rpm is no whole number of counts"),
        (rpm(1e9), r"front_rpm: 1000000000.0 rpm is no whole number of counts"),
        (rpm(float("inf")), r"front_rpm: inf rpm is no whole number of counts"),
        (rpm([0.0]), r"front_rpm: \[0.0\] is not a number"),
        (GpsPosition(longitude_deg=181.0, latitude_deg=0.0), r"longitude_deg: 181.0 deg is outside -180\.\.180"),
        (GpsPosition(longitude_deg=0.0, latitude_deg=-90.5), r"latitude_deg: -90.5 deg is outside -90\.\.90"),
        (GpsPosition(longitude_deg=0.0, latitude_deg=0.0), r"GpsPosition: .* cannot be told from having no values"),
        (GpsPosition(longitude_deg=21.0, latitude_deg=None), r"GpsPosition: .* cannot be told from having no values"),
    ],
)
def test_what_does_not_fit_is_refused_never_clipped(frame, text):
    with pytest.raises(EncodeError, match=text):
        PROTOCOL.encode(frame)


@pytest.mark.parametrize(
    ("longitude", "latitude"),
    [(0.0, 0.0), (float("nan"), 52.0), (21.0, float("nan")), (21.0, 90.5), (-180.5, 0.0), (float("inf"), 1.0)],
)
def test_no_fix_is_no_position(longitude, latitude):
    assert PROTOCOL.decode(110, struct.pack("<2f", longitude, latitude)) == GpsPosition()


def test_a_place_on_the_equator_is_a_position():
    assert PROTOCOL.decode(110, struct.pack("<2f", 21.0, 0.0)) == GpsPosition(longitude_deg=21.0, latitude_deg=0.0)


class Arm(RoverFrame, frame=160, to=Party.OPERATOR):
    pass


class Doubled(RoverFrame, frame=104, to=Party.OPERATOR):
    pass


def test_a_frame_that_is_none_of_this_rovers_cannot_be_sent():
    with pytest.raises(EncodeError, match="Arm: not a frame of this rover"):
        PROTOCOL.encode(Arm())
    with pytest.raises(EncodeError, match="Doubled: not a frame of this rover"):
        PROTOCOL.encode(Doubled())


def test_an_identifier_belongs_to_one_frame():
    with pytest.raises(ConfigError, match="Doubled: frame 104 is MotorCurrentRight already"):
        Protocol(PHYSICAL, [Doubled])


def test_the_columns_of_a_recording_have_derived_signals_and_nan_where_there_is_nothing():
    payloads = np.frombuffer(bytes.fromhex("8e0fae0e350e4a0e" + "b80bb80bb80bb80b"), np.uint8).reshape(2, 8)
    found = PROTOCOL.columns(108, payloads)
    assert list(found) == ["tap1", "tap2", "tap3", "tap4", "cell1", "cell2", "cell3", "cell4"]
    assert found["cell4"] == pytest.approx([4.1987, 3.3838], abs=1e-4)
    wheels = PROTOCOL.columns(106, np.zeros((3, 6), np.uint8))
    assert np.isnan(wheels["front_rpm"]).all()


def test_no_fix_is_no_position_in_columns_either():
    payloads = np.array([[21.0, 52.0], [0.0, 0.0], [21.0, np.nan], [181.0, 52.0]], "<f4").view(np.uint8)
    found = PROTOCOL.columns(110, payloads)
    assert found["latitude_deg"][0] == 52.0
    assert np.isnan([found["latitude_deg"][1:], found["longitude_deg"][1:]]).all()


def test_columns_want_whole_payloads():
    with pytest.raises(DecodeError, match=r"BatteryVoltage: payloads of shape \(2, 7\), not \(n, 8\)"):
        PROTOCOL.columns(108, np.zeros((2, 7), np.uint8))


def test_columns_may_be_a_part_of_something_larger_and_longer_than_a_chunk():
    payloads = np.random.default_rng(104).integers(0, 256, (40_000, 12), np.uint8)[:, 3:9]
    found = PROTOCOL.columns(104, payloads)
    for row in (0, 16_383, 16_384, 39_999):
        assert found["rear"][row] == PROTOCOL.decode(104, payloads[row].tobytes()).rear


def test_the_generated_text_can_be_read():
    assert "* 0.0335693359375 + -62.5" in PROTOCOL.codec(104).text
