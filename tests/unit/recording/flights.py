"""Small recordings for tests."""

from pathlib import Path

from timonel.core.frame import Frame
from timonel.recording.flight import EVENTS, OUT, TIMER, Metadata
from timonel.recording.flight_bus import SENT
from timonel.recording.flight_segment import SegmentFile
from timonel.recording.flight_tape import Page, Tape, text

OFFSET = 1_790_000_000_000_000_000  # ns from machine time to wall-clock time
METADATA: Metadata = {"timonel.recording": {"run": "a", "segment": "0"}}
HEADING = Frame(0x09F11223, bytes.fromhex("FF725AFF7FFF7FFD"))
SHORT = Frame(0x123, b"", extended=False)
LONG = Frame(108, bytes(range(20)), extended=False)
LINE = b"$IIHDT,182.3,T*2F\r\n"


def page(tape: Tape, first_us: int, steps: int = 3) -> Page:
    """`steps` steps, a millisecond apart, each with an answer, and one in which time passed."""
    for number in range(steps):
        us = first_us + 1000 * number
        tape.step += 1
        tape.frames([HEADING, SHORT], us)
        tape.add(tape.numbers[OUT], us, text(LINE))
        tape.frames([HEADING], us, SENT)
    tape.step += 1
    tape.add(tape.numbers[TIMER], first_us + 1000 * steps, b"{}")
    tape.add(tape.numbers[EVENTS], first_us + 1000 * steps, b'{"type":"Denied","station":2}')
    made = tape.take()
    assert made is not None
    return made


def recording(path: Path, pages: int = 3, finished: bool = True) -> list[int]:
    """A recording of so many chunks; where each of them ends in the file."""
    tape = Tape(["Bridge", "Flybridge"], OFFSET)
    segment = SegmentFile(path, METADATA)
    ends = []
    for number in range(pages):
        segment.write(page(tape, 1_000_000 * number))
        ends.append(segment.size)
    segment.finish() if finished else segment.close()
    return ends
