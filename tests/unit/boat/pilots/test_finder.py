"""Which device is the pilot."""

import pytest

from timonel.nmea2000.devices import Devices, name_of
from timonel.nmea2000.lookups import DeviceClass, IndustryCode, ManufacturerCode, YesNoBit
from timonel.nmea2000.messages.network import IsoAddressClaim, ProductInformation
from timonel.vehicles.boat.pilots import KINDS, Wanted, finder_of
from timonel.vehicles.boat.pilots.finder import Finder, maker_called
from timonel.vehicles.boat.settings import BoatSettings

RAYMARINE, GARMIN, NAVICO = ManufacturerCode.RAYMARINE, ManufacturerCode.GARMIN, ManufacturerCode.NAVICO
STEERING = DeviceClass.STEERING_AND_CONTROL


def claim(maker=RAYMARINE, kind=STEERING, function=150, number=1):
    return IsoAddressClaim(
        unique_number=number,
        manufacturer_code=maker,
        device_instance_lower=0,
        device_instance_upper=0,
        device_function=function,
        device_class=kind,
        system_instance=0,
        industry_group=IndustryCode.MARINE,
        arbitrary_address_capable=YesNoBit.NO,
    )


def on_the_bus(*claims):
    """Devices at 10, 11, ..."""
    devices = Devices()
    for place, told in enumerate(claims):
        devices.receive(told, 10 + place, 0.0)
    return devices


def product(model):
    blank = ProductInformation.decode(b"")
    return ProductInformation(**{n: getattr(blank, n) for n in blank.__struct_fields__} | {"model_id": model})


def test_a_pilot_is_what_says_to_be_one_in_class_and_function():
    devices = on_the_bus(claim(kind=DeviceClass.NAVIGATION), claim(function=155), claim())
    assert Finder(devices, Wanted()).address == 12


def test_without_one_and_with_several_there_is_no_address_but_a_reason():
    none, several = Finder(on_the_bus(), Wanted()), Finder(on_the_bus(claim(), claim(number=2)), Wanted())
    assert (none.address, none.objection) == (None, "no pilot found on the bus")
    assert (several.address, several.objection) == (None, "several pilots on the bus: pilot_name says which")


def test_one_that_is_found_has_no_objection_and_is_found_where_it_moves_to():
    devices = on_the_bus(claim())
    finder = Finder(devices, Wanted())
    assert (finder.address, finder.objection) == (10, None)
    devices.receive(claim(), 99, 1.0)
    assert finder.address == 99


def test_one_that_lost_its_address_is_not_there():
    devices = on_the_bus(claim())
    devices.receive(claim(), 254, 1.0)
    assert Finder(devices, Wanted()).address is None


@pytest.mark.parametrize(("driver", "address"), [("raymarine", 10), ("garmin", 11), ("navico", 12)])
def test_each_driver_looks_for_pilots_of_its_makers(driver, address):
    devices = on_the_bus(claim(), claim(GARMIN), claim(NAVICO))
    assert finder_of(BoatSettings(pilot=driver), devices).address == address


@pytest.mark.parametrize("maker", [NAVICO, ManufacturerCode.SIMRAD, ManufacturerCode.B_AND_G])
def test_a_navico_pilot_may_bear_any_of_its_makers_names(maker):
    assert finder_of(BoatSettings(pilot="navico"), on_the_bus(claim(maker))).address == 10


def test_of_several_the_owner_names_one_by_its_name_or_by_its_maker():
    devices = on_the_bus(claim(), claim(GARMIN), claim(number=2))
    second = f"0x{name_of(claim(number=2)):x}"
    assert finder_of(BoatSettings(pilot="groupfunction", pilot_name=second), devices).address == 12
    assert finder_of(BoatSettings(pilot="groupfunction", pilot_name="garmin"), devices).address == 11
    assert finder_of(BoatSettings(pilot="groupfunction", pilot_name="raymarine"), devices).address is None


def test_a_device_that_its_owner_names_need_not_say_that_it_is_a_pilot():
    odd = claim(function=140)
    named = BoatSettings(pilot="raymarine", pilot_name=f"0x{name_of(odd):X}")
    assert finder_of(named, on_the_bus(odd)).address == 10


def test_a_converter_is_found_by_what_its_product_information_says():
    devices = on_the_bus(claim(kind=DeviceClass.INTERNETWORK_DEVICE, function=130), claim())
    finder = finder_of(BoatSettings(pilot="raymarine-spx"), devices)
    assert finder.address is None
    devices.receive(product("SeaTalk-STNG-Converter"), 10, 1.0)
    assert finder.address == 10
    devices.receive(product("i70"), 10, 1.0)
    assert finder.address is None


@pytest.mark.parametrize(("word", "maker"), [("raymarine", RAYMARINE), ("B and G", ManufacturerCode.B_AND_G)])
def test_a_maker_is_called_by_its_name(word, maker):
    assert maker_called(word) is maker


@pytest.mark.parametrize("text", ["rymarine", "0x1ffffffffffffffff", "0xzz", "204"])
def test_what_names_no_pilot_is_refused(text):
    with pytest.raises(ValueError, match=r"0x|rymarine|204|base 16"):
        Wanted.of(text)


def test_the_empty_name_wants_any():
    assert Wanted.of("") == Wanted()


def test_every_driver_is_described_and_may_be_chosen():
    for name, kind in KINDS.items():
        assert kind.name == name
        assert finder_of(BoatSettings(pilot=name), on_the_bus(claim())) is not None
        assert all((kind.steers, kind.sources, kind.sends, kind.confirmed_by, kind.references))
