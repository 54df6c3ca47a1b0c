"""Reads the files in which an owner declares frames of a rover."""

import runpy
from pathlib import Path

from timonel.errors import ConfigError
from timonel.vehicles.rover import declared
from timonel.vehicles.rover.declaration import RoverFrame

PROGRAM_FAULTS = (ArithmeticError, AttributeError, ImportError, LookupError, NameError, OSError, TypeError, ValueError)


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
