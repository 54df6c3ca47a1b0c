"""From a frame on the bus to the sentence in a listener's hands: latency, cost, highest rate; beside other programs.

    python -m benchmarks.live [--json] [--passes 5] [--seconds 4] [--only WORD]

Everything runs in processes of its own: the program alone on one core, what sends and what reads on the other. A
latency counts from just before the frame is sent to just after its sentence was read, so both system calls and both
wake-ups are in it. See `docs/performance.md` for what was found.
"""

import argparse
import json
import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from statistics import median
from typing import Any

from benchmarks import command, memory
from benchmarks.bare_loop import run_bare_loop
from benchmarks.consoles import run_consoles
from benchmarks.live_gateway import ANY_PORT, HERE, Setup, bus_pair, run_gateway, run_stamped_gateway
from benchmarks.peers import Peer, peers
from benchmarks.processes import (
    HARNESS,
    PROGRAM,
    Helper,
    Stamps,
    Where,
    cpu_seconds,
    ending,
    run_reader,
    run_source,
)
from benchmarks.table import table
from benchmarks.traffic import ONE_A_FRAME, USUAL, places, raw_cycle, unambiguous

Result = dict[str, float]
RATE = 2000  # frames/s; a full bus of 250 kbit/s has 1766
WARM_UP = 1.0  # s
SETTLE = 0.5  # s until what is on its way has come, and until every terminal is found open
CYCLE = raw_cycle()

SETUPS = {
    "12 outputs, flush 0ms": Setup(ONE_A_FRAME),
    "12 outputs, flush 2ms": Setup(ONE_A_FRAME, flush=0.002),
    "12 outputs, flush 5ms": Setup(ONE_A_FRAME, flush=0.005),
    "12 outputs, usual ceilings": Setup(USUAL),
    "12 outputs, 200 consoles": Setup(ONE_A_FRAME, consoles=200),
    "1 output (TCP)": Setup(ONE_A_FRAME, terminals=0, clients=1),
}
MORE_IS_BETTER = {"most_frames_s", "most_sentences"}
COMMANDED = "12 outputs, flush 0ms"
OURS, BARE = f"timonel, {COMMANDED}", "a bare loop, 12 outputs"


class Session:
    """One program between a source and a reader."""

    def __init__(self, pid: int, source: Helper, reader: Helper) -> None:
        self._pid = pid
        self._source = source
        self._reader = reader
        self._reader.order("count")

    def _next(self, *order: Any) -> Any:
        """What the reader heard until now; `order` is for what comes."""
        time.sleep(SETTLE)
        self._reader.order(*order)
        return self._reader.answer()

    def paced(self, seconds: float, commands: bool = False) -> Result:
        """Latency in us and CPU time in us a frame at `RATE`."""
        self._source.ask("paced", RATE, int(RATE * WARM_UP))
        self._next("stamp", commands)
        count = int(RATE * seconds)
        used = cpu_seconds(self._pid)
        self._source.ask("paced", RATE, count)
        used = cpu_seconds(self._pid) - used
        heard = self._next("count")
        if commands:
            return {f"command_{name}": value for name, value in heard.commands.items()}
        return {**heard.latencies, "cpu_us": used / count * 1e6, "sentences": sum(heard.sentences) / count}

    def flat_out(self, seconds: float) -> Result:
        """Frames taken in a second when there are always more, and CPU time in us of each."""
        begun, used, sent = time.monotonic(), cpu_seconds(self._pid), self._source.ask("flat out", 0.0)
        sent = self._source.ask("flat out", seconds) - sent
        took, used = time.monotonic() - begun, cpu_seconds(self._pid) - used
        heard = self._next("count")
        return {
            "most_frames_s": sent / took,
            "most_cpu_us": used / sent * 1e6,
            "most_sentences": sum(heard.sentences) / sent,
        }


@contextmanager
def session(pid: int, bus: int, where: Where, origins: dict[bytes, int]) -> Iterator[Session]:
    """Source on `bus`, reader on the rest."""
    stamps = Stamps()
    reader = Helper(HARNESS, run_reader, where, origins, len(CYCLE), stamps)
    source = Helper(HARNESS, run_source, bus, CYCLE, stamps)
    with ending(reader, source):
        reader.answer()
        time.sleep(SETTLE)
        yield Session(pid, source, reader)


@contextmanager
def with_gateway(setup: Setup, run: Callable[..., None] = run_gateway) -> Iterator[tuple[Session, Helper]]:
    """A session with our own gateway, or with what else takes its place."""
    near, far = bus_pair()
    with tempfile.TemporaryDirectory() as directory:
        gateway = Helper(PROGRAM, run, near.fileno(), directory, setup)
        with ending(gateway), near, far:
            terminals = tuple(f"{directory}/{number}" for number in range(1, 1 + setup.terminals))
            address, url = gateway.answer()
            where = Where(far.fileno(), terminals, address, setup.clients)
            with looking(url, setup.consoles), session(gateway.pid, far.fileno(), where, places()) as running:
                yield running, gateway


@contextmanager
def looking(url: str | None, consoles: int) -> Iterator[None]:
    """While browsers look, if any are wanted."""
    if url is None:
        yield
        return
    crowd = Helper(HARNESS, run_consoles, url, consoles)
    with ending(crowd):
        crowd.answer()
        yield


def measure_gateway(setup: Setup, seconds: float) -> Result:
    """Latency, cost, highest rate and memory of the gateway."""
    with with_gateway(setup) as (running, gateway):
        before = gateway.ask("counters")
        paced = running.paced(seconds)
        between = gateway.ask("counters")
        flat_out = running.flat_out(seconds)
        after = gateway.ask("counters")
    lost, most_lost = between["lost"] - before["lost"], after["lost"] - between["lost"]
    return {**paced, **flat_out, "lost": lost, "most_lost": most_lost, "mib": after["mib"]}


def measure_inside(setup: Setup, seconds: float) -> Result:
    """Latency within the program, from a frame read to its sentence written to the last of all readers."""
    with with_gateway(setup, run_stamped_gateway) as (running, gateway):
        gateway.ask("latencies")
        running.paced(seconds)
        return {f"inside_{name}": value for name, value in gateway.ask("latencies").items()}


def measure_bare_loop(setup: Setup, seconds: float) -> Result:
    """Latency and cost of what no program can do without."""
    with with_gateway(setup, run_bare_loop) as (running, _):
        return running.paced(seconds)


def measure_commands(setup: Setup, seconds: float) -> Result:
    """From a `$PARP` line to the last frame of its 127237, while the bus is full."""
    with with_gateway(setup) as (running, _):
        return running.paced(seconds, commands=True)


def measure_peer(peer: Peer, seconds: float) -> Result:
    """The same of another program, with one reader: a socket for its bus and TCP to its reader, as for ours."""
    near, bus = socket.socketpair()
    program_end, reader_end = tcp_pair()
    process = subprocess.Popen(
        peer.command, stdin=near.fileno(), stdout=program_end.fileno(), stderr=subprocess.DEVNULL
    )
    os.sched_setaffinity(process.pid, {PROGRAM})
    where = Where(bus.fileno(), connected=reader_end.fileno())
    try:
        with near, bus, program_end, reader_end, session(process.pid, bus.fileno(), where, _places_of(peer)) as running:
            return {**running.paced(seconds), **running.flat_out(seconds)}
    finally:
        process.kill()
        process.wait()


def tcp_pair() -> tuple[socket.socket, socket.socket]:
    """Two ends of a connection; what the first one sends goes out at once."""
    with socket.create_server((HERE, ANY_PORT)) as server:
        reader_end = socket.create_connection(server.getsockname())
        program_end, _ = server.accept()
    program_end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return program_end, reader_end


def _places_of(peer: Peer) -> dict[bytes, int]:
    """What the peer says of each frame, from a run of its own: one sentence each, or it does not do the same work."""
    done = subprocess.run(peer.command, input=b"".join(CYCLE * 2), stdout=subprocess.PIPE, check=True)
    lines = done.stdout.splitlines(keepends=True)
    assert len(lines) == 2 * len(CYCLE)
    return unambiguous((line, place) for place, line in enumerate(lines[len(CYCLE) :]))


# What to run ----------------------------------------------------------------------------------------------------


def scenarios(seconds: float) -> dict[str, Callable[[], Result]]:
    """By name; each is one pass."""
    found: dict[str, Callable[[], Result]] = {
        OURS: partial(measure_gateway, SETUPS[COMMANDED], seconds),
        BARE: partial(measure_bare_loop, SETUPS[COMMANDED], seconds),  # at once, so that both have the same neighbours
    }
    found["timonel, 12 outputs, read to written"] = partial(measure_inside, SETUPS[COMMANDED], seconds)
    found |= {f"timonel, {name}": partial(measure_gateway, setup, seconds) for name, setup in SETUPS.items()}
    found |= {f"{peer.name}, 1 output": partial(measure_peer, peer, seconds) for peer in peers()}
    found["command under load"] = partial(measure_commands, SETUPS[COMMANDED], 2 * seconds)
    found["command, the machine alone"] = command.measure
    found["an hour of bus"] = memory.measure
    return found


def run(wanted: dict[str, Callable[[], Result]], passes: int) -> dict[str, Result]:
    """All scenarios in turn, so many times; of each figure the median."""
    results: dict[str, list[Result]] = {name: [] for name in wanted}
    for number in range(passes):
        for name, measure in wanted.items():
            print(f"pass {number + 1} of {passes}: {name}", file=sys.stderr, flush=True)
            results[name].append(measure())
    return {name: summary(rows) for name, rows in results.items()}


def summary(rows: Iterable[Result]) -> Result:
    """Medians, each figure by itself, and as `best_` what the pass that was disturbed least had."""
    listed = list(rows)
    keys = [key for key in listed[0] if all(key in row for row in listed)]
    best = {f"best_{key}": (max if key in MORE_IS_BETTER else min)(row[key] for row in listed) for key in keys}
    return {key: median(row[key] for row in listed) for key in keys} | best


def show(results: dict[str, Result]) -> str:
    """The tables of docs/performance.md."""
    flows = {name: row for name, row in results.items() if "p50" in row}
    others = {name: row for name, row in results.items() if "p50" not in row}
    columns = {
        "p50 us": ("p50", ".0f"),
        "(best)": ("best_p50", ".0f"),
        "p99": ("p99", ".0f"),
        "(best) ": ("best_p99", ".0f"),
        "p99.9": ("p999", ".0f"),
        "CPU us/frame": ("cpu_us", ".0f"),
        "(best)  ": ("best_cpu_us", ".0f"),
        "sentences/frame": ("sentences", ".2f"),
        "replaced": ("lost", ".0f"),
        "most frames/s": ("most_frames_s", ",.0f"),
        "(best)   ": ("best_most_frames_s", ",.0f"),
        "CPU us/frame, then": ("most_cpu_us", ".1f"),
        "(best)    ": ("best_most_cpu_us", ".1f"),
        "sentences/frame, then": ("most_sentences", ".2f"),
        "replaced, then": ("most_lost", ",.0f"),
    }
    text = table(flows, columns) + beside_bare(results)
    for name, row in others.items():
        told = {key: value for key, value in row.items() if not key.startswith("best_")}
        text += f"\n{name}: " + ", ".join(f"{key} {value:,.1f}" for key, value in told.items())
    return text


def beside_bare(results: dict[str, Result]) -> str:
    """How often a bare loop fits into the gateway: medians, and the best passes of each."""
    if not {OURS, BARE} <= results.keys():
        return ""
    ours, bare = results[OURS], results[BARE]
    times = ", ".join(f"{key} {ours[key] / bare[key]:.2f}" for key in ("cpu_us", "best_cpu_us", "p50", "best_p50"))
    return f"\n{OURS}, times a bare loop: {times}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--passes", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=4.0, help="of each part of a pass")
    parser.add_argument("--only", default="", help="scenarios with this in their name")
    parser.add_argument("--json", action="store_true")
    chosen = parser.parse_args()
    wanted = {name: measure for name, measure in scenarios(chosen.seconds).items() if chosen.only in name}
    results = run(wanted, chosen.passes)
    print(json.dumps(results, indent=1) if chosen.json else show(results))


if __name__ == "__main__":
    main()
