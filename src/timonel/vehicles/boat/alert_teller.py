"""Tells the bus of our alerts: when they change, and over and over while they stand."""

from typing import Any

from timonel.core.alerts import Alert
from timonel.core.message import Message
from timonel.nmea2000.lookups import AlertCategory
from timonel.vehicles.boat import alert_messages
from timonel.vehicles.boat.alert_messages import NO_NAME
from timonel.vehicles.boat.alerts import NAVIGATIONAL

BUS_INTERVAL = 1.0  # s between two tellings of an alert on the bus, as N2KView does
TEXT_EVERY = 10  # tellings
AT_ONCE = 10  # alerts told in one go; if more stand, each comes less often
FAREWELLS = 3  # tellings that an alert is over
OCCURRENCES = 250


class Told:
    """An alert of ours on the bus: how often it arose, who acknowledged it, and how often it was told."""

    __slots__ = ("acknowledged_by", "alert", "farewells", "occurrence", "since", "tellings")

    def __init__(self, alert: Alert) -> None:
        self.alert = alert
        self.occurrence = 0
        self.since: float | None = None
        self.acknowledged_by = NO_NAME
        self.farewells = 0
        self.tellings = 0


class BusTeller:
    """126983 and 126985 of every alert that is ours."""

    def __init__(self, now: float) -> None:
        self._told: dict[int, Told] = {}
        self._next = 0
        self._due = now

    def changed(self, alert: Alert, name: int, now: float) -> list[Message]:
        """An alert as it stands after a change. `name` is our own NAME."""
        if not self._standing:
            self._due = now + BUS_INTERVAL
        told = self._told.setdefault(alert.kind.id, Told(alert))
        named = told.since == alert.since and (told.alert.kind, told.alert.text) == (alert.kind, alert.text)
        if told.since != alert.since:
            told.since, told.acknowledged_by = alert.since, NO_NAME
            told.occurrence = told.occurrence % OCCURRENCES + 1
        if alert.acknowledged and told.acknowledged_by == NO_NAME:
            told.acknowledged_by = name
        told.alert = alert
        if not named:
            told.tellings = 0
        told.farewells = 0 if alert.active or not alert.acknowledged else FAREWELLS
        return [self._state(told, name)] if named else [self._state(told, name), self._words(told, name)]

    def acknowledged_by(self, number: int, name: int) -> None:
        """Who is about to acknowledge an alert that was told."""
        self._told[number].acknowledged_by = name

    def forget(self, number: int) -> None:
        """The number is no longer of an alert that is ours to tell."""
        self._told.pop(number, None)

    def occurrence(self, number: int) -> int | None:
        """How often an alert arose; None for one that was never told."""
        told = self._told.get(number)
        return None if told is None else told.occurrence

    @property
    def _standing(self) -> list[Told]:
        return [
            told for told in self._told.values() if told.farewells or told.alert.active or not told.alert.acknowledged
        ]

    @property
    def deadline(self) -> float:
        """When `expire` is due, s."""
        return self._due if self._standing else float("inf")

    def expire(self, name: int, now: float) -> list[Message]:
        """What is to be told again, the longest untold first."""
        standing = self._standing
        if not standing or now < self._due:
            return []
        self._due = now + BUS_INTERVAL
        first = self._next % len(standing)
        turn = (standing[first:] + standing[:first])[:AT_ONCE]
        self._next = first + len(turn)
        return [message for told in turn for message in self._again(told, name)]

    def _again(self, told: Told, name: int) -> list[Message]:
        told.farewells = max(0, told.farewells - 1)
        told.tellings += 1
        words = [self._words(told, name)] if told.tellings % TEXT_EVERY == 0 else []
        return [self._state(told, name), *words]

    def _state(self, told: Told, name: int) -> Message:
        return alert_messages.told(told.alert, self._begin(told, name), told.acknowledged_by)

    def _words(self, told: Told, name: int) -> Message:
        return alert_messages.told_in_words(told.alert, self._begin(told, name))

    def _begin(self, told: Told, name: int) -> dict[str, Any]:
        number = told.alert.kind.id
        category = AlertCategory.NAVIGATIONAL if number in NAVIGATIONAL else AlertCategory.TECHNICAL
        return alert_messages.identity(told.alert, category, told.occurrence, name)
