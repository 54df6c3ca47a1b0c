"""A voyage of a simulated boat or rover in counted time, with everything that goes wrong on board, and recorded.

What happens is drawn from a seed: frames get lost, come late or in heaps, ports say commands, garbage and halves of
both, are unplugged and plugged in again, the bus falls silent and is flooded. The recorder is the gateway's own; there
is no loop and nobody waits.
"""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Protocol

from timonel.core.effects import Effect, Transmit
from timonel.core.frame import Frame
from timonel.gateway import machine
from timonel.gateway.configuration import Configuration
from timonel.gateway.link_settings import Station
from timonel.gateway.moment import microseconds, seconds
from timonel.gateway.recorder import FORMAT, Recorder
from timonel.nmea0183 import parp
from timonel.nmea0183.sentences import ACK
from timonel.recording.flight_writer import FlightWriter, Limits
from timonel.vehicles.boat import simulator as boat_simulator
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.simulator import SimulatedBoat
from timonel.vehicles.rover import simulator as rover_simulator
from timonel.vehicles.rover.framing import DIALECTS
from timonel.vehicles.rover.settings import RoverSettings
from timonel.vehicles.rover.simulator import SimulatedRover
from timonel.vehicles.rover.vehicle import PERMIT

PORTS = tuple(Port(name, number) for number, name in enumerate(("Bridge", "Cockpit", "Flybridge", "Reserve"), 1))
STATIONS = tuple(Station(port, f"pty:///{port.name}", f"pty:///{port.name}") for port in PORTS)
DATA = Path(__file__).parent / "data"
BEGAN_NS = 1_790_000_000_000_000_000
UPTIME_US = 12_345_678_901  # of the computer when the voyage begins
LIMITS = Limits()
TICK_US = 50_000
BOAT = Configuration("voyage", BoatSettings(name="voyage", variation_model=False), "loop://voyage", STATIONS)
ROVER = Configuration("voyage", RoverSettings(name="voyage"), "loop://voyage", STATIONS)
COMMANDS = [verb for verb in parp.Verb for _ in range(3 if verb.value.endswith("CMD") else 1)]
ROVER_FRAMES = {100: 2, 101: 1, 119: 1}  # what stations say, and the length of each


class Simulated(Protocol):
    def receive(self, frame: Frame) -> None: ...
    def step(self, dt: float) -> list[Frame]: ...


class Voyage:
    """One run. `told` counts the steps of the machine, `flush` is in s."""

    def __init__(
        self,
        directory: Path,
        configuration: Configuration,
        seed: int = 1,
        *,
        limits: Limits = LIMITS,
        flush: float = 1.0,
    ) -> None:
        self.configuration = configuration
        self.us = UPTIME_US
        self.told = 0
        self.on_board = isinstance(configuration.vehicle, BoatSettings)
        self._random = Random(seed)
        self.model: Simulated = SimulatedBoat(seed) if self.on_board else SimulatedRover(seed)
        description = machine.describe(configuration, seconds(self.us))
        self.machine = machine.make(description)
        run = {
            "format": FORMAT,
            "run": f"{type(configuration.vehicle).__name__} {seed}",
            "boot_id": "",
            "simulated": "yes",
            "seed": str(seed),
        }
        self.writer = FlightWriter(
            directory,
            configuration.vehicle.name,
            limits,
            lambda number: {
                "timonel.recording": run | {"segment": str(number)},
                "timonel.machine": description,
            },
            began_ns=BEGAN_NS,
        )
        self.recorder = Recorder([port.name for port in PORTS], self._put, seconds(self.us), wall=self._wall)
        self._flush_us = microseconds(flush)
        self._flushed = self.us
        self._held: list[Frame] = []

    @property
    def now(self) -> float:
        return seconds(self.us)

    def _wall(self) -> int:
        return BEGAN_NS + (self.us - UPTIME_US) * 1000

    def _put(self, page: object) -> None:
        self.writer.put(page)  # type: ignore[arg-type]
        self.writer.drain()

    # What can happen --------------------------------------------------------------------------------------

    def sail(self, duration: float) -> Path:
        """So many seconds; where the recording is."""
        end = self.us + microseconds(duration)
        trouble = self._troubles()
        while self.us < end:
            next(trouble)
            self._tick()
        self.recorder.flush(self.now)
        self.writer.finish()
        return sorted(self.writer.directory.iterdir())[0]

    def _tick(self) -> None:
        """The stations speak, the bus is heard; each at its own moment."""
        until = self.us + TICK_US
        frames = self.model.step(TICK_US / 1e6)
        for act in self._acts(frames):
            self._wait(self.us + self._random.randrange(1, 4000))
            act()
        self._wait(max(until, self.us + 1))

    def _acts(self, frames: list[Frame]) -> Iterator[Callable[[], None]]:
        heard = self._held + [frame for frame in frames if self._random.random() > 0.01]
        self._held = []
        while heard:
            batch = heard[: self._random.randrange(1, 9)]
            del heard[: len(batch)]
            yield lambda batch=batch: self._hear(batch)  # type: ignore[misc]
        for port in PORTS:
            if self._random.random() < (0.02 if self.on_board else 0.5):
                yield lambda port=port: self._speak(port.name, self._words(port))  # type: ignore[misc]

    def _troubles(self) -> Iterator[None]:
        """Every tick: perhaps something begins that lasts a while."""
        faults: Sequence[str] = list(boat_simulator.Fault if self.on_board else rover_simulator.Fault)
        broken: dict[str, int] = {}
        while True:
            for fault in [fault for fault, ends in broken.items() if self.us >= ends]:
                del broken[fault]
                self.model.restore(fault)  # type: ignore[attr-defined]
            match self._random.randrange(2000):
                case 0:
                    fault = self._random.choice(faults)
                    broken[fault] = self.us + self._random.randrange(60_000_000)
                    self.model.silence(fault)  # type: ignore[attr-defined]
                case 1:
                    self._plug(self._random.choice(PORTS).name, self._random.random() < 0.6)
                case 2:
                    self._flood(self._random.choice(PORTS))
                case 3:
                    self._held = [self._stranger() for _ in range(self._random.randrange(200))]
            yield

    def _flood(self, port: Port) -> None:
        for _ in range(100):
            self._speak(port.name, self._words(port))

    def _stranger(self) -> Frame:
        extended = self._random.random() < 0.5
        number = self._random.getrandbits(29 if extended else 11)
        return Frame(number, self._random.randbytes(self._random.randrange(9)), extended)

    def _words(self, port: Port) -> bytes:
        """What a station says: mostly sense."""
        words = self._command(port) if self.on_board else self._frame(port)
        match self._random.randrange(20):
            case 0:
                return self._random.randbytes(self._random.randrange(1, 60))
            case 1:
                return words[: self._random.randrange(len(words))]
            case 2:
                place = self._random.randrange(len(words))
                return words[:place] + self._random.randbytes(1) + words[place + 1 :]
            case _:
                return words

    def _command(self, port: Port) -> bytes:
        assert port.station is not None
        if self._random.random() < 0.05:
            return ACK(self._random.randrange(101, 107)).encode()
        verb = self._random.choice(COMMANDS)
        station = port.station if self._random.random() < 0.95 else self._random.randrange(1, 5)
        return parp.command(verb, station, self._random.randrange(3600) / 10)

    def _frame(self, port: Port) -> bytes:
        settings = self.configuration.vehicle
        assert isinstance(settings, RoverSettings)
        number = self._random.choice([100, 100, 100, 100, 101, 119])
        data = PERMIT if number == 101 and self._random.random() < 0.8 else None
        data = data or self._random.randbytes(ROVER_FRAMES[number])
        return DIALECTS[settings.dialect].write(number, data)

    # The gateway's part -----------------------------------------------------------------------------------

    def _wait(self, us: int) -> None:
        """Time passes; what is due happens at its time, or a little late."""
        while (due := self.machine.deadline) <= seconds(us):
            self.us = min(us, max(self.us, microseconds(due) + self._random.randrange(1, 1500)))
            self.told += 1
            self.recorder.expired(self.now)
            self._carry_out(self.machine.expire(self.now))
        self.us = max(self.us, us)
        if self.us >= self._flushed + self._flush_us:
            self._flushed = self.us
            self.recorder.flush(self.now)

    def _hear(self, frames: list[Frame]) -> None:
        self.told += 1
        self.recorder.frames_received(frames, self.now)
        self._carry_out(self.machine.receive_frames(frames, self.now))

    def _speak(self, port: str, data: bytes) -> None:
        self.told += 1
        self.recorder.bytes_received(port, data, self.now)
        self._carry_out(self.machine.receive_bytes(port, data, self.now))

    def _plug(self, port: str, connected: bool) -> None:
        self.told += 1
        self.recorder.port_changed(port, connected, self.now)
        self._carry_out(self.machine.port_changed(port, connected, self.now))

    def _carry_out(self, effects: list[Effect]) -> None:
        if effects:
            self.recorder.answered(effects, self.now)
        for effect in effects:
            if isinstance(effect, Transmit):
                self.model.receive(effect.frame)


def main() -> None:
    """Make the recordings that later versions must replay to the same bytes."""
    for name, configuration, duration in (("boat", BOAT, 26.0), ("rover", ROVER, 9.0)):
        with TemporaryDirectory() as directory:
            made = Voyage(Path(directory), configuration, seed=56).sail(duration)
            (DATA / f"{name}.mcap").write_bytes(made.read_bytes())


if __name__ == "__main__":
    main()
