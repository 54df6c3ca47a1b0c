from pathlib import Path

import pytest

from timonel.gateway import identity
from timonel.gateway.identity import unique_number


def test_the_number_is_this_computers_and_this_vehicles(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(identity, "MACHINE_ID", tmp_path / "machine-id")
    (tmp_path / "machine-id").write_text("0123456789abcdef\n")
    number = unique_number("Alisea")
    assert 0 <= number < 1 << 21
    assert unique_number("Alisea") == number
    assert unique_number("Alba") != number
    (tmp_path / "machine-id").write_text("another\n")
    assert unique_number("Alisea") != number


def test_a_computer_without_an_identity_is_told_by_its_network_card(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(identity, "MACHINE_ID", tmp_path / "nothing")
    monkeypatch.setattr(identity.uuid, "getnode", lambda: 1)
    one = unique_number("Alisea")
    monkeypatch.setattr(identity.uuid, "getnode", lambda: 2)
    assert unique_number("Alisea") != one
