"""`timonel drive`: drive a rover from a terminal.

A terminal tells that a key is pressed, and again while it is held, but not that it is let go. So a key counts for
`HOLD` seconds: while it is held the next repetition comes before that, and when it is let go the rover rests. Between
the first press and the first repetition a terminal waits (a quarter to two thirds of a second; `xset r rate 200 30`
shortens it): a tap is a nudge, and a key that is held begins with one.
"""

import asyncio
import signal
import sys
from collections.abc import Coroutine
from contextlib import AsyncExitStack, ExitStack
from typing import TYPE_CHECKING, Any

import click
from rich.console import Console
from rich.live import Live

from timonel.cli import gamepad
from timonel.cli.gauges import Gauges
from timonel.cli.terminal import keyboard
from timonel.errors import TimonelError
from timonel.gateway.rover import Rover
from timonel.vehicles.rover.framing import DIALECTS

if TYPE_CHECKING:
    import evdev

HOLD = 0.25  # s that a key counts
PAD_PERIOD = 0.05  # s
REDRAW = 0.1  # s
STEP = 0.05  # of the speed limit
FIRST_LIMIT = 0.3
CURVE = 0.4

MOVES = {
    "up": (1.0, 0.0), "w": (1.0, 0.0), "down": (-1.0, 0.0), "s": (-1.0, 0.0),
    "left": (0.0, -1.0), "a": (0.0, -1.0), "right": (0.0, 1.0), "d": (0.0, 1.0),
    "shift-left": (1.0, -CURVE), "shift-right": (1.0, CURVE), "shift-up": (1.0, 0.0), "shift-down": (-1.0, 0.0),
}  # fmt: skip
"""Forward and right by key."""


class Driver:
    """Keys in, set points out; `gauges` is what there is to see. Made on the loop, inside the rover's block."""

    def __init__(self, rover: Rover, *, url: str = "", night: bool = False) -> None:
        self.left = asyncio.Event()
        self._rover = rover
        self._url = url
        self._speed_limit = FIRST_LIMIT
        self._message = ""
        self._refused = False
        self._help = False
        self._night = night
        self._enabling: asyncio.Task[None] | None = None
        self._tasks: set[asyncio.Task[None]] = set()

    @property
    def gauges(self) -> Gauges:
        return Gauges.of(
            self._rover,
            self._url,
            self._speed_limit,
            message=self._message,
            refused=self._refused,
            help=self._help,
            night=self._night,
        )

    def press(self, key: str) -> None:
        """One key. Space is stop in whatever state we are."""
        match key:
            case " ":
                self._start("stopped", self._rover.stop())
            case _ if key in MOVES:
                self.move(*MOVES[key])
            case "e" if self._enabling is None or self._enabling.done():
                self._say("asking for command and permission ...")
                self._enabling = self._start("enabled", self._enable())
            case "+" | "=":
                self._limit(+STEP)
            case "-" | "_":
                self._limit(-STEP)
            case "l":
                self._night = not self._night
            case "?":
                self._help = not self._help
            case "q":
                self.left.set()

    def move(self, forward: float, right: float) -> None:
        """Somebody holds a key or a stick: drive on, for a little while."""
        self._start("", self._rover.drive(forward, right, hold=HOLD))

    async def _enable(self) -> None:
        await self._rover.speed_limit(self._speed_limit)
        await self._rover.enable()

    def _limit(self, change: float) -> None:
        self._speed_limit = min(1.0, max(STEP, self._speed_limit + change))
        self._start(f"speed limit {self._speed_limit * 100:.0f} %", self._rover.speed_limit(self._speed_limit))

    def _start(self, done: str, work: Coroutine[Any, Any, object]) -> asyncio.Task[None]:
        task = asyncio.get_running_loop().create_task(self._finish(done, work))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    async def _finish(self, done: str, work: Coroutine[Any, Any, object]) -> None:
        try:
            await work
        except TimonelError as fault:
            self._say(str(fault), refused=True)
        else:
            self._say(done)

    def _say(self, message: str, *, refused: bool = False) -> None:
        self._message, self._refused = message, refused

    # A gamepad ------------------------------------------------------------------------------------

    async def follow(self, pad: gamepad.Pad) -> None:
        """Drive as the stick says, for as long as a shoulder button is held; a last time at rest when it is let go."""
        held = False
        while True:
            stick = pad.stick
            if stick is not None or held:
                self.move(*(stick or (0.0, 0.0)))
            held = stick is not None
            await asyncio.sleep(PAD_PERIOD)

    async def hear(self, device: "evdev.InputDevice", pad: gamepad.Pad) -> None:
        """Buttons as keys, until the gamepad is unplugged; that stops the rover."""
        async for key in gamepad.read(device, pad):
            self.press(key)
        await self._finish("the gamepad is gone; stopped", self._rover.stop())


async def run(rover: Rover, console: Console, fd: int, *, url: str, night: bool, with_pad: bool) -> None:
    """Show the gauges on `console` and hear keys on terminal `fd`, until it is left or a signal ends it."""
    device = gamepad.find() if with_pad else None
    loop = asyncio.get_running_loop()
    async with AsyncExitStack() as outer, rover:
        driver = Driver(rover, url=url, night=night)
        if device is not None:
            pad = gamepad.pad_of(device)
            outer.callback(device.close)
            tasks = [loop.create_task(driver.follow(pad)), loop.create_task(driver.hear(device, pad))]
            for task in tasks:
                outer.callback(task.cancel)
        with ExitStack() as stack:
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                loop.add_signal_handler(number, driver.left.set)
                stack.callback(loop.remove_signal_handler, number)
            stack.enter_context(keyboard(fd, driver.press, driver.left.set))
            live = stack.enter_context(Live(console=console, screen=True, auto_refresh=False, vertical_overflow="crop"))
            await _show(driver, live)


async def _show(driver: Driver, live: Live) -> None:
    while not driver.left.is_set():
        live.update(driver.gauges.page(live.console.width), refresh=True)
        try:
            await asyncio.wait_for(driver.left.wait(), REDRAW)
        except TimeoutError:
            continue


@click.command()
@click.argument("url")
@click.option("--station", type=click.IntRange(1, 4), default=1, show_default=True, help="The station that you are.")
@click.option("--gamepad", "with_pad", is_flag=True, help="Drive with a gamepad too: hold a shoulder button.")
@click.option("--dialect", type=click.Choice(list(DIALECTS)), default="strzyga", show_default=True,
              help="How frames are written on the link.")  # fmt: skip
@click.option("--calibration", type=click.Choice(["physical", "documented"]), default="physical", show_default=True,
              help="What raw values mean.")  # fmt: skip
@click.option("--night", is_flag=True, help="Red on black. Key l changes it.")
def drive(url: str, station: int, with_pad: bool, dialect: str, calibration: str, night: bool) -> None:
    """Drive the rover at URL from this terminal: hold an arrow key to move, let go to rest.

    URL is the controller's link: tcp://host:port, serial:///dev/ttyUSB0?baud=115200 ... Key e enables, space stops,
    q stops and leaves.

    A terminal does not tell that a key is let go: the rover rests a quarter of a second after the last repetition.
    """
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise click.ClickException("driving needs a terminal: standard input and output must both be one")
    rover = Rover.open(url, station=station, dialect=dialect, calibration=calibration)
    asyncio.run(run(rover, Console(), sys.stdin.fileno(), url=url, night=night, with_pad=with_pad))
    click.echo("left; what we drove was stopped")
