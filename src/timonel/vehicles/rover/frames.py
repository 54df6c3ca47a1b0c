"""All frames of the rover, 100 to 120, declared once.

Source: spec/rover.md, Frames; rates are ours (the original says: fixed intervals, at most 50 Hz). What is positive:
forward, starboard (the stick's `y`), east and north. Axes of the sensors are x forward, y to the left, z up, so that a
rover at rest on level ground reads z = +1 g (ours).
"""

from typing import Annotated

from timonel.core.fields import Code
from timonel.vehicles.rover.conversions import (
    Acceleration,
    Coded,
    Current,
    Degrees,
    HalfDegrees,
    MagneticField,
    Percent,
    Rate,
    Steps,
    Tap,
    WheelSpeed,
)
from timonel.vehicles.rover.declaration import Derived, Party, RoverFrame

A_FIX = "(abs(longitude_deg) <= 180) & (abs(latitude_deg) <= 90) & ((longitude_deg != 0) | (latitude_deg != 0))"


class DriveCode(Code):
    """What frame 101 says. Anything but PERMIT stops; STOP is eight bits away from it."""

    PERMIT = 0x31
    STOP = 0xCE


class DriverState(Code):
    """State of the motor driver of one side."""

    RUNNING = 1
    STOPPED = 2
    NO_SUPPLY = 3
    FAULT = 4


class BatteryState(Code):
    """State of the battery management system."""

    OK = 1
    UNDER_VOLTAGE = 2
    OVER_TEMPERATURE = 3
    OVER_CURRENT = 4


class DriveCommand(RoverFrame, frame=100, to=Party.ROVER, sender="operator", rate=50):
    """Frame 100: the joystick, -100..100. `x` = -100 is full forward, `y` = 100 full right; 0, 0 is rest.

    The axes are those of SDL and the Gamepad API. What is out of range is read as it is; the driving machine refuses
    it.
    """

    y: Annotated[int | None, Percent()]
    x: Annotated[int | None, Percent()]
    forward = Derived("1", "-x / 100", "-1..1")
    right = Derived("1", "y / 100", "-1..1")


class DriveEnable(RoverFrame, frame=101, to=Party.ROVER, sender="operator", rate=5):
    """Frame 101: the character `1` permits motion, any other value stops the drives."""

    code: Annotated[DriveCode | None, Coded(DriveCode)]


class WheelSpeedSetRight(RoverFrame, frame=102, to=Party.MOTORS, sender="controller", rate=50):
    """Frame 102: speed set points of the right wheels in percent of full speed, forward positive."""

    front_percent: Annotated[int | None, Percent()]
    middle_percent: Annotated[int | None, Percent()]
    rear_percent: Annotated[int | None, Percent()]


class WheelSpeedSetLeft(RoverFrame, frame=103, to=Party.MOTORS, sender="controller", rate=50):
    """Frame 103: speed set points of the left wheels in percent of full speed, forward positive."""

    front_percent: Annotated[int | None, Percent()]
    middle_percent: Annotated[int | None, Percent()]
    rear_percent: Annotated[int | None, Percent()]


class MotorCurrentRight(RoverFrame, frame=104, to=Party.OPERATOR, sender="right drive", rate=20):
    """Frame 104: currents of the right motors in A, from ADC counts of 50 A sensors (ACS714)."""

    front: Annotated[float | None, Current("right", 0)]
    middle: Annotated[float | None, Current("right", 1)]
    rear: Annotated[float | None, Current("right", 2)]


class MotorCurrentLeft(RoverFrame, frame=105, to=Party.OPERATOR, sender="left drive", rate=20):
    """Frame 105: currents of the left motors in A, from ADC counts of 50 A sensors (ACS714)."""

    front: Annotated[float | None, Current("left", 0)]
    middle: Annotated[float | None, Current("left", 1)]
    rear: Annotated[float | None, Current("left", 2)]


class WheelSpeedRight(RoverFrame, frame=106, to=Party.OPERATOR, sender="right drive", rate=20):
    """Frame 106: measured speeds of the right wheels in rpm, forward positive, from the timer's period."""

    front_rpm: Annotated[float | None, WheelSpeed()]
    middle_rpm: Annotated[float | None, WheelSpeed()]
    rear_rpm: Annotated[float | None, WheelSpeed()]


class WheelSpeedLeft(RoverFrame, frame=107, to=Party.OPERATOR, sender="left drive", rate=20):
    """Frame 107: measured speeds of the left wheels in rpm, forward positive, from the timer's period."""

    front_rpm: Annotated[float | None, WheelSpeed()]
    middle_rpm: Annotated[float | None, WheelSpeed()]
    rear_rpm: Annotated[float | None, WheelSpeed()]


class BatteryVoltage(RoverFrame, frame=108, to=Party.OPERATOR, sender="BMS", rate=5):
    """Frame 108: voltages of the taps of the 4S battery against ground in V; `tap4` is the whole battery."""

    tap1: Annotated[float | None, Tap(1)]
    tap2: Annotated[float | None, Tap(2)]
    tap3: Annotated[float | None, Tap(3)]
    tap4: Annotated[float | None, Tap(4)]
    cell1 = Derived("V", "tap1")
    cell2 = Derived("V", "tap2 - tap1")
    cell3 = Derived("V", "tap3 - tap2")
    cell4 = Derived("V", "tap4 - tap3")


class BatteryTemperature(RoverFrame, frame=109, to=Party.OPERATOR, sender="BMS", rate=1):
    """Frame 109: temperatures of the six battery modules in degC, 0 to 127.5."""

    module1_c: Annotated[float | None, HalfDegrees()]
    module2_c: Annotated[float | None, HalfDegrees()]
    module3_c: Annotated[float | None, HalfDegrees()]
    module4_c: Annotated[float | None, HalfDegrees()]
    module5_c: Annotated[float | None, HalfDegrees()]
    module6_c: Annotated[float | None, HalfDegrees()]


class GpsPosition(RoverFrame, frame=110, to=Party.OPERATOR, sender="controller", rate=5, valid=A_FIX):
    """Frame 110: position in degrees, east and north positive. Both are None without a fix.

    No fix is (0, 0), what is no number, and what is no place on Earth. A step of the wire's 32-bit numbers is 0.4 m at
    52 degrees.
    """

    longitude_deg: Annotated[float | None, Degrees(180)]
    latitude_deg: Annotated[float | None, Degrees(90)]


class Imu(RoverFrame, frame=111, to=Party.OPERATOR, sender="controller", rate=50):
    """Frame 111: specific force in m/s2 and rate of turn in rad/s. 12 bytes: a frame of the UART, not of CAN."""

    acceleration_x: Annotated[float | None, Acceleration()]
    acceleration_y: Annotated[float | None, Acceleration()]
    acceleration_z: Annotated[float | None, Acceleration()]
    rate_x: Annotated[float | None, Rate()]
    rate_y: Annotated[float | None, Rate()]
    rate_z: Annotated[float | None, Rate()]


class Magnetometer(RoverFrame, frame=112, to=Party.OPERATOR, sender="controller", rate=20):
    """Frame 112: magnetic flux density in T, as the sensor says it: iron on board is not compensated."""

    x: Annotated[float | None, MagneticField()]
    y: Annotated[float | None, MagneticField()]
    z: Annotated[float | None, MagneticField()]
    magnetic_heading = Derived("rad", "atan2(-y, -x) + pi", "of a level rover, clockwise from magnetic north")
    strength = Derived("T", "sqrt(x * x + y * y + z * z)", "about 50e-6 on Earth; far from it there is iron nearby")


class MotorTemperatureRight(RoverFrame, frame=113, to=Party.OPERATOR, sender="right drive", rate=1):
    """Frame 113: temperatures of the right motors in degC, 0 to 127.5."""

    front_c: Annotated[float | None, HalfDegrees()]
    middle_c: Annotated[float | None, HalfDegrees()]
    rear_c: Annotated[float | None, HalfDegrees()]


class MotorTemperatureLeft(RoverFrame, frame=114, to=Party.OPERATOR, sender="left drive", rate=1):
    """Frame 114: temperatures of the left motors in degC, 0 to 127.5."""

    front_c: Annotated[float | None, HalfDegrees()]
    middle_c: Annotated[float | None, HalfDegrees()]
    rear_c: Annotated[float | None, HalfDegrees()]


class PowerLimit(RoverFrame, frame=115, to=Party.ROVER, sender="operator", rate=1):
    """Frame 115: power of the motors, 1..20; 20 is full power. What is out of range is refused by the rover."""

    steps: Annotated[int | None, Steps(20)]
    share = Derived("1", "steps / 20")


class MotorDriverStatusRight(RoverFrame, frame=116, to=Party.OPERATOR, sender="right drive", rate=10):
    """Frame 116: state of the motor driver of the right side."""

    status: Annotated[DriverState | None, Coded(DriverState)]


class MotorDriverStatusLeft(RoverFrame, frame=117, to=Party.OPERATOR, sender="left drive", rate=10):
    """Frame 117: state of the motor driver of the left side."""

    status: Annotated[DriverState | None, Coded(DriverState)]


class BmsStatus(RoverFrame, frame=118, to=Party.OPERATOR, sender="BMS", rate=5):
    """Frame 118: state of the battery management system. The original's text here is a copy of 117's."""

    status: Annotated[BatteryState | None, Coded(BatteryState)]


class SpeedLimit(RoverFrame, frame=119, to=Party.ROVER, sender="operator", rate=1):
    """Frame 119: full speed, 1..20; 20 is the motors' own. What is out of range is refused by the rover."""

    steps: Annotated[int | None, Steps(20)]
    share = Derived("1", "steps / 20")


class CurrentLimit(RoverFrame, frame=120, to=Party.ROVER, sender="operator", rate=1):
    """Frame 120: current of the motors, 1..200; the original names no unit. What is out of range is refused."""

    steps: Annotated[int | None, Steps(200)]
    share = Derived("1", "steps / 200")


FRAMES: tuple[type[RoverFrame], ...] = (
    DriveCommand,
    DriveEnable,
    WheelSpeedSetRight,
    WheelSpeedSetLeft,
    MotorCurrentRight,
    MotorCurrentLeft,
    WheelSpeedRight,
    WheelSpeedLeft,
    BatteryVoltage,
    BatteryTemperature,
    GpsPosition,
    Imu,
    Magnetometer,
    MotorTemperatureRight,
    MotorTemperatureLeft,
    PowerLimit,
    MotorDriverStatusRight,
    MotorDriverStatusLeft,
    BmsStatus,
    SpeedLimit,
    CurrentLimit,
)
