"""Compressed recordings: whole, in several members, cut and damaged."""

import subprocess
import sys
import tracemalloc

import pytest

from tests.unit.recording.writers import gzipped, zstd
from timonel.errors import RecordingError
from timonel.recording import open_log

LINES = "".join(f"({1.6e9 + n:.6f}) can0 09F8017F#{n:016X}\n" for n in range(20_000)).encode()
PACKERS = pytest.mark.parametrize("pack", [gzipped, zstd])


@pytest.fixture
def log(tmp_path):
    def write(data):
        (tmp_path / "log").write_bytes(data)
        return open_log(tmp_path / "log")

    return write


@PACKERS
def test_members_behind_one_another_are_one_recording(pack, log):
    reader = log(pack(LINES[:500]) + pack(LINES[500:]))
    assert [frame.data for frame in reader] == [n.to_bytes(8, "big") for n in range(20_000)]
    assert (reader.unreadable, reader.bytes_read) == ([], reader.size)


@PACKERS
def test_a_compressed_file_that_is_cut_gives_what_stands_before(pack, log):
    packed = pack(LINES)
    reader = log(packed[: len(packed) // 2])
    found = [int.from_bytes(frame.data, "big") for frame in reader]
    assert 1000 < len(found) < 20_000
    assert found == list(range(len(found)))
    assert reader.unreadable[-1].reason == "the compressed file is cut off"


@PACKERS
def test_a_compressed_file_that_is_damaged_gives_what_stands_before(pack, log):
    packed = bytearray(pack(LINES[:100_000]) + pack(LINES[100_000:]))
    packed[-600:-500] = bytes(100)
    reader = log(bytes(packed))
    assert sum(1 for _ in reader) > 1000
    assert reader.unreadable[-1].reason.startswith("the compressed file is damaged: ")


@PACKERS
def test_strict_reading_stops_where_a_compressed_file_is_cut(pack, tmp_path):
    packed = pack(LINES)
    (tmp_path / "log").write_bytes(packed[:-20])
    with pytest.raises(RecordingError, match=r"log, (byte|line) "):
        list(open_log(tmp_path / "log", strict=True))


def test_the_padding_of_a_tape_behind_gzip_is_nothing(log):
    reader = log(gzipped(LINES[:510]) + bytes(512))
    assert sum(1 for _ in reader) == 10
    assert reader.unreadable == []


def test_a_few_bytes_that_stand_for_very_many_do_not_fill_the_memory(log):
    packed = zstd(LINES[:51] + b"# " + b"x" * 100_000_000 + b"\n" + LINES[51:102])
    tracemalloc.start()
    reader = log(packed)
    assert reader.size < 20_000
    assert sum(1 for _ in reader) == 2
    assert tracemalloc.get_traced_memory()[1] < 64_000_000
    tracemalloc.stop()


def test_zstd_without_its_package_names_the_extra(tmp_path):
    (tmp_path / "log").write_bytes(zstd(LINES))
    program = (
        "import sys\n"
        "sys.modules['zstandard'] = None\n"
        "from timonel.errors import RecordingError\n"
        "from timonel.recording import open_log\n"
        "try: open_log(sys.argv[1])\n"
        "except RecordingError as error: print(error)\n"
    )
    said = subprocess.run([sys.executable, "-c", program, tmp_path / "log"], capture_output=True, text=True, check=True)
    assert said.stdout.endswith("log: zstd: needs the extra `recording` (pip install 'timonel[recording]')\n")
