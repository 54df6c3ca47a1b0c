"""Vector's BLF, written by python-can and damaged by hand."""

import struct
import zlib

import can
import pytest

from tests.unit.recording.writers import with_python_can
from timonel.recording import LogFrame, Unreadable
from timonel.recording.blf import Blf

FRAMES = [LogFrame(1.6e9 + number / 64, 0x09F80100 + number, bytes((number,)) * 8) for number in range(100)]
HEADER = b"LOGG" + struct.pack("<I", 144) + bytes(136)


def read(*pieces):
    reader = Blf(b"".join(pieces))
    found = [each for piece in pieces for each in reader.receive(piece)]
    return [*found, *reader.finish()]


def frames(results):
    return [each for each in results if isinstance(each, LogFrame)]


def told(results):
    return [(each.place, each.reason) for each in results if isinstance(each, Unreadable)]


def lobj(kind, content, size=None):
    return struct.pack("<4sHHII", b"LOBJ", 32, 1, size or 16 + len(content), kind) + content


def message(identifier=0x89F80100, flags=0, length=8, unit=2, ticks=10):
    head = struct.pack("<IHHQ", unit, 0, 0, ticks)
    return lobj(1, head + struct.pack("<HBBI8s", 1, flags, length, identifier, bytes(range(8))))


def container(data, method=2):
    packed = zlib.compress(data) if method == 2 else data
    whole = lobj(10, struct.pack("<H6xI4x", method, len(data)) + packed)
    return whole + bytes(len(whole) % 4)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    return with_python_can(can.BLFWriter, tmp_path_factory.mktemp("blf") / "a.blf", FRAMES)


def test_what_python_can_writes_is_read(written):
    assert read(written) == FRAMES
    assert read(*(written[n : n + 7] for n in range(0, len(written), 7))) == FRAMES
    assert Blf(written).dated


def test_times_without_a_start_count_from_the_epoch_in_either_unit():
    data = HEADER + container(message(ticks=1_500_000_000) + message(unit=1, ticks=250_000))
    assert [frame.stamp for frame in read(data)] == [1.5, 2.5]
    assert not Blf(data).dated


def test_objects_go_on_from_one_container_to_the_next_and_may_stand_in_none():
    data = message() + message()
    assert len(read(HEADER + container(data[:60]) + container(data[60:], method=0) + message())) == 3


def test_remote_requests_and_other_objects_are_passed_over():
    assert read(HEADER + container(message(flags=0x80) + lobj(73, bytes(48)) + lobj(96, bytes(64)))) == []


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (message(length=9), "not a classic CAN frame"),
        (message(identifier=0x800), "not a classic CAN frame"),
        (lobj(100, bytes(100)), "not a classic CAN frame"),
        (lobj(10, struct.pack("<H6xI4x", 2, 99) + b"nonsense"), "a container that is damaged: Error -3 while "
         "decompressing data: incorrect header check"),
        (lobj(10, struct.pack("<H6xI4x", 7, 99) + b"nonsense"), "a container of unknown compression 7"),
        (lobj(1, bytes(16), size=16), "unpack_from requires a buffer of at least 32 bytes for unpacking 16 bytes at "
         "offset 16 (actual buffer size is 16)"),
        (b"LOBJ" + bytes(40), "44 bytes of nothing that is known"),
    ],
)  # fmt: skip
def test_an_object_that_is_not_well_formed_is_told_and_the_next_is_read(data, reason):
    results = read(HEADER + data + message())
    assert len(frames(results)) == 1
    assert told(results)[0] == ("byte 144", reason)


def test_damage_inside_a_container_is_told_with_the_containers_offset():
    results = read(HEADER + container(message() + b"noise" + message()))
    assert len(frames(results)) == 2
    assert told(results) == [("byte 144", "5 bytes of nothing that is known")]


def test_an_object_without_a_size_does_not_send_the_reader_round_in_circles():
    endless = struct.pack("<4sHHII", b"LOBJ", 32, 1, 0, 999) + bytes(16)
    results = read(HEADER + container(endless, method=0) + message())
    assert len(frames(results)) == 1


def test_a_container_that_is_cut_gives_the_frames_before_the_cut(written):
    for end in range(len(written) - 200, len(written), 10):
        results = read(written[:end])
        found = frames(results)
        assert 0 < len(found) < 100
        assert found == FRAMES[: len(found)]
        assert told(results) == [("byte 144", "cut off")]


def test_the_header_alone_is_a_recording_without_frames():
    for end in range(4, 145):
        assert frames(read(HEADER[:end])) == []
