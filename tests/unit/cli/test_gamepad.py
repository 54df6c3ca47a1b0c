import asyncio
import sys
from types import ModuleType, SimpleNamespace

import pytest

from timonel.cli.gamepad import (
    ABS_X,
    ABS_Y,
    BTN_EAST,
    BTN_START,
    BTN_TL,
    BTN_TR,
    EV_ABS,
    EV_KEY,
    Pad,
    find,
    pad_of,
    read,
)
from timonel.errors import LinkError

RANGES = {ABS_X: (-32768, 32767), ABS_Y: (0, 255)}


def test_the_stick_counts_while_a_shoulder_button_is_held():
    pad = Pad(RANGES)
    pad.receive(EV_ABS, ABS_Y, 0)
    assert pad.stick is None
    pad.receive(EV_KEY, BTN_TL, 1)
    assert pad.stick == (1.0, 0.0)
    pad.receive(EV_KEY, BTN_TL, 0)
    assert pad.stick is None


def test_letting_go_of_one_of_two_buttons_is_not_letting_go():
    pad = Pad(RANGES)
    for code, value in ((BTN_TL, 1), (BTN_TR, 1), (BTN_TL, 0)):
        pad.receive(EV_KEY, code, value)
    assert pad.stick == (0.0, 0.0)


@pytest.mark.parametrize(
    ("x", "y", "stick"),
    [
        (32767, 255, (-1.0, 1.0)),
        (-32768, 0, (1.0, -1.0)),
        (3000, 130, (0.0, 0.0)),
        (0, 127, (0.0, 0.0)),
        (18022, 127, (0.0, 0.5)),
    ],
)
def test_a_stick_is_scaled_by_its_range_and_has_a_dead_zone(x: int, y: int, stick: tuple[float, float]):
    pad = Pad(RANGES)
    pad.receive(EV_KEY, BTN_TR, 1)
    pad.receive(EV_ABS, ABS_X, x)
    pad.receive(EV_ABS, ABS_Y, y)
    assert pad.stick == pytest.approx(stick, abs=1e-4)


def test_start_enables_and_b_stops_when_pressed_and_not_when_let_go():
    pad = Pad(RANGES)
    told = [pad.receive(EV_KEY, code, value) for code in (BTN_START, BTN_EAST, 0x120) for value in (1, 0)]
    assert told == ["e", None, " ", None, None, None]


class Device:
    """What evdev makes of a gamepad that says `events` and is unplugged then."""

    def __init__(self, capabilities: dict, events: list[tuple[int, int, int]] = ()) -> None:
        self._capabilities = capabilities
        self._events = events
        self.closed = False

    def capabilities(self):
        return self._capabilities

    def absinfo(self, axis: int):
        lowest, highest = RANGES[axis]
        return SimpleNamespace(min=lowest, max=highest)

    async def async_read_loop(self):
        for kind, code, value in self._events:
            yield SimpleNamespace(type=kind, code=code, value=value)
        raise OSError(19, "No such device")

    def close(self) -> None:
        self.closed = True


GAMEPAD = {EV_KEY: [BTN_TL, BTN_TR], EV_ABS: [(ABS_X, None), (ABS_Y, None)]}
MOUSE = {EV_KEY: [0x110], EV_ABS: []}


def plugged(monkeypatch: pytest.MonkeyPatch, **devices: Device) -> None:
    module = ModuleType("evdev")
    module.list_devices = lambda: list(devices)
    module.InputDevice = devices.__getitem__
    monkeypatch.setitem(sys.modules, "evdev", module)


def test_the_first_gamepad_is_found_and_other_devices_are_let_go(monkeypatch: pytest.MonkeyPatch):
    mouse, gamepad = Device(MOUSE), Device(GAMEPAD)
    plugged(monkeypatch, mouse=mouse, gamepad=gamepad)
    assert find() is gamepad
    assert (mouse.closed, gamepad.closed) == (True, False)


def test_without_a_gamepad_it_says_where_it_looked(monkeypatch: pytest.MonkeyPatch):
    plugged(monkeypatch, mouse=Device(MOUSE))
    with pytest.raises(LinkError, match="no gamepad among 1 input devices that can be read"):
        find()


def test_without_evdev_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "evdev", None)
    with pytest.raises(LinkError, match=r"pip install timonel\[gamepad\]"):
        find()


def test_a_gamepad_that_is_unplugged_holds_nothing():
    device = Device(GAMEPAD, [(EV_KEY, BTN_START, 1), (EV_KEY, BTN_TR, 1), (EV_ABS, ABS_Y, 0)])
    pad = pad_of(device)

    async def session() -> list[str]:
        return [key async for key in read(device, pad)]

    assert asyncio.run(session()) == ["e"]
    assert pad.stick is None
