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
from timonel.core.effects import Effect, Event, Refused, Rejected, Say, SecurityEvent
from timonel.core.frame import Frame
from timonel.core.message import Message
from timonel.core.pace import Allowance
from timonel.errors import EncodeError
from timonel.nmea0183 import parp
from timonel.nmea0183.checksum import Fault
from timonel.nmea0183.framing import SentenceFramer
from timonel.nmea0183.registry import parse
from timonel.nmea0183.sentences import ACK, ACN, ALR, HTC, AlertCommand
from timonel.nmea2000 import registry
from timonel.nmea2000.claim import CLAIM, AddressClaimed, NoAddress
from timonel.nmea2000.devices import Devices
from timonel.nmea2000.fastpacket import FastPacketCounters, Reassembler
from timonel.nmea2000.identifier import NULL, split
from timonel.nmea2000.lookups import HeadingReference
from timonel.nmea2000.messages.garmin import (
    GarminAutopilotHeadingToSteer,
    GarminAutopilotModeState,
    GarminAutopilotRateOfTurn,
)
from timonel.nmea2000.messages.navico import SimnetAutopilotAngle, SimnetAutopilotModeState, SimnetPilotMode
from timonel.nmea2000.messages.network import IsoAddressClaim
from timonel.nmea2000.messages.raymarine import SeatalkPilotLockedHeading, SeatalkPilotMode
from timonel.nmea2000.messages.steering import HeadingTrackControl, VesselHeading
from timonel.nmea2000.node import MANAGED, Node
from timonel.nmea2000.sender import Outgoing, Sender, outgoing
from timonel.vehicles.boat.ais import Ais
from timonel.vehicles.boat.ais_layout import LAYOUTS as AIS
from timonel.vehicles.boat.alert_messages import NO_NAME
from timonel.vehicles.boat.alerting import HEARD as ALERT_MESSAGES
from timonel.vehicles.boat.alerting import Alerting, Done, patience
from timonel.vehicles.boat.alerts import COMMANDER_UNPLUGGED, NO_ADDRESS
from timonel.vehicles.boat.conversion import HEAR, RATES, Converter
from timonel.vehicles.boat.helm import Helm
from timonel.vehicles.boat.inputs import Inputs, sources
from timonel.vehicles.boat.pilot import Mode, PilotChanged, PilotReport, Steer, tenths
from timonel.vehicles.boat.pilots import choose, htc
from timonel.vehicles.boat.pilots.driver import Answer, Compass, GaveUp, Progressed
from timonel.vehicles.boat.reports import PilotMessage, PilotReports
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.sources import DERIVED
from timonel.vehicles.boat.truth import Truth, VariationModel

STATUS = "STATUS"
STATUS_INTERVAL = 0.5  # s
AIS_FORMATTERS = (b"VDM", b"VDO")
STEER_AGE = 1.5  # s that a set point may wait for our address; while it is wanted it comes once a second
MODES = {mode: None if mode is Mode.UNKNOWN else parp.PilotMode(mode.value) for mode in Mode}
REFERENCES = {"true": HeadingReference.TRUE, "magnetic": HeadingReference.MAGNETIC}
SHOWN = frozenset({Transferred, Requested, Denied, Overridden, PilotChanged, Refused})
PILOT_MESSAGES = (
    HeadingTrackControl,
    SeatalkPilotMode,
    SeatalkPilotLockedHeading,
    SimnetPilotMode,
    SimnetAutopilotModeState,
    SimnetAutopilotAngle,
    GarminAutopilotModeState,
    GarminAutopilotHeadingToSteer,
    GarminAutopilotRateOfTurn,
)


_HEARD: tuple[type[Message], ...] = (*HEAR, *AIS, *PILOT_MESSAGES, *ALERT_MESSAGES)
UNDERSTOOD = frozenset(message.PGN for message in _HEARD if message.PGN is not None)
"""The PGNs that the boat makes something of, beside the network management."""


class Route(msgspec.Struct, frozen=True, gc=False):
    """What becomes of the frames of one identifier. `decode` None: nobody here understands the PGN.

    What is `managed` is for our node, and who is meant counts.
    """

    source: int
    fast: bool
    decode: Callable[[bytes], Message | None] | None
    managed: bool = False


class Wire:
    """One port: what has come in so far, and how much of it."""

    def __init__(self, port: Port, settings: BoatSettings) -> None:
        self.port = port
        self.station = port.station
        self.commands = port.station is not None or not port.instrument
        self.framer = SentenceFramer()
        self.allowance = Allowance(settings.commands_per_second)
        self.flooded = False
        self.ordered: htc.Order | None = None  # what its heading controller last commanded, and was not refused


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
        self.helm = Helm(
            now,
            request_timeout=settings.request_seconds,
            on_timeout=OnTimeout(settings.request_timeout),
            patience=None if settings.alerts is None else patience(settings.alerts),
        )
        if settings.backbone == "optional":
            self.helm.pilot.expect_no_bus()
        model = variation_model if settings.variation_model else None
        self.sources = sources(settings, ports)
        if self.sources is None:
            self.truth, self._inputs = Truth(settings.max_age, model), None
        else:
            self.truth = Truth(settings.max_age, model, self.sources.datum, self.sources.hdop_limit)
            self._inputs = Inputs(settings, self.sources, self.truth, now)
        self._listen = self._hear if self._inputs is None else self._hear_in_order
        self.devices = Devices()
        self.counters: Counter[str] = Counter()
        self._converter = Converter(self.truth, settings.rates, settings.dialect)
        self._ais = Ais(settings.rates.get("VDM", RATES["VDM"]), self.counters)
        self._reference = REFERENCES[settings.heading_reference]
        self._compass = Compass(self._reference, self.truth.to_true, self.truth.to_magnetic)
        self.steering = choose(settings, self.devices, self._compass)
        self._driver = self.steering.driver
        finder = self.steering.finder
        self._reports = PilotReports(None if finder is None else lambda: finder.address)
        self.helm.pilot.adopts = self.steering.kind.adopts
        self.helm.pilot.objection = None if finder is None else self._driver.objection
        self._sender = Sender(settings.address)
        self.node = Node(settings.node, self._sender, self.devices, now, UNDERSTOOD)
        self._own_address = self._sender.address
        self._waiting: tuple[Steer, float] | None = None
        self._reassembler = Reassembler(settings.fast_packet_age)
        self._alerting: Alerting | None = None
        if settings.alerts is not None:
            table = self.helm.alerts
            self._alerting = Alerting(settings.alerts, table, self._own_name, self.devices, self.counters, now)
        self._wires = {port.name: Wire(port, settings) for port in ports}
        self._connected: dict[str, bool] = {}
        self._routes: dict[int, Route] = {}
        self._status_due = now
        self._due: float | None = None

    @property
    def address(self) -> int:
        """Our own address on the bus now."""
        return self._sender.address

    @property
    def fast_packets(self) -> FastPacketCounters:
        """What became of the frames of fast-packet messages."""
        return self._reassembler.counters

    # From the bus ---------------------------------------------------------------------------------

    def receive_frames(self, frames: Sequence[Frame], now: float) -> list[Effect]:
        """Frames came in from the bus. Runs once a wake-up and its loop once a frame: written for speed."""
        due = self._due
        effects: list[Effect] = [] if due is not None and now < due else self._overdue(now)
        heard = False
        routes = self._routes
        for frame in frames:
            identifier = frame.identifier
            route = routes.get(identifier) or self._route(frame)
            if route is None:
                continue
            heard = True
            if route.decode is None:
                if route.managed:
                    effects += self._manage(frame, route, now)
                continue
            data = self._reassembler.receive(identifier, frame.data, now) if route.fast else frame.data
            if data is None:
                continue
            message = route.decode(data)
            if message is not None:
                said = self._listen(message, route.source, now)
                effects = effects + said if effects else said
        if heard and (back := self.helm.pilot.bus_heard(now)):
            return self._tell(back, now) + self._network(self.node.bus_back(now), now) + effects
        return effects

    def receive_message(self, identifier: int, payload: bytes, now: float) -> list[Effect]:
        """A whole message came in."""
        if not registry.is_fast(split(identifier).pgn):
            return self.receive_frames([Frame(identifier, payload)], now)
        effects = self._overdue(now) + self._tell(self.helm.pilot.bus_heard(now), now)
        route = self._route(Frame(identifier, payload))
        if route is not None and route.managed:
            return effects + self._managed(identifier, payload, now)
        message = None if route is None or route.decode is None else route.decode(payload)
        return effects if message is None or route is None else effects + self._listen(message, route.source, now)

    def _route(self, frame: Frame) -> Route | None:
        """How to treat the frames of an identifier; None for those that are none of ours to hear."""
        if not frame.extended:
            self.counters["frames with 11-bit identifiers"] += 1
            return None
        target = split(frame.identifier)
        if target.source == self._sender.address and not (target.pgn == CLAIM or target.source == NULL):
            self.counters["frames from our own address"] += 1
            return None
        managed = target.pgn in MANAGED
        decode = None if managed else registry.decoder(target.pgn)
        route = Route(target.source, registry.is_fast(target.pgn), decode, managed)
        if len(self._routes) > 10_000:  # as many as a full bus of honest devices never has
            self._routes.clear()
        self._routes[frame.identifier] = route
        return route

    def _manage(self, frame: Frame, route: Route, now: float) -> list[Effect]:
        data = self._reassembler.receive(frame.identifier, frame.data, now) if route.fast else frame.data
        return [] if data is None else self._managed(frame.identifier, data, now)

    def _managed(self, identifier: int, payload: bytes, now: float) -> list[Effect]:
        """A message of the network management, for our node and for who wants to know the devices."""
        target = split(identifier)
        message = registry.decode(target.pgn, payload)
        answers = self.node.receive(target.pgn, message, payload, target.source, target.destination, now)
        effects = self._network(answers, now)
        return effects if message is None else effects + self._hear_device(message, target.source, now)

    def _network(self, answers: list[Effect], now: float) -> list[Effect]:
        """What our node wants done, and what follows from the address that it has or has not."""
        self._due = None
        if self._sender.address != self._own_address:
            self._own_address = self._sender.address
            self._routes.clear()
        return self._tell(answers, now)

    def _address_claimed(self, event: AddressClaimed, now: float) -> list[Effect]:
        self.helm.mute = False
        effects = self._tell(self.helm.alerts.rectify(NO_ADDRESS), now)
        if self._waiting is None:
            return effects
        (steer, since), self._waiting = self._waiting, None
        if steer.setpoint is not None and now > since + STEER_AGE:
            return effects
        return effects + self._steer(steer, now)

    def _no_address(self, event: NoAddress, now: float) -> list[Effect]:
        self.helm.mute = self._driver.on_bus
        text = "no address is free on the bus: nothing can be sent, the pilot least of all"
        return self._tell(self.helm.alerts.arise(NO_ADDRESS, text, now), now)

    def _hear(self, message: Message, source: int, now: float) -> list[Effect]:
        kind = type(message)
        if kind not in HEAR:
            return self._ais.say(message, now) if kind in AIS else self._hear_device(message, source, now)
        said, taken = self._converter.receive(message, source, now)
        if kind is VesselHeading:
            if taken and (events := self._heading_heard(message, now)):  # type: ignore[arg-type]
                return [*said, *self._tell(events, now)]
        elif kind is HeadingTrackControl:
            return [*said, *self._hear_device(message, source, now)]
        return said

    def _hear_in_order(self, message: Message, source: int, now: float) -> list[Effect]:
        """As `_hear`, of a boat whose sources have an order."""
        inputs = self._inputs
        assert inputs is not None
        message = inputs.sources.mended(message, source)
        said = self._hear(message, source, now)
        effects = inputs.heard(message, source, said, now) + said
        return effects + self._derive(inputs, message, now)

    def _derive(self, inputs: Inputs, message: Message, now: float) -> list[Effect]:
        """What is computed now that `message` was told."""
        return [effect for derived in inputs.derive(message, now) for effect in self._tell_bus(derived, DERIVED, now)]

    def _tell_bus(self, message: Message, source: int, now: float) -> list[Effect]:
        """What no device on the bus told: we hear it, and the bus gets it if it has it not."""
        inputs = self._inputs
        assert inputs is not None
        message = inputs.sources.mended(message, source)
        try:
            sent = outgoing(message)
        except EncodeError as error:
            return [Rejected(str(error), source=inputs.sources.label(source))]
        said = self._hear(message, source, now)
        effects = inputs.heard(message, source, said, now) + said
        if inputs.allow(message, source, now):
            effects += self._transmit([sent])
        return effects if source == DERIVED else effects + self._derive(inputs, message, now)

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
            if self.sources is not None and (device := self.devices.at(source)) is not None:
                self.sources.introduce(source, device.name)
        if self._alerting is not None and type(message) in ALERT_MESSAGES:
            return self._tell(self._alerting.hear(message, source, now), now)
        if not isinstance(message, PILOT_MESSAGES):
            return []
        return self._hear_pilot(message, source, now)

    def _hear_pilot(self, message: PilotMessage, source: int, now: float) -> list[Effect]:
        reading = self._reports.receive(message, source, now)
        if reading is None:
            return []
        pilot = self.helm.pilot
        course = self._driver.hear(reading, pilot.heading(now), now)
        report = PilotReport(reading.mode, None if course is None else tenths(degrees(course)))
        effects = self._tell(pilot.reported(report, now), now)
        answers = self._driver.reported(message, reading, report, pilot.pending, now)
        return effects + self._do(answers, now) if answers else effects

    # From the stations ----------------------------------------------------------------------------

    def receive_bytes(self, port: str, data: bytes, now: float) -> list[Effect]:
        """Bytes came in on a station's port, in any portions."""
        due = self._due
        effects: list[Effect] = [] if due is not None and now < due else self._overdue(now)
        wire = self._wires[port]
        for sentence in wire.framer.receive(data):
            if sentence.startswith(b"$PARP,"):
                said = self._receive_command(wire, sentence, now)
                effects = effects + said if effects else said
            elif wire.port.hears is not None and not wire.port.hears.accepts(sentence):
                self.counters["sentences that this port's owner does not want"] += 1
            elif wire.port.instrument and sentence[3:6] in AIS_FORMATTERS:
                effects += self._receive_ais(wire, sentence, now)
            elif wire.port.instrument and self._inputs is not None and self._inputs.wants(sentence):
                effects += self._receive_instrument(self._inputs, wire, sentence, now)
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
        restated = self._alerting.restate() if connected and self._alerting is not None else []
        return effects + self._tell(self._watch_commander(now), now) + restated

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
        """Runs between a station's key and the rudder."""
        if not wire.commands:
            self.counters["commands of instruments"] += 1
            return [SecurityEvent("an instrument commands", wire.port.name)]
        command = parp.read_command(sentence)
        if isinstance(command, Fault):
            return self._reject(command, sentence, wire)
        if not wire.allowance.take(now):
            return self._flood(wire, sentence)
        wire.flooded = False
        station = command.station if wire.station is None else wire.station
        if station is None:  # the short form does not say who speaks, so the wire must
            return self._reject(Fault.MALFORMED, sentence, wire)
        if command.station is not None and command.station != station:
            self.counters["commands of another station"] += 1
            return [SecurityEvent("another station's id", wire.port.name, command.station)]
        self.counters["commands"] += 1
        return self._tell(self.helm.obey(command, station, now), now, status=True)

    def _receive_instrument(self, inputs: Inputs, wire: Wire, sentence: bytes, now: float) -> list[Effect]:
        """A sentence of an instrument. What we said ourselves does not make a port the one that is listened to."""
        name = wire.port.name
        told = inputs.read(sentence, name, now)
        if isinstance(told, Fault):
            return self._reject(told, sentence, wire)
        source = inputs.sources.ports[name]
        echo = inputs.is_echo(sentence, now)
        effects: list[Effect] = []
        for message in told:
            if not inputs.admits(message, source, now):
                self.counters["values that another source tells"] += 1
            elif echo and not inputs.rules(message, source):
                self.counters["echoes of our own sentences"] += 1
            else:
                effects += self._tell_bus(message, source, now)
        return effects

    def _receive_ais(self, wire: Wire, sentence: bytes, now: float) -> list[Effect]:
        """A sentence of an AIS receiver: the bus and the stations get what it tells."""
        assert self.sources is not None
        clock = self.truth.clock_at(now)
        told = self._ais.hear(sentence, None if clock is None else clock.day, now)
        if isinstance(told, Fault):
            return self._reject(told, sentence, wire)
        source = self.sources.ports[wire.port.name]
        return [effect for message in told for effect in self._tell_bus(message, source, now)]

    def _receive_sentence(self, wire: Wire, sentence: bytes, now: float) -> list[Effect]:
        """Of the standard's sentences a station may acknowledge and silence alerts; the rest is not for us."""
        if self.settings.obey_htc and sentence[3:7] == b"HTC,":
            return self._receive_htc(wire, sentence, now)
        if self._alerting is not None:
            return self._receive_alert(self._alerting, wire, sentence, now)
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

    def _receive_htc(self, wire: Wire, sentence: bytes, now: float) -> list[Effect]:
        """What a heading controller commands, as the station whose wire it has. Said again it is not done again."""
        if wire.port.station is None:
            self.counters["sentences not for us"] += 1
            return []
        if not self._allowed(wire, now):
            return self._flood(wire, sentence)
        told = parse(sentence)
        if not isinstance(told, HTC):
            return self._reject(told if isinstance(told, Fault) else Fault.MALFORMED, sentence, wire)
        order = htc.order(told)
        if order == wire.ordered:
            return []
        self.counters["commands"] += 1
        effects = self._tell(self._obey_htc(order, wire.port.station, now), now, status=True)
        refused = any(type(effect) is Refused for effect in effects)
        wire.ordered = None if refused else order
        return effects

    def _obey_htc(self, order: htc.Order, station: int, now: float) -> list[Event]:
        match order:
            case htc.LetGo():
                return self.helm.obey(parp.Command(parp.Verb.DISENGAGE, station), station, now)
            case htc.Hold(course=course, reference=reference):
                return self._hold(course, reference, station, now)
        return [Refused(order, station)]

    def _hold(self, course: float | None, reference: HeadingReference | None, station: int, now: float) -> list[Event]:
        """Engage, if the pilot is not engaged already, and then hold `course`, if there is one."""
        told = self._compass.ours(course, reference, now)
        if course is not None and told is None:
            return [Refused("HTC: its reference, or the magnetic variation, is not known", station)]
        events: list[Event] = []
        if self.helm.pilot.mode is not Mode.HEADING_HOLD:
            events += self.helm.obey(parp.Command(parp.Verb.ENGAGE, station), station, now)
        if told is None or any(type(event) is Refused for event in events):
            return events
        heading = parp.Command(parp.Verb.SETHEADING, station, heading_tenths=tenths(degrees(told)))
        return events + self.helm.obey(heading, station, now)

    def _receive_alert(self, alerting: Alerting, wire: Wire, sentence: bytes, now: float) -> list[Effect]:
        """What a station commands about alerts, and what an instrument tells of its own."""
        if not alerting.wants(sentence, wire.port.instrument):
            self.counters["sentences not for us"] += 1
            return []
        match parse(sentence):
            case Fault() as fault:
                return self._reject(fault, sentence, wire)
            case ACK(alarm=None) | ACN(alarm=None) | ACN(command=None):
                return self._reject(Fault.MALFORMED, sentence, wire)
            case ACK() | ACN() as command:
                if not self._allowed(wire, now):
                    return self._flood(wire, sentence)
                return self._alerted(alerting.command(command, now, self._time_of_day(now)), now)
            case told:
                talker = sentence[1:3].decode("latin-1")
                return self._tell(alerting.instrument(told, wire.port.name, talker, now), now)

    def _alerted(self, done: Done, now: float) -> list[Effect]:
        """What the table of alerts makes the gateway do."""
        events = self._tell(done.events, now)
        return [*events, *done.lines, *self._transmit([outgoing(message) for message in done.messages])]

    def _own_name(self) -> int:
        return NO_NAME if self.settings.node is None else self.node.name

    def _time_of_day(self, now: float) -> float | None:
        clock = self.truth.clock_at(now)
        return None if clock is None else clock.second

    def _reject(self, reason: Fault, sentence: bytes, wire: Wire) -> list[Effect]:
        self.counters[str(reason)] += 1
        return [Rejected(str(reason), sentence, wire.port.name)]

    def _allowed(self, wire: Wire, now: float) -> bool:
        """Whether one more command is within what the port may give; a flood is over then."""
        allowed = wire.allowance.take(now)
        if allowed:
            wire.flooded = False
        return allowed

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
            self._due = min(self._status_due, self.helm.deadline, self.node.deadline, self._driver.deadline)
            if self._alerting is not None:
                self._due = min(self._due, self._alerting.deadline)
        return self._due

    def expire(self, now: float) -> list[Effect]:
        """What the passing of time brings about."""
        effects = self._tell(self.helm.expire(now), now)
        if now >= self.node.deadline:
            effects += self._network(self.node.expire(now), now)
        if self._alerting is not None and now >= self._alerting.deadline:
            effects += self._alerted(self._alerting.expire(now), now)
        if now >= self._driver.deadline:
            effects += self._do(self._driver.expire(now), now)
        if now >= self._status_due:
            self.node.now = now
            self._status_due += STATUS_INTERVAL
            if self._status_due <= now:  # nobody called for a while
                self._status_due = now + STATUS_INTERVAL
            effects.append(self._status(now))
        self._due = None
        return effects

    def _overdue(self, now: float) -> list[Effect]:
        return self.expire(now) if now >= self.deadline else []

    # To the outside -------------------------------------------------------------------------------

    def _tell(self, events: Sequence[Effect], now: float, status: bool = False) -> list[Effect]:
        """Events, what they make the gateway say and do, and one STATUS if they changed what it shows."""
        effects: list[Effect] = []
        for event in events:
            effects.append(event)
            kind = type(event)
            carry_out = CARRY_OUT.get(kind)
            if carry_out is not None:
                effects += carry_out(self, event, now)
            if not status and kind in SHOWN:
                status = True
        if status:
            effects.append(self._status(now))
        if effects:
            self._due = None
        return effects

    def _steer(self, steer: Steer, now: float) -> list[Effect]:
        driver = self._driver
        if not self.node.operating and driver.on_bus:
            self._waiting = (steer, now)
            return []
        pilot = self.helm.pilot
        answers = driver.steer(steer.setpoint, pilot.heading(now), now, pilot.manner)
        if driver.messages_only and driver.on_bus:
            return self._send(answers)  # type: ignore[arg-type]
        return self._do(answers, now)

    def _do(self, answers: Sequence[Answer], now: float) -> list[Effect]:
        """What the driver wants done."""
        self._due = None
        effects: list[Effect] = []
        for answer in answers:
            if type(answer) is Outgoing:
                effects += self._transmit((answer,))
            else:
                effects += self._tell((answer,), now)  # type: ignore[arg-type]
        return effects

    def _progressed(self, event: Progressed, now: float) -> list[Effect]:
        self.helm.pilot.progressed(now)
        return []

    def _gave_up(self, event: GaveUp, now: float) -> list[Effect]:
        return self._tell(self.helm.pilot.gave_up(event.reason, now), now)

    def _transmit(self, messages: Sequence[Outgoing]) -> list[Effect]:
        """Messages of ours, as frames from the address that we have; nothing leaves while we have none."""
        if not self.node.operating:
            self.counters["messages without an address"] += len(messages)
            return []
        return self._send(messages)

    def _send(self, messages: Sequence[Outgoing]) -> list[Effect]:
        """`_transmit` where we have an address."""
        effects: list[Effect] = []
        for message in messages:
            self.node.sent(message)
            effects += self._sender.transmit(message)
        return effects

    def _transferred(self, event: Transferred, now: float) -> list[Effect]:
        transfer = Say(parp.cmdtransfer(event.previous, event.commander), "CMDTRANSFER", urgent=True)
        return [transfer, *self._do(self._driver.passed(), now), *self._tell(self._watch_commander(now), now)]

    def _requested(self, event: Requested, now: float) -> list[Effect]:
        return [Say(parp.cmdrequest(event.station), "CMDREQUEST", urgent=True)]

    def _alert_changed(self, event: AlertChanged, now: float) -> list[Effect]:
        if self._alerting is not None:
            return self._alerted(self._alerting.changed(event.alert, now, self._time_of_day(now)), now)
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
        return ALR(self._time_of_day(now), alert.kind.id, alert.active, alert.acknowledged, alert.kind.name).encode()


CARRY_OUT: dict[type[Effect], Callable[..., list[Effect]]] = {
    Steer: Boat._steer,
    AddressClaimed: Boat._address_claimed,
    NoAddress: Boat._no_address,
    Progressed: Boat._progressed,
    GaveUp: Boat._gave_up,
    Transferred: Boat._transferred,
    Requested: Boat._requested,
    AlertChanged: Boat._alert_changed,
}
"""What an event makes the gateway say and do, beyond telling of it."""
