"""The key that seals cookies."""

import logging
from pathlib import Path

import pytest

from timonel.gateway.places import state_directory
from timonel.web import keys


@pytest.fixture(autouse=True)
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.delenv("STATE_DIRECTORY", raising=False)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    return tmp_path / "timonel"


def test_the_key_is_the_same_after_a_restart_and_for_us_alone(state: Path) -> None:
    key = keys.kept_key()
    assert len(key) == 32
    assert keys.kept_key() == key
    assert (state / "console.key").stat().st_mode & 0o777 == 0o600
    assert state.stat().st_mode & 0o777 == 0o700


def test_systemd_says_where_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STATE_DIRECTORY", f"{tmp_path / 'var'}:/other")
    keys.kept_key()
    assert (tmp_path / "var" / "console.key").exists()


def test_without_a_place_there_is_one_in_the_home(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("XDG_STATE_HOME")
    assert state_directory() == Path.home() / ".local" / "state" / "timonel"


def test_where_it_cannot_be_kept_it_is_a_new_one_and_people_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path / "file"))
    with caplog.at_level(logging.WARNING):
        assert keys.kept_key() != keys.kept_key()
    assert "consoles must be paired anew after a restart" in caplog.text


def test_what_is_no_key_is_not_used(state: Path, caplog: pytest.LogCaptureFixture) -> None:
    state.mkdir()
    (state / "console.key").write_bytes(b"short")
    assert len(keys.kept_key()) == 32
    assert "not a key of ours" in caplog.text
    assert (state / "console.key").read_bytes() == b"short"
