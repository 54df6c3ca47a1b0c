"""timonel: the command gateway between helm stations and the CAN bus of a vehicle."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from timonel.gateway.station import Station

__version__ = "0.1.0"
__all__ = ["Station", "__version__"]


def __getattr__(name: str) -> object:
    # so that `import timonel`, which every program and every `--help` does, loads nothing
    if name == "Station":
        from timonel.gateway.station import Station

        return Station
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
