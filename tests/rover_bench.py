"""A rover with everything around it, in counted time and without I/O.

```
station ──wire── the controller's machine ──bus── simulated rover
```
A `Station` is a program as people write one: it says its stick 50 times a second and its permission three times, and
reads telemetry. A `Wire` loses bytes, or is cut. The bus loses nothing.
"""

from collections.abc import Iterable
from math import cos, hypot, inf, pi, radians, tau
from random import Random

import msgspec

from timonel.core.effects import Effect, Event, Say, Transmit
from timonel.vehicles.rover.declaration import Party, RoverFrame
from timonel.vehicles.rover.drive import STANDSTILL, Stick, Wheels
from timonel.vehicles.rover.frames import (
    GpsPosition,
    Magnetometer,
    WheelSpeedSetLeft,
    WheelSpeedSetRight,
)
from timonel.vehicles.rover.framing import DIALECTS
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.settings import Port, RoverSettings
from timonel.vehicles.rover.simulator import EARTH, VARIATION, SimulatedRover
from timonel.vehicles.rover.vehicle import PERMIT, Rover, signed

PERIOD = 0.02  # s between two sticks of a station
GRANTS = 3  # times that a station says its permission, as some are lost
TRIES = 5
FULL = Stick(0, -100)
REST = Stick(0, 0)
PROTOCOL = Protocol()


class Wire:
    """One direction of a UART; each byte is lost with the probability `loss`."""

    def __init__(self, loss: float, random: Random) -> None:
        self.loss = loss
        self.cut = False
        self._random = random

    def carry(self, data: bytes) -> bytes:
        """What of `data` arrives."""
        if self.cut:
            return b""
        if not self.loss:
            return data
        random = self._random.random
        return bytes(byte for byte in data if random() >= self.loss)


class Station:
    """A program at the far end of a UART, with a wire each way."""

    def __init__(self, number: int, dialect: str, loss: float, jitter: float, random: Random) -> None:
        self.number = number
        self.stick = REST
        self.says_stick = True
        self.chatter = b""
        """What it says besides."""
        self.due = self._beat = random.uniform(0.001, PERIOD)
        self._jitter = jitter
        self._random = random
        self.up, self.down = Wire(loss, random), Wire(loss, random)
        self.heard: dict[type[RoverFrame], RoverFrame] = {}
        self.write = DIALECTS[dialect].write
        self.framer = DIALECTS[dialect](PROTOCOL.lengths(Party.OPERATOR))
        self._grants = 0

    def enable(self) -> None:
        """Let go of the stick and permit motion."""
        self.stick = REST
        self._grants = GRANTS

    def speak(self) -> bytes:
        """What it says at this moment of its 50 Hz."""
        self._beat += PERIOD
        self.due = self._beat + self._random.uniform(0.0, self._jitter)
        said = self.write(100, bytes((self.stick.y & 0xFF, self.stick.x & 0xFF))) if self.says_stick else b""
        if self._grants:
            self._grants -= 1
            said += self.write(101, PERMIT)
        return said + self.chatter

    def hear(self, data: bytes, now: float) -> None:
        """What came down the wire."""
        for number, payload in self.framer.receive(data, now):
            if message := PROTOCOL.decode(number, payload):
                self.heard[type(message)] = message

    def fix(self) -> tuple[float, float]:
        """Where the rover says it is, in m north and east of where all begins."""
        gps = self.heard[GpsPosition]
        assert isinstance(gps, GpsPosition)
        assert gps.latitude_deg is not None
        assert gps.longitude_deg is not None
        north, east = radians(gps.latitude_deg - 52.2194), radians(gps.longitude_deg - 21.0105)
        return north * EARTH, east * EARTH * cos(radians(52.2194))

    def heading(self) -> float:
        """Where it says that it looks, rad true."""
        compass = self.heard[Magnetometer]
        assert isinstance(compass, Magnetometer)
        assert compass.magnetic_heading is not None
        return compass.magnetic_heading + VARIATION


class Order(msgspec.Struct, frozen=True, gc=False):
    """What the wheels were told, and when."""

    time: float
    wheels: Wheels


class Bench:
    """A controller with stations and a simulated rover; `now` is the time in s.

    `stations` are their numbers; each speaks up to `jitter` s late. With `module_timeout` the motor boards have one of
    their own, in s. Without `simulated` there are no modules: then there is no telemetry either.
    """

    def __init__(
        self,
        stations: Iterable[int] = (1,),
        *,
        dialect: str = "strzyga",
        loss: float = 0.0,
        jitter: float = 0.0,
        seed: int = 1,
        module_timeout: float | None = None,
        simulated: bool = True,
    ) -> None:
        random = Random(seed)
        self.now = 0.0
        self.random = random
        self.dialect = dialect
        self.stations = {s: Station(s, dialect, loss, jitter, random) for s in stations}
        ports = [Port(str(number), number) for number in self.stations]
        self.rover = Rover(RoverSettings(dialect=dialect), ports, 0.0, PROTOCOL)  # type: ignore[arg-type]
        self.modules = SimulatedRover(seed, module_timeout=module_timeout) if simulated else None
        self.orders: list[Order] = []
        self.events: list[Event] = []
        self.wheels = STANDSTILL
        """What the wheels were told last."""
        self.killed = False
        self._right = 0
        self._step_due = PERIOD if simulated else inf

    # Time -----------------------------------------------------------------------------------------

    def run(self, seconds: float) -> None:
        """Everything that happens in so many seconds, in its order."""
        end = self.now + seconds
        while True:
            speaks = min(self.stations.values(), key=lambda station: station.due)
            due = inf if self.killed else self.rover.deadline
            self.now = max(self.now, min(end, speaks.due, due, self._step_due))
            if self.now >= due:
                self._carry_out(self.rover.expire(self.now))
            elif self.now >= self._step_due:
                self._step()
            elif self.now >= speaks.due:
                self.say(speaks, speaks.speak())
            else:
                return

    def say(self, station: Station, data: bytes) -> None:
        """Bytes on a station's wire."""
        arrived = station.up.carry(data)
        if arrived and not self.killed:
            self._carry_out(self.rover.receive_bytes(str(station.number), arrived, self.now))

    def unplug(self, station: Station) -> None:
        """The controller sees that the wire is gone."""
        station.up.cut = station.down.cut = True
        self._carry_out(self.rover.port_changed(str(station.number), False, self.now))

    def mend(self, station: Station) -> None:
        """The wire is whole again."""
        station.up.cut = station.down.cut = False

    def _step(self) -> None:
        assert self.modules is not None
        self._step_due += PERIOD
        frames = self.modules.step(PERIOD)
        if not self.killed:
            self._carry_out(self.rover.receive_frames(frames, self.now))

    def _carry_out(self, effects: Iterable[Effect]) -> None:
        heard = b""
        for effect in effects:
            match effect:
                case Transmit(frame):
                    if self.modules is not None:
                        self.modules.receive(frame)
                    self._note(frame.identifier, frame.data)
                case Say(line):
                    heard += line
                case Event():
                    self.events.append(effect)
        if heard:
            for station in self.stations.values():
                station.hear(station.down.carry(heard), self.now)

    def _note(self, identifier: int, data: bytes) -> None:
        if identifier == WheelSpeedSetRight.FRAME:
            self._right = signed(data[0])
        elif identifier == WheelSpeedSetLeft.FRAME:
            self.wheels = Wheels(signed(data[0]), self._right)
            self.orders.append(Order(self.now, self.wheels))

    # What people do -------------------------------------------------------------------------------

    def start(self, station: Station, stick: Stick = FULL, settle: float = 0.2) -> None:
        """Enable, again if it got lost, and push the stick."""
        for _ in range(TRIES):
            station.enable()
            self.run(settle)
            if self.rover.drive.permitted:
                break
        station.stick = stick

    def turn_to(self, station: Station, heading: float) -> None:
        """On the spot, slower the nearer."""

        def error() -> float:
            return (heading - station.heading() + pi) % tau - pi

        while abs(error()) > radians(1.5):
            pushed = 60 if abs(error()) > radians(20) else 20
            station.stick = Stick(pushed if error() > 0 else -pushed, 0)
            self.run(PERIOD)
        station.stick = REST
        self.run(0.5)

    def drive_leg(self, station: Station, heading: float, metres: float) -> None:
        """Straight on, by GPS and magnetometer."""
        begin = station.fix()
        while distance(begin, station.fix()) < metres:
            error = (heading - station.heading() + pi) % tau - pi
            station.stick = Stick(round(max(-30.0, min(30.0, error * 60))), -80)
            self.run(PERIOD)
        station.stick = REST
        self.run(0.5)


def distance(a: tuple[float, float], b: tuple[float, float]) -> float:
    """In m."""
    return hypot(a[0] - b[0], a[1] - b[1])
