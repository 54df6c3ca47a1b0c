"""What a rover shows."""

from collections import Counter, deque
from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from typing import Any, TypeVar

import msgspec

from timonel.core.command import CommandTransfer
from timonel.core.effects import Effect
from timonel.core.frame import Frame
from timonel.gateway.configuration import Configuration
from timonel.gateway.gateway import Gateway
from timonel.gateway.telemetry import PERIODS, PLACES, SHORTEST
from timonel.vehicles.rover.declaration import Party, RoverFrame
from timonel.vehicles.rover.drive import FULL, LIMIT_STEPS, Permission
from timonel.vehicles.rover.frames import (
    BatteryTemperature,
    BatteryVoltage,
    BmsStatus,
    CurrentLimit,
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
)
from timonel.vehicles.rover.segments import Joiner
from timonel.vehicles.rover.vehicle import Rover
from timonel.web.messages import (
    BatteryState,
    DriveState,
    FrameRate,
    Framing,
    ImuState,
    LimitsState,
    LinkQuality,
    MagnetometerState,
    OwnFrame,
    OwnValue,
    Position,
    Quality,
    StickState,
    Vector,
    WheelState,
)
from timonel.web.state import State, Topics, finite, fresh, quality, seconds

KELVIN = 273.15
QUALITY_PERIOD = 0.5  # s between two looks at the quality of the link
RATE_LOOKS = 5  # that a rate is taken over
REJECTIONS = ("undeclared frame", "wrong length", "frames of another controller", "halves without their partner")


class Side(msgspec.Struct, frozen=True):
    """The frames that tell of the wheels of a side."""

    name: Any
    speed: type[RoverFrame]
    current: type[RoverFrame]
    temperature: type[RoverFrame]
    driver: type[RoverFrame]


SIDES = (
    Side("left", WheelSpeedLeft, MotorCurrentLeft, MotorTemperatureLeft, MotorDriverStatusLeft),
    Side("right", WheelSpeedRight, MotorCurrentRight, MotorTemperatureRight, MotorDriverStatusRight),
)

F = TypeVar("F", bound=RoverFrame)
Sample = Callable[[Mapping[str, Any]], float | None]


class Newest(msgspec.Struct):
    """The newest frame with an identifier: its bytes, when they came, how many came, and what they mean."""

    data: bytes
    at: float
    count: int
    frame: RoverFrame | None = None


class RoverState(State):
    """The topics of a rover."""

    def __init__(self, gateway: Gateway, configuration: Configuration, rover: Rover) -> None:
        super().__init__(gateway, configuration)
        self._rover = rover
        self._protocol = rover.protocol
        self._lengths = rover.protocol.lengths(Party.OPERATOR)
        declared = self._protocol.declarations
        self._segmented = {number: size for number, size in self._lengths.items() if declared[number].SEGMENTED}
        self._joiner = Joiner(self._segmented)
        self._newest: dict[int, Newest] = {}
        self._reason = "nobody has enabled the drives yet"
        self._looks: deque[tuple[float, Counter[int]]] = deque(maxlen=RATE_LOOKS)
        self._quality = LinkQuality([], 0, [], rover.settings.dialect)
        self._own = [frame for frame in self._protocol.own if frame.TO is Party.OPERATOR]

    @property
    def transfer(self) -> CommandTransfer:
        return self._rover.helm.transfer

    # What happens -------------------------------------------------------------------------------------

    def frames_received(self, frames: Sequence[Frame], now: float) -> None:
        """From the bus. Its loop runs once a frame: written for speed."""
        lengths, newest = self._lengths, self._newest
        for frame in frames:
            identifier, data = frame.identifier, frame.data
            length = lengths.get(identifier)
            if length is None or frame.extended:
                continue
            if len(data) != length:
                whole = self._joiner.receive(identifier, data, now) if identifier in self._segmented else None
                if whole is None:
                    continue
                data = whole
            known = newest.get(identifier)
            if known is None:
                newest[identifier] = Newest(data, now, 1)
            else:
                known.data, known.at, known.frame = data, now, None
                known.count += 1

    def effect(self, effect: Effect, now: float) -> None:
        """Something was said, transmitted or happened."""
        if isinstance(effect, Permission):
            self._reason = effect.reason
        super().effect(effect, now)

    def _get(self, kind: type[F]) -> tuple[F | None, float]:
        """The newest frame of a kind, and when it came."""
        newest = self._newest.get(kind.FRAME)
        if newest is None:
            return None, float("-inf")
        if newest.frame is None:
            newest.frame = self._protocol.decode(kind.FRAME, newest.data)
        return (newest.frame if isinstance(newest.frame, kind) else None), newest.at

    # What is shown ------------------------------------------------------------------------------------

    def topics(self, now: float) -> Topics:
        """Everything as it stands at `now` (s)."""
        return super().topics(now) | {
            "drive": self._drive(now),
            "wheels": [self._wheel(side, place, now) for side in SIDES for place in PLACES],
            "battery": self._battery(now),
            "imu": self._imu(now),
            "magnetometer": self._magnetometer(now),
            "gps": self._gps(now),
            "limits": LimitsState(*map(self._rover.limit, (PowerLimit.FRAME, SpeedLimit.FRAME, CurrentLimit.FRAME))),
            "quality": self._look(now),
            "own": [shown for frame in self._own if (shown := self._own_frame(frame, now)) is not None],
        }

    def samples(self, topics: Mapping[str, Any]) -> dict[str, float | None]:
        """The values whose course over time is kept."""
        return {name: sample(topics) for name, sample in SAMPLES.items()}

    def _drive(self, now: float) -> DriveState:
        drive = self._rover.drive
        stick, wheels = drive.obeyed(now), drive.wheels(now)
        shown = StickState(stick.y / FULL, -stick.x / FULL)
        share = drive.speed_limit / LIMIT_STEPS
        return DriveState(drive.permitted, shown, wheels.left / FULL, wheels.right / FULL, share, self._reason)

    def _wheel(self, side: Side, place: Any, now: float) -> WheelState:
        speed, at = self._get(side.speed)
        wheels = self._rover.drive.wheels(now)
        temperature = self._value(side.temperature, f"{place}_c", now)
        return WheelState(
            side.name,
            place,
            getattr(wheels, side.name) / FULL,
            finite(getattr(speed, f"{place}_rpm", None), 2),
            self._value(side.current, place, now),
            None if temperature is None else finite(temperature + KELVIN, 2),
            self._word(side.driver, now),
            _at(at),
            _worth(side.speed, at, now),
        )

    def _value(self, kind: type[RoverFrame], name: str, now: float) -> float | None:
        """While it is fresh."""
        frame, at = self._get(kind)
        return finite(getattr(frame, name, None)) if _worth(kind, at, now) == "fresh" else None

    def _word(self, kind: type[RoverFrame], now: float) -> str | None:
        """A state in words, while it is fresh."""
        frame, at = self._get(kind)
        status = getattr(frame, "status", None)
        return _words(status) if isinstance(status, Enum) and _worth(kind, at, now) == "fresh" else None

    def _battery(self, now: float) -> BatteryState:
        voltage, at = self._get(BatteryVoltage)
        temperatures = [self._value(BatteryTemperature, f"module{number}_c", now) for number in range(1, 7)]
        return BatteryState(
            finite(None if voltage is None else voltage.tap4, 3),
            [finite(getattr(voltage, f"cell{number}", None), 3) for number in range(1, 5)],
            [None if each is None else finite(each + KELVIN, 2) for each in temperatures],
            self._word(BmsStatus, now),
            _at(at),
            _worth(BatteryVoltage, at, now),
        )

    def _imu(self, now: float) -> ImuState:
        frame, at = self._get(Imu)
        acceleration, rate = (
            Vector(*(finite(getattr(frame, f"{what}_{axis}", None), 4) for axis in "xyz"))
            for what in ("acceleration", "rate")
        )
        return ImuState(acceleration, rate, _at(at), _worth(Imu, at, now))

    def _magnetometer(self, now: float) -> MagnetometerState:
        frame, at = self._get(Magnetometer)
        heading, strength = (None, None) if frame is None else (frame.magnetic_heading, frame.strength)
        return MagnetometerState(finite(heading), finite(strength, 8), _at(at), _worth(Magnetometer, at, now))

    def _gps(self, now: float) -> Position:
        frame, at = self._get(GpsPosition)
        if frame is None or frame.latitude_deg is None or frame.longitude_deg is None:
            return Position(None, None, _at(at), "absent")
        place = finite(frame.latitude_deg, 7), finite(frame.longitude_deg, 7)
        return Position(*place, _at(at), _worth(GpsPosition, at, now))

    def _own_frame(self, kind: type[RoverFrame], now: float) -> OwnFrame | None:
        frame, at = self._get(kind)
        if frame is None:
            return None
        units = {name: signal.unit for name, signal in kind.signals}
        units |= {name: derived.unit for name, derived in kind.DERIVED.items()}
        values = [OwnValue(name, unit, _own_value(getattr(frame, name))) for name, unit in units.items()]
        return OwnFrame(kind.FRAME, kind.__name__, values, seconds(at), _worth(kind, at, now))

    def _look(self, now: float) -> LinkQuality:
        """The quality of the link, looked at twice a second."""
        if self._looks and now < self._looks[-1][0] + QUALITY_PERIOD:
            return self._quality
        counts = Counter({identifier: newest.count for identifier, newest in self._newest.items()})
        then, before = self._looks[0] if self._looks else (now - QUALITY_PERIOD, counts)
        self._looks.append((now, counts))
        counters = self._rover.counters
        self._quality = LinkQuality(
            [self._rate(identifier, (counts[identifier] - before[identifier]) / (now - then)) for identifier in counts],
            sum(counters[reason] for reason in REJECTIONS if reason in counters),
            [
                Framing(port, framer.counters.frames, framer.counters.skipped, framer.counters.rejected)
                for port, framer in self._rover.framing().items()
            ],
            self._rover.settings.dialect,
        )
        return self._quality

    def _rate(self, identifier: int, rate: float) -> FrameRate:
        name = self._protocol.declarations[identifier].__name__
        return FrameRate(identifier, name, round(rate, 1), seconds(self._newest[identifier].at))


def _worth(kind: type[RoverFrame], at: float, now: float) -> Quality:
    """What the newest frame of a kind is worth: three of its periods, and at least a second."""
    return quality(at, now, max(SHORTEST, PERIODS / kind.RATE))


def _at(at: float) -> float | None:
    return None if at == float("-inf") else seconds(at)


def _own_value(value: object) -> float | str | None:
    match value:
        case Enum():
            return _words(value)
        case bool() | int() | float():
            return finite(float(value), 6)
        case _:
            return None


def _words(code: Enum) -> str:
    return code.name.lower().replace("_", " ")


def _cell(number: int) -> Sample:
    return lambda topics: topics["battery"].cells[number] if topics["battery"].quality == "fresh" else None


def _wheel(number: int, what: str) -> Sample:
    return lambda topics: fresh(topics["wheels"][number], what)


WHEELS = [f"{side.name}_{place}" for side in SIDES for place in PLACES]
SAMPLES: dict[str, Sample] = {
    "battery_voltage": lambda topics: fresh(topics["battery"], "voltage"),
    **{f"cell{number + 1}": _cell(number) for number in range(4)},
    "left": lambda topics: topics["drive"].left,
    "right": lambda topics: topics["drive"].right,
    **{
        f"{wheel}_{what}": _wheel(n, what)
        for n, wheel in enumerate(WHEELS)
        for what in ("rpm", "current", "temperature")
    },
    "heading": lambda topics: fresh(topics["magnetometer"], "heading"),
    "latitude": lambda topics: fresh(topics["gps"], "latitude"),
    "longitude": lambda topics: fresh(topics["gps"], "longitude"),
}
