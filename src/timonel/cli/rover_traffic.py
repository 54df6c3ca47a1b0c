"""What goes through a rover's controller, counted for people to look at."""

from collections.abc import Sequence
from math import degrees

from timonel.cli.traffic import Heard, Meter, Traffic, words
from timonel.core.command import NOBODY, Transferred
from timonel.core.effects import Effect, Say, Transmit
from timonel.core.fields import Code
from timonel.core.frame import Frame
from timonel.vehicles.rover.declaration import RoverFrame
from timonel.vehicles.rover.drive import Permission
from timonel.vehicles.rover.protocol import Protocol

STATIONS = {1: "Operator", 2: "Jetson", 3: "Station 3", 4: "Station 4"}

SPOKEN = {
    "rad": (degrees, "°", 0),
    "rad/s": (degrees, "°/s", 1),
    "T": (lambda value: value * 1e6, " µT", 1),
    "degC": (float, " °C", 1),
    "deg": (float, "°", 5),
    "V": (float, " V", 2),
    "A": (float, " A", 1),
    "rpm": (float, " rpm", 1),
    "m/s2": (float, " m/s²", 2),
    "%": (float, " %", 0),
    "1": (float, "", 2),
}
"""Units for the eye: how to come to them, what they are called, and how many decimals they deserve."""
SUFFIXES = ("_percent", "_rpm", "_c", "_deg")


class RoverTraffic(Traffic):
    """An observer of a rover's gateway: `messages` are the frames of the modules, `sent` those for them."""

    def __init__(self, protocol: Protocol) -> None:
        super().__init__()
        self.protocol = protocol
        self.sent: dict[int, Heard] = {}
        self.commander = NOBODY
        self.permission = Permission(False, "nobody has enabled the drives yet")

    def frames_received(self, frames: Sequence[Frame], now: float) -> None:
        """Frames came in from the bus."""
        self.frames_in.count(now, len(frames))
        for frame in frames:
            self._take(self.messages, frame, now)

    def _take(self, heard: dict[int, Heard], frame: Frame, now: float) -> None:
        if frame.identifier not in heard:
            declared = self.protocol.declaration(frame.identifier)
            name = words(declared.__name__) if declared else f"Frame {frame.identifier}"
            heard[frame.identifier] = Heard(name, Meter())
        heard[frame.identifier].take(frame.data, now)

    def effect(self, effect: Effect, now: float) -> None:
        """The gateway said, sent or noticed something."""
        match effect:
            case Say():
                self.lines_out.count(now)
                return
            case Transmit(frame=frame):
                self._take(self.sent, frame, now)
            case Transferred(commander=commander):
                self.commander = commander
            case Permission():
                self.permission = effect
        super().effect(effect, now)

    def decoded(self, heard: dict[int, Heard], identifier: int) -> RoverFrame | None:
        """The newest frame of an identifier; None if there is none."""
        return self.protocol.decode(identifier, heard[identifier].last) if identifier in heard else None


def spoken(frame: RoverFrame | None, data: bytes) -> str:
    """The values of a frame in units for the eye, derived ones first; what is not available is left out.

    A unit stands behind the last of the values that share it.
    """
    if frame is None:
        return data.hex(" ")
    units = {name: derived.unit for name, derived in type(frame).DERIVED.items()}
    units |= {name: signal.unit for name, signal in type(frame).signals}
    values = [(name, value, unit) for name, unit in units.items() if (value := getattr(frame, name)) is not None]
    following = [unit for _, _, unit in values[1:]] + [None]
    parts = [
        _value(*value) + (_unit(value[2]) if value[2] != then else "")
        for value, then in zip(values, following, strict=False)  # without a value, nothing follows
    ]
    return "  ".join(parts) or "nothing available"


def _value(name: str, value: object, unit: str) -> str:
    for suffix in SUFFIXES:
        name = name.removesuffix(suffix)
    label = name.replace("_", " ")
    match value:
        case Code():
            return f"{label} {value.name.lower().replace('_', ' ')}"
        case int() | float() if unit in SPOKEN:
            convert, _, decimals = SPOKEN[unit]
            return f"{label} {convert(value):.{decimals}f}"
        case float():
            return f"{label} {value:.6g}"
        case _:
            return f"{label} {value}"


def _unit(unit: str) -> str:
    return SPOKEN[unit][1] if unit in SPOKEN else f" {unit}" if unit else ""
