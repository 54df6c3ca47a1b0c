"""What decoding a message of the catalogue costs, one by one and in columns.

    python -m benchmarks.catalogue [RECORDING...]

Messages are those of the recordings, repeated to thirty thousand of a PGN; each figure is the best of five runs.
"""

import sys
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import numpy as np

from benchmarks.table import table
from timonel.nmea2000 import catalogue
from timonel.nmea2000.catalogue_columns import columns, select
from timonel.nmea2000.fastpacket import Reassembler
from timonel.nmea2000.identifier import split
from timonel.recording import open_log

ROWS = 30_000
RUNS = 5
MOST = 40  # PGNs


def main(names: list[str]) -> None:
    found = payloads(names)
    often = sorted(found, key=lambda pgn: -len(found[pgn]))[:MOST]
    headings = {"messages": ("messages", "d"), "us, one": ("one", ".2f"), "ns, in columns": ("column", ".0f")}
    print(table({str(pgn): figures(pgn, found[pgn]) for pgn in often}, headings))


def payloads(names: list[str]) -> dict[int, list[bytes]]:
    """The messages of recordings by PGN."""
    found: dict[int, list[bytes]] = defaultdict(list)
    for name in names:
        reassembler, now = Reassembler(), 0.0
        for frame in open_log(Path(name)):
            pgn, now = split(frame.identifier).pgn, now + 0.001
            whole = frame.whole or not catalogue.is_fast(pgn)
            payload = frame.data if whole else reassembler.receive(frame.identifier, frame.data, now)
            if payload is not None:
                found[pgn].append(payload)
    return found


def figures(pgn: int, messages: list[bytes]) -> dict[str, float]:
    """Microseconds for a message decoded by itself, nanoseconds for one among many."""
    times = -(-ROWS // len(messages))
    lengths = np.array([len(payload) for payload in messages], np.intp)
    rows = np.zeros((len(messages), lengths.max()), np.uint8)
    for row, payload in zip(rows, messages, strict=True):
        row[: len(payload)] = np.frombuffer(payload, np.uint8)
    many, sizes = np.tile(rows, (times, 1)), np.tile(lengths, times)
    find = catalogue.finder(pgn)

    def one_by_one() -> None:
        for payload in messages:
            if definition := find(payload):
                definition.decode(payload)

    def all_at_once() -> None:
        for definition, chosen in select(pgn, many, sizes):
            if definition is not None:
                columns(definition, many[chosen], sizes[chosen])

    return {
        "messages": len(messages),
        "one": best(one_by_one) / len(messages) * 1e6,
        "column": best(all_at_once) / len(many) * 1e9,
    }


def best(run: Callable[[], None]) -> float:
    """Seconds of the fastest run."""
    found = []
    for _ in range(RUNS):
        start = perf_counter()
        run()
        found.append(perf_counter() - start)
    return min(found)


if __name__ == "__main__":
    main(sys.argv[1:])
