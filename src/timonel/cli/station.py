"""`timonel station`: a keyboard head in the terminal."""

import asyncio
import signal
import sys
from collections.abc import Coroutine
from contextlib import ExitStack
from typing import Any

import click
from rich.console import Console
from rich.live import Live

from timonel.cli.face import NAMES, Face
from timonel.cli.terminal import keyboard
from timonel.errors import TimonelError
from timonel.gateway.lookout import Back, Lost, StationEvent, StatusChanged
from timonel.gateway.station import Station
from timonel.nmea0183.parp import CommandRequested, CommandTransferred, PilotMode

REDRAW = 0.25  # s, for ages and count-downs; whatever happens is drawn at once
ENTRY_MAX = 5  # characters of a heading, 359.9

TURNS = {
    "left": -1, "down": -1, "right": +1, "up": +1,
    "shift-left": -10, "shift-down": -10, "<": -10, "shift-right": +10, "shift-up": +10, ">": +10,
}  # fmt: skip


class Head:
    """Keys in, commands out; `face` is what there is to see. Made on the loop, inside the station's block."""

    def __init__(self, station: Station, *, link: str = "", night: bool = False) -> None:
        self.left = asyncio.Event()
        self.changed = asyncio.Event()
        self.bell = False
        self._station = station
        self._link = link
        self._night = night
        self._help = False
        self._entry: str | None = None
        self._message = ""
        self._refused = False
        self._turn_left = 0
        self._turning = False
        self._asking = False
        self._tasks: set[asyncio.Task[None]] = set()

    @property
    def face(self) -> Face:
        return Face(
            station=self._station.station,
            link=self._link,
            status=self._station.status,
            requests=self._station.requests,
            lost=self._station.lost,
            asking=self._asking,
            entry=self._entry,
            message=self._message,
            refused=self._refused,
            help=self._help,
            night=self._night,
        )

    # Keys -----------------------------------------------------------------------------------------

    def press(self, key: str) -> None:
        """One key. Space is STANDBY in whatever state the head is."""
        self.changed.set()
        if key == " ":
            self._standby()
        elif self._entry is not None:
            self._type(key)
        elif key in TURNS:
            self._turn(TURNS[key])
        else:
            self._do(key)

    def _do(self, key: str) -> None:
        match key:
            case "a" | "e":
                self._start("AUTO", self._station.engage())
            case "r" if not self._asking:
                self._asking = True
                self._start("this station commands", self._ask())
            case "t":
                self._start("this station commands", self._station.take())
            case "y" if self._station.requests:
                self._start("command given", self._station.acknowledge())
            case "y":
                self._start("command released", self._station.release())
            case "n":
                self._start("denied", self._station.deny())
            case "h":
                self._entry = ""
            case "l":
                self._night = not self._night
            case "?":
                self._help = not self._help
            case "q":
                self.left.set()

    def _standby(self) -> None:
        self._entry = None
        self._turn_left = 0
        self._start("STANDBY", self._station.disengage())

    def _turn(self, degrees: int) -> None:
        """Add to the turn: a key held down repeats faster than commands are answered, and they must not pile up."""
        self._turn_left = max(-180, min(180, self._turn_left + degrees))
        if not self._turning:
            self._turning = True
            self._start("set point moved", self._turn_on())

    async def _turn_on(self) -> None:
        try:
            while degrees := self._turn_left:
                self._turn_left = 0
                await self._station.turn(degrees)
        finally:
            self._turning = False
            self._turn_left = 0

    async def _ask(self) -> None:
        try:
            await self._station.request()
        finally:
            self._asking = False

    def _type(self, key: str) -> None:
        entry = self._entry or ""
        match key:
            case "escape":
                self._entry = None
            case "backspace":
                self._entry = entry[:-1]
            case "enter":
                self._entry = None
                self._set_heading(entry)
            case _ if key in "0123456789." and len(entry) < ENTRY_MAX:
                self._entry = entry + key

    def _set_heading(self, entry: str) -> None:
        try:
            heading = float(entry)
        except ValueError:
            self._say(f'"{entry}" is no heading', refused=True)
            return
        self._start(f"set point {heading:05.1f}", self._station.set_heading(heading))

    # What comes of it -----------------------------------------------------------------------------

    def _start(self, done: str, work: Coroutine[Any, Any, object]) -> None:
        task = asyncio.get_running_loop().create_task(self._finish(done, work))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _finish(self, done: str, work: Coroutine[Any, Any, object]) -> None:
        try:
            await work
        except TimonelError as fault:
            self._say(str(fault), refused=True)
        else:
            self._say(done)

    def _say(self, message: str, *, refused: bool = False) -> None:
        self._message, self._refused = message, refused
        self.changed.set()

    async def watch(self) -> None:
        """Tell what the far end tells, until the station is closed."""
        mode: PilotMode | None = None
        async for event in self._station.events():
            if isinstance(event, StatusChanged):
                self.bell |= event.status.mode is PilotMode.ALARM is not mode
                mode = event.status.mode
                self.changed.set()
            else:
                self._tell(event)

    def _tell(self, event: StationEvent) -> None:
        self.bell = True
        match event:
            case CommandTransferred(previous, commander):
                self._say(f"command passed from {_who(previous)} to {_who(commander)}")
            case CommandRequested(station):
                self._say(f"{_who(station)} asks for command")
            case Lost(reason):
                self._say(f"lost: {reason}", refused=True)
            case Back():
                self._say("back")


def _who(station: int) -> str:
    return f"{station:02d} {NAMES[station]}" if station else "nobody"


async def steer(station: Station, console: Console, fd: int, *, link: str, night: bool) -> None:
    """Show the head on `console` and hear keys on terminal `fd`, until it is left or a signal ends it."""
    async with station:
        head = Head(station, link=link, night=night)
        watching = asyncio.get_running_loop().create_task(head.watch())
        with ExitStack() as stack:
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                asyncio.get_running_loop().add_signal_handler(number, head.left.set)
                stack.callback(asyncio.get_running_loop().remove_signal_handler, number)
            stack.enter_context(keyboard(fd, head.press, head.left.set))
            live = stack.enter_context(Live(console=console, screen=True, auto_refresh=False, vertical_overflow="crop"))
            await _show(head, live)
        watching.cancel()


async def _show(head: Head, live: Live) -> None:
    while not head.left.is_set():
        head.changed.clear()
        live.update(head.face.page(live.console.width), refresh=True)
        if head.bell:
            live.console.bell()
            head.bell = False
        await _first(head.left, head.changed, REDRAW)


async def _first(left: asyncio.Event, changed: asyncio.Event, seconds: float) -> None:
    """Until one of them is set, or the time is over."""
    waits = [asyncio.ensure_future(event.wait()) for event in (left, changed)]
    await asyncio.wait(waits, timeout=seconds, return_when=asyncio.FIRST_COMPLETED)
    for wait in waits:
        wait.cancel()


@click.command()
@click.argument("url")
@click.option("--id", "number", type=click.IntRange(1, 4), required=True, help="The station that you are.")
@click.option("--out", help="The gateway's OUT port, where IN and OUT are two wires.")
@click.option("--night", is_flag=True, help="Red on black. Key l changes it.")
def station(url: str, number: int, out: str | None, night: bool) -> None:
    """A keyboard head: steer from this terminal as a station at URL.

    URL is the gateway's IN port, and its OUT port too unless --out names another: serial:///dev/ttyUSB0,
    tcp://host:port ...

    Leaving changes nothing: who commands stays in command, and what is engaged stays engaged.
    """
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise click.ClickException("a keyboard head needs a terminal: standard input and output must both be one")
    head = Station.open(url, out=out, station=number)
    asyncio.run(steer(head, Console(), sys.stdin.fileno(), link=url, night=night))
    click.echo(f"{_who(number)} left; command and pilot stay as they were")
