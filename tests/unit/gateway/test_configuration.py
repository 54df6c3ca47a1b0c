from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from timonel import __version__
from timonel.errors import ConfigError
from timonel.gateway import recording_settings
from timonel.gateway.configuration import KINDS, load, parse
from timonel.gateway.identity import unique_number
from timonel.gateway.link_settings import Output, Station
from timonel.gateway.recording_settings import Recording
from timonel.nmea2000.node import NodeSettings
from timonel.vehicles.boat.alert_settings import AlertSettings
from timonel.vehicles.boat.conversion import RATES
from timonel.vehicles.boat.settings import BoatSettings, Port

DOCS = Path(__file__).parents[3] / "docs"

VEHICLE = '[vehicle]\nkind = "boat"\n'
BUS = '[bus]\nurl = "socketcan://can0"\n'
STATION = '[[station]]\nid = 1\nurl = "pty:///tmp/bridge"\n'
SOUND = VEHICLE + BUS + STATION


def mistakes(text: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        parse(text)
    return str(caught.value).splitlines()


def test_what_cannot_be_printed_does_not_break_a_mistake_in_two() -> None:
    text = SOUND.replace("boat", r"bo\nat\u001b[2J", 1)
    assert mistakes(text) == [
        r'boat.toml:2, vehicle.kind: "bo\nat\x1b[2J" should be "boat" or "rover" (did you mean "boat"?)'
    ]


def test_the_example_of_the_documentation_is_sound() -> None:
    configuration = load(DOCS / "boat.toml")
    assert configuration.stations[0] == Station(Port("Bridge", 1), "serial:///dev/ttyUSB4", "serial:///dev/ttyUSB0")
    assert configuration.outputs == (Output("Chart plotter", "tcp-listen://127.0.0.1:10110"),)
    assert configuration.vehicle.rates == {"HDT": 10.0, "MTW": 0.5, "XDR": 0.0}


def test_the_page_about_the_configuration_names_every_key_and_every_sentence() -> None:
    page = (DOCS / "configuration.md").read_text()
    keys = {key for table, keys in KINDS["boat"].keys.items() if table != "sentences" for key in keys}
    assert [key for key in sorted(keys | RATES.keys()) if f"`{key}`" not in page] == []


def test_what_is_not_said_has_the_defaults_of_the_specification() -> None:
    configuration = parse(SOUND)
    node = NodeSettings(unique_number=unique_number("boat"), software=__version__)
    assert configuration.vehicle == BoatSettings(node=node, alerts=AlertSettings())
    assert (configuration.flush, configuration.log, configuration.outputs) == (0.0, "info", ())


def test_keys_reach_the_boats_settings() -> None:
    text = '[vehicle]\nkind = "boat"\ndialect = "ar-1.0"\nmax_age = 2\n[bus]\nurl = "loop://a"\naddress = 7\n'
    settings = parse(text + STATION).vehicle
    assert (settings.dialect, settings.max_age, settings.address) == ("ar-1.0", 2.0, 7)


def test_the_keys_of_the_bus_say_what_device_the_gateway_is() -> None:
    keys = 'class = 40\nfunction = 140\ninstance = 3\nmanufacturer = 2046\nunique_number = 7\ninstallation1 = "port"\n'
    settings = parse('[vehicle]\nkind = "boat"\n[bus]\nurl = "loop://a"\n' + keys + STATION).vehicle
    assert settings.node == NodeSettings(
        unique_number=7,
        manufacturer=2046,
        device_class=40,
        device_function=140,
        device_instance=3,
        software=__version__,
        installation1="port",
    )


@pytest.mark.parametrize("bus", ['url = "loop://a"\nnode = false\n', 'url = "file:///tmp/a.log"\nnode = true\n'])
def test_a_gateway_that_need_not_or_cannot_speak_is_no_device(bus: str) -> None:
    assert parse('[vehicle]\nkind = "boat"\n[bus]\n' + bus + STATION).vehicle.node is None


def test_a_sentence_is_switched_or_has_a_rate() -> None:
    rates = parse(SOUND + "[sentences]\nHDT = true\nROT = 5\nXDR = false\nMTW = 0\n").vehicle.rates
    assert rates == {"HDT": RATES["HDT"], "ROT": 5.0, "XDR": 0.0, "MTW": 0.0}


def test_a_flush_time_is_in_seconds_for_the_program() -> None:
    assert parse(SOUND + '[gateway]\nflush = "2ms"').flush == 0.002


def test_a_link_that_does_both_is_one_link() -> None:
    assert parse(SOUND).stations == (Station(Port("Station 1", 1), "pty:///tmp/bridge", "pty:///tmp/bridge"),)


def test_a_shared_wire_is_bound_to_no_station() -> None:
    text = VEHICLE + BUS + '[[station]]\nname = "UART2"\nshared = true\nurl = "serial:///dev/ttyS1"\n'
    assert parse(text).stations[0].port == Port("UART2", None)


def test_a_station_may_hear_nothing() -> None:
    text = VEHICLE + BUS + '[[station]]\nid = 4\nin = "udp://:2000"\n'
    assert parse(text).stations[0] == Station(Port("Station 4", 4), "udp://:2000", None)


def test_a_table_is_enough_to_be_recorded() -> None:
    assert parse(SOUND).recording is None
    assert parse(SOUND + "[recording]\n").recording == Recording("recordings")
    assert parse(SOUND + "[recording]\nenabled = false\n").recording is None


def test_what_is_recorded_where_and_how_much_is_up_to_the_owner() -> None:
    table = 'directory = "log"\nsegment_size = "1.5 MB"\nsegment_age = "90 min"\nbudget = "1 GB"\ndecoded = true\n'
    recording = parse(SOUND + "[recording]\n" + table, "/etc/timonel/boat.toml").recording
    assert recording == Recording("/etc/timonel/log", 1_500_000, 5400.0, 10**9, True)


def test_a_recorder_that_is_not_installed_is_a_mistake(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording_settings, "recorder_installed", lambda: False)
    assert mistakes(SOUND + "[recording]\n") == [
        "boat.toml:8, recording: needs mcap and zstandard: pip install timonel[recording]"
    ]
    assert parse(SOUND + "[recording]\nenabled = false\n").recording is None


def test_the_text_of_the_file_is_kept() -> None:
    assert parse(SOUND).text == SOUND


def test_the_alerts_of_a_boat_are_told_to_all_unless_its_owner_wants_it_otherwise() -> None:
    assert parse(SOUND).vehicle.alerts == AlertSettings()
    table = (
        '[alerts]\nforeign = false\ntell_bus = false\nsentences = "both"\nalarm_repeat = 0\nwarning_escalation = 300\n'
    )
    wanted = AlertSettings(foreign=False, tell_bus=False, sentences="both", alarm_repeat=0, warning_escalation=300)
    assert parse(SOUND + table).vehicle.alerts == wanted


MISTAKES = {
    "a sentence for alerts": (
        SOUND + '[alerts]\nsentences = "alc"\n',
        'boat.toml:9, alerts.sentences: "alc" should be "alf" or "alr" or "both" (did you mean "alr"?)',
    ),
    "a wait that is none": (
        SOUND + "[alerts]\nwarning_repeat = -1\n",
        "boat.toml:9, alerts.warning_repeat: -1 should be a number 0..3600",
    ),
    "a misspelt key of the alerts": (
        SOUND + "[alerts]\nforein = true\n",
        'boat.toml:9, alerts.forein: unknown key (did you mean "foreign"?)',
    ),
    "a size": (
        SOUND + '[recording]\nbudget = "2 Gb"\n',
        'boat.toml:9, recording.budget: "2 Gb" should be a size like "64 MB" (kB, MB, GB, TB)',
    ),
    "a time": (
        SOUND + '[recording]\nsegment_age = "0 h"\n',
        'boat.toml:9, recording.segment_age: "0 h" should be a time like "1 h" (s, min, h, d)',
    ),
    "a size that is a number": (
        SOUND + "[recording]\nsegment_size = 64\n",
        "boat.toml:9, recording.segment_size: 64 should be text",
    ),
    "a budget for less than two segments": (
        SOUND + '[recording]\nbudget = "100 MB"\n',
        "boat.toml:9, recording.budget: is less than two segments of segment_size",
    ),
    "a misspelt key of the recording": (
        SOUND + '[recording]\ndirektory = "a"\n',
        'boat.toml:9, recording.direktory: unknown key (did you mean "directory"?)',
    ),
    "an unknown scheme": (
        SOUND.replace("socketcan", "sockcan"),
        'boat.toml:4, bus.url: unknown scheme "sockcan" (did you mean "socketcan"?)',
    ),
    "a port where a bus should be": (
        SOUND.replace("socketcan://can0", "tcp://a:1"),
        "boat.toml:4, bus.url: tcp://a:1: not the URL of a bus "
        "(a bus is one of socketcan, slcan, loop, file, or text as ydraw+tcp)",
    ),
    "a parameter of a URL": (
        SOUND.replace("/tmp/bridge", "/tmp/bridge?mode=9"),
        'boat.toml:7, station[1].url: pty:///tmp/bridge?mode=9: mode: "9" is not a file mode like 660',
    ),
    "an unknown table": (
        SOUND + "[sentence]\n",
        'boat.toml:8, sentence: unknown table (did you mean "sentences"?)',
    ),
    "a key without a table": ("speed = 3\n" + SOUND, "boat.toml:1, speed: unknown table"),
    "a misspelt key": (
        SOUND.replace("[bus]", "[bus]\nadress = 3"),
        'boat.toml:4, bus.adress: unknown key (did you mean "address"?)',
    ),
    "a key in the wrong table": (
        SOUND.replace("[bus]", "address = 3\n[bus]"),
        "boat.toml:3, vehicle.address: unknown key (it belongs in [bus])",
    ),
    "a misspelt value": (
        SOUND.replace("[bus]", 'dialect = "standart"\n[bus]'),
        'boat.toml:3, vehicle.dialect: "standart" should be "ar-1.0" or "standard" (did you mean "standard"?)',
    ),
    "a kind of vehicle": (
        SOUND.replace('"boat"', '"submarine"'),
        'boat.toml:2, vehicle.kind: "submarine" should be "boat" or "rover"',
    ),
    "text where a number should be": (
        SOUND.replace("[bus]", 'max_age = "3 s"\n[bus]'),
        'boat.toml:3, vehicle.max_age: "3 s" should be a number above 0, at most 3600',
    ),
    "no number at all": (
        SOUND.replace("[bus]", "max_age = nan\n[bus]"),
        "boat.toml:3, vehicle.max_age: nan should be a number above 0, at most 3600",
    ),
    "a whole number out of range": (
        SOUND.replace("[bus]", "[bus]\naddress = 252"),
        "boat.toml:4, bus.address: 252 should be a whole number 0..251",
    ),
    "a number where a switch should be": (
        SOUND.replace("id = 1", "id = 1\nshared = 1"),
        "boat.toml:7, station[1].shared: 1 should be true or false",
    ),
    "a list where text should be": (
        SOUND.replace("[bus]", "name = [1]\n[bus]"),
        "boat.toml:3, vehicle.name: a list should be text",
    ),
    "a table where a number should be": (
        SOUND + "[sentences.HDT]\nrate = 3\n",
        "boat.toml:8, sentences.HDT: a table should be true or false or a number 0..1000",
    ),
    "a sentence nobody knows": (
        SOUND + "[sentences]\nhdt = 3\n",
        'boat.toml:9, sentences.hdt: unknown key (did you mean "HDT"?)',
    ),
    "a station that does not exist": (
        SOUND.replace("id = 1", "id = 5"),
        "boat.toml:6, station[1].id: 5 should be a whole number 1..4",
    ),
    "a station without a number": (
        SOUND.replace("id = 1", ""),
        "boat.toml:5, station[1].id: missing; 1..4, or shared = true for a wire that several stations share",
    ),
    "a station twice": (
        SOUND + STATION.replace("bridge", "cockpit"),
        "boat.toml:9, station[2].id: 1 is station[1].id already",
    ),
    "a name twice": (
        SOUND + '[[station]]\nid = 2\nname = "Station 1"\nurl = "pty:///tmp/b"\n',
        'boat.toml:10, station[2].name: "Station 1" is station[1].id already',
    ),
    "a station nobody can speak from": (
        VEHICLE + BUS + '[[station]]\nid = 1\nout = "pty:///tmp/b"\n',
        "boat.toml:5, station[1].in: missing; what the station says, or url where one link does both",
    ),
    "a station with too many links": (
        SOUND + 'in = "pty:///tmp/b"\n',
        "boat.toml:7, station[1].url: one link does both; leave out in and out",
    ),
    "a device twice": (
        VEHICLE + BUS + '[[station]]\nid = 1\nin = "serial:///dev/ttyS9"\nout = "serial:///dev/ttyS9?baud=9600"\n',
        'boat.toml:8, station[1].out: "serial:///dev/ttyS9?baud=9600" is station[1].in already',
    ),
    "a device of the bus": (
        SOUND.replace("socketcan://can0", "slcan:///dev/ttyS9").replace("pty:///tmp/bridge", "serial:///dev/ttyS9"),
        'boat.toml:7, station[1].url: "serial:///dev/ttyS9" is bus.url already',
    ),
    "a network port twice": (
        SOUND + 2 * '[[output]]\nurl = "tcp-listen://0.0.0.0:10110"\n',
        'boat.toml:11, output[2].url: "tcp-listen://0.0.0.0:10110" is output[1].url already',
    ),
    "an output without a place": (
        SOUND + "[[output]]\n",
        "boat.toml:8, output[1].url: missing; where the listeners are, like tcp-listen://127.0.0.1:10110",
    ),
    "an output that is a bus": (
        SOUND + '[[output]]\nurl = "loop://a"\n',
        "boat.toml:9, output[1].url: loop://a: not the URL of a port "
        "(a port is one of serial, pty, tcp, tcp-listen, udp, iec450)",
    ),
    "single brackets": (
        VEHICLE + BUS + "[station]\nid = 1\n",
        "boat.toml:5, station: should stand in double brackets: [[station]]",
    ),
    "double brackets": (
        BUS + STATION + '[[vehicle]]\nkind = "boat"\n',
        "boat.toml:6, vehicle: a list should be a table: [vehicle]",
    ),
    "nobody who hears": (
        VEHICLE + BUS,
        "boat.toml, station: missing; without a [[station]] or an [[output]] nobody hears anything",
    ),
    "no bus": (VEHICLE + STATION, "boat.toml, bus.url: missing; a bus is needed, like socketcan://can0"),
    "no vehicle": (BUS + STATION, 'boat.toml, vehicle.kind: missing; say which: "boat" or "rover"'),
    "a mistake of TOML": (VEHICLE + "url = \n", "boat.toml:3, column 7: invalid value"),
    "a file that is cut short": (VEHICLE + 'url = "', "boat.toml:3: unterminated string"),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_a_mistake_is_told_with_its_line_its_key_and_what_would_be_right(case: str) -> None:
    text, told = MISTAKES[case]
    assert told in mistakes(text)


ALONE = MISTAKES.keys() - {"double brackets", "single brackets"}


@pytest.mark.parametrize("case", sorted(ALONE))
def test_one_mistake_is_told_once(case: str) -> None:
    text, told = MISTAKES[case]
    assert mistakes(text) == [told]


def test_all_mistakes_are_told_at_once_in_the_order_of_the_file() -> None:
    text = '[vehicle]\nkind = "bot"\n[bus]\nurl = "can0"\n[[station]]\nid = 9\n[[output]]\nurl = "x://y"\n'
    assert [line.split(":")[1].split(",")[0] for line in mistakes(text)] == ["2", "4", "5", "6", "8"]


def test_a_mistake_in_an_inline_table_has_the_line_of_the_table() -> None:
    text = VEHICLE + 'bus = "x"\n' + STATION
    assert mistakes("bus = { url = 3 }\n" + VEHICLE + STATION) == ["boat.toml:1, bus.url: 3 should be text"]
    assert "boat.toml:3, vehicle.bus: unknown key" in mistakes(text)


def test_a_dotted_key_is_found() -> None:
    assert mistakes("bus.url = 3\n" + VEHICLE + STATION) == ["boat.toml:1, bus.url: 3 should be text"]


def test_the_same_listening_port_0_may_stand_twice() -> None:
    text = SOUND + 2 * '[[output]]\nurl = "tcp-listen://127.0.0.1:0"\n'
    assert len(parse(text).outputs) == 2


def test_a_device_is_the_same_under_another_name() -> None:
    with TemporaryDirectory() as folder:  # a short name: long values are cut in messages
        (Path(folder) / "by-id").symlink_to("/dev/ttyS9")
        text = VEHICLE + BUS + f'[[station]]\nid = 1\nin = "serial:///dev/ttyS9"\nout = "serial://{folder}/by-id"\n'
        assert mistakes(text) == [f'boat.toml:8, station[1].out: "serial://{folder}/by-id" is station[1].in already']


def test_a_file_that_is_not_there_is_told() -> None:
    with pytest.raises(ConfigError, match=r"nowhere/boat\.toml: No such file or directory"):
        load("nowhere/boat.toml")


def test_a_file_that_is_no_text_is_told(tmp_path: Path) -> None:
    path = tmp_path / "boat.toml"
    path.write_bytes(b"[bus]\n\xff")
    with pytest.raises(ConfigError, match=r"boat.toml: not UTF-8 text \(byte 6\)"):
        load(path)
