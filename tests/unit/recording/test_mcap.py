"""Our own recordings among the others: their frames, from the stream, whole or torn."""

import pytest

from tests.unit.recording.flights import HEADING, SHORT, recording
from tests.unit.recording.writers import gzipped
from timonel.recording import flight, open_log
from timonel.recording.mcap import Mcap


@pytest.fixture
def path(tmp_path):
    recording(tmp_path / "run.mcap")
    return tmp_path / "run.mcap"


def test_the_frames_are_those_that_the_flight_reader_gives(path):
    log = open_log(path)
    assert (log.format, log.kind, log.timed, log.dated) == ("MCAP", "frames", True, True)
    frames = list(log)
    assert frames == list(flight.frames(path)) != []
    assert {(frame.identifier, frame.extended) for frame in frames} == {
        (HEADING.identifier, True),
        (SHORT.identifier, False),
    }
    assert log.unreadable == []


def test_a_compressed_recording_is_one_too(path, tmp_path):
    (tmp_path / "packed").write_bytes(gzipped(path.read_bytes()))
    log = open_log(tmp_path / "packed")
    assert list(log) == list(flight.frames(path))
    assert log.unreadable == []


def test_a_torn_recording_gives_its_whole_chunks_wherever_it_is_cut(tmp_path):
    ends = recording(tmp_path / "run.mcap")
    whole = list(flight.frames(tmp_path / "run.mcap"))
    data = (tmp_path / "run.mcap").read_bytes()
    for end in range(ends[0] - 50, ends[-1], 7):
        reader = Mcap(data[:end])
        found = [*reader.receive(data[:end]), *reader.finish()]
        frames = [each for each in found if each in whole]
        assert frames == whole[: len(frames)]
        assert len(frames) >= len(whole) * sum(end >= each for each in ends) // len(ends)
        assert len(found) - len(frames) <= 1


def test_a_damaged_chunk_is_told_and_the_next_is_read(tmp_path):
    ends = recording(tmp_path / "run.mcap")
    data = bytearray((tmp_path / "run.mcap").read_bytes())
    data[ends[0] + 150 : ends[0] + 160] = bytes(10)
    (tmp_path / "log").write_bytes(data)
    log = open_log(tmp_path / "log")
    assert len(list(log)) == len(list(flight.frames(tmp_path / "run.mcap"))) * 2 // 3
    assert len(log.unreadable) == 1
    assert log.unreadable[0].offset is not None


def test_an_mcap_file_without_a_bus_says_so(tmp_path):
    topic = flight.RECORD.pack(flight.CHANNEL, 16) + b"\1\0\0\0\4\0\0\0imu " + bytes(4)
    reader = Mcap(flight.MAGIC + topic)
    found = [*reader.receive(flight.MAGIC + topic), *reader.finish()]
    assert [each.reason for each in found] == ["no topic `bus`"]
