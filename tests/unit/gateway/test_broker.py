"""The table `[mqtt]`."""

from pathlib import Path

import pytest

from timonel.errors import ConfigError
from timonel.gateway import broker
from timonel.gateway.broker import Mqtt, Place, plain
from timonel.gateway.configuration import Configuration, parse
from timonel.vehicles.boat.settings import Port

BOAT = '[vehicle]\nkind = "boat"\nname = "Sea Cloud II"\n[bus]\nurl = "socketcan://can0"\n'
STATION = '[[station]]\nid = 3\nname = "Flybridge"\nurl = "pty:///run/fly"\n'
HERE = 'url = "mqtt://127.0.0.1"'


def parsed(table: str, rest: str = "", file: str = "/etc/boat.toml") -> Configuration:
    return parse(f"{BOAT}[mqtt]\n{table}\n{rest}", file)


def mistakes(table: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        parsed(table)
    return str(caught.value).splitlines()


def test_there_is_no_broker_unless_it_is_asked_for() -> None:
    assert parse(BOAT + STATION).mqtt is None
    assert parsed("enabled = false", STATION).mqtt is None
    assert parse(BOAT + STATION).broker_port is None


def test_a_url_is_enough() -> None:
    place = Place("127.0.0.1", 1883, False)
    assert parsed(HERE).mqtt == Mqtt(place, "timonel/sea_cloud_ii", 1.0, None, "homeassistant", None)


def test_everything_can_be_said(tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("correct horse\nand more\n")
    table = """url = "mqtts://broker.example"
user = "boat"
password_file = "secret"
authorities = "ca.pem"
base = "fleet/alisea"
interval = 0.5
discovery = "ha"
station = 3"""
    told = parsed(table, STATION, str(tmp_path / "boat.toml"))
    place = Place("broker.example", 8883, True, "boat", "correct horse")
    assert told.mqtt == Mqtt(place, "fleet/alisea", 0.5, str(tmp_path / "ca.pem"), "ha", 3)


def test_user_and_password_may_stand_in_the_url() -> None:
    told = parsed('url = "mqtt://boat:a%40b@broker.example:1884"').mqtt
    assert told is not None
    assert told.place == Place("broker.example", 1884, False, "boat", "a@b")


def test_discovery_can_be_left_off() -> None:
    told = parsed(f"{HERE}\ndiscovery = false").mqtt
    assert told is not None
    assert told.discovery is None


def test_the_broker_is_one_more_port_of_the_station_that_it_is_paired_with() -> None:
    assert parsed(f"{HERE}\nstation = 3", STATION).ports == [
        Port("Flybridge", 3),
        Port("Flybridge MQTT", 3, console=True),
    ]
    assert parsed(HERE, STATION).ports == [Port("Flybridge", 3)]


def test_the_console_and_the_broker_are_two_ports_of_one_station() -> None:
    told = parsed(f"{HERE}\nstation = 3", "[web]\nstations = [3]\n")
    assert [port.name for port in told.ports] == ["Station 3 web", "Station 3 MQTT"]
    assert [port.name for port in told.consoles] == ["Station 3 web"]


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ("", "/etc/boat.toml:6, mqtt.url: missing; where the broker is, like"),
        ('url = "http://127.0.0.1"', '/etc/boat.toml:7, mqtt.url: should be like "mqtt://127.0.0.1:1883"'),
        ('url = "mqtt://127.0.0.1:port"', "/etc/boat.toml:7, mqtt.url: should be like"),
        ('url = "mqtt://127.0.0.1:99999"', "/etc/boat.toml:7, mqtt.url: should be like"),
        ('url = "mqtt://127.0.0.1/topic"', "/etc/boat.toml:7, mqtt.url: should be like"),
        (f'{HERE}\nbase = "boat/#"', '/etc/boat.toml:8, mqtt.base: "boat/#" should be a topic'),
        (f'{HERE}\nbase = "/boat"', '/etc/boat.toml:8, mqtt.base: "/boat" should be a topic'),
        (f'{HERE}\ndiscovery = "home+"', "/etc/boat.toml:8, mqtt.discovery: "),
        (f"{HERE}\ninterval = 0", "/etc/boat.toml:8, mqtt.interval: "),
        (f"{HERE}\nstation = 5", "/etc/boat.toml:8, mqtt.station: "),
        (f'{HERE}\npassword_file = "/nowhere"', "/etc/boat.toml:8, mqtt.password_file: /nowhere: No such file"),
        (f'{HERE}\npasword_file = "x"', "unknown key (did you mean"),
    ],
)
def test_what_is_wrong_is_told_with_what_would_be_right(table: str, expected: str) -> None:
    (told,) = mistakes(table)
    assert expected in told


def test_a_password_is_never_told() -> None:
    (told,) = mistakes('url = "mqtt://boat:secret@broker.example/topic"')
    assert "secret" not in told


def test_a_password_file_that_is_no_text_is_told(tmp_path: Path) -> None:
    (tmp_path / "secret").write_bytes(b"\xff\xfe")
    with pytest.raises(ConfigError, match=r"mqtt.password_file: .*: not text"):
        parsed(f'{HERE}\npassword_file = "secret"', file=str(tmp_path / "boat.toml"))


def test_a_broker_that_others_reach_must_know_its_users_before_it_may_command() -> None:
    elsewhere = 'url = "mqtt://10.0.0.2"\nstation = 3'
    (told,) = mistakes(elsewhere)
    assert "mqtt.station: whoever reaches 10.0.0.2 could command as this station" in told
    assert parsed(f'{elsewhere}\nuser = "boat"').mqtt is not None


def test_without_aiomqtt_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(broker, "mqtt_installed", lambda: False)
    (told,) = mistakes(HERE)
    assert told.endswith("mqtt: needs aiomqtt: pip install timonel[mqtt]")


@pytest.mark.parametrize(
    ("name", "level"), [("Alisea", "alisea"), ("Sea Cloud II", "sea_cloud_ii"), ("a/+#b", "a_b"), ("ź", "vehicle")]
)
def test_a_name_becomes_a_level_of_a_topic(name: str, level: str) -> None:
    assert plain(name) == level
