"""The key that seals the cookies of paired consoles, kept so that they are known again after a restart."""

import logging
import os
from pathlib import Path

from timonel.gateway.places import state_directory
from timonel.web.access import new_key

LENGTH = 32

logger = logging.getLogger("timonel")


def kept_key() -> bytes:
    """This computer's key; a new one that is forgotten at the end where it cannot be kept."""
    path = state_directory() / "console.key"
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not path.exists():
            _write(path, new_key())
        key = path.read_bytes()
    except OSError as fault:
        logger.warning("%s: %s: consoles must be paired anew after a restart", path, fault.strerror)
        return new_key()
    if len(key) != LENGTH:
        logger.warning("%s: not a key of ours: consoles must be paired anew after a restart", path)
        return new_key()
    return key


def _write(path: Path, key: bytes) -> None:
    """For us alone to read; somebody else's is not overwritten."""
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with open(descriptor, "wb") as file:
        file.write(key)
