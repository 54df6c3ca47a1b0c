import asyncio
import fcntl
import os
import pty
import signal
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Awaitable, Callable

import pytest
from click.testing import CliRunner

from tests.unit.gateway.concentrator import Cable, Concentrator, run
from timonel.cli.station import Head, station
from timonel.gateway.station import Station
from timonel.nmea0183.parp import PilotMode, Verb

Scene = Callable[[Head, Concentrator], Awaitable[None]]


def play(scene: Scene, *, number: int = 2, commander: int = 2, holding: bool = True) -> Concentrator:
    async def main() -> Concentrator:
        far = Concentrator()
        far.commander = commander
        if holding:
            far.mode, far.setpoint = PilotMode.HEADING_HOLD, 1825
        async with Station(Cable(far, delay=0.01), station=number) as s:
            head = Head(s, link="cable")
            watching = asyncio.create_task(head.watch())
            await asyncio.sleep(0.55)
            await scene(head, far)
        await watching
        return far

    return run(main())


async def press(head: Head, *keys: str, wait: float = 0.1) -> None:
    for key in keys:
        head.press(key)
    await asyncio.sleep(wait)


@pytest.mark.parametrize(
    ("key", "setpoint"),
    [
        ("right", 1835), ("up", 1835), ("left", 1815), ("down", 1815),
        ("shift-right", 1925), (">", 1925), ("shift-left", 1725), ("<", 1725),
    ],
)  # fmt: skip
def test_arrows_turn(key: str, setpoint: int):
    assert play(lambda head, far: press(head, key)).setpoint == setpoint


@pytest.mark.parametrize("key", ["a", "e"])
def test_a_and_e_engage(key: str):
    assert play(lambda head, far: press(head, key), holding=False).verbs == [Verb.ENGAGE]


def test_space_is_standby():
    assert play(lambda head, far: press(head, " ")).mode is PilotMode.STANDBY


def test_space_is_standby_while_a_heading_is_typed_too():
    async def scene(head: Head, far: Concentrator) -> None:
        await press(head, "h", "4", " ", "5", "enter")
        assert head.face.entry is None

    far = play(scene)
    assert far.verbs == [Verb.DISENGAGE]


def test_space_drops_what_is_left_of_a_turn():
    far = play(lambda head, far: press(head, "right", "right", "shift-right", " ", wait=2.0))
    assert far.verbs[-1] is Verb.DISENGAGE
    assert far.mode is PilotMode.STANDBY


def test_a_key_held_down_adds_up_instead_of_piling_up():
    far = play(lambda head, far: press(head, *["right"] * 60, wait=3.0))
    assert far.setpoint == 1825 + 600
    assert far.verbs == [Verb.STBDTEN] * 6


def test_a_heading_is_typed_and_set():
    async def scene(head: Head, far: Concentrator) -> None:
        await press(head, "h", "0", "4", "6", "backspace", "5", "x", "enter")
        assert head.face.message == "set point 045.0"

    assert play(scene).setpoint == 450


def test_a_heading_can_be_given_up():
    async def scene(head: Head, far: Concentrator) -> None:
        await press(head, "h", "4", "escape")
        assert head.face.entry is None

    assert play(scene).verbs == []


@pytest.mark.parametrize(
    ("keys", "message"),
    [("", '"" is no heading'), ("..", '".." is no heading'), ("400", "heading: 400.0 is outside 0..360")],
)
def test_what_is_no_heading_is_said_and_not_sent(keys: str, message: str):
    async def scene(head: Head, far: Concentrator) -> None:
        await press(head, "h", *keys, "enter")
        assert (head.face.message, head.face.refused) == (message, True)

    assert play(scene).verbs == []


def test_r_asks_for_command_once():
    async def scene(head: Head, far: Concentrator) -> None:
        await press(head, "r", "r")
        assert head.face.asking
        assert head.face.requests[0].station == 2
        far.transfer(2)
        await asyncio.sleep(0.1)
        assert not head.face.asking
        assert head.face.status.commander == 2

    assert play(scene, commander=1).verbs == [Verb.REQCMD]


def test_t_takes_command_on_the_bridge():
    assert play(lambda head, far: press(head, "t"), number=1, commander=3).commander == 1


def test_y_gives_command_to_who_asks_and_else_releases_it():
    async def scene(head: Head, far: Concentrator) -> None:
        far.announce(3)
        await asyncio.sleep(0.1)
        await press(head, "y")

    assert play(scene).verbs == [Verb.ACKCMD]
    assert play(lambda head, far: press(head, "y")).verbs == [Verb.RELCMD]


def test_n_denies():
    async def scene(head: Head, far: Concentrator) -> None:
        far.announce(3)
        await asyncio.sleep(0.1)
        await press(head, "n")
        assert head.face.requests == ()

    assert play(scene).verbs == [Verb.DENYCMD]


def test_a_refusal_is_shown_with_its_reason():
    async def scene(head: Head, far: Concentrator) -> None:
        await press(head, "right")
        assert (head.face.message, head.face.refused) == ("STBDONE: station 01 is in command", True)

    play(scene, commander=1)


def test_what_the_far_end_tells_is_shown_and_rings():
    async def scene(head: Head, far: Concentrator) -> None:
        head.bell = False
        far.announce(3)
        await asyncio.sleep(0.1)
        assert (head.face.message, head.bell) == ("03 Flybridge asks for command", True)
        far.transfer(0)
        await asyncio.sleep(0.1)
        assert head.face.message == "command passed from 02 Cockpit to nobody"
        far.mute = True
        await asyncio.sleep(4.0)
        assert head.face.message == "lost: no STATUS for 3 s"
        far.mute = False
        await asyncio.sleep(1.0)
        assert (head.face.message, head.face.lost) == ("back", None)

    play(scene)


def test_an_alarm_rings_once():
    async def scene(head: Head, far: Concentrator) -> None:
        far.mode = PilotMode.ALARM
        await asyncio.sleep(0.6)
        assert head.bell
        head.bell = False
        far.heading = 10.0
        await asyncio.sleep(0.6)
        assert not head.bell

    play(scene)


def test_keys_change_what_is_shown():
    async def scene(head: Head, far: Concentrator) -> None:
        await press(head, "l", "?")
        assert head.face.night
        assert head.face.help
        await press(head, "l", "?", "q")
        assert not head.face.night
        assert not head.face.help
        assert head.left.is_set()

    assert play(scene).verbs == []


def test_without_a_terminal_it_says_that_it_needs_one():
    result = CliRunner().invoke(station, ["tcp://127.0.0.1:1", "--id", "2"])
    assert result.exit_code == 1
    assert "needs a terminal" in result.output


@pytest.mark.parametrize("number", ["0", "5", "x"])
def test_a_station_that_there_is_not_is_a_mistake(number: str):
    assert CliRunner().invoke(station, ["tcp://127.0.0.1:1", "--id", number]).exit_code == 2


def head_in_terminal(url: str) -> tuple[subprocess.Popen[bytes], int, int]:
    """The program in a pseudo-terminal of 80 by 24; the process, our end, and its end."""
    master, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    code = "from timonel.cli.station import station; station()"
    process = subprocess.Popen(
        [sys.executable, "-c", code, url, "--id", "2"],
        stdin=terminal, stdout=terminal, stderr=terminal, env=os.environ | {"TERM": "xterm"}, start_new_session=True,
    )  # fmt: skip
    os.set_blocking(master, False)
    return process, master, terminal


def read_until(fd: int, wanted: bytes, seconds: float = 20.0) -> bytes:
    seen, end = b"", time.monotonic() + seconds
    while wanted not in seen:
        assert time.monotonic() < end, seen
        try:
            seen += os.read(fd, 65536)
        except BlockingIOError:
            time.sleep(0.01)
    return seen


@pytest.mark.parametrize("end", [None, signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_the_terminal_is_put_back_however_it_ends(end: signal.Signals | None):
    process, master, terminal = head_in_terminal("tcp://127.0.0.1:1")
    try:
        before = termios.tcgetattr(terminal)
        read_until(master, b"NO LINK")
        assert termios.tcgetattr(terminal) != before
        if end is None:
            os.write(master, b"q")
        else:
            process.send_signal(end)
        out = read_until(master, b"left; command and pilot stay as they were")
        assert b"\x1b[?1049l" in out
        assert process.wait(timeout=10) == 0
        assert termios.tcgetattr(terminal) == before
    finally:
        process.kill()
        process.wait()
        os.close(master)
        os.close(terminal)


def test_a_terminal_that_is_hung_up_ends_it():
    process, master, terminal = head_in_terminal("tcp://127.0.0.1:1")
    try:
        read_until(master, b"NO LINK")
        os.close(terminal)
        os.close(master)
        process.wait(timeout=10)
    finally:
        process.kill()
        process.wait()
