"""The console's server side without the server: who looks, what they are shown, and what becomes of what they say.

It looks at the vehicle 10 times a second (a rover's 20 times), and at once when something presses; with nobody
there only once a second, for the history.
"""

import asyncio
import logging
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

from timonel.core.command import NOBODY
from timonel.core.pace import Allowance
from timonel.gateway.configuration import Configuration
from timonel.gateway.gateway import Gateway
from timonel.links.inner import InnerLink
from timonel.vehicles.boat.vehicle import Boat
from timonel.vehicles.rover.vehicle import Rover
from timonel.web.access import Access, Least, Rights
from timonel.web.boat import SAMPLES as BOAT_SAMPLES
from timonel.web.boat import BoatState
from timonel.web.feed import Feed
from timonel.web.history import PERIOD, History
from timonel.web.messages import FromServer, Pairing, PairingOver
from timonel.web.pairing import Asked, Pairings
from timonel.web.port import BoatPort, Port, RoverPort
from timonel.web.rover import SAMPLES as ROVER_SAMPLES
from timonel.web.rover import RoverState
from timonel.web.signalk import SignalK
from timonel.web.state import State
from timonel.web.tiles import Tiles

BOAT_PERIOD = 0.1  # s
ROVER_PERIOD = 0.05  # s
SOONEST = 0.02  # s between two looks
CLIENTS_MAX = 256
AT_ONCE = 4  # clients that are told in one go; between two of them the wires have their turn
ASKING, ASKING_WINDOW = 10, 60.0  # pairings that may be asked for in so many seconds

logger = logging.getLogger("timonel")


class Client(Protocol):
    """Somebody who looks."""

    rights: Rights
    station: int | None

    def tell(self, message: FromServer) -> None:
        """Something for this one alone."""

    def news(self) -> None:
        """The feed has something new."""

    def look(self, now: float) -> None:
        """See what became of what this one said, and whether it still listens."""


class Console:
    """All who look at one vehicle."""

    def __init__(self, gateway: Gateway, configuration: Configuration, key: bytes) -> None:
        assert configuration.web is not None
        self.gateway = gateway
        self.names = configuration.names
        self.access = Access(configuration.web, key, time.monotonic, time.time)
        self.pairings = Pairings(self._pairing_began, self._pairing_ended)
        self.clients: dict[int, Client] = {}
        self.tiles = None if configuration.web.tiles is None else Tiles(Path(configuration.web.tiles))
        self.asking = Allowance(ASKING, ASKING_WINDOW)
        self.state, self.ports, kind = _vehicle(gateway, configuration)
        boat = kind == "boat"
        self.feed = Feed("boat" if boat else "rover", configuration.vehicle.name)
        self.history = History(BOAT_SAMPLES if boat else ROVER_SAMPLES)
        self._period = BOAT_PERIOD if boat else ROVER_PERIOD
        self._sampled = float("-inf")
        self._spread_until = 0
        self.signalk = SignalK(gateway, gateway.vehicle, configuration) if isinstance(gateway.vehicle, Boat) else None
        self._commander = NOBODY
        self._pressed = asyncio.Event()
        self._numbers = 0
        self.state.pressing = self._pressed.set
        self.state.consoles = lambda station: len(self.ports[station].consoles) if station in self.ports else 0
        gateway.observers.append(self.state)

    # Looking ------------------------------------------------------------------------------------------

    async def run(self) -> None:
        """For ever."""
        while True:
            await asyncio.sleep(SOONEST)
            self._pressed.clear()
            try:
                async with asyncio.timeout(self._period - SOONEST):
                    await self._pressed.wait()
            except TimeoutError:
                pass
            news: list[Client] = []
            self.gateway.guarded("console", self._tick, self.gateway.now, news)
            await self._spread(news)

    def _tick(self, now: float, news: list[Client]) -> None:
        if now >= self._sampled + PERIOD:
            self._sampled = now
            self.history.take(self.state.samples(self.state.topics(now)), now)
        if self.signalk is not None:
            self.signalk.look(now)
        if not self.clients:
            return
        for client in list(self.clients.values()):
            client.look(now)
        self._remind_commander()
        self.refresh(now)
        if self.feed.sequence != self._spread_until:
            self._spread_until = self.feed.sequence
            news += self.clients.values()

    def refresh(self, now: float) -> None:
        """Bring the feed up to date."""
        self.feed.update(self.state.topics(now), now)

    async def _spread(self, clients: list[Client]) -> None:
        for place, client in enumerate(clients, 1):
            client.news()
            if place % AT_ONCE == 0:
                await asyncio.sleep(0)

    # Those who look -----------------------------------------------------------------------------------

    def enter(self, client: Client) -> int:
        """Somebody looks; the number that he is known by."""
        self._numbers += 1
        if not self.clients:
            self.refresh(self.gateway.now)
        self.clients[self._numbers] = client
        return self._numbers

    def leave(self, number: int) -> None:
        """He looks no more."""
        client = self.clients.pop(number)
        self.become(number, client, None)

    def become(self, number: int, client: Client, station: int | None) -> None:
        """A client is another station from now on, or none."""
        if client.station is not None:
            self.ports[client.station].leave(number)
        client.station = station
        if station is not None:
            self.ports[station].enter(number)
            self._remind(client)
        self._pressed.set()

    # Pairing ------------------------------------------------------------------------------------------

    def _pairing_began(self, asked: Asked) -> None:
        name = self.names[asked.station]
        logger.warning(
            "%s (%s) asks to be %s: the digits are %s", asked.name or "a console", asked.address, name, asked.code
        )
        for client in self.clients.values():
            if self._may_decide(client):
                client.tell(self._pairing(asked))

    def _pairing_ended(self, asked: Asked) -> None:
        for client in self.clients.values():
            if self._may_decide(client):
                client.tell(PairingOver(asked.number))

    def _remind(self, client: Client) -> None:
        if self._may_decide(client):
            for asked in self.pairings.waiting(self.gateway.now):
                client.tell(self._pairing(asked))

    def _remind_commander(self) -> None:
        """Whoever comes into command is shown what waits."""
        self.pairings.waiting(self.gateway.now)
        commander, self._commander = self._commander, self.state.transfer.commander
        if self._commander != commander:
            for client in self.clients.values():
                self._remind(client)

    def _may_decide(self, client: Client) -> bool:
        """The station in command, and admins."""
        commander = self.state.transfer.commander
        return client.rights.least is Least.ADMIN or (client.station is not None and client.station == commander)

    def may_refuse(self, client: Client, number: int) -> bool:
        """Let somebody refuse a pairing; whether he may and it was there."""
        return self._may_decide(client) and self.pairings.refuse(number)

    def _pairing(self, asked: Asked) -> Pairing:
        return Pairing(
            asked.number,
            asked.station,
            self.names[asked.station],
            asked.code,
            asked.name,
            asked.address,
            round(asked.deadline, 3),
        )


def _vehicle(gateway: Gateway, configuration: Configuration) -> tuple[State, Mapping[int, Any], str]:
    """State and web ports of a gateway's vehicle, and what it is."""
    links = {channel.name: channel.receive for channel in gateway.channels if isinstance(channel.receive, InnerLink)}
    mine = {port.station: links[port.name] for port in configuration.consoles if port.station is not None}
    ports: dict[int, Port]
    match gateway.vehicle:
        case Boat() as boat:
            state: State = BoatState(gateway, configuration, boat)
            ports = {number: BoatPort(number, link, state, gateway, boat) for number, link in mine.items()}
            return state, ports, "boat"
        case Rover() as rover:
            state = RoverState(gateway, configuration, rover)
            ports = {number: RoverPort(number, link, state, gateway, rover) for number, link in mine.items()}
            return state, ports, "rover"
    raise AssertionError("a gateway is of a boat or of a rover")
