"""A minimal Signal K server beside the console: who follows its stream, and what they have not been told yet."""

from typing import Protocol

from timonel.gateway.configuration import Configuration
from timonel.gateway.gateway import Gateway
from timonel.gateway.signalk import epoch
from timonel.gateway.signalk_settings import SignalK as Settings
from timonel.gateway.signalk_settings import own_urn
from timonel.interop.signalk.boat import known
from timonel.interop.signalk.deltas import Vessel, delta
from timonel.interop.signalk.model import Model, grouped
from timonel.vehicles.boat.vehicle import Boat
from timonel.web.feed import framed

FOLLOWERS_MAX = 32


class Follower(Protocol):
    """Somebody who is told deltas."""

    def look(self, now: float) -> None:
        """Be told what there is."""


class SignalK:
    """What Signal K is told about a boat; looked at only while somebody wants to know."""

    def __init__(self, gateway: Gateway, boat: Boat, configuration: Configuration) -> None:
        self.settings = configuration.signalk or Settings()
        name = boat.settings.name
        self.vessel = Vessel(self.settings.urn or own_urn(name), name)
        self.boat = boat
        self.model = Model()
        self.followers: set[Follower] = set()
        self._gateway = gateway
        self._names = configuration.names
        self._said: dict[int, bytes] = {}

    @property
    def epoch(self) -> float:
        """When the machine's time was 0, s since 1970."""
        return epoch(self._gateway)

    def refresh(self, now: float) -> None:
        """Bring the model up to date."""
        if self.model.update(known(self.boat, self._names, now), now):
            self._said.clear()

    def look(self, now: float) -> None:
        """Let those who follow be told."""
        if self.followers:
            self.refresh(now)
            for follower in list(self.followers):
                follower.look(now)

    def since(self, sequence: int) -> bytes:
        """All that changed after an update, as a frame of the socket: the same for all who have seen as much."""
        said = self._said.get(sequence)
        if said is None:
            said = self._said[sequence] = self.told(
                [path for path, entry in self.model.entries.items() if entry.changed > sequence]
            )
        return said

    def told(self, paths: list[str]) -> bytes:
        """These paths, as a frame of the socket."""
        entries = {path: self.model.entries[path] for path in paths}
        return framed(delta(self.vessel.context, grouped(entries), self.epoch))
