"""The helm of a rover: whose word reaches the drives, and what becomes of a commander that is lost.

The protocol on the wire has no words for command, so it is implied (spec/rover.md, Driving):

frame                from the bridge (station 1)    from another station
100, or 101 = '1'    takes command                  requests command, and counts once it is granted
101, anything else   stops the drives               stops the drives
115, 119, 120        counts if in command           counts if in command

A request that the bridge leaves unanswered is denied, as each of its frames 100 and 101 takes command anew; one that
another commander leaves unanswered passes or is denied, as configured.

Explicit words come from consoles and programs by `say`. A commander that is silent for 2 s is released: unlike a
boat a rover stands still then, and somebody else may take over.
"""

from timonel.core.alerts import Alerts
from timonel.core.command import BRIDGE, NOBODY, CommandTransfer, OnTimeout, Transferred, Verb
from timonel.core.effects import Event, Refused
from timonel.vehicles.rover.alerts import LINK_LOST
from timonel.vehicles.rover.drive import SILENT, Drive, Permission, Stick, Stop

LOST = 2.0  # s
SILENCED = Permission(False, Stop.SILENT.value)


class Helm:
    """Command transfer, drives and alerts of a rover, told the time."""

    def __init__(
        self, now: float, *, request_timeout: float = 10.0, on_timeout: OnTimeout = OnTimeout.TRANSFER
    ) -> None:
        self.alerts = Alerts()
        self.transfer = CommandTransfer(timeout=request_timeout, on_timeout=on_timeout)
        self.drive = Drive(now)
        self._heard = now
        self._on_timeout = on_timeout

    # What stations say ----------------------------------------------------------------------------

    def heard(self, station: int, now: float, age: float = 0.0) -> list[Event]:
        """Any frame came in from the link of `station`, `age` s ago."""
        effects = self.expire(now)
        if station == self.transfer.commander:
            self._heard = now - age
            self.drive.heard(now, age)
        return effects

    def stick(self, stick: Stick, station: int, now: float, age: float = 0.0) -> list[Event]:
        """Frame 100."""
        effects = self._claim(station, now, age)
        if station != self.transfer.commander:
            return effects
        return effects + self.drive.stick(stick, station, now, age)

    def permission(self, granted: bool, station: int, now: float, age: float = 0.0) -> list[Event]:
        """Frame 101: motion is permitted, or stopped."""
        if not granted:
            return self.expire(now) + self.drive.stop(Stop.ORDERED, now)
        effects = self._claim(station, now, age)
        if station != self.transfer.commander:
            return effects
        permitted = self.drive.permit(station, now)
        return effects + permitted + (self.alerts.rectify(LINK_LOST) if self.drive.permitted else [])

    def speed_limit(self, steps: int, station: int, now: float) -> list[Event]:
        """Frame 119."""
        effects = self.expire(now)
        if station != self.transfer.commander:
            return [*effects, Refused("not in command", station)]
        return effects + self.drive.limit(steps, station)

    def say(self, verb: Verb, station: int, now: float) -> list[Event]:
        """An explicit word about command."""
        return self.expire(now) + self._passed(self.transfer.receive(verb, station, now), now)

    def _claim(self, station: int, now: float, age: float) -> list[Event]:
        """What a drive or permission frame says about command, by being sent at all."""
        effects = self.heard(station, now, age)
        if station == self.transfer.commander or station in self.transfer.queue:
            return effects
        verb = Verb.TAKE if station == BRIDGE else Verb.REQUEST
        return effects + self._passed(self.transfer.receive(verb, station, now), now)

    def _passed(self, effects: list[Event], now: float) -> list[Event]:
        for effect in effects:
            if isinstance(effect, Transferred):
                self._heard = now
                self.transfer.on_timeout = self._policy(self.transfer.commander)
                found = [] if effect.commander == NOBODY else self.alerts.rectify(LINK_LOST)
                return effects + found + self.drive.passes(now)
        return effects

    def _policy(self, commander: int) -> OnTimeout:
        """What an unanswered request comes to. A bridge that does not speak either is lost long before."""
        return OnTimeout.DENY if commander == BRIDGE else self._on_timeout

    # Time -----------------------------------------------------------------------------------------

    @property
    def deadline(self) -> float:
        """When `expire` is due."""
        lost = None if self.transfer.commander == NOBODY else self._heard + LOST
        times = (self.drive.deadline, self.transfer.deadline, self.alerts.deadline, lost)
        return min(time for time in times if time is not None)

    def expire(self, now: float) -> list[Event]:
        """What the passing of time brings about."""
        if now < self.deadline:
            return []
        effects = self._watched(self.drive.expire(now), now) + self.alerts.expire(now)
        if self.transfer.commander != NOBODY and now >= self._heard + LOST:
            released = self.transfer.receive(Verb.RELEASE, self.transfer.commander, now)
            effects += self._passed(released, now)
        return effects + self._passed(self.transfer.expire(now), now)

    def _watched(self, effects: list[Event], now: float) -> list[Event]:
        """Who falls silent while driving is an alarm; who had stopped before may go."""
        if SILENCED not in effects:
            return effects
        text = f"station {self.transfer.commander} was driving and has not been heard for {SILENT:g} s"
        return effects + self.alerts.arise(LINK_LOST, text, now)
