"""Who the gateway is on an NMEA 2000 bus: the keys of `[bus]` beside its URL and address, and what they come to.

A NAME must be nobody else's and stay over restarts, so its number is made of the computer's own identity and the
vehicle's name, unless an owner gives one.
"""

import hashlib
import uuid
from pathlib import Path
from typing import Any, get_type_hints

from timonel import __version__
from timonel.nmea2000.node import NodeSettings

MACHINE_ID = Path("/etc/machine-id")
SILENT = ("file",)
"""Schemes of buses that cannot be spoken to: there the gateway only listens, and is no device."""

_HINTS = get_type_hints(NodeSettings, include_extras=True)
_FIELDS = {
    "unique_number": "unique_number",
    "manufacturer": "manufacturer",
    "class": "device_class",
    "function": "device_function",
    "instance": "device_instance",
    "system_instance": "system_instance",
    "product_code": "product_code",
    "serial": "serial",
    "installation1": "installation1",
    "installation2": "installation2",
}
KEYS: dict[str, Any] = {"node": bool} | {key: _HINTS[field] for key, field in _FIELDS.items()}


def settle(values: dict[str, Any], vehicle: str) -> NodeSettings | None:
    """The node that a `[bus]` table asks for; None where it wants none, or the bus is a recording."""
    scheme = values.get("url", "").partition("://")[0]
    if not values.get("node", True) or scheme in SILENT:
        return None
    settings: dict[str, Any] = {"unique_number": unique_number(vehicle), "software": __version__[:32]}
    return NodeSettings(**settings | {field: values[key] for key, field in _FIELDS.items() if key in values})


def unique_number(vehicle: str) -> int:
    """21 bits that are this computer's and this vehicle's; the computer's identity cannot be told from them."""
    return int.from_bytes(hashlib.sha256(f"timonel {_machine()} {vehicle}".encode()).digest()[:4], "big") & 0x1FFFFF


def _machine() -> str:
    try:
        return MACHINE_ID.read_text().strip()
    except OSError:
        return f"{uuid.getnode():x}"
