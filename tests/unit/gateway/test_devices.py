"""Devices as people and programs see them."""

from tests.unit.nmea2000.test_devices import claim, product
from timonel.gateway.devices import DeviceShown, roll, shown
from timonel.nmea2000.devices import Devices
from timonel.nmea2000.identifier import GLOBAL, NULL
from timonel.nmea2000.messages.network import ConfigurationInformation, IsoAddressClaim
from timonel.nmea2000.node import Node, NodeSettings
from timonel.nmea2000.sender import Sender


def test_a_device_is_told_in_words() -> None:
    devices = Devices()
    devices.receive(claim(1, instance=9), 204, now=2.0)
    devices.receive(product("EV-1"), 204, now=3.0)
    written = ConfigurationInformation(
        installation_description1="locker", installation_description2="port", manufacturer_information=None
    )
    told = devices.receive(written, 204, now=3.0)
    assert told is not None
    assert shown(told, now=5.5) == DeviceShown(
        address=204,
        name=f"{told.name:016X}",
        maker="Raymarine",
        model="EV-1",
        software="1",
        serial="42",
        device_class="Steering and Control surfaces",
        function="Autopilot",
        instance=9,
        system_instance=0,
        installation="locker, port",
        seconds=3.5,
    )


def test_codes_that_nobody_knows_stay_numbers_and_a_builder_without_a_code_has_no_maker() -> None:
    devices = Devices()
    for number, (maker, device_class) in enumerate(((1, 1), (2046, 127))):
        name = 7 | maker << 21 | 255 << 40 | device_class << 49
        devices.receive(IsoAddressClaim.decode(name.to_bytes(8, "little")), number, now=0.0, name=name)
    one, other = roll(devices, now=0.0)
    assert (one.maker, one.device_class, one.function) == ("maker 1", "class 1", "function 255")
    assert (other.maker, other.device_class) == (None, "class 127")


def test_the_roll_is_by_address_with_ourselves_and_those_without_a_name_or_address() -> None:
    devices = Devices()
    devices.receive(claim(1), NULL, now=0.0)
    devices.receive(claim(2), 40, now=0.0)
    node = Node(NodeSettings(unique_number=3), Sender(35), devices, now=0.0)
    node._sender.address = 35
    rows = roll(devices, 1.0, node, nameless=(7,))
    assert [(row.address, row.ours) for row in rows] == [(7, False), (35, True), (40, False), (None, False)]
    assert rows[0] == DeviceShown(7)
    assert rows[1].model == "timonel"
    assert all(row.address != GLOBAL for row in rows)
    assert len(roll(devices, 1.0, Node(None, Sender(35), devices, now=0.0))) == 2
