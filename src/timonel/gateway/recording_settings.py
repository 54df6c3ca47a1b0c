"""Where the flight recorder writes: the table `[recording]` of a configuration, understood."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from timonel.gateway.extras import recorder_installed
from timonel.gateway.measures import duration, size

RECORDINGS = "recordings"
KEYS: dict[str, Any] = {
    "directory": str,
    "segment_size": str,
    "segment_age": str,
    "budget": str,
    "decoded": bool,
    "enabled": bool,
}
_READERS: dict[str, Callable[[str], float]] = {"segment_size": size, "budget": size, "segment_age": duration}


class Recording(msgspec.Struct, frozen=True):
    """Where the flight recorder writes, when it begins a new file (bytes, s), and what all may take (bytes).

    `decoded` is whether messages are recorded in clear too.
    """

    directory: str
    segment_size: int = 64_000_000
    segment_age: float = 3600.0
    budget: int = 2_000_000_000
    decoded: bool = False


def settle(values: Mapping[str, Any], beside: Path, wrong: Callable[[str, str], object]) -> Recording:
    """What the table says, of which `values` are right; files stand `beside` the configuration."""
    if not recorder_installed():
        wrong("recording", "needs mcap and zstandard: pip install timonel[recording]")
    measures: dict[str, Any] = {}
    for key, read in _READERS.items():
        try:
            measures |= {key: read(values[key])} if key in values else {}
        except ValueError as fault:
            wrong(f"recording.{key}", str(fault))
    directory = str(beside / values.get("directory", RECORDINGS))
    recording = Recording(directory, decoded=values.get("decoded", False), **measures)
    if recording.budget < 2 * recording.segment_size:
        wrong("recording.budget", "is less than two segments of segment_size")
    return recording
