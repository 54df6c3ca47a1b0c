"""The table `[signalk]` is understood, or every mistake in it is told."""

import re
from pathlib import Path

import pytest

from timonel.errors import ConfigError
from timonel.gateway import signalk_settings
from timonel.gateway.configuration import parse
from timonel.gateway.signalk_settings import SignalK, own_urn

BOAT = '[vehicle]\nkind = "boat"\n[bus]\nurl = "loop://x"\n[[output]]\nurl = "tcp-listen://127.0.0.1:10110"\n'
UUID = "b7590868-1d62-47d9-989c-32321b349fb9"


def understood(text: str) -> SignalK | None:
    return parse(BOAT + text).signalk


def test_without_the_table_nobody_is_told() -> None:
    assert understood("") is None


@pytest.mark.parametrize(
    ("text", "settings"),
    [
        ("[signalk]", SignalK()),
        ('[signalk]\ntcp = "tcp-listen://127.0.0.1:8375"', SignalK(tcp="tcp-listen://127.0.0.1:8375")),
        ('[signalk]\npush = "ws://boat:3000"', SignalK(push="ws://boat:3000/signalk/v1/stream")),
        ('[signalk]\npush = "wss://boat/x/stream"\ntoken = "t"', SignalK(push="wss://boat/x/stream", token="t")),
        ('[signalk]\nmmsi = "224123456"', SignalK(urn="urn:mrn:imo:mmsi:224123456")),
        (f'[signalk]\nuuid = "{UUID}"\nstation = 2', SignalK(urn=f"urn:mrn:signalk:uuid:{UUID}", station=2)),
    ],
)
def test_the_table_says_where_deltas_go_and_who_the_boat_is(text: str, settings: SignalK) -> None:
    assert understood(text) == settings


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('tcp = "udp://127.0.0.1:8375"', r'signalk\.tcp: .*should be like "tcp-listen://127\.0\.0\.1:8375"'),
        ('tcp = "tcp-listen://127.0.0.1"', r"signalk\.tcp: .*a port is missing"),
        ('tcp = "tcp-listen://127.0.0.1:10110"', r"signalk\.tcp: .*is output\[1\]\.url already"),
        ('push = "http://boat:3000"', r'signalk\.push: "http://boat:3000" should be like "ws://127\.0\.0\.1:3000"'),
        ('push = "ws://boat:x"', r"signalk\.push: .*should be like"),
        ('push = "ws://user:word@boat:3000"', r"signalk\.push: .*should be like"),
        ('token = "t"', r"signalk\.token: is for push"),
        ("station = 5", r"signalk\.station"),
        ('mmsi = "123"', r"signalk\.mmsi"),
        ('uuid = "x"', r'signalk\.uuid: "x" is no UUID of version 4, like "'),
        ('uuid = "6ba7b810-9dad-11d1-80b4-00c04fd430c8"', r"signalk\.uuid: .*version 4"),
        (f'uuid = "{UUID}"\nmmsi = "224123456"', r"signalk\.uuid: the boat has an mmsi already"),
        ("tpc = 1", r'signalk\.tpc: unknown key \(did you mean "tcp"\?\)'),
    ],
)
def test_a_mistake_names_its_key_and_what_would_be_right(text: str, told: str) -> None:
    with pytest.raises(ConfigError, match=told):
        parse(f"{BOAT}[signalk]\n{text}")


def test_push_needs_its_library(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(signalk_settings, "web_installed", lambda: False)
    with pytest.raises(ConfigError, match=re.escape("signalk.push: needs websockets: pip install timonel[web]")):
        understood('[signalk]\npush = "ws://boat:3000"')


def test_a_rover_has_no_signal_k() -> None:
    rover = '[vehicle]\nkind = "rover"\n[bus]\nurl = "loop://x"\n[[output]]\nurl = "tcp-listen://127.0.0.1:1"\n'
    with pytest.raises(ConfigError, match="signalk: unknown table"):
        parse(f"{rover}[signalk]\n")


def test_deltas_are_reason_enough_for_a_gateway() -> None:
    alone = BOAT.partition("[[output]]")[0] + '[signalk]\ntcp = "tcp-listen://127.0.0.1:8375"'
    assert parse(alone).outputs == ()


def test_a_boat_that_was_not_told_who_it_is_is_always_the_same_and_no_other(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    assert own_urn("Alba") == own_urn("Alba") != own_urn("Bora")
    names = {own_urn("Alba")}
    for machine in ("one", "other"):
        monkeypatch.setattr(signalk_settings, "MACHINE", tmp_path / machine)
        names.add(own_urn("Alba"))
        (tmp_path / machine).write_text(machine)
        names.add(own_urn("Alba"))
    assert len(names) == 4, "two computers of their own, this one, and one that has no name"
    pattern = r"urn:mrn:signalk:uuid:[0-9a-f]{8}-[0-9a-f]{4}-4[0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}"
    assert re.fullmatch(pattern, own_urn("Alba"))
