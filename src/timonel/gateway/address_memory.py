"""What a boat's node remembers over a restart: its address, its NAME and what an installer wrote into it.

It stands in the state directory, in one file for each NAME that a configuration gives, and is read before the
machine is made: what a machine is made from, and a recording holds, is all there is to know about it.
"""

import asyncio
import logging
import os
import threading
from collections.abc import Sequence
from pathlib import Path

import msgspec

from timonel.core.effects import Effect
from timonel.core.frame import Frame
from timonel.gateway.configuration import Configuration
from timonel.gateway.gateway import Gateway
from timonel.gateway.places import state_directory
from timonel.nmea2000.claim import AddressClaimed
from timonel.nmea2000.node import Described, NodeSettings
from timonel.vehicles.boat.settings import BoatSettings

logger = logging.getLogger("timonel")


class Remembered(msgspec.Struct, frozen=True):
    """The file. `device_instance` and the system's are what the NAME came to have; None is what is configured."""

    address: int | None = None
    device_instance: int | None = None
    system_instance: int | None = None
    installation1: str | None = None
    installation2: str | None = None


def remembered(configuration: Configuration) -> Configuration:
    """The configuration with what is remembered of its node. A file that is not understood is as good as none."""
    vehicle = configuration.vehicle
    if not isinstance(vehicle, BoatSettings) or vehicle.node is None:
        return configuration
    kept = _read(_path(vehicle.node))
    changes = {key: value for key, value in msgspec.structs.asdict(kept).items() if value is not None}
    address = changes.pop("address", vehicle.address)
    try:
        settings = msgspec.convert(
            msgspec.to_builtins(vehicle) | {"address": address, "node": msgspec.to_builtins(vehicle.node) | changes},
            BoatSettings,
        )
    except msgspec.ValidationError:
        return configuration
    return msgspec.structs.replace(configuration, vehicle=settings)


def remember(gateway: Gateway, configuration: Configuration) -> None:
    """From now on keep what the node of `configuration`, as its file says it, comes to."""
    vehicle = configuration.vehicle
    if isinstance(vehicle, BoatSettings) and vehicle.node is not None:
        gateway.observers.append(Memory(_path(vehicle.node)))


class Memory:
    """An observer that writes down the node's address whenever it claimed one."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._kept = _read(path)
        self._writing = threading.Lock()

    def frames_received(self, frames: Sequence[Frame], now: float) -> None:
        """Not kept."""

    def port(self, name: str, connected: bool, now: float) -> None:
        """Not kept."""

    def effect(self, effect: Effect, now: float) -> None:
        if isinstance(effect, AddressClaimed):
            instances = {"device_instance": effect.name >> 32 & 0xFF, "system_instance": effect.name >> 56 & 0xF}
            self._keep(msgspec.structs.replace(self._kept, address=effect.address, **instances))
        elif isinstance(effect, Described):
            words = {"installation1": effect.installation1, "installation2": effect.installation2}
            self._keep(msgspec.structs.replace(self._kept, **words))

    def _keep(self, what: Remembered) -> None:
        """Written beside the loop: a slow card must not keep a station waiting."""
        if what == self._kept:
            return
        self._kept = what
        asyncio.get_running_loop().run_in_executor(None, self._write)

    def _write(self) -> None:
        """One after the other, and always the newest: two claims may follow each other at once."""
        with self._writing:
            _write(self._path, self._kept)


def _path(node: NodeSettings) -> Path:
    return state_directory() / f"node-{node.name:016x}.json"


def _read(path: Path) -> Remembered:
    try:
        return msgspec.json.decode(path.read_bytes(), type=Remembered)
    except (OSError, msgspec.DecodeError):
        return Remembered()


def _write(path: Path, what: Remembered) -> None:
    new = path.with_suffix(".new")
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        new.write_bytes(msgspec.json.encode(what))
        os.replace(new, path)
    except OSError as fault:
        logger.warning("%s: %s: the address on the bus is looked for anew after a restart", path, fault.strerror)
