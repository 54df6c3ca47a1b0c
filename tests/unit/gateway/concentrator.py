"""A far end for stations to talk to, and a loop whose time is a number."""

import asyncio
import selectors
from collections import deque
from collections.abc import Callable, Coroutine, Sequence
from typing import Any, TypeVar

from timonel.core.effects import Say
from timonel.links.link import Changed, Counters
from timonel.nmea0183 import parp
from timonel.nmea0183.framing import SentenceFramer
from timonel.nmea0183.parp import Command, PilotMode, Verb

Result = TypeVar("Result")

TURNS = {Verb.PORTTEN: -100, Verb.PORTONE: -10, Verb.STBDONE: 10, Verb.STBDTEN: 100}


class _Jump(selectors.DefaultSelector):
    """Instead of waiting, moves the loop's time to where the wait would end."""

    loop: "CountedLoop"

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        ready = super().select(0)
        if not ready and timeout is None:
            raise RuntimeError("everybody waits for nothing")
        if not ready and timeout is not None:
            self.loop.now += max(timeout, 1e-6)
        return ready


class CountedLoop(asyncio.SelectorEventLoop):
    """An event loop in which an hour takes as long as what happens in it."""

    def __init__(self) -> None:
        self.now = 1000.0
        selector = _Jump()
        selector.loop = self
        super().__init__(selector)

    def time(self) -> float:
        return self.now


def run(main: Coroutine[Any, Any, Result]) -> Result:
    """`asyncio.run` in counted time."""
    with asyncio.Runner(loop_factory=CountedLoop) as runner:
        return runner.run(main)


class Concentrator:
    """Says STATUS at 2 Hz and, unless it is an ESP32, at once after whatever it heard.

    It obeys the commander as spec/boat.md says; what a test wants otherwise it sets (`deaf`, `mute`, `stubborn`).
    """

    def __init__(self, *, esp32: bool = False) -> None:
        self.esp32 = esp32
        self.commander = 0
        self.mode: PilotMode | None = PilotMode.STANDBY
        self.setpoint = 0
        self.heading: float | None = 182.5
        self.rudder: float | None = 0.0
        self.asking: int | None = None
        self.deaf = False
        self.mute = False
        self.stubborn = False
        self.heard: list[Command] = []
        self.times: list[float] = []
        self._framer = SentenceFramer()
        self._say: Callable[[bytes], None] = lambda _: None
        self._timer: asyncio.TimerHandle | None = None

    def plug(self, say: Callable[[bytes], None]) -> None:
        self._say = say
        self.unplug()
        self._tick()

    def unplug(self) -> None:
        if self._timer is not None:
            self._timer.cancel()

    def _tick(self) -> None:
        self._timer = asyncio.get_running_loop().call_later(0.5, self._tick)
        self.status()

    def say(self, line: bytes) -> None:
        if not self.mute:
            self._say(line)

    def status(self) -> None:
        self.say(parp.status(self.mode, self.setpoint, self.heading, self.rudder, self.commander))

    def transfer(self, commander: int) -> None:
        previous, self.commander, self.asking = self.commander, commander, None
        self.say(parp.cmdtransfer(previous, commander))

    def announce(self, station: int) -> None:
        self.asking = station
        self.say(parp.cmdrequest(station))

    def receive(self, data: bytes) -> None:
        for line in self._framer.receive(data):
            command = parp.read_command(line)
            assert isinstance(command, Command), line
            self.heard.append(command)
            self.times.append(asyncio.get_running_loop().time())
            if not self.deaf:
                self._obey(command)

    @property
    def verbs(self) -> list[Verb]:
        return [command.verb for command in self.heard]

    def _obey(self, command: Command) -> None:
        if not self.stubborn:
            self._act(command)
        if not self.esp32:
            self.status()

    def _act(self, command: Command) -> None:
        station = command.station or 0
        match command.verb:
            case Verb.REQCMD if self.commander == 0:
                self.transfer(station)
            case Verb.REQCMD if self.asking is None and station != self.commander:
                self.announce(station)
            case Verb.TAKECMD if station == 1:
                self.transfer(1)
            case _ if station == self.commander:
                self._obey_commander(command)

    def _obey_commander(self, command: Command) -> None:
        holding = self.mode is PilotMode.HEADING_HOLD
        match command.verb:
            case Verb.RELCMD:
                self.transfer(self.asking or 0)
            case Verb.ACKCMD if self.asking:
                self.transfer(self.asking)
            case Verb.DENYCMD:
                self.asking = None
            case Verb.DISENGAGE:
                self.mode = PilotMode.STANDBY
            case Verb.ENGAGE if self.heading is not None and self.mode is not PilotMode.ALARM:
                self.mode, self.setpoint = PilotMode.HEADING_HOLD, round(self.heading * 10)
            case Verb.SETHEADING if holding:
                self.setpoint = command.heading_tenths or 0
            case turn if holding and turn in TURNS:
                self.setpoint = (self.setpoint + TURNS[turn]) % 3600


class Cable:
    """A link without a wire, from a station to a concentrator in the same test."""

    url = ""

    def __init__(self, far: Concentrator, name: str = "port", *, delay: float = 0.0) -> None:
        self.far = far
        self.name = name
        self.delay = delay
        self.counters = Counters()
        self.closed = False

    async def open(self, receive: Callable[[bytes], None], changed: Changed) -> None:
        self.changed = changed
        self.far.plug(self._way(receive))
        changed(True, "")

    def send(self, lines: Sequence[Say]) -> None:
        towards = self._way(self.far.receive)
        for say in lines:
            towards(say.line)

    def _way(self, receive: Callable[[bytes], None]) -> Callable[[bytes], None]:
        """What goes in comes out in order; timers of one moment would not keep it."""
        loop = asyncio.get_running_loop()
        under_way: deque[bytes] = deque()

        def enter(line: bytes) -> None:
            under_way.append(line)
            loop.call_later(self.delay, lambda: receive(under_way.popleft()))

        return enter

    async def close(self, drain: float = 0.5) -> None:
        self.far.unplug()
        self.closed = True
