"""What the flight recorder costs: at the rate of a full bus, at fifty thousand frames a second, and at most.

    python -m benchmarks.recorder [--passes 3] [--seconds 5] [--directory DIR] [--json]

Every frame is told by itself and answered with a sentence, which is more than any boat does: `told together` has
batches of sixteen, as a loop that has fallen behind hears them. The figures are of the recorder with its thread, its
compression and its disk: what the same loop costs without it is taken off. See `docs/performance.md`.
"""

import argparse
import json
import tempfile
import time
from collections.abc import Iterator
from itertools import cycle
from pathlib import Path

from benchmarks.table import table
from benchmarks.traffic import raw_cycle
from timonel.core.effects import Effect, Say
from timonel.core.frame import Frame
from timonel.gateway.recorder import FLUSH, Recorder
from timonel.recording.flight_writer import FlightWriter, Limits

ANSWER: list[Effect] = [Say(b"$IIHDT,182.3,T*2F\r\n", "HDT")]
TICK = 0.001  # s
BATCH = 16
CASES = {
    "2,000 frames/s, each with a sentence": (2_000, 1),
    "50,000 frames/s, each with a sentence": (50_000, 1),
    "50,000 frames/s, told together": (50_000, BATCH),
}
COLUMNS = {
    "frames/s": ("told", ",.0f"),
    "of a core": ("share", ".2%"),
    "us/frame": ("us", ".2f"),
    "bytes/frame": ("bytes", ".1f"),
    "lost steps": ("lost", ".0f"),
}


def frames() -> Iterator[Frame]:
    """Those of a boat, for ever."""
    return cycle(raw_frames())


def raw_frames() -> list[Frame]:
    """A second of the traffic of `benchmarks.traffic`."""
    return [Frame(int.from_bytes(raw[:4], "little") & 0x1FFFFFFF, raw[8 : 8 + raw[4]]) for raw in raw_cycle()]


class Setup:
    """A recorder with its writer; without a directory, nothing is recorded and only the loop costs."""

    def __init__(self, directory: Path | None) -> None:
        self.writer = None if directory is None else FlightWriter(directory, "bench", Limits(), lambda number: {})
        self.recorder = None if self.writer is None else Recorder(["Bridge"], self.writer.put, time.monotonic())
        if self.writer is not None:
            self.writer.start()

    def tell(self, batch: list[Frame], now: float) -> None:
        if self.recorder is not None:
            self.recorder.frames_received(batch, now)
            self.recorder.answered(ANSWER, now)

    def flush(self) -> None:
        if self.recorder is not None:
            self.recorder.flush(time.monotonic())

    def close(self) -> None:
        if self.writer is not None:
            self.flush()
            self.writer.close(60.0)


def paced(setup: Setup, rate: int, size: int, seconds: float) -> tuple[float, int]:
    """CPU time, s, of the process while so many frames a second come, and how many came."""
    source = frames()
    used, began = time.process_time(), time.monotonic()
    flushed, told = began, 0
    while (now := time.monotonic()) < began + seconds:
        while told < (now - began) * rate:
            setup.tell([next(source) for _ in range(size)], now)
            told += size
        if now > flushed + FLUSH:
            setup.flush()
            flushed = now
        time.sleep(TICK)
    setup.close()
    return time.process_time() - used, told


def measure(rate: int, size: int, seconds: float, directory: Path) -> dict[str, float]:
    alone, _ = paced(Setup(None), rate, size, seconds)
    setup = Setup(directory)
    used, told = paced(setup, rate, size, seconds)
    used -= alone
    assert setup.writer is not None
    written = setup.writer.written
    return {
        "told": told / seconds,
        "share": used / seconds,
        "us": used / told * 1e6,
        "bytes": written.bytes / told,
        "lost": written.lost_steps,
    }


def most(size: int, seconds: float, directory: Path) -> dict[str, float]:
    """As many frames as the loop and the thread take together, none lost."""
    source, waiting = frames(), 0
    setup = Setup(directory)
    assert setup.writer is not None
    batches = [[next(source) for _ in range(size)] for _ in range(1000)]
    told, began = 0, time.monotonic()
    while (now := time.monotonic()) < began + seconds:
        for batch in batches:
            setup.tell(batch, now)
        told += size * len(batches)
        while setup.writer.waiting > 16:
            waiting += 1
            time.sleep(TICK)
    setup.close()
    took = time.monotonic() - began
    return {"rate": told / took, "lost": setup.writer.written.lost_steps, "bytes": setup.writer.written.bytes / told}


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--passes", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--directory", type=Path)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=arguments.directory) as directory:
        rows = {
            name: min(
                (measure(rate, size, arguments.seconds, Path(directory)) for _ in range(arguments.passes)),
                key=lambda row: row["us"],
            )
            for name, (rate, size) in CASES.items()
        }
        limits = {
            name: max((most(size, arguments.seconds, Path(directory)) for _ in range(arguments.passes)),
                      key=lambda row: row["rate"])
            for name, size in (("each with a sentence", 1), ("told together", BATCH))
        }  # fmt: skip
    if arguments.json:
        print(json.dumps({"paced": rows, "most": limits}))
        return
    print(table(rows, COLUMNS))
    print(
        table(
            limits,
            {"frames/s at most": ("rate", ",.0f"), "lost steps": ("lost", ".0f"), "bytes/frame": ("bytes", ".1f")},
        )
    )


if __name__ == "__main__":
    main()
