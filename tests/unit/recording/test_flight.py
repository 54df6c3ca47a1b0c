from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from tests.unit.recording.flights import HEADING, LINE, LONG, METADATA, OFFSET, SHORT, page, recording
from timonel.core.frame import Frame
from timonel.errors import RecordingError
from timonel.recording.flight import (
    BUS,
    EVENTS,
    OUT,
    TIMER,
    Flight,
    frames,
    read,
)
from timonel.recording.flight_bus import LONGEST_PAUSE, MOST_STEPS, ROW, frames_of, layout, message_of
from timonel.recording.flight_segment import SegmentFile
from timonel.recording.flight_tape import SPAN, Tape


def test_what_was_recorded_is_read_back_with_both_times(tmp_path: Path) -> None:
    recording(tmp_path / "a.mcap", pages=1)
    line = next(record for record in read(tmp_path / "a.mcap") if record.topic == OUT)
    assert line.fields == {"text": LINE.decode()}
    assert (line.step, line.now_ns, line.stamp_ns) == (0, 0, OFFSET)
    event = next(record for record in read(tmp_path / "a.mcap") if record.topic == EVENTS)
    assert event.fields == {"type": "Denied", "station": 2}
    assert (event.step, event.now_ns, event.stamp_ns) == (3, 3_000_000, OFFSET + 3_000_000)


def test_frames_are_read_back_with_direction_time_and_step(tmp_path: Path) -> None:
    recording(tmp_path / "a.mcap", pages=1)
    (message,) = [record for record in read(tmp_path / "a.mcap") if record.topic == BUS]
    assert message.stamp_ns == OFFSET
    found = [(frame.identifier, frame.data, frame.extended, frame.sent, frame.elapsed, frame.step)
             for frame in frames_of(message.data, message.step)]  # fmt: skip
    assert found[:4] == [
        (HEADING.identifier, HEADING.data, True, False, 0, 0),
        (SHORT.identifier, b"", False, False, 0, 0),
        (HEADING.identifier, HEADING.data, True, True, 0, 0),
        (HEADING.identifier, HEADING.data, True, False, 1000, 1),
    ]


def test_frames_are_a_log_with_wall_clock_times(tmp_path: Path) -> None:
    recording(tmp_path / "a.mcap", pages=1)
    both = list(frames(tmp_path / "a.mcap"))
    assert [len(list(frames(tmp_path / "a.mcap", sent=sent))) for sent in (None, False, True)] == [9, 6, 3]
    assert both[0].frame == HEADING
    assert both[3].stamp == (OFFSET + 1_000_000) / 1e9


def test_a_frame_of_a_uart_may_be_longer_than_a_row() -> None:
    tape = Tape([], 0)
    tape.step += 1
    tape.frames([LONG, SHORT], 0)
    made = tape.take()
    assert made is not None
    content = bytes(made.data[31:])
    assert layout(content).frames == 4
    assert [Frame(frame.identifier, frame.data, frame.extended) for frame in frames_of(content, 0)] == [LONG, SHORT]


def test_a_message_of_the_bus_spans_a_tenth_of_a_second(tmp_path: Path) -> None:
    tape = Tape([], 0)
    for us in (0, SPAN // 2, SPAN - 1, SPAN, SPAN + 1):
        tape.step += 1
        tape.frames([HEADING], us)
    made = tape.take()
    assert made is not None
    segment = SegmentFile(tmp_path / "a.mcap", METADATA)
    segment.write(made)
    segment.finish()
    assert [(record.step, len(frames_of(record.data, 0))) for record in read(tmp_path / "a.mcap")] == [
        (0, 3),
        (3, 2),
    ]


@pytest.mark.parametrize(
    ("pause", "quiet"), [(LONGEST_PAUSE, 0), (LONGEST_PAUSE + 1, 0), (0, MOST_STEPS), (1, 1 + MOST_STEPS)]
)
def test_frames_after_a_pause_or_many_steps_have_their_time_and_step(tmp_path: Path, pause: int, quiet: int) -> None:
    tape = Tape([], OFFSET)
    tape.step = (1 << 32) - 1
    tape.frames([HEADING], 7)
    tape.step += quiet
    tape.frames([HEADING, SHORT], 7 + pause)
    segment = SegmentFile(tmp_path / "a.mcap", METADATA)
    segment.write(tape.take())
    segment.finish()
    records = list(read(tmp_path / "a.mcap"))
    assert len(records) == 1 + (pause > LONGEST_PAUSE or quiet > MOST_STEPS)
    last = frames_of(records[-1].data, records[-1].step)[-1]
    assert records[-1].now_ns // 1000 + last.elapsed == 7 + pause
    assert last.step == ((1 << 32) - 1 + quiet) % (1 << 32)
    assert last.identifier == SHORT.identifier


def test_frames_in_rows_as_they_were_recorded_before_are_read() -> None:
    rows = ROW.pack(HEADING.identifier | 1 << 31, 8, 1, 0, HEADING.data, 250, 7)
    (frame,) = frames_of(b"\0\1\0\0\1\0\0\0" + rows, 3)
    assert frame == (HEADING.identifier, HEADING.data, True, True, 250, 7)


def test_no_size_of_a_message_could_be_that_of_rows_and_of_columns() -> None:
    for count in range(1, 2000):
        message = bytes(message_of(bytes(17 * count)))
        assert layout(message).columns
        assert not layout(message[:4] + count.to_bytes(4, "little") + bytes(24 * count)).columns
    assert frames_of(bytes(message_of(b"")), 0) == []


@pytest.mark.parametrize("changed", [b"", bytes(7), bytes(9), bytes(40), bytes(message_of(bytes(17)))[:-1]])
def test_a_message_that_is_not_made_of_frames_has_none(changed: bytes) -> None:
    assert layout(changed) is None
    assert frames_of(changed, 0) == []


def test_a_message_of_the_bus_that_is_not_made_of_frames_is_damage(tmp_path: Path) -> None:
    tape = Tape([], OFFSET)
    tape.step += 1
    tape.add(tape.numbers[BUS], 0, b"no frames")
    tape.frames([HEADING], 1)
    segment = SegmentFile(tmp_path / "a.mcap", METADATA)
    segment.write(tape.take())
    segment.finish()
    flight = Flight(tmp_path / "a.mcap")
    assert len(list(flight)) == 1
    assert [damage.reason for damage in flight.damage] == ["a message is not made of frames"]


def test_steps_are_counted_on_beyond_32_bits(tmp_path: Path) -> None:
    tape = Tape([], 0)
    tape.step = (1 << 32) - 2
    segment = SegmentFile(tmp_path / "a.mcap", METADATA)
    segment.write(page(tape, 0, steps=2))
    segment.finish()
    assert [record.step for record in read(tmp_path / "a.mcap") if record.topic in (OUT, TIMER)] == [
        (1 << 32) - 1,
        0,
        1,
    ]


def test_the_mcap_library_reads_a_recording_by_its_index_with_all_check_sums(tmp_path: Path) -> None:
    recording(tmp_path / "a.mcap")
    with open(tmp_path / "a.mcap", "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        topics = [channel.topic for _, channel, _ in reader.iter_messages(topics=[OUT, BUS])]
        assert [(metadata.name, metadata.metadata) for metadata in reader.iter_metadata()] == list(METADATA.items())
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == len(list(read(tmp_path / "a.mcap")))
    assert (summary.statistics.message_start_time, summary.statistics.message_end_time) == (
        OFFSET,
        OFFSET + 2_003_000_000,
    )
    assert (topics.count(OUT), topics.count(BUS)) == (9, 3)


def test_a_reader_of_ros_messages_understands_the_bus(tmp_path: Path) -> None:
    recording(tmp_path / "a.mcap", pages=1)
    with open(tmp_path / "a.mcap", "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        (message,) = [decoded for *_, decoded in reader.iter_decoded_messages(topics=[BUS])]
    assert list(message.identifier[:2]) == [HEADING.identifier | 1 << 31, 0x123]
    assert bytes(message.data[:16]) == HEADING.data + bytes(8)
    assert list(message.length[:2]) == [8, 0]
    assert list(message.flags[:4]) == [0, 0, 1, 0]
    assert list(message.since[:4]) == [0, 0, 0, 1000]
    assert list(message.steps[:4]) == [0, 0, 0, 1]


def test_a_page_holds_whole_steps(tmp_path: Path) -> None:
    recording(tmp_path / "a.mcap")
    steps = [{record.step for record in chunk} for chunk in Flight(tmp_path / "a.mcap").pages()]
    assert steps == [{0, 1, 2, 3}, {4, 5, 6, 7}, {8, 9, 10, 11}]


def test_metadata_is_there_before_anything_is_read(tmp_path: Path) -> None:
    recording(tmp_path / "a.mcap")
    assert Flight(tmp_path / "a.mcap").metadata == METADATA


@pytest.mark.parametrize("content", [b"", b"\x89MCAP", b"(1620807235.135072) can0 09F8017F#3E17B322B320590D\n"])
def test_what_is_no_mcap_file_is_an_error(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=r"a\.mcap: not an MCAP file"):
        Flight(path)
    with pytest.raises(RecordingError, match="No such file"):
        Flight(tmp_path / "b.mcap")
    with pytest.raises(RecordingError, match="directory"):
        Flight(tmp_path)
