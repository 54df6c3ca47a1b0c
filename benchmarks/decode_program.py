"""Whole programs that decode a recording: start, reading, decoding, writing, end.

    python -m benchmarks.decode_program [--inputs DIR] [--frames N] [--passes N] [--json]

The input is a public recording of a boat's bus, candump text, played over and over; `--inputs` keeps it for the next
time. Every program runs once in a pass, so that all of them meet the same disturbances; the best pass counts. `cpu` is
what all threads of a program took, `memory` the most that was resident, `first` the time until the first byte came.
`goal` is how many times as fast as nmea2000 a rate was, where it was set as a goal.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import msgspec

from benchmarks.table import table
from tests.recordings import ROOT, SHARED

THERE = 9.389  # us a frame that nmea2000 with its JSON took where the goals were set
FEW = 100_000  # frames for who takes tens of microseconds each

PEER_NAME = "nmea2000 (its to_json)"
PEER = """
import sys
from nmea2000.decoder import NMEA2000Decoder
from nmea2000.input_formats import N2KFormat
decode = NMEA2000Decoder(bound_format=N2KFormat.CANDUMP3).decode
for line in open(sys.argv[1]):
    message = decode(line)
    if message is not None:
        print(message.to_json())
"""
TIMONEL = (sys.executable, "-c", "from timonel.cli.main import main; main(prog_name='timonel')")


class Program(msgspec.Struct, frozen=True):
    """A command, and how many frames it reads; `{out}` is a directory of its own."""

    name: str
    frames: int
    command: tuple[str, ...]
    goal: float = 0.0  # million frames/s


class Run(msgspec.Struct, frozen=True):
    """What one run took: seconds, of the processor too, until the first byte, and MiB."""

    wall: float
    cpu: float
    first: float
    memory: float


def programs(log: Path, short: Path, frames: int) -> Iterator[Program]:
    decode = (*TIMONEL, "decode", str(log))
    yield Program("timonel: Parquet", frames, (*decode, "--to", "parquet", "-o", "{out}"), 3.5)
    yield Program("timonel: Arrow", frames, (*decode, "--to", "arrow", "-o", "{out}"))
    yield Program("timonel: JSON lines", frames, decode, 2.0)
    yield Program("timonel: one message to CSV", frames, (*decode, "--to", "csv", "-m", "vesselHeading"))
    yield Program("timonel: info", frames, (*TIMONEL, "info", str(log)))
    yield Program(PEER_NAME, FEW, (sys.executable, "-c", PEER, str(short)))


def run(program: Program) -> Run:
    out = tempfile.mkdtemp(prefix="decode-")
    began = time.perf_counter()
    process = subprocess.Popen(
        [part.format(out=out) if part == "{out}" else part for part in program.command],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    assert process.stdout is not None
    process.stdout.read(1)
    first = time.perf_counter() - began
    while process.stdout.read(1 << 20):
        pass
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    wall = time.perf_counter() - began
    shutil.rmtree(out)
    if process.returncode:
        raise SystemExit(f"{program.name} failed")
    return Run(wall, used.ru_utime + used.ru_stime, first, used.ru_maxrss / 1024)


def input_files(folder: Path, frames: int) -> tuple[Path, Path]:
    log, short = folder / f"boat-{frames}.candump", folder / "boat-short.candump"
    if not log.exists():
        folder.mkdir(parents=True, exist_ok=True)
        subprocess.run(
            [
                sys.executable, str(SHARED / "tools" / "peers" / "gen_inputs.py"), "--frames", str(frames),
                "--canboat-samples", str(ROOT / "canboat_canboat" / "samples"),
                "--signalk-samples", str(ROOT / "SignalK_signalk-server" / "samples"), "--out", str(folder),
            ],
            check=True, stdout=subprocess.DEVNULL,
        )  # fmt: skip
        (folder / "boat.candump").rename(log)
    with log.open() as whole:
        short.write_text("".join(next(whole) for _ in range(FEW)))
    return log, short


def measure(folder: Path, frames: int, passes: int) -> dict[str, dict[str, float]]:
    log, short = input_files(folder, frames)
    with log.open("rb") as lines:
        count = sum(1 for _ in lines)
    runs: dict[Program, list[Run]] = {}
    for _ in range(passes):
        for program in programs(log, short, count):
            runs.setdefault(program, []).append(run(program))
    rows = {}
    for program, some in runs.items():
        best = min(some, key=lambda one: one.wall)
        rows[program.name] = {
            "rate": program.frames / best.wall / 1e6,
            "cpu": min(one.cpu for one in some) / program.frames * 1e9,
            "first": min(one.first for one in some),
            "memory": max(one.memory for one in some),
        }
    for program in runs:
        rows[program.name]["ratio"] = rows[program.name]["rate"] / rows[PEER_NAME]["rate"]
        if program.goal:
            rows[program.name]["goal"] = program.goal * THERE
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--inputs", type=Path)
    parser.add_argument("--frames", type=int, default=5_000_000)
    parser.add_argument("--passes", type=int, default=3)
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        rows = measure(given.inputs or Path(temporary), given.frames, given.passes)
    columns = {
        "million frames/s": ("rate", ".2f"),
        "times the other": ("ratio", ".0f"),
        "goal": ("goal", ".0f"),
        "ns of processor a frame": ("cpu", ".0f"),
        "first output, s": ("first", ".2f"),
        "memory, MiB": ("memory", ".0f"),
    }
    print(json.dumps(rows) if given.json else table(rows, columns), end="")


if __name__ == "__main__":
    os.environ.setdefault("NO_COLOR", "1")
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # what is installed is compiled once, not at every start
    main()
