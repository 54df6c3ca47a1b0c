"""What the rover's framings make of a bad link, and how fast they are: `python -m benchmarks.framing`.

A frame is intact if all its bytes arrive, unchanged and together. What a parser emits is true if it begins where a
frame began and says the same; corrupt if bits of it were changed on the way (its data, or its id into another one of
the same length); false if it was put together from pieces.
"""

import argparse
import struct
import time
from collections import deque
from collections.abc import Callable
from functools import partial
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
    return score


def _judge(score: Score, session: Session, sent: Traffic, wire: Wire, where: dict[int, int], parser: Parser) -> None:
    intact = _intact(session, wire, where)
    score.intact += len(intact)
    place = 0
    for frame in parser.parse(session, wire):
        written = parser.write(*frame)
        place = session.data.index(written, place)
        original = where.get(session.origins[place])
        if original is not None and sent.frames[original] == frame:
            score.received += original in intact
        elif original is not None and len(written) == _size(wire, original) and _together(session, place, len(written)):
            score.corrupt += 1
        else:
            score.false += 1
        place += len(written)


def _size(wire: Wire, number: int) -> int:
    return wire.starts[number + 1] - wire.starts[number]


def _together(session: Session, place: int, size: int) -> bool:
    last = place + size - 1
    return last < len(session.origins) and session.origins[last] - session.origins[place] == size - 1


def _intact(session: Session, wire: Wire, where: dict[int, int]) -> set[int]:
    """The frames that arrived as they were sent."""
    intact = set()
    for place, origin in enumerate(session.origins):
        if origin in where:
            size = _size(wire, where[origin])
            unchanged = session.data[place : place + size] == wire.data[origin : origin + size]
            if unchanged and _together(session, place, size):
                intact.add(where[origin])
    return intact


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


UPLINK = {100: 2, 101: 1}
SENDERS: dict[str, tuple[type[Framer], Callable[[int, bytes], bytes], float]] = {
    "strzyga, no gaps": (Strzyga, Strzyga.write, 0.0),
    "strzyga": (Strzyga, Strzyga.write, TICK),
    "strzyga, pad = 2": (Strzyga, partial(Strzyga.write, pad=2), TICK),
    "strzyga-crc, no gaps": (StrzygaCrc, StrzygaCrc.write, 0.0),
    "strzyga-crc": (StrzygaCrc, StrzygaCrc.write, TICK),
}


class Orders(msgspec.Struct):
    """What a controller makes of a drive at 50 Hz, half of it at rest."""

    taken: int = 0
    invented: int = 0
    """Set points that were not among the last four sent."""


def orders(name: str, count: int, share: float = 1e-2, seed: int = SEED) -> Orders:
    """Drive through a link that loses `share` of the bytes; every tenth frame 100 has a permission before it."""
    framer, write, tick = SENDERS[name]
    random = Random(seed)
    parser = framer(UPLINK)
    result = Orders()
    recent: deque[Frame] = deque(maxlen=4)
    x = y = 0
    for number in range(count):
        x, y = (_moved(x, random), _moved(y, random)) if number // 500 % 2 else (0, 0)
        recent.append((100, struct.pack("bb", y, x)))
        written = write(*recent[-1]) if number % 10 else write(101, b"1") + write(*recent[-1])
        arrived = bytes(byte for byte in written if random.random() >= share)
        taken = [frame for frame in parser.receive(arrived, number * tick) if frame[0] == 100]
        result.taken += len(taken)
        result.invented += sum(frame not in recent for frame in taken)
    return result


def _moved(stick: int, random: Random) -> int:
    return max(-100, min(100, stick + random.randint(-6, 6)))


def driven(frames: int) -> str:
    """The table of the way up."""
    rows = {}
    for name in SENDERS:
        made = orders(name, frames)
        rows[name] = {"lost": 100 * (1 - made.taken / frames), "invented": 1e6 * made.invented / made.taken}
    columns = {"set points lost, %": ("lost", ".1f"), "never sent, per million": ("invented", ".0f")}
    return f"Driving at 1 % byte loss:\n\n{table(rows, columns)}"


def speed(frames: int, portion: int = 4096, times: int = 5) -> str:
    """Telemetry through each dialect, best of `times`; 111 does not fit `hal062` and is left out there."""
    rows = {}
    for name, framer in DIALECTS.items():
        sent = channel.traffic(frames, channel.realistic, Random(SEED)).frames
        fitting = [frame for frame in sent if len(frame[1]) <= framer.LONGEST]
        clean = b"".join(framer.write(*frame) for frame in fitting)
        spoilt = channel.byte_loss(1e-2)(clean, Random(SEED))[0].data
        took = min(_through(framer(LENGTHS), clean, portion) for _ in range(times))
        took_spoilt = min(_through(framer(LENGTHS), spoilt, portion) for _ in range(times))
        rows[name] = {"clean": len(clean) / took / 1e6, "frame": took / len(fitting) * 1e6}
        rows[name] |= {"spoilt": len(spoilt) / took_spoilt / 1e6}
    columns = {"MB/s": ("clean", ".1f"), "us a frame": ("frame", ".2f"), "MB/s at 1 % byte loss": ("spoilt", ".1f")}
    return f"Speed on one core:\n\n{table(rows, columns)}"


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
    print(driven(10 * frames))
    print(speed(frames))


if __name__ == "__main__":
    main()
