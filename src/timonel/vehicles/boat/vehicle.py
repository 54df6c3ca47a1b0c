"""The whole gateway of a boat as one machine: frames and port bytes in, frames, port bytes and events out.

It reads no clock and opens nothing: the same inputs at the same times give the same effects, byte for byte.

in                     what happens                                                       out
frames of the bus      put together, decoded, heard (`truth`), converted (`conversion`)   sentences
  of the pilot         read as its maker means it (`reports`)                             STATUS
bytes of a port        framed, checked, bound to the port's station, obeyed (`helm`)      CMDTRANSFER, CMDREQUEST,
                                                                                          STATUS, PGN 127237
time                   requests, silences, repetition, STATUS twice a second              all of these
"""

from collections import Counter
from collections.abc import Callable, Sequence
from math import degrees

import msgspec

from timonel.core.alerts import Alert, AlertChanged
from timonel.core.command import Denied, OnTimeout, Overridden, Requested, Transferred
from timonel.core.effects import Effect, Event, Refused, Rejected, Say, SecurityEvent, Transmit
from timonel.core.frame import Frame
from timonel.core.message import Message
from timonel.core.pace import Allowance
from timonel.nmea0183 import parp
from timonel.nmea0183.checksum import Fault
from timonel.nmea0183.framing import SentenceFramer
from timonel.nmea0183.registry import parse
from timonel.nmea0183.sentences import ACK, ACN, ALR, AlertCommand
from timonel.nmea2000 import registry
from timonel.nmea2000.fastpacket import FastPacketCounters, Reassembler
from timonel.nmea2000.identifier import split
from timonel.nmea2000.lookups import HeadingReference
from timonel.nmea2000.messages.navico import SimnetAutopilotModeState, SimnetPilotMode
from timonel.nmea2000.messages.network import IsoAddressClaim
from timonel.nmea2000.messages.raymarine import SeatalkPilotLockedHeading, SeatalkPilotMode
from timonel.nmea2000.messages.steering import HeadingTrackControl, VesselHeading
from timonel.nmea2000.sender import Outgoing, Sender
from timonel.vehicles.boat.alerts import COMMANDER_UNPLUGGED
from timonel.vehicles.boat.conversion import HEAR, Converter
from timonel.vehicles.boat.drivers import StandardPilot
from timonel.vehicles.boat.helm import Helm
from timonel.vehicles.boat.pilot import Mode, PilotChanged, PilotReport, Steer, tenths
from timonel.vehicles.boat.reports import PilotMessage, PilotReports
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.truth import Truth, VariationModel

STATUS = "STATUS"
STATUS_INTERVAL = 0.5  # s
MODES = {mode: None if mode is Mode.UNKNOWN else parp.PilotMode(mode.value) for mode in Mode}
REFERENCES = {"true": HeadingReference.TRUE, "magnetic": HeadingReference.MAGNETIC}
SHOWN = frozenset({Transferred, Requested, Denied, Overridden, PilotChanged, Refused})
PILOT_MESSAGES = (
    HeadingTrackControl,
    SeatalkPilotMode,
    SeatalkPilotLockedHeading,
    SimnetPilotMode,
    SimnetAutopilotModeState,
)


class Route(msgspec.Struct, frozen=True, gc=False):
    """What becomes of the frames of one identifier. `decode` None: nobody here understands the PGN."""

    source: int
    fast: bool
    decode: Callable[[bytes], Message | None] | None


class Wire:
    """One port: what has come in so far, and how much of it."""

    def __init__(self, port: Port, settings: BoatSettings) -> None:
        self.port = port
        self.framer = SentenceFramer()
        self.allowance = Allowance(settings.commands_per_second)
        self.flooded = False


class Boat:
    """A boat with its stations. `ports` are the ways in; what is said goes to every OUT port."""

    def __init__(
        self,
        settings: BoatSettings,
        ports: Sequence[Port],
        now: float,
        variation_model: VariationModel | None = None,
    ) -> None:
        self.settings = settings
        self.helm = Helm(now, request_timeout=settings.request_seconds, on_timeout=OnTimeout(settings.request_timeout))
        self.truth = Truth(settings.max_age, variation_model if settings.variation_model else None)
        self.counters: Counter[str] = Counter()
        self._converter = Converter(self.truth, settings.rates, settings.dialect)
        self._reports = PilotReports()
        self._reference = REFERENCES[settings.heading_reference]
        self._driver = StandardPilot(self._reference)
        self._sender = Sender(settings.address)
        self._reassembler = Reassembler(settings.fast_packet_age)
        self._wires = {port.name: Wire(port, settings) for port in ports}
        self._connected: dict[str, bool] = {}
        self._routes: dict[int, Route] = {}
        self._status_due = now
        self._due: float | None = None

    @property
    def fast_packets(self) -> FastPacketCounters:
        """What became of the frames of fast-packet messages."""
        return self._reassembler.counters

    # From the bus ---------------------------------------------------------------------------------

    def receive_frames(self, frames: Sequence[Frame], now: float) -> list[Effect]:
        """Frames came in from the bus. Runs once a wake-up and its loop once a frame: written for speed."""
        effects = self._overdue(now)
        heard = False
        routes = self._routes
        for frame in frames:
            identifier = frame.identifier
            route = routes.get(identifier) or self._route(frame)
            if route is None:
                continue
            heard = True
            if route.decode is None:
                continue
            data = self._reassembler.receive(identifier, frame.data, now) if route.fast else frame.data
            if data is None:
                continue
            message = route.decode(data)
            if message is not None:
                effects += self._hear(message, route.source, now)
        if heard and (back := self.helm.pilot.bus_heard(now)):
            return self._tell(back, now) + effects
        return effects

    def receive_message(self, identifier: int, payload: bytes, now: float) -> list[Effect]:
        """A whole message came in."""
        if not registry.is_fast(split(identifier).pgn):
            return self.receive_frames([Frame(identifier, payload)], now)
        effects = self._overdue(now) + self._tell(self.helm.pilot.bus_heard(now), now)
        route = self._route(Frame(identifier, payload))
        message = None if route is None or route.decode is None else route.decode(payload)
        return effects if message is None or route is None else effects + self._hear(message, route.source, now)

    def _route(self, frame: Frame) -> Route | None:
        """How to treat the frames of an identifier; None for those that are none of ours to hear."""
        if not frame.extended:
            self.counters["frames with 11-bit identifiers"] += 1
            return None
        target = split(frame.identifier)
        if target.source == self._sender.address:
            self.counters["frames from our own address"] += 1
            return None
        route = Route(target.source, registry.is_fast(target.pgn), registry.decoder(target.pgn))
        if len(self._routes) > 10_000:  # as many as a full bus of honest devices never has
            self._routes.clear()
        self._routes[frame.identifier] = route
        return route

    def _hear(self, message: Message, source: int, now: float) -> list[Effect]:
        kind = type(message)
        if kind not in HEAR:
            return self._hear_device(message, source, now)
        said, taken = self._converter.receive(message, source, now)
        if isinstance(message, VesselHeading) and taken and (events := self._heading_heard(message, now)):
            return [*said, *self._tell(events, now)]
        if kind is HeadingTrackControl:
            return [*said, *self._hear_device(message, source, now)]
        return said

    def _heading_heard(self, message: VesselHeading, now: float) -> list[Event]:
        """A heading is new only if it comes from the compass that was just heard."""
        datum = self.truth.true if self._reference is HeadingReference.TRUE else self.truth.magnetic
        heading = datum.value
        if heading is None or heading.message is not message:
            return []
        return self.helm.pilot.heading_heard(degrees(heading.angle), now)

    def _hear_device(self, message: Message, source: int, now: float) -> list[Effect]:
        if isinstance(message, IsoAddressClaim):
            self._reports.introduce(message, source)
        if not isinstance(message, PILOT_MESSAGES):
            return []
        return self._tell(self._hear_pilot(message, source, now), now)

    def _hear_pilot(self, message: PilotMessage, source: int, now: float) -> list[Event]:
        reading = self._reports.receive(message, source, now)
        if reading is None:
            return []
        convert = self.truth.to_true if self._reference is HeadingReference.TRUE else self.truth.to_magnetic
        course = convert(reading.course, reading.reference, now)
        setpoint = None if course is None else tenths(degrees(course))
        return self.helm.pilot.reported(PilotReport(reading.mode, setpoint), now)

    # From the stations ----------------------------------------------------------------------------

    def receive_bytes(self, port: str, data: bytes, now: float) -> list[Effect]:
        """Bytes came in on a station's port, in any portions."""
        effects = self._overdue(now)
        wire = self._wires[port]
        for sentence in wire.framer.receive(data):
            if sentence.startswith(b"$PARP,"):
                effects += self._receive_command(wire, sentence, now)
            else:
                effects += self._receive_sentence(wire, sentence, now)
        return effects

    def port_changed(self, port: str, connected: bool, now: float) -> list[Effect]:
        """A port was plugged in or unplugged: command stays where it is, but people are told."""
        wire = self._wires.get(port)
        if wire is None:
            return []
        effects = self._overdue(now)
        wire.framer = SentenceFramer()
        self._connected[port] = connected
        return effects + self._tell(self._watch_commander(now), now)

    def _watch_commander(self, now: float) -> list[Event]:
        commander = self.helm.transfer.commander
        if not self._unplugged(commander):
            return self.helm.alerts.rectify(COMMANDER_UNPLUGGED)
        text = f"the port of station {commander}, which is in command, is unplugged"
        return self.helm.alerts.arise(COMMANDER_UNPLUGGED, text, now)

    def _unplugged(self, station: int) -> bool:
        """Whether none of its own ports is connected, of those that ever were or were missed."""
        known = [on for port, on in self._connected.items() if self._wires[port].port.station == station]
        return bool(known) and not any(known)

    def _receive_command(self, wire: Wire, sentence: bytes, now: float) -> list[Effect]:
        command = parp.read_command(sentence)
        if not isinstance(command, parp.Command):
            return self._reject(command, sentence, wire)
        if not wire.allowance.take(now):
            return self._flood(wire, sentence)
        wire.flooded = False
        station = command.station if wire.port.station is None else wire.port.station
        if station is None:  # the short form does not say who speaks, so the wire must
            return self._reject(Fault.MALFORMED, sentence, wire)
        if command.station is not None and command.station != station:
            self.counters["commands of another station"] += 1
            return [SecurityEvent("another station's id", wire.port.name, command.station)]
        self.counters["commands"] += 1
        return self._tell(self.helm.obey(command, station, now), now, status=True)

    def _receive_sentence(self, wire: Wire, sentence: bytes, now: float) -> list[Effect]:
        """Of the standard's sentences a station may acknowledge and silence alerts; the rest is not for us."""
        if sentence[3:7] not in (b"ACK,", b"ACN,"):
            self.counters["sentences not for us"] += 1
            return []
        match parse(sentence):
            case ACK(alarm=int() as alarm) | ACN(alarm=int() as alarm, command=AlertCommand.ACKNOWLEDGE):
                return self._tell(self.helm.alerts.acknowledge(alarm), now)
            case ACN(alarm=int() as alarm, command=AlertCommand.SILENCE):
                return self._tell(self.helm.alerts.silence(alarm, now), now)
            case Fault() as fault:
                return self._reject(fault, sentence, wire)
        return self._reject(Fault.MALFORMED, sentence, wire)

    def _reject(self, reason: Fault, sentence: bytes, wire: Wire) -> list[Effect]:
        self.counters[str(reason)] += 1
        return [Rejected(str(reason), sentence, wire.port.name)]

    def _flood(self, wire: Wire, sentence: bytes) -> list[Effect]:
        """Counted one by one, told once."""
        self.counters["commands beyond the allowance"] += 1
        told, wire.flooded = wire.flooded, True
        return [] if told else [Rejected("too many commands", sentence, wire.port.name)]

    # Time -----------------------------------------------------------------------------------------

    @property
    def deadline(self) -> float:
        """When `expire` is due: perhaps before there is anything to do, never after.

        It is asked for once a wake-up, so it is worked out anew only when something happened. What is merely heard
        puts deadlines off, or sets one of a second and more, and it is worked out at every STATUS too.
        """
        if self._due is None:
            self._due = min(self._status_due, self.helm.deadline)
        return self._due

    def expire(self, now: float) -> list[Effect]:
        """What the passing of time brings about."""
        effects = self._tell(self.helm.expire(now), now)
        if now >= self._status_due:
            self._status_due += STATUS_INTERVAL
            if self._status_due <= now:  # nobody called for a while
                self._status_due = now + STATUS_INTERVAL
            effects.append(self._status(now))
        self._due = None
        return effects

    def _overdue(self, now: float) -> list[Effect]:
        return self.expire(now) if now >= self.deadline else []

    # To the outside -------------------------------------------------------------------------------

    def _tell(self, events: list[Event], now: float, status: bool = False) -> list[Effect]:
        """Events, what they make the gateway say and do, and one STATUS if they changed what it shows."""
        effects: list[Effect] = []
        for event in events:
            effects.append(event)
            kind = type(event)
            if (carry_out := CARRY_OUT.get(kind)) is not None:
                effects += carry_out(self, event, now)
            status = status or kind in SHOWN
        if status:
            effects.append(self._status(now))
        if effects:
            self._due = None
        return effects

    def _steer(self, steer: Steer, now: float) -> list[Effect]:
        heading = self.helm.pilot.heading(now)
        return self._transmit(self._driver.steer(steer.setpoint, heading))

    def _transmit(self, messages: Sequence[Outgoing]) -> list[Effect]:
        """Messages of ours, as frames from the address that we have."""
        return [Transmit(frame) for message in messages for frame in self._sender.frames(message)]

    def _transferred(self, event: Transferred, now: float) -> list[Effect]:
        transfer = Say(parp.cmdtransfer(event.previous, event.commander), "CMDTRANSFER", urgent=True)
        return [transfer, *self._tell(self._watch_commander(now), now)]

    def _requested(self, event: Requested, now: float) -> list[Effect]:
        return [Say(parp.cmdrequest(event.station), "CMDREQUEST", urgent=True)]

    def _alert_changed(self, event: AlertChanged, now: float) -> list[Effect]:
        return [Say(self._alr(event.alert, now), "ALR", urgent=True)]

    def _status(self, now: float) -> Say:
        pilot = self.helm.pilot
        rudder = self.truth.rudder_angle(now)
        line = parp.status(
            MODES[pilot.mode],
            pilot.setpoint,
            pilot.heading(now),
            None if rudder is None else degrees(rudder),
            self.helm.transfer.commander,
        )
        return Say(line, STATUS, urgent=True, state=True)

    def _alr(self, alert: Alert, now: float) -> bytes:
        clock = self.truth.clock_at(now)
        time = None if clock is None else clock.second
        return ALR(time, alert.kind.id, alert.active, alert.acknowledged, alert.kind.name).encode()


CARRY_OUT: dict[type[Event], Callable[..., list[Effect]]] = {
    Steer: Boat._steer,
    Transferred: Boat._transferred,
    Requested: Boat._requested,
    AlertChanged: Boat._alert_changed,
}
"""What an event makes the gateway say and do, beyond telling of it."""
