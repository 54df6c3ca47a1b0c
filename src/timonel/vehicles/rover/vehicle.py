"""The whole controller of a rover as one machine: bytes of UART links and CAN frames in, the same and events out.

in                       what happens                                                     out
frames of a station      framed, bound to the port's station, obeyed (`helm`)             102, 103, 101, limits on CAN
frames of the modules    checked, watched (`watch`)                                       telemetry on every link
time                     the ladder of stops, repetition at 50 Hz                         102, 103, 101, limits on CAN

In the role `operator` the far end of the link is a real controller that does the mixing itself: what comes out then is
100 and 101, and never 102 or 103; the permission is said three times and not for ever, so that the far end's own stop
lasts; and a rover that falls silent for 500 ms is stopped as a lost commander is.

Where a frame goes is declared with the frame. No frame goes out more often than 50 times a second, and on a link that
cannot keep up the newest of each takes the place of an older one.
"""

from collections import Counter
from collections.abc import Sequence

from timonel.core.command import NOBODY, OnTimeout, Transferred
from timonel.core.effects import Effect, Event, Refused, Rejected, Say, SecurityEvent, Transmit
from timonel.core.frame import Frame
from timonel.core.pace import Pace
from timonel.vehicles.rover.console import CONSOLE, VERBS, Console, Word
from timonel.vehicles.rover.declaration import Party
from timonel.vehicles.rover.drive import SILENT, STOP_BURST, STOP_PERIOD, Drive, Permission, Stick, Stop, Wheels
from timonel.vehicles.rover.frames import (
    CurrentLimit,
    DriveCode,
    DriveCommand,
    DriveEnable,
    PowerLimit,
    SpeedLimit,
    WheelSpeedSetLeft,
    WheelSpeedSetRight,
)
from timonel.vehicles.rover.framing import DIALECTS, Framer
from timonel.vehicles.rover.helm import Helm
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.segments import SINGLE, Joiner, split
from timonel.vehicles.rover.settings import Port, RoverSettings
from timonel.vehicles.rover.watch import Watch

GRANTS = 3  # times that a permission is said to a controller at the far end of a link
CEILING = 0.02  # s: no frame is sent more often than 50 times a second
LIMITS_PERIOD = 1.0  # s between repetitions of the limits; a module that was restarted has forgotten them
PERMIT = bytes((DriveCode.PERMIT,))
FORBID = bytes((0xCE,))  # eight bits away from PERMIT
LIMITS = {PowerLimit.FRAME: 20, SpeedLimit.FRAME: 20, CurrentLimit.FRAME: 200}  # the highest step of each


def signed(byte: int) -> int:
    """An int8."""
    return byte - 256 if byte > 127 else byte


def three(percent: int) -> bytes:
    """One set point for the three wheels of a side."""
    return bytes((percent & 0xFF,)) * 3


class Rover:
    """A rover with its stations."""

    def __init__(self, settings: RoverSettings, ports: Sequence[Port], now: float, protocol: Protocol) -> None:
        self.settings = settings
        self.protocol = protocol
        self.helm = Helm(now, request_timeout=settings.request_seconds, on_timeout=OnTimeout(settings.request_timeout))
        self.counters: Counter[str] = Counter()
        self._watch = Watch(self.helm.alerts, settings.stall_current, now)
        self._dialect = DIALECTS[settings.dialect]
        self._lengths = protocol.lengths(Party.ROVER)
        self._telemetry = protocol.lengths(Party.OPERATOR)
        self._stations = {port.name: port.station for port in ports}
        self._consoles = frozenset(port.name for port in ports if port.console)
        self._framers = {port.name: self._framer(port.name) for port in ports}
        self._crosses_whole = settings.role == "operator"  # on a UART a frame is as long as it likes
        self._segmented = {
            number: size for number, size in self._telemetry.items() if protocol.declarations[number].SEGMENTED
        }
        self._joiner = Joiner(self._segmented)
        self._paces: dict[int, Pace] = {}
        self._limits: dict[int, bytes] = {}
        self._limits_due = now + LIMITS_PERIOD
        self._enable_due = now
        self._grants_left = 0
        self._bus_heard = now
        self._last_words = now

    @property
    def drive(self) -> Drive:
        """The drives."""
        return self.helm.drive

    def limit(self, identifier: int) -> int | None:
        """A limit in its steps (frames 115, 119, 120), as the commander said it; None if nobody did."""
        data = self._limits.get(identifier)
        return None if data is None else data[0]

    def framing(self) -> dict[str, Framer]:
        """The framer of each port, with its counters: the quality of the link."""
        return self._framers

    def _framer(self, port: str) -> Framer:
        if port in self._consoles:
            return Console(self._lengths | CONSOLE)
        return self._dialect(self._lengths, self.settings.idle)

    # From the stations ----------------------------------------------------------------------------

    def receive_bytes(self, port: str, data: bytes, now: float) -> list[Effect]:
        """Bytes came in on a station's port, in any portions."""
        effects = self._overdue(now)
        framer = self._framers[port]
        came = framer.heard if framer.waiting else now  # what waits may be a whole frame that only now is proved
        return effects + self._receive(port, framer.receive(data, now), came, now)

    def _receive(self, port: str, frames: list[tuple[int, bytes]], came: float, now: float) -> list[Effect]:
        """Frames whose last byte came in at `came`: a set point is as old as that, not as its proof."""
        effects: list[Effect] = []
        for identifier, data in frames:
            effects += self._obey(self._stations[port], identifier, data, now - came, now)
        return effects

    def _obey(self, station: int, identifier: int, data: bytes, age: float, now: float) -> list[Effect]:
        """One frame of a station."""
        match identifier:
            case DriveCommand.FRAME:
                stick = Stick(signed(data[0]), signed(data[1]))
                return self._tell(self.helm.stick(stick, station, now, age), now)
            case DriveEnable.FRAME:
                return self._tell(self.helm.permission(data == PERMIT, station, now, age), now)
            case Word.COMMAND | Word.ACKNOWLEDGE | Word.SILENCE:
                return self._tell(self._hear_word(identifier, int.from_bytes(data, "big"), station, now), now)
        heard = self._tell(self.helm.heard(station, now, age), now)
        if station != self.helm.transfer.commander:
            return [*heard, *self._tell([Refused("not in command", station)], now)]
        if identifier in LIMITS:
            return heard + self._limit(identifier, data, station, now)
        return heard + self._pass_on(identifier, data, now)

    def _hear_word(self, word: int, what: int, station: int, now: float) -> list[Event]:
        """What only a console says."""
        match word:
            case Word.ACKNOWLEDGE:
                return self.helm.alerts.acknowledge(what)
            case Word.SILENCE:
                return self.helm.alerts.silence(what, now)
            case _:
                verb = VERBS.get(what)
                return [] if verb is None else self.helm.say(verb, station, now)

    def _limit(self, identifier: int, data: bytes, station: int, now: float) -> list[Effect]:
        if not 1 <= data[0] <= LIMITS[identifier]:
            return self._tell([Refused("limit out of range", station)], now)
        effects: list[Event] = []
        if identifier == SpeedLimit.FRAME:
            effects = self.helm.speed_limit(data[0], station, now)
        self._limits[identifier] = data
        return self._tell(effects, now) + self._pass_on(identifier, data, now)

    def _pass_on(self, identifier: int, data: bytes, now: float) -> list[Effect]:
        """A frame for a module, within the ceiling."""
        if not self._within_ceiling(identifier, now):
            self.counters["frames beyond 50 Hz"] += 1
            return []
        if self._crosses_whole or len(data) <= SINGLE:
            return [self._transmit(identifier, data)]
        return [self._transmit(identifier, half) for half in split(data)]

    def port_changed(self, port: str, connected: bool, now: float) -> list[Effect]:
        """A link came or went. Without its commander's link a rover does not wait for silence to stop."""
        if port not in self._stations:
            return []
        effects = self._overdue(now)
        counters = self._framers[port].counters
        self._framers[port] = self._framer(port)  # half a frame is not finished by who comes next
        self._framers[port].counters = counters
        if connected or self._stations[port] != self.helm.transfer.commander:
            return effects
        return effects + self._tell(self.drive.stop(Stop.UNPLUGGED, now), now)

    # From the modules -----------------------------------------------------------------------------

    def receive_frames(self, frames: Sequence[Frame], now: float) -> list[Effect]:
        """Frames came in from the bus. Runs once a wake-up and its loop once a frame: written for speed."""
        effects = self._overdue(now)
        self._bus_heard = now
        for frame in frames:
            length = self._telemetry.get(frame.identifier)
            if length is None or frame.extended:
                effects += self._stranger(frame)
            elif len(frame.data) == length:
                effects += self._report(frame.identifier, frame.data, now)
            elif frame.identifier in self._segmented:
                effects += self._join(frame, now)
            else:
                effects += self._reject("wrong length", frame)
        return effects

    def receive_message(self, identifier: int, payload: bytes, now: float) -> list[Effect]:
        """A whole message, longer than a CAN frame."""
        return self.receive_frames([Frame(identifier, payload, extended=False)], now)

    def _join(self, frame: Frame, now: float) -> list[Effect]:
        whole = self._joiner.receive(frame.identifier, frame.data, now)
        self.counters["halves without their partner"] = self._joiner.dropped
        return [] if whole is None else self._report(frame.identifier, whole, now)

    def _report(self, identifier: int, data: bytes, now: float) -> list[Effect]:
        """Telemetry: to every link, and to the watch."""
        effects: list[Effect] = []
        message = self.protocol.decode(identifier, data)
        if message is not None:
            effects += self._tell(self._watch.hear(message, now), now)
        if len(data) > self._dialect.LONGEST:
            self.counters["frames too long for the dialect"] += 1
        elif self._within_ceiling(identifier, now):
            effects.append(Say(self._dialect.write(identifier, data), str(identifier)))
        return effects

    def _stranger(self, frame: Frame) -> list[Effect]:
        """A frame that no module sends: two controllers on one bus would fight over the wheels."""
        declared = None if frame.extended else self.protocol.declaration(frame.identifier)
        if declared is None:
            return self._reject("undeclared frame", frame)
        self.counters["frames of another controller"] += 1
        if self.counters["frames of another controller"] > 1:
            return []
        return [SecurityEvent(f"somebody else sends {declared.__name__} on the bus", "bus")]

    def _reject(self, reason: str, frame: Frame) -> list[Effect]:
        self.counters[reason] += 1
        return [Rejected(reason, frame.data, f"frame {frame.identifier}")]

    # Time -----------------------------------------------------------------------------------------

    @property
    def deadline(self) -> float:
        """When `expire` is due."""
        waiting = min((framer.deadline for framer in self._framers.values()), default=self._enable_due)
        silent = self._bus_heard + SILENT if self._watches_bus else self._enable_due
        return min(self.helm.deadline, self._limits_due, self._enable_due, waiting, silent)

    @property
    def _watches_bus(self) -> bool:
        return self.settings.role == "operator" and self.drive.permitted

    def expire(self, now: float) -> list[Effect]:
        """What the passing of time brings about."""
        effects: list[Effect] = []
        for port, framer in self._framers.items():
            if now >= framer.deadline:
                effects += self._receive(port, framer.expire(now), framer.heard, now)
        effects += self._tell(self.helm.expire(now), now)
        if self._watches_bus and now >= self._bus_heard + SILENT:
            effects += self._tell(self.drive.stop(Stop.ROVER_SILENT, now), now)
        if now >= self._limits_due:
            self._limits_due = now + LIMITS_PERIOD
            effects += [self._transmit(identifier, data) for identifier, data in self._limits.items()]
        if now >= self._enable_due:
            effects += self._enable(now)
        return effects

    def _overdue(self, now: float) -> list[Effect]:
        return self.expire(now) if now >= self.deadline else []

    # To the outside -------------------------------------------------------------------------------

    def _tell(self, events: list[Event], now: float) -> list[Effect]:
        """Events, and the frames that carry them out."""
        effects: list[Effect] = []
        for event in events:
            match event:
                case Wheels():
                    self._watch.told(event, now)
                    effects += self._turn(event, now)
                    continue
                case Transferred(commander=commander) if commander == NOBODY:
                    self._last_words = now + STOP_BURST
                case Permission():
                    self._watch.permission(event, now)
                    self._grants_left = GRANTS
                    effects += self._enable(now)
                case Refused(reason):
                    self.counters[reason] += 1
            effects.append(event)
        return effects

    def _speaks(self, now: float) -> bool:
        """A controller always; an operator's end only for a station in command, and to say a last stop. Its 100
        would take command at the far end, and its 101 stop whoever drives there."""
        ours = self.helm.transfer.commander != NOBODY
        return ours or self.settings.role == "controller" or now < self._last_words

    def _turn(self, wheels: Wheels, now: float) -> list[Effect]:
        if not self._speaks(now):
            return []
        if self.settings.role == "operator":
            stick = self.drive.obeyed(now)
            return [self._transmit(DriveCommand.FRAME, bytes((stick.y & 0xFF, stick.x & 0xFF)))]
        return [
            self._transmit(WheelSpeedSetRight.FRAME, three(wheels.right)),
            self._transmit(WheelSpeedSetLeft.FRAME, three(wheels.left)),
        ]

    def _enable(self, now: float) -> list[Effect]:
        """Frame 101 as it stands; also repeated, since nobody acknowledges it."""
        self._enable_due = now + STOP_PERIOD
        if not self._speaks(now):
            return []
        if not self.drive.permitted:
            return [self._transmit(DriveEnable.FRAME, FORBID)]
        self._grants_left -= 1
        if self.settings.role == "operator" and self._grants_left < 0:
            return []
        return [self._transmit(DriveEnable.FRAME, PERMIT)]

    def _transmit(self, identifier: int, data: bytes) -> Transmit:
        return Transmit(Frame(identifier, data, extended=False))

    def _within_ceiling(self, identifier: int, now: float) -> bool:
        pace = self._paces.get(identifier)
        if pace is None:
            pace = self._paces[identifier] = Pace(CEILING)
        if not pace.open(now):
            return False
        pace.count(now)
        return True
