"""The devices of a bus, each known by its NAME: a device that moves to another address stays the same device.

message                       what becomes known
address claim                 the NAME and the address; whoever had that address before has none now
claim from 254 (null)         a device that found no address: it is known, but nothing can be told to it
product information           maker's model, versions and serial number
configuration information     what the installer wrote into it
PGN lists                     what it sends and what it understands
heartbeat                     that it is alive

What a source says before it told its NAME is not kept: nobody knows whose it is. A flood cannot make the table
grow: an address has one device, and of those without an address the last `HOMELESS` are remembered.
"""

from collections.abc import Iterator

import msgspec

from timonel.core.message import Message
from timonel.nmea2000.identifier import NULL
from timonel.nmea2000.lookups import PgnListFunction
from timonel.nmea2000.messages.network import (
    ConfigurationInformation,
    Heartbeat,
    IsoAddressClaim,
    PgnListTransmitAndReceive,
    ProductInformation,
)

HOMELESS = 32
"""How many devices without an address are remembered."""


class Device(msgspec.Struct, frozen=True):
    """One device. `address` is 254 while it has none; `since` is when its NAME was first heard, s.

    `heard` is when it last said something of itself, s: not every message counts, but claims, information, lists and
    heartbeats. What it has not told yet is None, or an empty list of PGNs.
    """

    name: int
    address: int
    claim: IsoAddressClaim
    since: float
    heard: float
    product: ProductInformation | None = None
    configuration: ConfigurationInformation | None = None
    transmits: tuple[int, ...] = ()
    receives: tuple[int, ...] = ()

    @property
    def instance(self) -> int:
        """The device instance, which both halves of it make, 0..255."""
        return self.claim.device_instance_upper << 3 | self.claim.device_instance_lower


def name_of(claim: IsoAddressClaim) -> int:
    """The 64-bit NAME as a number, the lower of which wins.

    Codes that mean "not available" come out as all ones: who has the payload has the NAME as it stood there.
    """
    return int.from_bytes(claim.encode(), "little")


class Devices:
    """All devices that told their NAME."""

    def __init__(self) -> None:
        self.revision = 0
        """Moves on whenever something becomes known that was not; that a device is still alive is nothing new."""
        self._by_address: dict[int, Device] = {}
        self._homeless: dict[int, Device] = {}
        self._addresses: dict[int, int] = {}  # of those that have one, by NAME

    @property
    def all(self) -> list[Device]:
        """By address, those without one last."""
        return sorted(self, key=lambda device: device.address)

    def __iter__(self) -> Iterator[Device]:
        yield from self._by_address.values()
        yield from self._homeless.values()

    def __len__(self) -> int:
        return len(self._by_address) + len(self._homeless)

    def at(self, address: int) -> Device | None:
        """Who has this address now; None if nobody told."""
        return self._by_address.get(address)

    def by_name(self, name: int) -> Device | None:
        """The device with this NAME, wherever it is."""
        address = self._addresses.get(name)
        return self._homeless.get(name) if address is None else self._by_address[address]

    def receive(self, message: Message, source: int, now: float, name: int | None = None) -> Device | None:
        """The device at `source` said something; the device as it is now known, None if that is nobody's word.

        `name` is the NAME as it stood in the frame of a claim, for who has it.
        """
        if isinstance(message, IsoAddressClaim):
            return self._claimed(message, name_of(message) if name is None else name, source, now)
        device = self._by_address.get(source)
        if device is None:
            return None
        told = _told(device, message, now)
        if not isinstance(message, Heartbeat) and told is not device:
            self.revision += 1
        self._by_address[source] = told
        return told

    def _claimed(self, claim: IsoAddressClaim, name: int, address: int, now: float) -> Device:
        known = self._take(name)
        if known is None or known.address != address:
            self.revision += 1
        if known is None:
            device = Device(name, address, claim, now, now)
        else:
            device = msgspec.structs.replace(known, address=address, claim=claim, heard=now)
        if address >= NULL:
            self._send_away(device)
            return device
        if (previous := self._by_address.pop(address, None)) is not None:
            del self._addresses[previous.name]
            self._send_away(previous)
        self._by_address[address] = device
        self._addresses[name] = address
        return device

    def _take(self, name: int) -> Device | None:
        """The device with this NAME, taken from its place."""
        address = self._addresses.pop(name, None)
        return self._homeless.pop(name, None) if address is None else self._by_address.pop(address)

    def _send_away(self, device: Device) -> None:
        self._homeless[device.name] = msgspec.structs.replace(device, address=NULL)
        if len(self._homeless) > HOMELESS:
            del self._homeless[next(iter(self._homeless))]


def _told(device: Device, message: Message, now: float) -> Device:
    match message:
        case ProductInformation():
            return msgspec.structs.replace(device, product=message, heard=now)
        case ConfigurationInformation():
            return msgspec.structs.replace(device, configuration=message, heard=now)
        case PgnListTransmitAndReceive(function_code=PgnListFunction.TRANSMIT):
            return msgspec.structs.replace(device, transmits=message.pgns, heard=now)
        case PgnListTransmitAndReceive(function_code=PgnListFunction.RECEIVE):
            return msgspec.structs.replace(device, receives=message.pgns, heard=now)
        case Heartbeat():
            return msgspec.structs.replace(device, heard=now)
    return device
