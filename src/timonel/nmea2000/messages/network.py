"""Network management: requests, acknowledgements, addresses, names and what a device says of itself."""

from typing import Annotated

from timonel.core.fields import U8, U16, Ascii, Bits, Lookup, Packed, Reserved, Spare, StringLau, Unsigned
from timonel.core.message import Message
from timonel.nmea2000.lookups import (
    CertificationLevel,
    ControllerState,
    DeviceClass,
    EquipmentStatus,
    IndustryCode,
    IsoControl,
    ManufacturerCode,
    PgnListFunction,
    YesNoBit,
)


class IsoAcknowledgement(Message, pgn=59392):
    """PGN 59392: the answer to a request, that it was carried out or why not.

    Single frame, priority 6, on event. Layout: canboat `isoAcknowledgement`.
    """

    control: Annotated[IsoControl | None, Lookup(8, IsoControl)]
    group_function: Annotated[int | None, U8()]
    reserved: Annotated[None, Reserved(24)] = None
    pgn: Annotated[int, Bits(24)]


class IsoRequest(Message, pgn=59904):
    """PGN 59904: asks for a PGN, of one device or of all.

    Single frame, priority 6, on event. Layout: canboat `isoRequest`.
    """

    pgn: Annotated[int, Bits(24)]


class IsoAddressClaim(Message, pgn=60928):
    """PGN 60928: a device says which address it has; the payload is its NAME, and the lower NAME wins.

    Single frame, priority 6, on event. Layout: canboat `isoAddressClaim`.
    """

    unique_number: Annotated[int | None, Unsigned(21)]
    manufacturer_code: Annotated[ManufacturerCode | None, Lookup(11, ManufacturerCode)]
    device_instance_lower: Annotated[int, Bits(3)]
    device_instance_upper: Annotated[int, Bits(5)]
    device_function: Annotated[int | None, U8()]
    spare: Annotated[None, Spare(1)] = None
    device_class: Annotated[DeviceClass | None, Lookup(7, DeviceClass)]
    system_instance: Annotated[int | None, Unsigned(4)]
    industry_group: Annotated[IndustryCode | None, Lookup(3, IndustryCode)]
    arbitrary_address_capable: Annotated[YesNoBit, Lookup(1, YesNoBit)]


class IsoCommandedAddress(Message, pgn=65240):
    """PGN 65240: tells the device with this NAME to take another address.

    9 bytes, by ISO transport, priority 6, on event. Layout: canboat `isoCommandedAddress`.
    """

    unique_number: Annotated[int, Bits(21)]
    manufacturer_code: Annotated[ManufacturerCode | None, Lookup(11, ManufacturerCode)]
    device_instance_lower: Annotated[int, Bits(3)]
    device_instance_upper: Annotated[int, Bits(5)]
    device_function: Annotated[int | None, U8()]
    reserved: Annotated[None, Reserved(1)] = None
    device_class: Annotated[DeviceClass | None, Lookup(7, DeviceClass)]
    system_instance: Annotated[int | None, Unsigned(4)]
    industry_code: Annotated[IndustryCode | None, Lookup(3, IndustryCode)]
    reserved10: Annotated[None, Reserved(1)] = None
    new_source_address: Annotated[int | None, U8()]


class PgnListTransmitAndReceive(Message, pgn=126464):
    """PGN 126464: the PGNs that a device sends, or understands.

    Fast packet, priority 6, on event. Layout: canboat `pgnListTransmitAndReceive`.
    """

    function_code: Annotated[PgnListFunction | None, Lookup(8, PgnListFunction)]
    pgns: Annotated[tuple[int, ...], Packed(Bits(24))] = ()


class Heartbeat(Message, pgn=126993):
    """PGN 126993: a device is alive; `data_transmit_offset` is the time to the next heartbeat.

    Single frame, priority 7, every 60 s. Layout: canboat `heartbeat`.
    """

    data_transmit_offset: Annotated[float | None, U16(0.001, "s")]
    sequence_counter: Annotated[int | None, U8()]
    controller1_state: Annotated[ControllerState | None, Lookup(2, ControllerState)] = None
    controller2_state: Annotated[ControllerState | None, Lookup(2, ControllerState)] = None
    equipment_status: Annotated[EquipmentStatus | None, Lookup(2, EquipmentStatus)] = None
    reserved: Annotated[None, Reserved(34)] = None


class ProductInformation(Message, pgn=126996):
    """PGN 126996: maker's name and versions of a device. `load_equivalency` is in steps of 50 mA.

    Fast packet, priority 6, on event. Layout: canboat `productInformation`.
    """

    nmea2000_version: Annotated[float | None, U16(0.001)]
    product_code: Annotated[int | None, U16()]
    model_id: Annotated[str | None, Ascii(32)]
    software_version_code: Annotated[str | None, Ascii(32)]
    model_version: Annotated[str | None, Ascii(32)]
    model_serial_code: Annotated[str | None, Ascii(32)]
    certification_level: Annotated[CertificationLevel | None, Lookup(8, CertificationLevel)]
    load_equivalency: Annotated[int | None, U8()]


class ConfigurationInformation(Message, pgn=126998):
    """PGN 126998: what the installer wrote into a device.

    Fast packet, priority 6, on event. Layout: canboat `configurationInformation`.
    """

    installation_description1: Annotated[str | None, StringLau()]
    installation_description2: Annotated[str | None, StringLau()]
    manufacturer_information: Annotated[str | None, StringLau()]
