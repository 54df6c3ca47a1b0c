"""The program at work, with the far ends of all its wires in the hands of a test.

`Program` is a process. `UsbSerial` and `Terminal` are what a station sees of its port, `Backbone` is the CAN adapter
with the bus behind it. `Bench` puts them together: a gateway with four stations, each with an IN and an OUT.
"""

import asyncio
import ctypes
import json
import os
import random
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from math import degrees, radians
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self

from tests.unit.cli.programs import ENVIRONMENT, TIMONEL
from tests.unit.links.far_side import Adapter
from timonel.core.frame import Frame
from timonel.nmea2000.fastpacket import Reassembler
from timonel.nmea2000.identifier import join, split
from timonel.nmea2000.lookups import HeadingReference, SteeringMode
from timonel.nmea2000.messages.steering import HeadingTrackControl, Rudder, VesselHeading

Kind = Literal["serial", "pty"]
STATIONS = (1, 2, 3, 4)
PILOT_PGN = 127237
TICK = 0.1  # s between the frames of a 10 Hz source


def free_port() -> int:
    """A TCP port that nobody has now, nor is given for a connection of his own before it is used: those begin at 32768.

    As many tests as there are processes ask at a time, so it is none that follows the one before.
    """
    while True:
        port = random.SystemRandom().randrange(20_000, 32_000)
        with suppress(OSError), socket.create_server(("127.0.0.1", port)):
            return port


async def until(condition: Callable[[], object], what: str, within: float = 10.0) -> float:
    """Wait for it and tell how long it took, s; fail when it does not come."""
    began = time.monotonic()
    while not condition():
        assert time.monotonic() - began < within, f"not within {within:g} s: {what}"
        await asyncio.sleep(0.002)
    return time.monotonic() - began


def die_with_parent() -> None:
    """A test run that is killed must leave no gateway behind (prctl(2), PR_SET_PDEATHSIG)."""
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)


class Program:
    """`timonel ARGUMENTS`; what it logs goes to `log_path`, what it prints to `output_path`."""

    def __init__(self, directory: Path, *arguments: str) -> None:
        self.log_path = directory / "log.jsonl"
        self.output_path = directory / "output.txt"
        self.arguments = arguments
        self.process: subprocess.Popen[bytes] | None = None
        self._before = 0

    def start(self) -> None:
        self._before = len(self.log("running"))
        with self.log_path.open("ab") as log, self.output_path.open("ab") as output:
            self.process = subprocess.Popen(
                [*TIMONEL, *self.arguments],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=log,
                env=ENVIRONMENT | {"STATE_DIRECTORY": str(self.log_path.parent)},
                preexec_fn=die_with_parent,
            )

    async def running(self) -> None:
        """Wait until it says that all its links were tried."""
        await until(lambda: len(self.log("running")) > self._before or self.ended, "running", 30.0)
        assert not self.ended, self.log_path.read_text()

    @property
    def pid(self) -> int:
        assert self.process is not None
        return self.process.pid

    @property
    def ended(self) -> bool:
        return self.process is None or self.process.poll() is not None

    async def stop(self) -> float:
        """SIGTERM; how long it took to end, s."""
        assert self.process is not None
        self.process.terminate()
        return await until(lambda: self.ended, "end after SIGTERM")

    def kill(self) -> None:
        """As a power cut would."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()

    def descriptors(self) -> int:
        return len(os.listdir(f"/proc/{self.pid}/fd"))

    def log(self, text: str = "") -> list[dict[str, Any]]:
        """The records so far, or those whose text is `text`."""
        written = self.log_path.read_text() if self.log_path.exists() else ""
        whole = written[: written.rfind("\n") + 1]
        records = [json.loads(line) for line in whole.splitlines() if line.startswith("{")]
        return [record for record in records if not text or record["text"] == text]

    def events(self, kind: str) -> list[dict[str, Any]]:
        """The events of one kind so far."""
        return [record for record in self.log() if record.get("event") == kind]

    async def health(self) -> dict[str, dict[str, int]]:
        """Its counters now, by link."""
        before = len(self._reports())
        os.kill(self.pid, signal.SIGUSR1)
        await until(lambda: len(self._reports()) > before, "the counters")
        return self._reports()[-1]

    def _reports(self) -> list[dict[str, dict[str, int]]]:
        return [record for record in self.log() if record.get("event") == "health"]

    async def __aenter__(self) -> Self:
        self.start()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.kill()


class FarEnd:
    """The other end of a wire: takes down each line that comes out of it, with the loop's time."""

    LINE_END = b"\n"

    def __init__(self, path: Path) -> None:
        self.path = path
        self.fd: int | None = None
        self.heard: list[tuple[float, str]] = []
        self._rest = b""

    def _listen(self, fd: int) -> None:
        self.fd = fd
        self._rest = b""
        asyncio.get_running_loop().add_reader(fd, self._readable)

    def sleep(self) -> None:
        """Read no more until `wake`."""
        asyncio.get_running_loop().remove_reader(self.fd or -1)

    def wake(self) -> None:
        asyncio.get_running_loop().add_reader(self.fd or -1, self._readable)

    def _leave(self) -> None:
        if self.fd is not None:
            asyncio.get_running_loop().remove_reader(self.fd)
        self.fd = None

    def _readable(self) -> None:
        assert self.fd is not None
        try:
            data = os.read(self.fd, 65536)
        except BlockingIOError:
            return
        except OSError:  # nobody has the other end open; that it will be reported does not help
            self._look_away(self.fd)
            return
        now = asyncio.get_running_loop().time()
        *lines, self._rest = (self._rest + data).split(self.LINE_END)
        self.heard += [(now, line.decode("latin-1").strip()) for line in lines]

    def _look_away(self, fd: int) -> None:
        loop = asyncio.get_running_loop()
        loop.remove_reader(fd)
        loop.call_later(0.01, lambda: loop.add_reader(fd, self._readable) if self.fd == fd else None)

    def say(self, data: bytes) -> int:
        """Put on the wire what there is room for; how many bytes that was."""
        try:
            return 0 if self.fd is None else os.write(self.fd, data)
        except OSError:
            return 0

    async def hears(self, beginning: str, since: int = 0, within: float = 5.0) -> tuple[float, str]:
        """The first line after the `since`-th that begins so; waits for it."""

        def found() -> list[tuple[float, str]]:
            return [entry for entry in self.heard[since:] if entry[1].startswith(beginning)]

        await until(found, f"{beginning} on {self.path.name}", within)
        return found()[0]


class UsbSerial(FarEnd):
    """A serial adapter that can be pulled: one path, a new device at every plugging."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._adapter: Adapter | None = None

    def plug(self) -> None:
        if self._adapter is None:
            self._adapter = Adapter(self.path)
        else:
            self._adapter.plug()
        self._listen(self._adapter.fd)

    def pull(self) -> None:
        if self.fd is not None and self._adapter is not None:
            self._leave()
            self._adapter.pull()


class Terminal(FarEnd):
    """A pseudo-terminal that the program makes and a program on the same machine opens."""

    def plug(self) -> None:
        self._listen(os.open(self.path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK))

    def pull(self) -> None:
        if (fd := self.fd) is not None:
            self._leave()
            os.close(fd)


class Backbone(UsbSerial):
    """A bus behind a Lawicel adapter. While `frames` is not empty, they are on the bus ten times a second."""

    LINE_END = b"\r"

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.frames: list[Frame] = []

    def plug(self) -> None:
        self.heard.clear()
        super().plug()

    @property
    def opened(self) -> bool:
        """Whether the program has told the adapter to open its channel."""
        return any(line == "O" for _, line in self.heard)

    async def sail(self) -> None:
        """For ever."""
        loop = asyncio.get_running_loop()
        tick = loop.time()
        while True:
            if self.opened:
                self.say(b"".join(map(line_of, self.frames)))
            tick = max(tick + TICK, loop.time())
            await asyncio.sleep(tick - loop.time())

    def commands(self) -> list[tuple[float, SteeringMode | None, float | None]]:
        """What the pilot was told since the adapter was plugged: when, the mode, and the course in degrees."""
        reassembler, commands = Reassembler(), []
        for now, line in self.heard:
            if not line.startswith("T") or split(identifier := int(line[1:9], 16)).pgn != PILOT_PGN:
                continue
            if payload := reassembler.receive(identifier, bytes.fromhex(line[10:]), now):
                told = HeadingTrackControl.decode(payload)
                course = told.heading_to_steer_course
                commands.append((now, told.steering_mode, None if course is None else round(degrees(course), 1)))
        return commands


def line_of(frame: Frame) -> bytes:
    """What the adapter says when it hears a frame of 29 bits."""
    return b"T%08X%d%s\r" % (frame.identifier, len(frame.data), frame.data.hex().upper().encode())


def heading(course: float) -> Frame:
    """Where the bow points, true."""
    message = VesselHeading(
        sid=None, heading=radians(course), deviation=None, variation=None, reference=HeadingReference.TRUE
    )
    return Frame(join(2, 127250, 10), message.encode())


def rudder(angle: float) -> Frame:
    message = Rudder(instance=0, direction_order=None, angle_order=None, position=radians(angle))
    return Frame(join(2, 127245, 11), message.encode())


def write_configuration(
    path: Path, bus: str, stations: Mapping[int, str], outputs: Iterable[str] = (), more: str = ""
) -> Path:
    """`stations` are lines of their tables by number: `url = ...`, or `in = ...` and `out = ...`."""
    tables = ['[vehicle]\nkind = "boat"', more, f'[bus]\nurl = "{bus}"']
    tables += [f"[[station]]\nid = {number}\n{lines}" for number, lines in stations.items()]
    tables += [f'[[output]]\nurl = "{url}"' for url in outputs]
    path.write_text("\n".join(tables) + "\n")
    return path


def _shows_the_boat(out: FarEnd) -> bool:
    """Whether a STATUS had a heading and a rudder angle."""
    return any(line.startswith("$PARP,STATUS,") and all(line.split(",")) for _, line in out.heard)


class Bench:
    """`timonel run` with a bus and four stations; entered, it runs and every station sees the heading.

    `kinds` is how each station is wired: `serial` to adapters that the bench has, `pty` to terminals of the program.
    """

    def __init__(
        self,
        directory: Path,
        *,
        kinds: Mapping[int, Kind] | None = None,
        outputs: Iterable[str] = (),
        more: str = "",
        frames: Iterable[Frame] = (),
    ) -> None:
        self.kinds = kinds or dict.fromkeys(STATIONS, "serial")
        self.bus = Backbone(directory / "can")
        self.bus.frames = list(frames) or [heading(182.5), rudder(0.0)]
        self.ins = {number: self._far_end(directory / f"in{number}", number) for number in STATIONS}
        self.outs = {number: self._far_end(directory / f"out{number}", number) for number in STATIONS}
        stations = {number: self._table(number) for number in STATIONS}
        bus = f"slcan://{self.bus.path}?bitrate=250000"
        path = write_configuration(directory / "boat.toml", bus, stations, outputs, more)
        self.program = Program(directory, "run", str(path))

    def _far_end(self, path: Path, number: int) -> UsbSerial | Terminal:
        return UsbSerial(path) if self.kinds[number] == "serial" else Terminal(path)

    def _table(self, number: int) -> str:
        scheme = self.kinds[number]
        return f'in = "{scheme}://{self.ins[number].path}"\nout = "{scheme}://{self.outs[number].path}"'

    @property
    def ports(self) -> list[UsbSerial | Terminal]:
        return [*self.ins.values(), *self.outs.values()]

    async def __aenter__(self) -> Self:
        for end in (self.bus, *self.ports):
            if isinstance(end, UsbSerial):
                end.plug()
        self._sailing = asyncio.get_running_loop().create_task(self.bus.sail())
        self.program.start()
        try:
            await self.program.running()
            for end in self.ports:
                if isinstance(end, Terminal):
                    end.plug()
            await until(lambda: all(map(_shows_the_boat, self.outs.values())), "STATUS with a heading", 30.0)
        except BaseException:
            await self._end()
            raise
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._end()

    async def _end(self) -> None:
        self._sailing.cancel()
        await asyncio.gather(self._sailing, return_exceptions=True)
        self.program.kill()
        for end in (self.bus, *self.ports):
            end.pull()

    def say(self, station: int, sentence: str | bytes) -> None:
        """A sentence on a station's IN port."""
        line = sentence.encode() if isinstance(sentence, str) else sentence
        written = self.ins[station].say(line.rstrip() + b"\r\n")
        assert written == len(line.rstrip()) + 2, f"no room on the IN port of station {station}"

    async def ask(self, station: int, sentence: str | bytes, answer: str, within: float = 5.0) -> float:
        """Say a sentence and wait until the same station's OUT port answers; how long it took, s."""
        out = self.outs[station]
        mark, began = len(out.heard), asyncio.get_running_loop().time()
        self.say(station, sentence)
        when, _ = await out.hears(answer, mark, within)
        return when - began
