"""Alerts: conditions that people must know of, with priority and acknowledgement.

Priorities and states follow IMO MSC.302(87) bridge alert management: an alarm or warning stands out until it
is acknowledged and stays visible until it is rectified; one that is rectified before anybody acknowledged it
stays until somebody does; silencing lasts 30 s and an unacknowledged one then sounds again; a caution needs no
acknowledgement. The state is one for all stations: who acknowledges, acknowledges for everybody.

What nobody acknowledges is announced again and again if the table is told how often (`Patience`), and a warning
may become an alarm so. Another system that takes responsibility for an alert makes it quiet like an
acknowledgement does.
"""

from enum import IntEnum
from typing import Any

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

    @property
    def announced(self) -> int:
        """How often it was announced again because nobody acknowledged it."""
        return 0

    @property
    def transferred(self) -> bool:
        """Whether another system has taken responsibility for it."""
        return False


class PressingAlert(Alert, frozen=True, gc=False):
    """An alert that was announced again, or for which another system is responsible."""

    announced: int = 0
    transferred: bool = False


class Patience(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """After how many seconds an unacknowledged alert is announced again, and a warning becomes an alarm.

    None is never. An emergency counts as an alarm.
    """

    alarm: float | None = None
    warning: float | None = None
    escalation: float | None = None


class AlertChanged(Event, frozen=True, gc=False):
    """An alert arose, was acknowledged, silenced, sounded again or was rectified."""

    alert: Alert


class Alerts:
    """All alerts of a vehicle, by number."""

    def __init__(self, patience: Patience | None = None) -> None:
        self._patience = patience or Patience()
        self._alerts: dict[int, Alert] = {}
        self._due: dict[int, float] = {}

    @property
    def standing(self) -> list[Alert]:
        """What people must still see, most urgent first, then the oldest first."""
        return sorted(self._alerts.values(), key=lambda alert: (alert.kind.priority, alert.since))

    def get(self, id: int) -> Alert | None:
        """The alert of a number while it stands."""
        return self._alerts.get(id)

    def active(self, kind: AlertKind) -> bool:
        """Whether the condition holds now."""
        alert = self._alerts.get(kind.id)
        return alert is not None and alert.active

    def arise(self, kind: AlertKind, text: str, now: float, acknowledged: bool = False) -> list[Event]:
        """The condition holds from now on. One that holds already changes nothing.

        `acknowledged` is one that somebody had acknowledged before we heard of it.
        """
        if self.active(kind):
            return []
        alert = Alert(kind, text, now, acknowledged=acknowledged or kind.priority is Priority.CAUTION)
        self._wait(alert, now)
        return self._store(alert)

    def reword(self, kind: AlertKind, text: str) -> list[Event]:
        """The alert of that number is of this name and priority, and `text` says more about it.

        A warning that became an alarm stays one.
        """
        alert = self._alerts.get(kind.id)
        if alert is None:
            return []
        if alert.announced:
            kind = msgspec.structs.replace(kind, priority=min(kind.priority, alert.kind.priority))
        if (alert.kind, alert.text) == (kind, text):
            return []
        return self._store(msgspec.structs.replace(alert, kind=kind, text=text))

    def rectify(self, kind: AlertKind) -> list[Event]:
        """The condition no longer holds."""
        if not self.active(kind):
            return []
        self._due.pop(kind.id, None)
        alert = msgspec.structs.replace(self._alerts[kind.id], active=False)
        return self._drop(alert) if alert.acknowledged else self._store(alert)

    def acknowledge(self, id: int) -> list[Event]:
        """Somebody has seen it. Unknown or acknowledged already: nothing happens."""
        alert = self._alerts.get(id)
        if alert is None or alert.acknowledged:
            return []
        self._due.pop(id, None)
        alert = msgspec.structs.replace(alert, acknowledged=True, silenced_until=None)
        return self._store(alert) if alert.active else self._drop(alert)

    def transfer(self, id: int) -> list[Event]:
        """Another system is responsible for it from now on. It is quiet, and stays while it holds."""
        alert = self._alerts.get(id)
        if alert is None or alert.acknowledged or not alert.active:
            return []
        self._due.pop(id, None)
        return self._store(_pressing(alert, acknowledged=True, silenced_until=None, transferred=True))

    def silence(self, id: int, now: float) -> list[Event]:
        """Quiet for 30 s, without acknowledging."""
        alert = self._alerts.get(id)
        if alert is None or alert.acknowledged:
            return []
        self._due.pop(id, None)
        return self._store(msgspec.structs.replace(alert, silenced_until=now + SILENCE_SECONDS))

    def forget(self, id: int) -> list[Event]:
        """It stands no longer, whatever its state."""
        alert = self._alerts.get(id)
        if alert is None:
            return []
        self._due.pop(id, None)
        return self._drop(msgspec.structs.replace(alert, active=False, acknowledged=True, silenced_until=None))

    @property
    def deadline(self) -> float | None:
        """When the next silenced alert sounds again, or an unacknowledged one is announced again."""
        if not self._alerts:
            return None
        silenced = [a.silenced_until for a in self._alerts.values() if a.silenced_until is not None]
        return min((*silenced, *self._due.values()), default=None)

    def expire(self, now: float) -> list[Event]:
        """Let sound again what was silenced long enough, and what nobody acknowledged."""
        due = [a for a in self._alerts.values() if a.silenced_until is not None and a.silenced_until <= now]
        return [e for alert in due for e in self._sound(alert, now)] + self._announce(now)

    def _sound(self, alert: Alert, now: float) -> list[Event]:
        alert = msgspec.structs.replace(alert, silenced_until=None)
        self._wait(alert, now)
        return self._store(alert)

    def _announce(self, now: float) -> list[Event]:
        due = [number for number, time in self._due.items() if time <= now]
        return [event for number in due for event in self._announce_again(self._alerts[number], now)]

    def _announce_again(self, alert: Alert, now: float) -> list[Event]:
        raised = self._raised_at(alert)
        kind = alert.kind
        if raised is not None and raised <= now:
            kind = msgspec.structs.replace(kind, priority=Priority.ALARM)
        alert = _pressing(alert, kind=kind, announced=alert.announced + 1)
        self._wait(alert, now)
        return self._store(alert)

    def _raised_at(self, alert: Alert) -> float | None:
        """When a warning becomes an alarm."""
        if alert.kind.priority is not Priority.WARNING or self._patience.escalation is None:
            return None
        return alert.since + self._patience.escalation

    def _wait(self, alert: Alert, now: float) -> None:
        """Set when an alert is announced again, if it is not acknowledged before."""
        if alert.acknowledged or not alert.active:
            return
        interval = self._patience.warning if alert.kind.priority is Priority.WARNING else self._patience.alarm
        times = (None if interval is None else now + interval, self._raised_at(alert))
        if due := [time for time in times if time is not None]:
            self._due[alert.kind.id] = min(due)
        else:
            self._due.pop(alert.kind.id, None)

    def _store(self, alert: Alert) -> list[Event]:
        self._alerts[alert.kind.id] = alert
        return [AlertChanged(alert)]

    def _drop(self, alert: Alert) -> list[Event]:
        del self._alerts[alert.kind.id]
        return [AlertChanged(alert)]


def _pressing(alert: Alert, **changes: Any) -> PressingAlert:
    values = {name: getattr(alert, name) for name in PressingAlert.__struct_fields__}
    return PressingAlert(**values | changes)
