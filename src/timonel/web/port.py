"""How a console's words become bytes of its station's port, and what becomes of them.

All consoles of one station share its web port, which is one more port of that station: what is said there is recorded,
limited and refused as what comes over a wire. It is unplugged when the console that holds a rover's stick is gone, at
once, which stops the rover; and when no console of a boat's station has been there for `GRACE` s, so that a page may be
loaded anew.

Of the consoles of a rover's station one holds the stick: who pushes it first, until it lets go, leaves, has said
nothing for 500 ms, or rests while another pushes. A stick that comes more often than 50 times a second is said 50
times, the newest of each, at rest at once; the machine's own limits (200 ms, 500 ms, 2 s without a word) do the rest.
"""

import asyncio
from math import degrees

from timonel.core.command import Verb
from timonel.core.effects import Effect
from timonel.core.pace import Pace
from timonel.gateway.gateway import Gateway
from timonel.links.inner import InnerLink
from timonel.nmea0183 import parp
from timonel.nmea0183.sentences import ACK, ACN, AlertCommand
from timonel.vehicles.boat.pilot import Mode
from timonel.vehicles.boat.vehicle import Boat
from timonel.vehicles.rover import console as words
from timonel.vehicles.rover.drive import PERIOD, SILENT
from timonel.vehicles.rover.frames import (
    CurrentLimit,
    DriveCommand,
    DriveEnable,
    PowerLimit,
    SpeedLimit,
)
from timonel.vehicles.rover.vehicle import FORBID, PERMIT, Rover
from timonel.web.messages import Acknowledge, Command, Enable, LetGo, Limit, Silence, Stick, Stop
from timonel.web.outcome import CONFIRMED, Judge, Verdict, at_once, refused, request, steering
from timonel.web.state import State

GRACE = 5.0  # s
BLIND = 0.5  # s without news from us after which a driver does not see any more what he does
LIMITS = {"power": PowerLimit.FRAME, "speed": SpeedLimit.FRAME, "current": CurrentLimit.FRAME}
VERBS = {
    "REQCMD": Verb.REQUEST,
    "RELCMD": Verb.RELEASE,
    "TAKECMD": Verb.TAKE,
    "ACKCMD": Verb.ACKNOWLEDGE,
    "DENYCMD": Verb.DENY,
}

Order = Command | Acknowledge | Silence | Enable | Stop | Limit
Result = Verdict | Judge
"""How an order ended, or who will tell."""

NOT_HERE = Verdict("refused", "not a word of this vehicle")
NO_ALERT = Verdict("refused", "no such alert")


class Port:
    """The web port of one station."""

    def __init__(self, station: int, link: InnerLink, state: State, gateway: Gateway) -> None:
        self.station = station
        self.consoles: set[int] = set()
        self._link = link
        self._state = state
        self._gateway = gateway

    def enter(self, console: int) -> None:
        """A console, by its number, is this station now."""
        self.consoles.add(console)
        if not self._link.connected:
            self._link.plug(True, "a console")

    def leave(self, console: int) -> None:
        """A console is gone, or is this station no more."""
        raise NotImplementedError

    def carry_out(self, order: Order) -> Result:
        """Say it, and what becomes of it."""
        raise NotImplementedError

    def _say(self, data: bytes) -> list[Effect]:
        with self._state.listening() as effects:
            self._link.say(data)
        return effects

    def _about_alert(self, order: Acknowledge | Silence, said: bytes) -> Result:
        alert = self._state.alert(order.alert)
        if alert is None:
            return NO_ALERT
        self._say(said)
        return CONFIRMED if self._state.alert(order.alert) != alert or alert.acknowledged else NO_ALERT


class BoatPort(Port):
    """What consoles of a boat say: the sentences that a wire would carry."""

    def __init__(self, station: int, link: InnerLink, state: State, gateway: Gateway, boat: Boat) -> None:
        super().__init__(station, link, state, gateway)
        self._boat = boat

    def leave(self, console: int) -> None:
        """A console is gone; that nobody is left is told when nobody comes back."""
        self.consoles.discard(console)
        if not self.consoles:
            asyncio.get_running_loop().call_later(GRACE, self._unplug)

    def _unplug(self) -> None:
        if not self.consoles and self._link.connected:
            self._link.plug(False, "no console")

    def carry_out(self, order: Order) -> Result:
        """Say it, and what becomes of it."""
        match order:
            case Command():
                return self._command(order)
            case Acknowledge(alert=alert):
                return self._about_alert(order, ACK(alert).encode())
            case Silence(alert=alert):
                return self._about_alert(order, ACN(alarm=alert, command=AlertCommand.SILENCE, status="C").encode())
        return NOT_HERE

    def _command(self, order: Command) -> Result:
        verb = parp.Verb(order.verb)
        helm, sent = self._boat.helm, self._gateway.now
        if verb is parp.Verb.SETHEADING and order.parameter is None:
            return Verdict("refused", "no heading")
        effects = self._say(parp.command(verb, self.station, degrees(order.parameter or 0.0)))
        if against := refused(effects, self.station):
            return against
        match verb:
            case parp.Verb.REQCMD:
                return request(helm.transfer, self.station)
            case parp.Verb.TAKECMD:
                return at_once(lambda: helm.transfer.commander == self.station, sent)
            case parp.Verb.RELCMD | parp.Verb.ACKCMD | parp.Verb.DENYCMD:
                return CONFIRMED
            case parp.Verb.DISENGAGE:
                return steering(helm.pilot, Mode.STANDBY, sent)
            case _:
                return steering(helm.pilot, Mode.HEADING_HOLD, sent)


class RoverPort(Port):
    """What consoles of a rover say: the frames that a wire would carry, and words that it has none for."""

    def __init__(self, station: int, link: InnerLink, state: State, gateway: Gateway, rover: Rover) -> None:
        super().__init__(station, link, state, gateway)
        self._rover = rover
        self._pace = Pace(PERIOD)
        self._holder: int | None = None
        self._heard = 0.0
        self._number = -1
        self._at_rest = True
        self._waiting: bytes | None = None
        self._timer: asyncio.TimerHandle | None = None

    def leave(self, console: int) -> None:
        """A console is gone: if it held the stick, that is as if the link were cut; others only looked."""
        self.consoles.discard(console)
        if console == self._holder:
            self._release()
            self._link.plug(False, "the console that held the stick is gone")
            if self.consoles:
                self._link.plug(True, "another console")

    # The stick ----------------------------------------------------------------------------------------

    def stick(self, console: int, stick: Stick) -> None:
        """A stick, which counts while the station is in command."""
        now = self._gateway.now
        if self._rover.helm.transfer.commander != self.station:
            self._release()
            return
        if not self._may_hold(console, stick, now):
            return
        self._heard, self._number = now, stick.n
        blind = stick.seen is not None and not now - BLIND <= stick.seen <= now + BLIND
        self._move(0.0 if blind else stick.x, 0.0 if blind else stick.y, now)

    def _may_hold(self, console: int, stick: Stick, now: float) -> bool:
        if console == self._holder:
            return stick.n > self._number
        pushes = (stick.x, stick.y) != (0, 0)
        if self._holder is not None and now < self._heard + SILENT and not (self._at_rest and pushes):
            return False
        self._holder = console
        return True

    def _move(self, x: float, y: float, now: float) -> None:
        across, along = round(x * 100), -round(y * 100)
        said = words.Console.write(DriveCommand.FRAME, bytes((across & 0xFF, along & 0xFF)))
        halts = (across, along) == (0, 0) and not self._at_rest
        self._at_rest = (across, along) == (0, 0)
        if halts or self._pace.open(now):
            self._say_stick(said, now)
        else:
            self._waiting = said
            if self._timer is None:
                self._timer = asyncio.get_running_loop().call_at(self._pace.opens, self._say_waiting)

    def _say_stick(self, said: bytes, now: float) -> None:
        self._waiting = None
        self._pace.count(now)
        self._link.say(said)

    def _say_waiting(self) -> None:
        self._timer = None
        if self._waiting is not None:
            self._say_stick(self._waiting, self._gateway.now)

    def let_go(self, console: int, _: LetGo | None = None) -> None:
        """Nobody holds the stick any more."""
        if console == self._holder:
            self._move(0.0, 0.0, self._gateway.now)
            self._release()

    def _release(self) -> None:
        self._holder, self._number, self._waiting = None, -1, None

    # Orders -------------------------------------------------------------------------------------------

    def carry_out(self, order: Order) -> Result:
        """Say it, and what becomes of it."""
        drive, sent = self._rover.drive, self._gateway.now
        match order:
            case Command():
                return self._command(order, sent)
            case Stop():
                self._release()
                self._say(words.Console.write(DriveEnable.FRAME, FORBID))
                return at_once(lambda: not drive.permitted, sent)
            case Enable():
                permit = words.Console.write(DriveEnable.FRAME, PERMIT)
                return self._if_in_command(permit) or at_once(lambda: drive.permitted, sent)
            case Limit(which=which, value=value):
                frame = LIMITS[which]
                limit = words.Console.write(frame, bytes((value,)))
                return self._if_in_command(limit) or at_once(lambda: self._rover.limit(frame) == value, sent)
            case Acknowledge(alert=alert):
                return self._about_alert(order, words.acknowledge(alert))
            case Silence(alert=alert):
                return self._about_alert(order, words.silence(alert))
        return NOT_HERE

    def _if_in_command(self, said: bytes) -> Verdict | None:
        """Say what would be a request for command, if it came from another station; what stands against it."""
        if self._rover.helm.transfer.commander != self.station:
            return Verdict("refused", "not in command")
        return refused(self._say(said), self.station)

    def _command(self, order: Command, sent: float) -> Result:
        verb = VERBS.get(order.verb)
        if verb is None:
            return NOT_HERE
        transfer = self._rover.helm.transfer
        if against := refused(self._say(words.command(verb)), self.station):
            return against
        match verb:
            case Verb.REQUEST:
                return request(transfer, self.station)
            case Verb.TAKE:
                return at_once(lambda: transfer.commander == self.station, sent)
            case _:
                return CONFIRMED
