"""Recordings in chunks: read many frames at a time, they are what they are when read one by one."""

import gzip
import random
import struct

import numpy as np
import pytest

from tests.unit.recording.flights import HEADING, LONG, METADATA, OFFSET, SHORT, recording
from timonel.errors import RecordingError
from timonel.recording import flight, flight_bus, open_log
from timonel.recording.candump_words import BLOCK
from timonel.recording.chunks import open_frames
from timonel.recording.flight_segment import SegmentFile
from timonel.recording.flight_tape import Tape
from timonel.recording.frames import concatenate, from_logframes

pytestmark = pytest.mark.usefixtures("each_way")

LINE = "(1620807235.135421) can0 09F8017F#3E17B322B320590D\n"


def lines(count, seed=1):
    """Lines of `candump -L` as a bus gives them: mostly of one length."""
    draw = random.Random(seed)
    for place in range(count):
        size = 8 if draw.random() < 0.98 else draw.randrange(8)
        number = draw.choice((0x09F8017F, 0x0DF11917, 0x1FFFFFFF, 0))
        time, data = f"{1620807235 + place // 50}.{place * 20011 % 10**6:06d}", draw.randbytes(size).hex().upper()
        yield f"({time}) can0 {number:08X}#{data}\n"


def same(path, size=1 << 18):
    """The frames of a file, after a look at everything in both ways of reading."""
    log, reader = open_log(path), open_frames(path, size=size)
    expected = from_logframes(list(log))
    chunks = list(reader)
    found = concatenate(chunks)
    assert found.rows.tobytes() == expected.rows.tobytes()
    assert found.stamp.tolist() == expected.stamp.tolist()
    assert found.spill.tobytes() == expected.spill.tobytes()
    assert reader.log.unreadable == log.unreadable
    assert reader.log.unreadable_count == log.unreadable_count
    assert reader.log.frames == log.frames == len(found)
    assert reader.log.bytes_read == log.bytes_read
    return chunks


def written(path, content):
    path.write_bytes(content if isinstance(content, bytes) else content.encode("latin-1"))
    return path


def test_a_bus_of_many_blocks_is_read(tmp_path):
    assert sum(map(len, same(written(tmp_path / "log", "".join(lines(3 * BLOCK)))))) == 3 * BLOCK


def test_lines_of_one_length_are_read(tmp_path):
    same(written(tmp_path / "log", LINE * (2 * BLOCK + 5)))


@pytest.mark.parametrize("size", range(9))
def test_lines_of_any_length_of_data_are_read(tmp_path, size):
    text = f"(1620807235.135421) can0 09F8017F#{bytes(range(size)).hex().upper()}\n"
    same(written(tmp_path / "log", text * (BLOCK + 100)))
    same(written(tmp_path / "log", (LINE + text) * 100))


@pytest.mark.parametrize("name", ["x", "can0", "vcan12", "slcan10", "an_interface_15"])
@pytest.mark.parametrize("identifier", ["09F8017F", "06C"])
def test_interfaces_and_identifiers_of_any_length_are_read(tmp_path, name, identifier):
    text = f"(1620807235.135421) {name} {identifier}#3E17\n"
    frames = same(written(tmp_path / "log", text * 300))[0]
    assert len(frames) == 300
    assert frames.data[299].tolist() == [0x3E, 0x17, 0, 0, 0, 0, 0, 0]


def test_two_buses_in_one_log_are_read(tmp_path):
    text = LINE + LINE.replace("can0", "can1") + LINE.replace("can0", "vcan0")
    assert len(same(written(tmp_path / "log", text * 4000))[0]) == 12000


def test_chunks_are_about_as_large_as_asked_for(tmp_path):
    chunks = same(written(tmp_path / "log", "".join(lines(5 * BLOCK))), size=BLOCK)
    assert len(chunks) > 3
    assert all(len(chunk) <= 2 * BLOCK for chunk in chunks)


OTHERS = [
    "# a comment\n",
    "\n",
    "hello\n",
    "(1.5) can0 123#R\n",
    "(1620807235.135421) can0 09F8017F#R\n",
    "(1620807235.135421) can0 09F8017F##13E17\n",
    "(1620807235.135421) can0 20000004#0000000000000000\n",
    "(1620807235.135421) can0 89F8017F#3E17B322B320590D\n",
    "(1620807235.135421) can0 09F8017F#3E17B322B320590D R\n",
    "(1620807235.135421) can0 09f8017f#3e17b322b320590d\n",
    "(1620807235.135421) can0 09F8017F#3E17B322B320590D\r\n",
    "(1620807235.135421) can0 09F8017F#3E17B322B320590D00\n",
    "(1620807235.135421) can0 09F8017F#3E17B322B320590\n",
    "(1620807235.135421) can0 09F8017F#3E17B322B32059G0\n",
    "(1620807235.135421) can0 09F8017F#3E17B322B32059@0\n",
    "(1620807235.135421) can0 09F8017F#3E17B322B32059:0\n",
    "(1620807235.135421) can0 09F8017F#3E17B322B32059/0\n",
    "(1620807235.135421) can0 09F8017F#3E17B322B32059`0\n",
    "(1620807235.135421) can0 0:F8017F#3E17B322B320590D\n",
    "(1620807235.135421) ca 0 09F8017F#3E17B322B320590D\n",
    "(1620807235.135421) ca\x850 09F8017F#3E17B322B320590D\n",
    "(1620807235.135421) can009F8017F#3E17B322B320590D1\n",
    "(1620807235.13542:) can0 09F8017F#3E17B322B320590D\n",
    "(1620807235.1354/1) can0 09F8017F#3E17B322B320590D\n",
    "(162080723:.135421) can0 09F8017F#3E17B322B320590D\n",
    "(16 0807235.135421) can0 09F8017F#3E17B322B320590D\n",
    "(9920807235.135421) can0 09F8017F#3E17B322B320590D\n",
    " 1620807235.135421) can0 09F8017F#3E17B322B320590D\n",
    "(1620807235.135421( can0 09F8017F#3E17B322B320590D\n",
    "(1620807235 135421) can0 09F8017F#3E17B322B320590D\n",
    "(1620807235.135421)_can0 09F8017F#3E17B322B320590D\n",
    "(1620807235.135421) can0_09F8017F#3E17B322B320590D\n",
    "(1620807235.135421) can0 09F8017F_3E17B322B320590D\n",
    "  can0  09F8017F   [8]  3E 17 B3 22 B3 20 59 0D\n",
    "x" * 5000 + "\n",
]


@pytest.mark.parametrize("other", OTHERS)
def test_a_line_of_another_shape_is_read_in_its_place_as_it_is_alone(tmp_path, other):
    for before in (0, 1, 40):
        same(written(tmp_path / "log", LINE * before + other + LINE * 60 + other + other + LINE * 9))


def test_behind_many_lines_the_others_are_read_all_the_same(tmp_path):
    for text in ("".join(OTHERS), OTHERS[7] * 50, LINE[:-1]):
        same(written(tmp_path / "log", LINE * (2 * BLOCK - 1) + text + LINE * (BLOCK + 1)))


def test_the_last_line_may_lack_its_end_or_be_cut_off(tmp_path):
    for cut in range(1, len(LINE) + 2):
        same(written(tmp_path / "log", LINE * 200 + LINE[:-cut]))


def test_an_empty_log_has_no_frames(tmp_path):
    assert same(written(tmp_path / "log", "")) == []


def test_logs_that_something_went_over_are_read_the_same(tmp_path):
    draw = random.Random(5)
    for _ in range(12):
        log = bytearray("".join(lines(2000, draw.random())).encode())
        for _ in range(draw.choice((1, 20, 400))):
            place = draw.randrange(len(log))
            match draw.randrange(3):
                case 0:
                    log[place] = draw.choice(b"0123456789ABCDEFabcdefG:@`/#() .\n\rR\x00\xff")
                case 1:
                    del log[place : place + draw.randrange(1, 60)]
                case 2:
                    log[place:place] = draw.choice(OTHERS[:-1]).encode("latin-1")
        same(written(tmp_path / "log", bytes(log)), size=draw.choice((1, 500, 1 << 18)))


def test_a_compressed_log_is_read_as_far_as_it_goes(tmp_path):
    packed = gzip.compress("".join(lines(BLOCK)).encode())
    same(written(tmp_path / "whole.gz", packed))
    assert same(written(tmp_path / "torn.gz", packed[: len(packed) // 2]))


def test_a_strict_reader_names_the_line(tmp_path):
    path = written(tmp_path / "log", LINE * 300 + "hello\n" + LINE * 300)
    with pytest.raises(RecordingError, match=r"line 301: .*hello"):
        list(open_frames(path, strict=True))


def test_a_format_without_a_fast_reader_is_read_one_by_one(tmp_path):
    text = "17:33:21.107 R 19F51323 01 2F 30 70 00 2F 30 70\n"
    assert [len(chunk) for chunk in same(written(tmp_path / "log", text * 25), size=10)] == [10, 10, 5]


def packet(number, data, seconds=1620807235, micros=135421, captured=16, length=None, before=b"", order="<"):
    frame = struct.pack(">IB3x", number, len(data) if length is None else length) + data.ljust(8, b"\xaa")
    content = (before + frame)[: len(before) + captured]
    return struct.pack(order + "IIII", seconds, micros, len(content), len(content)) + content


def capture(*packets, link=227, magic=0xA1B2C3D4, order="<"):
    return struct.pack(order + "IHHiIII", magic, 2, 4, 0, 0, 65535, link) + b"".join(packets)


FRAME = packet(0x89F8017F, bytes(range(8)))
ODD = [
    packet(0x89F8017F, b"\x01\x02"),
    packet(0x6C, b"\x01\x02"),
    packet(0x80C, b"\x01\x02"),
    packet(0xC9F8017F, b""),
    packet(0xA0000004, bytes(8)),
    packet(0x89F8017F, bytes(8), length=9),
    packet(0x89F8017F, bytes(8), captured=12),
    packet(0x89F8017F, b"\x01\x02", captured=12),
    packet(0x89F8017F, bytes(8), captured=7),
    packet(0x89F8017F, bytes(64), captured=72),
    packet(0x89F8017F, bytes(8), seconds=0xFFFFFFFF, micros=1_500_000),
    struct.pack("<IIII", 1, 2, 0, 0),
]


@pytest.mark.parametrize("odd", ODD)
def test_packets_of_any_kind_are_read_in_their_place(tmp_path, odd):
    for before in (0, 1, 30, 1000):
        same(written(tmp_path / "log", capture(FRAME * before, odd, FRAME * 100, odd, odd, FRAME)))


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("magic", [0xA1B2C3D4, 0xA1B23C4D])
def test_captures_of_either_order_and_of_nanoseconds_are_read(tmp_path, order, magic):
    frame = packet(0x89F8017F, bytes(range(8)), micros=999_000, order=order)
    same(written(tmp_path / "log", capture(frame * 100, magic=magic, order=order)))


def test_nanoseconds_of_a_capture_are_kept(tmp_path):
    frame = packet(0x89F8017F, bytes(8), micros=123_456_789)
    (frames,) = open_frames(written(tmp_path / "log", capture(frame, magic=0xA1B23C4D)))
    assert frames.stamp.tolist() == [1620807235_123456789]


@pytest.mark.parametrize(("link", "before"), [(113, bytes(14) + b"\x00\x0c"), (276, b"\x00\x0c" + bytes(18))])
def test_cooked_captures_are_read_and_other_protocols_passed_over(tmp_path, link, before):
    frame = packet(0x89F8017F, bytes(8), before=before)
    other = packet(0x89F8017F, bytes(8), before=before.replace(b"\x0c", b"\x08"))
    assert len(same(written(tmp_path / "log", capture(frame * 50, other * 3, frame, link=link)))[0]) == 51


def test_a_capture_may_be_cut_anywhere(tmp_path):
    whole = capture(FRAME * 20)
    for size in (*range(20, 100), len(whole) - 1):
        same(written(tmp_path / "log", whole[:size]))


def test_behind_a_packet_of_an_impossible_size_a_capture_is_lost(tmp_path):
    same(written(tmp_path / "log", capture(FRAME * 50, struct.pack("<IIII", 1, 2, 1 << 30, 16), FRAME * 50)))


def test_chunks_of_a_capture_are_about_as_large_as_asked_for(tmp_path):
    chunks = list(open_frames(written(tmp_path / "log", capture(FRAME * 100_000)), size=30_000))
    assert [30_000 <= len(chunk) < 70_000 for chunk in chunks] == [True] * (len(chunks) - 1) + [False]
    assert np.concatenate([chunk.identifier for chunk in chunks]).tolist() == [0x89F8017F] * 100_000


def test_our_own_recordings_are_read_whole_and_torn(tmp_path):
    recording(tmp_path / "run.mcap")
    data = (tmp_path / "run.mcap").read_bytes()
    assert len(same(tmp_path / "run.mcap")[0]) == 27
    for end in range(9, len(data), 97):
        same(written(tmp_path / "torn.mcap", data[:end]))


BUS_AT = 3
ROWS = flight_bus.ROW.pack(HEADING.identifier | flight_bus.EXTENDED, 8, 0, 0, b"12345678", 250, 7)
ONE, TWO = (b"\0\1\0\0" + bytes((count, 0, 0, 0)) for count in (1, 2))
PACKED = flight_bus.PACKED.pack(HEADING.identifier | flight_bus.EXTENDED, b"12345678", 250, 7, 8, 0)
COLUMNS = flight_bus.message_of(PACKED * 3)
BUS = flight.RECORD.pack(flight.CHANNEL, 15) + b"\3\0\0\0\3\0\0\0bus" + bytes(4)


def message(content, channel=BUS_AT, stamp=1_700_000_000_000_000_000, opcode=flight.MESSAGE):
    """A record of a chunk."""
    return flight.MESSAGE_HEAD.pack(opcode, 22 + len(content), channel, 1, stamp, stamp) + content


def packed(identifier=HEADING.identifier, data=b"12345678", length=8, flags=0):
    """A message of two frames in columns, the second of which is odd."""
    return message(flight_bus.message_of(PACKED + flight_bus.PACKED.pack(identifier, data, 1, 1, length, flags)))


ODD_RECORDS = {
    "of another channel": message(b"{}", channel=4),
    "of no known kind": message(ONE + ROWS, opcode=0x77),
    "with a row and a half": message(TWO + ROWS + ROWS[:12]),
    "with more rows than it says": message(ONE + ROWS + ROWS),
    "without even its number of rows": message(bytes(5)),
    "without a row": message(bytes(8)),
    "without a frame": message(flight_bus.message_of(b"")),
    "with columns that are cut off": message(COLUMNS[:-1]),
    "with bytes behind its columns": message(COLUMNS + b"\0"),
    "with a column that is too short": message(COLUMNS[:20] + b"\x17" + COLUMNS[21:]),
    "with more columns than there could be": message(b"\0\1\0\0\xff\xff\xff\xff" + bytes(60)),
    "from a time beyond all clocks": message(ONE + ROWS, stamp=1 << 62),
    "from a year before that": message(ONE + ROWS, stamp=4_580_000_000_000_000_000),
    "with a row that goes on": message(TWO + ROWS + ROWS[:5] + bytes((flight_bus.CONTINUED,)) + ROWS[6:]),
    "with a frame that goes on": packed(flags=flight_bus.CONTINUED),
    "with a length that no row has": message(ONE + ROWS[:4] + b"\x09" + ROWS[5:]),
    "with a length that no frame has": packed(length=9),
    "with bytes behind a row's data": message(ONE + ROWS[:4] + b"\x03" + ROWS[5:]),
    "with bytes behind its data": packed(length=3),
    "with a frame of eleven bits": packed(identifier=0x123),
    "a second channel of that name": BUS[:9] + b"\5" + BUS[10:] + message(ONE + ROWS, channel=5),
    "too short for a message": flight.RECORD.pack(flight.MESSAGE, 21) + bytes(21),
    "cut off": message(ONE + ROWS)[:-1],
    "a size beyond everything": flight.RECORD.pack(flight.MESSAGE, (1 << 64) - 1) + bytes(40),
}


@pytest.mark.parametrize("odd", ODD_RECORDS.values(), ids=ODD_RECORDS)
def test_records_of_every_kind_between_those_of_the_bus(tmp_path, odd):
    sound = message(TWO + ROWS + ROWS) + message(COLUMNS)
    chunk = BUS + sound + sound + odd + sound
    content = struct.pack("<QQQII", 0, 0, len(chunk), 0, 0) + struct.pack("<Q", len(chunk)) + chunk
    record = flight.RECORD.pack(flight.CHUNK, len(content)) + content
    frames = concatenate(same(written(tmp_path / "log.mcap", flight.MAGIC + record + record)))
    assert len(frames) >= 10


def test_frames_of_our_own_recordings_that_are_longer_than_a_row_stay_whole_and_in_place(tmp_path):
    tape = Tape(["Bridge"], OFFSET)
    for frames in ([HEADING, SHORT], [SHORT, LONG, HEADING], [HEADING]):
        tape.step += 1
        tape.frames(frames, tape.step * 500_000)
    segment = SegmentFile(tmp_path / "run.mcap", METADATA)
    segment.write(tape.take())
    segment.finish()
    (frames,) = same(tmp_path / "run.mcap")
    assert [frame.data for frame in frames.logframes()] == [
        *(HEADING.data, SHORT.data),
        *(SHORT.data, LONG.data, HEADING.data),
        HEADING.data,
    ]
