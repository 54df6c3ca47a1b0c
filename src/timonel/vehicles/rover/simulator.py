"""A simulated rover: six driven wheels and their two boards, battery, GPS, IMU and magnetometer, on its CAN bus.

It has no clock: `step(dt)` moves it and returns the frames that its modules sent meanwhile, `receive` hands it the
frames of others. The same seed and the same calls give the same bytes. How it moves is in `physics`.

    frame      what the modules do with it
    101        '1' lets the boards run, anything else stops them; boards that never heard one run by their set points
    102 103    the right and the left board follow it; what is beyond +-100, or not zero while they are stopped, is
               counted and not followed
    115        power limit of every motor, in twentieths
    119        nothing: the controller's mixer has heeded it
    120        current limit of every motor, in two-hundredths

GPS, IMU and magnetometer hang on the controller itself. Their frames 110 to 112 come out of `step` like the others, 111
with its twelve bytes in one: they stand for what the controller reads from its own sensors, not for CAN frames.

The boards have no time-out of their own, as the protocol states none: what stops the wheels when the operator is gone
is the controller, and who tests that wants no help. `module_timeout` gives them one.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from enum import StrEnum
from math import cos, degrees, radians, sin, sqrt
from random import Random

from timonel.core.frame import Frame
from timonel.vehicles.rover.calibration import PHYSICAL, Calibration
from timonel.vehicles.rover.conversions import Reciprocal, WheelSpeed
from timonel.vehicles.rover.declaration import RoverFrame
from timonel.vehicles.rover.frames import (
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
    WheelSpeedLeft,
    WheelSpeedRight,
    WheelSpeedSetLeft,
    WheelSpeedSetRight,
)
from timonel.vehicles.rover.physics import (
    AIR,
    CELLS,
    CURRENT_LIMIT,
    ELECTRONICS,
    FULL_TURN,
    GRAVITY,
    MODULES,
    POWER_LIMIT,
    Battery,
    Body,
    Wheel,
    torque_of,
)
from timonel.vehicles.rover.protocol import Protocol

TICKS = 50
"""Moments of the simulation in a second: the highest rate of a frame."""

TICK = 1 / TICKS  # s
WARMING = 10  # ticks between two looks at what is slow: charge and temperatures

EARTH = 6371008.8  # m
VARIATION = radians(7.0)  # World Magnetic Model at 52.2 N 21.0 E, 2026
FIELD_NORTH, FIELD_DOWN = 18.7e-6, 47.0e-6  # T, of the same
GPS_WANDER, GPS_MEMORY, GPS_NOISE = 0.3, 60.0, 0.05  # m, s, m
ENCODER_NOISE = 0.002  # of the speed
CURRENT_NOISE = 0.05  # A
SLOWEST_COUNT = 32767  # of an encoder's timer; what turns slower stands
TRIP, REARM = 110.0, 90.0  # degC: where a board stops its motors, and where it lets them run again
CELL_LOW, MODULE_HOT, PACK_CURRENT = 3.2, 60.0, 50.0  # V, degC, A: what the BMS calls too low and too high
FADED = 1.0  # V that a low cell lacks

Setpoints = tuple[int, int, int]
"""Of the front, the middle and the rear wheel, in percent of full speed."""

STANDSTILL: Setpoints = (0, 0, 0)


class Fault(StrEnum):
    """What can go wrong with the rover."""

    STALLED_WHEEL = "stalled wheel"  # the left one in the middle
    STUCK = "stuck"  # no wheel turns
    HOT_MOTOR = "hot motor"  # the right one in the rear: its board stops within a minute
    LOW_CELL = "low cell"  # the third
    RIGHT_BOARD = "right board"  # neither hears nor speaks, and its motors have no torque
    MOTOR_SUPPLY = "motor supply"  # the emergency switch is pressed
    GPS = "gps"  # no fix
    IMU = "imu"  # silent


SILENT: dict[Fault, tuple[type[RoverFrame], ...]] = {
    Fault.RIGHT_BOARD: (MotorCurrentRight, WheelSpeedRight, MotorTemperatureRight, MotorDriverStatusRight),
    Fault.IMU: (Imu,),
}

HEEDED = {
    declaration.FRAME for declaration in (DriveEnable, WheelSpeedSetRight, WheelSpeedSetLeft, PowerLimit, CurrentLimit)
}


class MotorBoard:
    """Drives the three wheels of a side: front, middle, rear."""

    def __init__(self, timeout: float | None) -> None:
        self.wheels = [Wheel(AIR) for _ in range(3)]
        self.setpoints = STANDSTILL
        self.permitted = True
        self.started = False
        self.supplied = True
        self.connected = True
        self._timeout = timeout
        self._heard = 0.0
        self._tripped = False

    def order(self, setpoints: Setpoints, time: float) -> None:
        """What the wheels shall do from now on."""
        self.setpoints, self._heard = setpoints, time

    def permit(self, permitted: bool) -> None:
        """A stop is not taken back by a permission: set points must come anew."""
        self.permitted = self.started = permitted
        if not permitted:
            self.setpoints = STANDSTILL

    @property
    def powered(self) -> bool:
        """Whether its motors can have torque at all."""
        return self.supplied and self.connected and not self._tripped

    def push(self, ground: float, torque_limit: float, power_limit: float, time: float) -> float:
        """The force of the side on the body in N, for one tick."""
        if self._timeout is not None and time - self._heard >= self._timeout:
            self.setpoints = STANDSTILL
        force, powered = 0.0, self.powered
        for wheel, setpoint in zip(self.wheels, self.setpoints, strict=True):
            wheel.powered = powered
            wheel.follow(setpoint * FULL_TURN / 100 if powered else 0.0, TICK)
            force += wheel.push(ground, torque_limit, power_limit, TICK)
        return force

    def warm(self, dt: float) -> None:
        """A board with a motor that is too hot stops all three until it has cooled down."""
        for wheel in self.wheels:
            wheel.warm(dt)
        hottest = max(wheel.temperature for wheel in self.wheels)
        self._tripped = hottest > (REARM if self._tripped else TRIP)

    @property
    def status(self) -> DriverState:
        """As frames 116 and 117 have it: running is being started by a permission, or turning without one."""
        if not self.supplied:
            return DriverState.NO_SUPPLY
        if self._tripped:
            return DriverState.FAULT
        return DriverState.RUNNING if self.started or any(self.setpoints) else DriverState.STOPPED


class Gps:
    """A receiver whose fix wanders around the truth."""

    def __init__(self, latitude: float, longitude: float, random: Random) -> None:
        self._latitude, self._longitude = latitude, longitude
        self._random = random
        self._north = self._east = 0.0  # m, of the error

    def fix(self, north: float, east: float, period: float) -> GpsPosition:
        """`north` and `east` in m of where it was switched on, `period` s after the last fix."""
        self._north = self._wander(self._north, period)
        self._east = self._wander(self._east, period)
        north += self._north + GPS_NOISE * self._random.gauss()
        east += self._east + GPS_NOISE * self._random.gauss()
        parallel = EARTH * cos(radians(self._latitude))
        return GpsPosition(
            longitude_deg=self._longitude + degrees(east / parallel),
            latitude_deg=self._latitude + degrees(north / EARTH),
        )

    def _wander(self, error: float, period: float) -> float:
        kick = GPS_WANDER * sqrt(2 * period / GPS_MEMORY)
        return error * (1 - period / GPS_MEMORY) + kick * self._random.gauss()


class SimulatedRover:
    """The rover on its bus.

    `latitude` and `longitude` in degrees are where it begins, `heading` in rad true is where it looks then, `charge`
    0..1 its battery's. `hard_iron` in T is what the iron on board adds to the magnetometer, `calibration` what the
    sensors are made of (wheel speeds fit into their frames with the physical one alone). With `module_timeout` in s a
    board stops when no set point came for so long; None: it follows the last one for ever.

    `body`, `battery`, `left` and `right` are the truth, read and changed at will. `accepted` counts the set points that
    the boards took over, by the identifier of their frame and by value, `rejected` the frames that they did not, by
    identifier.
    """

    def __init__(
        self,
        seed: int = 1,
        *,
        latitude: float = 52.2194,
        longitude: float = 21.0105,
        heading: float = 0.0,
        charge: float = 0.95,
        hard_iron: tuple[float, float, float] = (0.0, 0.0, 0.0),
        calibration: Calibration = PHYSICAL,
        module_timeout: float | None = None,
    ) -> None:
        self.body = Body(heading)
        self.battery = Battery([charge] * CELLS, [AIR] * MODULES)
        self.right, self.left = MotorBoard(module_timeout), MotorBoard(module_timeout)
        self.accepted: Counter[tuple[int, Setpoints]] = Counter()
        self.rejected: Counter[int] = Counter()
        self._random = Random(seed)
        self._gps = Gps(latitude, longitude, self._random)
        self._hard_iron = hard_iron
        self._protocol = Protocol(calibration)
        self._slowest = _slowest(calibration)
        self._power_limit, self._torque_limit = POWER_LIMIT, torque_of(CURRENT_LIMIT)
        self._ticks = 0
        self._owed = 0.0  # s of simulation not yet run
        self._faults: set[Fault] = set()
        self._due = [list(self._schedule(tick)) for tick in range(TICKS)]

    @property
    def time(self) -> float:
        """Seconds since it was switched on."""
        return self._ticks * TICK

    @property
    def setpoints(self) -> tuple[Setpoints, Setpoints]:
        """What the left and the right wheels shall do now."""
        return self.left.setpoints, self.right.setpoints

    def silence(self, fault: Fault) -> None:
        """Let something go wrong, until `restore`."""
        self._faults.add(fault)
        self._suffer()

    def restore(self, fault: Fault) -> None:
        """Mend it. A motor that is hot by then has to cool down."""
        self._faults.discard(fault)
        self._suffer()

    def _suffer(self) -> None:
        for wheel in self.left.wheels + self.right.wheels:
            wheel.stalled = Fault.STUCK in self._faults
        self.left.wheels[1].stalled |= Fault.STALLED_WHEEL in self._faults
        self.right.wheels[2].hot = Fault.HOT_MOTOR in self._faults
        self.right.connected = Fault.RIGHT_BOARD not in self._faults
        self.battery.faded[2] = FADED if Fault.LOW_CELL in self._faults else 0.0
        self._supply()

    def _supply(self) -> None:
        self.left.supplied = self.right.supplied = Fault.MOTOR_SUPPLY not in self._faults and not self.battery.empty

    def step(self, dt: float) -> list[Frame]:
        """Let `dt` seconds pass; the frames that were sent in them, in order."""
        frames: list[Frame] = []
        self._owed += dt
        while self._owed > TICK / 2:
            self._owed -= TICK
            self._ticks += 1
            self._move()
            frames += self._speak()
        return frames

    # --- what others say ----------------------------------------------------------------------------------------------

    def receive(self, frame: Frame) -> None:
        """A frame that the controller put on the bus."""
        if frame.extended:
            return
        match self._protocol.decode(frame.identifier, frame.data):
            case WheelSpeedSetRight(front_percent=int(front), middle_percent=int(middle), rear_percent=int(rear)):
                self._order(self.right, frame.identifier, (front, middle, rear))
            case WheelSpeedSetLeft(front_percent=int(front), middle_percent=int(middle), rear_percent=int(rear)):
                self._order(self.left, frame.identifier, (front, middle, rear))
            case DriveEnable(code=code):
                self._permit(code is DriveCode.PERMIT)
            case PowerLimit(steps=int(steps)) if 1 <= steps <= 20:
                self._power_limit = POWER_LIMIT * steps / 20
            case CurrentLimit(steps=int(steps)) if 1 <= steps <= 200:
                self._torque_limit = torque_of(CURRENT_LIMIT * steps / 200)
            case _ if frame.identifier in HEEDED:
                self.rejected[frame.identifier] += 1

    def _order(self, board: MotorBoard, identifier: int, setpoints: Setpoints) -> None:
        if not board.connected:
            return
        if -100 <= min(setpoints) <= max(setpoints) <= 100 and (board.permitted or setpoints == STANDSTILL):
            board.order(setpoints, self.time)
            self.accepted[identifier, setpoints] += 1
        else:
            self.rejected[identifier] += 1

    def _permit(self, permitted: bool) -> None:
        for board in (self.right, self.left):
            if board.connected:
                board.permit(permitted)

    # --- motion -------------------------------------------------------------------------------------------------------

    def _move(self) -> None:
        body, limits = self.body, (self._torque_limit, self._power_limit, self.time)
        body.move(self.left.push(body.left, *limits), self.right.push(body.right, *limits), TICK)
        if self._ticks % WARMING == 0:
            self._warm(WARMING * TICK)

    def _warm(self, dt: float) -> None:
        wheels = self.left.wheels + self.right.wheels
        self.battery.drain(ELECTRONICS + sum(wheel.power for wheel in wheels), dt)
        self.battery.warm(dt)
        self.left.warm(dt)
        self.right.warm(dt)
        self._supply()

    # --- what the modules send ----------------------------------------------------------------------------------------

    def _schedule(self, tick: int) -> Iterator[tuple[type[RoverFrame], Callable[[], RoverFrame]]]:
        """What is due at `tick` of a second's, each at its declared rate and not all at once."""
        plan: tuple[tuple[type[RoverFrame], Callable[[], RoverFrame]], ...] = (
            (MotorCurrentRight, self._current_right),
            (MotorCurrentLeft, self._current_left),
            (WheelSpeedRight, self._speed_right),
            (WheelSpeedLeft, self._speed_left),
            (BatteryVoltage, self._voltage),
            (BatteryTemperature, self._battery_temperature),
            (GpsPosition, self._position),
            (Imu, self._imu),
            (Magnetometer, self._magnetometer),
            (MotorTemperatureRight, self._temperature_right),
            (MotorTemperatureLeft, self._temperature_left),
            (MotorDriverStatusRight, self._status_right),
            (MotorDriverStatusLeft, self._status_left),
            (BmsStatus, self._bms_status),
        )
        for place, (declaration, build) in enumerate(plan):
            rate = declaration.RATE
            if int((tick + place + 1) * rate / TICKS) > int((tick + place) * rate / TICKS):
                yield declaration, build

    def _speak(self) -> list[Frame]:
        silent = [declaration for fault in self._faults for declaration in SILENT.get(fault, ())]
        return [
            Frame(*self._protocol.encode(build()), extended=False)
            for declaration, build in self._due[self._ticks % TICKS]
            if declaration not in silent
        ]

    def _current_right(self) -> MotorCurrentRight:
        front, middle, rear = self._currents(self.right)
        return MotorCurrentRight(front=front, middle=middle, rear=rear)

    def _current_left(self) -> MotorCurrentLeft:
        front, middle, rear = self._currents(self.left)
        return MotorCurrentLeft(front=front, middle=middle, rear=rear)

    def _currents(self, board: MotorBoard) -> list[float]:
        return [wheel.current + CURRENT_NOISE * self._random.gauss() for wheel in board.wheels]

    def _speed_right(self) -> WheelSpeedRight:
        front, middle, rear = self._rpm(self.right)
        return WheelSpeedRight(front_rpm=front, middle_rpm=middle, rear_rpm=rear)

    def _speed_left(self) -> WheelSpeedLeft:
        front, middle, rear = self._rpm(self.left)
        return WheelSpeedLeft(front_rpm=front, middle_rpm=middle, rear_rpm=rear)

    def _rpm(self, board: MotorBoard) -> list[float]:
        measured = [wheel.rpm * (1 + ENCODER_NOISE * self._random.gauss()) for wheel in board.wheels]
        return [rpm if abs(rpm) > self._slowest else 0.0 for rpm in measured]

    def _voltage(self) -> BatteryVoltage:
        tap1, tap2, tap3, tap4 = self.battery.taps
        return BatteryVoltage(tap1=tap1, tap2=tap2, tap3=tap3, tap4=tap4)

    def _battery_temperature(self) -> BatteryTemperature:
        one, two, three, four, five, six = self.battery.temperatures
        return BatteryTemperature(
            module1_c=one, module2_c=two, module3_c=three, module4_c=four, module5_c=five, module6_c=six
        )

    def _position(self) -> GpsPosition:
        fix = self._gps.fix(self.body.north, self.body.east, 1 / GpsPosition.RATE)
        return GpsPosition(longitude_deg=None, latitude_deg=None) if Fault.GPS in self._faults else fix

    def _imu(self) -> Imu:
        """The faster, the more it shakes."""
        body, gauss = self.body, self._random.gauss
        shake = 0.02 + 0.3 * abs(body.speed)
        return Imu(
            acceleration_x=body.acceleration + shake * gauss(),
            acceleration_y=-body.speed * body.rate + shake * gauss(),
            acceleration_z=GRAVITY + shake * gauss(),
            rate_x=0.1 * shake * gauss(),
            rate_y=0.1 * shake * gauss(),
            rate_z=-body.rate + 0.02 * shake * gauss(),
        )

    def _magnetometer(self) -> Magnetometer:
        magnetic_heading = self.body.heading - VARIATION
        x, y, z = FIELD_NORTH * cos(magnetic_heading), FIELD_NORTH * sin(magnetic_heading), -FIELD_DOWN
        x, y, z = (
            field + iron + 0.1e-6 * self._random.gauss() for field, iron in zip((x, y, z), self._hard_iron, strict=True)
        )
        return Magnetometer(x=x, y=y, z=z)

    def _temperature_right(self) -> MotorTemperatureRight:
        front, middle, rear = (wheel.temperature for wheel in self.right.wheels)
        return MotorTemperatureRight(front_c=front, middle_c=middle, rear_c=rear)

    def _temperature_left(self) -> MotorTemperatureLeft:
        front, middle, rear = (wheel.temperature for wheel in self.left.wheels)
        return MotorTemperatureLeft(front_c=front, middle_c=middle, rear_c=rear)

    def _status_right(self) -> MotorDriverStatusRight:
        return MotorDriverStatusRight(status=self.right.status)

    def _status_left(self) -> MotorDriverStatusLeft:
        return MotorDriverStatusLeft(status=self.left.status)

    def _bms_status(self) -> BmsStatus:
        battery = self.battery
        if min(battery.cells) < CELL_LOW:
            return BmsStatus(status=BatteryState.UNDER_VOLTAGE)
        if max(battery.temperatures) > MODULE_HOT:
            return BmsStatus(status=BatteryState.OVER_TEMPERATURE)
        high = battery.current > PACK_CURRENT
        return BmsStatus(status=BatteryState.OVER_CURRENT if high else BatteryState.OK)


def _slowest(calibration: Calibration) -> float:
    """The speed in rpm whose period the encoder's timer can just count."""
    formula = WheelSpeed().conversion(calibration)
    assert isinstance(formula, Reciprocal)
    return formula.numerator / SLOWEST_COUNT
