"""pcap and pcapng, written by hand."""

import struct

import pytest

from tests.unit.recording.writers import block, can_frame, pcap, pcapng
from timonel.errors import RecordingError
from timonel.recording import LogFrame, Unreadable, open_log
from timonel.recording.pcap import Pcap, PcapNg

FRAME = LogFrame(1.6e9 + 0.25, 0x09F8017F, bytes.fromhex("E715B322C318590D"))


def read(form, data):
    reader = form(data)
    return [*reader.receive(data), *reader.finish()]


def told(results):
    return [(each.place, each.reason) for each in results if isinstance(each, Unreadable)]


def packet(content, seconds=1):
    return struct.pack("<IIII", seconds, 0, len(content), len(content)) + content


def can(identifier, length=8, content=bytes(8)):
    return struct.pack(">IB3x", identifier, length) + content


def test_remote_requests_and_error_frames_are_passed_over():
    assert read(Pcap, pcap([]) + packet(can(0xC9F8017F)) + packet(can(0x20000004))) == []


def test_what_stands_in_the_reserved_bytes_means_nothing():
    dirty = struct.pack(">IB", 0x89F8017F, 1) + b"\x2e\x92\x04" + b"\x07" + bytes(7)
    assert read(Pcap, pcap([]) + packet(dirty)) == [LogFrame(1.0, 0x09F8017F, b"\x07")]


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (can(0x89F8017F, 12, bytes(64)), "not a classic CAN frame"),
        (can(0x89F8017F, 8, bytes(64)), "not a classic CAN frame"),
        (can(0x00001800), "not a classic CAN frame"),
        (can(0x89F8017F, 8, bytes(5)), "8 bytes announced, 5 captured"),
        (b"\x89\xf8", "unpack_from requires a buffer of at least 8 bytes for unpacking 8 bytes at offset 0 (actual "
                      "buffer size is 2)"),
    ],
)  # fmt: skip
def test_a_packet_that_is_no_frame_is_told_with_its_offset(content, reason):
    results = read(Pcap, pcap([FRAME]) + packet(content) + pcap([FRAME])[24:])
    assert [each for each in results if isinstance(each, LogFrame)] == [FRAME] * 2
    assert told(results) == [("byte 56", reason)]


def test_packets_of_other_protocols_are_passed_over():
    other = b"\0\0\0\x01" + bytes(10) + b"\x08\0" + bytes(40)
    assert read(Pcap, pcap([], link=113) + packet(other) + pcap([FRAME], link=113)[24:]) == [FRAME]


def test_behind_a_packet_of_an_impossible_size_nothing_is_read():
    results = read(Pcap, pcap([FRAME]) + struct.pack("<IIII", 1, 0, 1 << 20, 1 << 20) + pcap([FRAME])[24:])
    assert results[0] == FRAME
    assert told(results) == [("byte 56", "48 bytes of nothing that is known")]


def test_a_capture_of_another_link_is_refused(tmp_path):
    path = tmp_path / "ethernet.pcap"
    path.write_bytes(pcap([])[:20] + struct.pack("<I", 1))
    with pytest.raises(RecordingError, match=r"ethernet\.pcap: pcap of link type 1: CAN has 227, 113, 276"):
        open_log(path)


def test_a_capture_that_ends_in_its_header_has_no_frames(tmp_path):
    path = tmp_path / "log"
    for end in range(4, 25):
        path.write_bytes(pcap([])[:end])
        assert list(open_log(path)) == []


def section(order="<"):
    return block(order, 0x0A0D0D0A, struct.pack(order + "IHHq", 0x1A2B3C4D, 1, 0, -1))


def interface(link, options=b""):
    return block("<", 1, struct.pack("<HHI", link, 0, 0) + options)


def enhanced(number, content, ticks=0):
    return block("<", 6, struct.pack("<IIIII", number, ticks >> 32, ticks & 0xFFFFFFFF, len(content), 16) + content)


def test_interfaces_have_their_own_resolution_and_offset():
    binary = struct.pack("<HHB3xHH", 9, 1, 128 | 10, 0, 0)
    later = struct.pack("<HHqHHB3x", 14, 8, 1_600_000_000, 9, 1, 3)
    data = section() + interface(227, binary) + interface(227, later)
    data += enhanced(0, can_frame(FRAME), 1536) + enhanced(1, can_frame(FRAME), 250)
    assert [frame.stamp for frame in read(PcapNg, data)] == [1.5, 1.6e9 + 0.25]


def test_a_new_section_has_interfaces_of_its_own_and_may_have_another_byte_order():
    assert read(PcapNg, pcapng([FRAME]) + pcapng([FRAME], ">")) == [FRAME] * 2


def test_simple_and_old_packets_are_read():
    simple = block("<", 3, struct.pack("<I", 16) + can_frame(FRAME))
    old = block("<", 2, struct.pack("<HHIIII", 0, 0, 0, 2_000_000, 16, 16) + can_frame(FRAME))
    frames = read(PcapNg, section() + interface(227) + simple + old)
    assert [(frame.stamp, frame.data) for frame in frames] == [(None, FRAME.data), (2.0, FRAME.data)]


def test_packets_of_interfaces_that_are_not_of_can_are_passed_over():
    data = section() + interface(1) + interface(227) + enhanced(0, bytes(60)) + enhanced(1, can_frame(FRAME))
    assert [frame.data for frame in read(PcapNg, data)] == [FRAME.data]
    assert told(read(PcapNg, section() + interface(1) + enhanced(0, bytes(60)))) == [
        ("byte 0", "no interface of CAN, but of link type 1")
    ]


def test_a_block_that_is_not_well_formed_is_told_and_the_next_is_read():
    good = enhanced(0, can_frame(FRAME))
    twisted = good[:-4] + b"\x10\0\0\0"
    results = read(PcapNg, section() + interface(227) + twisted + enhanced(7, can_frame(FRAME)) + good)
    assert [each.data for each in results if isinstance(each, LogFrame)] == [FRAME.data]
    assert told(results) == [
        ("byte 48", "a block whose two sizes differ"),
        ("byte 96", "a packet of interface 7, which was not described"),
    ]


def test_blocks_of_other_kinds_are_passed_over():
    assert read(PcapNg, section() + interface(227) + block("<", 4, bytes(8)) + block("<", 5, bytes(12))) == []
