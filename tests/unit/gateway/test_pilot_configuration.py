"""What an owner says about the pilot, and what is wrong with it."""

import pytest

from timonel.errors import ConfigError
from timonel.gateway.configuration import Configuration, parse
from timonel.gateway.machine import describe, make
from timonel.vehicles.boat.pilots import KINDS
from timonel.vehicles.boat.settings import BoatSettings
from timonel.vehicles.boat.vehicle import Boat

OUTPUT = '[[output]]\nname = "Pilot"\nurl = "tcp-listen://127.0.0.1:10111"\n'


def configuration(keys: str = "", output: str = OUTPUT) -> Configuration:
    return parse(f'[vehicle]\nkind = "boat"\n{keys}[bus]\nurl = "loop://a"\n{output}')


def mistakes(keys: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        configuration(keys)
    return [line.partition(", ")[2] for line in str(caught.value).splitlines()]


def settings(keys: str = "") -> BoatSettings:
    vehicle = configuration(keys).vehicle
    assert isinstance(vehicle, BoatSettings)
    return vehicle


def test_no_driver_from_reverse_engineering_is_on_unless_it_is_chosen() -> None:
    assert (settings().pilot, settings().pilot_name, settings().obey_htc) == ("standard", "", False)


@pytest.mark.parametrize("name", [name for name in KINDS if name != "sentence"])
def test_every_driver_may_be_chosen(name: str) -> None:
    boat = Boat(settings(f'pilot = "{name}"\n'), [], 0.0)
    assert boat.steering.kind is KINDS[name]


def test_a_pilot_on_an_output_is_chosen_with_its_sentences() -> None:
    chosen = settings('pilot = "sentence"\npilot_output = "Pilot"\npilot_sentences = ["HTC", "HSC"]\n')
    assert (chosen.pilot_output, chosen.pilot_sentences) == ("Pilot", ("HTC", "HSC"))


@pytest.mark.parametrize(
    ("keys", "mistake"),
    [
        ('pilot = "raymarin"\n', 'vehicle.pilot: "raymarin" is unknown; one of'),
        ('pilot_name = "rymarine"\n', "vehicle.pilot_name: 'rymarine' is neither a NAME like 0xC0509635E761AEC1"),
        ('pilot_name = "0x1ffffffffffffffff"\n', "vehicle.pilot_name: 0x1ffffffffffffffff has more than 64 bits"),
        ('pilot = "sentence"\n', "vehicle.pilot_output: missing; the name of the [[output]] where the pilot is"),
        (
            'pilot = "sentence"\npilot_output = "Pilto"\n',
            'vehicle.pilot_output: there is no [[output]] with the name "Pilto"',
        ),
        (
            'pilot = "navico"\npilot_output = "Pilot"\n',
            'vehicle.pilot_output: goes with pilot = "sentence", not with "navico"',
        ),
        ('pilot_sentences = ["HTC"]\n', 'vehicle.pilot_sentences: goes with pilot = "sentence", not with "standard"'),
    ],
)
def test_what_is_wrong_about_the_pilot_is_said_with_its_key(keys: str, mistake: str) -> None:
    (said,) = mistakes(keys)
    assert said.startswith(mistake) or mistake.split(";")[0].split(" is ")[0] in said


def test_a_recording_holds_the_driver_and_older_ones_have_the_standards() -> None:
    chosen = configuration('pilot = "navico"\npilot_name = "garmin"\nobey_htc = true\n')
    description = describe(chosen, 0.0)
    again = make(description)
    assert isinstance(again, Boat)
    assert again.settings == chosen.vehicle
    older = make(description | {"settings": '{"name": "boat", "pilot": "standard"}'})
    assert isinstance(older, Boat)
    assert older.steering.kind is KINDS["standard"]
