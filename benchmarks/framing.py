"""What the rover's framings make of a bad link, and how fast they are: `python -m benchmarks.framing`.

A frame is intact if all its bytes arrive, unchanged and together. What a parser emits is true if it is a frame
that was sent, in its place; corrupt if bits of it were changed on the way (its data, or its id into another one of
the same length); false if it was put together from pieces.
"""

import argparse
import time
from collections.abc import Callable
from random import Random

import msgspec

from benchmarks import channel
from benchmarks.channel import LENGTHS, TICK, Damage, Frame, Payload, Session, Traffic, Wire
from benchmarks.table import table
from timonel.vehicles.rover.framing import DIALECTS, Framer, Strzyga, StrzygaCrc

SEED = 20
CASES: dict[str, tuple[Payload, Damage]] = {
    "byte loss 1e-4": (channel.realistic, channel.byte_loss(1e-4)),
    "byte loss 1e-3": (channel.realistic, channel.byte_loss(1e-3)),
    "byte loss 1e-2": (channel.realistic, channel.byte_loss(1e-2)),
    "bit errors 1e-5": (channel.realistic, channel.bit_errors(1e-5)),
    "bit errors 1e-4": (channel.realistic, channel.bit_errors(1e-4)),
    "bit errors 1e-3": (channel.realistic, channel.bit_errors(1e-3)),
    "bursts of 8-120 bytes, one in 2 kB": (channel.realistic, channel.bursts(2000, 8, 120)),
    "joining, every 100 bytes": (channel.realistic, channel.joins(100)),
    "`#`-rich, byte loss 1e-2": (channel.full_of_starts, channel.byte_loss(1e-2)),
    "`#`-rich, joining, every 100 bytes": (channel.full_of_starts, channel.joins(100)),
}


class Score(msgspec.Struct):
    """What became of `sent` frames."""

    sent: int
    intact: int = 0
    received: int = 0
    """Intact frames that came out."""
    corrupt: int = 0
    false: int = 0

    @property
    def lost_percent(self) -> float:
        """Of the intact frames."""
        return 100 * (self.intact - self.received) / self.intact

    @property
    def false_per_1000(self) -> float:
        """Of all frames sent."""
        return 1000 * self.false / self.sent

    @property
    def corrupt_per_1000(self) -> float:
        """Of all frames sent."""
        return 1000 * self.corrupt / self.sent


class Parser(msgspec.Struct, frozen=True):
    write: Callable[[int, bytes], bytes]
    parse: Callable[[Session, Wire], list[Frame]]


def naive(session: Session, wire: Wire) -> list[Frame]:
    """What firmware does: after `#` and a known id the next bytes are data, whatever they are."""
    frames = []
    stream = iter(session.data)
    for byte in stream:
        while byte == 0x23:
            byte = next(stream, 0)
            if byte in LENGTHS:
                data = bytes(value for _, value in zip(range(LENGTHS[byte]), stream, strict=False))
                frames += [(byte, data)] if len(data) == LENGTHS[byte] else []
                break
    return frames


def continuous(framer: type[Framer]) -> Callable[[Session, Wire], list[Frame]]:
    """Fed without a gap, as from a recording or a radio that sends on in blocks."""

    def parse(session: Session, wire: Wire) -> list[Frame]:
        parser = framer(LENGTHS)
        return parser.receive(session.data, 0.0) + parser.finish()

    return parse


def direct(session: Session, wire: Wire) -> list[Frame]:
    """Fed as a direct line delivers it: between two bursts of frames it is silent."""
    parser = Strzyga(LENGTHS, idle=0.005, patience=0.005)
    frames = []
    for tick, data in session.portions(wire):
        frames += parser.receive(data, tick * TICK)
    return frames + parser.finish()


PARSERS = {
    "naive": Parser(Strzyga.write, naive),
    "strzyga": Parser(Strzyga.write, continuous(Strzyga)),
    "direct line": Parser(Strzyga.write, direct),
    "strzyga-crc": Parser(StrzygaCrc.write, continuous(StrzygaCrc)),
}


def study(sent: Traffic, parser: Parser, damage: Damage, seed: int = SEED) -> Score:
    """Send the traffic through the channel and see what the parser makes of it."""
    wire = channel.wire(sent, parser.write)
    score = Score(len(sent.frames))
    where = {start: number for number, start in enumerate(wire.starts[:-1])}
    for session in damage(wire.data, Random(seed)):
        _judge(score, session, sent, wire, where, parser)
        score.intact += _intact(session, wire, where)
    return score


def _judge(score: Score, session: Session, sent: Traffic, wire: Wire, where: dict[int, int], parser: Parser) -> None:
    place = 0
    for frame in parser.parse(session, wire):
        written = parser.write(*frame)
        place = session.data.index(written, place)
        original = where.get(session.origins[place])
        if original is None or not _together(
            session, place, wire.starts[original + 1] - wire.starts[original], written
        ):
            score.false += 1
        elif sent.frames[original] == frame:
            score.received += 1
        else:
            score.corrupt += 1
        place += len(written)


def _together(session: Session, place: int, size: int, written: bytes) -> bool:
    last = place + size - 1
    return size == len(written) and session.origins[last] - session.origins[place] == size - 1


def _intact(session: Session, wire: Wire, where: dict[int, int]) -> int:
    """How many frames arrived as they were sent."""
    count = 0
    for place, origin in enumerate(session.origins):
        if origin in where:
            end = wire.starts[where[origin] + 1]
            last = place + end - origin - 1
            whole = last < len(session.origins) and session.origins[last] == end - 1
            count += whole and session.data[place : last + 1] == wire.data[origin:end]
    return count


def spoilt(frames: int) -> str:
    """The tables of the channel study."""
    lost, wrong = {}, {}
    for name, (payload, damage) in CASES.items():
        sent = channel.traffic(frames, payload, Random(SEED))
        scores = {parser: study(sent, PARSERS[parser], damage) for parser in PARSERS}
        lost[name] = {parser: score.lost_percent for parser, score in scores.items()}
        wrong[name] = {parser: score.false_per_1000 for parser, score in scores.items()}
        wrong[name] |= {f"{parser} corrupt": score.corrupt_per_1000 for parser, score in scores.items()}
    columns = {parser: (parser, ".3f") for parser in PARSERS}
    corrupt = {f"{parser}: corrupt": (f"{parser} corrupt", ".2f") for parser in ("strzyga", "strzyga-crc")}
    return (
        f"Intact frames lost, in % of them:\n\n{table(lost, columns)}\n"
        f"False frames per 1000 sent, and corrupt ones:\n\n{table(wrong, columns | corrupt)}"
    )


def speed(frames: int, portion: int = 4096, times: int = 5) -> str:
    """Undamaged telemetry through each dialect, best of `times`; 111 does not fit `hal062` and is left out there."""
    rows = {}
    for name, framer in DIALECTS.items():
        sent = channel.traffic(frames, channel.realistic, Random(SEED)).frames
        fitting = [frame for frame in sent if len(frame[1]) <= framer.LONGEST]
        stream = b"".join(framer.write(*frame) for frame in fitting)
        took = min(_through(framer(LENGTHS), stream, portion) for _ in range(times))
        rows[name] = {"bytes": len(stream) / took / 1e6, "frame": took / len(fitting) * 1e6}
    return f"Speed on one core:\n\n{table(rows, {'MB/s': ('bytes', '.1f'), 'us a frame': ('frame', '.2f')})}"


def _through(framer: Framer, stream: bytes, portion: int) -> float:
    """Processor time in s."""
    begun = time.process_time()
    for place in range(0, len(stream), portion):
        framer.receive(stream[place : place + portion], 0.0)
    return time.process_time() - begun


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=40_000, help="frames a case")
    frames = parser.parse_args().frames
    print(spoilt(frames))
    print(speed(frames))


if __name__ == "__main__":
    main()
