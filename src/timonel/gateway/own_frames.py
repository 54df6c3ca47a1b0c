"""Reads the files in which an owner declares frames and calibration of a rover."""

import runpy
import tomllib
from pathlib import Path
from typing import Any

from timonel.core.mistakes import Mistakes, syntax_error
from timonel.errors import ConfigError
from timonel.vehicles.rover import declared
from timonel.vehicles.rover.calibration import CALIBRATIONS, PHYSICAL, Calibration, calibrated
from timonel.vehicles.rover.declaration import RoverFrame
from timonel.vehicles.rover.protocol import Protocol

PROGRAM_FAULTS = (ArithmeticError, AttributeError, ImportError, LookupError, NameError, OSError, TypeError, ValueError)


def protocol(config: str | Path | None, frames: str | Path | None = None, calibration: str | None = None) -> Protocol:
    """The protocol that a `rover.toml` describes by `frames` in its `[vehicle]` and by its `[calibration]`.

    `frames` and `calibration` take the place of what stands there. Raises ConfigError with one line for each mistake.
    """
    document, constants = _configured(Path(config)) if config else ({}, PHYSICAL)
    if calibration:
        constants = CALIBRATIONS[calibration]
    if config and not frames and (named := document.get("vehicle", {}).get("frames")):
        frames = Path(config).parent / named
    return Protocol(constants, load(frames) if frames else ())


def _configured(path: Path) -> tuple[dict[str, Any], Calibration]:
    text = read(path)
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as fault:
        raise syntax_error(str(path), text, fault) from fault
    mistakes = Mistakes(str(path), text)
    constants = calibrated(document.get("calibration", {}), mistakes.add)
    if mistakes:
        raise mistakes.error()
    return document, constants


def load(path: str | Path) -> tuple[type[RoverFrame], ...]:
    """The frames of a TOML or Python file; raises ConfigError with one line for each mistake.

    A Python file is a program of its owner and is run.
    """
    return _from_python(Path(path)) if Path(path).suffix == ".py" else declared.parse(read(path), str(path))


def read(path: str | Path) -> str:
    """The text of a file; raises ConfigError."""
    try:
        return Path(path).read_bytes().decode()
    except OSError as fault:
        raise ConfigError(f"{path}: {fault.strerror}") from fault
    except UnicodeDecodeError as fault:
        raise ConfigError(f"{path}: not UTF-8 text (byte {fault.start})") from fault


def _from_python(path: Path) -> tuple[type[RoverFrame], ...]:
    read(path)
    try:
        found = runpy.run_path(str(path), run_name=path.stem)
    except (SyntaxError, *PROGRAM_FAULTS) as fault:
        raise ConfigError(f"{path}: {type(fault).__name__}: {fault}") from fault
    frames = tuple(
        value
        for value in found.values()
        if isinstance(value, type) and issubclass(value, RoverFrame) and value.__module__ == path.stem
    )
    mistakes: list[str] = []
    declared.check(frames, lambda key, text: mistakes.append(f"{path}, {key}: {text}"), "frame[{}].{}")
    if mistakes:
        raise ConfigError("\n".join(mistakes))
    return frames
