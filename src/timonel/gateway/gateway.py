"""The one loop: what links hear is told to the vehicle, and what the vehicle wants done is done.

```
heard                      told to the vehicle        done with what it answers
frames from the bus        receive_frames             Transmit     on the bus, at once
bytes from a port          receive_bytes              Say, urgent  to the OUT links, at once and ahead of data
a port came or went        port_changed               Say          to the OUT links, when `flush` says
its deadline has come      expire                     Event        to health, the log and the observers
```
Data lines go out at the end of the batch that brought them about, or with `flush` > 0 together every so many
seconds, which costs less where there are many listeners. One line is one object for all links.

A fault in our own code is logged with the name of the link whose input it came from, and the rest goes on: a
display sentence that cannot be made must not take the wheel out of anybody's hands. When `FAULTS` of them come
within `FAULT_WINDOW` seconds the vehicle's state is not to be trusted any more, and the gateway ends by itself,
so that its supervisor starts it anew: in STANDBY with nobody in command, and without a word to the pilot, which
keeps its course until a station takes command.

The machine's time is the loop's in whole microseconds, so that a recording can hold it. A recorder is told what the
vehicle is told before the vehicle, and what it answers before that is carried out.

What runs once a frame is written for speed here.
"""

import asyncio
import logging
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Protocol

import msgspec

from timonel.core.effects import Effect, Event, Say, SayTo, Transmit
from timonel.core.frame import Frame
from timonel.gateway.health import Health
from timonel.gateway.moment import moment
from timonel.links.fan import Fan, is_fanned
from timonel.links.link import BusLink, ByteLink, Link
from timonel.links.shaped import Shaped
from timonel.vehicles.vehicle import Vehicle

FAULTS = 10
FAULT_WINDOW = 10.0  # s
RETRY = 0.1  # s until what is due is tried again after a fault
SOONEST = 0.001  # s: a deadline that has passed already must not keep the loop from everything else

logger = logging.getLogger("timonel")


class Channel(msgspec.Struct, frozen=True):
    """A station or listener with its links.

    `receive` is what commands come from, None for listeners; `send` is what hears, None for nothing. One link that
    does both is the same in both places. What a listener says is heard by nobody.
    """

    name: str
    receive: ByteLink | None
    send: ByteLink | None


class Connection(msgspec.Struct, frozen=True):
    """How a link stands: whether it is connected, why or in what state, and since when, s."""

    connected: bool
    reason: str
    since: float


class Observer(Protocol):
    """Sees everything that goes through, after it has gone through; `now` is the loop's time."""

    def frames_received(self, frames: Sequence[Frame], now: float) -> None:
        """From the bus."""

    def effect(self, effect: Effect, now: float) -> None:
        """Something was said, transmitted or happened."""

    def port(self, name: str, connected: bool, now: float) -> None:
        """A link, by its name, came or went."""


class Recorder(Protocol):
    """Takes down what the vehicle is told and what it answers, in order; see `timonel.gateway.recorder`."""

    def frames_received(self, frames: Sequence[Frame], now: float) -> None: ...
    def bytes_received(self, port: str, data: bytes, now: float) -> None: ...
    def port_changed(self, port: str, connected: bool, now: float) -> None: ...
    def expired(self, now: float) -> None: ...
    def answered(self, effects: Sequence[Effect], now: float) -> None: ...
    def note(self, kind: str, now: float, **fields: Any) -> None: ...


class Gateway:
    """A vehicle, its bus and its channels on the running loop. Made, opened and closed on that loop.

    `began` is the time that the vehicle was made at, s.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        bus: BusLink,
        channels: Sequence[Channel],
        *,
        flush: float = 0.0,
        began: float = 0.0,
    ) -> None:
        self.vehicle = vehicle
        self.began = began
        self.bus = bus
        self.channels = tuple(channels)
        self.health = Health()
        self.observers: list[Observer] = []
        self.recorder: Recorder | None = None
        self.connections: dict[str, Connection] = {}
        """How each link stands, by name; one that has not told yet is not in it."""
        self.failed = asyncio.Event()
        """Set when there were too many faults; the gateway should be closed then."""
        self._flush_after = flush
        outs = [channel.send for channel in channels if channel.send is not None]
        self._fan = Fan([link for link in outs if is_fanned(link)])
        self._apart = [link for link in outs if not is_fanned(link)]
        self._attached: list[tuple[ByteLink, Callable[[bytes], None]]] = []
        self._pending: list[Say] = []
        self._flush_timer: asyncio.TimerHandle | None = None
        self._deadline_timer: asyncio.TimerHandle | None = None
        self._armed_for = float("inf")
        self._faults: deque[float] = deque(maxlen=FAULTS)
        self._loop = asyncio.get_running_loop()
        self._closing = False
        for link in self.links:
            self.health.watch(link.name, partial(_counters, link))

    @property
    def links(self) -> list[Link]:
        """Every link once."""
        links: list[Link] = [self.bus]
        for channel in self.channels:
            links += [link for link in (channel.receive, channel.send) if link is not None]
        links += [link for link, _ in self._attached]
        return list({id(link): link for link in links}.values())

    @property
    def now(self) -> float:
        """The machine's time, s."""
        return moment(self._loop.time())

    def attach(self, link: ByteLink, receive: Callable[[bytes], None]) -> None:
        """One more link, opened and closed with the others; its bytes are not for the vehicle but for `receive`."""
        self._attached.append((link, receive))
        self.health.watch(link.name, partial(_counters, link))

    def inject(self, source: str, frames: list[Frame]) -> None:
        """Frames of somebody who may put them on the bus; the vehicle hears them as all that is on the bus."""
        self._feed(source, self._injected, frames)

    def happened(self, events: Sequence[Event]) -> None:
        """Something that is worth telling, beside what the vehicle notices."""
        now = self.now
        for event in events:
            self.health.event(event, now)
        self._show(partial(_show_effects, events, now))

    # Life ------------------------------------------------------------------------------------------------

    async def open(self) -> None:
        """Open all links at once; one that cannot be reached yet keeps none of the others waiting."""
        self._arm(self.vehicle.deadline)
        attached = (self._open_attached(link, receive) for link, receive in self._attached)
        await asyncio.gather(self._open_bus(), *map(self._open_channel, self.channels), *attached)

    async def _open_bus(self) -> None:
        name = self.bus.name
        changed = partial(self._feed, name, self._link_changed, name)
        await self.bus.open(self._bus_heard, changed)

    async def _open_channel(self, channel: Channel) -> None:
        if channel.receive is not None:
            name = channel.receive.name
            receive = partial(self._feed, name, self._bytes_received, channel.name)
            await channel.receive.open(receive, partial(self._feed, name, self._port_changed, channel.name, name))
        if channel.send is not None and channel.send is not channel.receive:
            name = channel.send.name
            await channel.send.open(_unheard, partial(self._feed, name, self._link_changed, name))

    async def _open_attached(self, link: ByteLink, receive: Callable[[bytes], None]) -> None:
        changed = partial(self._feed, link.name, self._link_changed, link.name)
        await link.open(partial(self._attached_heard, link.name, receive), changed)

    async def close(self, drain: float = 0.5) -> None:
        """End: send what is waiting, for at most `drain` seconds, and close all links.

        The pilot is left as it is; who restarts a gateway under way does not want the helm to drop.
        """
        self._closing = True
        for timer in (self._deadline_timer, self._flush_timer):
            if timer is not None:
                timer.cancel()
        self._flush()
        await asyncio.gather(*(link.close(drain) for link in self.links))

    # In --------------------------------------------------------------------------------------------------

    def _bus_heard(self, frames: list[Frame]) -> None:
        """Once a wake-up: what `_feed` does with `_frames_received`, with fewer steps."""
        if self._closing:
            return
        now = moment(self._loop.time())
        if not self._guarded(self.bus.name, self._answer_frames, frames, now):
            self._faulted(self.bus.name, now)

    def _answer_frames(self, frames: list[Frame], now: float) -> None:
        if effects := self._frames_received(frames, now):
            if self.recorder is not None:
                self._record(self.recorder.answered, effects, now)
            self._carry_out(effects, now)
        if (deadline := self.vehicle.deadline) < self._armed_for:
            self._arm(deadline)

    def _frames_received(self, frames: list[Frame], now: float) -> list[Effect]:
        if self.observers:
            self._show(lambda observer: observer.frames_received(frames, now))
        if self.recorder is not None:
            self._record(self.recorder.frames_received, frames, now)
        return self.vehicle.receive_frames(frames, now)

    def _injected(self, frames: list[Frame], now: float) -> list[Effect]:
        self.bus.send(frames)
        return self._frames_received(frames, now)

    def _attached_heard(self, name: str, receive: Callable[[bytes], None], data: bytes) -> None:
        if not self._closing:
            self._guarded(name, receive, data)

    def _bytes_received(self, port: str, data: bytes, now: float) -> list[Effect]:
        if self.recorder is not None:
            self._record(self.recorder.bytes_received, port, data, now)
        return self.vehicle.receive_bytes(port, data, now)

    def _port_changed(self, port: str, name: str, connected: bool, reason: str, now: float) -> list[Effect]:
        self._link_changed(name, connected, reason, now)
        if self.recorder is not None:
            self._record(self.recorder.port_changed, port, connected, now)
        return self.vehicle.port_changed(port, connected, now)

    def _link_changed(self, name: str, connected: bool, reason: str, now: float) -> list[Effect]:
        self.health.link(name, connected, reason)
        self.connections[name] = Connection(connected, reason, now)
        if self.recorder is not None:
            self._record(partial(self.recorder.note, link=name, connected=connected, reason=reason), "Link", now)
        self._show(lambda observer: observer.port(name, connected, now))
        return []

    def _expire(self) -> None:
        self._armed_for = float("inf")
        self._feed("timer", self._expired)

    def _expired(self, now: float) -> list[Effect]:
        if self.recorder is not None:
            self._record(self.recorder.expired, now)
        return self.vehicle.expire(now)

    def _feed(self, source: str, tell: Callable[..., list[Effect]], *what: Any) -> None:
        """Tell the vehicle what came from `source`, and do what it answers."""
        if self._closing:
            return
        now = self.now
        if not self._guarded(source, self._tell, tell, what, now):
            self._faulted(source, now)

    def _tell(self, tell: Callable[..., list[Effect]], what: Sequence[Any], now: float) -> None:
        if effects := tell(*what, now):
            if self.recorder is not None:
                self._record(self.recorder.answered, effects, now)
            self._carry_out(effects, now)
        self._arm(self.vehicle.deadline)

    def _guarded(self, source: str, act: Callable[..., object], *what: Any) -> bool:
        """Whether `act` came to its end. The only place that catches everything."""
        try:
            act(*what)
        except Exception:  # noqa: BLE001 - whatever it is, the other stations must go on
            self.health.fault(source)
            return False
        return True

    def guarded(self, source: str, act: Callable[..., object], *what: Any) -> bool:
        """Do what is beside the vehicle's business; whether it came to its end. A fault is logged and counted."""
        return self._guarded(source, act, *what)

    def _record(self, write: Callable[..., None], *what: Any) -> None:
        """Write something down; a recorder that cannot write without falling over is told no more."""
        if not self._guarded("recorder", write, *what):
            self.recorder = None

    def _arm(self, deadline: float) -> None:
        """See to it that `expire` is called at `deadline`; a timer that rings earlier is left to ring."""
        if deadline >= self._armed_for:
            return
        if self._deadline_timer is not None:
            self._deadline_timer.cancel()
        self._armed_for = deadline
        self._deadline_timer = self._loop.call_at(max(deadline, self._loop.time() + SOONEST), self._expire)

    def _faulted(self, source: str, now: float) -> None:
        if self.recorder is not None:
            self._record(partial(self.recorder.note, source=source), "Fault", now)
        self._faults.append(now)
        if len(self._faults) == FAULTS and now - self._faults[0] < FAULT_WINDOW:
            logger.critical("%d faults within %g s: giving up", FAULTS, FAULT_WINDOW)
            self.failed.set()
        self._arm(now + RETRY)

    # Out -------------------------------------------------------------------------------------------------

    def _carry_out(self, effects: Sequence[Effect], now: float) -> None:
        frames: list[Frame] = []
        urgent: list[Say] = []
        for effect in effects:
            if type(effect) is Say:
                (urgent if effect.urgent else self._pending).append(effect)
            elif type(effect) is Transmit:
                frames.append(effect.frame)
            elif type(effect) is SayTo:
                self._say_to(effect)
            else:
                self.health.event(effect, now)
        if frames:
            self.bus.send(frames)
        if urgent:
            self._send(urgent)
        if self._pending:
            if not self._flush_after:
                lines, self._pending = self._pending, []
                self._send(lines)
            elif self._flush_timer is None:
                self._flush_timer = self._loop.call_later(self._flush_after, self._flush)
        if self.observers:
            self._show(partial(_show_effects, effects, now))

    def _flush(self) -> None:
        self._flush_timer = None
        if lines := self._pending:
            self._pending = []
            self._send(lines)

    def _send(self, lines: list[Say]) -> None:
        self._fan.send(lines)
        for link in self._apart:
            link.send(lines)

    def _say_to(self, order: SayTo) -> None:
        """One line for one port, whatever its listeners are told of the rest."""
        line = Say(order.line, order.key, urgent=True, state=True)
        for channel in self.channels:
            if channel.name == order.port and channel.send is not None:
                link = channel.send
                (link.send_whatever if isinstance(link, Shaped) else link.send)([line])

    def _show(self, show: Callable[[Observer], object]) -> None:
        """Let the observers see something; one that cannot look without falling over sees no more."""
        self.observers = [
            observer for observer in self.observers if self._guarded(type(observer).__name__, show, observer)
        ]


def _show_effects(effects: Sequence[Effect], now: float, observer: Observer) -> None:
    for effect in effects:
        observer.effect(effect, now)


def _counters(link: Link) -> dict[str, int]:
    return msgspec.structs.asdict(link.counters)


def _unheard(_: bytes) -> None:
    """What a listener says."""
