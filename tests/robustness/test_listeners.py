"""A listener that stops reading delays nobody, and hears the newest when it goes on."""

import asyncio
import re
import socket
from bisect import bisect_right
from pathlib import Path
from typing import Self

import pytest

from tests.program import Bench, free_port, heading, line_of, rudder, until
from timonel.nmea0183.checksum import seal

PORTION = 2  # headings and rudder angles every 5 ms
PAUSE = 0.005  # s
RATES = "[sentences]\nHDT = 1000\nTHS = 1000\nRSA = 1000"
DELAY = 0.1  # s that others may hear something after it was on the bus
ASLEEP = 6.0  # s; the system takes what comes in the first three or so
TRIES = 3  # a busy computer may spoil one
STEADY = line_of(rudder(-12.3))
HDT = re.compile(r"\$IIHDT,(\d{1,3})\.(\d),T\*[0-9A-F]{2}")


class Turning:
    """A boat that turns by a tenth of a degree a frame, 400 times a second: the heading tells when it was."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self.sent: list[float] = []

    async def run(self) -> None:
        """For ever."""
        loop = asyncio.get_running_loop()
        due = loop.time()
        while True:
            now = loop.time()
            first = len(self.sent)
            lines = [line_of(heading(n % 3600 / 10)) + STEADY for n in range(first, first + PORTION)]
            if self._bench.bus.say(b"".join(lines)) == sum(map(len, lines)):
                self.sent += [now] * PORTION
            due = max(due + PAUSE, now)
            await asyncio.sleep(due - loop.time())

    def age(self, when: float, line: str) -> float:
        """How long before `when` the heading of a sentence was on the bus, s; the same comes again after 9 s."""
        match = HDT.fullmatch(line)
        assert match is not None, line
        newest = bisect_right(self.sent, when) - 1
        return when - self.sent[newest - (newest - int(match[1]) * 10 - int(match[2])) % 3600]

    def worst_age(self, heard: list[tuple[float, str]]) -> float:
        return max(self.age(when, line) for when, line in heard)


class Reader:
    """A TCP client that takes down what it hears, with the time, while it is awake."""

    def __init__(self, port: int, buffer: int | None = None) -> None:
        self.stream = socket.socket()
        if buffer is not None:
            self.stream.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
        self.stream.connect(("127.0.0.1", port))
        self.stream.setblocking(False)
        self.heard: list[tuple[float, str]] = []
        self._rest = b""

    def wake(self) -> None:
        asyncio.get_running_loop().add_reader(self.stream, self._read)

    def _read(self) -> None:
        now = asyncio.get_running_loop().time()
        *lines, self._rest = (self._rest + self.stream.recv(65536)).split(b"\r\n")
        self.heard += [(now, line.decode()) for line in lines]

    def headings(self) -> list[tuple[float, str]]:
        return [(when, line) for when, line in self.heard if line.startswith("$IIHDT")]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        asyncio.get_running_loop().remove_reader(self.stream)
        self.stream.close()


async def watch(directory: Path) -> float:
    """The worst age that a healthy reader heard while another one slept, s."""
    port = free_port()
    async with Bench(directory, outputs=[f"tcp-listen://127.0.0.1:{port}"], more=RATES) as bench:
        bench.bus.frames = []
        with Reader(port, buffer=4096) as sleeper, Reader(port) as healthy:
            healthy.wake()
            turning = Turning(bench)
            turns = asyncio.create_task(turning.run())
            await asyncio.sleep(ASLEEP)
            worst = turning.worst_age(healthy.headings())
            sleeper.wake()
            await until(lambda: sleeper.heard and turning.age(*sleeper.headings()[-1]) < DELAY, "the newest")
            turns.cancel()
            assert len(healthy.headings()) > 0.5 * len(turning.sent)  # two a wake-up, by their ceiling
            assert len(healthy.headings()) - len(sleeper.headings()) > 1000  # it was not kept for the sleeper
            assert all(line.encode() + b"\r\n" == seal(line[1:-3]) for _, line in sleeper.heard)
            assert (await bench.program.health())[f"tcp-listen://127.0.0.1:{port}"]["replaced"] > 1000
        return worst


@pytest.mark.timeout(90)
def test_a_tcp_reader_that_stops_reading_delays_nobody_and_wakes_to_the_newest(tmp_path: Path) -> None:
    worst: list[float] = []
    while not worst or (min(worst) > DELAY and len(worst) < TRIES):
        directory = tmp_path / str(len(worst))
        directory.mkdir()
        worst.append(asyncio.run(watch(directory)))
    print("worst age at the healthy reader, ms:", [round(age * 1e3, 1) for age in worst])
    assert min(worst) <= DELAY


def test_a_terminal_that_nobody_reads_delays_nobody(tmp_path: Path) -> None:
    async def scene() -> None:
        loop = asyncio.get_running_loop()
        async with Bench(tmp_path, more=RATES) as bench:
            bench.outs[2].sleep()
            turns = asyncio.create_task(Turning(bench).run())
            await asyncio.sleep(2.0)
            took = [await bench.ask(1, "$PARP,TAKECMD,000.0,01*41", "$PARP,STATUS,", within=2.0) for _ in range(5)]
            turns.cancel()
            assert min(took) < DELAY
            assert (await bench.program.health())["Station 2 OUT"]["replaced"] > 0
            mark, again = len(bench.outs[2].heard), loop.time()
            bench.outs[2].wake()
            when, _ = await bench.outs[2].hears("$PARP,STATUS", mark, 2.0)
            assert when - again < 1.0

    asyncio.run(scene())
