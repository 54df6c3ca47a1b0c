"""Opening a recording: the format is told from the content, and no line is fatal unless that was asked for."""

import json
import subprocess
import sys

import pytest

from tests.recordings import vectors
from tests.unit.recording.writers import bdtp, bst, pcap
from timonel.core.frame import Frame
from timonel.errors import RecordingError
from timonel.recording import LogFrame, Unreadable, open_any, open_log

LOGGED = "(1620807235.135421) can0 09F8017F#3E17B322B320590D\n"
PRINTED = "  can0  09F8017F   [8]  3E 17 B3 22 B3 20 59 0D\n"
RAW = "17:33:21.107 R 09F8017F 3E 17 B3 22 B3 20 59 0D\n"
PLAIN = "2021-05-12T08:13:55.135Z,2,129025,127,255,8,3e,17,b3,22,b3,20,59,0d\n"


@pytest.fixture
def log(tmp_path):
    def write(text):
        path = tmp_path / "log"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


@pytest.mark.parametrize(
    ("text", "name"), [(LOGGED, "candump"), (PRINTED, "candump"), (RAW, "YD RAW"), (PLAIN, "canboat")]
)
@pytest.mark.parametrize("before", ["", "# a comment\n\n", "half a line of someth\n"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_the_format_is_told_from_the_content(log, text, name, before, end):
    with open_log(log((before + text * 2).replace("\n", end))) as reader:
        frames = list(reader)
    assert reader.format == name
    assert [(frame.identifier, frame.data.hex()) for frame in frames] == [(0x09F8017F, "3e17b322b320590d")] * 2
    assert reader.unreadable_count == before.startswith("half")


def test_a_line_that_cannot_be_read_is_kept_with_its_number_and_reason(log):
    reader = open_log(log("# note\n" + LOGGED + "(oops\n" + LOGGED))
    assert len(list(reader)) == 2
    assert reader.frames == 2
    assert [(u.line, u.text, u.reason) for u in reader.unreadable] == [(3, "(oops", "neither a comment nor a frame")]


def test_strict_reading_stops_at_the_line_and_names_it(log):
    path = log(LOGGED + "(oops\n")
    reader = open_log(path, strict=True)
    with pytest.raises(RecordingError) as error:
        list(reader)
    assert str(error.value) == f"{path}, line 2: neither a comment nor a frame: '(oops'"


def test_all_bad_lines_are_counted_and_a_hundred_kept(log):
    reader = open_log(log(LOGGED + "?\n" * 150))
    list(reader)
    assert reader.unreadable_count == 150
    assert len(reader.unreadable) == 100


def test_the_last_line_may_lack_its_end(log):
    assert len(list(open_log(log(LOGGED + LOGGED.rstrip())))) == 2


def test_an_empty_recording_has_no_frames(log):
    assert list(open_log(log(""))) == []
    assert list(open_log(log("# nothing happened\n"))) == []


def test_progress_ends_at_the_size_of_the_file(log):
    path = log(LOGGED * 5000)
    reader = open_log(path)
    assert reader.size == path.stat().st_size
    frames = iter(reader)
    next(frames)
    assert 0 < reader.bytes_read < reader.size
    assert sum(1 for _ in frames) == 4999
    assert reader.bytes_read == reader.size


def test_lines_that_lie_across_two_chunks_are_read_whole(log):
    frames = list(open_log(log("".join(f"({i}.0) can0 09F8017F#{i % 256:02X}\n" for i in range(5000)))))
    assert [(frame.stamp, frame.data[0]) for frame in frames] == [(i, i % 256) for i in range(5000)]


def test_a_line_without_end_does_not_fill_the_memory(log):
    reader = open_log(log(LOGGED.encode() + b"\x00" * 1_000_000))
    assert len(list(reader)) == 1
    assert max(len(u.text) for u in reader.unreadable) <= 100


def test_a_file_of_no_known_format_is_refused_with_its_first_line(log):
    path = log("$IIHDT,45.0,T*10\n")
    with pytest.raises(RecordingError, match=r"no log format known here has lines such as '\$IIHDT"):
        open_log(path)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(RecordingError, match=r"nowhere\.log: No such file or directory"):
        open_log(tmp_path / "nowhere.log")


def test_a_folder_is_refused_by_name(tmp_path):
    with pytest.raises(RecordingError, match="Is a directory"):
        open_log(tmp_path)


def test_a_pipe_is_read_as_it_comes_and_has_no_size():
    program = (
        "from timonel.recording import open_log\n"
        "reader = open_log('-')\n"
        "print(reader.name, reader.size, reader.format)\n"
        "for frame in reader: print(frame.identifier, flush=True)\n"
    )
    reading = subprocess.Popen(
        [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert reading.stdin is not None
    assert reading.stdout is not None
    with reading, reading.stdin, reading.stdout:
        for _ in range(2):
            reading.stdin.write(LOGGED)
            reading.stdin.flush()
        assert reading.stdout.readline() == "standard input None candump\n"
        assert [reading.stdout.readline() for _ in range(2)] == [f"{0x09F8017F}\n"] * 2
        reading.stdin.close()
        assert reading.wait() == 0


def test_a_line_gives_a_frame():
    assert LogFrame(1.0, 0x6C, b"\x01", extended=False).frame == Frame(0x6C, b"\x01", extended=False)


def test_strict_reading_of_bytes_names_their_offset(log):
    good = LogFrame(1.0, 0x09F8017F, b"\1")
    path = log(pcap([good]) + pcap([good], link=113)[24:])
    with pytest.raises(RecordingError, match=r"log, byte 56: not a classic CAN frame: '01 00"):
        list(open_log(path, strict=True))
    assert Unreadable(3, "", "").place == "line 3"


@pytest.mark.parametrize(
    ("text", "name"),
    [
        (";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n", "PEAK TRC"),
        ("date Wed Sep 28 10:23:45.123 pm 2016\nbase hex  timestamps absolute\n", "Vector ASC"),
    ],
)
def test_headings_without_a_frame_are_a_recording(log, text, name):
    reader = open_log(log(text))
    assert (list(reader), reader.format, reader.unreadable) == ([], name, [])


def test_a_byte_order_mark_is_no_part_of_the_first_line(log):
    reader = open_log(log(b"\xef\xbb\xbf" + LOGGED.encode()))
    assert (len(list(reader)), reader.unreadable) == (1, [])


@pytest.mark.parametrize(
    "line",
    [
        "(1620807235.135421) can0 09F8017F#3E17B3",
        "17:33:21.107 R 09F8017F 3E 17 B3",
        "A173321.107 23FF7 1F513 012F3070002F3070",
        "!PDGY,127250,2,3,255,481.734,2C20AAAA",
        "2021-05-12T08:13:55.135Z,2,129025,127,255,8,3e,17,b3,22,b3,20,59,0",
    ],
)
def test_a_last_line_that_may_be_cut_in_its_data_is_not_guessed_at(log, line):
    reader = open_log(log(line + "\n" + line))
    assert len(list(reader)) == 1
    assert [(found.line, found.reason) for found in reader.unreadable] == [(2, "the last line may be cut off")]


def test_whether_there_are_times_and_dates_is_told(log):
    cases = ((LOGGED, True, True), ("(0.25) can0 09F8017F#3E\n", True, False), (PRINTED, False, False))
    for text, timed, dated in (*cases, (RAW, True, False), (PLAIN, True, True)):
        with open_log(log(text)) as reader:
            assert (reader.timed, reader.dated) == (timed, dated), text


def test_bytes_that_are_of_no_format_are_refused(log):
    with pytest.raises(RecordingError, match="no log format known here"):
        open_any(log(bytes(range(256)) * 40))
    with pytest.raises(RecordingError, match="no log format known here"):
        open_any(log(bdtp(bst(0x93, bytes(20)))[:-2]))


@pytest.mark.parametrize("number", range(3))
def test_a_serial_line_of_the_rover_as_the_specification_has_it_is_known(log, number):
    case = json.loads(vectors("rover_uart.jsonl").read_text().splitlines()[number])
    reader = open_log(log(bytes.fromhex(case["stream"])))
    assert reader.kind == "uart"
    assert [(frame.identifier, frame.data.hex()) for frame in reader] == [
        (frame["id"], frame["data"].lower()) for frame in case["frames"]
    ]
