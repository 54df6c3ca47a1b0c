"""The whole machine of a boat against a simulated pilot, in the machine's own time: nobody waits for anything."""

from math import degrees, radians

from timonel.core.effects import Effect, Refused, Say, SayTo, Transmit
from timonel.nmea0183 import parp
from timonel.nmea0183.parp import Verb
from timonel.nmea2000.fastpacket import Reassembler
from timonel.nmea2000.identifier import split
from timonel.nmea2000.registry import is_fast
from timonel.vehicles.boat.pilot import Mode
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.simulated_pilots import DIALECTS, Dialect, SentenceDialect
from timonel.vehicles.boat.simulator import VARIATION, SimulatedBoat
from timonel.vehicles.boat.vehicle import Boat

TICK = 0.05  # s
PORTS = [Port(f"IN{station}", station) for station in (1, 2, 3, 4)]


def apart(a: float, b: float) -> float:
    """The difference of two angles in degrees."""
    return abs((a - b + 180) % 360 - 180)


class AtSea:
    """A boat under way with a pilot of `kind`; station 1 speaks for it."""

    def __init__(self, kind: str, **settings: object) -> None:
        self.dialect: Dialect = DIALECTS[kind]()
        output = {"pilot_output": "Pilot"} if kind == "sentence" else {}
        self.boat = Boat(BoatSettings(pilot=kind, **output, **settings), PORTS, now=0.0)  # type: ignore[arg-type]
        self.sea = SimulatedBoat(dialect=self.dialect, heading=radians(45))
        self.now = 0.0
        self.effects: list[Effect] = []
        self.sent: list[tuple[float, int, int, bytes]] = []
        """What was put on the bus: when, PGN, destination, payload."""
        self.deaf = False
        self.silent = False
        self.muted: set[int] = set()
        """Devices that the gateway does not hear."""
        self._reassembler = Reassembler()

    # Time ------------------------------------------------------------------------------------------

    def run(self, seconds: float) -> "AtSea":
        """Let time pass."""
        for _ in range(round(seconds / TICK)):
            self.now = round(self.now + TICK, 6)
            frames = self.sea.step(TICK)
            muted = self.muted | ({self.dialect.address} if self.silent else set())
            frames = [frame for frame in frames if split(frame.identifier).source not in muted]
            self._take(self.boat.receive_frames(frames, self.now))
            while self.boat.deadline <= self.now:
                self._take(self.boat.expire(self.now))
        return self

    def until(self, condition: object, within: float = 60.0) -> float:
        """Let time pass until something holds; how long it took."""
        began = self.now
        while not condition():  # type: ignore[operator]
            assert self.now - began < within, f"not within {within} s"
            self.run(TICK)
        return self.now - began

    # Words -----------------------------------------------------------------------------------------

    def say(self, verb: Verb, parameter: float = 0.0, station: int = 1) -> list[Effect]:
        before = len(self.effects)
        self._take(self.boat.receive_bytes(f"IN{station}", parp.command(verb, station, parameter), self.now))
        return self.effects[before:]

    def in_command(self) -> "AtSea":
        """Under way for two seconds, with station 1 in command."""
        self.run(2.0).say(Verb.TAKECMD)
        return self

    def engaged(self) -> "AtSea":
        """The same, with the pilot engaged and what it reported told."""
        self.in_command().say(Verb.ENGAGE)
        self.until(lambda: self.dialect.law.engaged)
        return self.run(1.5)

    def refusals(self, effects: list[Effect]) -> list[str]:
        return [effect.reason for effect in effects if isinstance(effect, Refused)]

    def another_head_turns(self, change_deg: float) -> "AtSea":
        """Somebody turns the pilot at its own control head."""
        self.sea.tell(self.dialect.turn(radians(change_deg)))
        return self

    # What is seen ----------------------------------------------------------------------------------

    @property
    def mode(self) -> Mode:
        return self.boat.helm.pilot.mode

    @property
    def setpoint(self) -> float | None:
        """In degrees, as STATUS shows it."""
        tenths = self.boat.helm.pilot.setpoint
        return None if tenths is None else tenths / 10

    @property
    def heading(self) -> float:
        """Of the bow, true, in degrees."""
        return degrees(self.sea.hull.heading)

    @property
    def held(self) -> float:
        """What the pilot steers, true, in degrees."""
        magnetic = self.dialect.law.reference is not None and self.dialect.law.reference.name == "MAGNETIC"
        return degrees(self.dialect.law.setpoint + (VARIATION if magnetic else 0.0)) % 360

    @property
    def alerts(self) -> list[str]:
        return [alert.kind.name for alert in self.boat.helm.alerts.standing if alert.active]

    def commands(self, *pgns: int) -> list[bytes]:
        """The payloads that went to the pilot."""
        return [payload for _, pgn, _, payload in self.sent if pgn in pgns]

    @property
    def lines(self) -> list[str]:
        return [effect.line.decode().strip() for effect in self.effects if isinstance(effect, Say | SayTo)]

    def _take(self, effects: list[Effect]) -> None:
        self.effects += effects
        for effect in effects:
            if isinstance(effect, SayTo) and isinstance(self.dialect, SentenceDialect) and not self.deaf:
                self.dialect.hear(effect.line, self.sea.hull.heading)
            if not isinstance(effect, Transmit):
                continue
            if not self.deaf:
                self.sea.receive(effect.frame)
            target = split(effect.frame.identifier)
            payload: bytes | None = effect.frame.data
            if is_fast(target.pgn):
                payload = self._reassembler.receive(effect.frame.identifier, effect.frame.data, self.now)
            if payload is not None:
                self.sent.append((self.now, target.pgn, target.destination, payload))
