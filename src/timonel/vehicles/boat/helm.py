"""The helm: who is in command and what the pilot does, as one machine.

Only this module lets a station's word through to the pilot, and only the commander's. It speaks no sentences
and no PGNs: `vehicle` translates both ways.
"""

from timonel.core.alerts import Alerts, Patience
from timonel.core.command import NOBODY, CommandTransfer, OnTimeout, Transferred, Verb
from timonel.core.effects import Event, Refused
from timonel.nmea0183 import parp
from timonel.vehicles.boat.alerts import NO_COMMANDER
from timonel.vehicles.boat.pilot import Mode, Pilot

TRANSFER = {
    parp.Verb.REQCMD: Verb.REQUEST,
    parp.Verb.RELCMD: Verb.RELEASE,
    parp.Verb.TAKECMD: Verb.TAKE,
    parp.Verb.ACKCMD: Verb.ACKNOWLEDGE,
    parp.Verb.DENYCMD: Verb.DENY,
}
TURNS = {  # tenths of a degree, starboard positive
    parp.Verb.PORTTEN: -100,
    parp.Verb.PORTONE: -10,
    parp.Verb.STBDONE: 10,
    parp.Verb.STBDTEN: 100,
}


class Helm:
    """Command transfer, pilot and alerts of a boat, told the time."""

    def __init__(
        self,
        now: float,
        *,
        request_timeout: float = 10.0,
        on_timeout: OnTimeout = OnTimeout.TRANSFER,
        patience: Patience | None = None,
    ) -> None:
        self.mute = False
        """Whether nothing can be said to the pilot, for want of an address on the bus."""
        self.alerts = Alerts(patience)
        self.transfer = CommandTransfer(timeout=request_timeout, on_timeout=on_timeout)
        self.pilot = Pilot(self.alerts, now)

    def receive(self, command: parp.Command, station: int, now: float) -> list[Event]:
        """What `station` commands at `now` (s), and what follows from it; first of all what is overdue."""
        return self.expire(now) + self.obey(command, station, now)

    def obey(self, command: parp.Command, station: int, now: float) -> list[Event]:
        """The same where nothing is overdue: between a key and the rudder it is looked at once."""
        about_command = TRANSFER.get(command.verb)
        if about_command is not None:
            return self._with_alert(self.transfer.receive(about_command, station, now, command.requester), now)
        if station != self.transfer.commander:
            return [Refused("not in command", station)]
        return self._steer(command, station, now)

    def _steer(self, command: parp.Command, station: int, now: float) -> list[Event]:
        if self.mute and command.verb is not parp.Verb.DISENGAGE:
            return [Refused("no address on the bus", station)]
        if (change := TURNS.get(command.verb)) is not None:
            return self.pilot.turn(change, station, now)
        match command.verb:
            case parp.Verb.ENGAGE:
                return self.pilot.engage(station, now)
            case parp.Verb.DISENGAGE:
                return self.pilot.disengage(now)
            case _:
                return self.pilot.set_heading(command.heading_tenths or 0, station, now)

    @property
    def deadline(self) -> float:
        """When `expire` should be called, s."""
        times = (self.pilot.deadline, self.transfer.deadline, self.alerts.deadline)
        return min(time for time in times if time is not None)

    def expire(self, now: float) -> list[Event]:
        """What the passing of time brings about."""
        if now < self.deadline:
            return []
        passed = self._with_alert(self.transfer.expire(now), now)
        return passed + self.pilot.expire(now) + self.alerts.expire(now)

    def _with_alert(self, effects: list[Event], now: float) -> list[Event]:
        for effect in effects:
            if type(effect) is Transferred:  # isinstance asks the metaclass: five times as slow
                return effects + self._watch_commander(effect, now)
        return effects

    def _watch_commander(self, transferred: Transferred, now: float) -> list[Event]:
        if transferred.commander != NOBODY:
            return self.alerts.rectify(NO_COMMANDER)
        if self.pilot.mode in (Mode.STANDBY, Mode.ALARM):
            return []
        text = f"station {transferred.previous} gave up command and nobody took it while the pilot steers"
        return self.alerts.arise(NO_COMMANDER, text, now)
