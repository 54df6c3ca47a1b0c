"""Where a server listens, as people write it: "127.0.0.1:8080", "[::]:8080", "boat.local:8080"; and where state is."""

import ipaddress
import os
from pathlib import Path


def place(text: str) -> tuple[str, int]:
    """Host and port; raises ValueError that says what would be right."""
    host, _, port = text.rpartition(":")
    host = host.removeprefix("[").removesuffix("]") if host.startswith("[") else host
    if not host or not port.isdecimal() or int(port) > 65535 or (":" in host and not text.startswith("[")):
        raise ValueError(f'"{text}" should be a host and a port, like "127.0.0.1:8080" or "[::1]:8080"')
    return host, int(port)


def state_directory() -> Path:
    """Where things are kept over restarts: where systemd says (`StateDirectory=`), else in the user's own state."""
    given = os.environ.get("STATE_DIRECTORY", "").partition(":")[0]
    if given:
        return Path(given)
    home = os.environ.get("XDG_STATE_HOME")
    return Path(home or Path.home() / ".local" / "state") / "timonel"


def is_loopback(host: str) -> bool:
    """Whether only this computer reaches it."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
