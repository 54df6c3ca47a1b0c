"""A bus that is written in each format is read back as it was, and damage costs no more than what it hits."""

import can
import pytest

from tests.recordings import recording
from tests.unit.recording import writers
from timonel.nmea2000.fastpacket import Reassembler
from timonel.nmea2000.identifier import split
from timonel.nmea2000.registry import is_fast
from timonel.recording import LogFrame, open_any, open_log
from timonel.vehicles.rover.frames import FRAMES as ROVER

BUS = "aldas_go-nmea-client/socketcan/testdata/candump-2021-05-12_091355.log"
DAY, EXACTLY, MILLISECOND = 86400.0, 1e-6, 0.00051


@pytest.fixture(scope="module")
def frames():
    return list(open_log(recording(BUS)))


@pytest.fixture(scope="module")
def messages(frames):
    reassembler = Reassembler()
    whole = []
    for frame in frames:
        if not is_fast(split(frame.identifier).pgn):
            whole.append(frame)
        elif (data := reassembler.receive(frame.identifier, frame.data, frame.stamp)) is not None:
            whole.append(LogFrame(frame.stamp, frame.identifier, data, True, True))
    return whole


def python_can(writer, suffix):
    return lambda tmp_path, frames: writers.with_python_can(writer, tmp_path / f"written{suffix}", frames)


def plain(write, *settings):
    return lambda _, frames: write(frames, *settings)


# What writes frames, the format that is then recognised, what the times are: None for none, else what they count
# from and how exactly.
FRAMES = {
    "candump -L": (plain(writers.candump), "candump", ("epoch", EXACTLY)),
    "candump": (plain(writers.candump_printed), "candump", None),
    "YD RAW": (plain(writers.yd_raw), "YD RAW", ("day", 2 * MILLISECOND)),
    "TRC 1.1": (plain(writers.trc_11), "PEAK TRC", ("epoch", MILLISECOND)),
    "TRC 2.1": (python_can(can.TRCWriter, ".trc"), "PEAK TRC", ("epoch", MILLISECOND)),
    "ASC": (python_can(can.ASCWriter, ".asc"), "Vector ASC", ("start", EXACTLY)),
    "BLF": (python_can(can.BLFWriter, ".blf"), "Vector BLF", ("epoch", EXACTLY)),
    "pcap": (plain(writers.pcap), "pcap", ("epoch", EXACTLY)),
    "pcap, big-endian, ns": (plain(writers.pcap, ">", True), "pcap", ("epoch", EXACTLY)),
    "pcap, cooked": (plain(writers.pcap, "<", False, 113), "pcap", ("epoch", EXACTLY)),
    "pcap, cooked v2": (plain(writers.pcap, "<", False, 276), "pcap", ("epoch", EXACTLY)),
    "pcapng": (plain(writers.pcapng), "pcapng", ("epoch", EXACTLY)),
    "pcapng, big-endian, cooked, ns": (plain(writers.pcapng, ">", 113, 9), "pcapng", ("epoch", EXACTLY)),
    "BST 95": (plain(writers.ngt1_frames), "Actisense NGT-1", ("start", 2 * MILLISECOND)),
    "EBL of BST 95": (plain(writers.ebl_frames), "Actisense EBL", ("epoch", EXACTLY)),
}
MESSAGES = {
    "canboat FAST": (plain(writers.canboat), "canboat", ("epoch", 2 * MILLISECOND)),
    "N2K ASCII": (plain(writers.actisense_ascii), "Actisense N2K ASCII", ("day", 2 * MILLISECOND)),
    "iKonvert": (plain(writers.ikonvert), "iKonvert", ("start", 2 * MILLISECOND)),
    "Garmin CSV": (plain(writers.garmin), "Garmin CSV", ("start", 2 * MILLISECOND)),
    "BST 93": (plain(writers.ngt1), "Actisense NGT-1", ("start", 2 * MILLISECOND)),
    "BST D0": (plain(writers.ngt1_d0), "Actisense NGT-1", ("start", 2 * MILLISECOND)),
    "EBL of BST 93": (plain(writers.ebl), "Actisense EBL", ("epoch", EXACTLY)),
}
DATED = ("epoch",)


def contents(read):
    return [(frame.identifier, frame.data, frame.extended, frame.whole) for frame in read]


def times(read, count):
    """Stamps as far as the format can tell them."""
    origin = {"epoch": 0.0, "day": read[0].stamp // DAY * DAY, "start": read[0].stamp}[count]
    return [frame.stamp - origin for frame in read]


@pytest.mark.parametrize("case", [*FRAMES, *MESSAGES])
def test_what_is_written_is_read_back(case, frames, messages, tmp_path):
    written = frames if case in FRAMES else messages
    write, name, time = (FRAMES | MESSAGES)[case]
    path = tmp_path / "log"
    path.write_bytes(write(tmp_path, written))
    log = open_log(path)
    assert (log.format, log.kind, log.timed) == (name, "frames", time is not None)
    read = list(log)
    assert contents(read) == contents(written)
    assert (log.frames, log.unreadable, log.bytes_read) == (len(written), [], log.size)
    if time is None:
        assert {frame.stamp for frame in read} == {None}
    else:
        count, precision = time
        assert times(read, count) == pytest.approx(times(written, count), abs=precision, rel=0)


def test_whether_times_have_a_date_is_told(frames, messages, tmp_path):
    for case, (write, _, time) in (FRAMES | MESSAGES).items():
        path = tmp_path / "log"
        path.write_bytes(write(tmp_path, frames if case in FRAMES else messages))
        with open_log(path) as log:
            dated = case == "ASC" or (time is not None and time[0] == "epoch")
            assert log.dated is dated, case


@pytest.mark.parametrize("pack", [writers.gzipped, writers.zstd])
@pytest.mark.parametrize("case", ["candump -L", "pcap", "BST 95", "BLF"])
def test_what_is_compressed_is_read_all_the_same(case, pack, frames, tmp_path):
    write, name, _ = FRAMES[case]
    path = tmp_path / "log"
    path.write_bytes(pack(write(tmp_path, frames)))
    log = open_log(path)
    assert log.format == name
    assert contents(log) == contents(frames)
    assert (log.unreadable, log.bytes_read) == ([], log.size)


@pytest.mark.parametrize("case", [*FRAMES, *MESSAGES])
def test_a_file_cut_anywhere_gives_what_stands_before_the_cut(case, frames, messages, tmp_path):
    written = (frames if case in FRAMES else messages)[:12]
    data = (FRAMES | MESSAGES)[case][0](tmp_path, written)
    whole = contents(written)
    found = []
    path = tmp_path / "log"
    for end in range(len(data) // 3, len(data)):  # in less there is not enough to tell some formats by
        path.write_bytes(data[:end])
        with open_log(path) as log:
            read = contents(log)
        assert read == whole[: len(read)], end
        assert log.unreadable_count <= 2, log.unreadable
        found.append(len(read))
    assert found == sorted(found)
    assert found[0] < 8
    assert found[-1] >= 11 or case == "BLF"  # its end is that of the one container


LINES_AND_CHECK_SUMS = [case for case in (*FRAMES, *MESSAGES) if not case.startswith(("pcap", "BLF"))]


@pytest.mark.parametrize("case", LINES_AND_CHECK_SUMS)
def test_a_few_bytes_of_damage_cost_a_frame_or_two(case, frames, messages, tmp_path):
    written = frames if case in FRAMES else messages
    data = bytearray((FRAMES | MESSAGES)[case][0](tmp_path, written))
    middle = len(data) // 2
    data[middle : middle + 3] = b"\xff\x00?"
    path = tmp_path / "log"
    path.write_bytes(data)
    log = open_log(path)
    read = contents(log)
    assert log.unreadable_count in (1, 2)
    assert len(written) - len(read) in (1, 2)
    assert all(any(frame == other for other in contents(written)) for frame in read[-20:])


@pytest.mark.parametrize("dialect", ["strzyga", "strzyga-crc", "hal062"])
def test_a_rovers_serial_line_is_read_in_its_framing(dialect, tmp_path):
    size = 8 if dialect == "hal062" else 255
    written = [
        LogFrame(None, frame.FRAME, bytes(range(1, frame.size + 1)), extended=False)
        for frame in ROVER
        if frame.size <= size
    ]
    path = tmp_path / "log"
    path.write_bytes(b"\x00\x7f" + writers.uart(dialect, written * 20))
    log = open_any(path)
    assert (log.kind, log.format, log.timed, log.dated) == ("uart", f"UART {dialect}", False, False)
    assert list(log) == written * 20
    assert [(found.place, found.text) for found in log.unreadable] == [("byte 0", log.unreadable[0].text)]


def test_frames_of_eleven_bits_keep_their_identifiers(tmp_path):
    written = [LogFrame(1.6e9 + number, 100 + number, bytes(number), extended=False) for number in range(9)]
    for name, data in {
        "pcap": writers.pcap(written),
        "Vector BLF": writers.with_python_can(can.BLFWriter, tmp_path / "a.blf", written),
        "Vector ASC": writers.with_python_can(can.ASCWriter, tmp_path / "a.asc", written),
        "PEAK TRC": writers.with_python_can(can.TRCWriter, tmp_path / "a.trc", written),
    }.items():
        path = tmp_path / "log"
        path.write_bytes(data)
        log = open_log(path)
        assert log.format == name
        assert contents(log) == contents(written)
