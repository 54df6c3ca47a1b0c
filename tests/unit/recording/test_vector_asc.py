"""Vector's ASC, and python-can beside it."""

import can
import pytest

from timonel.recording import LogFrame
from timonel.recording.vector_asc import VectorAsc

HEAD = """date Wed Sep 28 10:23:45.123 pm 2016
base hex  timestamps absolute
internal events logged
// version 8.2.1
Begin Triggerblock Wed Sep 28 10:23:45.123 pm 2016
   0.000000 Start of measurement
"""
FRAME = (
    "   0.015991 1  18EBFF00x       Rx   d 8 01 A0 0F A6 60 3B D1 40  Length = 273910 BitCount = 141 ID = 418119424x"
)
DATA = bytes.fromhex("01A00FA6603BD140")
BEGAN = 1475101425.123


def read(text):
    lines = text.splitlines()
    reader = VectorAsc(lines)
    return [frame for line in lines if (frame := reader.read(line)) is not None]


def test_a_frame_has_time_identifier_and_data():
    (frame,) = read(HEAD + FRAME)
    assert frame == LogFrame(pytest.approx(BEGAN + 0.015991), 0x18EBFF00, DATA)
    assert VectorAsc(HEAD.splitlines()).dated


def test_without_a_date_times_count_from_the_epoch():
    assert read("base hex  timestamps absolute\n" + FRAME) == [LogFrame(0.015991, 0x18EBFF00, DATA)]
    assert not VectorAsc([FRAME]).dated


def test_an_identifier_without_x_is_a_standard_frame_and_numbers_may_be_decimal():
    assert read("base dec  timestamps absolute\n 1.5 1 100 Tx d 2 10 255") == [LogFrame(1.5, 100, b"\n\xff", False)]


def test_relative_times_count_from_the_line_before():
    frames = read("base hex  timestamps relative\n 1.5 1 64 Rx d 0\n 0.25 1 Statistic: D 1\n 0.25 1 64 Rx d 1 07")
    assert [frame.stamp for frame in frames] == [1.5, 2.0]


def test_a_german_date_is_a_date():
    frames = read("date Mit Mär 2 14:05:06 2016\n 1.0 1 64 Rx d 0")
    assert [frame.stamp for frame in frames] == [1456927507.0]


def test_other_events_and_remote_requests_are_passed_over():
    assert read(
        HEAD + "   1.0 1  ErrorFrame\n   1.1 CAN 1 Status:chip status error active\n   1.2 1  123  Rx   r 8\n"
        "   1.3 1  Statistic: D 27 R 0 XD 0 XR 0 E 0 O 0 B 0.87%\n   1.4 1  J1939TP FEE3p 6 0 0 - Rx d 23 A0 0F\n"
        "End TriggerBlock\n"
    ) == []  # fmt: skip


@pytest.mark.parametrize(
    "line",
    [
        FRAME[: FRAME.index(" D1")],
        FRAME[: FRAME.index("0  Length")],
        FRAME[: FRAME.index("Rx")],
        "   0.015991 CANFD   1 Rx        123                 1 0 d 32 01 02",
        "   0.015991 1  EngineSpeed     Rx   d 1 01",
        "   0.015991 1  800             Rx   d 1 01",
        "   0.015991 1  20000000x       Rx   d 1 01",
        "   0.015991 1  123             Rx   d 9 01 02 03 04 05 06 07 08 09",
        "   0.015991 1  123             Rx   d 1 301",
        "half a line",
        "date Wed Foo 28 10:23:45 2016",
        "date Wed Feb 30 10:23:45 2016",
    ],
)
def test_a_line_of_another_shape_is_refused(line):
    with pytest.raises(ValueError):
        read(line)


def test_python_can_reads_the_same(tmp_path):
    (tmp_path / "a.asc").write_text(HEAD + FRAME + "\n   0.5 1  123             Tx   d 3 01 02 03\n")
    theirs = [
        LogFrame(message.timestamp, message.arbitration_id, bytes(message.data), message.is_extended_id)
        for message in can.ASCReader(tmp_path / "a.asc")
    ]
    ours = read((tmp_path / "a.asc").read_text())
    assert [(f.identifier, f.data, f.extended) for f in ours] == [(f.identifier, f.data, f.extended) for f in theirs]
    assert [f.stamp - BEGAN for f in ours] == pytest.approx([f.stamp for f in theirs], abs=1e-6)
