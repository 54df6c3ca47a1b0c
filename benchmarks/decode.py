"""How many frames and sentences of recordings are decoded in a second, beside packages that do the same.

    python -m benchmarks.decode [--inputs DIR] [--passes N] [--json]

The inputs are public recordings, played over and over to a million frames; `--inputs` keeps them for the next time.
Times are of the processor, in this process, on one core, of the best pass. How many times as fast as another package
something is, is the median of the passes: in each of them that package runs right after it, for about as long, as the
best pass of what takes longer would be disturbed more. Goals are rates that were set on another machine; here they are
how many times as fast as the package beside it that was there.
"""

import argparse
import json
import logging
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path

import msgspec
import numpy as np
import pynmea2
from nmea2000.decoder import NMEA2000Decoder
from nmea2000.input_formats import N2KFormat

from benchmarks.asammdf_peer import asammdf, six_to_columns
from benchmarks.table import table
from tests.recordings import ROOT, SHARED
from timonel.core.effects import Say
from timonel.core.frame import Frame
from timonel.gateway.recorder import Recorder
from timonel.nmea2000.catalogue import finder
from timonel.nmea2000.fastpacket import Reassembler
from timonel.nmea2000.identifier import split
from timonel.nmea2000.registry import is_fast
from timonel.recording.assembly import Assembly
from timonel.recording.candump import Candump
from timonel.recording.chunks import open_frames
from timonel.recording.decoded import Decoder, open_recording
from timonel.recording.fast_nmea0183 import open_sentences
from timonel.recording.flight_writer import FlightWriter, Limits
from timonel.recording.frames import Frames, concatenate
from timonel.recording.tables import CHUNK, Tables, decode_file, keep_memory

SIX = (127250, 127251, 129025, 129026, 130306, 128259)
SENTENCE = [Say(b"$IIHDT,182.3,T*2F\r\n", "HDT")]
FEW = 50_000  # lines for what takes microseconds each
BESIDE = 10_000  # of the other packages
PCAP = np.dtype(
    [("s", "<u4"), ("us", "<u4"), ("captured", "<u4"), ("size", "<u4"), ("id", ">u4"), ("frame", "V4"), ("data", "V8")]
)


BUS, SENTENCES, DBC = "nmea2000, a line", "pynmea2, a line", "asammdf, a frame of six PGNs in MF4"
THERE = {BUS: 6.594, SENTENCES: 3.343}
"""What the other packages took where the goals were set, us."""


class Work(msgspec.Struct, frozen=True):
    """Something measured: how many frames or sentences it goes over, which of the others is beside it, and the goal in
    millions a second."""

    name: str
    count: int
    run: Callable[[], object]
    peer: str = ""
    goal: float = 0.0


def inputs(folder: Path) -> None:
    """The recordings to a million frames each, in `folder`."""
    if (folder / "boat.pcap").exists() and (folder / "boat.mcap").exists():
        return
    script, samples = SHARED / "tools" / "peers" / "gen_inputs.py", ROOT / "canboat_canboat" / "samples"
    signalk = ROOT / "SignalK_signalk-server" / "samples"
    options = ["--canboat-samples", samples, "--signalk-samples", signalk, "--out", folder]
    subprocess.run([sys.executable, script, *options], check=True, stdout=subprocess.DEVNULL)
    frames = concatenate(open_frames(folder / "boat.candump"))
    packets = np.zeros(len(frames), PCAP)
    packets["s"], packets["us"] = np.divmod(frames.stamp // 1000, 1_000_000)
    packets["captured"] = packets["size"] = 16
    packets["id"] = frames.identifier
    packets["frame"] = frames.rows.view("V4").reshape(-1, 4)[:, 1]
    packets["data"] = frames.rows.view("V8").reshape(-1, 2)[:, 1]
    header = np.array([0xA1B2C3D4, 4 << 16 | 2, 0, 0, 65535, 227], "<u4")
    flight_recording(frames, folder / "boat.mcap")
    (folder / "boat.pcap").write_bytes(header.tobytes() + packets.tobytes())


def flight_recording(frames: Frames, path: Path) -> None:
    """What the gateway would have recorded of 2,000 frames a second, with a sentence for every tenth.

    The frames come as irregularly as they came in the recording.
    """
    came = frames.stamp - frames.stamp[0]
    times = (came * (len(frames) / 2000 / came[-1])).tolist()
    with tempfile.TemporaryDirectory(dir=path.parent) as directory:
        now, flushed = 0.0, 0.0
        writer = FlightWriter(Path(directory), "boat", Limits(segment_size=1 << 30), lambda number: {}, began_ns=0)
        recorder = Recorder(["Bridge"], writer.put, now, wall=lambda: round(now * 1e9))
        for place, frame in enumerate(frames.logframes()):
            now = times[place]
            recorder.frames_received([Frame(frame.identifier, frame.data)], now)
            if place % 10 == 0:
                recorder.answered(SENTENCE, now)
            if now - flushed >= 1:
                flushed = now
                recorder.flush(now)
                writer.drain()
        recorder.flush(now)
        writer.finish()
        (written,) = Path(directory).iterdir()
        written.rename(path)


def decoded(frames: Frames, pgns: tuple[int, ...] | None = None) -> int:
    """Frames in memory to columns; how many messages."""
    assembly, tables = Assembly(pgns), Tables()
    return sum(
        len(each.messages.row)
        for start in range(0, len(frames), CHUNK)
        for each in tables.receive(assembly.receive(frames[start : start + CHUNK]))
    )


def from_file(path: Path) -> int:
    return sum(len(each.messages.row) for chunk in decode_file(path) for each in chunk)


def objects(path: Path) -> int:
    """A recording to typed objects, as a program iterates over them; how many."""
    return sum(message.value is not None for message in open_recording(path))


def line_by_line(lines: list[str]) -> int:
    """The same of lines that come one at a time."""
    read, receive = Candump(lines[:1]).read, Decoder().receive
    count = 0
    for line in lines:
        frame = read(line)
        if frame is not None:
            message = receive(frame)
            if message is not None and message.value is not None:
                count += 1
    return count


def streamed(frames: list[tuple[int, bytes, float]]) -> int:
    """Frames of fast packets to typed objects."""
    receive = Reassembler().receive
    count = 0
    for identifier, data, now in frames:
        payload = receive(identifier, data, now)
        if payload is not None:
            definition = finder(split(identifier).pgn)(payload)
            if definition is not None:
                definition.decode(payload)
                count += 1
    return count


def nmea2000(lines: list[str]) -> None:
    decode = NMEA2000Decoder(bound_format=N2KFormat.CANDUMP3).decode
    for line in lines:
        decode(line)


def sentences(path: Path) -> int:
    return sum(len(each.line) for each in open_sentences(path))


def pynmea2_all(lines: list[str]) -> None:
    for line in lines:
        try:
            pynmea2.parse(line, check=True)
        except pynmea2.ParseError:
            continue


def first(path: Path, wanted: Callable[[int], bool] = lambda pgn: True) -> list[str]:
    """The first lines of PGNs that are wanted."""
    with path.open() as lines:
        chosen = (line.rstrip() for line in lines if wanted(split(int(line.split()[2][:8], 16)).pgn))
        return list(islice(chosen, FEW))


def gathered(frames: Frames) -> Callable[[], object]:
    """What NumPy takes to bring the rows of all PGNs together, and nothing else."""
    order = np.argsort((frames.identifier >> 8).astype(np.uint16), kind="stable")
    rows = frames.rows.view("<c16")
    return lambda: rows.take(order)


def works(folder: Path) -> Iterator[Work]:
    candump, pcap, plaka = folder / "boat.candump", folder / "boat.pcap", folder / "plaka.nmea"
    flight = folder / "boat.mcap"
    frames = concatenate(open_frames(pcap))
    count = len(frames)
    lines, single = first(candump), first(candump, lambda pgn: not is_fast(pgn))
    fast = [frame for frame in frames[: 3 * FEW].logframes() if is_fast(split(frame.identifier).pgn)]
    stream = [(frame.identifier, frame.data, frame.stamp or 0.0) for frame in fast]
    with plaka.open() as text:
        spoken = [line.strip() for line in islice(text, FEW)]
    said = sum(1 for line in plaka.read_bytes().split(b"\n") if line)
    yield Work("candump text to columns of all PGNs", count, lambda: from_file(candump), BUS, 6)
    yield Work("pcap to columns of all PGNs", count, lambda: from_file(pcap), BUS, 14)
    yield Work("our recording to columns of all PGNs", count, lambda: from_file(flight), BUS, 14)
    yield Work("frames in memory to columns of all PGNs", count, lambda: decoded(frames), BUS, 14)
    yield Work("frames scanned for six PGNs, to columns", count, lambda: decoded(frames, SIX), BUS, 50)
    six = concatenate(open_frames(folder / "six.candump"))
    yield Work("frames of six PGNs in memory to columns", len(six), lambda: decoded(six), DBC if asammdf else "")
    yield Work("candump text to frames", count, lambda: sum(map(len, open_frames(candump))))
    yield Work("pcap to frames", count, lambda: sum(map(len, open_frames(pcap))))
    yield Work("our recording to frames", count, lambda: sum(map(len, open_frames(flight))))
    yield Work("frames to payloads by PGN", count, lambda: assembled(frames))
    yield Work("NumPy's own gather of the rows", count, gathered(frames))
    yield Work("NMEA 0183 text to columns", said, lambda: sentences(plaka), SENTENCES, 4.5)
    alone = folder / "single.candump"
    alone.write_text("".join(f"{line}\n" for line in single))
    yield Work("one line to a typed object, single frames", len(single), lambda: objects(alone), BUS, 1)
    yield Work("the same, line by line", len(single), lambda: line_by_line(single), BUS)
    yield Work("a recording to typed objects, all PGNs, a frame", count, lambda: objects(candump), BUS)
    yield Work("one frame of fast packets, to typed objects", len(stream), lambda: streamed(stream), BUS, 1)
    if asammdf:
        yield Work(DBC, len(six), six_to_columns(six, folder))
    yield Work(BUS, BESIDE, lambda: nmea2000(lines[:BESIDE]))
    yield Work(SENTENCES, BESIDE, lambda: pynmea2_all(spoken[:BESIDE]))


def assembled(frames: Frames) -> None:
    assembly = Assembly()
    for start in range(0, len(frames), CHUNK):
        assembly.receive(frames[start : start + CHUNK])


def seconds(work: Work) -> float:
    """Of the processor, for one of its frames or sentences."""
    start = time.process_time()
    work.run()
    return (time.process_time() - start) / work.count


def measure(folder: Path, passes: int) -> dict[str, dict[str, float]]:
    """Millions a second, ns each, and how many times as fast as the one beside it."""
    keep_memory()
    inputs(folder)
    all_works = {work.name: work for work in works(folder)}
    best = dict.fromkeys(all_works, float("inf"))
    ratios: dict[str, list[float]] = {name: [] for name in all_works}
    for _ in range(passes):
        for name, work in all_works.items():
            took = seconds(work)
            best[name] = min(best[name], took)
            if work.peer:
                ratios[name].append(seconds(all_works[work.peer]) / took)
    rows = {name: {"rate": 1e-6 / each, "ns": each * 1e9} for name, each in best.items()}
    for name, work in all_works.items():
        if work.peer:
            rows[name]["ratio"] = statistics.median(ratios[name])
        if work.goal:
            rows[name]["goal"] = work.goal * THERE[work.peer]
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--inputs", type=Path)
    parser.add_argument("--passes", type=int, default=7)
    parser.add_argument("--json", action="store_true")
    chosen = parser.parse_args()
    logging.disable(logging.CRITICAL)
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    with tempfile.TemporaryDirectory() as temporary:
        rows = measure(chosen.inputs or Path(temporary), chosen.passes)
    columns = {
        "million/s": ("rate", ".2f"),
        "ns": ("ns", ",.0f"),
        "times the other": ("ratio", ".1f"),
        "goal": ("goal", ".1f"),
    }
    print(json.dumps(rows, indent=1) if chosen.json else table(rows, columns))


if __name__ == "__main__":
    main()
