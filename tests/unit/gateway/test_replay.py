"""A recording through the machine that made it gives the same bytes, and whatever is not the same is noticed."""

from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec
import pytest

from tests import voyage
from tests.voyage import BOAT, ROVER, Voyage
from timonel.core.frame import Frame
from timonel.errors import RecordingError
from timonel.gateway import moment, replay
from timonel.gateway.replay import segments, verify
from timonel.recording.flight import BUS, EVENTS, MESSAGE, MESSAGE_HEAD, OUT, Flight, Metadata, Record
from timonel.recording.flight_bus import PACKED, ROW, layout, message_of
from timonel.recording.flight_segment import INDEX_ENTRY, SegmentFile
from timonel.recording.flight_tape import OWN, TEXT, Page, Topic
from timonel.recording.flight_writer import Limits
from timonel.vehicles.boat import vehicle as boat_vehicle
from timonel.vehicles.rover import vehicle as rover_vehicle

SECONDS = 20


@pytest.fixture(scope="module")
def boat(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of a boat in which much happens."""
    return Voyage(tmp_path_factory.mktemp("boat"), BOAT, seed=5).sail(SECONDS)


@pytest.fixture(scope="module")
def rover(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return Voyage(tmp_path_factory.mktemp("rover"), ROVER, seed=5).sail(SECONDS)


Change = Callable[[Record], bytes | None]
"""What a message becomes; None: it is left out."""


def altered(path: Path, output: Path, change: Change, metadata: Metadata | None = None) -> Path:
    """A copy of a recording in which the messages, or the metadata, are other ones."""
    flight = Flight(path)
    pages = list(flight.pages())
    names = [flight.topics[number] for number in sorted(flight.topics)]
    known = {topic.name: topic for topic in OWN}
    topics = tuple(known.get(name, Topic(name, TEXT)) for name in names)
    segment = SegmentFile(output, metadata or flight.metadata)
    for records in pages:
        if page := _page(topics, names, records, change):
            segment.write(page)
    segment.finish()
    return output


def _page(topics: tuple[Topic, ...], names: list[str], records: list[Record], change: Change) -> Page | None:
    page = Page(topics, bytearray(), {}, records[0].stamp_ns, records[-1].stamp_ns, 0)
    for record in records:
        if (data := change(record)) is None:
            continue
        channel = names.index(record.topic) + 1
        page.indexes.setdefault(channel, bytearray()).extend(INDEX_ENTRY.pack(record.stamp_ns, len(page.data)))
        head = (MESSAGE, 22 + len(data), channel, record.step, record.stamp_ns, record.now_ns)
        page.data += MESSAGE_HEAD.pack(*head) + data
    return page if page.data else None


def only(topic: str, number: int, change: Callable[[bytes], bytes | None]) -> Change:
    """Of all messages of a topic, that one is changed."""
    numbers = iter(range(10**9))

    def changed(record: Record) -> bytes | None:
        return change(record.data) if record.topic == topic and next(numbers) == number else record.data

    return changed


def test_the_same_seed_gives_the_same_file(tmp_path: Path, rover: Path) -> None:
    assert Voyage(tmp_path, ROVER, seed=5).sail(SECONDS).read_bytes() == rover.read_bytes()


# What is noticed --------------------------------------------------------------------------------------


@pytest.mark.parametrize("number", [0, 17, 100])
def test_one_byte_of_a_line_is_noticed(boat: Path, tmp_path: Path, number: int) -> None:
    change = only(OUT, number, lambda data: data[:20] + bytes((data[20] ^ 1,)) + data[21:])
    difference = verify(altered(boat, tmp_path / "a.mcap", change)).difference
    assert difference is not None
    assert difference.recorded != difference.replayed
    assert difference.recorded[:5] == difference.replayed[:5] == "'$"[:2] + difference.replayed[2:5]


def test_one_bit_of_a_sent_frame_is_noticed(rover: Path, tmp_path: Path) -> None:
    def flip(data: bytes) -> bytes:
        message = bytearray(data)
        _, contents, *_, flags = layout(data).columns
        sent = next(place for place in range(len(data) - flags) if data[flags + place])
        message[contents + 8 * sent] ^= 1
        return bytes(message)

    difference = verify(altered(rover, tmp_path / "a.mcap", only(BUS, 0, flip))).difference
    assert difference is not None
    assert "#" in difference.recorded
    assert difference.recorded != difference.replayed


def test_an_event_that_did_not_happen_is_noticed(boat: Path, tmp_path: Path) -> None:
    difference = verify(altered(boat, tmp_path / "a.mcap", only(EVENTS, 3, lambda data: None))).difference
    assert difference is not None
    assert "type" in difference.replayed


def test_a_constant_of_the_machine_that_is_another_one_is_noticed(
    boat: Path, rover: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(boat_vehicle, "STATUS_INTERVAL", 0.500001)
    monkeypatch.setattr(rover_vehicle, "LIMITS_PERIOD", 1.001)
    for recording in (boat, rover):
        assert verify(recording).difference is not None


def test_a_difference_tells_when_what_was_told_and_both_answers(boat: Path, tmp_path: Path) -> None:
    (line,) = (data for data in [b'{"text":"$PARP,NONSENSE\\r\\n"}'])
    difference = verify(altered(boat, tmp_path / "a.mcap", only(OUT, 0, lambda _: line))).difference
    assert difference is not None
    assert difference.recorded == r"'$PARP,NONSENSE\r\n'"
    assert difference.replayed.startswith("'$PARP,STATUS,")
    assert difference.told == "time passed"
    assert moment.microseconds(difference.now_us / 1e6) == difference.now_us
    assert difference.stamp_ns - voyage.BEGAN_NS == (difference.now_us - voyage.UPTIME_US) * 1000


# What cannot be compared ------------------------------------------------------------------------------


def test_a_recording_that_was_cut_off_is_verified_as_far_as_it_goes(boat: Path, tmp_path: Path) -> None:
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(boat.read_bytes()[: boat.stat().st_size // 2])
    verdict = verify(torn)
    assert verdict.difference is None
    assert SECONDS / 4 < verdict.seconds < SECONDS
    assert verdict.notes == [f"torn.mcap: the file is cut off (byte {len(torn.read_bytes()) - _rest(torn)})"]


def _rest(path: Path) -> int:
    flight = Flight(path)
    list(flight)
    return flight.damage[0].size


def test_what_follows_lost_steps_is_not_compared(boat: Path, tmp_path: Path) -> None:
    lost = list(Flight(boat).pages())[7]
    missing = [step.number for step in replay.steps_of(lost, 0)]
    verdict = verify(altered(boat, tmp_path / "a.mcap", lambda record: None if record in lost else record.data))
    assert verdict.difference is None
    assert verdict.steps == missing[0]
    assert verdict.notes == [f"{len(missing)} steps are missing in a.mcap: what follows is not compared"]


def test_every_part_of_a_run_leads_to_the_whole_run(tmp_path: Path) -> None:
    run = Voyage(tmp_path, ROVER, seed=3, limits=Limits(segment_size=50_000))
    first = run.sail(SECONDS)
    parts = segments(first)
    assert len(parts) > 2
    assert [segments(part) for part in parts] == [parts] * len(parts)
    assert verify(parts[-1]).steps == run.told


def test_a_run_without_its_first_part_cannot_be_replayed(tmp_path: Path) -> None:
    first = Voyage(tmp_path, ROVER, seed=3, limits=Limits(segment_size=50_000)).sail(SECONDS)
    parts = segments(first)
    first.unlink()
    with pytest.raises(RecordingError, match=r"part 1 of a run whose first part is not in .* the budget"):
        verify(parts[1])


def test_a_run_without_a_part_in_between_is_verified_up_to_there(tmp_path: Path) -> None:
    first = Voyage(tmp_path, ROVER, seed=3, limits=Limits(segment_size=50_000)).sail(SECONDS)
    parts = segments(first)
    parts[1].unlink()
    verdict = verify(first)
    assert verdict.difference is None
    assert f"steps are missing in {parts[2].name}" in verdict.notes[-1]


def told(metadata: Metadata, name: str, **changes: str) -> Metadata:
    return metadata | {name: metadata[name] | changes}


@pytest.mark.parametrize(
    ("name", "changes", "message"),
    [
        ("timonel.recording", {"format": "9"}, "of format 9; this version reads formats 1 and 2"),
        ("timonel.machine", {"vehicle": "submarine"}, "does not say what made it"),
        ("timonel.machine", {"settings": '{"depth":300}'}, "not understood: settings"),
        ("timonel.machine", {"began_us": ""}, "not understood: began_us"),
    ],
)
def test_what_this_version_does_not_understand_is_said(
    boat: Path, tmp_path: Path, name: str, changes: dict[str, str], message: str
) -> None:
    metadata = told(Flight(boat).metadata, name, **changes)
    copy = altered(boat, tmp_path / "a.mcap", lambda record: record.data, metadata)
    with pytest.raises(RecordingError, match=message):
        verify(copy)


def test_a_file_of_somebody_else_is_told_apart(boat: Path, tmp_path: Path) -> None:
    copy = altered(boat, tmp_path / "a.mcap", lambda record: record.data, {"other": {}})
    with pytest.raises(RecordingError, match="an MCAP file, but no recording of timonel's"):
        verify(copy)


def test_own_frames_that_are_a_program_are_run_only_if_they_are_given(rover: Path, tmp_path: Path) -> None:
    program = "raise SystemExit('this was run')"
    metadata = told(Flight(rover).metadata, "timonel.machine", frames_file="own.py", frames=program)
    copy = altered(rover, tmp_path / "a.mcap", lambda record: record.data, metadata)
    with pytest.raises(RecordingError, match=r"a program, own\.py: give it with --frames if you trust it"):
        verify(copy)
    own = tmp_path / "own.py"
    own.write_text("")
    assert verify(copy, own).difference is None


def test_own_frames_of_a_table_are_in_the_recording(rover: Path, tmp_path: Path) -> None:
    table = '[[frame]]\nid = 170\nname = "Gripper"\nto = "rover"\nfields = [{ name = "force", type = "u8" }]\n'
    metadata = told(Flight(rover).metadata, "timonel.machine", frames_file="own.toml", frames=table)
    verify(altered(rover, tmp_path / "a.mcap", lambda record: record.data, metadata))
    broken = told(metadata, "timonel.machine", frames="[[frame]]")
    with pytest.raises(RecordingError, match=r"own frames: own\.toml"):
        verify(altered(rover, tmp_path / "b.mcap", lambda record: record.data, broken))


def test_a_fault_of_the_program_comes_up_again(boat: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(boat_vehicle.Boat, "_status", fail)
    with pytest.raises(ZeroDivisionError):
        verify(boat)


# Steps ------------------------------------------------------------------------------------------------


def steps(records: list[Record], expected: int = 0) -> Iterator[tuple[int, object]]:
    return ((step.number, step.told) for step in replay.steps_of(records, expected))


def record(topic: str, step: int, data: bytes) -> Record:
    return Record(topic, step, 0, 0, data)


def test_steps_are_counted_beyond_32_bits() -> None:
    wrapped = [record("timer", 2**32 - 1, b"{}"), record("timer", 0, b"{}")]
    assert list(steps(wrapped, 2**32 - 1)) == [(2**32 - 1, None), (2**32, None)]


def test_frames_that_were_told_together_are_told_together() -> None:
    rows = b"".join(ROW.pack(0x123, 1, 0, 0, bytes((number,)), 0, number // 2) for number in range(4))
    columns = b"".join(PACKED.pack(0x123, bytes((number,)), 0, number == 2, 1, 0) for number in range(4))
    frames = [Frame(0x123, bytes((number,)), extended=False) for number in range(4)]
    for data in (b"\0\1\0\0\4\0\0\0" + rows, bytes(message_of(columns))):
        assert list(steps([record(BUS, 0, data)])) == [(0, (BUS, frames[:2])), (1, (BUS, frames[2:]))]


def test_a_batch_of_no_frames_is_told_too() -> None:
    assert list(steps([record(BUS, 4, b"\0\1\0\0\0\0\0\0")], 4)) == [(4, (BUS, []))]


def test_ports_and_their_bytes_are_told() -> None:
    message = msgspec.json.encode({"text": "\xff\x00"})
    records = [record("in/Bridge", 0, message), record("ports", 1, b'{"port":"Bridge","connected":false}')]
    assert list(steps(records)) == [(0, ("Bridge", b"\xff\x00")), (1, ("Bridge", False))]
