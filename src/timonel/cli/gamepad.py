"""A gamepad: the left stick drives while a shoulder button is held.

```
left stick             forward and right, with a dead zone of a tenth
shoulder buttons       hold one of them to drive; letting go is rest
start                  enable
B (the right button)   stop
```
`Pad` is told what the kernel says of a device and knows nothing of it otherwise; `read` is the device, by evdev.
"""

import asyncio
from collections.abc import AsyncIterator
from contextlib import suppress
from typing import TYPE_CHECKING

from timonel.errors import LinkError

if TYPE_CHECKING:
    import evdev

DEAD_ZONE = 0.1

# linux/input-event-codes.h
EV_KEY, EV_ABS = 0x01, 0x03
ABS_X, ABS_Y = 0x00, 0x01
BTN_EAST, BTN_TL, BTN_TR, BTN_START = 0x131, 0x136, 0x137, 0x13B
SHOULDERS = (BTN_TL, BTN_TR)
PRESSED = {BTN_START: "e", BTN_EAST: " "}
"""Buttons that are as good as a key."""

Range = tuple[int, int]


class Pad:
    """What a gamepad says; `ranges` are the lowest and highest value of ABS_X and ABS_Y."""

    def __init__(self, ranges: dict[int, Range]) -> None:
        self._ranges = ranges
        self._axes = {ABS_X: 0.0, ABS_Y: 0.0}
        self._held: set[int] = set()

    def receive(self, kind: int, code: int, value: int) -> str | None:
        """An event of the device; the key that it is as good as, if it is."""
        if kind == EV_ABS and code in self._axes:
            self._axes[code] = self._deflection(code, value)
        elif kind == EV_KEY and code in SHOULDERS:
            (self._held.add if value else self._held.discard)(code)
        elif kind == EV_KEY and value == 1:
            return PRESSED.get(code)
        return None

    def _deflection(self, code: int, value: int) -> float:
        """-1..1; the dead zone is taken out, so that beside it a stick begins at nothing."""
        lowest, highest = self._ranges[code]
        part = (2 * value - lowest - highest) / (highest - lowest)
        beyond = max(0.0, abs(part) - DEAD_ZONE) / (1 - DEAD_ZONE)
        return beyond if part > 0 else -beyond

    def release(self) -> None:
        """It is gone: nobody holds anything."""
        self._held.clear()

    @property
    def stick(self) -> tuple[float, float] | None:
        """Forward and right, -1..1; None while no shoulder button is held."""
        return (0.0 - self._axes[ABS_Y], self._axes[ABS_X]) if self._held else None


def find() -> "evdev.InputDevice":
    """The first gamepad of this machine. Raises LinkError if there is none, or evdev is missing."""
    try:
        import evdev
    except ImportError:
        raise LinkError("a gamepad needs evdev: pip install timonel[gamepad]") from None
    paths = evdev.list_devices()
    for path in paths:
        device = evdev.InputDevice(path)
        if _is_gamepad(device.capabilities()):
            return device
        device.close()
    raise LinkError(f"no gamepad among {len(paths)} input devices that can be read (is this user in the group input?)")


def _is_gamepad(capabilities: dict[int, list[object]]) -> bool:
    axes = [axis[0] for axis in capabilities.get(EV_ABS, []) if isinstance(axis, tuple)]
    buttons = capabilities.get(EV_KEY, [])
    return ABS_X in axes and ABS_Y in axes and any(button in buttons for button in SHOULDERS)


def pad_of(device: "evdev.InputDevice") -> Pad:
    """A pad with the ranges of a device."""
    return Pad({axis: (device.absinfo(axis).min, device.absinfo(axis).max) for axis in (ABS_X, ABS_Y)})


async def read(device: "evdev.InputDevice", pad: Pad) -> AsyncIterator[str]:
    """Feed `pad`, and give the keys that its buttons are as good as, until it is unplugged."""
    try:
        with suppress(OSError):
            async for event in device.async_read_loop():
                if key := pad.receive(event.type, event.code, event.value):
                    yield key
    except asyncio.CancelledError:
        pad.release()
        raise
    pad.release()
