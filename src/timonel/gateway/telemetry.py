"""What a rover tells, as it stands now: the newest of each frame in SI values, how old it is and what it is worth.

```python
telemetry[MotorCurrentRight].frame.front        # A, or None where the sensor gave nothing
telemetry[MotorCurrentRight].quality            # FRESH, or STALE
```
"""

from collections import deque
from collections.abc import Callable, Iterator
from enum import Enum
from typing import Generic, TypeVar

import msgspec

from timonel.errors import NoAnswerError
from timonel.vehicles.rover.declaration import RoverFrame
from timonel.vehicles.rover.frames import (
    BatteryState,
    BatteryTemperature,
    BatteryVoltage,
    BmsStatus,
    GpsPosition,
    MotorCurrentLeft,
    MotorCurrentRight,
    MotorTemperatureLeft,
    MotorTemperatureRight,
    WheelSpeedLeft,
    WheelSpeedRight,
)

PERIODS = 3  # that may pass without a frame until its last one is stale
SHORTEST = 1.0  # s that every value counts
WINDOW = 5.0  # s over which the quality of the link is taken

F = TypeVar("F", bound=RoverFrame)


class Quality(Enum):
    """What a value is worth."""

    FRESH = "fresh"
    STALE = "stale"  # three of its periods old, and at least a second
    NEVER = "never heard"


class Reading(msgspec.Struct, Generic[F], frozen=True):
    """The newest frame of a kind and its age in s."""

    frame: F
    age: float
    quality: Quality


class Wheel(msgspec.Struct, frozen=True):
    """One wheel, forward positive; `quality` is that of the worst of its values, None is not available."""

    side: str
    place: str
    rpm: float | None
    current: float | None
    """In A."""
    temperature_c: float | None
    quality: Quality


class Battery(msgspec.Struct, frozen=True):
    """Voltages in V, of the whole and of cells 1..4; temperatures of its six modules; None is not available.

    `age` in s and `quality` are those of the voltages.
    """

    voltage: float | None
    cells: tuple[float | None, ...]
    temperatures_c: tuple[float | None, ...]
    state: BatteryState | None
    age: float | None
    quality: Quality


class Position(msgspec.Struct, frozen=True):
    """Where the rover is, north and east positive; both None without a fix. `age` in s."""

    latitude_deg: float | None
    longitude_deg: float | None
    age: float | None
    quality: Quality


SPEEDS, CURRENTS, TEMPERATURES = "rpm", "current", "temperature_c"
SIDES: dict[str, dict[str, type[RoverFrame]]] = {
    "left": {SPEEDS: WheelSpeedLeft, CURRENTS: MotorCurrentLeft, TEMPERATURES: MotorTemperatureLeft},
    "right": {SPEEDS: WheelSpeedRight, CURRENTS: MotorCurrentRight, TEMPERATURES: MotorTemperatureRight},
}
PLACES = ("front", "middle", "rear")
SUFFIX = {SPEEDS: "_rpm", CURRENTS: "", TEMPERATURES: "_c"}


class Telemetry:
    """The newest frame of every kind; `clock` gives the time in s by which ages are told."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._newest: dict[type[RoverFrame], tuple[RoverFrame, float]] = {}

    def hear(self, frame: RoverFrame, now: float) -> None:
        """A frame came in at `now` (s)."""
        self._newest[type(frame)] = (frame, now)

    def __iter__(self) -> Iterator[type[RoverFrame]]:
        """The kinds that were heard."""
        return iter(self._newest)

    def __getitem__(self, kind: type[F]) -> Reading[F]:
        """Raises NoAnswerError if no such frame was ever heard."""
        reading = self.get(kind)
        if reading is None:
            raise NoAnswerError(f"{kind.__name__}: never heard")
        return reading

    def get(self, kind: type[F]) -> Reading[F] | None:
        """The newest frame of `kind`; None if none was ever heard."""
        frame, heard = self._newest.get(kind, (None, 0.0))
        if not isinstance(frame, kind):
            return None
        age = self._clock() - heard
        stale = age > max(SHORTEST, PERIODS / kind.RATE)
        return Reading(frame, age, Quality.STALE if stale else Quality.FRESH)

    def quality(self, kind: type[RoverFrame]) -> Quality:
        """What the newest frame of `kind` is worth."""
        reading = self.get(kind)
        return Quality.NEVER if reading is None else reading.quality

    @property
    def wheels(self) -> tuple[Wheel, ...]:
        """Left front, middle and rear, then the right ones."""
        return tuple(self._wheel(side, place) for side in SIDES for place in PLACES)

    def _wheel(self, side: str, place: str) -> Wheel:
        values = {name: self._value(kind, place + SUFFIX[name]) for name, kind in SIDES[side].items()}
        worst = self._worst(*SIDES[side].values())
        return Wheel(side, place, values[SPEEDS], values[CURRENTS], values[TEMPERATURES], worst)

    def _value(self, kind: type[RoverFrame], name: str) -> float | None:
        reading = self.get(kind)
        value: float | None = None if reading is None else getattr(reading.frame, name)
        return value

    def _worst(self, *kinds: type[RoverFrame]) -> Quality:
        found = {self.quality(kind) for kind in kinds}
        return next(quality for quality in (Quality.NEVER, Quality.STALE, Quality.FRESH) if quality in found)

    @property
    def battery(self) -> Battery:
        """The battery."""
        reading, bms = self.get(BatteryVoltage), self.get(BmsStatus)
        return Battery(
            voltage=self._value(BatteryVoltage, "tap4"),
            cells=tuple(self._value(BatteryVoltage, f"cell{number}") for number in range(1, 5)),
            temperatures_c=tuple(self._value(BatteryTemperature, f"module{number}_c") for number in range(1, 7)),
            state=None if bms is None else bms.frame.status,
            age=None if reading is None else reading.age,
            quality=self.quality(BatteryVoltage),
        )

    @property
    def position(self) -> Position:
        """The position by GPS."""
        reading = self.get(GpsPosition)
        if reading is None:
            return Position(None, None, None, Quality.NEVER)
        return Position(reading.frame.latitude_deg, reading.frame.longitude_deg, reading.age, reading.quality)


class LinkQuality(msgspec.Struct, frozen=True):
    """How well the link carries: over the last seconds the `share` 0..1 of its bytes that were in frames.

    `share` is None where nothing came in; `frames` a second. `skipped` bytes and `resynchronised` are all since it was
    opened.
    """

    share: float | None
    frames: float
    skipped: int
    resynchronised: int


class LinkWatch:
    """Counts by time what the link carries."""

    def __init__(self) -> None:
        self._samples: deque[tuple[float, int, int, int]] = deque()

    def sample(self, now: float, received: int, skipped: int, frames: int) -> None:
        """The counters at `now` (s): bytes received, bytes skipped, frames."""
        self._samples.append((now, received, skipped, frames))
        while self._samples[0][0] < now - WINDOW:
            self._samples.popleft()

    def quality(self, skipped: int, resynchronised: int) -> LinkQuality:
        """What the samples say, beside the sums."""
        if len(self._samples) < 2:
            return LinkQuality(None, 0.0, skipped, resynchronised)
        seconds, received, lost, frames = (
            last - first for first, last in zip(self._samples[0], self._samples[-1], strict=True)
        )
        share = 1 - min(1.0, lost / received) if received else None
        return LinkQuality(share, frames / seconds if seconds else 0.0, skipped, resynchronised)
