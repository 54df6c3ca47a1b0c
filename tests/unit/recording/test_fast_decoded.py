"""Messages made thousands at a time are those that are made one by one."""

import gzip
import random
from typing import Annotated

import pytest

import timonel
from tests.recordings import recording
from tests.unit.recording import flights
from tests.unit.recording.test_chunks import lines
from timonel.errors import RecordingError
from timonel.nmea2000.fastpacket import fragment
from timonel.nmea2000.identifier import join
from timonel.recording import chunks, decoded, fast_decoded, open_log
from timonel.recording.decoded import Message, OwnMessage, Recording, open_recording
from timonel.recording.flight_segment import SegmentFile
from timonel.recording.flight_tape import Tape
from timonel.vehicles.rover.conversions import signal
from timonel.vehicles.rover.declaration import RoverFrame
from timonel.vehicles.rover.protocol import Protocol

SAMPLES = "canboat_canboat/samples"
TRACK, GNSS, HEADING, VARIANTS, UNKNOWN = 127237, 129029, 127250, 65280, 130762


class Arm(RoverFrame, frame=151, segmented=True):
    """Ten bytes of an arm."""

    a: Annotated[int | None, signal("u32")]
    b: Annotated[int | None, signal("u32")]
    c: Annotated[int | None, signal("u16")]


ROVER = Protocol(own=(Arm,))


def same(path):
    """The messages of a file, after a look at everything in both ways."""
    one_by_one, many = Recording(open_log(path), ROVER), Recording(open_log(path), ROVER, many=True)
    expected, found = list(one_by_one), list(many)
    assert found == expected
    assert [message.line() for message in found[:500]] == [message.line() for message in expected[:500]]
    assert many.counters == one_by_one.counters
    for kept in ("frames", "unreadable", "unreadable_count", "bytes_read"):
        assert getattr(many.log, kept) == getattr(one_by_one.log, kept)
    return found


def bus(count, seed=1):
    """Lines of `candump -L` with all that can come on a bus, some of it lost, some of it doubled."""
    draw = random.Random(seed)
    now = 1_700_000_000_000_000
    for number in range(count):
        pgn = draw.choice((TRACK, GNSS, HEADING, VARIANTS, UNKNOWN))
        identifier = join(draw.randrange(8), pgn, draw.randrange(3))
        payload = draw.randbytes({TRACK: 21, GNSS: draw.randrange(43, 60)}.get(pgn, draw.randrange(9)))
        frames = fragment(payload, number) if pgn in (TRACK, GNSS) else [payload]
        if draw.random() < 0.1:
            identifier, frames = 104, [draw.randbytes(6)]
        elif draw.random() < 0.1:
            identifier, frames = Arm.FRAME, [draw.randbytes(8), draw.randbytes(2)]
        for data in frames:
            now += draw.choice((50, 700, 900, 30_000))
            digits = f"{identifier:03X}" if identifier < 0x800 else f"{identifier:08X}"
            line = f"({now // 10**6}.{now % 10**6:06d}) can0 {digits}#{data.hex().upper()}"
            yield from draw.choices(([line], [], [line, line], ["no line"], [line + " R"]), (90, 3, 3, 1, 1))[0]


def written(path, found):
    path.write_text("".join(f"{line}\n" for line in found))
    return path


@pytest.mark.parametrize("size", [64, 1 << 14])
def test_a_bus_with_everything_on_it_gives_the_same_messages(tmp_path, monkeypatch, size):
    monkeypatch.setattr(fast_decoded, "CHUNK", size)
    found = same(written(tmp_path / "log", bus(6000)))
    assert {type(message) for message in found} == {Message, OwnMessage}
    assert {len(message.data) for message in found if isinstance(message, OwnMessage)} == {6, 10}


@pytest.mark.parametrize("name", ["can0-2.pcap", "can0-3.pcap", "candumpSample2.txt", "candump-fast.txt"])
def test_recordings_give_the_same_messages(name):
    assert same(recording(f"{SAMPLES}/{name}"))


def test_printed_lines_without_times_and_with_times_of_no_date_give_the_same_messages(tmp_path):
    data = [f"  can0  {join(2, HEADING, 5):08X}   [8]  {random.Random(n).randbytes(8).hex(' ')}" for n in range(50)]
    assert {message.time for message in same(written(tmp_path / "none", data))} == {None}
    times = [f" (000.{n:06d}){line}" for n, line in enumerate(data)]
    assert {message.time for message in same(written(tmp_path / "no date", times))} == {None}
    mixed = [f"(1700000000.{n:06d}) can0 {join(2, HEADING, 5):08X}#00" for n in range(9)]
    assert {message.time is None for message in same(written(tmp_path / "mixed", mixed + data))} == {True, False}


def test_our_own_recordings_give_the_same_messages(tmp_path):
    flights.recording(tmp_path / "flight.mcap")
    assert {message.name for message in same(tmp_path / "flight.mcap")} >= {"vesselHeading"}


def test_messages_that_were_recorded_whole_stay_in_their_place(tmp_path):
    product = flights.Frame(join(6, 126996, 5), bytes(range(134)))
    transported = flights.Frame(join(6, 65240, 5), bytes(range(9)))
    tape = Tape(["Bridge"], flights.OFFSET)
    for frames in ([flights.HEADING, product], [transported, flights.LONG, flights.HEADING], [product, product]):
        tape.step += 1
        tape.frames(frames, tape.step * 500_000)
    segment = SegmentFile(tmp_path / "run.mcap", flights.METADATA)
    segment.write(tape.take())
    segment.finish()
    assert [len(message.data) for message in same(tmp_path / "run.mcap")] == [8, 134, 9, 20, 8, 134, 134]


def test_nothing_but_lost_fast_packets_gives_no_message(tmp_path):
    text = [f"(1700000000.000000) can0 {join(2, TRACK, 5):08X}#0100112233445566"] * 5
    assert same(written(tmp_path / "log", text)) == []


def test_long_recordings_are_read_many_frames_at_a_time_and_others_one_by_one(tmp_path, monkeypatch):
    path = tmp_path / "log.gz"
    path.write_bytes(gzip.compress("".join(lines(30_000)).encode(), 0))
    used = []
    monkeypatch.setattr(fast_decoded, "FrameReader", lambda *given: used.append(given) or chunks.FrameReader(*given))
    assert len(list(open_recording(path))) == 30_000
    assert len(used) == 1
    list(open_recording(recording(f"{SAMPLES}/candumpSample2.txt")))
    monkeypatch.setattr(decoded, "find_spec", lambda name: None)
    assert sum(1 for _ in open_recording(path)) == 30_000
    assert len(used) == 1


def test_a_strict_recording_gives_all_messages_before_what_it_refuses(tmp_path):
    text = [line.strip() for line in lines(30_000)]
    text[20_000] = "no line"
    found = []
    with pytest.raises(RecordingError, match="line 20001"):
        found.extend(timonel.open_recording(written(tmp_path / "log", text), strict=True))
    assert len(found) == 20_000


def test_what_is_read_many_frames_at_a_time_is_what_has_a_reader_for_it():
    assert set(decoded.FAST) == set(chunks.FAST)
