"""A recording through the machine that made it: the same inputs at the same times must give the same bytes.

The machine is made anew of what the recording says it was made from; every step tells it what it was told then, and
what it answers is compared with what is recorded: all lines, all frames and all events, to the last byte.
"""

from collections.abc import Iterable, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any

import msgspec

from timonel.core.effects import Effect
from timonel.core.frame import Frame
from timonel.errors import RecordingError
from timonel.gateway import machine
from timonel.gateway.moment import seconds
from timonel.gateway.recorder import READABLE, event_message, taken_apart
from timonel.recording.flight import (
    BUS,
    EVENTS,
    IN,
    OUT,
    PORTS,
    TIMER,
    Flight,
    Metadata,
    Record,
)
from timonel.recording.flight_bus import frames_of
from timonel.recording.flight_tape import STEPS
from timonel.vehicles.vehicle import Vehicle

Input = tuple[str, Any] | None
"""What the machine was told: a port and its bytes, or whether it came; the bus and its frames; None: time passed."""


class Answer(msgspec.Struct, gc=False):
    """What a machine answers at once, as it is recorded."""

    said: bytes
    sent: list[Frame]
    events: list[bytes]

    @classmethod
    def of(cls, effects: Sequence[Effect]) -> "Answer":
        """Of what the machine wants done."""
        said, sent, events = taken_apart(effects)
        return cls(said, sent, [event_message(event) for event in events])


class Step(msgspec.Struct, gc=False):
    """One time that the machine was told something, and what it answered."""

    number: int
    stamp_ns: int
    now_us: int
    told: Input
    answer: Answer


class Difference(msgspec.Struct, frozen=True):
    """The first thing that the machine answered differently, and when (wall clock and machine time, ns)."""

    stamp_ns: int
    now_us: int
    told: str
    recorded: str
    replayed: str


class Verdict(msgspec.Struct):
    """What a replay came to. `difference` None: everything that could be compared is the same.

    `notes` tell what could not be compared, and why. `frames` are those received, `said` counts bytes.
    """

    steps: int = 0
    frames: int = 0
    said: int = 0
    sent: int = 0
    events: int = 0
    began_us: int | None = None
    ended_us: int = 0
    difference: Difference | None = None
    notes: list[str] = []

    @property
    def seconds(self) -> float:
        """From the first step to the last."""
        return 0.0 if self.began_us is None else (self.ended_us - self.began_us) / 1e6

    def count(self, step: Step) -> None:
        """One more step was replayed."""
        self.steps += 1
        self.began_us = step.now_us if self.began_us is None else self.began_us
        self.ended_us = step.now_us
        match step.told:
            case (_, list() as frames):
                self.frames += len(frames)
        self.said += len(step.answer.said)
        self.sent += len(step.answer.sent)
        self.events += len(step.answer.events)


def verify(path: str | Path, frames_file: str | Path | None = None) -> Verdict:
    """Replay the run that a file is of, from its first segment on.

    `frames_file` stands in for the rover's own frames. Raises RecordingError where there is nothing to replay: no
    recording of ours, the first segment is missing, or what made it is not understood.
    """
    parts = segments(path)
    verdict = Verdict()
    vehicle: Vehicle | None = None
    expected = 0
    for part in parts:
        flight = Flight(part)
        vehicle = vehicle or machine.make(flight.metadata["timonel.machine"], frames_file)
        for page in flight.pages():
            steps = steps_of(page, expected)
            if steps and steps[0].number != expected:
                missing = steps[0].number - expected
                verdict.notes.append(f"{missing} steps are missing in {part.name}: what follows is not compared")
                return verdict
            verdict.difference = _play(vehicle, steps, verdict)
            if verdict.difference is not None:
                return verdict
            expected += len(steps)
        verdict.notes += [f"{part.name}: {damage.reason} (byte {damage.offset})" for damage in flight.damage]
    return verdict


def newest(path: Path) -> Path:
    """The file itself; of a directory the one that was written last. Raises RecordingError if there is none."""
    if not path.is_dir():
        return path
    files = sorted(path.glob("*.mcap"), key=lambda file: file.stat().st_mtime_ns)
    if not files:
        raise RecordingError(f"{path}: no recording (*.mcap) in this directory")
    return files[-1]


def segments(path: str | Path) -> list[Path]:
    """All files of the run that a file is of, in order, from the first one. Raises RecordingError."""
    path = Path(path)
    own = run_of(Flight(path).metadata, path)
    parts = {}
    for sibling in path.parent.glob("*.mcap"):
        try:
            run = Flight(sibling).metadata.get("timonel.recording", {})
        except RecordingError:
            continue
        if run.get("run") == own["run"]:
            parts[int(run["segment"])] = sibling
    if 0 not in parts:
        raise RecordingError(
            f"{path}: part {own['segment']} of a run whose first part is not in {path.parent} (was it deleted to keep "
            "the budget?): a machine can only be replayed from its beginning"
        )
    return [parts[number] for number in sorted(parts)]


def run_of(metadata: Metadata, path: Path) -> dict[str, str]:
    """What a recording says of its run. Raises RecordingError if it is not one of ours."""
    run = metadata.get("timonel.recording")
    if run is None or "timonel.machine" not in metadata:
        raise RecordingError(f"{path}: an MCAP file, but no recording of timonel's")
    if run.get("format") not in READABLE:
        readable = " and ".join(READABLE)
        raise RecordingError(f"{path}: of format {run.get('format')}; this version reads formats {readable}")
    return run


def steps_of(page: Iterable[Record], expected: int) -> list[Step]:
    """The steps of a page in order. They are numbered modulo 2**32 there, and from `expected` on here."""
    gathered = _Steps(expected)
    for record in page:
        gathered.add(record)
    return gathered.in_order()


class _Steps:
    """Gathers the steps of a page from its topics."""

    def __init__(self, expected: int) -> None:
        self._expected = expected
        self._steps: dict[int, Step] = {}

    def in_order(self) -> list[Step]:
        return [self._steps[number] for number in sorted(self._steps)]

    def add(self, record: Record) -> None:
        topic = record.topic
        if topic == BUS:
            self._add_frames(record)
        elif topic == OUT:
            self._at(record).answer.said += _text(record)
        elif topic == EVENTS:
            self._at(record).answer.events.append(record.data)
        elif topic == TIMER:
            self._at(record).told = None
        elif topic == PORTS:
            fields = record.fields
            self._at(record).told = (fields["port"], fields["connected"])
        elif topic.startswith(IN):
            self._at(record).told = (topic.removeprefix(IN), _text(record))

    def _add_frames(self, record: Record) -> None:
        """Runs once for each frame: written for speed."""
        frames = frames_of(record.data, record.step)
        if not frames:
            self._at(record).told = (BUS, [])
        now_us = record.now_ns // 1000
        for identifier, data, extended, sent, elapsed, number in frames:
            step = self._step(number, record.stamp_ns + elapsed * 1000, now_us + elapsed)
            frame = Frame(identifier, data, extended)
            if sent:
                step.answer.sent.append(frame)
            elif step.told is None:
                step.told = (BUS, [frame])
            else:
                step.told[1].append(frame)

    def _at(self, record: Record) -> Step:
        return self._step(record.step, record.stamp_ns, record.now_ns // 1000)

    def _step(self, number: int, stamp_ns: int, now_us: int) -> Step:
        number = self._expected + (number - self._expected) % STEPS
        step = self._steps.get(number)
        if step is None:
            step = self._steps[number] = Step(number, stamp_ns, now_us, None, Answer(b"", [], []))
        return step


def _text(record: Record) -> bytes:
    text: str = record.fields["text"]
    return text.encode("latin-1")


def _play(vehicle: Vehicle, steps: Sequence[Step], verdict: Verdict) -> Difference | None:
    """Tell the machine what it was told; the first difference."""
    for step in steps:
        answer = Answer.of(_tell(vehicle, step))
        verdict.count(step)
        if answer != step.answer:
            return _difference(step, answer)
    return None


def _tell(vehicle: Vehicle, step: Step) -> list[Effect]:
    now = seconds(step.now_us)
    match step.told:
        case None:
            return vehicle.expire(now)
        case (_, list() as frames):
            return vehicle.receive_frames(frames, now)
        case (port, bytes() as data):
            return vehicle.receive_bytes(port, data, now)
        case (port, connected):
            return vehicle.port_changed(port, connected, now)


def _difference(step: Step, answer: Answer) -> Difference:
    """What of the answer is not the same, the first of it."""
    recorded, replayed = step.answer, answer
    for before, now in (
        (recorded.said.splitlines(keepends=True), replayed.said.splitlines(keepends=True)),
        (recorded.sent, replayed.sent),
        (recorded.events, replayed.events),
    ):
        if before != now:
            one, other = next(pair for pair in zip_longest(before, now) if pair[0] != pair[1])
            return Difference(step.stamp_ns, step.now_us, _told(step), _shown(one), _shown(other))
    raise AssertionError("they are the same")


def _told(step: Step) -> str:
    """What the machine was told, for people."""
    match step.told:
        case None:
            return "time passed"
        case (_, list() as frames):
            return f"{len(frames)} {'frame' if len(frames) == 1 else 'frames'}: {', '.join(map(_shown, frames[:3]))}"
        case (port, bytes() as data):
            return f"{port}: {_shown(data)}"
        case (port, connected):
            return f"{port} {'came' if connected else 'went'}"


def _shown(what: object) -> str:
    match what:
        case None:
            return "nothing"
        case Frame(identifier, data, extended):
            return f"{identifier:08X}#{data.hex().upper()}" if extended else f"{identifier:03X}#{data.hex().upper()}"
        case _:
            return repr(what).removeprefix("b")
