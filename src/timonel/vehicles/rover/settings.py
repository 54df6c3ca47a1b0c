"""What an owner may set about a rover: the `[vehicle]` table of a configuration."""

from typing import Annotated, Literal

import msgspec

Seconds = Annotated[float, msgspec.Meta(gt=0, le=3600)]
ShortSeconds = Annotated[float, msgspec.Meta(gt=0, le=1)]


class RoverSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Settings of the rover with the defaults of spec/rover.md."""

    name: str = "rover"
    role: Literal["controller", "operator"] = "controller"
    """Whether this gateway drives the wheels itself, or is the far end of a link to the controller that does."""
    dialect: Literal["strzyga", "strzyga-crc", "hal062"] = "strzyga"
    """How frames are written on the stations' links, and on the link to a controller."""
    calibration: Literal["documented", "physical"] = "physical"
    """What raw values mean: the original's formulas to the letter, or mended. `[calibration]` has the constants."""
    request_timeout: Literal["transfer", "deny"] = "deny"
    """What a request comes to that the commander leaves unanswered. Who drives has no hand free to answer, and no
    word for it on the wire; who is gone is released after 2 s anyway."""
    request_seconds: Seconds = 10.0
    idle: ShortSeconds = 0.005
    """How long a silence proves the frame before it, s."""
    stall_current: Annotated[float, msgspec.Meta(gt=0)] = 10.0
    """From how many A on wheels that are told to turn and do not are stalled."""


class Port(msgspec.Struct, frozen=True):
    """A way in: the link of one station. On a rover nobody shares a wire; the frames do not say who speaks.

    A `console` is no wire, but the gateway's own: what it says is written as `console` (the module) tells.
    """

    name: str
    station: int
    console: bool = False
