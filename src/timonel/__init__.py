"""timonel: the command gateway between helm stations and the CAN bus of a vehicle."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from timonel.gateway.rover import Rover
    from timonel.gateway.station import Station
    from timonel.recording.decoded import open_recording
    from timonel.recording.selection import columns

__version__ = "0.1.0"
__all__ = ["Rover", "Station", "__version__", "columns", "open_recording"]

_LAZY = {
    "Rover": "timonel.gateway.rover",
    "Station": "timonel.gateway.station",
    "columns": "timonel.recording.selection",
    "open_recording": "timonel.recording.decoded",
}


def __getattr__(name: str) -> object:
    # so that `import timonel`, which every program and every `--help` does, loads nothing
    if name in _LAZY:
        return getattr(import_module(_LAZY[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
