import asyncio
from pathlib import Path

import pytest

from timonel.errors import ConfigError
from timonel.gateway.assemble import assemble
from timonel.gateway.configuration import KINDS, load, parse
from timonel.gateway.link_settings import Station
from timonel.links.slcan import SlcanLink
from timonel.links.tcp_listen import TcpListenLink
from timonel.links.uart_bus import UartBus
from timonel.vehicles.boat.settings import Port
from timonel.vehicles.rover.calibration import DOCUMENTED, PHYSICAL
from timonel.vehicles.rover.framing import Hal062
from timonel.vehicles.rover.settings import RoverSettings
from timonel.vehicles.rover.vehicle import Rover

DOCS = Path(__file__).parents[3] / "docs"

VEHICLE = '[vehicle]\nkind = "rover"\n'
BUS = '[bus]\nurl = "socketcan://can0"\n'
STATION = '[[station]]\nid = 1\nurl = "tcp-listen://127.0.0.1:5001"\n'
SOUND = VEHICLE + BUS + STATION
OPERATOR = '[vehicle]\nkind = "rover"\nrole = "operator"\n[bus]\nurl = "serial:///dev/ttyUSB0"\n' + STATION


def mistakes(text: str, file: str = "rover.toml") -> list[str]:
    with pytest.raises(ConfigError) as caught:
        parse(text, file)
    return str(caught.value).splitlines()


def test_the_example_of_the_documentation_is_sound() -> None:
    configuration = load(DOCS / "rover.toml")
    assert [station.port for station in configuration.stations] == [
        Port("Operator", 1), Port("Jetson", 2), Port("Bench", 3),
    ]  # fmt: skip
    assert configuration.protocol.declaration(160).__name__ == "ArmJoints"
    assert configuration.protocol.calibration.current_zero_right == (1861.8, 1858.0, 1864.5)
    assert configuration.vehicle == RoverSettings(name="Strzyga")


def test_the_page_about_the_rover_names_every_key() -> None:
    page = (DOCS / "rover.md").read_text()
    kind = KINDS["rover"]
    keys = {
        key for table in (kind.tables, {"station": kind.lists["station"]}) for each in table.values() for key in each
    }
    for table in ("gateway", "recording", "web", "mqtt"):  # docs/configuration.md has them
        keys -= kind.tables[table].keys()
    assert [key for key in sorted(keys) if f"`{key}`" not in page] == []


def test_what_is_not_said_has_the_defaults_of_the_specification() -> None:
    configuration = parse(SOUND)
    assert configuration.vehicle == RoverSettings()
    assert configuration.protocol.calibration == PHYSICAL
    assert len(configuration.protocol.declarations) == 21
    assert configuration.stations == (
        Station(Port("Station 1", 1), "tcp-listen://127.0.0.1:5001", "tcp-listen://127.0.0.1:5001"),
    )


def test_the_vehicle_names_its_calibration_and_the_table_may_differ_from_it() -> None:
    named = SOUND.replace('kind = "rover"', 'kind = "rover"\ncalibration = "documented"')
    assert parse(named).protocol.calibration == DOCUMENTED
    assert parse(named + "[calibration]\nadc_volts = 5\n").protocol.calibration.adc_volts == 5


def test_a_calibration_is_a_base_and_what_differs_from_it() -> None:
    calibration = parse(SOUND + '[calibration]\nbase = "documented"\nadc_volts = 5\n').protocol.calibration
    assert calibration.adc_volts == 5
    assert calibration.encoder_pulses == DOCUMENTED.encoder_pulses


MISTAKES = {
    "a table of the boat": (
        SOUND + "[sentences]\nHDT = 1\n",
        "rover.toml:8, sentences: unknown table",
    ),
    "a key of the boat": (
        SOUND.replace("[bus]", 'pilot = "standard"\n[bus]'),
        "rover.toml:3, vehicle.pilot: unknown key",
    ),
    "a shared wire, whose frames would not say who speaks": (
        SOUND + "shared = true\n",
        "rover.toml:8, station[1].shared: unknown key",
    ),
    "a station without a number": (
        SOUND.replace("id = 1", 'name = "x"'),
        "rover.toml:5, station[1].id: missing; 1..4",
    ),
    "a misspelt role": (
        SOUND.replace("[bus]", 'role = "operater"\n[bus]'),
        'rover.toml:3, vehicle.role: "operater" should be "controller" or "operator" (did you mean "operator"?)',
    ),
    "a constant that there is not": (
        SOUND + "[calibration]\nadc_volt = 5\n",
        'rover.toml:9, calibration.adc_volt: unknown key (did you mean "adc_volts"?)',
    ),
    "a port as the bus of a controller": (
        SOUND.replace("socketcan://can0", "serial:///dev/ttyUSB0"),
        "rover.toml:4, bus.url: serial:///dev/ttyUSB0: not the URL of a bus "
        "(a bus is one of socketcan, slcan, loop, file, or text as ydraw+tcp)",
    ),
    "a bus where the operator has a port": (
        OPERATOR.replace("serial:///dev/ttyUSB0", "socketcan://can0"),
        "rover.toml:5, bus.url: socketcan://can0: not the URL of a port "
        "(a port is one of serial, pty, tcp, tcp-listen, udp, iec450)",
    ),
    "no link to the controller": (
        OPERATOR.replace('url = "serial:///dev/ttyUSB0"', ""),
        "rover.toml:4, bus.url: missing; a bus is needed, like serial:///dev/ttyUSB0",
    ),
    "a file of frames that is not there": (
        SOUND.replace("[bus]", 'frames = "nowhere.toml"\n[bus]'),
        "nowhere.toml: No such file or directory",
    ),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_a_mistake_is_told_once_with_its_line_and_what_would_be_right(case: str) -> None:
    text, told = MISTAKES[case]
    assert mistakes(text) == [told]


def test_mistakes_in_the_owners_frames_stand_beside_those_of_the_configuration(tmp_path: Path) -> None:
    (tmp_path / "arm.toml").write_text('[[frame]]\nid = 100\nname = "Arm"\nto = "operator"\nfields = []\n')
    text = SOUND.replace("[bus]", 'frames = "arm.toml"\nidle = 5\n[bus]')
    told = mistakes(text, str(tmp_path / "rover.toml"))
    assert told[0].startswith(f"{tmp_path}/rover.toml:4, vehicle.idle: 5 should be")
    assert told[1].startswith(f"{tmp_path}/arm.toml:2, frame[1].id: 100 is DriveCommand already")


def assembled(text: str):
    async def scene():
        return assemble(parse(text))

    return asyncio.run(scene())


def test_a_listening_link_of_a_rover_is_raw() -> None:
    gateway = assembled(SOUND + '[[output]]\nurl = "tcp-listen://127.0.0.1:5010"\n')
    links = [channel.send for channel in gateway.channels]
    assert all(isinstance(link, TcpListenLink) and link.raw for link in links)
    assert isinstance(gateway.vehicle, Rover)


def test_the_bit_rate_of_an_adapter_is_the_rovers_unless_it_says_another() -> None:
    for url, bitrate in (("slcan:///dev/ttyACM0", 500_000), ("slcan:///dev/ttyACM0?bitrate=125000", 125_000)):
        bus = assembled(SOUND.replace("socketcan://can0", url)).bus
        assert isinstance(bus, SlcanLink)
        assert bus.bitrate == bitrate


def test_the_bus_of_an_operator_is_the_uart_of_a_controller() -> None:
    gateway = assembled(OPERATOR.replace("[bus]", 'dialect = "hal062"\n[bus]'))
    assert isinstance(gateway.bus, UartBus)
    assert isinstance(gateway.bus.framer, Hal062)


def test_what_each_link_found_no_place_for_is_watched(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO")
    assembled(SOUND).health.report()
    watched = caplog.records[-1].__dict__["fields"].keys()
    assert {"bus", "Station 1", "rover", "Station 1 framing"} <= watched
