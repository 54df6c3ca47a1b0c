"""What one message and one sentence cost, beside packages that do the same.

    python -m benchmarks.codec [--json]

Each figure is the best of many short runs, taken in turn: what the code costs when nothing else disturbs it. NumPy
columns are the time for one message out of a hundred thousand.
"""

import argparse
import json
import logging
import os
from collections.abc import Callable
from timeit import Timer
from typing import Any

import cantools.database
import cantools.database.can
import numpy as np
import pynmea2
from nmea2000.decoder import NMEA2000Decoder
from nmea2000.encoder import create_encoder
from nmea2000.input_formats import N2KFormat

from benchmarks.peers import HERE
from benchmarks.processes import PROGRAM
from benchmarks.table import table
from timonel.core.columns import columns
from timonel.nmea0183 import sentences as s
from timonel.nmea0183.registry import parse
from timonel.nmea2000.fastpacket import Reassembler, fragment
from timonel.nmea2000.identifier import join
from timonel.nmea2000.lookups import HeadingReference, SteeringMode
from timonel.nmea2000.messages.steering import HeadingTrackControl, VesselHeading

ROUNDS = 400
RUNS = 200  # of one thing in a round
MANY = 100_000
SOURCE = 34

HEADING = VesselHeading(sid=1, heading=1.2345, deviation=-0.0123, variation=0.0367, reference=HeadingReference.MAGNETIC)
TRACK = HeadingTrackControl(steering_mode=SteeringMode.HEADING_CONTROL, heading_to_steer_course=1.5)
HDT = b"$IIHDT,123.4,T*26"
MWV = b"$IIMWV,45.0,R,12.5,N,A*3A"
RMC = b"$GPRMC,120000,A,3930.738000,N,00236.740400,E,6.5,123.4,010126,2.1,E,A*1D"

Run = Callable[[], Any]


def ours() -> dict[str, Run]:
    """What we do, by name."""
    payload = HEADING.encode()
    sentence, full = s.HDT(123.4), parse(RMC)
    assert isinstance(full, s.RMC)
    assert full.encode("GP").rstrip() == RMC
    read = parse.__wrapped__  # each time as if it had never been read before
    assert (type(read(HDT)), type(read(MWV))) == (s.HDT, s.MWV)
    return {
        "decode 127250": lambda: VesselHeading.decode(payload),
        "encode 127250": lambda: HEADING.encode(),
        "fast packet, a frame of 127237": fast_packets(),
        "build HDT": lambda: sentence.encode("II"),
        "build RMC": lambda: full.encode("GP"),
        "parse HDT": lambda: read(HDT),
        "parse MWV": lambda: read(MWV),
        "parse RMC": lambda: read(RMC),
    }


def fast_packets() -> Run:
    """One frame of four; the fourth gives the message."""
    identifier, reassembler = join(2, HeadingTrackControl.PGN, SOURCE), Reassembler()
    frames = [frame for sequence in range(8) for frame in fragment(TRACK.encode(), sequence)]
    turn = iter(range(10**12))
    assert [reassembler.receive(identifier, frame, 0.0) for frame in frames][3::4] == [TRACK.encode()] * 8
    return lambda: reassembler.receive(identifier, frames[next(turn) & 31], 0.0)


def nmea2000() -> dict[str, Run]:
    """PyPI nmea2000, in its format nearest to a frame, and pynmea2."""
    logging.disable(logging.CRITICAL)
    decoder = NMEA2000Decoder(bound_format=N2KFormat.EBYTE)
    encoder = create_encoder(output_format=N2KFormat.EBYTE)
    packet = b"\x88" + join(2, VesselHeading.PGN, SOURCE).to_bytes(4, "big") + HEADING.encode()
    message = decoder.decode(packet)
    track = join(2, HeadingTrackControl.PGN, SOURCE).to_bytes(4, "big")
    packets = [b"\x88" + track + frame for sequence in range(8) for frame in fragment(TRACK.encode(), sequence)]
    turn = iter(range(10**12))
    return {
        "decode 127250": lambda: decoder.decode(packet),
        "encode 127250": lambda: encoder.encode(message),
        "fast packet, a frame of 127237": lambda: decoder.decode(packets[next(turn) & 31]),
        "build HDT": lambda: str(pynmea2.HDT("II", "HDT", ("123.4", "T"))),
        "parse HDT": _parser(HDT),
        "parse MWV": _parser(MWV),
        "parse RMC": _parser(RMC),
    }


def _parser(line: bytes) -> Run:
    """All fields are read, as ours are: pynmea2 works them out when asked."""
    text = line.decode()
    names = [field[1] for field in pynmea2.parse(text, check=True).fields]

    def run() -> list[Any]:
        sentence = pynmea2.parse(text, check=True)
        return [getattr(sentence, name) for name in names]

    return run


def dbc() -> dict[str, Run]:
    """cantools, on the same layout as a DBC."""
    database = cantools.database.load_file(HERE / "vessel_heading.dbc")
    assert isinstance(database, cantools.database.can.Database)
    identifier, payload = database.messages[0].frame_id, HEADING.encode()
    values = database.decode_message(identifier, payload)
    return {
        "decode 127250": lambda: database.decode_message(identifier, payload),
        "encode 127250": lambda: database.encode_message(identifier, values, padding=True),
    }


def best(what: dict[str, Run]) -> dict[str, float]:
    """ns of each, without the empty call that every one of them is made with."""
    timers = {name: Timer(run) for name, run in {**what, "": lambda: None}.items()}
    found = dict.fromkeys(timers, float("inf"))
    for _ in range(ROUNDS):
        for name, timer in timers.items():
            found[name] = min(found[name], timer.timeit(RUNS) / RUNS * 1e9)
    empty = found.pop("")
    return {name: value - empty for name, value in found.items()}


def columns_ns() -> float:
    """All five columns of one message among many."""
    payloads = np.tile(np.frombuffer(HEADING.encode(), np.uint8), (MANY, 1))
    return min(Timer(lambda: columns(VesselHeading, payloads)).repeat(20, 1)) / MANY * 1e9


def measure() -> dict[str, dict[str, float]]:
    """Every figure by what it is of, then by who."""
    mine, theirs, database = best(ours()), best(nmea2000()), best(dbc())
    rows = {name: {"timonel": value} for name, value in mine.items()}
    rows["columns of 127250, a message"] = {"timonel": columns_ns()}
    for name, value in theirs.items():
        rows[name] |= {"nmea2000/pynmea2": value, "ratio": value / mine[name]}
    for name, value in database.items():
        rows[name]["cantools"] = value
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true")
    chosen = parser.parse_args()
    os.sched_setaffinity(0, {PROGRAM})
    rows = measure()
    heads = {"timonel ns": "timonel", "nmea2000 / pynmea2 ns": "nmea2000/pynmea2", "cantools ns": "cantools"}
    formats = {head: (key, ",.0f") for head, key in heads.items()} | {"times as fast": ("ratio", ".1f")}
    print(json.dumps(rows, indent=1) if chosen.json else table(rows, formats))


if __name__ == "__main__":
    main()
