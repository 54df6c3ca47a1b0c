"""The devices of a bus as people and programs see them: one description of each, in words."""

from collections.abc import Collection, Iterable

import msgspec

from timonel.nmea2000 import catalogue
from timonel.nmea2000.devices import Device
from timonel.nmea2000.identifier import NULL
from timonel.nmea2000.messages.network import ConfigurationInformation, ProductInformation
from timonel.nmea2000.node import Node

NO_MAKER = 2045  # the first code that no maker has


class DeviceShown(msgspec.Struct, frozen=True):
    """One device. What it has not told is None; so is the address of one that has none, and the NAME of one that
    has not introduced itself. `name` is the NAME in 16 hexadecimal digits, `seconds` the time since it was first heard.
    """

    address: int | None
    name: str | None = None
    maker: str | None = None
    model: str | None = None
    software: str | None = None
    serial: str | None = None
    device_class: str | None = None
    function: str | None = None
    instance: int | None = None
    system_instance: int | None = None
    installation: str | None = None
    seconds: float | None = None
    ours: bool = False


def shown(device: Device, now: float, ours: bool = False) -> DeviceShown:
    """What `device` told until `now`, s."""
    name = device.name
    code, device_class, function = name >> 21 & 0x7FF, name >> 49 & 0x7F, name >> 40 & 0xFF
    product = device.product or ProductInformation.decode(b"")
    return DeviceShown(
        address=device.address if device.address < NULL else None,
        name=f"{name:016X}",
        maker=None if code >= NO_MAKER else catalogue.labels("MANUFACTURER_CODE").get(code, f"maker {code}"),
        model=product.model_id,
        software=product.software_version_code,
        serial=product.model_serial_code,
        device_class=catalogue.labels("DEVICE_CLASS").get(device_class, f"class {device_class}"),
        function=catalogue.pairs("DEVICE_FUNCTION").get(device_class, {}).get(function, f"function {function}"),
        instance=name >> 32 & 0xFF,
        system_instance=name >> 56 & 0xF,
        installation=_installation(device.configuration),
        seconds=round(now - device.since, 1),
        ours=ours,
    )


def roll(
    devices: Iterable[Device], now: float, node: Node | None = None, nameless: Collection[int] = ()
) -> list[DeviceShown]:
    """All of them by address, those without one last; with our own `node` where it is one, and with the addresses
    of those who spoke and told no NAME."""
    rows = [shown(device, now) for device in devices]
    if node is not None and (us := node.ourselves()) is not None:
        rows.append(shown(us, now, ours=True))
    rows += [DeviceShown(address) for address in nameless]
    return sorted(rows, key=lambda row: (row.address is None, row.address or 0, row.name or ""))


def _installation(configuration: ConfigurationInformation | None) -> str | None:
    if configuration is None:
        return None
    words = (configuration.installation_description1, configuration.installation_description2)
    return ", ".join(word for word in words if word) or None
