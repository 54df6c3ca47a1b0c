"""PEAK's TRC in each of its versions."""

import pytest

from timonel.recording import LogFrame
from timonel.recording.peak_trc import PeakTrc

BEGAN = 1506809231.17
START = f";$STARTTIME={BEGAN / 86400 + 25569:.11f}\n"
DATA = bytes.fromhex("01A00FA6603BD140")
FILES = {
    "1.0": "     1)      1059 18EBFF00 8 01 A0 0F A6 60 3B D1 40",
    "1.1": ";$FILEVERSION=1.1\n" + START + "     1)      1059.9  Rx     18EBFF00  8  01 A0 0F A6 60 3B D1 40 ",
    "1.2": ";$FILEVERSION=1.2\n" + START + "     1)      1059.9 1  Rx     18EBFF00  8  01 A0 0F A6 60 3B D1 40 ",
    "1.3": ";$FILEVERSION=1.3\n" + START + "     1)      1059.9 1  Rx     18EBFF00 -  8    01 A0 0F A6 60 3B D1 40 ",
    "2.0": ";$FILEVERSION=2.0\n" + START + ";$COLUMNS=N,O,T,I,d,l,D\n"
           "      1      1059.900 DT 18EBFF00 Rx 8  01 A0 0F A6 60 3B D1 40 ",
    "2.1": ";$FILEVERSION=2.1\n" + START + ";$COLUMNS=N,O,T,B,I,d,R,L,D\n"
           "      1      1059.900 DT 1 18EBFF00 Rx -  8    01 A0 0F A6 60 3B D1 40 ",
}  # fmt: skip


def read(text):
    lines = text.splitlines()
    reader = PeakTrc(lines)
    return [frame for line in lines if (frame := reader.read(line)) is not None]


@pytest.mark.parametrize("version", FILES)
def test_a_frame_of_each_version_has_time_identifier_and_data(version):
    (frame,) = read(FILES[version])
    assert (frame.identifier, frame.data, frame.extended) == (0x18EBFF00, DATA, True)
    stamp = 1.059 if version == "1.0" else BEGAN + 1.0599
    assert frame.stamp == pytest.approx(stamp, abs=1e-3)
    assert PeakTrc(FILES[version].splitlines()).dated == (version != "1.0")


def test_an_identifier_of_four_digits_is_a_standard_frame():
    assert read("     1)       500 0064 2 01 02") == [LogFrame(0.5, 0x64, b"\x01\x02", False)]
    assert read("     1)       500 0064 0 ") == [LogFrame(0.5, 0x64, b"", False)]


def test_other_events_and_remote_requests_are_passed_over():
    assert read("     1)      1841 FFFFFFFF 4  00 00 00 08 BUSHEAVY \n     2)      1842 0064 4 RTR") == []
    assert read(";$FILEVERSION=1.1\n     1)      1059.9  Warng  FFFFFFFF  4  00 00 00 08  BUSHEAVY") == []
    columns = ";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n"
    assert read(columns + "   1 10.2 ST 1 - Rx - 4 00 00 00 08\n   2 11.0 RR 1 0064 Rx - 4 ") == []


@pytest.mark.parametrize(
    "text",
    [
        FILES["1.1"][:-4],
        FILES["1.1"][:-26],
        FILES["2.1"][:-2].removesuffix("0"),
        "     1)      1059 800 1 01",
        "     1)      1059 18EBFF00 9 01 02 03 04 05 06 07 08 09",
        "     1)      1059 20000000 1 01",
        "     1)      10_9 0064 1 01",
        "half a line",
        ";$COLUMNS=N,O\n",
        ";$STARTTIME=nan\n",
        ";$FILEVERSION=2.0\n;$COLUMNS=N,O,T,I,d,l,D\n 1 10.0 FD 0064 Rx 12 00 01 02 03 04 05 06 07 08 09 0A 0B",
    ],
)
def test_a_line_of_another_shape_is_refused(text):
    with pytest.raises(ValueError):
        read(text)
