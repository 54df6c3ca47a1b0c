"""Instruments, the order of sources and corrections in a configuration."""

import logging

import pytest

from timonel.errors import ConfigError
from timonel.gateway.configuration import parse
from timonel.gateway.health import describe, level
from timonel.gateway.machine import describe as described
from timonel.gateway.machine import make
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.sources import Correction, SourceChanged, SourceDamaged, SourceSettings

HEAD = '[vehicle]\nkind = "boat"\n[bus]\nurl = "loop://a"\nnode = false\n'
INPUT = '[[input]]\nname = "Compass"\nurl = "pty:///tmp/compass"\n'
STATION = '[[station]]\nid = 2\nurl = "pty:///tmp/cockpit"\n'


def settings(text: str) -> SourceSettings | None:
    vehicle = parse(HEAD + text).vehicle
    assert isinstance(vehicle, BoatSettings)
    return vehicle.sources


def mistakes(text: str) -> list[str]:
    with pytest.raises(ConfigError) as told:
        parse(HEAD + text)
    return str(told.value).splitlines()


def test_an_input_is_a_port_of_instruments_and_enough_to_run() -> None:
    configuration = parse(HEAD + INPUT + '[[input]]\nurl = "tcp://127.0.0.1:10110"\n')
    assert configuration.ports == [Port("Compass", instrument=True), Port("Input 2", instrument=True)]
    assert [url for _, url in configuration.instrument_urls] == ["pty:///tmp/compass", "tcp://127.0.0.1:10110"]


def test_a_stations_wire_may_have_instruments() -> None:
    assert parse(HEAD + STATION + "instruments = true\n").ports == [Port("Station 2", 2, instrument=True)]
    assert parse(HEAD + STATION).ports == [Port("Station 2", 2)]


def test_where_nothing_is_said_of_sources_they_have_no_order() -> None:
    assert settings(INPUT) is None


def test_every_key_reaches_the_boat() -> None:
    text = (
        '[sources]\nheading = ["Compass", "0xC0328200E0000001"]\nwind = ["0xc0328200e0000002"]\nhold = 2\nsettle = 0\n'
        'hdop_limit = 4.5\nbroken = 0.1\nderive = ["true_wind", "current"]\n'
        '[[correction]]\nsource = "Compass"\nheading_deg = -2.5\n'
        '[[correction]]\nsource = "0xc0328200e0000002"\nrudder_invert = true\nwind_deg = 3\ndepth_offset_m = -1.2\n'
    )
    assert settings(INPUT + text) == SourceSettings(
        order={"heading": ("Compass", "0xC0328200E0000001"), "wind": ("0xc0328200e0000002",)},
        hold=2.0,
        settle=0.0,
        hdop_limit=4.5,
        broken=0.1,
        derive=("true_wind", "current"),
        corrections=(
            Correction("Compass", heading_deg=-2.5),
            Correction("0xc0328200e0000002", rudder_invert=True, wind_deg=3.0, depth_offset_m=-1.2),
        ),
    )


def test_a_recording_holds_them() -> None:
    configuration = parse(HEAD + INPUT + '[sources]\nheading = ["Compass"]\n[[correction]]\nsource = "Compass"\n')
    assert make(described(configuration, 0.0)).settings == configuration.vehicle  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[[input]]\nname = 'x'\n", "boat.toml:6, input[1].url: missing; where the instruments are"),
        (INPUT + INPUT, 'input[2].name: "Compass" is input[1].name already'),
        (INPUT + INPUT.replace("Compass", "Other"), 'input[2].url: "pty:///tmp/compass" is input[1].url already'),
        (
            INPUT.replace("pty:///tmp/compass", "socketcan://can0"),
            "input[1].url: socketcan://can0: not the URL of a port",
        ),
        (
            "[[station]]\nshared = true\nurl = 'pty:///tmp/x'\ninstruments = true\n",
            "station[1].instruments: not on a wire that several stations share",
        ),
        (INPUT + '[sources]\nheading = ["Compas"]\n', '"Compas" is no port of instruments (did you mean "Compass"?)'),
        (STATION + '[sources]\nheading = ["Station 2"]\n', '"Station 2" is no port of instruments'),
        (INPUT + '[sources]\nheading = ["0x12"]\n', '"0x12" is no NAME: 0x and 16 hexadecimal digits'),
        (INPUT + "[sources]\nheading = 3\n", "sources.heading: 3 should be"),
        (INPUT + '[sources]\nderive = ["waves"]\n', "sources.derive"),
        (INPUT + "[sources]\nheadings = []\n", 'sources.headings: unknown key (did you mean "heading"?)'),
        (INPUT + "[[correction]]\nwind_deg = 3\n", "correction[1].source: missing; whose values are to be corrected"),
        (INPUT + '[[correction]]\nsource = "Compass"\nwind_deg = 300\n', "correction[1].wind_deg: 300 should be"),
        (INPUT + '[[correction]]\nsource = "Wind"\n', 'correction[1].source: "Wind" is no port of instruments'),
    ],
)
def test_a_mistake_is_told_with_what_would_be_right(text: str, told: str) -> None:
    assert any(told in line for line in mistakes(text)), mistakes(text)


def test_a_rover_has_no_such_tables() -> None:
    text = '[vehicle]\nkind = "rover"\n[bus]\nurl = "loop://a"\n[[station]]\nid = 1\nurl = "pty:///tmp/x"\n' + INPUT
    with pytest.raises(ConfigError, match="input: unknown table"):
        parse(text)


def test_who_rules_is_told_in_words() -> None:
    assert describe(SourceChanged("true heading", "Compass", "")) == "true heading: from Compass"
    assert describe(SourceChanged("depth", "0x01", "Wind")) == "depth: from 0x01, no longer Wind"
    damaged = SourceDamaged("Compass", True, 0.254)
    assert describe(damaged) == "Compass: 25% of its sentences are damaged, it comes last"
    assert describe(SourceDamaged("Compass", False, 0.02)) == "Compass: 2% of its sentences are damaged, it counts"
    assert level(damaged) == logging.WARNING
    assert level(SourceDamaged("Compass", False, 0.02)) == logging.INFO
