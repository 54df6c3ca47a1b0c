import socket
from pathlib import Path

import pytest

from timonel.gateway.notify import notify, watchdog_interval


def test_systemd_is_told_on_its_socket(tmp_path: Path) -> None:
    address = str(tmp_path / "notify")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(address)
        notify("READY=1", {"NOTIFY_SOCKET": address})
        assert manager.recv(100) == b"READY=1"


def test_systemd_is_told_on_an_abstract_socket() -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind("")  # the kernel names it
        address = manager.getsockname().decode()
        notify("WATCHDOG=1", {"NOTIFY_SOCKET": address.replace("\0", "@")})
        assert manager.recv(100) == b"WATCHDOG=1"


def test_a_manager_that_is_gone_troubles_nobody(tmp_path: Path) -> None:
    notify("READY=1", {"NOTIFY_SOCKET": str(tmp_path / "nobody")})
    notify("READY=1", {})


@pytest.mark.parametrize(("usec", "interval"), [("3000000", 1.5), ("0", None), ("", None), ("soon", None)])
def test_a_sign_of_life_comes_twice_in_the_time_that_systemd_allows(usec: str, interval: float | None) -> None:
    assert watchdog_interval({"WATCHDOG_USEC": usec}) == interval
    assert watchdog_interval({}) is None
