"""What makes us a device of the bus: an address, and answers to whoever asks who we are. A pure machine, told the time.

heard, by us or by everybody             what the node does
60928, 59904 of it, 65240                see `claim`
59904 of what it has or sends            says it
59904 of anything else                   59392, no, to the one who asked; nothing if everybody was asked
126208                                   see `group_answers`
126996, 126998 of others                 `devices` has them

time                                     what the node does
once it has an address, every 60 s       heartbeat
a device whose product nobody knows      is asked for it and for what its installer wrote, three times at most

Answers leave at most `ANSWERS` times a second, whoever asks and however often. Without settings the node has a fixed
address, claims nothing and says nothing: what others say of themselves is all that it knows.

What a node may be commanded to: its instances (60928 fields 3, 4 and 8), its installation descriptions (126998 fields
1 and 2), the interval of its heartbeat. Nobody may command the steering: 127237 by 126208 is denied.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import Annotated

import msgspec

from timonel.core.effects import Effect, Event, Transmit
from timonel.core.message import Message
from timonel.core.pace import Allowance
from timonel.nmea2000.claim import NEVER, AddressClaimed, Claimer, State
from timonel.nmea2000.devices import Device, Devices
from timonel.nmea2000.group_answers import Answers, GroupFunctionMessage, Target, answer
from timonel.nmea2000.identifier import GLOBAL, NULL
from timonel.nmea2000.lookups import (
    CertificationLevel,
    ControllerState,
    EquipmentStatus,
    IsoControl,
    PgnListFunction,
)
from timonel.nmea2000.messages.group_function import NmeaRequestGroupFunction, Parameter
from timonel.nmea2000.messages.network import (
    ConfigurationInformation,
    Heartbeat,
    IsoAcknowledgement,
    IsoAddressClaim,
    IsoCommandedAddress,
    IsoRequest,
    PgnListTransmitAndReceive,
    ProductInformation,
)
from timonel.nmea2000.registry import interval
from timonel.nmea2000.sender import Outgoing, Sender, outgoing
from timonel.nmea2000.transport import CONTROL, DATA, Transport

ACKNOWLEDGEMENT, REQUEST, CLAIM, COMMANDED, GROUP = 59392, 59904, 60928, 65240, 126208
LISTS, HEARTBEAT, PRODUCT, CONFIGURATION = 126464, 126993, 126996, 126998
STEERING = 127237
MANAGED = frozenset(
    {ACKNOWLEDGEMENT, REQUEST, CONTROL, DATA, CLAIM, COMMANDED, GROUP, LISTS, HEARTBEAT, PRODUCT, CONFIGURATION}
)
"""The PGNs that a node is to be told, with their destination."""

SENDS = (ACKNOWLEDGEMENT, REQUEST, CLAIM, GROUP, LISTS, HEARTBEAT, PRODUCT, CONFIGURATION)
OBEYS = (ACKNOWLEDGEMENT, REQUEST, CLAIM, COMMANDED, GROUP, LISTS, HEARTBEAT, PRODUCT, CONFIGURATION)
LISTED = 74  # PGNs that one list holds
ANSWERS = 25  # a second
HEARTBEAT_INTERVAL = 60.0  # s
HEARTBEATS = (1.0, 60.0)  # s between them that may be asked for
COUNTED = 253  # the heartbeat's counter begins anew here
ASK_AFTER = 0.5  # s from a claim to the question what it is
ASK_INTERVAL = 0.25  # s between questions
TRIES = 3
FRESH = 3.0  # s that a message of ours is worth repeating when it is asked for

Word = Annotated[str, msgspec.Meta(max_length=32, pattern="^[ -~]*$")]
Text = Annotated[str, msgspec.Meta(max_length=48)]  # two of them and more fit one message, in UTF-16 too


class NodeSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a node tells of itself. All numbers but the unique one have defaults that suit a gateway.

    Manufacturer codes are given out by the NMEA; 2046 is what builders without one use.
    """

    unique_number: Annotated[int, msgspec.Meta(ge=0, le=0x1FFFFF)] = 0
    manufacturer: Annotated[int, msgspec.Meta(ge=0, le=2046)] = 2046
    device_class: Annotated[int, msgspec.Meta(ge=0, le=0x7F)] = 25
    device_function: Annotated[int, msgspec.Meta(ge=0, le=0xFF)] = 130
    device_instance: Annotated[int, msgspec.Meta(ge=0, le=253)] = 0
    system_instance: Annotated[int, msgspec.Meta(ge=0, le=15)] = 0
    product_code: Annotated[int, msgspec.Meta(ge=0, le=65532)] = 0
    model: Word = "timonel"
    software: Word = ""
    serial: Word = ""
    installation1: Text = ""
    installation2: Text = ""

    @property
    def name(self) -> int:
        """The 64-bit NAME: marine industry, and able to take any address."""
        return (
            self.unique_number
            | self.manufacturer << 21
            | self.device_instance << 32
            | self.device_function << 40
            | self.device_class << 49
            | self.system_instance << 56
            | 4 << 60
            | 1 << 63
        )


class Described(Event, frozen=True, gc=False):
    """Somebody at a chart plotter wrote these installation descriptions into us."""

    installation1: str
    installation2: str


class Node:
    """Our side of the network management. `receives` are the PGNs that are understood beside its own.

    `sender` is moved to the address that the node has; it may be used while `operating`.
    """

    def __init__(
        self,
        settings: NodeSettings | None,
        sender: Sender,
        devices: Devices,
        now: float,
        receives: Collection[int] = (),
    ) -> None:
        self.settings = settings or NodeSettings()
        self._sender = sender
        self._devices = devices
        self._receives = sorted({*receives, *OBEYS})
        self._claimer = None if settings is None else Claimer(settings.name, sender.address, sender, devices, now)
        self._transport = Transport(frozenset({COMMANDED}))
        self._answers = Allowance(ANSWERS)
        self._installation = (self.settings.installation1, self.settings.installation2)
        self._sent: dict[int, Outgoing] = {}
        self._fresh: dict[int, float] = {}
        self._heartbeat_interval = HEARTBEAT_INTERVAL
        self._heartbeat_due = NEVER
        self._heartbeats = 0
        self._asked: dict[tuple[int, int], int] = {}
        self._ask_due = NEVER
        self._events: list[Effect] = []
        self._targets = {
            CLAIM: Target(self._claim, frozenset({3, 4, 8}), self._rename),
            HEARTBEAT: Target(self._heartbeat, intervals=HEARTBEATS, repeat=self._beat_every),
            LISTS: Target(lambda: self._list(PgnListFunction.TRANSMIT)),
            PRODUCT: Target(self._product),
            CONFIGURATION: Target(self._configuration, frozenset({1, 2}), self._describe),
        }
        self._began = self.now = now
        """When the node was last told the time: what it sent is dated by it, to half a second."""

    # What we are ----------------------------------------------------------------------------------

    @property
    def address(self) -> int:
        """The address that we have or are about to have; 254 while there is none."""
        return self._sender.address

    @property
    def name(self) -> int:
        """Our NAME; its instance moves when a twin is met."""
        return self.settings.name if self._claimer is None else self._claimer.name

    @property
    def operating(self) -> bool:
        """Whether we may send."""
        return self._claimer is None or self._claimer.state is State.CLAIMED

    @property
    def counters(self) -> Mapping[str, int]:
        """What became of long messages that were not whole."""
        return self._transport.counters

    def ourselves(self) -> Device | None:
        """We, as others see us; None without a node of our own. The time since is from the beginning."""
        if self._claimer is None:
            return None
        product, configuration = self._product(), self._configuration()
        return Device(self.name, self.address, self._claim(), self._began, self.now, product, configuration)

    def ask(self, pgn: int, destination: int = GLOBAL) -> list[Effect]:
        """The request for a PGN, to everybody or to one; nothing while we must not speak."""
        return self._send(outgoing(IsoRequest(pgn=pgn), destination)) if self.operating and self._claimer else []

    # What is heard --------------------------------------------------------------------------------

    def receive(
        self, pgn: int, message: Message | None, payload: bytes, source: int, destination: int, now: float
    ) -> list[Effect]:
        """One message of the PGNs in `MANAGED`, whoever it is for; `message` is what it says, `payload` as it came."""
        self.now = now
        if pgn in (CONTROL, DATA):
            return self._receive_part(pgn, payload, source, destination, now)
        if message is None:
            return []
        if isinstance(message, IsoAddressClaim):
            return self._receive_claim(message, payload, source, now)
        self._devices.receive(message, source, now)
        if self._claimer is None or destination not in (self.address, GLOBAL):
            return []
        match message:
            case IsoRequest():
                return self._requested(message.pgn, source, destination, now)
            case IsoCommandedAddress():
                return self._commanded(payload, now)
        return self._receive_group(message, payload, source, destination, now)

    def _receive_claim(self, claim: IsoAddressClaim, payload: bytes, source: int, now: float) -> list[Effect]:
        name = int.from_bytes(payload[:8], "little")
        if self._claimer is None or name != self._claimer.name:
            device = self._devices.receive(claim, source, now, name)
            self._meet(device, now)
        return [] if self._claimer is None else self._claimer.claimed_by(name, source, now)

    def _receive_part(self, pgn: int, payload: bytes, source: int, destination: int, now: float) -> list[Effect]:
        if destination != GLOBAL:
            return []
        whole = self._transport.receive(pgn, payload, source, now)
        return [] if whole is None else self._commanded(whole[1], now)

    def _commanded(self, payload: bytes, now: float) -> list[Effect]:
        """65240: the NAME that is meant, and its new address."""
        if self._claimer is None or len(payload) < 9 or int.from_bytes(payload[:8], "little") != self._claimer.name:
            return []
        return self._claimer.move(payload[8], now)

    def _requested(self, pgn: int, source: int, destination: int, now: float) -> list[Effect]:
        assert self._claimer is not None
        if pgn == CLAIM:
            return self._claimer.asked(now)
        if not self.operating or not self._answers.take(now):
            return []
        if said := self._say(pgn, source, now):
            return said
        if destination == GLOBAL or source >= NULL:
            return []
        no = IsoAcknowledgement(control=IsoControl.NAK, group_function=None, pgn=pgn)
        return self._send(outgoing(no, source))

    def _receive_group(
        self, message: Message, payload: bytes, source: int, destination: int, now: float
    ) -> list[Effect]:
        if not isinstance(message, GroupFunctionMessage) or not self.operating or source >= NULL:
            return []
        if not self._answers.take(now):
            return []
        denied = frozenset({STEERING, *self._sent})
        told = Answers(send=message.pgn) if self._repeats(message, now) else None
        told = told or answer(message, payload, self._targets, denied)
        effects: list[Effect] = []
        if destination != GLOBAL:
            effects += [frame for reply in told.replies for frame in self._send(outgoing(reply, source))]
        if told.send is not None:
            effects += self._say(told.send, source, now)
        events, self._events = self._events, []
        return effects + events

    def _repeats(self, message: Message, now: float) -> bool:
        """Whether it is a plain request of something that we send."""
        return (
            isinstance(message, NmeaRequestGroupFunction)
            and not message.parameters
            and message.transmission_interval is None
            and self._again(message.pgn, now) is not None
        )

    # Time -----------------------------------------------------------------------------------------

    @property
    def deadline(self) -> float:
        """When `expire` should be called, s."""
        if self._claimer is None:
            return NEVER
        return min(self._claimer.deadline, self._heartbeat_due, self._ask_due)

    def expire(self, now: float) -> list[Effect]:
        """What the passing of time brings about."""
        if self._claimer is None or now < self.deadline:
            return []
        self.now = now
        effects = self._claimer.expire(now)
        if any(type(effect) is AddressClaimed for effect in effects):
            self._heartbeat_due, self._ask_due = now, now + ASK_AFTER
        if now >= self._heartbeat_due and self.operating:
            effects += self._beat(now)
        if now >= self._ask_due:
            effects += self._ask(now)
        return effects

    def bus_back(self, now: float) -> list[Effect]:
        """The bus was silent and is heard again: others may have come, and not know of us."""
        return [] if self._claimer is None else self._claimer.announce(now)

    def sent(self, message: Outgoing) -> None:
        """A message of ours leaves: it can be asked for, and its PGN is in our list. Runs before every command."""
        self._sent[message.pgn] = message
        self._fresh[message.pgn] = self.now

    def _beat(self, now: float) -> list[Effect]:
        effects = self._send(outgoing(self._heartbeat()))
        self._heartbeats = (self._heartbeats + 1) % COUNTED
        self._heartbeat_due = now + self._heartbeat_interval
        return effects

    def _meet(self, device: Device | None, now: float) -> None:
        if self._claimer is not None and device is not None and device.address < NULL and self._wanted(device):
            self._ask_due = min(self._ask_due, now + ASK_AFTER)

    def _wanted(self, device: Device) -> list[int]:
        """What this device has yet to tell, and may be asked for once more."""
        missing = [
            pgn for pgn, told in ((PRODUCT, device.product), (CONFIGURATION, device.configuration)) if told is None
        ]
        return [pgn for pgn in missing if self._asked.get((device.name, pgn), 0) < TRIES]

    def _ask(self, now: float) -> list[Effect]:
        """Ask one device for one thing: who was asked least comes first."""
        questions = [
            (self._asked.get((device.name, pgn), 0), device.address, pgn, device.name)
            for device in self._devices
            if device.address < NULL
            for pgn in self._wanted(device)
        ]
        if not questions or not self.operating:
            self._ask_due = NEVER if self.operating else now + ASK_AFTER
            return []
        times, address, pgn, name = min(questions)
        known = {key: count for key, count in self._asked.items() if self._devices.by_name(key[0]) is not None}
        self._asked = known | {(name, pgn): times + 1}
        self._ask_due = now + ASK_INTERVAL
        return self.ask(pgn, address)

    # What we say ----------------------------------------------------------------------------------

    def _send(self, message: Outgoing) -> list[Effect]:
        return [Transmit(frame) for frame in self._sender.frames(message)]

    def _say(self, pgn: int, to: int, now: float) -> list[Effect]:
        """A PGN that we have or send; nothing for one that we have not."""
        if pgn == CLAIM and self._claimer is not None:
            return self._claimer.asked(now)
        if pgn == HEARTBEAT:
            return self._beat(now)
        if pgn == LISTS:
            lists = (self._list(PgnListFunction.TRANSMIT), self._list(PgnListFunction.RECEIVE))
            return [frame for words in lists for frame in self._send(outgoing(words, to))]
        if (target := self._targets.get(pgn)) is not None:
            return self._send(outgoing(target.message()))
        again = self._again(pgn, now)
        return [] if again is None else self._send(again)

    def _again(self, pgn: int, now: float) -> Outgoing | None:
        """What we sent of a PGN lately, if it is sent over and over: no order to a pilot is ever repeated."""
        if pgn == STEERING or interval(pgn) is None or pgn not in self._sent:
            return None
        return self._sent[pgn] if now < self._fresh[pgn] + FRESH else None

    def _claim(self) -> IsoAddressClaim:
        return IsoAddressClaim.decode(self.name.to_bytes(8, "little"))

    def _heartbeat(self) -> Heartbeat:
        return Heartbeat(
            data_transmit_offset=self._heartbeat_interval,
            sequence_counter=self._heartbeats,
            controller1_state=ControllerState.ERROR_ACTIVE,
            equipment_status=EquipmentStatus.OPERATIONAL,
        )

    def _product(self) -> ProductInformation:
        return ProductInformation(
            nmea2000_version=2.1,
            product_code=self.settings.product_code,
            model_id=self.settings.model,
            software_version_code=self.settings.software,
            model_version="",
            model_serial_code=self.settings.serial or str(self.settings.unique_number),
            certification_level=CertificationLevel.LEVEL_B,
            load_equivalency=1,
        )

    def _configuration(self) -> ConfigurationInformation:
        return ConfigurationInformation(
            installation_description1=self._installation[0],
            installation_description2=self._installation[1],
            manufacturer_information="timonel",
        )

    def _list(self, function: PgnListFunction) -> PgnListTransmitAndReceive:
        pgns = self._receives if function is PgnListFunction.RECEIVE else sorted({*SENDS, *self._sent})
        return PgnListTransmitAndReceive(function_code=function, pgns=tuple(pgns[:LISTED]))

    # What we can be told --------------------------------------------------------------------------

    def _rename(self, parameters: Sequence[Parameter]) -> None:
        assert self._claimer is not None
        name = self.name
        for parameter in parameters:
            slot = IsoAddressClaim.layout[parameter.index - 1]
            ones = (1 << (slot.length or 0)) - 1
            name = name & ~(ones << (slot.offset or 0)) | int.from_bytes(parameter.value, "little") << (
                slot.offset or 0
            )
        if name != self.name:
            self._events += self._claimer.rename(name, self.now)

    def _describe(self, parameters: Sequence[Parameter]) -> None:
        told = list(self._installation)
        for parameter in parameters:
            text = ConfigurationInformation.layout[0].field.read(parameter.value, 0)[0]  # type: ignore[attr-defined]
            told[parameter.index - 1] = text or ""
        self._installation = (told[0], told[1])
        self._events.append(Described(*self._installation))

    def _beat_every(self, seconds: float | None) -> None:
        self._heartbeat_interval = seconds or HEARTBEAT_INTERVAL
