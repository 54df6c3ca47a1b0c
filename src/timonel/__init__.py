"""timonel: the command gateway between helm stations and the CAN bus of a vehicle."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from timonel.gateway.rover import Rover
    from timonel.gateway.station import Station

__version__ = "0.1.0"
__all__ = ["Rover", "Station", "__version__"]

_CLIENTS = {"Rover": "timonel.gateway.rover", "Station": "timonel.gateway.station"}


def __getattr__(name: str) -> object:
    # so that `import timonel`, which every program and every `--help` does, loads nothing
    if name in _CLIENTS:
        return getattr(import_module(_CLIENTS[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
