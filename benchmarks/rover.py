"""The rover's controller: from a UART to the bus and back, and what one frame costs, beside cantools.

    python -m benchmarks.rover [--json] [--passes 5] [--seconds 6]

The gateway that `timonel run` makes is alone on one core, its station on a pseudo-terminal, its bus a pair of sockets.
All frames go at 50 Hz: 100, 101, 115, 119 and 120 up the UART, 102 and 103 out of the mixer, the telemetry from the bus
to the UART (111 with its twelve bytes is no CAN frame, and stays away). A latency counts from just before the write of
a stick to just after 103, the second of its two set points, was read. `strzyga` needs the next `#`, or 5 ms of silence,
to prove a frame: with a frame behind the stick in the same write it has it at once, a stick alone is proved by the next
frame on the line, 1.1 ms later. `strzyga-crc` needs nothing.
"""

import argparse
import asyncio
import json
import os
import select
import socket
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from multiprocessing.connection import Connection
from random import Random
from statistics import mean, median
from timeit import Timer
from typing import Any

import cantools.database
import cantools.database.can
import msgspec
import numpy as np

from benchmarks.channel import realistic
from benchmarks.live_gateway import bus_pair
from benchmarks.processes import HARNESS, PROGRAM, Helper, cpu_seconds, ending, quantiles
from benchmarks.table import table
from timonel.gateway.gateway import Channel, Gateway
from timonel.interop.dbc import export
from timonel.links.pty import PtyLink
from timonel.links.socketcan import SocketCanLink
from timonel.vehicles.rover.declaration import Party
from timonel.vehicles.rover.framing import DIALECTS
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.segments import SINGLE
from timonel.vehicles.rover.settings import Port, RoverSettings
from timonel.vehicles.rover.vehicle import PERMIT, Rover

Figures = dict[str, float]
TICK = 0.02  # s: 50 Hz
CAN_FRAME = 16
STATION = "Router"
PROTOCOL = Protocol()
TELEMETRY = {number: size for number, size in PROTOCOL.lengths(Party.OPERATOR).items() if size <= SINGLE}
UNIQUE = [number for number, size in TELEMETRY.items() if size >= 4]  # with room for a number of their own
LIMITS = ((115, b"\x14"), (119, b"\x14"), (120, b"\xc8"))
LEFT_SET_POINTS = 103
MANY = 100_000
RUNS, ROUNDS = 2000, 60


# The gateway --------------------------------------------------------------------------------------


def run_controller(pipe: Connection, bus: int, terminal: str, dialect: str) -> None:
    """Orders: `("counters",)`."""
    asyncio.run(_run(pipe, bus, terminal, dialect))


async def _run(pipe: Connection, bus: int, terminal: str, dialect: str) -> None:
    loop = asyncio.get_running_loop()
    settings = RoverSettings(dialect=dialect)  # type: ignore[arg-type]
    rover = Rover(settings, [Port(STATION, 1)], loop.time(), PROTOCOL)
    can = SocketCanLink("lo", make=lambda _: socket.socket(fileno=bus), name="bus")
    link = PtyLink(terminal, name=STATION)
    gateway = Gateway(rover, can, [Channel(STATION, link, link)])
    await gateway.open()

    def answer() -> None:
        pipe.recv()
        frames = rover.framing()[STATION].counters.frames
        pipe.send({"can": can.counters.frames_in, "uart": frames, "permitted": rover.drive.permitted})

    loop.add_reader(pipe.fileno(), answer)
    pipe.send("ready")
    await gateway.failed.wait()


# Its surroundings ---------------------------------------------------------------------------------


class Latencies(msgspec.Struct):
    """In us."""

    up: list[float]
    """From the stick to the wheels."""
    down: list[float]
    """From the module to the operator."""


class Yard:
    """The far ends of UART and bus."""

    def __init__(self, terminal: str, bus: socket.socket, dialect: str, alone: bool) -> None:
        self.uart = os.open(terminal, os.O_RDWR | os.O_NOCTTY)
        self.bus = bus
        self.write = DIALECTS[dialect].write
        self._alone = alone
        self._poll = select.epoll()
        self._poll.register(self.uart, select.EPOLLIN)
        self._poll.register(bus.fileno(), select.EPOLLIN)
        self._sticks: dict[int, int] = {}
        self._lines: dict[bytes, int] = {}
        self._count = 0
        self.latencies = Latencies([], [])

    def enable(self) -> None:
        for _ in range(20):
            os.write(self.uart, self.write(100, b"\0\0") + self.write(101, PERMIT))
            self._listen(time.monotonic() + TICK)

    def paced(self, seconds: float) -> None:
        """Everything at 50 Hz, spread over each 20 ms."""
        actions: list[Callable[[], None]] = [self._stick, partial(self._say, 101, PERMIT)]
        actions += [partial(self._say, *limit) for limit in LIMITS]
        actions += [partial(self._module, number) for number in TELEMETRY]
        begun = time.monotonic()
        for step in range(int(seconds / TICK) * len(actions)):
            self._listen(begun + step * TICK / len(actions))
            actions[step % len(actions)]()
        self._listen(time.monotonic() + 0.1)

    def _stick(self) -> None:
        """Alone, or with the next frame behind it that proves it."""
        self._count += 1
        percent = 1 + self._count % 100
        line = self.write(100, bytes((0, -percent & 0xFF)))
        if not self._alone:
            line += self.write(*LIMITS[0])
        self._sticks[percent] = time.monotonic_ns()
        os.write(self.uart, line)

    def _say(self, number: int, data: bytes) -> None:
        os.write(self.uart, self.write(number, data))

    def _module(self, number: int) -> None:
        self._count += 1
        data = (
            self._count.to_bytes(8, "little")[: TELEMETRY[number]] if number in UNIQUE else b"\x01" * TELEMETRY[number]
        )
        if number in UNIQUE:
            self._lines[self.write(number, data)] = time.monotonic_ns()
        self.bus.send(packed(number, data))

    def _listen(self, until: float) -> None:
        while (left := until - time.monotonic()) > 0:
            for descriptor, _ in self._poll.poll(left):
                if descriptor == self.uart:
                    self._hear_uart(os.read(self.uart, 4096))
                else:
                    self._hear_bus(self.bus.recv(CAN_FRAME))

    def _hear_bus(self, raw: bytes) -> None:
        now = time.monotonic_ns()
        if int.from_bytes(raw[:4], "little") == LEFT_SET_POINTS and (sent := self._sticks.pop(raw[8], 0)):
            self.latencies.up.append((now - sent) / 1000)

    def _hear_uart(self, data: bytes) -> None:
        now = time.monotonic_ns()
        for line in [line for line in self._lines if line in data]:
            self.latencies.down.append((now - self._lines.pop(line)) / 1000)


def packed(number: int, data: bytes) -> bytes:
    """A CAN frame as a socket has it."""
    return number.to_bytes(4, "little") + bytes((len(data), 0, 0, 0)) + data.ljust(8, b"\0")


@contextmanager
def controller(dialect: str, alone: bool) -> Iterator[tuple[Yard, Helper]]:
    """A gateway whose station is there, with motion permitted."""
    near, far = bus_pair()
    with tempfile.TemporaryDirectory() as directory:
        terminal = f"{directory}/router"
        helper = Helper(PROGRAM, run_controller, near.fileno(), terminal, dialect)
        with ending(helper), near, far:
            helper.answer()
            yard = Yard(terminal, far, dialect, alone)
            time.sleep(0.5)  # until the gateway has seen that somebody opened the terminal
            yard.enable()
            assert helper.ask("counters")["permitted"]
            yield yard, helper
            os.close(yard.uart)


def live(dialect: str, alone: bool, seconds: float) -> Figures:
    """All frames at 50 Hz."""
    with controller(dialect, alone) as (yard, helper):
        used = cpu_seconds(helper.pid)
        yard.paced(seconds)
        used = cpu_seconds(helper.pid) - used
    up, down = quantiles(yard.latencies.up), quantiles(yard.latencies.down)
    share = len(yard.latencies.up) / (seconds / TICK)
    return {
        "up_p50": up["p50"],
        "up_p99": up["p99"],
        "up_share": 100 * share,
        "down_p50": down["p50"],
        "down_p99": down["p99"],
        "cpu": 100 * used / seconds,
    }


def flat_out(seconds: float) -> Figures:
    """Frames taken in a second when there are always more: from the bus, and from the UART."""
    taken: Figures = {}
    with controller("strzyga", alone=False) as (yard, helper):
        threading.Thread(target=_drain, args=(yard.uart, yard.bus), daemon=True).start()
        frames = [packed(number, b"\x01" * size) for number, size in TELEMETRY.items()]
        sticks = b"".join(yard.write(100, bytes((0, -x & 0xFF))) for x in range(1, 101))
        for name, put in (("can", partial(_put, yard.bus, frames)), ("uart", partial(os.write, yard.uart, sticks))):
            before, begun = helper.ask("counters")[name], time.monotonic()
            while time.monotonic() < begun + seconds:
                put()
            took = time.monotonic() - begun
            taken[f"{name}_frames_s"] = (helper.ask("counters")[name] - before) / took
    return taken


def _put(bus: socket.socket, frames: list[bytes]) -> None:
    for frame in frames:
        bus.send(frame)


def _drain(uart: int, bus: socket.socket) -> None:
    poll = select.epoll()
    poll.register(uart, select.EPOLLIN)
    poll.register(bus.fileno(), select.EPOLLIN)
    try:
        while True:
            for descriptor, _ in poll.poll():
                os.read(descriptor, 4096)
    except OSError:
        return  # the measurement is over


# One frame ----------------------------------------------------------------------------------------


def codec() -> dict[str, Figures]:
    """Each frame of the telemetry that fits CAN, decoded: us a frame, columns ns a frame."""
    database = cantools.database.load_string(export(PROTOCOL), "dbc")
    assert isinstance(database, cantools.database.can.Database)
    rows: dict[str, Figures] = {}
    random = Random(1)
    for number, size in TELEMETRY.items():
        data = realistic(number, random)
        payloads = np.frombuffer(b"".join(realistic(number, random) for _ in range(100)) * (MANY // 100), np.uint8)
        many = payloads.reshape(MANY, size)
        rows[f"{number} {PROTOCOL.declarations[number].__name__}"] = {
            "ours": best(partial(PROTOCOL.decode, number, data)),
            "cantools": best(partial(database.decode_message, number, data)),
            "columns": min(Timer(partial(PROTOCOL.columns, number, many)).repeat(7, 1)) / MANY * 1e9,
        }
    rows["mean"] = {key: mean(row[key] for row in rows.values()) for key in ("ours", "cantools", "columns")}
    return rows


def best(what: Callable[[], Any]) -> float:
    """The shortest of many runs, in us."""
    return min(Timer(what).repeat(ROUNDS, RUNS)) / RUNS * 1e6


def measure(passes: int, seconds: float) -> dict[str, Any]:
    """All of it; of what is live the medians of so many passes."""
    os.sched_setaffinity(0, {HARNESS})
    cases = {
        "strzyga, a frame behind": ("strzyga", False),
        "strzyga, the stick alone": ("strzyga", True),
        "strzyga-crc": ("strzyga-crc", True),
    }
    rows: dict[str, list[Figures]] = {name: [] for name in cases}
    rates = []
    for _ in range(passes):
        for name, case in cases.items():
            rows[name].append(live(*case, seconds))
        rates.append(flat_out(min(seconds, 2.0)))
    flows = {name: medians(found) for name, found in rows.items()}
    return {"live": flows, "flat out": medians(rates), "codec": codec()}


def medians(rows: Sequence[Figures]) -> Figures:
    """Of each figure by itself."""
    return {key: median(row[key] for row in rows) for key in rows[0]}


def show(results: dict[str, Any]) -> str:
    """The tables of docs/performance.md."""
    flows = {
        "UART to CAN p50 us": ("up_p50", ".0f"),
        "p99": ("up_p99", ".0f"),
        "sticks passed %": ("up_share", ".1f"),
        "CAN to UART p50 us": ("down_p50", ".0f"),
        "p99 ": ("down_p99", ".0f"),
        "CPU %": ("cpu", ".1f"),
    }
    frames = {"decode us": ("ours", ".2f"), "cantools us": ("cantools", ".2f"), "columns ns": ("columns", ".1f")}
    rates = ", ".join(f"{name} {value:,.0f}" for name, value in results["flat out"].items())
    return f"{table(results['live'], flows)}\nflat out: {rates}\n\n{table(results['codec'], frames)}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--passes", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=6.0)
    parser.add_argument("--json", action="store_true")
    chosen = parser.parse_args()
    results = measure(chosen.passes, chosen.seconds)
    print(json.dumps(results, indent=1) if chosen.json else show(results))


if __name__ == "__main__":
    main()
