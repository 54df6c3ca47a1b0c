"""The other end of the wire: a station, for software that talks to a gateway or to the ESP32 concentrator.

```python
async with Station.open("serial:///dev/ttyUSB0", station=2) as s:
    await s.request()
    await s.engage()
    await s.turn(+10)
```
Every method returns when the far end has shown the effect, and raises RefusedError or NoAnswerError otherwise;
how that is told from STATUS stands in `verdict`. No answer is not no effect: the command may have arrived all the
same. The links look after themselves; while one is down, or nothing was heard for 3 s, commands fail at once.

Leaving the block changes nothing at the far end: whoever commands stays in command, and what is engaged stays
engaged (spec/boat.md, safety rule 5), unless `release_on_exit` was asked for.
"""

import asyncio
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from types import TracebackType
from typing import Self
from weakref import WeakSet

from timonel.core.command import BRIDGE, STATIONS
from timonel.core.effects import Say
from timonel.errors import EncodeError, NoAnswerError, RefusedError, StationError
from timonel.gateway.lookout import STALE, Back, Lookout, Lost, Request, StationEvent, StationStatus
from timonel.gateway.verdict import CommandVerdict, Done, Grant, Refusal, RequestVerdict, Verdict, named
from timonel.links.link import ByteLink
from timonel.links.urls import byte_link, commanding_link
from timonel.nmea0183 import parp
from timonel.nmea0183.parp import PilotMode, Verb

REQUEST_TIMEOUT = 12.0  # s: the commander's ten, a second for the consequence, and one in reserve
TIMEOUT = 1.5  # s: STATUS comes at 2 Hz
BURST = 10  # commands at once, and as many a second: a port takes 20 a second (spec/boat.md)
BURST_PAUSE = 1.0
TURNS = {Verb.PORTTEN: -10, Verb.PORTONE: -1, Verb.STBDONE: 1, Verb.STBDTEN: 10}
SAME_COURSE = 0.55  # degrees: a pilot that holds whole or half degrees still shows the effect
EVENTS_KEPT = 256


class Events:
    """Events from the moment it was made, until the station is closed. The oldest give way if nobody reads."""

    def __init__(self) -> None:
        self._queue: asyncio.Queue[StationEvent | None] = asyncio.Queue()

    def put(self, event: StationEvent | None) -> None:
        if self._queue.qsize() >= EVENTS_KEPT:
            self._queue.get_nowait()
        self._queue.put_nowait(event)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> StationEvent:
        event = await self._queue.get()
        if event is None:
            self._queue.put_nowait(None)
            raise StopAsyncIteration
        return event


class Station:
    """One station at the far end's ports; an async context manager, usually made by `open`.

    `in_port` is the far end's IN port, which we speak into; `out_port` its OUT port, where that is another wire.
    """

    def __init__(
        self,
        in_port: ByteLink,
        out_port: ByteLink | None = None,
        *,
        station: int,
        request_seconds: float = 10.0,
        release_on_exit: bool = False,
    ) -> None:
        if station not in STATIONS:
            raise StationError(f"station: {station} is not 1 (bridge), 2 (cockpit), 3 (flybridge) or 4")
        self.station = station
        self._in_port = in_port
        self._out_port = out_port
        self._release_on_exit = release_on_exit
        self._lookout = Lookout(request_seconds)
        self._verdicts: dict[Verdict, asyncio.Future[Done | Refusal]] = {}
        self._readers: WeakSet[Events] = WeakSet()
        self._steering = asyncio.Lock()
        self._first_status = asyncio.Event()
        self._let_gos = 0
        self._down: dict[str, str] = {}
        self._silent = False
        self._told_lost = False
        self._silence: asyncio.TimerHandle | None = None

    @classmethod
    def open(
        cls,
        url: str,
        *,
        out: str | None = None,
        station: int,
        request_seconds: float = 10.0,
        release_on_exit: bool = False,
    ) -> Self:
        """A station on the link `url`, for `async with`; `out` is the OUT port's URL where it is another wire.

        `request_seconds` is how long the commander may leave a request unanswered at the far end. With
        `release_on_exit` leaving the block gives up command, if we have it. Raises LinkError for a bad URL,
        StationError for a station outside 1..4.
        """
        out_port = None if out is None else byte_link(out, name="OUT port")
        return cls(
            commanding_link(url, name="IN port" if out else "port"),
            out_port,
            station=station,
            request_seconds=request_seconds,
            release_on_exit=release_on_exit,
        )

    async def __aenter__(self) -> Self:
        self._loop = asyncio.get_running_loop()
        self._await_status()
        heard_by = self._in_port if self._out_port is None else self._out_port
        try:
            if heard_by is not self._in_port:
                await self._in_port.open(_ignore, partial(self._link_changed, self._in_port.name))
            await heard_by.open(self._receive, partial(self._link_changed, heard_by.name))
        except BaseException:
            await self._close()
            raise
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        fault: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            if self._release_on_exit and self.in_command:
                with suppress(StationError):
                    await self.release()
        finally:
            await self._close()

    async def _close(self) -> None:
        if self._silence is not None:
            self._silence.cancel()
        await self._in_port.close()
        if self._out_port is not None:
            await self._out_port.close()
        for future in self._verdicts.values():
            if not future.done():
                future.set_exception(NoAnswerError("the station was closed"))
        for reader in self._readers:
            reader.put(None)

    # What is known --------------------------------------------------------------------------------

    @property
    def status(self) -> StationStatus:
        """What the last STATUS said, and how old it is now."""
        return self._lookout.status(self._loop.time())

    @property
    def in_command(self) -> bool:
        """Whether we are the commander, as far as was heard; false while the far end is lost."""
        return self._lookout.commander == self.station and self.lost is None

    @property
    def requests(self) -> tuple[Request, ...]:
        """The announced request, if there is one; those that wait behind it are not told."""
        return self._lookout.requests(self._loop.time())

    @property
    def lost(self) -> str | None:
        """Why the far end is out of reach; None while it is heard, and in the first 3 s."""
        if self._down:
            return "; ".join(f"{port}: {reason}" for port, reason in self._down.items())
        return f"no STATUS for {STALE:g} s" if self._silent else None

    @property
    def rejected(self) -> Counter[str]:
        """`$PARP` sentences that were dropped, by cause."""
        return self._lookout.rejected.copy()

    def events(self) -> Events:
        """What happens from now on: StatusChanged, CommandTransferred, CommandRequested, Lost, Back."""
        events = Events()
        self._readers.add(events)
        return events

    # Command --------------------------------------------------------------------------------------

    async def request(self, timeout: float = REQUEST_TIMEOUT) -> Grant:
        """Ask for command and wait until we have it; how we came to it.

        Raises RefusedError if it was denied or overridden, which without a sentence of its own is certain only a
        second after the commander's time is over, and NoAnswerError if nothing is decided within `timeout` s.
        """
        if self.in_command:
            return Grant.ALREADY
        announced = self._lookout.announced(self.station)
        verdict = RequestVerdict(self.station, self._lookout.request_seconds, announced)
        done = await self._settle((Verb.REQCMD,), verdict, timeout)
        assert done.grant is not None
        return done.grant

    async def release(self, timeout: float = TIMEOUT) -> None:
        """Give command to whoever asked for it, else to nobody. The pilot goes on as it is."""
        await self._command((Verb.RELCMD,), self._gave_command, timeout)

    async def acknowledge(self, timeout: float = TIMEOUT) -> None:
        """Give command to the announced requester."""
        await self._command((Verb.ACKCMD,), self._gave_command, timeout)

    async def deny(self, timeout: float = TIMEOUT) -> None:
        """Turn the announced requester down. STATUS has no field for it: that we still command is all it shows."""
        await self._command((Verb.DENYCMD,), self._has_command, timeout)
        self._lookout.answered()

    async def take(self, timeout: float = TIMEOUT) -> None:
        """Take command at once, whoever has it: the bridge's right. Raises RefusedError at any other station."""
        if self.station != BRIDGE:
            raise RefusedError(f"{Verb.TAKECMD}: only the bridge may, and this is {named(self.station)}")
        await self._command((Verb.TAKECMD,), self._has_command, timeout)
        self._lookout.answered()

    def _has_command(self, status: parp.Status) -> bool:
        return status.commander == self.station

    def _gave_command(self, status: parp.Status) -> bool:
        return status.commander != self.station

    # Steering -------------------------------------------------------------------------------------

    async def engage(self, timeout: float = TIMEOUT) -> None:
        """Hold the present heading."""
        wanted = self._let_gos
        async with self._steering:
            self._still_wanted(Verb.ENGAGE, wanted)
            await self._command((Verb.ENGAGE,), _engaged, timeout)

    async def disengage(self, timeout: float = TIMEOUT) -> None:
        """Let go: STANDBY. Waits for no other command, and is sent even where nothing is heard any more.

        A steering command that still waits its turn here is dropped: its caller gets RefusedError.
        """
        self._let_gos += 1
        if self.lost is not None:
            self._send((Verb.DISENGAGE,))
        await self._command((Verb.DISENGAGE,), _let_go, timeout)

    async def set_heading(self, heading_deg: float, timeout: float = TIMEOUT) -> None:
        """Hold `heading_deg`, to the tenth. Raises EncodeError outside 0..360."""
        if not 0.0 <= heading_deg <= 360.0:
            raise EncodeError(f"heading: {heading_deg} is outside 0..360")
        wanted = self._let_gos
        async with self._steering:
            self._still_wanted(Verb.SETHEADING, wanted)
            shows = partial(_holds, heading_deg)
            await self._command((Verb.SETHEADING,), shows, timeout, parameter=heading_deg)

    async def turn(self, degrees: float, timeout: float = TIMEOUT) -> None:
        """Move the set point by whole `degrees`, starboard positive, in as few commands as tens and ones allow.

        More than ten of them go out at ten a second, with `timeout` for each ten. Raises EncodeError outside
        -180..180 and for fractions.
        """
        if not -180 <= degrees <= 180 or degrees != int(degrees):
            raise EncodeError(f"turn: {degrees} is not a whole number of degrees in -180..180")
        wanted = self._let_gos
        async with self._steering:
            for place, burst in enumerate(bursts(int(degrees))):
                await asyncio.sleep(BURST_PAUSE if place else 0)
                self._still_wanted(burst[0], wanted)
                await self._turn(burst, timeout)

    async def _turn(self, burst: Sequence[Verb], timeout: float) -> None:
        await self._hear_first(burst[0], timeout)
        start = self.status.setpoint_deg
        course = None if start is None else start + sum(TURNS[verb] for verb in burst)
        await self._command(burst, partial(_holds, course), timeout)

    def _still_wanted(self, verb: Verb, wanted: int) -> None:
        if wanted != self._let_gos:
            raise RefusedError(f"{verb}: disengaged meanwhile")

    # Speaking and listening -----------------------------------------------------------------------

    async def _hear_first(self, verb: Verb, timeout: float) -> None:
        """Wait for the first STATUS, for a command that cannot be judged without the one before it."""
        try:
            await asyncio.wait_for(self._first_status.wait(), timeout)
        except TimeoutError:
            raise NoAnswerError(f"{verb}: {self.lost or f'no STATUS within {timeout:g} s'}") from None

    async def _command(
        self,
        verbs: Sequence[Verb],
        shows: Callable[[parp.Status], bool],
        timeout: float,
        parameter: float = 0.0,
    ) -> None:
        now, before = self._loop.time(), self._lookout.last
        verdict = CommandVerdict(verbs[0], self.station, shows, sent=now, before=before)
        await self._settle(verbs, verdict, timeout, parameter)

    async def _settle(self, verbs: Sequence[Verb], verdict: Verdict, timeout: float, parameter: float = 0.0) -> Done:
        """Say `verbs` and wait for the verdict. Raises RefusedError and NoAnswerError."""
        if self.lost is not None:
            raise NoAnswerError(f"{verbs[0]}: {self.lost}")
        future: asyncio.Future[Done | Refusal] = self._loop.create_future()
        self._verdicts[verdict] = future
        self._send(verbs, parameter)
        try:
            outcome = await asyncio.wait_for(future, timeout)
        except TimeoutError:
            raise NoAnswerError(f"{verbs[0]}: {self._undecided(verdict, timeout)}") from None
        finally:
            del self._verdicts[verdict]
        if isinstance(outcome, Refusal):
            raise RefusedError(f"{verbs[0]}: {outcome.reason}")
        return outcome

    def _undecided(self, verdict: Verdict, timeout: float) -> str:
        if self.lost is not None:
            return self.lost
        commander = self.status.commander
        if commander is None or not isinstance(verdict, RequestVerdict):
            return f"no STATUS within {timeout:g} s"
        if verdict.announced:
            return f"{named(commander)} has been asked and has not answered within {timeout:g} s"
        return f"{named(commander)} is in command and has not been asked (another request, the wrong port?)"

    def _send(self, verbs: Sequence[Verb], parameter: float = 0.0) -> None:
        lines = (parp.command(verb, self.station, parameter) for verb in verbs)
        self._in_port.send([Say(line, key="", urgent=True) for line in lines])

    def _receive(self, data: bytes) -> None:
        now = self._loop.time()
        for report in self._lookout.receive(data):
            for event in self._lookout.hear(report, now):
                self._tell(event)
            if isinstance(report, parp.Status):
                self._first_status.set()
                self._await_status()
            self._judge(report, now)

    def _judge(self, report: parp.Report, now: float) -> None:
        for verdict, future in self._verdicts.items():
            outcome = None if future.done() else verdict.hear(report, now)
            if outcome is not None:
                future.set_result(outcome)

    def _await_status(self) -> None:
        """One was just heard, or we just began to listen: the next is due within 3 s."""
        if self._silence is not None:
            self._silence.cancel()
        self._silence = self._loop.call_later(STALE, self._fall_silent)
        self._silent = False
        self._tell_lost()

    def _fall_silent(self) -> None:
        self._silent = True
        self._tell_lost()

    def _link_changed(self, port: str, connected: bool, reason: str) -> None:
        if connected:
            self._down.pop(port, None)
        else:
            self._down[port] = reason or "not connected"
        self._tell_lost()

    def _tell_lost(self) -> None:
        lost = self.lost
        if (lost is not None) != self._told_lost:
            self._told_lost = lost is not None
            self._tell(Back() if lost is None else Lost(lost))

    def _tell(self, event: StationEvent) -> None:
        for reader in self._readers:
            reader.put(event)


def _ignore(_data: bytes) -> None:
    """An IN port that is a wire of its own has nothing to say to us."""


def _engaged(status: parp.Status) -> bool:
    return status.mode is PilotMode.HEADING_HOLD


def _let_go(status: parp.Status) -> bool:
    return status.mode is PilotMode.STANDBY


def _holds(course: float | None, status: parp.Status) -> bool:
    """Whether `status` shows that `course` is held, in degrees and modulo 360."""
    if course is None or status.setpoint_deg is None or not _engaged(status):
        return False
    return abs((status.setpoint_deg - course + 180.0) % 360.0 - 180.0) <= SAME_COURSE


def bursts(degrees: int) -> list[list[Verb]]:
    """The fewest commands that turn by `degrees`, in portions that a port takes at once.

    The ones come first: they may go the other way, and a course of 180 degrees or more is never passed through.
    """
    tens, ones = divmod(abs(degrees), 10)
    if ones > 5:
        tens, ones = tens + 1, ones - 10
    starboard = degrees > 0
    verbs = [Verb.STBDONE if starboard == (ones > 0) else Verb.PORTONE] * abs(ones)
    verbs += [Verb.STBDTEN if starboard else Verb.PORTTEN] * tens
    return [verbs[first : first + BURST] for first in range(0, len(verbs), BURST)]
