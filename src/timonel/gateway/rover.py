"""The other end of a rover's link: for programs on board (the Jetson's end) and for operators.

```python
async with Rover.open("tcp://rover:5000", station=2) as r:
    await r.enable()
    await r.drive(forward=0.3, right=0.0)
    print(r.battery.voltage, r.telemetry[MotorCurrentRight].frame.front)
```
What keeps a rover from driving on by itself:

what                         what becomes of it
a set point                  is said 20 times a second, and is at rest `hold` seconds after the last `drive`
the program hangs or dies    nothing is said any more: the rover rests after 0.2 s, and after 0.5 s needs `enable` anew
a motor driver stops         no set point is said any more, `drive` raises; somebody stopped the rover, or took over
a motor driver is silent     the same, and the rover is told to stop: who cannot see does not drive
the link is lost             the same; it is opened again, and `enable` is needed anew
the block is left            the rover is stopped, if we drove

The wire has no words for command. Who is in command drives, and to drive is to ask for it: station 1 takes it, others
wait until whoever commands gives it, or has been silent. That we may drive is known from the motor drivers (frames 116
and 117), who say so themselves. A program that only listens says nothing, and its end stops nobody.
"""

import asyncio
from collections.abc import Callable
from contextlib import suppress
from enum import Enum
from math import floor
from pathlib import Path
from types import TracebackType
from typing import Self, TypeVar
from weakref import WeakSet

import msgspec

from timonel.core.command import BRIDGE, STATIONS
from timonel.core.frame import Frame
from timonel.core.mistakes import did_you_mean
from timonel.errors import ConfigError, EncodeError, NoAnswerError, RefusedError, StationError
from timonel.gateway import own_frames
from timonel.gateway.telemetry import Battery, LinkQuality, LinkWatch, Position, Telemetry, Wheel
from timonel.links.uart_bus import UartBus
from timonel.links.urls import commanding_link, with_default
from timonel.vehicles.rover.calibration import CALIBRATIONS, PHYSICAL, Calibration
from timonel.vehicles.rover.declaration import Party, RoverFrame
from timonel.vehicles.rover.frames import (
    CurrentLimit,
    DriveCode,
    DriveCommand,
    DriveEnable,
    DriverState,
    MotorDriverStatusLeft,
    MotorDriverStatusRight,
    PowerLimit,
    SpeedLimit,
)
from timonel.vehicles.rover.framing import DIALECTS
from timonel.vehicles.rover.framing import Counters as Framing
from timonel.vehicles.rover.protocol import Protocol

PERIOD = 0.05  # s: 20 Hz
CEILING = 0.02  # s: 50 Hz, for set points that come faster
HOLD = 0.5  # s
HOLD_MAX = 10.0  # s
AGAIN = 0.2  # s until a permission that shows no effect is said again
STOPS = 5  # times that a stop is said at least
STOP_TIMEOUT = 1.0  # s
TIMEOUT = 2.0  # s: the drivers tell their state ten times a second
REQUEST_TIMEOUT = 12.0  # s: the commander's ten, and two in reserve
DRIVER_SILENT = 1.0  # s
SILENT = 2.0  # s
LIMITS_PERIOD = 1.0  # s
KEPT = 4096  # frames for a reader that does not read

DriverStatus = MotorDriverStatusRight | MotorDriverStatusLeft
DRIVERS: dict[type[DriverStatus], str] = {
    MotorDriverStatusRight: "right motor driver",
    MotorDriverStatusLeft: "left motor driver",
}
OURS = (DriveCommand, DriveEnable)

Choice = TypeVar("Choice")


class Phase(Enum):
    """How far we are with driving."""

    IDLE = "not enabled"
    ENABLING = "asking"
    ENABLED = "enabled"


class Driver(msgspec.Struct, frozen=True):
    """What a motor driver said last, and when (s)."""

    state: DriverState | None
    heard: float


class Frames:
    """Typed frames from the moment it was made, until the rover is closed. The oldest give way if nobody reads."""

    def __init__(self) -> None:
        self._queue: asyncio.Queue[RoverFrame | None] = asyncio.Queue()

    def put(self, frame: RoverFrame | None) -> None:
        if self._queue.qsize() >= KEPT:
            self._queue.get_nowait()
        self._queue.put_nowait(frame)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> RoverFrame:
        frame = await self._queue.get()
        if frame is None:
            self._queue.put_nowait(None)
            raise StopAsyncIteration
        return frame


class Rover:
    """A rover at the far end of `bus`; an async context manager, usually made by `open`."""

    def __init__(self, bus: UartBus, protocol: Protocol, *, station: int) -> None:
        if station not in STATIONS:
            raise StationError(f"station: {station} is not 1 (operator), 2 (Jetson), 3 or 4")
        self.station = station
        self.protocol = protocol
        self.phase = Phase.IDLE
        self.telemetry = Telemetry(self._now)
        self._bus = bus
        self._watch = LinkWatch()
        self._x = self._y = 0
        self._rests_at = 0.0
        self._said_at = 0.0
        self._why_idle = "enable it first"
        self._limits: dict[int, RoverFrame] = {}
        self._limits_due = 0.0
        self._drivers: dict[type[DriverStatus], Driver] = {}
        self._drivers_spoke = asyncio.Event()
        self._enabling = asyncio.Lock()
        self._down: str | None = None
        self._heard = 0.0
        self._readers: WeakSet[Frames] = WeakSet()

    @classmethod
    def open(
        cls,
        url: str,
        *,
        station: int,
        dialect: str = "strzyga",
        calibration: str | Calibration = PHYSICAL,
        frames: str | Path | None = None,
    ) -> Self:
        """A rover on the link `url`, for `async with`: `tcp://host:port`, `serial:///dev/ttyUSB0?baud=115200` ...

        `dialect` is how frames are written there; `calibration` one of "physical" and "documented", or constants of
        one's own; `frames` a file that declares more of them. Raises LinkError for a bad URL, StationError for a
        station outside 1..4, ConfigError for anything else that is not there.
        """
        if isinstance(calibration, str):
            calibration = _chosen("calibration", calibration, CALIBRATIONS)
        protocol = Protocol(calibration, () if frames is None else own_frames.load(frames))
        framer = _chosen("dialect", dialect, DIALECTS)(protocol.lengths(Party.OPERATOR))
        link = commanding_link(with_default(url, "raw", "yes"), name="rover")
        return cls(UartBus(link, framer), protocol, station=station)

    async def __aenter__(self) -> Self:
        self._loop = asyncio.get_running_loop()
        self._heard = self._loop.time()
        try:
            await self._bus.open(self._receive, self._link_changed)
        except BaseException:
            await self._bus.close(0.0)
            raise
        self._speaking = self._loop.create_task(self._speak(), name="rover")
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if self.phase is not Phase.IDLE:
                with suppress(NoAnswerError):  # what we cannot tell it, our silence does
                    await self.stop()
        finally:
            self._speaking.cancel()
            await self._bus.close()
            for reader in self._readers:
                reader.put(None)

    def _now(self) -> float:
        return self._loop.time()

    # What is known --------------------------------------------------------------------------------

    @property
    def enabled(self) -> bool:
        """Whether the rover follows our set points, as far as its motor drivers say."""
        return self.phase is Phase.ENABLED

    @property
    def lost(self) -> str | None:
        """Why the rover is out of reach; None while it is heard, and in the first 2 s."""
        if self._down is not None:
            return self._down
        return f"nothing heard for {SILENT:g} s" if self._now() - self._heard > SILENT else None

    @property
    def why_idle(self) -> str:
        """Why the rover does not follow us, while it does not."""
        return self._why_idle

    @property
    def setpoint(self) -> tuple[float, float]:
        """What we ask of it now: forward and right, -1..1."""
        x, y = self._stick(self._now())
        return -x / 100, y / 100

    @property
    def wheels(self) -> tuple[Wheel, ...]:
        """The six wheels, left ones first."""
        return self.telemetry.wheels

    @property
    def battery(self) -> Battery:
        """The battery."""
        return self.telemetry.battery

    @property
    def position(self) -> Position:
        """Where it is."""
        return self.telemetry.position

    @property
    def link(self) -> LinkQuality:
        """How well the link carries what the rover says."""
        framing = self.framing
        return self._watch.quality(framing.skipped, framing.resynchronised)

    @property
    def framing(self) -> Framing:
        """Counters of what came in."""
        return self._bus.framer.counters

    def frames(self) -> Frames:
        """Every frame from now on, typed and in SI values: `async for frame in r.frames()`."""
        frames = Frames()
        self._readers.add(frames)
        return frames

    # Driving --------------------------------------------------------------------------------------

    async def enable(self, timeout: float | None = None) -> None:
        """Get command, and permission to move; the stick is at rest meanwhile.

        Raises NoAnswerError if the motor drivers do not say that they run within `timeout` s (2, and 12 for stations
        that have to ask for command), RefusedError if they cannot run, or if `stop` came first.
        """
        async with self._enabling:
            if self.enabled:
                return
            self._reachable("enable")
            seconds = timeout if timeout is not None else TIMEOUT if self.station == BRIDGE else REQUEST_TIMEOUT
            self._rest()
            self.phase = Phase.ENABLING
            try:
                await asyncio.wait_for(self._enable(self._now()), seconds)
            except TimeoutError:
                raise NoAnswerError(f"enable: {self.lost or self._unconfirmed()} within {seconds:g} s") from None
            finally:
                if not self.enabled:
                    # silence ends a permission that we did not see, and disturbs nobody else
                    self._fall_silent("it could not be enabled")

    async def _enable(self, began: float) -> None:
        """Somebody else's permission ends when command passes to us, so that one which comes after it is ours."""
        self._say_stick()
        while not self._all_drivers(lambda driver: driver.heard > began and driver.state is DriverState.STOPPED):
            self._still_asking()
            await self._drivers_speak(began)
        said = float("-inf")
        while not self._all_drivers(lambda driver: driver.state is DriverState.RUNNING):
            self._still_asking()
            if self._now() >= said + AGAIN:
                said = self._now()
                self._say(DriveEnable(code=DriveCode.PERMIT))
            await self._drivers_speak(began)
        self._still_asking()
        self.phase = Phase.ENABLED
        self._say_limits()

    def _still_asking(self) -> None:
        if self.phase is not Phase.ENABLING:
            raise RefusedError(f"enable: {self._why_idle}")

    async def _drivers_speak(self, began: float) -> None:
        """Until a motor driver has said something, or for as long as we wait until we say the same again."""
        self._drivers_spoke.clear()
        with suppress(TimeoutError):
            await asyncio.wait_for(self._drivers_spoke.wait(), AGAIN)
        for kind, driver in self._drivers.items():
            if driver.heard > began and driver.state not in (DriverState.RUNNING, DriverState.STOPPED):
                raise RefusedError(f"enable: {DRIVERS[kind]}: {_words(driver.state)}")

    def _all_drivers(self, does: Callable[[Driver], bool]) -> bool:
        return len(self._drivers) == len(DRIVERS) and all(map(does, self._drivers.values()))

    def _unconfirmed(self) -> str:
        if missing := [name for kind, name in DRIVERS.items() if kind not in self._drivers]:
            return f"no word from the {' and the '.join(missing)}"
        if self._all_drivers(lambda driver: driver.state is DriverState.RUNNING):
            return "somebody else drives, and has not given command"
        return "the motor drivers do not run; somebody else may be in command"

    async def drive(self, forward: float, right: float = 0.0, *, hold: float = HOLD) -> None:
        """Move on: `forward` and `right` of full speed, -1..1, for `hold` s (at most 10) unless this is called again.

        Raises EncodeError for values out of range, RefusedError if the rover is not enabled, NoAnswerError if it is
        out of reach.
        """
        for name, value, lowest, highest in (("forward", forward, -1, 1), ("right", right, -1, 1)):
            _check(name, value, lowest, highest)
        _check("hold", hold, 0, HOLD_MAX)
        self._reachable("drive")
        if not self.enabled:
            raise RefusedError(f"drive: not enabled: {self._why_idle}")
        now = self._now()
        self._x, self._y = -round(forward * 100), round(right * 100)
        self._rests_at = now + hold
        if now >= self._said_at + CEILING:
            self._say_stick()

    async def stop(self, timeout: float = STOP_TIMEOUT) -> None:
        """Stop the rover, whoever drives it. Said five times at least, and until the motor drivers stand.

        Raises NoAnswerError if they do not say so within `timeout` s.
        """
        drove, began = self.phase is not Phase.IDLE, self._now()
        self._fall_silent("it was stopped")
        said = 0
        while said < STOPS or not self._stand(began):
            if self._now() > began + timeout:
                raise NoAnswerError(f"stop: {self.lost or f'the motor drivers run on after {timeout:g} s'}")
            self._say_stop(drove)
            said += 1
            await asyncio.sleep(PERIOD)

    def _stand(self, began: float) -> bool:
        return self._all_drivers(lambda driver: driver.heard > began and driver.state is not DriverState.RUNNING)

    # Limits ---------------------------------------------------------------------------------------

    async def speed_limit(self, share: float) -> None:
        """Full speed is `share` of the motors' own from now on: 0.05..1, in steps of 0.05 and never more than asked."""
        self._limit(SpeedLimit(steps=_steps("speed limit", share, 20)))

    async def power_limit(self, share: float) -> None:
        """Power of the motors, as `speed_limit`."""
        self._limit(PowerLimit(steps=_steps("power limit", share, 20)))

    async def current_limit(self, share: float) -> None:
        """Current of the motors: 0.005..1, in steps of 0.005."""
        self._limit(CurrentLimit(steps=_steps("current limit", share, 200)))

    def _limit(self, limit: RoverFrame) -> None:
        """Kept and repeated while we drive: it counts from the commander only, and nobody acknowledges it."""
        self._limits[limit.FRAME] = limit
        if self.enabled:
            self._say(limit)

    async def send(self, frame: RoverFrame) -> None:
        """Say one of the owner's own frames, for a manipulator or a probe; it counts while we are in command.

        Raises EncodeError for a frame that is not for the rover, or that has a method of its own here.
        """
        if frame.TO is not Party.ROVER or isinstance(frame, OURS):
            raise EncodeError(f"{type(frame).__name__}: not a frame to send; drive, enable and stop say theirs")
        self._reachable("send")
        self._say(frame)

    # Speaking and listening -----------------------------------------------------------------------

    def _reachable(self, what: str) -> None:
        if self.lost is not None:
            raise NoAnswerError(f"{what}: {self.lost}")

    def _say(self, *frames: RoverFrame) -> None:
        self._bus.send([Frame(*self.protocol.encode(frame), extended=False) for frame in frames])

    def _say_stick(self) -> None:
        self._said_at = self._now()
        x, y = self._stick(self._said_at)
        self._say(DriveCommand(y=y, x=x))

    def _say_limits(self) -> None:
        self._limits_due = self._now() + LIMITS_PERIOD
        self._say(*self._limits.values())

    def _say_stop(self, drove: bool) -> None:
        """A stick at rest would be a request for command, if we were not driving."""
        self._say(DriveEnable(code=DriveCode.STOP), *([DriveCommand(y=0, x=0)] if drove else []))

    def _stick(self, now: float) -> tuple[int, int]:
        return (self._x, self._y) if now < self._rests_at else (0, 0)

    def _rest(self) -> None:
        self._x = self._y = 0

    def _fall_silent(self, why: str) -> None:
        self._rest()
        self.phase = Phase.IDLE
        self._why_idle = why

    async def _speak(self) -> None:
        while True:
            self._tick(self._now())
            await asyncio.sleep(PERIOD)

    def _tick(self, now: float) -> None:
        framing = self.framing
        self._watch.sample(now, self._bus.counters.bytes_in, framing.skipped, framing.frames)
        if self.enabled:
            self._look(now)
        if self.phase is Phase.IDLE:
            return
        self._say_stick()
        if self.enabled and now >= self._limits_due:
            self._say_limits()

    def _look(self, now: float) -> None:
        for kind, driver in self._drivers.items():
            if now - driver.heard > DRIVER_SILENT:
                self._give_up(f"no word from the {DRIVERS[kind]} for {DRIVER_SILENT:g} s")

    def _give_up(self, why: str) -> None:
        self._fall_silent(why)
        self._say_stop(drove=True)

    def _receive(self, frames: list[Frame]) -> None:
        now = self._heard = self._now()
        for frame in frames:
            message = self.protocol.decode(frame.identifier, frame.data)
            if message is not None:
                self._hear(message, now)

    def _hear(self, message: RoverFrame, now: float) -> None:
        self.telemetry.hear(message, now)
        if isinstance(message, DriverStatus):
            self._hear_driver(type(message), message.status, now)
        for reader in self._readers:
            reader.put(message)

    def _hear_driver(self, kind: type[DriverStatus], state: DriverState | None, now: float) -> None:
        self._drivers[kind] = Driver(state, now)
        self._drivers_spoke.set()
        if self.enabled and state is DriverState.STOPPED:
            # whoever stopped it, or drives now, is not to hear of us again: our stick would ask for command
            self._fall_silent(f"{DRIVERS[kind]}: stopped; somebody stopped it, or took command")
        elif self.enabled and state is not DriverState.RUNNING:
            self._give_up(f"{DRIVERS[kind]}: {_words(state)}")

    def _link_changed(self, connected: bool, reason: str) -> None:
        self._down = None if connected else reason or "not connected"
        if connected:
            self._heard = self._now()
        elif self.phase is not Phase.IDLE:
            self._fall_silent(f"the link was lost: {self._down}")


def _words(state: DriverState | None) -> str:
    return "unknown" if state is None else state.name.lower().replace("_", " ")


def _chosen(what: str, name: str, among: dict[str, Choice]) -> Choice:
    if name not in among:
        raise ConfigError(f'{what}: "{name}" is not one of {", ".join(among)}{did_you_mean(name, among)}')
    return among[name]


def _check(name: str, value: float, lowest: float, highest: float) -> None:
    if not lowest <= value <= highest:
        raise EncodeError(f"{name}: {value} is outside {lowest:g}..{highest:g}")


def _steps(name: str, share: float, highest: int) -> int:
    """A share as a limit has it; the nearest step below, so that no limit is exceeded."""
    _check(name, share, 1 / highest, 1)
    return floor(share * highest + 1e-9)
