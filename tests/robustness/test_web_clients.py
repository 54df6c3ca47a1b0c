"""Two hundred consoles, some of which never read or hardly, delay neither each other nor the wires."""

import asyncio
import re
from pathlib import Path

import pytest

from tests.program import Bench, free_port, until
from tests.web_client import WebClient
from timonel.nmea0183 import parp
from timonel.nmea0183.parp import Verb

CLIENTS, DEAF, SLOW = 200, 20, 20
SLOW_RATE = 1000  # bytes a second
SMALL = 4096  # bytes of a reader's own buffer
IN_TIME = 0.100  # s, p99
WIRE_IN_TIME = 0.050  # s
MORE_MEMORY = 64  # MB
TRIES = 3  # a busy computer may spoil one
WARM_UP = 3.0  # s
CUT_AFTER = 30.0  # s that a client takes nothing
CLOCK = re.compile(rb'"clock":([0-9.]+)')


def memory(pid: int) -> float:
    """Resident, in MB."""
    status = Path(f"/proc/{pid}/status").read_text()
    (size,) = re.findall(r"VmRSS:\s+(\d+) kB", status)
    return int(size) / 1024


class Crowd:
    """All of them; the deaf and the slow take nothing by themselves."""

    def __init__(self, port: int) -> None:
        self.deaf = [WebClient(port, SMALL) for _ in range(DEAF)]
        self.slow = [WebClient(port, SMALL) for _ in range(SLOW)]
        self.others = [WebClient(port) for _ in range(CLIENTS - DEAF - SLOW)]
        self.all = [*self.deaf, *self.slow, *self.others]

    async def enter(self) -> None:
        for client in self.all:
            await client.connect()
            assert client.status == 101
        for client in self.others:
            client.wake()

    async def crawl(self) -> None:
        """Let the slow ones take their kilobyte a second, for ever."""
        while True:
            for client in self.slow:
                client.read(SLOW_RATE // 10)
            await asyncio.sleep(0.1)

    def delays(self, since: float) -> list[float]:
        """From when something was put together until it was read, s; of all others together."""
        return sorted(
            when - float(clock[1])
            for client in self.others
            for when, data in client.heard
            if when > since and (clock := CLOCK.search(data)) is not None
        )

    def leave(self) -> None:
        for client in self.all:
            client.close()


async def ask(bench: Bench, station: int) -> float:
    """A command over a wire; until the wire tells that it was heard, s."""
    return await bench.ask(station, parp.command(Verb.TAKECMD, station), "$PARP,STATUS")


async def crowded(directory: Path, seconds: float) -> tuple[float, float, float]:
    """The p99 of what consoles hear, of what the wires hear (s), and the memory for them (MB)."""
    port = free_port()
    async with Bench(directory, more=f'[web]\nlisten = "127.0.0.1:{port}"') as bench:
        before = memory(bench.program.pid)
        crowd = Crowd(port)
        await crowd.enter()
        crawling = asyncio.get_running_loop().create_task(crowd.crawl())
        await asyncio.sleep(WARM_UP)
        began = asyncio.get_running_loop().time()
        answers = []
        while asyncio.get_running_loop().time() < began + seconds:
            await asyncio.sleep(0.1)
            answers.append(await ask(bench, 1))
        delays = crowd.delays(began)
        more = memory(bench.program.pid) - before
        everybody = min(len(client.heard) for client in crowd.others)
        assert everybody > seconds * 5, "who reads hears of it several times a second"
        if seconds > CUT_AFTER:
            await until(lambda: _are_cut(crowd.deaf), "who takes nothing is cut off", 10.0)
        crawling.cancel()
        crowd.leave()
        answers.sort()
        answers.sort()
        return delays[int(len(delays) * 0.99)], answers[int(len(answers) * 0.99)], more


def _are_cut(clients: list[WebClient]) -> bool:
    """Whether nothing can be said to them any more."""
    for client in clients:
        try:
            client.stream.send(b"\x8a\x80\x00\x00\x00\x00")  # a pong that nobody asked for
        except ConnectionError:
            continue
        return False
    return True


async def holds(directory: Path, seconds: float) -> None:
    for place in range(TRIES):
        (directory / str(place)).mkdir()
        delay, answer, more = await crowded(directory / str(place), seconds)
        print(f"consoles p99 {delay * 1e3:.1f} ms, wire p99 {answer * 1e3:.1f} ms, +{more:.1f} MB")
        if delay <= IN_TIME and answer <= WIRE_IN_TIME:
            break
    assert delay <= IN_TIME
    assert answer <= WIRE_IN_TIME
    assert more <= MORE_MEMORY


def test_consoles_that_do_not_read_delay_nobody(tmp_path: Path) -> None:
    asyncio.run(holds(tmp_path, 8.0))


@pytest.mark.slow
def test_consoles_that_do_not_read_delay_nobody_for_a_minute_and_are_cut_off(tmp_path: Path) -> None:
    asyncio.run(holds(tmp_path, 60.0))
