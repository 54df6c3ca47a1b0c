"""Alerts: conditions that people must know of, with priority and acknowledgement.

Priorities and states follow IMO MSC.302(87) bridge alert management: an alarm or warning stands out until it
is acknowledged and stays visible until it is rectified; one that is rectified before anybody acknowledged it
stays until somebody does; silencing lasts 30 s and an unacknowledged one then sounds again; a caution needs no
acknowledgement. The state is one for all stations: who acknowledges, acknowledges for everybody.
"""

from enum import IntEnum

import msgspec

from timonel.core.effects import Event

SILENCE_SECONDS = 30.0


class Priority(IntEnum):
    """Urgency, most urgent first."""

    EMERGENCY = 1
    ALARM = 2
    WARNING = 3
    CAUTION = 4


class AlertKind(msgspec.Struct, frozen=True, gc=False):
    """A condition that can arise: a number for sentences, a name for people and its priority."""

    id: int
    name: str
    priority: Priority


class Alert(msgspec.Struct, frozen=True, gc=False):
    """One condition as it stands. `active` is whether it still holds; `since` is when it arose, in s."""

    kind: AlertKind
    text: str
    since: float
    active: bool = True
    acknowledged: bool = False
    silenced_until: float | None = None


class AlertChanged(Event, frozen=True, gc=False):
    """An alert arose, was acknowledged, silenced, sounded again or was rectified."""

    alert: Alert


class Alerts:
    """All alerts of a vehicle, by number."""

    def __init__(self) -> None:
        self._alerts: dict[int, Alert] = {}

    @property
    def standing(self) -> list[Alert]:
        """What people must still see, most urgent first, then the oldest first."""
        return sorted(self._alerts.values(), key=lambda alert: (alert.kind.priority, alert.since))

    def active(self, kind: AlertKind) -> bool:
        """Whether the condition holds now."""
        alert = self._alerts.get(kind.id)
        return alert is not None and alert.active

    def arise(self, kind: AlertKind, text: str, now: float) -> list[Event]:
        """The condition holds from now on. One that holds already changes nothing."""
        if self.active(kind):
            return []
        alert = Alert(kind, text, now, acknowledged=kind.priority is Priority.CAUTION)
        return self._store(alert)

    def rectify(self, kind: AlertKind) -> list[Event]:
        """The condition no longer holds."""
        if not self.active(kind):
            return []
        alert = msgspec.structs.replace(self._alerts[kind.id], active=False)
        return self._drop(alert) if alert.acknowledged else self._store(alert)

    def acknowledge(self, id: int) -> list[Event]:
        """Somebody has seen it. Unknown or acknowledged already: nothing happens."""
        alert = self._alerts.get(id)
        if alert is None or alert.acknowledged:
            return []
        alert = msgspec.structs.replace(alert, acknowledged=True, silenced_until=None)
        return self._store(alert) if alert.active else self._drop(alert)

    def silence(self, id: int, now: float) -> list[Event]:
        """Quiet for 30 s, without acknowledging."""
        alert = self._alerts.get(id)
        if alert is None or alert.acknowledged:
            return []
        return self._store(msgspec.structs.replace(alert, silenced_until=now + SILENCE_SECONDS))

    @property
    def deadline(self) -> float | None:
        """When the next silenced alert sounds again."""
        if not self._alerts:
            return None
        return min((a.silenced_until for a in self._alerts.values() if a.silenced_until is not None), default=None)

    def expire(self, now: float) -> list[Event]:
        """Let sound again what was silenced long enough."""
        due = [a for a in self._alerts.values() if a.silenced_until is not None and a.silenced_until <= now]
        return [e for alert in due for e in self._store(msgspec.structs.replace(alert, silenced_until=None))]

    def _store(self, alert: Alert) -> list[Event]:
        self._alerts[alert.kind.id] = alert
        return [AlertChanged(alert)]

    def _drop(self, alert: Alert) -> list[Event]:
        del self._alerts[alert.kind.id]
        return [AlertChanged(alert)]
