"""A boat that was told something."""

from typing import Any

from tests.unit.web.scene import frame, heading, pilot_holds
from timonel.core.message import Message
from timonel.interop.signalk.boat import known
from timonel.interop.signalk.told import Value
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.vehicle import Boat

NAMES = {1: "Bridge", 2: "Cockpit"}
__all__ = ["boat", "heading", "message", "pilot_holds", "told", "values"]


def boat(*heard: Message, now: float = 0.0, **settings: Any) -> Boat:
    made = Boat(BoatSettings(name="Alba", **settings), [Port("Cockpit", 2)], now)
    for each in heard:
        told(made, each, now)
    return made


def told(there: Boat, what: Message, now: float = 0.0) -> None:
    there.receive_frames([frame(what)], now)


def message(kind: type[Message], **fields: Any) -> Message:
    """One whose other fields are not available."""
    return kind(**(dict.fromkeys(kind.__struct_fields__, None) | fields))


def values(there: Boat, now: float = 0.0) -> dict[str, Value]:
    """All values by path."""
    return {path: value for each in known(there, NAMES, now) for path, value in each.values.items()}
