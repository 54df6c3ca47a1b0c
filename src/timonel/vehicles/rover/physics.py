"""The mechanics and the electricity of a simulated rover: wheels and motors, the body that they push, the battery.

    motor     a speed controller whose torque is limited by current and by power; current = torque / TORQUE_CONSTANT
    wheel     rolls with the ground under it and slips with its push; it never pushes harder than it grips
    body      m v' = push - rolling friction, J r' = moment - scrub of the wheels that skid sideways
    skid      a side runs at v +- r track slip / 2: wheels that skid turn the rover less than its track says
    heat      C T' = R I^2 - (T - air) / resistance, in motors and in battery modules
    battery   four cells: an open-circuit curve over charge, less the drop in the internal resistance

Speeds in m/s and rad/s, clockwise and forward positive. The figures are those of a rover of the student competitions:
50 kg, 1.2 m/s, six wheels of 24 cm with a gear motor each.
"""

from bisect import bisect_right
from math import cos, sin, tau

import msgspec

GRAVITY = 9.80665  # m/s^2
MASS = 50.0  # kg
INERTIA = 6.0  # kg m^2, about the upright axis
RADIUS = 0.12  # m, of a wheel
TRACK = 0.8  # m, between left and right wheels
SLIP = 1.5  # how much wider its track seems when it turns
FULL_SPEED = 1.2  # m/s
FULL_TURN = FULL_SPEED / RADIUS  # rad/s, of a wheel
LEVER = TRACK * SLIP / 2  # m

HARD_GROUND = 0.10  # rolling friction; sand has 0.3
SCRUB = 50.0  # N m, of six wheels that skid sideways
GRIP = 0.7 * MASS * GRAVITY / 6  # N, of one wheel
SLOPE = 380.0 * RADIUS  # N m of torque per m/s of slip, of one wheel

GAIN = 1.5  # N m per rad/s of error
RESET = 4.0  # N m per rad of error
RAMP = 15.0  # rad/s^2, how fast an order may grow; it falls at once

TORQUE_CONSTANT = 1.2  # N m/A, behind the gear
IDLE_CURRENT = 0.4  # A, of a motor that turns nothing
MOTOR_RESISTANCE = 0.6  # ohm
CURRENT_LIMIT = 20.0  # A, of one motor
POWER_LIMIT = 150.0  # W, of one motor
MOTOR_HEAT = 100.0  # J/K
MOTOR_COOLING = 4.0  # K/W
HOT = 118.0  # degC, what a motor with a seized bearing comes to, in some minutes
HEATING = 20.0  # s

CELLS = 4
MODULES = 6
CAPACITY = 16.0 * 3600  # A s
CELL_RESISTANCE = 0.006  # ohm
ELECTRONICS = 25.0  # W
MODULE_HEAT = 350.0  # J/K
MODULE_COOLING = 6.0  # K/W
CHARGE, OPEN_CIRCUIT = (0.0, 0.05, 0.1, 0.3, 0.5, 0.8, 1.0), (3.0, 3.45, 3.6, 3.75, 3.85, 4.0, 4.18)
AIR = 20.0  # degC


class Wheel(msgspec.Struct):
    """One wheel with its gear, motor and speed controller.

    `order` and `speed` in rad/s, `torque` in N m, `temperature` in degC. Without `powered` it rolls freely; when
    `stalled` it does not turn at all; when `hot` its bearing seizes.
    """

    temperature: float
    order: float = 0.0
    speed: float = 0.0
    torque: float = 0.0
    powered: bool = True
    stalled: bool = False
    hot: bool = False
    reset: float = 0.0

    @property
    def at_rest(self) -> bool:
        """Nothing turns, nothing is asked for."""
        return self.order == 0.0 and self.speed == 0.0

    def follow(self, order: float, dt: float) -> None:
        """The order that the board gives its motor: growing at `RAMP`, falling at once."""
        if order * self.order < 0:
            self.order = 0.0
        grows = self.order + RAMP * dt if order > 0 else self.order - RAMP * dt
        self.order = order if abs(order) <= abs(grows) else grows

    # Three hundred times a second of simulated time.
    def push(self, ground: float, torque_limit: float, power_limit: float, dt: float) -> float:
        """The force on the body in N, while the ground passes at `ground` m/s."""
        if not self.powered:
            self.torque = self.reset = 0.0
            self.speed = 0.0 if self.stalled else ground / RADIUS
            return _drag(ground) if self.stalled else 0.0
        grip = torque_limit if self.stalled else GRIP * RADIUS
        limit = min(grip, torque_limit, power_limit / max(abs(self.speed), 0.5))
        force = self._stall(ground, limit) if self.stalled else self._roll(ground, limit)
        # a wheel that shall stand is braked, not held
        self.reset = _clamp(self.reset + RESET * (self.order - self.speed) * dt, limit) if self.order else 0.0
        return force

    def _roll(self, ground: float, limit: float) -> float:
        """Controller and tyre balance: gain (order - speed) + reset = slope (radius speed - ground)."""
        free = (GAIN * self.order + self.reset + SLOPE * ground) / (SLOPE * RADIUS + GAIN)
        self.torque = _clamp(SLOPE * (RADIUS * free - ground), limit)
        self.speed = (ground + self.torque / SLOPE) / RADIUS
        return self.torque / RADIUS

    def _stall(self, ground: float, limit: float) -> float:
        """The motor pushes all it may, and the tyre skids."""
        self.torque = _clamp(GAIN * self.order + self.reset, limit)
        self.speed = 0.0
        return _drag(ground)

    @property
    def current(self) -> float:
        """In A as the motor takes it: positive when it drives in either direction, negative when it brakes.

        A motor that turns, or tries to, takes a little for itself.
        """
        if self.at_rest or not self.powered:
            return 0.0
        backward = (self.speed or self.order) < 0
        return (-self.torque if backward else self.torque) / TORQUE_CONSTANT + IDLE_CURRENT

    @property
    def rpm(self) -> float:
        return self.speed * 60 / tau

    @property
    def power(self) -> float:
        """What it takes from the battery, in W. What it gives in braking becomes heat."""
        current = self.current
        return max(0.0, (abs(self.speed) * TORQUE_CONSTANT + MOTOR_RESISTANCE * current) * current)

    def warm(self, dt: float) -> None:
        """Heat from the current, cooling by the air."""
        if self.hot:
            self.temperature += (HOT - self.temperature) * dt / HEATING
            return
        heat = MOTOR_RESISTANCE * self.current**2 - (self.temperature - AIR) / MOTOR_COOLING
        self.temperature += heat * dt / MOTOR_HEAT


class Body(msgspec.Struct):
    """Where the rover is and how it moves: `north` and `east` in m from where it began, heading in rad true."""

    heading: float
    north: float = 0.0
    east: float = 0.0
    speed: float = 0.0
    rate: float = 0.0
    acceleration: float = 0.0
    friction: float = HARD_GROUND

    @property
    def left(self) -> float:
        """How fast the ground passes under the left wheels, in m/s."""
        return self.speed + self.rate * LEVER

    @property
    def right(self) -> float:
        return self.speed - self.rate * LEVER

    def move(self, left: float, right: float, dt: float) -> None:
        """`left` and `right` are the forces of the wheels of a side, in N."""
        before = self.speed
        self.speed = _rubbed(self.speed + (left + right) / MASS * dt, self.friction * GRAVITY * dt)
        self.rate = _rubbed(self.rate + (left - right) * LEVER / INERTIA * dt, SCRUB / INERTIA * dt)
        self.acceleration = (self.speed - before) / dt
        middle = self.heading + self.rate * dt / 2
        self.north += self.speed * cos(middle) * dt
        self.east += self.speed * sin(middle) * dt
        self.heading = (self.heading + self.rate * dt) % tau


class Battery(msgspec.Struct):
    """Four cells in series, six temperatures in degC.

    `charges` 0..1 and `faded`, the voltage lost by age, are those of each cell; `current` in A, `voltage` in V.
    """

    charges: list[float]
    temperatures: list[float]
    faded: list[float] = msgspec.field(default_factory=lambda: [0.0] * CELLS)
    current: float = 0.0
    voltage: float = 16.0

    def drain(self, power: float, dt: float) -> None:
        """`power` in W goes to motors and electronics."""
        self.current = power / self.voltage
        for cell, charge in enumerate(self.charges):
            self.charges[cell] = max(0.0, charge - self.current * dt / CAPACITY)
        self.voltage = sum(self.cells)

    def warm(self, dt: float) -> None:
        """Modules in the middle are cooled less."""
        heat = self.current * self.current * CELL_RESISTANCE * CELLS / MODULES
        for module, temperature in enumerate(self.temperatures):
            cooling = MODULE_COOLING * (1.2 if module in (2, 3) else 1.0)
            self.temperatures[module] += (heat - (temperature - AIR) / cooling) * dt / MODULE_HEAT

    @property
    def cells(self) -> list[float]:
        """Voltage of each cell in V, under load."""
        drop = self.current * CELL_RESISTANCE
        return [_open_circuit(charge) - lost - drop for charge, lost in zip(self.charges, self.faded, strict=True)]

    @property
    def empty(self) -> bool:
        """A cell has nothing left."""
        return min(self.charges) == 0.0

    @property
    def taps(self) -> list[float]:
        """Voltage from the pack's minus to above each cell, in V, as frame 108 has it."""
        cells = self.cells
        return [sum(cells[: n + 1]) for n in range(CELLS)]


def torque_of(current: float) -> float:
    """The torque of a motor in N m that takes `current` in A."""
    return max(0.0, current - IDLE_CURRENT) * TORQUE_CONSTANT


def _drag(ground: float) -> float:
    """The force of a tyre that does not turn."""
    return -GRIP * _clamp(ground / 0.02, 1.0)


def _open_circuit(charge: float) -> float:
    """Voltage of a lithium polymer cell without load, in V."""
    above = min(bisect_right(CHARGE, charge), len(CHARGE) - 1)
    share = (charge - CHARGE[above - 1]) / (CHARGE[above] - CHARGE[above - 1])
    return OPEN_CIRCUIT[above - 1] + share * (OPEN_CIRCUIT[above] - OPEN_CIRCUIT[above - 1])


def _rubbed(value: float, friction: float) -> float:
    """Friction takes away motion but never turns it round."""
    return value - _clamp(value, friction)


def _clamp(value: float, limit: float) -> float:
    if value > limit:
        return limit
    return -limit if value < -limit else value
