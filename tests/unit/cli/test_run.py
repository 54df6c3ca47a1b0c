import json
import os
import signal
import socket
import time
from pathlib import Path

from tests.unit.cli.programs import start, timonel


def configuration(directory: Path, more: str = "") -> str:
    path = directory / "boat.toml"
    path.write_text(
        '[vehicle]\nkind = "boat"\n[bus]\nurl = "loop://a"\n'
        f'[[station]]\nid = 1\nurl = "pty://{directory}/bridge"\n{more}'
    )
    return str(path)


def terminal(directory: Path) -> int:
    """The bridge's end of its port, as soon as the gateway has made it."""
    while not (directory / "bridge").exists():
        time.sleep(0.01)
    return os.open(directory / "bridge", os.O_RDWR | os.O_NOCTTY)


def heard_until(fd: int, word: bytes) -> bytes:
    heard = b""
    while word not in heard:
        heard += os.read(fd, 4096)
    return heard


def test_a_station_speaks_and_hears_and_sigterm_ends_it_within_a_second(tmp_path: Path) -> None:
    running = start("run", configuration(tmp_path))
    bridge = terminal(tmp_path)
    os.write(bridge, b"$PARP,TAKECMD,000.0,01*41\r\n")
    assert b"$PARP,CMDTRANSFER,00,01*7F\r\n" in heard_until(bridge, b"STATUS,STANDBY,000.0,,,01*")
    began = time.monotonic()
    running.send_signal(signal.SIGTERM)
    _, log = running.communicate(timeout=10)
    assert time.monotonic() - began < 1.0
    assert running.returncode == 0
    os.close(bridge)
    assert not (tmp_path / "bridge").is_symlink()
    lines = [json.loads(line) for line in log.splitlines()]
    assert {"event": "Transferred", "previous": 0, "commander": 1}.items() <= next(
        line for line in lines if line.get("event") == "Transferred"
    ).items()
    assert lines[-1]["text"] == "stopped"


def test_a_link_that_cannot_be_reached_keeps_nobody_waiting(tmp_path: Path) -> None:
    running = start("run", configuration(tmp_path, '[[output]]\nurl = "tcp://127.0.0.1:1"\n'))
    bridge = terminal(tmp_path)
    assert b"STATUS" in heard_until(bridge, b"STATUS")
    running.send_signal(signal.SIGINT)
    running.communicate(timeout=10)
    assert running.returncode == 0
    os.close(bridge)


def test_a_configuration_with_mistakes_is_not_run(tmp_path: Path) -> None:
    path = configuration(tmp_path, '[[output]]\nurl = "tcp//127.0.0.1"\n')
    run = timonel("run", path)
    assert run.returncode == 2
    assert run.stderr.decode().startswith(f"{path}:9, output[1].url: ")


def test_a_console_whose_port_is_taken_is_an_error_at_once(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        place = f"127.0.0.1:{server.getsockname()[1]}"
        run = timonel("run", configuration(tmp_path, f'[web]\nlisten = "{place}"\n'))
    assert run.returncode == 1
    assert run.stderr.decode().endswith(
        f"console: {place}: Address already in use; listen in [web] takes another one\n"
    )
