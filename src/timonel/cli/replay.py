"""`timonel replay`: a recording through the machine that made it, or to a link."""

import asyncio
import sys
from collections.abc import Sized
from contextlib import ExitStack
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, cast

import click

from timonel.cli.terminal import keyboard
from timonel.errors import ConfigError
from timonel.gateway.extras import need_recorder
from timonel.links import urls
from timonel.links.kept import Kept

if TYPE_CHECKING:
    from timonel.gateway.playback import Begin, Entry, Playback, Player
    from timonel.gateway.replay import Difference, Verdict
    from timonel.links.link import BusLink, ByteLink
    from timonel.vehicles.boat.settings import BoatSettings

DIFFERENT = 1
SHOWN_EVERY = 0.25  # s
SEEK = {"left": -10.0, "right": 10.0, "down": -60.0, "up": 60.0, "shift-left": -60.0, "shift-right": 60.0}  # s


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--verify", is_flag=True, help="Put the recorded inputs through the machine and compare all that it says."
)
@click.option("--to", "url", metavar="URL", help="Play it to a bus (socketcan://vcan0) or to listeners "
              "(tcp-listen://127.0.0.1:10110).")  # fmt: skip
@click.option("--speed", default="1", show_default=True, help="2 is twice as fast; max as fast as the link takes it.")
@click.option("--from", "begin", metavar="TIME", help="Where to begin: 12:30 (UTC), a date with time, or +90 (s).")
@click.option("--loop", is_flag=True, help="Begin again at the end.")
@click.option("--allow-commands", is_flag=True, help="Let through frames that command: an autopilot may obey them.")
@click.option("--config", type=click.Path(), help="A boat.toml whose [vehicle] and [sentences] convert a log.")
@click.option("--frames", type=click.Path(), help="The rover's own frames, where they are a Python program.")
def replay(
    file: Path,
    verify: bool,
    url: str | None,
    speed: str,
    begin: str | None,
    loop: bool,
    allow_commands: bool,
    config: str | None,
    frames: str | None,
) -> None:
    """Verify FILE, or play it.

    --verify takes a recording of the gateway's, or the newest in a directory. --to takes that or any log of a bus, and
    plays it as if it happened now. What is played is marked as simulated, and nobody is obeyed. On a terminal: space
    stands still and goes on, the arrows seek ten seconds or a minute, q ends.
    """
    if verify == (url is not None):
        raise click.UsageError("say --verify, or --to URL")
    if verify:
        sys.exit(_verify(file, frames))
    assert url is not None
    sys.exit(_play(file, url, speed, begin, loop, allow_commands, config))


# Verify -----------------------------------------------------------------------------------------------


def _verify(file: Path, frames: str | None) -> int:
    need_recorder()
    from timonel.gateway.replay import newest, verify

    file = newest(file)
    verdict = verify(file, frames)
    for note in verdict.notes:
        click.echo(f"note: {note}", err=True)
    if verdict.difference is not None:
        click.echo(_different(verdict.difference), err=True)
    click.echo(f"{file}: {_summary(verdict)}")
    return DIFFERENT if verdict.difference is not None else 0


def _summary(verdict: "Verdict") -> str:
    outcome = "DIFFERENT" if verdict.difference is not None else "the same to the last byte"
    if verdict.notes and verdict.difference is None:
        outcome += ", as far as it goes"
    return (
        f"{verdict.seconds:.1f} s, {verdict.steps} steps, {verdict.frames} frames in: {verdict.said} bytes said, "
        f"{verdict.sent} frames sent, {verdict.events} events: {outcome}"
    )


def _different(difference: "Difference") -> str:
    moment = datetime.fromtimestamp(difference.stamp_ns / 1e9, UTC)
    return (
        f"the first difference, {moment:%Y-%m-%d %H:%M:%S.%f}Z (machine time {difference.now_us / 1e6:.6f} s)\n"
        f"  told      {difference.told}\n  recorded  {difference.recorded}\n  replayed  {difference.replayed}"
    )


# Play -------------------------------------------------------------------------------------------------


def _play(
    file: Path, url: str, speed: str, begin: str | None, loop: bool, allow_commands: bool, config: str | None
) -> int:
    from timonel.gateway.playback import Playback, at_once, begin_at

    bus = urls.parse(url).carries == "frames"
    try:
        pace = urls.speed(speed)
    except ValueError as fault:
        raise click.UsageError(f'--speed: "{speed}" {fault}') from None
    try:
        first = at_once if begin is None else begin_at(begin)
    except ValueError as fault:
        raise click.UsageError(f"--from: {fault}") from None
    playback = Playback(file, bus=bus, allow_commands=allow_commands, settings=_settings(config))
    playback.check()
    link = urls.bus_link(url) if bus else urls.byte_link(url)
    status = asyncio.run(_Show(playback, link, bus, pace).run(first, loop))
    played = playback.played
    click.echo(f"{file}: {played.frames} frames and {played.lines} lines played", err=True)
    for count, what in (
        (played.withheld, "frames that command were withheld; --allow-commands lets them through"),
        (played.unmarked, "sentences were left out: they have no room for the mark of a simulation"),
    ):
        if count:
            click.echo(f"{count} {what}", err=True)
    return status


def _settings(config: str | None) -> "BoatSettings | None":
    from timonel.gateway.configuration import load
    from timonel.vehicles.boat.settings import BoatSettings

    if config is None:
        return None
    settings = load(config).vehicle
    if not isinstance(settings, BoatSettings):
        raise ConfigError(f"{config}, vehicle.kind: only what a boat said is converted")
    return settings


class _Show:
    """A player with its link, its keyboard and a line that tells where it is."""

    def __init__(self, playback: "Playback", link: "BusLink | ByteLink", bus: bool, speed: float | None) -> None:
        self._playback = playback
        self._bus = bus
        self._link = link
        self._speed = speed
        self._heard = 0
        self._ended = asyncio.Event()
        self._ready = asyncio.Event()

    async def run(self, begin: "Begin", loop: bool) -> int:
        from timonel.gateway.playback import Player

        busy = cast(Kept[object], self._link)
        player = Player(self._playback, self._send, speed=self._speed, busy=lambda: busy.busy)
        await self._link.open(self._hear, self._changed)
        try:
            with ExitStack() as stack:
                if sys.stdin.isatty():
                    stack.enter_context(keyboard(sys.stdin.fileno(), lambda key: self._press(key, player), self._end))
                await self._until_ended(player, begin, loop)
        finally:
            await self._link.close(drain=5.0)
        if self._heard:
            click.echo(f"{self._heard} bytes or frames came in and were not obeyed: this is a recording", err=True)
        return 0

    async def _until_ended(self, player: "Player", begin: "Begin", loop: bool) -> None:
        """Play until the end of the recording, or of the patience of whoever has the keyboard."""
        tasks = [
            asyncio.ensure_future(work)
            for work in (self._keep_playing(player, begin, loop), self._ended.wait(), self._tell(player))
        ]
        await asyncio.wait(tasks[:2], return_when=asyncio.FIRST_COMPLETED)
        for task in tasks:
            task.cancel()
        for end in await asyncio.gather(*tasks, return_exceptions=True):
            if isinstance(end, Exception):
                raise end

    async def _keep_playing(self, player: "Player", begin: "Begin", loop: bool) -> None:
        await self._ready.wait()
        await player.play(begin)
        while loop:
            await player.play(begin)

    async def _tell(self, player: "Player") -> None:
        """Where it is, on a terminal."""
        while sys.stderr.isatty():
            click.echo(f"\r\x1b[K{self._where(player)}", nl=False, err=True)
            await asyncio.sleep(SHOWN_EVERY)

    def _where(self, player: "Player") -> str:
        if not self._ready.is_set():
            return f"waiting for somebody at {self._link.url}"
        moment = "" if player.stamp is None else f"{datetime.fromtimestamp(player.stamp, UTC):%Y-%m-%d %H:%M:%S}Z  "
        pace = "standing still" if player.paused else "max" if self._speed is None else f"{self._speed:g} x"
        return f"{moment}{pace}  (space, arrows, q)"

    def _press(self, key: str, player: "Player") -> None:
        match key:
            case " ":
                player.pause()
            case "q" | "escape":
                self._end()
            case _ if key in SEEK:
                player.seek(SEEK[key])

    def _end(self) -> None:
        self._ended.set()

    def _send(self, entry: "Entry") -> None:
        link = self._link
        if self._bus:
            cast("BusLink", link).send(entry.frames)
        else:
            cast("ByteLink", link).send(entry.lines)

    def _hear(self, what: Sized) -> None:
        self._heard += len(what)

    def _changed(self, connected: bool, reason: str) -> None:
        """A server begins when somebody is there to hear it."""
        if connected and (reason or not self._link.url.startswith("tcp-listen:")):
            self._ready.set()
