"""The vehicle at an MQTT broker: what the console shows is published, and a paired station's orders are heard.

```
async with published(gateway, configuration):
    await serve(gateway)
```
what                                                       is published
command, pilot, drive, alerts, links, position             at once
measured values                                            every `interval`
everything                                                 when a connection begins; then only what changed
that we are here, and that we are gone                     when it is so; by the broker when we are lost (last will)

Nothing waits for the broker: a task of its own publishes what stands on a board, and tries again after 1, 2, 4 ... 30 s
when the broker is gone. Orders go through a port of their own, as the console's do (`timonel.web.port`): recorded,
limited and refused as what comes over a wire, and obeyed only while their station is in command. A broker that is gone
is a port that is unplugged.
"""

import asyncio
import logging
import secrets
import ssl
from collections import Counter
from collections.abc import AsyncIterator, Iterator, Sequence
from contextlib import asynccontextmanager, suppress
from types import ModuleType

import aiomqtt
import msgspec
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties
from paho.mqtt.subscribeoptions import SubscribeOptions

from timonel import __version__
from timonel.core.alerts import AlertKind
from timonel.core.effects import Effect
from timonel.core.frame import Frame
from timonel.core.pace import Allowance
from timonel.gateway.broker import Mqtt, plain
from timonel.gateway.configuration import Configuration
from timonel.gateway.gateway import Gateway
from timonel.interop import mqtt
from timonel.interop.home_assistant import Device, discovery
from timonel.links.inner import InnerLink
from timonel.vehicles.boat import alerts as boat_alerts
from timonel.vehicles.boat.vehicle import Boat
from timonel.vehicles.rover import alerts as rover_alerts
from timonel.vehicles.rover.vehicle import Rover
from timonel.web import documents
from timonel.web.board import Board
from timonel.web.boat import BoatState
from timonel.web.orders import Orders
from timonel.web.port import BoatPort, RoverPort
from timonel.web.rover import RoverState
from timonel.web.state import UNTOLD, State, Told

ALERTS_MAX = 64  # that Home Assistant is told of
EVENTS_PER_SECOND = 20
ORDERS_WAITING = 64
MESSAGE_MAX = 4096  # bytes that the broker may send at once
FIRST_PAUSE, LAST_PAUSE = 1.0, 30.0  # s before the broker is tried again
KEEP_ALIVE = 15  # s
WITHIN = 5.0  # s that the broker has for what it is told
END_WITHIN = 0.5  # s
SOONEST = 0.05  # s between two looks
DECIDE_EVERY = 0.1  # s
KINDS: dict[mqtt.Vehicle, ModuleType] = {"boat": boat_alerts, "rover": rover_alerts}
NO_ECHO = SubscribeOptions(qos=0, noLocal=True, retainAsPublished=True, retainHandling=2)

logger = logging.getLogger("timonel")


@asynccontextmanager
async def published(gateway: Gateway, configuration: Configuration) -> AsyncIterator[None]:
    """While it is entered, the broker of the configuration is told, if there is one."""
    if configuration.mqtt is None:
        yield
        return
    broker = Broker(gateway, configuration.mqtt, configuration)
    talking = asyncio.create_task(broker.run(), name="MQTT")
    talking.add_done_callback(_ended)
    try:
        yield
    finally:
        broker.ending = True
        talking.cancel()
        await asyncio.wait({talking}, timeout=2 * END_WITHIN)


def _ended(talking: asyncio.Task[None]) -> None:
    if not talking.cancelled() and (fault := talking.exception()) is not None:
        logger.error("MQTT: given up", exc_info=fault)


class Bulletin:
    """Puts on a board how a vehicle stands and what happens to it. `pressed` is set when people should see it at once.

    An observer of the gateway.
    """

    def __init__(self, board: Board, settings: Mqtt, gateway: Gateway, configuration: Configuration) -> None:
        self.state, self.vehicle = _state(gateway, configuration)
        self.pressed = asyncio.Event()
        self._board = board
        self._mqtt = settings
        self._device = Device(
            plain(settings.base), configuration.vehicle.name, self.vehicle, settings.base, __version__
        )
        self._alerts: dict[int, str] = {}
        self._allowance = Allowance(EVENTS_PER_SECOND)
        self._measured = float("-inf")
        self.state.pressing = self.pressed.set
        gateway.observers += [self.state, self]
        self._discover({kind.id: kind.name for kind in _kinds(KINDS[self.vehicle])})

    # What happens -------------------------------------------------------------------------------------------

    def frames_received(self, frames: Sequence[Frame], now: float) -> None:
        """From the bus."""

    def effect(self, effect: Effect, now: float) -> None:
        """Something was said, transmitted or happened. Runs once an effect: written for speed."""
        if not isinstance(effect, UNTOLD) and self._allowance.take(now):
            shown = Told(effect, now).shown
            self.happened(shown.kind, shown.text)

    def port(self, name: str, connected: bool, now: float) -> None:
        """A link came or went, which stands among the links."""
        self.pressed.set()

    def happened(self, kind: str, text: str) -> None:
        """Tell of it."""
        self.say(mqtt.EVENT, mqtt.Happened(kind, text))

    def answered(self, answer: mqtt.Answer) -> None:
        """Tell what became of an order."""
        self.say(mqtt.ANSWER, answer)

    def rejected(self, reason: str) -> None:
        """Tell of what was meant as an order and is none."""
        self.happened("refused", reason)

    def say(self, key: str, document: mqtt.Document) -> None:
        """Publish something that does not stand."""
        self._board.tell(self.topic(key), mqtt.written(document))
        self.pressed.set()

    # How it stands ------------------------------------------------------------------------------------------

    def topic(self, key: str) -> str:
        """The topic with this last level."""
        return f"{self._mqtt.base}/{key}"

    def look(self, now: float) -> None:
        """See how everything stands at `now` (s)."""
        topics = self.state.topics(now)
        told = documents.states(topics, self.vehicle, now)
        if now >= self._measured + self._mqtt.interval - SOONEST:
            self._measured = now
            told |= documents.values(topics, self.vehicle)
        for key, document in told.items():
            self._board.put(self.topic(key), mqtt.written(document))
        room = len(self._alerts) < ALERTS_MAX
        standing = {alert.id: alert.name for alert in topics["alerts"] if room or alert.id in self._alerts}
        if any(self._alerts.get(number) != name for number, name in standing.items()):
            self._discover(standing)

    def _discover(self, alerts: dict[int, str]) -> None:
        """Let Home Assistant know what there is; of an alert that only others know from when it first stands."""
        self._alerts |= alerts
        if self._mqtt.discovery is None:
            return
        wanted = discovery(self._device, self._mqtt.discovery, self._alerts, self._mqtt.station)
        for topic, config in wanted.items():
            self._board.put(topic, b"" if config is None else msgspec.json.encode(config))


class Broker:
    """The connection to one broker."""

    def __init__(self, gateway: Gateway, settings: Mqtt, configuration: Configuration) -> None:
        self.counts: Counter[str] = Counter()
        self.ending = False
        """Whether a broker that is lost is left alone."""
        self._mqtt = settings
        self._gateway = gateway
        self._board = Board()
        self._bulletin = Bulletin(self._board, settings, gateway, configuration)
        self._orders = _orders(gateway, configuration, self._bulletin)
        self._guard = gateway.guarded
        gateway.health.watch("MQTT", lambda: self.counts | {"events dropped": self._board.dropped})

    async def run(self) -> None:
        """Until cancelled at the end."""
        pause = FIRST_PAUSE
        while not self.ending:
            try:
                async with self._client() as client:
                    pause = FIRST_PAUSE
                    await self._talk(client)
            except* (aiomqtt.MqttError, OSError) as faults:
                self._lost(_first(faults), pause)
            if not self.ending:
                await asyncio.sleep(pause)
            pause = min(2 * pause, LAST_PAUSE)

    def _lost(self, fault: BaseException, pause: float) -> None:
        if not self.ending:
            self._gateway.health.link("MQTT", False, f"{self._mqtt.place.host}: {fault}; again in {pause:g} s")

    def _client(self) -> aiomqtt.Client:
        place, properties = self._mqtt.place, Properties(PacketTypes.CONNECT)  # type: ignore[no-untyped-call]
        properties.MaximumPacketSize = MESSAGE_MAX
        return aiomqtt.Client(
            place.host,
            place.port,
            username=place.user,
            password=place.password,
            identifier=f"timonel_{secrets.token_hex(8)}",  # two of one name would throw each other out
            protocol=aiomqtt.ProtocolVersion.V5,
            will=aiomqtt.Will(self._bulletin.topic(mqtt.AVAILABILITY), mqtt.OFFLINE, qos=1, retain=True),
            keepalive=KEEP_ALIVE,
            timeout=WITHIN,
            max_queued_incoming_messages=ORDERS_WAITING,
            properties=properties,
            tls_context=ssl.create_default_context(cafile=self._mqtt.authorities) if place.encrypted else None,
            logger=logging.getLogger("timonel.mqtt"),
        )

    async def _talk(self, client: aiomqtt.Client) -> None:
        self._gateway.health.link("MQTT", True, f"{self._mqtt.place.host}:{self._mqtt.place.port}")
        self.counts["connections"] += 1
        self._board.forget()
        try:
            async with asyncio.TaskGroup() as both:
                both.create_task(self._tell(client), name="MQTT tells")
                both.create_task(self._hear(client), name="MQTT hears")
        finally:
            client.timeout = END_WITHIN
            with suppress(aiomqtt.MqttError):
                await self._say_that_we_are(client, mqtt.OFFLINE)

    async def _tell(self, client: aiomqtt.Client) -> None:
        """How everything stands, and then that we are here."""
        await self._publish(client)
        await self._say_that_we_are(client, mqtt.ONLINE)
        while True:
            await asyncio.sleep(SOONEST)
            with suppress(TimeoutError):
                async with asyncio.timeout(self._pause):
                    await self._bulletin.pressed.wait()
            await self._publish(client)

    @property
    def _pause(self) -> float:
        waiting = self._orders is not None and self._orders.waiting
        return max(0.0, min(self._mqtt.interval, DECIDE_EVERY if waiting else self._mqtt.interval) - SOONEST)

    async def _publish(self, client: aiomqtt.Client) -> None:
        self._bulletin.pressed.clear()
        now = self._gateway.now
        self._guard("MQTT", self._bulletin.look, now)
        if self._orders is not None:
            self._guard("MQTT", self._orders.look, now)
        while (news := self._board.next()) is not None:
            await client.publish(news.topic, news.payload, retain=news.retained)
            self._board.told(news)
            self.counts["published"] += 1

    async def _say_that_we_are(self, client: aiomqtt.Client, word: str) -> None:
        await client.publish(self._bulletin.topic(mqtt.AVAILABILITY), word, qos=1, retain=True)

    async def _hear(self, client: aiomqtt.Client) -> None:
        """Orders, where a station is paired; without one, nothing until the broker is gone."""
        if self._orders is None:
            async for _ in client.messages:
                pass
        else:
            await self._obey(client, self._orders)

    async def _obey(self, client: aiomqtt.Client, orders: Orders) -> None:
        await client.subscribe(self._bulletin.topic(mqtt.ORDER), options=NO_ECHO)
        orders.plug(True)
        try:
            async for message in client.messages:
                self.counts["orders"] += 1
                payload = message.payload if isinstance(message.payload, bytes) else b""
                self._guard("MQTT", orders.hear, payload, message.retain, self._gateway.now)
        finally:
            orders.plug(False)


def _first(faults: BaseExceptionGroup[BaseException]) -> BaseException:
    fault: BaseException = faults
    while isinstance(fault, BaseExceptionGroup):
        fault = fault.exceptions[0]
    return fault


def _kinds(module: ModuleType) -> Iterator[AlertKind]:
    """The alerts that a vehicle declares."""
    return (each for each in vars(module).values() if isinstance(each, AlertKind))


def _state(gateway: Gateway, configuration: Configuration) -> tuple[State, mqtt.Vehicle]:
    match gateway.vehicle:
        case Boat() as boat:
            return BoatState(gateway, configuration, boat), "boat"
        case Rover() as rover:
            return RoverState(gateway, configuration, rover), "rover"
    raise AssertionError("a gateway is of a boat or of a rover")


def _orders(gateway: Gateway, configuration: Configuration, bulletin: Bulletin) -> Orders | None:
    """None where no station is paired."""
    port = configuration.broker_port
    if port is None or port.station is None:
        return None
    link = next(channel.receive for channel in gateway.channels if channel.name == port.name)
    assert isinstance(link, InnerLink)
    match gateway.vehicle:
        case Boat() as boat:
            said: BoatPort | RoverPort = BoatPort(port.station, link, bulletin.state, gateway, boat)
        case Rover() as rover:
            said = RoverPort(port.station, link, bulletin.state, gateway, rover)
        case _:
            raise AssertionError("a gateway is of a boat or of a rover")
    return Orders(bulletin.vehicle, said, bulletin.answered, bulletin.rejected)
