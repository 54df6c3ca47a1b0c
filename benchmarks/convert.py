"""How many frames and sentences are converted in a second, both ways, beside other programs.

    python -m benchmarks.convert [--passes 3] [--times 10]

A recorded bus (three captures of a sailing yacht, 50,000 frames of 40 devices' PGNs) becomes sentences, and a recorded
NMEA 0183 log becomes frames. Each program runs alone on one core; everything runs once in each pass, so that all of it
meets the same disturbances, and the best pass counts. Times are of the processor, without starting up and reading the
file. Ours is the whole gateway of a boat as one machine: truth, ageing, ceilings, stations and all.

`every message` is without ceilings, as the other programs convert; `usual ceilings` is what a gateway does. `conversion
alone` calls our functions directly, as those of the others are called; the whole gateway also hears what it puts on the
bus, asks who rules, keeps to the bus's rates, looks out for echoes, and tells its listeners.
"""

import argparse
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from benchmarks.peers import HERE, node_modules
from benchmarks.processes import PROGRAM
from benchmarks.table import table
from tests.recordings import recording
from timonel.core.effects import Effect, Say, Transmit
from timonel.core.frame import Frame
from timonel.nmea0183.framing import SentenceFramer
from timonel.nmea0183.registry import parse
from timonel.nmea0183.sentence import Sentence
from timonel.nmea2000.sender import Sender, outgoing
from timonel.recording.formats import open_log
from timonel.vehicles.boat.conversion import RATES
from timonel.vehicles.boat.instruments import FORMATTERS, Instruments
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.vehicle import Boat

BUS = [f"canboat_canboat/samples/can0-{number}.pcap" for number in (2, 3)]
WIRE = "SignalK_signalk-server/samples/plaka.log"
CAN_FRAME = struct.Struct("=IB3x8s")
EXTENDED = 0x80000000
BATCH = 16  # frames a wake-up of a busy gateway
PAUSE = 0.001  # s between frames, which is what half a bus has
ALL = dict.fromkeys(RATES, 1000.0)
COLUMNS = {
    "messages/s": ("rate", ",.0f"),
    "us a message": ("cost", ".1f"),
    "out of 1000": ("yield", ",.0f"),
    "times": ("times", ".1f"),
}
SENTENCES, FRAMES = "N2K to 0183", "0183 to N2K"


def bus(times: int, path: Path) -> None:
    """The recorded bus, so many times over, as `struct can_frame`."""
    frames = [
        CAN_FRAME.pack(frame.identifier | EXTENDED, len(frame.data), frame.data.ljust(8, b"\xff"))
        for name in BUS
        for frame in open_log(recording(name))
    ]
    path.write_bytes(b"".join(frames) * times)


def wire(times: int, path: Path) -> None:
    """The recorded sentences, so many times over."""
    lines = [line[line.find(b"$") :] for line in recording(WIRE).read_bytes().splitlines() if b"$" in line]
    path.write_bytes(b"".join(line + b"\r\n" for line in lines[: 10_000 * times]))


def made(effects: Iterator[Effect] | list[Effect]) -> tuple[int, int]:
    """Sentences and frames among them."""
    says = [effect for effect in effects if type(effect) is Say]
    return sum(say.line.count(b"\n") for say in says), sum(type(effect) is Transmit for effect in effects)


def our_sentences(path: Path, rates: dict[str, float]) -> tuple[int, int, float]:
    frames = [
        Frame(identifier & 0x1FFFFFFF, data[:size])
        for identifier, size, data in CAN_FRAME.iter_unpack(path.read_bytes())
    ]
    boat, now, out, spent = Boat(BoatSettings(rates=rates), [], 0.0), 0.0, 0, 0.0
    for start in range(0, len(frames), BATCH):
        batch = frames[start : start + BATCH]
        now += PAUSE * len(batch)
        began = time.process_time()
        effects = boat.receive_frames(batch, now)
        spent += time.process_time() - began
        out += made(effects)[0]
    return len(frames), out, spent


def our_frames(path: Path) -> tuple[int, int, float]:
    """The whole gateway. The port is read a burst at a time: a second's sentences, as a plotter sends them."""
    lines = path.read_bytes().splitlines(keepends=True)
    boat, now, out, spent = Boat(BoatSettings(), [Port("wire", instrument=True)], 0.0), 0.0, 0, 0.0
    for start in range(0, len(lines), BATCH):
        now += 1.0
        data = b"".join(lines[start : start + BATCH])
        began = time.process_time()
        effects = boat.receive_bytes("wire", data, now)
        spent += time.process_time() - began
        out += made(effects)[1]
    return len(lines), out, spent


def our_conversion(path: Path) -> tuple[int, int, float]:
    """The conversion called directly, as that of the others is: bytes to sentences, to messages, to frames."""
    lines = path.read_bytes().splitlines(keepends=True)
    framer, instruments, sender, now, out = SentenceFramer(), Instruments(), Sender(35), 0.0, 0
    bursts = [b"".join(lines[start : start + BATCH]) for start in range(0, len(lines), BATCH)]
    began = time.process_time()
    for burst in bursts:
        now += 1.0
        for text in framer.receive(burst):
            sentence = parse(text) if text[3:6] in FORMATTERS else None
            if isinstance(sentence, Sentence):
                for message in instruments.receive(sentence, "wire", now):
                    out += len(sender.frames(outgoing(message)))
    return len(lines), out, time.process_time() - began


def ours(what: str, path: str) -> tuple[int, int, float]:
    match what:
        case "every message":
            return our_sentences(Path(path), ALL)
        case "usual ceilings":
            return our_sentences(Path(path), {})
        case "conversion alone":
            return our_conversion(Path(path))
    return our_frames(Path(path))


def programs(frames: Path, lines: Path) -> dict[str, dict[str, list[str]]]:
    """What is run: by direction and name, a command that prints messages, what came of them, and seconds."""
    own = [sys.executable, "-m", "benchmarks.convert", "--run"]
    python = [sys.executable, str(HERE / "convert.py")]
    found: dict[str, dict[str, list[str]]] = {
        SENTENCES: {
            "timonel, every message": [*own, "every message", str(frames)],
            "timonel, usual ceilings": [*own, "usual ceilings", str(frames)],
            "nmea2000 + pynmea2": [*python, "sentences", str(frames)],
        },
        FRAMES: {
            "timonel, conversion alone": [*own, "conversion alone", str(lines)],
            "timonel, whole gateway": [*own, "whole gateway", str(lines)],
            "pynmea2 + nmea2000": [*python, "frames", str(lines)],
        },
    }
    if (modules := node_modules()) is not None:
        node = [str(shutil.which("node")), str(HERE / "convert.js"), str(modules)]
        found[SENTENCES]["canboatjs + n2k-signalk + signalk-to-nmea0183"] = [*node, "sentences", str(frames)]
        found[FRAMES]["nmea0183-signalk + signalk-to-nmea2000 + canboatjs"] = [*node, "frames", str(lines)]
    return found


def measure(command: list[str]) -> dict[str, float]:
    """One run, on the core that is kept for what is measured."""
    ran = subprocess.run(
        command, capture_output=True, text=True, check=True, preexec_fn=lambda: os.sched_setaffinity(0, {PROGRAM})
    )
    found = json.loads(ran.stdout.splitlines()[-1])
    messages, seconds = found["messages"], found["seconds"]
    return {
        "rate": messages / seconds,
        "cost": seconds / messages * 1e6,
        "yield": found["out"] / messages * 1000,
    }


def compare(rows: dict[str, dict[str, float]]) -> None:
    """How many times the best of the others each of ours is."""
    best = max(row["rate"] for name, row in rows.items() if not name.startswith("timonel"))
    for name, row in rows.items():
        if name.startswith("timonel"):
            row["times"] = row["rate"] / best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--passes", type=int, default=3)
    parser.add_argument("--times", type=int, default=10, help="how often the recordings are played over")
    parser.add_argument("--run", nargs=2, metavar=("WHAT", "FILE"), help="one run of ours, as the others print theirs")
    arguments = parser.parse_args()
    if arguments.run:
        messages, out, seconds = ours(*arguments.run)
        print(json.dumps({"messages": messages, "out": out, "seconds": seconds}))
        return
    with tempfile.TemporaryDirectory() as directory:
        frames, lines = Path(directory, "frames"), Path(directory, "lines")
        bus(arguments.times, frames)
        wire(arguments.times, lines)
        found = programs(frames, lines)
        best: dict[str, dict[str, dict[str, float]]] = {way: {} for way in found}
        for number in range(arguments.passes):
            for way, commands in found.items():
                for name, command in commands.items():
                    print(f"pass {number + 1} of {arguments.passes}: {way}, {name}", file=sys.stderr)
                    row = measure(command)
                    if row["rate"] > best[way].get(name, {"rate": 0.0})["rate"]:
                        best[way][name] = row
    for way, rows in best.items():
        compare(rows)
        print(f"\n{way}\n\n{table(rows, COLUMNS)}")


if __name__ == "__main__":
    main()
