"""What a vehicle's machine is made from, as text: a recording holds it, and a replay makes the same machine of it."""

from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar

import msgspec

from timonel.errors import ConfigError, RecordingError
from timonel.gateway import own_frames
from timonel.gateway.assemble import boat, rover
from timonel.gateway.configuration import Configuration
from timonel.gateway.moment import microseconds, seconds
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.rover import declared
from timonel.vehicles.rover.calibration import Calibration
from timonel.vehicles.rover.declaration import RoverFrame
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.settings import RoverSettings
from timonel.vehicles.vehicle import Vehicle

Description = dict[str, str]
T = TypeVar("T")


def describe(configuration: Configuration, now: float) -> Description:
    """The machine that `assemble` makes of a configuration at `now` (s). Raises ConfigError.

    The file of a rover's own frames is in it as it stands.
    """
    protocol = configuration.protocol or Protocol()
    description = {
        "vehicle": "boat" if isinstance(configuration.vehicle, BoatSettings) else "rover",
        "settings": _json(configuration.vehicle),
        "ports": _json(configuration.ports),
        "began_us": str(microseconds(now)),
    }
    if isinstance(configuration.vehicle, RoverSettings):
        description["calibration"] = _json(protocol.calibration)
    if configuration.frames_file is not None:
        description["frames_file"] = Path(configuration.frames_file).name
        description["frames"] = own_frames.read(configuration.frames_file)
    return description


def make(description: Mapping[str, str], frames_file: str | Path | None = None) -> Vehicle:
    """The machine of a description. `frames_file` stands in for the rover's own frames that it holds.

    Own frames that are a Python program are not run unless they are given: a recording may come from anybody.
    Raises RecordingError for what is no description, or one of a later version.
    """
    now = seconds(_read(description, "began_us", int))
    ports = _read(description, "ports", list[Port])
    match description.get("vehicle"):
        case "boat":
            return boat(_read(description, "settings", BoatSettings), ports, now)
        case "rover":
            protocol = Protocol(_read(description, "calibration", Calibration), _own_frames(description, frames_file))
            return rover(_read(description, "settings", RoverSettings), ports, now, protocol)
        case other:
            raise RecordingError(f"the recording does not say what made it (vehicle {other!r})")


def _own_frames(description: Mapping[str, str], frames_file: str | Path | None) -> tuple[type[RoverFrame], ...]:
    name, text = description.get("frames_file", ""), description.get("frames")
    try:
        if frames_file is not None:
            return own_frames.load(frames_file)
        if text is None:
            return ()
        if not name.endswith(".py"):
            return declared.parse(text, name)
    except ConfigError as fault:
        raise RecordingError(f"the rover's own frames: {fault}") from fault
    raise RecordingError(f"the rover's own frames are a program, {name}: give it with --frames if you trust it")


def _json(value: object) -> str:
    return msgspec.json.encode(value).decode()


def _read(description: Mapping[str, str], key: str, kind: type[T]) -> T:
    try:
        return msgspec.json.decode(description.get(key, ""), type=kind)
    except msgspec.DecodeError as fault:
        raise RecordingError(f"what made the recording is not understood: {key}: {fault}") from fault
