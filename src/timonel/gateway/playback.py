"""Plays a recording, on its own time, as the bus it was made of or as what a gateway said to its stations.

```
recorded                     as a bus                                     as a gateway's outputs
by our own recorder          what came in                                 what was said
a log of a bus               its frames                                   what a boat's machine makes of them
a log of sentences           -                                            its sentences
```
It must not be taken for the real thing: sentences are marked as simulated, and frames that command (`COMMANDS`, of a
rover all that go to its modules) or that the gateway sent are withheld, since a pilot that hears them would steer.
"""

import asyncio
import re
from collections.abc import Callable, Iterable, Iterator
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import NamedTuple, cast

import msgspec

from timonel.core.effects import Say
from timonel.core.frame import Frame
from timonel.errors import EncodeError, RecordingError
from timonel.gateway.assemble import boat
from timonel.gateway.convert import RecordedTime
from timonel.nmea0183.simulated import simulated
from timonel.nmea2000.fastpacket import fragment
from timonel.nmea2000.identifier import split
from timonel.recording import LogFrame, LogSentence, open_any
from timonel.recording.flight import BUS, MAGIC, OUT, Flight
from timonel.recording.flight_bus import frames_of
from timonel.vehicles.boat.settings import BoatSettings
from timonel.vehicles.rover.declaration import Party
from timonel.vehicles.rover.protocol import Protocol

COMMANDS = {
    61184,  # proprietary, to one device
    65240,  # commanded address
    126208,  # group functions: requests and commands
    126720,  # proprietary, to one device: keys of autopilots
    127237,  # heading and track control
    127502,  # switch bank control
    130850,  # Navico: autopilot commands
    130851,
}
"""PGNs by which one device makes another do something (canboat's database), reports by the same PGN included."""
BATCH = 64  # entries at once
NULL_ADDRESS = 254  # of whom has none (ISO 11783-5): no device of the recording is taken for ourselves
ROVER = Protocol().declarations
A_DAY = timedelta(days=1)


class Entry(NamedTuple):
    """What is due at `now`, s of the recording's own time; `stamp` is in unix seconds, None if it is not known."""

    now: float
    stamp: float | None
    frames: list[Frame]
    lines: list[Say]


class Played(msgspec.Struct):
    """What was played, and what was not."""

    frames: int = 0
    lines: int = 0
    withheld: int = 0
    """Frames that command."""
    unmarked: int = 0
    """Sentences that could not be marked as simulated."""


class Playback:
    """A recording as entries. `settings` are a boat's, for logs that its machine converts."""

    def __init__(
        self,
        path: str | Path,
        *,
        bus: bool,
        allow_commands: bool = False,
        settings: BoatSettings | None = None,
    ) -> None:
        self.path = path
        self.played = Played()
        self._bus = bus
        self._allow_commands = allow_commands
        self._settings = settings or BoatSettings()

    def check(self) -> None:
        """Raises RecordingError where there is nothing of the kind to play."""
        self.entries()

    def entries(self) -> Iterator[Entry]:
        """From the beginning, in order; raises as `check`."""
        if _is_ours(self.path):
            return self._recorded_frames() if self._bus else self._recorded_lines()
        if open_any_kind(self.path) == "sentences":
            if self._bus:
                raise RecordingError(f"{self.path}: sentences, not frames of a bus")
            return self._logged_lines()
        return self._logged_frames() if self._bus else self._converted()

    def _recorded_frames(self) -> Iterator[Entry]:
        for record in Flight(self.path):
            if record.topic != BUS:
                continue
            for frame in frames_of(record.data, record.step):
                told = Frame(frame.identifier, frame.data, frame.extended)
                if self._lets(told, frame.sent):
                    late = frame.elapsed / 1e6
                    yield Entry(record.now_ns / 1e9 + late, record.stamp_ns / 1e9 + late, [told], [])

    def _recorded_lines(self) -> Iterator[Entry]:
        for record in Flight(self.path):
            if record.topic == OUT:
                text = cast(str, record.fields["text"]).encode("latin-1")
                yield Entry(record.now_ns / 1e9, record.stamp_ns / 1e9, [], self._said(_lines(text)))

    def _logged_frames(self) -> Iterator[Entry]:
        time, sequence = RecordedTime(), 0
        for entry in _log(self.path):
            now = time.receive(entry.stamp)
            sequence = (sequence + entry.whole) % 8
            frames = [frame for frame in _frames(entry, sequence) if self._lets(frame, False)]
            yield Entry(now, entry.stamp, frames, [])

    def _logged_lines(self) -> Iterator[Entry]:
        time = RecordedTime()
        for entry in open_any(self.path):
            if isinstance(entry, LogSentence):
                yield Entry(time.receive(entry.stamp), entry.stamp, [], self._said([entry.line.rstrip() + b"\r\n"]))

    def _converted(self) -> Iterator[Entry]:
        vehicle = boat(msgspec.structs.replace(self._settings, address=NULL_ADDRESS), [], 0.0)
        time = RecordedTime()
        for entry in _log(self.path):
            before = time.now
            now = time.receive(entry.stamp)
            while (due := vehicle.deadline) <= now:
                late = now - max(due, before)
                stamp = None if entry.stamp is None else entry.stamp - late
                said = [effect.line for effect in vehicle.expire(now - late) if isinstance(effect, Say)]
                yield Entry(now - late, stamp, [], self._said(said))
            if entry.whole:
                effects = vehicle.receive_message(entry.identifier, entry.data, now)
            else:
                effects = vehicle.receive_frames((entry.frame,), now)
            said = [effect.line for effect in effects if isinstance(effect, Say)]
            yield Entry(now, entry.stamp, [], self._said(said))

    def _lets(self, frame: Frame, sent: bool) -> bool:
        if self._allow_commands or not (sent or commands(frame)):
            return True
        self.played.withheld += 1
        return False

    def _said(self, lines: Iterable[bytes]) -> list[Say]:
        """Urgent, so that none takes the place of another."""
        return [say for line in lines if (say := self._marked(line)) is not None]

    def _marked(self, line: bytes) -> Say | None:
        try:
            return Say(simulated(line), "replay", urgent=True)
        except EncodeError:
            self.played.unmarked += 1
            return None


def commands(frame: Frame) -> bool:
    """Whether a device that hears this frame might do something."""
    if frame.extended:
        return split(frame.identifier).pgn in COMMANDS
    declared = ROVER.get(frame.identifier)
    return declared is not None and declared.TO is not Party.OPERATOR


def open_any_kind(path: str | Path) -> str:
    """What a log has. Raises RecordingError."""
    with open_any(path) as reader:
        return reader.kind


def _log(path: str | Path) -> Iterator[LogFrame]:
    return (entry for entry in open_any(path) if isinstance(entry, LogFrame))


def _is_ours(path: str | Path) -> bool:
    try:
        with open(path, "rb") as file:
            return file.read(len(MAGIC)) == MAGIC
    except OSError as fault:
        raise RecordingError(f"{path}: {fault.strerror}") from fault


def _frames(entry: LogFrame, sequence: int) -> list[Frame]:
    if not entry.whole:
        return [entry.frame]
    return [Frame(entry.identifier, data) for data in fragment(entry.data, sequence)]


def _lines(text: bytes) -> list[bytes]:
    """The lines of what was said at once; what is not lines, as a rover's frames are not, is one piece."""
    return text.splitlines(keepends=True) if text.startswith((b"$", b"!")) else [text]


Begin = Callable[[Entry], bool]
"""Whether the entry is the one to begin with."""


def at_once(entry: Entry) -> bool:
    """The first one."""
    return True


def begin_at(text: str) -> Begin:
    """`12:30`, `12:30:15` (UTC, the first time it is that), `2026-07-27T12:30:00`, or `+90` s from the beginning.

    Raises ValueError that says what would be right.
    """
    if match := re.fullmatch(r"\+(\d+(?:\.\d+)?)", text):
        return _After(float(match[1]))
    if match := re.fullmatch(r"(\d\d?):(\d\d)(?::(\d\d(?:\.\d+)?))?", text):
        return _TimeOfDay(timedelta(hours=int(match[1]), minutes=int(match[2]), seconds=float(match[3] or 0)))
    try:
        moment = datetime.fromisoformat(text)
    except ValueError:
        raise ValueError(f'"{text}" should be a time like 12:30, 2026-07-27T12:30:00 (UTC) or +90 (s)') from None
    return partial(_not_before, (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp())


def _not_before(stamp: float, entry: Entry) -> bool:
    return entry.stamp is not None and entry.stamp >= stamp


class _After:
    """So many seconds after the first entry."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._first: float | None = None

    def __call__(self, entry: Entry) -> bool:
        if self._first is None:
            self._first = entry.now
        return entry.now >= self._first + self._seconds


class _TimeOfDay:
    """The first time that the clock shows it."""

    def __init__(self, time: timedelta) -> None:
        self._time = time
        self._stamp: float | None = None

    def __call__(self, entry: Entry) -> bool:
        if entry.stamp is None:
            return False
        if self._stamp is None:
            first = datetime.fromtimestamp(entry.stamp, UTC)
            moment = first.replace(hour=0, minute=0, second=0, microsecond=0) + self._time
            self._stamp = (moment if moment >= first else moment + A_DAY).timestamp()
        return entry.stamp >= self._stamp


class Player:
    """Sends what is due. `speed` is a multiple of the recording's own pace, None as fast as the link takes it.

    `position` is the recording's time in s, None before the first entry, and `stamp` its wall-clock time.
    """

    def __init__(
        self,
        playback: Playback,
        send: Callable[[Entry], None],
        *,
        speed: float | None = 1.0,
        busy: Callable[[], bool] = lambda: False,
    ) -> None:
        self.position: float | None = None
        self.stamp: float | None = None
        self.paused = False
        self._playback = playback
        self._send = send
        self._speed = speed
        self._busy = busy
        self._target: float | None = None
        self._wake = asyncio.Event()
        self._anchor = (0.0, 0.0)

    def pause(self) -> None:
        """Stand still, or go on."""
        self.paused = not self.paused
        self._wake.set()

    def seek(self, seconds: float) -> None:
        """Go on so much later, or earlier: at the earliest at the beginning."""
        self._target = (self.position or 0.0) + seconds if self._target is None else self._target + seconds
        self._wake.set()

    async def play(self, begin: Begin = at_once) -> None:
        """To the end. Raises RecordingError if no entry is the one to begin with."""
        while not await self._play_from(begin):
            target, self._target = self._target, None
            begin = partial(_reached, target)
        if self.position is None:
            raise RecordingError(f"{self._playback.path}: nothing to play from there on")

    async def _play_from(self, begin: Begin) -> bool:
        """Whether it came to the end; False: somebody wants to be elsewhere."""
        loop = asyncio.get_running_loop()
        begun = False
        for number, entry in enumerate(self._playback.entries()):
            if number % BATCH == 0:
                await self._breathe()
            if not begun:
                if not begin(entry):
                    continue
                begun, self._anchor = True, (loop.time(), entry.now)
            if not await self._until_due(entry.now):
                return False
            self.position, self.stamp = entry.now, entry.stamp
            self._count(entry)
            self._send(entry)
        return True

    def _count(self, entry: Entry) -> None:
        self._playback.played.frames += len(entry.frames)
        self._playback.played.lines += len(entry.lines)

    async def _breathe(self) -> None:
        """Let the loop do the rest of its work, and the link catch up."""
        await asyncio.sleep(0)
        while self._speed is None and self._busy():
            await asyncio.sleep(0.001)

    async def _until_due(self, now: float) -> bool:
        """Wait for the time of an entry; False if somebody wants to be elsewhere."""
        loop = asyncio.get_running_loop()
        while True:
            if self._target is not None:
                return False
            began, position = self._anchor
            if self.paused:
                wait = None
            elif self._speed is None or (wait := began + (now - position) / self._speed - loop.time()) <= 0:
                return True
            stood = loop.time()
            await self._woken(wait)
            if wait is None:  # time stood still
                self._anchor = (began + loop.time() - stood, position)

    async def _woken(self, within: float | None) -> None:
        self._wake.clear()
        try:
            await asyncio.wait_for(self._wake.wait(), within)
        except TimeoutError:
            return


def _reached(target: float | None, entry: Entry) -> bool:
    return target is None or entry.now >= target
