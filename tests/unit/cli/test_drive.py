import asyncio
import fcntl
import os
import pty
import re
import signal
import struct
import subprocess
import sys
import termios
from collections.abc import Awaitable, Callable
from contextlib import AsyncExitStack

import pytest
from click.testing import CliRunner

from tests.unit.cli.test_face import drawn
from tests.unit.cli.test_gamepad import GAMEPAD, Device
from tests.unit.cli.test_station import read_until
from tests.unit.gateway.concentrator import run
from tests.unit.gateway.test_rover import Scenery
from timonel.cli.drive import Driver, drive
from timonel.cli.gamepad import ABS_X, ABS_Y, BTN_START, BTN_TR, EV_ABS, EV_KEY, Pad, pad_of
from timonel.vehicles.rover.simulator import Fault

Scene = Callable[[Driver, Scenery], Awaitable[None]]


def play(scene: Scene, *, enable: bool = True) -> None:
    """A driver at station 1 of a simulated rover."""

    async def main() -> None:
        async with AsyncExitStack() as stack:
            scenery = Scenery()
            await scenery.enter(stack)
            rover = await stack.enter_async_context(scenery.client(1))
            driver = Driver(rover, url="cable")
            await asyncio.sleep(1.5)
            if enable:
                await press(driver, "e", seconds=0.5)
            await scene(driver, scenery)

    run(main())


async def press(driver: Driver, *keys: str, seconds: float = 0.05) -> None:
    for key in keys:
        driver.press(key)
    await asyncio.sleep(seconds)


async def hold(driver: Driver, key: str, seconds: float) -> None:
    """As a terminal tells it: again 30 times a second."""
    for _ in range(round(seconds * 30)):
        await press(driver, key, seconds=1 / 30)


@pytest.mark.parametrize(
    ("key", "setpoint"),
    [
        ("up", (1, 0)), ("w", (1, 0)), ("down", (-1, 0)), ("s", (-1, 0)), ("left", (0, -1)), ("a", (0, -1)),
        ("right", (0, 1)), ("d", (0, 1)), ("shift-left", (1, -0.4)), ("shift-right", (1, 0.4)),
    ],
)  # fmt: skip
def test_a_key_moves_the_rover_its_way(key: str, setpoint: tuple[float, float]):
    async def scene(driver: Driver, s: Scenery) -> None:
        await press(driver, key)
        assert driver.gauges.setpoint == setpoint

    play(scene)


def test_the_rover_moves_while_a_key_is_held_and_rests_a_quarter_of_a_second_after_it_is_let_go():
    async def scene(driver: Driver, s: Scenery) -> None:
        await hold(driver, "up", 2.0)
        assert s.speed > 0.3
        await asyncio.sleep(0.2)
        assert driver.gauges.setpoint == (1, 0)
        await asyncio.sleep(0.1)
        assert driver.gauges.setpoint == (0, 0)
        assert s.rover.setpoints == ((0, 0, 0), (0, 0, 0))
        assert driver.gauges.enabled

    play(scene)


def test_nothing_moves_before_it_is_enabled_and_the_driver_is_told():
    async def scene(driver: Driver, s: Scenery) -> None:
        await hold(driver, "up", 0.5)
        assert s.speed == 0
        assert (driver.gauges.message, driver.gauges.refused) == ("drive: not enabled: enable it first", True)

    play(scene, enable=False)


def test_space_stops_and_a_key_that_is_still_held_does_nothing():
    async def scene(driver: Driver, s: Scenery) -> None:
        await hold(driver, "up", 1.0)
        await press(driver, " ", "up", seconds=0.5)
        assert not s.controller.drive.permitted
        assert "not enabled: it was stopped" in driver.gauges.message or driver.gauges.message == "stopped"
        assert s.rover.setpoints == ((0, 0, 0), (0, 0, 0))

    play(scene)


def test_the_speed_limit_is_set_before_it_moves_and_changed_in_steps():
    async def scene(driver: Driver, s: Scenery) -> None:
        assert s.controller.drive.speed_limit == 6
        await press(driver, "+", "+", seconds=0.1)
        assert s.controller.drive.speed_limit == 8
        await press(driver, *["-"] * 20, seconds=1.5)
        assert s.controller.drive.speed_limit == 1
        assert driver.gauges.message == "speed limit 5 %"
        await press(driver, *["+"] * 30, seconds=1.5)
        assert s.controller.drive.speed_limit == 20

    play(scene)


def test_what_cannot_be_enabled_says_why():
    async def scene(driver: Driver, s: Scenery) -> None:
        s.rover.silence(Fault.MOTOR_SUPPLY)
        await asyncio.sleep(0.5)
        await press(driver, "e", "e", seconds=1.0)
        assert driver.gauges.refused
        assert "motor driver: no supply" in driver.gauges.message

    play(scene, enable=False)


def test_keys_change_what_is_shown():
    async def scene(driver: Driver, s: Scenery) -> None:
        await press(driver, "?", "l")
        assert "hold shift ← →" in "\n".join(drawn(driver.gauges.page(80)))
        assert driver.gauges.night
        await press(driver, "q", "x")
        assert driver.left.is_set()

    play(scene, enable=False)


def test_the_gauges_show_the_rover_at_80_by_24():
    async def scene(driver: Driver, s: Scenery) -> None:
        await hold(driver, "up", 2.0)
        text = "\n".join(drawn(driver.gauges.page(80)))
        assert len(drawn(driver.gauges.page(80))) == 24
        for part in (
            "01 Operator   cable",
            "100.0 % whole",
            "ENABLED   speed limit 30 %  forward +1.00  right +0.00",
            "battery  16.", "V  ok   cells 4.1",
            "modules  20 20 20 20 20 20 °C",
            "position 52.2194", "° N  21.0105", "heading 35",
            "drivers  left running   right running",
            "e enable   space STOP",
        ):  # fmt: skip
            assert part in text
        for wheel in ("left front", "left middle", "left rear", "right front", "right middle", "right rear"):
            assert re.search(rf"{wheel} +\+30 % +\+2\d\.\d +\+\d\.\d +20\.\d +│███", text)

    play(scene)


@pytest.mark.parametrize(("width", "height"), [(80, 24), (60, 16), (40, 8), (200, 60)])
def test_the_gauges_fill_the_terminal_exactly(width: int, height: int):
    async def scene(driver: Driver, s: Scenery) -> None:
        lines = drawn(driver.gauges.page(width), width, height)
        assert [len(line) for line in lines] == [width] * height

    play(scene, enable=False)


def test_what_is_old_or_missing_is_not_shown_as_if_it_were_known():
    async def scene(driver: Driver, s: Scenery) -> None:
        s.mute = True
        s.rover.silence(Fault.GPS)
        await asyncio.sleep(3.0)
        text = "\n".join(drawn(driver.gauges.page(80)))
        assert "NO LINK  nothing heard for 2 s" in text
        assert "drivers  left silent   right silent" in text
        assert "s old" in text
        s.mute = False
        await asyncio.sleep(1.0)
        assert "no fix" in "\n".join(drawn(driver.gauges.page(80)))

    play(scene, enable=False)


def test_a_gamepad_drives_while_its_button_is_held_and_letting_go_is_rest():
    async def scene(driver: Driver, s: Scenery) -> None:
        pad = Pad({ABS_X: (-32768, 32767), ABS_Y: (-32768, 32767)})
        following = asyncio.create_task(driver.follow(pad))
        pad.receive(EV_ABS, ABS_Y, -32768)
        await asyncio.sleep(0.2)
        assert driver.gauges.setpoint == (0, 0)
        pad.receive(EV_KEY, BTN_TR, 1)
        await asyncio.sleep(1.0)
        assert driver.gauges.setpoint == (1, 0)
        assert s.speed > 0.2
        pad.receive(EV_KEY, BTN_TR, 0)
        await asyncio.sleep(0.06)
        assert driver.gauges.setpoint == (0, 0)
        following.cancel()

    play(scene)


def test_a_gamepad_that_is_unplugged_stops_the_rover():
    async def scene(driver: Driver, s: Scenery) -> None:
        device = Device(GAMEPAD, [(EV_KEY, BTN_TR, 1), (EV_ABS, ABS_Y, 0)])
        await hold(driver, "up", 1.0)
        await driver.hear(device, pad_of(device))
        assert not s.controller.drive.permitted
        assert driver.gauges.message == "the gamepad is gone; stopped"

    play(scene)


def test_the_buttons_of_a_gamepad_are_keys():
    async def scene(driver: Driver, s: Scenery) -> None:
        device = Device(GAMEPAD, [(EV_KEY, BTN_START, 1)])
        told: list[str] = []
        driver.press = told.append
        await driver.hear(device, pad_of(device))
        assert told == ["e"]

    play(scene, enable=False)


def test_without_a_terminal_it_says_that_it_needs_one():
    result = CliRunner().invoke(drive, ["tcp://127.0.0.1:1"])
    assert result.exit_code == 1
    assert "driving needs a terminal" in result.output


@pytest.mark.parametrize("end", [None, signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_the_terminal_is_put_back_however_it_ends(end: signal.Signals | None):
    master, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    process = subprocess.Popen(
        [sys.executable, "-c", "from timonel.cli.drive import drive; drive()", "tcp://127.0.0.1:1"],
        stdin=terminal, stdout=terminal, stderr=terminal, env=os.environ | {"TERM": "xterm"}, start_new_session=True,
    )  # fmt: skip
    os.set_blocking(master, False)
    try:
        before = termios.tcgetattr(terminal)
        read_until(master, b"NO LINK")
        if end is None:
            os.write(master, b"q")
        else:
            process.send_signal(end)
        assert b"\x1b[?1049l" in read_until(master, b"left; what we drove was stopped")
        assert process.wait(timeout=10) == 0
        assert termios.tcgetattr(terminal) == before
    finally:
        process.kill()
        process.wait()
        os.close(master)
        os.close(terminal)
