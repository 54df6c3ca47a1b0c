"""What people are shown: the topics of a vehicle, worked out from its machine and from what happens.

An observer of the gateway. What comes once a frame is only counted and kept; all else is worked out when somebody
asks for `topics`, once for all who look.
"""

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from math import isfinite
from typing import Any, overload

from timonel.core.alerts import Alert, AlertChanged
from timonel.core.alerts import Priority as AlertPriority
from timonel.core.command import NOBODY, CommandTransfer, Denied, Overridden, Requested, Transferred
from timonel.core.effects import Effect, Refused, Rejected, Say, SayTo, SecurityEvent, Transmit
from timonel.core.frame import Frame
from timonel.gateway.configuration import Configuration
from timonel.gateway.gateway import Gateway
from timonel.gateway.health import describe
from timonel.links.inner import InnerLink
from timonel.vehicles.boat.pilot import PilotChanged, Steer
from timonel.vehicles.boat.pilots.driver import Progressed
from timonel.vehicles.rover.drive import Permission, Wheels
from timonel.web.messages import (
    AlertState,
    CommandState,
    EventKind,
    Happening,
    LinkKind,
    LinkState,
    Measured,
    Priority,
    Quality,
    StationState,
    Waiting,
)

Topics = dict[str, Any]

EVENTS_SHOWN = 20
PRIORITIES: dict[AlertPriority, Priority] = {
    AlertPriority.EMERGENCY: "alarm",
    AlertPriority.ALARM: "alarm",
    AlertPriority.WARNING: "warning",
    AlertPriority.CAUTION: "caution",
}
KINDS: dict[type[Effect], EventKind] = {
    Transferred: "command",
    Requested: "command",
    Denied: "command",
    Overridden: "command",
    PilotChanged: "pilot",
    Permission: "drive",
    AlertChanged: "alert",
    Refused: "refused",
    Rejected: "other",
    SecurityEvent: "security",
}
PRESSING = (Transferred, Requested, Denied, Overridden, PilotChanged, Permission, AlertChanged)
"""What people should see at once."""
UNTOLD = (Say, SayTo, Transmit, Steer, Progressed, Wheels)


class Told:
    """An event that happened `times` times in a row."""

    __slots__ = ("at", "event", "times")

    def __init__(self, event: Effect | str, at: float) -> None:
        self.event = event
        self.at = at
        self.times = 1

    @property
    def shown(self) -> Happening:
        """For people."""
        if isinstance(self.event, str):
            return Happening(seconds(self.at), self.event, "link", self.times)
        kind = KINDS.get(type(self.event), "other")
        return Happening(seconds(self.at), describe(self.event), kind, self.times)


class State:
    """What both vehicles show. `pressing` is called when something should be shown at once."""

    def __init__(self, gateway: Gateway, configuration: Configuration) -> None:
        self.names = configuration.names
        self.pressing: Callable[[], object] = _nothing
        self.consoles: Callable[[int], int] = _none
        self._gateway = gateway
        self._configuration = configuration
        self._alerts: dict[int, Alert] = {}
        self._told: deque[Told] = deque(maxlen=EVENTS_SHOWN)
        self._listener: list[Effect] | None = None
        self._kinds = dict(_kinds(gateway))
        self._wires = {
            station.port.station: station.port.name
            for station in configuration.stations
            if station.port.station is not None
        }

    # What happens -------------------------------------------------------------------------------------

    def frames_received(self, frames: Sequence[Frame], now: float) -> None:
        """From the bus."""

    def effect(self, effect: Effect, now: float) -> None:
        """Something was said, transmitted or happened. Runs once an effect: written for speed."""
        if isinstance(effect, UNTOLD):
            return
        if self._listener is not None:
            self._listener.append(effect)
        self._tell(effect, now)
        if isinstance(effect, AlertChanged):
            self._keep(effect.alert)
        if isinstance(effect, PRESSING):
            self.pressing()

    def port(self, name: str, connected: bool, now: float) -> None:
        """A link came or went."""
        self._tell(f"{name}: {'connected' if connected else 'not connected'}", now)

    def _tell(self, event: Effect | str, now: float) -> None:
        if self._told and self._told[-1].event == event:
            self._told[-1].times += 1
            self._told[-1].at = now
        else:
            self._told.append(Told(event, now))

    def _keep(self, alert: Alert) -> None:
        if alert.active or not alert.acknowledged:
            self._alerts[alert.kind.id] = alert
        else:
            self._alerts.pop(alert.kind.id, None)

    @contextmanager
    def listening(self) -> Iterator[list[Effect]]:
        """What happens while it is entered."""
        heard: list[Effect] = []
        self._listener = heard
        try:
            yield heard
        finally:
            self._listener = None

    def alert(self, number: int) -> Alert | None:
        """An alert that people must still see."""
        return self._alerts.get(number)

    # What is shown ------------------------------------------------------------------------------------

    def topics(self, now: float) -> Topics:
        """Everything as it stands at `now` (s)."""
        return {
            "command": self._command(),
            "links": self._links(now),
            "alerts": self._standing(),
            "events": [told.shown for told in self._told],
        }

    @property
    def transfer(self) -> CommandTransfer:
        raise NotImplementedError

    def _command(self) -> CommandState:
        transfer = self.transfer
        return CommandState(
            transfer.commander,
            "" if transfer.commander == NOBODY else self.names[transfer.commander],
            [self._station(number) for number in self.names],
            [Waiting(number, self.names[number]) for number in transfer.queue],
            seconds(transfer.deadline),
            transfer.on_timeout.value,
        )

    def _station(self, number: int) -> StationState:
        wire = self._wires.get(number)
        state = None if wire is None else self._gateway.connections.get(wire)
        connected = None if wire is None else state is not None and state.connected
        return StationState(number, self.names[number], connected, self.consoles(number))

    def _links(self, now: float) -> list[LinkState]:
        return [self._link(name, kind) for name, kind in self._kinds.items()]

    def _link(self, name: str, kind: LinkKind) -> LinkState:
        state = self._gateway.connections.get(name)
        if state is None:
            return LinkState(name, kind, False, "", None)
        return LinkState(name, kind, state.connected, state.reason, seconds(state.since))

    def _standing(self) -> list[AlertState]:
        alerts = sorted(self._alerts.values(), key=lambda alert: (alert.kind.priority, alert.since))
        return [
            AlertState(
                alert.kind.id,
                alert.kind.name,
                alert.text,
                PRIORITIES[alert.kind.priority],
                alert.active,
                alert.acknowledged,
                seconds(alert.silenced_until),
                seconds(alert.since),
                alert.announced,
            )
            for alert in alerts
        ]

    # What is kept for an hour -------------------------------------------------------------------------

    def samples(self, topics: Mapping[str, Any]) -> dict[str, float | None]:
        """The values of `topics` whose course over time is worth keeping, by name; None where there is none."""
        raise NotImplementedError


def _kinds(gateway: Gateway) -> Iterator[tuple[str, LinkKind]]:
    yield gateway.bus.name, "bus"
    for channel in gateway.channels:
        if channel.receive is not None and not isinstance(channel.receive, InnerLink):
            yield channel.receive.name, "in"
        if channel.send is not None and channel.send is not channel.receive:
            yield channel.send.name, "out"


def _nothing() -> None:
    """Nobody looks."""


def _none(_: int) -> int:
    """No consoles."""
    return 0


@overload
def seconds(time: float) -> float: ...
@overload
def seconds(time: None) -> None: ...
@overload
def seconds(time: float | None) -> float | None: ...
def seconds(time: float | None) -> float | None:
    """A time as it is told: to the millisecond; None stays None."""
    return None if time is None else round(time, 3)


def quality(heard: float, now: float, age: float) -> Quality:
    """What a value is worth that was heard at `heard` and counts for `age` s."""
    if heard == float("-inf"):
        return "absent"
    return "fresh" if now - heard < age else "stale"


def finite(value: float | None, digits: int = 5) -> float | None:
    """A value as it is told; None for what is no number."""
    return round(value, digits) if value is not None and isfinite(value) else None


ABSENT = Measured(None, None, "absent")


def measured(value: float | None, heard: float, now: float, age: float) -> Measured:
    """A value that was heard at `heard` and counts for `age` s."""
    if value is None or heard == float("-inf"):
        return ABSENT
    return Measured(finite(value), seconds(heard), quality(heard, now, age))


def fresh(topic: Any, name: str = "value") -> float | None:
    """A value of a topic while it holds."""
    value: float | None = getattr(topic, name) if topic.quality == "fresh" else None
    return value
