"""The processes of a live measurement, each pinned to a core, told what to do over a pipe.

```
source   core 0   puts frames on the bus: at a rate, sleeping in between (never spinning), or as fast as they are taken
reader   core 0   reads every output, and stamps each read
program  core 1   what is measured, alone there
```
The source stamps each frame just before it sends it, in memory that the reader shares.
"""

import errno
import json
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
def helpers(*made: Helper) -> Iterator[None]:
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
    """What the reader heard while it listened: latencies in us, over all outputs."""

    sentences: list[int]
    """Of each output, STATUS not among them."""
    latencies: list[float] = []
    commands: list[float] = []
    """From a command line written to the last frame of its 127237 read."""


class Where(msgspec.Struct, frozen=True):
    """What to read: `commands` is the terminal to write to, `bus` the far end of the bus."""

    terminals: tuple[str, ...] = ()
    address: tuple[str, int] | None = None
    clients: int = 0
    descriptor: int | None = None
    bus: int | None = None

    def open(self) -> list[int]:
        """Descriptors of all outputs."""
        opened = [os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK) for path in self.terminals]
        if self.address is not None:
            opened += [socket.create_connection(self.address).detach() for _ in range(self.clients)]
        if self.descriptor is not None:
            opened.append(self.descriptor)
        for fd in opened:
            os.set_blocking(fd, False)
        return opened


def run_reader(pipe: Connection, where: Where, places: dict[bytes, int], stamps: Stamps) -> None:
    """Orders: `("stamp", commands)` and `("count",)`, each until the next order; the answer is `Heard`."""
    reader = Reader(pipe, where, places, stamps)
    pipe.send("ready")
    while True:
        match pipe.recv():
            case "stamp", commands:
                heard = reader.stamp(commands)
            case "count",:
                heard = reader.count()
        pipe.send(heard)


class Reader:
    def __init__(self, pipe: Connection, where: Where, places: dict[bytes, int], stamps: Stamps) -> None:
        self._pipe = pipe.fileno()
        self._outputs = where.open()
        self._bus = where.bus
        self._places = places
        self._stamps = stamps
        self._poll = select.epoll()
        for fd in [self._pipe, *self._outputs]:
            self._poll.register(fd, select.EPOLLIN)

    def count(self) -> Heard:
        """How many sentences each output gives until something comes over the pipe."""
        sentences = dict.fromkeys(self._outputs, 0)
        while True:
            for fd, _ in self._poll.poll():
                if fd == self._pipe:
                    return Heard(list(sentences.values()))
                data = _read(fd)
                sentences[fd] += data.count(b"\n") - data.count(b"$PARP")

    def stamp(self, commands: bool) -> Heard:
        """When each sentence came; with `commands`, turn the boat ten times a second meanwhile."""
        reads: list[tuple[int, int, bytes]] = []
        commander = Commander(self._outputs[0], self._bus) if commands and self._bus is not None else None
        if commander is not None:
            self._poll.register(commander.bus, select.EPOLLIN)
        while True:
            for fd, _ in self._poll.poll(commander.wait() if commander else None):
                if fd == self._pipe:
                    if commander is not None:
                        self._poll.unregister(commander.bus)
                    return self._evaluate(reads, commander)
                if commander is not None and fd == commander.bus:
                    commander.hear()
                else:
                    data = _read(fd)
                    reads.append((time.monotonic_ns(), fd, data))

    def _evaluate(self, reads: list[tuple[int, int, bytes]], commander: "Commander | None") -> Heard:
        sentences = dict.fromkeys(self._outputs, 0)
        rest = dict.fromkeys(self._outputs, b"")
        latencies = []
        for now, fd, data in reads:
            *lines, rest[fd] = (rest[fd] + data).split(b"\n")
            for line in lines:
                if not line.startswith(b"$PARP"):
                    sentences[fd] += 1
                    latencies += self._latency(line + b"\n", now)
        return Heard(list(sentences.values()), latencies, commander.latencies if commander else [])

    def _latency(self, line: bytes, now: int) -> list[float]:
        """Since the latest frame before `now` that gives this sentence."""
        place = self._places.get(line)
        if place is None:
            return []
        size = len(self._places_of_cycle())
        times = self._stamps.times
        number = place
        while number + size < LONGEST_RUN and 0 < times[number + size] <= now:
            number += size
        return [(now - times[number]) / 1000] if 0 < times[number] <= now else []
