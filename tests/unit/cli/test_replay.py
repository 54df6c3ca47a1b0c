import asyncio
import os
import pty
import socket
import subprocess
import time
from itertools import pairwise
from pathlib import Path

import pytest

from tests.program import free_port
from tests.recordings import recording
from tests.unit.cli.programs import ENVIRONMENT, TIMONEL, start, timonel
from tests.voyage import BOAT, Voyage
from timonel.nmea0183.registry import parse
from timonel.nmea0183.sentences import RMC, Mode

LOG = "aldas_go-nmea-client/socketcan/testdata/candump_2021-05-25-1635_5s.log"


@pytest.fixture(scope="module")
def boat(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return Voyage(tmp_path_factory.mktemp("boat"), BOAT, seed=8).sail(30)


# Verify -----------------------------------------------------------------------------------------------


def test_a_recording_is_verified(boat: Path) -> None:
    run = timonel("replay", str(boat), "--verify")
    assert (run.returncode, run.stderr) == (0, b"")
    assert b": 30.0 s, " in run.stdout
    assert run.stdout.endswith(b"events: the same to the last byte\n")


def test_the_newest_recording_of_a_directory_is_verified(boat: Path) -> None:
    assert timonel("replay", str(boat.parent), "--verify").stdout == timonel("replay", str(boat), "--verify").stdout


def test_a_torn_recording_is_verified_as_far_as_it_goes(boat: Path, tmp_path: Path) -> None:
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(boat.read_bytes()[:-3000])
    run = timonel("replay", str(torn), "--verify")
    assert run.returncode == 0
    assert b"note: torn.mcap: the file is cut off" in run.stderr
    assert run.stdout.endswith(b"the same to the last byte, as far as it goes\n")


def test_a_difference_is_shown_with_its_time_and_both_sides(boat: Path, tmp_path: Path) -> None:
    """The settings of the machine say something else than what it was recorded with."""
    changed = tmp_path / "a.mcap"
    changed.write_bytes(boat.read_bytes().replace(b'"max_age":3.0', b'"max_age":0.1'))
    run = timonel("replay", str(changed), "--verify")
    assert run.returncode == 1
    assert b"the first difference, 2026-09-21 14:13:2" in run.stderr
    assert run.stderr.count(b"\n  recorded  '$") == run.stderr.count(b"\n  replayed  '$") == 1
    assert b"DIFFERENT" in run.stdout


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["no.mcap", "--verify"], b"no.mcap: No such file or directory\n"),
        ([str(recording(LOG)), "--verify"], b"not an MCAP file\n"),
        (["."], b"say --verify, or --to URL"),
        (["a", "--verify", "--to", "loop://a"], b"say --verify, or --to URL"),
        (["a", "--to", "sockcan://can0"], b'unknown scheme "sockcan" (did you mean "socketcan"?)\n'),
        (["a", "--to", "loop://a", "--speed", "fast"], b'--speed: "fast" is not a positive number or "max"\n'),
        (["a", "--to", "loop://a", "--from", "noon"], b'--from: "noon" should be a time like 12:30'),
        (["a", "--to", "loop://a"], b"a: No such file or directory\n"),
    ],
)
def test_what_cannot_be_replayed_is_told_in_a_line(arguments: list[str], told: bytes) -> None:
    run = timonel("replay", *arguments)
    assert run.returncode != 0
    assert told in run.stderr
    assert b"Traceback" not in run.stderr


def test_an_empty_directory_has_no_recording(tmp_path: Path) -> None:
    run = timonel("replay", "--verify", str(tmp_path))
    assert run.returncode == 1
    assert b"no recording (*.mcap) in this directory" in run.stderr


# Play -------------------------------------------------------------------------------------------------


def connected(port: int) -> socket.socket:
    """A listener, as soon as there is somebody to listen to."""
    for _ in range(500):
        try:
            return socket.create_connection(("127.0.0.1", port), 10)
        except ConnectionRefusedError:
            time.sleep(0.02)
    raise AssertionError("nobody listens")


def test_a_recording_is_played_to_listeners_marked_and_obeying_nobody(boat: Path) -> None:
    port = free_port()
    player = start("replay", str(boat), "--to", f"tcp-listen://127.0.0.1:{port}", "--speed", "max")
    with connected(port) as listener:
        listener.sendall(b"$PARP,TAKECMD,000.0,01*41\r\n")
        with listener.makefile("rb") as lines:
            heard = lines.read().splitlines()
    _, told = player.communicate(timeout=20)
    assert player.returncode == 0, told
    fixes = [sentence for line in heard if isinstance(sentence := parse(line), RMC)]
    assert len(fixes) > 20
    assert {fix.mode for fix in fixes if fix.latitude_deg is not None} == {Mode.SIMULATOR}
    assert b"%d lines played" % len(heard) in told
    assert b"27 bytes or frames came in and were not obeyed" in told


def test_a_log_is_converted_and_played_in_a_loop_from_where_one_says(tmp_path: Path) -> None:
    """Five seconds with another heading in each."""
    log, port = tmp_path / "boat.log", free_port()
    frames = [f"({1.6e9 + n / 10:.6f}) can0 09F11223#FF00{32 + n // 10:02X}00000000FC\n" for n in range(50)]
    log.write_text("".join(frames))
    url = f"tcp-listen://127.0.0.1:{port}"
    player = start("replay", str(log), "--to", url, "--speed", "10", "--loop", "--from", "+2")
    with connected(port) as listener, listener.makefile("rb") as lines:
        heard = [lines.readline() for _ in range(400)]
    player.terminate()
    player.communicate(timeout=20)
    headings = [line[7:12] for line in heard if line.startswith(b"$IIHDT,")]
    assert sum(line.startswith(b"$PARP,STATUS,") for line in heard) > 5
    changes = [later for earlier, later in pairwise(headings) if later != earlier]
    assert len(set(headings)) == 3  # nothing of the first two seconds
    assert changes[:5] == [changes[0], changes[1], headings[0], changes[0], changes[1]]


def test_a_recording_is_played_to_a_bus_without_what_commands(boat: Path, tmp_path: Path) -> None:
    """A pseudo-terminal stands in for an adapter."""
    ours, theirs = pty.openpty()
    os.set_blocking(ours, False)
    link = tmp_path / "can"
    link.symlink_to(os.ttyname(theirs))
    player = start("replay", str(boat), "--to", f"slcan://{link}?bitrate=250000", "--speed", "10")
    heard = b""
    while player.poll() is None:
        try:
            heard += os.read(ours, 65536)
        except BlockingIOError:
            time.sleep(0.005)
    _, told = player.communicate(timeout=20)
    os.close(ours)
    os.close(theirs)
    assert player.returncode == 0, told
    frames = [line for line in heard.split(b"\r") if line.startswith(b"T")]
    assert len(frames) > 1000
    assert not [line for line in frames if line[3:7] == b"F115"]  # 127237
    assert b"frames that command were withheld; --allow-commands lets them through" in told


def test_on_a_terminal_the_keyboard_plays(boat: Path) -> None:
    async def scene() -> tuple[bytes, int]:
        terminal, end = pty.openpty()
        port = free_port()
        process = subprocess.Popen(
            [*TIMONEL, "replay", str(boat), "--to", f"tcp-listen://127.0.0.1:{port}"],
            stdin=end, stdout=end, stderr=end, env=ENVIRONMENT,
        )  # fmt: skip
        os.close(end)
        os.set_blocking(terminal, False)
        shown = await until_shown(terminal, b"waiting for somebody")
        listener = connected(port)
        shown += await until_shown(terminal, b"1 x  (space, arrows, q)")
        os.write(terminal, b" ")
        shown += await until_shown(terminal, b"standing still")
        os.write(terminal, b"\x1b[C ")
        shown += await until_shown(terminal, b"14:13:3")
        os.write(terminal, b"q")
        shown += await until_shown(terminal, b"lines played")
        process.wait(10)
        listener.close()
        os.close(terminal)
        return shown, process.returncode

    shown, status = asyncio.run(scene())
    assert status == 0
    assert b"Traceback" not in shown


async def until_shown(terminal: int, text: bytes) -> bytes:
    shown = b""
    for _ in range(2000):
        try:
            shown += os.read(terminal, 65536)
        except BlockingIOError:
            await asyncio.sleep(0.005)
        except OSError:
            break
        if text in shown:
            return shown
    raise AssertionError(f"{text!r} not in {shown!r}")


# Repair -----------------------------------------------------------------------------------------------


def test_a_torn_recording_is_repaired_beside_the_old_one(boat: Path, tmp_path: Path) -> None:
    torn = tmp_path / "a.mcap"
    torn.write_bytes(boat.read_bytes()[:-5000])
    run = timonel("repair", str(torn))
    assert run.returncode == 0
    assert b"bytes from byte " in run.stderr
    assert b"are lost: the file is cut off" in run.stderr
    assert b"a.repaired.mcap: " in run.stdout
    assert b", 2026-09-21 14:13:20Z to 2026-09-21 14:13:" in run.stdout
    verified = timonel("replay", "--verify", str(tmp_path / "a.repaired.mcap"))
    assert verified.returncode == 0


def test_a_sound_recording_loses_nothing(boat: Path, tmp_path: Path) -> None:
    run = timonel("repair", str(boat), "-o", str(tmp_path / "b.mcap"))
    assert (run.returncode, run.stderr) == (0, b"")
    assert (tmp_path / "b.mcap").read_bytes() == boat.read_bytes()


def test_a_repair_overwrites_nothing(boat: Path) -> None:
    run = timonel("repair", str(boat), "-o", str(boat))
    assert run.returncode == 1
    assert b"File exists" in run.stderr
