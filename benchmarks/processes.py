"""The processes of a live measurement, each pinned to a core, told what to do over a pipe.

```
source   core 0   puts frames on the bus: at a rate, sleeping in between (never spinning), or as fast as they are taken
reader   core 0   reads every output, and stamps each read
program  core 1   what is measured, alone there
```
The source stamps each frame just before it sends it, in memory that the reader shares.
"""

import mmap
import multiprocessing
import os
import select
import socket
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import msgspec

from timonel.nmea0183 import parp

CORES = sorted(os.sched_getaffinity(0))
HARNESS, PROGRAM = CORES[0], CORES[-1]
LONGEST_RUN = 1 << 22  # frames that can be stamped
CAN_FRAME_SIZE = 16
COMMAND_EVERY = 0.1  # s
COMMAND_FRAMES = 4  # of one 127237
READ_AT_ONCE = 1 << 18
PIECE = 4096  # a long buffer for each short piece would be a lot of memory
QUANTILES = {"p50": 0.5, "p99": 0.99, "p999": 0.999}

_fork = multiprocessing.get_context("fork")


class Stamps:
    """When each frame was sent, in ns, for both processes."""

    def __init__(self) -> None:
        self.times = memoryview(mmap.mmap(-1, 8 * LONGEST_RUN)).cast("q")


class Helper:
    """A process of ours at the other end of a pipe: it is given orders and answers each one."""

    def __init__(self, core: int, run: Callable[..., None], *arguments: Any) -> None:
        self._pipe, far = _fork.Pipe()
        self._process = _fork.Process(target=_helper, args=(core, run, far, *arguments), daemon=True)
        self._process.start()
        far.close()

    @property
    def pid(self) -> int:
        assert self._process.pid is not None
        return self._process.pid

    def order(self, *what: Any) -> None:
        self._pipe.send(what)

    def answer(self, within: float = 120.0) -> Any:
        """What it has to say; raises RuntimeError if it has nothing to say."""
        if not self._pipe.poll(within):
            raise RuntimeError("a process of the benchmark does not answer")
        try:
            return self._pipe.recv()
        except EOFError:
            raise RuntimeError("a process of the benchmark has ended") from None

    def ask(self, *what: Any) -> Any:
        self.order(*what)
        return self.answer()

    def end(self) -> None:
        self._process.terminate()
        self._process.join(5)


def _helper(core: int, run: Callable[..., None], pipe: Connection, *arguments: Any) -> None:
    os.sched_setaffinity(0, {core})
    try:
        run(pipe, *arguments)
    except BaseException:
        traceback.print_exc()
        raise


@contextmanager
def ending(*made: Helper) -> Iterator[None]:
    """Ends them all in the end."""
    try:
        yield
    finally:
        for helper in made:
            helper.end()


def cpu_seconds(pid: int) -> float:
    """What a process has used of all cores so far, with its time in the kernel."""
    threads = Path(f"/proc/{pid}/task").glob("*/schedstat")
    return sum(int(thread.read_text().split()[0]) for thread in threads) / 1e9


def resident_mib(pid: int | str = "self") -> float:
    """Memory of a process as it stands in the machine."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20


# The source -----------------------------------------------------------------------------------------------------


def run_source(pipe: Connection, bus: int, frames: list[bytes], stamps: Stamps) -> None:
    """Orders: `("paced", rate, count)` and `("flat out", seconds)`; the answer is the number of frames sent so far."""
    os.set_blocking(bus, True)
    sent = 0
    while True:
        match pipe.recv():
            case "paced", rate, count:
                _send_paced(bus, frames, stamps, sent, count, rate)
                sent += count
            case "flat out", seconds:
                sent += _send_flat_out(bus, frames, seconds)
        pipe.send(sent)


def _send_paced(bus: int, frames: list[bytes], stamps: Stamps, first: int, count: int, rate: float) -> None:
    begun = time.monotonic()
    for number in range(count):
        wait = begun + number / rate - time.monotonic()
        if wait > 0:
            time.sleep(wait)
        stamps.times[first + number] = time.monotonic_ns()
        os.write(bus, frames[(first + number) % len(frames)])


def _send_flat_out(bus: int, frames: list[bytes], seconds: float) -> int:
    """As fast as they are taken: the socket or pipe blocks when it is full."""
    end = time.monotonic() + seconds
    rounds = 0
    while time.monotonic() < end:
        for frame in frames:
            os.write(bus, frame)
        rounds += 1
    return rounds * len(frames)


# The reader -----------------------------------------------------------------------------------------------------


class Heard(msgspec.Struct):
    """What the reader heard while it listened; latencies in us, over all outputs."""

    sentences: list[int]
    """Of each output, STATUS not among them."""
    latencies: dict[str, float] = {}
    commands: dict[str, float] = {}
    """From a command line written to the last frame of its 127237 read."""


class Where(msgspec.Struct, frozen=True):
    """What to read: terminals, `clients` of a TCP port, what is `connected` already; and the far end of the bus."""

    bus: int
    terminals: tuple[str, ...] = ()
    address: tuple[str, int] | None = None
    clients: int = 0
    connected: int | None = None

    def open(self) -> list[int]:
        """Descriptors of all outputs."""
        opened = [os.open(path, os.O_RDWR | os.O_NOCTTY) for path in self.terminals]
        if self.address is not None:
            opened += [socket.create_connection(self.address).detach() for _ in range(self.clients)]
        if self.connected is not None:
            opened.append(self.connected)
        for fd in opened:
            os.set_blocking(fd, False)
        return opened


def run_reader(pipe: Connection, where: Where, places: dict[bytes, int], cycle: int, stamps: Stamps) -> None:
    """Orders: `("stamp", commands)` and `("count",)`, each until the next order; the answer is `Heard`."""
    outputs = where.open()
    pipe.send("ready")
    while True:
        match pipe.recv():
            case "stamp", commands:
                commander = Commander(outputs[0], where.bus) if commands else None
                reads = _stamp(pipe, outputs, commander)
                heard = evaluate(reads, outputs, Origins(places, cycle, stamps))
                heard.commands = quantiles(commander.latencies) if commander else {}
                pipe.send(heard)
            case ("count",):
                pipe.send(_count(pipe, outputs))


def _count(pipe: Connection, outputs: list[int]) -> Heard:
    """How many sentences each output gives until the next order."""
    sentences = dict.fromkeys(outputs, 0)
    poll = _epoll(pipe.fileno(), *outputs)
    while True:
        for fd, _ in poll.poll():
            if fd == pipe.fileno():
                return Heard(list(sentences.values()))
            data = os.read(fd, READ_AT_ONCE)
            sentences[fd] += data.count(b"\n") - data.count(b"$PARP")


def _stamp(pipe: Connection, outputs: list[int], commander: "Commander | None") -> list[tuple[int, int, bytes]]:
    """When each piece came from which output, until the next order."""
    reads: list[tuple[int, int, bytes]] = []
    poll = _epoll(pipe.fileno(), *outputs, *([commander.bus.fileno()] if commander else []))
    while True:
        for fd, _ in poll.poll(commander.wait() if commander else None):
            if fd == pipe.fileno():
                return reads
            if commander is not None and fd == commander.bus.fileno():
                commander.hear()
            else:
                data = os.read(fd, PIECE)
                reads.append((time.monotonic_ns(), fd, data))


def _epoll(*fds: int) -> select.epoll:
    poll = select.epoll()
    for fd in fds:
        poll.register(fd, select.EPOLLIN)
    return poll


class Commander:
    """Turns the boat ten times a second and waits for the frames that tell the pilot."""

    def __init__(self, terminal: int, bus: int) -> None:
        self.bus = socket.socket(fileno=os.dup(bus))
        self.latencies: list[float] = []
        self._terminal = terminal
        self._line = parp.command(parp.Verb.STBDTEN, 1)
        os.write(terminal, parp.command(parp.Verb.TAKECMD, 1) + parp.command(parp.Verb.ENGAGE, 1))
        self._due = time.monotonic() + COMMAND_EVERY
        self._written = 0
        self._frames = 0

    def wait(self) -> float:
        """Seconds until the next command, which is given when it is due."""
        if time.monotonic() >= self._due:
            self._due += COMMAND_EVERY
            self._frames = 0
            self._written = time.monotonic_ns()
            os.write(self._terminal, self._line)
        return max(0.0, self._due - time.monotonic())

    def hear(self) -> None:
        """A frame of the gateway: of the first commands they are only read."""
        self.bus.recv(CAN_FRAME_SIZE, socket.MSG_DONTWAIT)
        self._frames += 1
        if self._frames == COMMAND_FRAMES and self._written:
            self.latencies.append((time.monotonic_ns() - self._written) / 1000)


class Origins:
    """Which frame a sentence is from: the latest one before it that gives this sentence. Asked in order of time."""

    def __init__(self, places: dict[bytes, int], cycle: int, stamps: Stamps) -> None:
        self._places = places
        self._cycle = cycle
        self._times = stamps.times
        self._latest = 0

    def latency(self, line: bytes, now: int) -> float | None:
        """In us; None for a sentence that does not tell its frame."""
        times, latest = self._times, self._latest
        while 0 < times[latest + 1] <= now:
            latest += 1
        self._latest = latest
        place = self._places.get(line)
        if place is None or latest < place:
            return None
        return (now - times[latest - (latest - place) % self._cycle]) / 1000


def evaluate(reads: list[tuple[int, int, bytes]], outputs: list[int], origins: Origins) -> Heard:
    """Cut what came from each output into lines, and find where they are from."""
    sentences = dict.fromkeys(outputs, 0)
    rest = dict.fromkeys(outputs, b"")
    latencies = []
    for now, fd, data in reads:
        *lines, rest[fd] = (rest[fd] + data).split(b"\n")
        for line in lines:
            if not line.startswith(b"$PARP"):
                sentences[fd] += 1
                latencies.append(origins.latency(line + b"\n", now))
    return Heard(list(sentences.values()), quantiles([latency for latency in latencies if latency is not None]))


def quantiles(values: list[float]) -> dict[str, float]:
    """Median and the high ends; nothing of nothing."""
    values = sorted(values)
    return {name: values[int(part * len(values))] for name, part in QUANTILES.items()} if values else {}
