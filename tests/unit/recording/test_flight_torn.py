"""A recording that was cut off is read up to its last whole chunk, and made sound again."""

from pathlib import Path
from random import Random

import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from tests.unit.recording.flights import METADATA, recording
from timonel.errors import RecordingError
from timonel.recording.flight import MAGIC, Flight, Record
from timonel.recording.flight_repair import repair

RUBBISH = 400  # files


def cut_to(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


def records_by_chunk(path: Path) -> list[list[Record]]:
    return list(Flight(path).pages())


def test_wherever_it_is_cut_off_all_whole_chunks_are_read(tmp_path: Path) -> None:
    ends = recording(tmp_path / "whole.mcap")
    whole, chunks = (tmp_path / "whole.mcap").read_bytes(), records_by_chunk(tmp_path / "whole.mcap")
    assert len(chunks) == 3
    for size in range(len(MAGIC), len(whole)):
        flight = Flight(cut_to(tmp_path / "torn.mcap", whole[:size]))
        read = list(flight.pages())
        # the message indexes behind a chunk may be missing: the chunk itself is whole
        assert len(read) >= sum(end <= size for end in ends)
        assert read == chunks[: len(read)]
        assert not flight.finished
        assert flight.damage[-1].reason == "the file is cut off"
        assert flight.damage[-1].offset + flight.damage[-1].size == size


def test_a_whole_recording_has_no_damage(tmp_path: Path) -> None:
    recording(tmp_path / "whole.mcap")
    flight = Flight(tmp_path / "whole.mcap")
    assert len(list(flight)) == 3 * 6
    assert (flight.finished, flight.damage) == (True, [])


def test_zeros_that_a_power_cut_left_behind_are_the_end(tmp_path: Path) -> None:
    ends = recording(tmp_path / "whole.mcap", finished=False)
    whole = (tmp_path / "whole.mcap").read_bytes()
    flight = Flight(cut_to(tmp_path / "torn.mcap", whole[: ends[1]] + bytes(5000)))
    assert len(list(flight.pages())) == 2
    assert [(damage.offset, damage.size) for damage in flight.damage] == [(ends[1], 5000)]


def test_a_chunk_that_was_changed_is_left_out_and_told(tmp_path: Path) -> None:
    ends = recording(tmp_path / "whole.mcap")
    whole, chunks = bytearray((tmp_path / "whole.mcap").read_bytes()), records_by_chunk(tmp_path / "whole.mcap")
    whole[ends[0] + 80] ^= 1
    flight = Flight(cut_to(tmp_path / "torn.mcap", bytes(whole)))
    assert list(flight.pages()) == [chunks[0], chunks[2]]
    assert [damage.offset for damage in flight.damage] == [ends[0]]
    assert "a chunk is damaged" in flight.damage[0].reason


def test_no_rubbish_raises(tmp_path: Path) -> None:
    recording(tmp_path / "whole.mcap")
    whole, random = (tmp_path / "whole.mcap").read_bytes(), Random(1)
    for number in range(RUBBISH):
        data = bytearray(whole)
        for _ in range(random.randrange(1, 6)):
            place = random.randrange(len(MAGIC), len(data))
            data[place : place + random.randrange(3)] = random.randbytes(random.randrange(4))
        path = cut_to(tmp_path / "rubbish.mcap", bytes(data))
        list(Flight(path))
        repair(path, tmp_path / f"{number}.mcap")


@pytest.mark.parametrize("from_the_end", range(1, 900, 23))
def test_a_repaired_file_is_sound_and_has_all_that_could_be_read(tmp_path: Path, from_the_end: int) -> None:
    recording(tmp_path / "whole.mcap")
    whole = (tmp_path / "whole.mcap").read_bytes()
    torn = cut_to(tmp_path / "torn.mcap", whole[:-from_the_end])
    repaired = repair(torn, tmp_path / "mended.mcap")
    mended = Flight(tmp_path / "mended.mcap")
    records = list(mended)
    assert records == list(Flight(torn))
    assert (mended.finished, mended.damage, mended.metadata) == (True, [], METADATA)
    assert (repaired.messages, repaired.size) == (len(records), (tmp_path / "mended.mcap").stat().st_size)
    with open(tmp_path / "mended.mcap", "rb") as file:
        assert len(list(make_reader(file, validate_crcs=True).iter_messages())) == len(records)


def test_a_repaired_whole_file_is_the_same_file(tmp_path: Path) -> None:
    recording(tmp_path / "whole.mcap")
    repaired = repair(tmp_path / "whole.mcap", tmp_path / "mended.mcap")
    assert (tmp_path / "mended.mcap").read_bytes() == (tmp_path / "whole.mcap").read_bytes()
    assert repaired.lost == 0


def test_what_is_lost_is_told(tmp_path: Path) -> None:
    ends = recording(tmp_path / "torn.mcap", finished=False)
    with open(tmp_path / "torn.mcap", "rb+") as file:
        file.truncate(ends[2] - 200)
    repaired = repair(tmp_path / "torn.mcap", tmp_path / "mended.mcap")
    assert (repaired.chunks, repaired.messages) == (2, 12)
    assert repaired.lost == ends[2] - 200 - ends[1]


def test_recordings_of_others_are_repaired_too(tmp_path: Path) -> None:
    path = tmp_path / "foreign.mcap"
    writer = Writer(str(path), chunk_size=200)
    writer.start()
    schema = writer.register_schema("S", "jsonschema", b"{}")
    channel = writer.register_channel("t", "json", schema)
    writer.add_attachment(0, 0, "chart", "text/plain", b"here be dragons")
    for number in range(50):
        writer.add_message(channel, number, b"{}", number)
    writer.finish()
    writer._Writer__stream.close()
    torn = cut_to(tmp_path / "torn.mcap", path.read_bytes()[:1500])
    repaired = repair(torn, tmp_path / "mended.mcap")
    with open(tmp_path / "mended.mcap", "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert [attachment.data for attachment in reader.iter_attachments()] == [b"here be dragons"]
        numbers = [message.log_time for _, _, message in reader.iter_messages()]
    assert numbers == list(range(repaired.messages))
    assert repaired.messages > 10


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    recording(tmp_path / "whole.mcap")
    with pytest.raises(RecordingError, match=r"whole\.mcap: File exists"):
        repair(tmp_path / "whole.mcap", tmp_path / "whole.mcap")
