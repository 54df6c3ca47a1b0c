"""The table `[web]`."""

from pathlib import Path

import pytest

from timonel.errors import ConfigError
from timonel.gateway import web_settings
from timonel.gateway.configuration import Configuration, parse
from timonel.gateway.web_settings import Web
from timonel.vehicles.boat.settings import Port

BOAT = '[vehicle]\nkind = "boat"\n[bus]\nurl = "socketcan://can0"\n'
STATION = '[[station]]\nid = 2\nname = "Cockpit"\nurl = "pty:///run/cockpit"\n'
TOKEN = "correct horse battery"


def parsed(table: str, rest: str = "") -> Configuration:
    return parse(f"{BOAT}[web]\n{table}\n{rest}", "/etc/boat.toml")


def mistakes(table: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        parsed(table)
    return str(caught.value).splitlines()


def test_there_is_no_console_unless_it_is_asked_for() -> None:
    assert parse(BOAT + STATION).web is None
    assert parse(BOAT + STATION).consoles == []
    assert parsed("enabled = false", STATION).web is None


def test_an_empty_table_is_a_console_for_this_computer_alone() -> None:
    assert parsed("").web == Web("127.0.0.1", 8080, None, stations=(1, 2, 3, 4))


def test_everything_can_be_said() -> None:
    table = f'''listen = "0.0.0.0:443"
token = "{TOKEN}"
certificate = "boat.pem"
key = "/etc/ssl/boat.key"
hosts = ["boat.local"]
stations = [3, 1, 3]'''
    expected = Web("0.0.0.0", 443, TOKEN, "/etc/boat.pem", "/etc/ssl/boat.key", ("boat.local",), (1, 3))
    assert parsed(table).web == expected


def test_a_console_is_one_more_port_of_each_station_that_it_may_be() -> None:
    told = parsed("stations = [2, 4]", STATION)
    assert told.names == {1: "Station 1", 2: "Cockpit", 3: "Station 3", 4: "Station 4"}
    assert told.ports == [
        Port("Cockpit", 2), Port("Cockpit web", 2, console=True), Port("Station 4 web", 4, console=True),
    ]  # fmt: skip


def test_outside_this_computer_a_token_is_needed_and_one_is_offered() -> None:
    (told,) = mistakes('listen = "0.0.0.0:8080"')
    assert told.startswith("/etc/boat.toml:5, web.token: missing; 0.0.0.0 is not this computer alone: say who may see")
    offered = told.rpartition(", like ")[2]
    assert parsed(f'listen = "0.0.0.0:8080"\n{offered}').web is not None
    assert mistakes('listen = "[::]:8080"')[0].rpartition(", like ")[2] != offered


MISTAKES = {
    'listen = "8080"': '/etc/boat.toml:6, web.listen: "8080" should be a host and a port, like',
    'token = "short"': "/etc/boat.toml:6, web.token: ",
    'certificate = "boat.pem"': "/etc/boat.toml:5, web: certificate and key go together",
    "stations = [5]": "/etc/boat.toml:6, web.stations",
    "port = 8080": "/etc/boat.toml:6, web.port: unknown key",
}


@pytest.mark.parametrize("table", MISTAKES)
def test_a_mistake_is_told(table: str) -> None:
    (told,) = mistakes(table)
    assert told.startswith(MISTAKES[table])


def test_what_is_not_installed_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(web_settings, "web_installed", lambda: False)
    assert mistakes("") == ["/etc/boat.toml:5, web: needs starlette, uvicorn and websockets: pip install timonel[web]"]


def test_the_page_of_the_console_names_every_key() -> None:
    page = (Path(__file__).parents[3] / "docs" / "console.md").read_text()
    keys = web_settings.KEYS
    assert [key for key in keys if f"`{key}`" not in page] == []


def test_tiles_are_a_directory_beside_the_configuration(tmp_path: Path) -> None:
    (tmp_path / "charts").mkdir()
    told = parse(f'{BOAT}[web]\ntiles = "charts"\n', str(tmp_path / "boat.toml"))
    assert told.web is not None
    assert told.web.tiles == str(tmp_path / "charts")
    (mistake,) = mistakes('tiles = "nowhere"')
    assert mistake == "/etc/boat.toml:6, web.tiles: /etc/nowhere is no directory of map tiles, z/x/y.png"
