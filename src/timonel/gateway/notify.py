"""Tells systemd that the gateway is ready and alive (sd_notify(3)), where systemd asked to be told."""

import os
import socket
from collections.abc import Mapping


def notify(state: str, environment: Mapping[str, str] = os.environ) -> None:
    """Send `READY=1`, `WATCHDOG=1` or `STOPPING=1`; nothing happens where nobody wants to know."""
    address = environment.get("NOTIFY_SOCKET", "")
    if not address:
        return
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_NONBLOCK) as manager:
        try:
            manager.sendto(state.encode(), address.replace("@", "\0", 1))
        except OSError:
            return  # its own time-out tells systemd


def watchdog_interval(environment: Mapping[str, str] = os.environ) -> float | None:
    """Half of the time within which systemd wants a sign of life, s; None if it wants none."""
    usec = environment.get("WATCHDOG_USEC", "")
    return int(usec) / 2e6 if usec.isdigit() and int(usec) else None
