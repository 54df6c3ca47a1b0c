from timonel.nmea2000.devices import HOMELESS, Devices, name_of
from timonel.nmea2000.lookups import DeviceClass, IndustryCode, ManufacturerCode, PgnListFunction, YesNoBit
from timonel.nmea2000.messages.network import (
    ConfigurationInformation,
    Heartbeat,
    IsoAddressClaim,
    PgnListTransmitAndReceive,
    ProductInformation,
)
from timonel.nmea2000.messages.steering import Rudder


def claim(unique: int, instance: int = 0) -> IsoAddressClaim:
    return IsoAddressClaim(
        unique_number=unique,
        manufacturer_code=ManufacturerCode.RAYMARINE,
        device_instance_lower=instance & 7,
        device_instance_upper=instance >> 3,
        device_function=150,
        device_class=DeviceClass.STEERING_AND_CONTROL,
        system_instance=0,
        industry_group=IndustryCode.MARINE,
        arbitrary_address_capable=YesNoBit.YES,
    )


def product(model: str) -> ProductInformation:
    return ProductInformation(
        nmea2000_version=2.1,
        product_code=1,
        model_id=model,
        software_version_code="1",
        model_version="A",
        model_serial_code="42",
        certification_level=None,
        load_equivalency=1,
    )


ONE, TWO = name_of(claim(1)), name_of(claim(2))


def test_the_name_is_the_payload_of_the_claim() -> None:
    real = bytes.fromhex("d204e07c008232c0")
    assert name_of(IsoAddressClaim.decode(real)) == int.from_bytes(real, "little")


def test_a_device_is_found_by_its_address_and_by_its_name() -> None:
    devices = Devices()
    device = devices.receive(claim(1), 204, now=5.0)
    assert devices.at(204) is device is devices.by_name(ONE)
    assert device is not None
    assert (device.name, device.address, device.since, device.heard) == (ONE, 204, 5.0, 5.0)
    assert devices.at(7) is None
    assert devices.by_name(TWO) is None


def test_a_device_that_moves_is_the_same_device() -> None:
    devices = Devices()
    devices.receive(claim(1), 204, now=0.0)
    devices.receive(product("EV-1"), 204, now=1.0)
    moved = devices.receive(claim(1), 205, now=2.0)
    assert devices.at(204) is None
    assert moved is not None
    assert moved is devices.at(205)
    assert (moved.product, moved.since, moved.heard) == (product("EV-1"), 0.0, 2.0)
    assert len(devices) == 1


def test_who_loses_its_address_is_known_by_its_name_still_and_comes_back_with_all_that_it_told() -> None:
    devices = Devices()
    devices.receive(claim(2), 10, now=0.0)
    devices.receive(product("loser"), 10, now=0.0)
    devices.receive(claim(1), 10, now=1.0)
    loser = devices.by_name(TWO)
    assert loser is not None
    assert loser.address == 254
    back = devices.receive(claim(2), 11, now=2.0)
    assert back is not None
    assert back.product == product("loser")
    assert [device.address for device in devices.all] == [10, 11]


def test_a_device_that_cannot_claim_has_no_address() -> None:
    devices = Devices()
    devices.receive(claim(1), 10, now=0.0)
    devices.receive(claim(1), 254, now=1.0)
    assert devices.at(10) is None
    assert devices.at(254) is None
    assert [device.address for device in devices.all] == [254]


def test_what_a_device_says_of_itself_is_kept() -> None:
    devices = Devices()
    devices.receive(claim(1, instance=9), 10, now=0.0)
    words = ConfigurationInformation(
        installation_description1="port", installation_description2=None, manufacturer_information=None
    )
    devices.receive(words, 10, now=1.0)
    devices.receive(PgnListTransmitAndReceive(function_code=PgnListFunction.TRANSMIT, pgns=(127237,)), 10, now=2.0)
    devices.receive(PgnListTransmitAndReceive(function_code=PgnListFunction.RECEIVE, pgns=(59904,)), 10, now=3.0)
    devices.receive(Heartbeat(data_transmit_offset=60.0, sequence_counter=0), 10, now=60.0)
    device = devices.at(10)
    assert device is not None
    assert (device.configuration, device.transmits, device.receives) == (words, (127237,), (59904,))
    assert (device.instance, device.heard, device.since) == (9, 60.0, 0.0)


def test_what_says_nothing_of_the_device_changes_nothing() -> None:
    devices = Devices()
    before = devices.receive(claim(1), 10, now=0.0)
    assert devices.receive(Rudder.decode(bytes(8)), 10, now=1.0) is before
    undecided = PgnListTransmitAndReceive(function_code=None, pgns=(1,))
    assert devices.receive(undecided, 10, now=1.0) is before


def test_what_somebody_says_who_told_no_name_is_not_kept() -> None:
    devices = Devices()
    assert devices.receive(product("who?"), 10, now=0.0) is None
    assert len(devices) == 0


def test_a_flood_of_claims_does_not_make_the_table_grow() -> None:
    devices = Devices()
    for number in range(20_000):
        devices.receive(claim(number), number % 256, now=0.0)
    assert len(devices) == 254 + HOMELESS


def test_a_flood_at_one_address_leaves_the_others_alone() -> None:
    devices = Devices()
    honest = devices.receive(claim(1), 10, now=0.0)
    for number in range(2, 1000):
        devices.receive(claim(number), 35, now=0.0)
    assert devices.at(10) is honest
    assert len(devices) == 2 + HOMELESS


def test_the_name_stays_as_it_stood_in_the_frame() -> None:
    """2046 is what builders without a maker's code use; decoded it is no maker."""
    payload = bytes.fromhex("d204c0ff008232c0")
    name = int.from_bytes(payload, "little")
    devices = Devices()
    device = devices.receive(IsoAddressClaim.decode(payload), 10, now=0.0, name=name)
    assert device is not None
    assert device.name == name
    assert devices.by_name(name) is device
