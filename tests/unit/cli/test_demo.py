import os
import signal
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import pytest

from tests.unit.cli.programs import start, timonel
from timonel.cli.demo import Demo, with_console
from timonel.cli.demo_boat import configure, how_to_connect, prepare
from timonel.errors import LinkError
from timonel.nmea0183.checksum import verify


def two_free_ports() -> int:
    """A port that is free, with the fourth above it."""
    while True:
        with socket.create_server(("127.0.0.1", 0)) as server:
            port = int(server.getsockname()[1])
            try:
                for taken in (port + 1, port + 2, port + 4):
                    socket.create_server(("127.0.0.1", taken)).close()
            except OSError:
                continue
            return port


@contextmanager
def a_demo(directory: Path, port: int) -> Iterator[IO[bytes]]:
    demo = start("demo", "--no-view", "--no-web", "--directory", str(directory), "--port", str(port))
    assert demo.stdout is not None
    try:
        yield demo.stdout
    finally:
        demo.send_signal(signal.SIGINT)
        _, told = demo.communicate(timeout=20)
    assert demo.returncode == 0, told.decode()


def test_the_demo_shows_a_moving_boat_that_obeys_its_stations_until_ctrl_c(tmp_path: Path) -> None:
    port = two_free_ports()
    with a_demo(tmp_path, port) as printed:
        while b"$IIHDT" not in printed.readline():
            pass
        with socket.create_connection(("127.0.0.1", port), 10) as listener:
            heard = listener.makefile("rb")
            assert all(isinstance(verify(heard.readline().rstrip()), bytes) for _ in range(20))
        bridge = os.open(tmp_path / "bridge", os.O_RDWR | os.O_NOCTTY)
        os.write(bridge, b"$PARP,TAKECMD,000.0,01*41\r\n$PARP,ENGAGE,000.0,01*1F\r\n")
        while b"STATUS,HEADING_HOLD" not in printed.readline():
            pass
        os.close(bridge)
    assert [path.name for path in tmp_path.iterdir()] == ["recordings"]
    verified = timonel("replay", "--verify", str(tmp_path / "recordings"))
    assert (verified.returncode, verified.stderr) == (0, b"")
    assert b"the same to the last byte" in verified.stdout


def test_what_to_connect_is_what_there_is() -> None:
    hints = "\n".join(how_to_connect(configure(Path("/run/timonel"), 20110)))
    for place in (
        "OpenCPN: TCP, 127.0.0.1:20110",
        "tcp://127.0.0.1:20114 --id 4",
        "serial:///run/timonel/bridge --id 1",
        "echo '$PARP,TAKECMD,000.0,01*41' > /run/timonel/bridge",
    ):
        assert place in hints


def test_the_hints_fit_a_terminal_of_80_columns() -> None:
    hints = how_to_connect(configure(Path("/run/user/1000/timonel"), 10110))
    assert [line for line in hints if len(line) > 78] == []


def test_a_second_demo_is_told_that_the_port_is_taken() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = str(server.getsockname()[1])
        run = timonel("demo", "--no-web", "--port", port)
    assert run.returncode == 1
    assert run.stderr.decode() == f"127.0.0.1:{port}: Address already in use; --port takes another one\n"


def test_a_directory_that_others_can_write_to_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "timonel").mkdir()
    (tmp_path / "timonel").chmod(0o777)
    monkeypatch.setitem(os.environ, "XDG_RUNTIME_DIR", str(tmp_path))
    from timonel.cli.demo import _own_directory
    from timonel.errors import LinkError

    with pytest.raises(LinkError, match="not ours alone"):
        _own_directory()
    (tmp_path / "timonel").chmod(0o700)
    assert _own_directory() == tmp_path / "timonel"


def prepared(tmp_path: Path) -> Demo:
    return prepare(tmp_path, 20110, 1)


def test_the_console_of_a_demo_is_for_this_computer_and_the_first_thing_to_try(tmp_path: Path) -> None:
    demo = with_console(prepared(tmp_path), None)
    web = demo.configuration.web
    assert web is not None
    assert (web.host, web.token) == ("127.0.0.1", None)
    assert demo.hints[0] == f"console  http://127.0.0.1:{web.port}/"


def test_a_console_takes_another_port_where_the_usual_one_is_taken_unless_one_was_asked_for(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = int(server.getsockname()[1])
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("timonel.cli.demo.WEB_PORT", port)
            web = with_console(prepared(tmp_path), None).configuration.web
        assert web is not None
        assert web.port != port
        with pytest.raises(LinkError, match=f"127.0.0.1:{port}: taken already; --web-port takes another one"):
            with_console(prepared(tmp_path), port)


def test_a_demo_without_the_extra_says_how_to_have_a_console(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("timonel.cli.demo.web_installed", lambda: False)
    demo = with_console(prepared(tmp_path), None)
    assert demo.configuration.web is None
    assert demo.hints[0].startswith("console  pip install timonel[web]")
