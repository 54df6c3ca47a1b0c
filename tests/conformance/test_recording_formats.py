"""Every public recording is recognised by its content, and one bus is the same bus whoever recorded it."""

import re
from collections import Counter
from itertools import pairwise

import pytest

from tests.recordings import ROOT, recording
from timonel.errors import RecordingError
from timonel.nmea2000.identifier import NULL, split
from timonel.recording import open_any, open_log
from timonel.recording.actisense import Ngt1

SAMPLES = "canboat_canboat/samples/"
CAN_UTILS = "aldas_go-nmea-client/socketcan/testdata/"
ACTISENSE = "aldas_go-nmea-client/actisense/testdata/"

# What SOURCES.md calls a format, what we call it, whether its records have times, and a date with them. What a
# candump has depends on its options; so it stands below.
NAMES = {
    "canboat-raw": ("canboat", True, True),
    "ydraw": ("YD RAW", True, False),
    "actisense-n2k-ascii": ("Actisense N2K ASCII", True, False),
    "actisense-ebl": ("Actisense EBL", True, True),
    "actisense-dle": ("Actisense NGT-1", True, False),
    "ikonvert": ("iKonvert", True, False),
    "pcap": ("pcap", True, True),
    "nmea0183": ("NMEA 0183", False, False),
    "candump": ("candump", False, False),
    "candump -L": ("candump", True, True),
    "candump -t": ("candump", True, True),
}
FROM_A_START = {
    SAMPLES + "candump-fast.txt": ("candump", True, False),  # times since the log began
    SAMPLES + "candump-fast-cr.txt": ("candump", True, False),
    CAN_UTILS + "candump_t-d.log": ("candump", True, False),
    CAN_UTILS + "candump_t-z.log": ("candump", True, False),
    SAMPLES + "pgn1.ebl": ("Actisense EBL", False, False),  # begins in the middle of its only time
    ACTISENSE + "actisense-ngt1-my-debug-20215131-1636.txt": ("candump", False, False),  # nothing but comments
}
NO_RECORDING = {"json", "dbc", "gpsd-chk", "text"}


def listed():
    """(file, format, lines or None) of every recording that SOURCES.md lists."""
    for row in (ROOT / "SOURCES.md").read_text().splitlines():
        cells = [cell.strip() for cell in row.split("|")]
        if len(cells) > 8 and "/" in cells[1]:
            yield cells[1], cells[2], int(cells[4]) if cells[4].isdigit() else None


def test_every_recording_is_recognised_by_its_content():
    recognised, expected = {}, {}
    for name, kind, _ in listed():
        if kind in NO_RECORDING and name not in FROM_A_START:
            continue
        with open_any(recording(name)) as log:
            recognised[name] = log.format, log.timed, log.dated
        expected[name] = FROM_A_START.get(name) or NAMES[kind]
    assert len(recognised) > 110
    assert recognised == expected


def test_a_file_that_is_no_recording_is_refused():
    refused = {name for name, kind, _ in listed() if kind in NO_RECORDING - {"gpsd-chk"}} - set(FROM_A_START)
    assert len(refused) == 6
    for name in refused:
        with pytest.raises(RecordingError, match="no log format known here has lines such as"):
            open_any(recording(name))


# Lines of these logs that are no sentences.
OTHER_LINES = {
    "Knio_pynmea2/examples/data.log": 1,  # foobar
    "ntpsec_gpsd/test/daemon/skytraq-PX1172RH_DS.log": 3,  # gpsd's own, in JSON
}


def test_every_sentence_of_the_logs_is_read_and_other_lines_are_counted():
    found, expected = {}, {}
    for name, kind, lines in listed():
        if kind == "nmea0183":
            log = open_any(recording(name))
            assert log.kind == "sentences"
            found[name] = sum(1 for _ in log), log.unreadable_count
            expected[name] = lines, OTHER_LINES.get(name, 0)
    assert len(found) == 15
    assert found == expected


def test_what_a_converter_wrote_behind_times_and_sources_is_read_too():
    log = open_any(recording("SignalK_signalk-server/samples/aava-n2k.data.ttlappalainen.nmea.gz"))
    assert (log.kind, log.timed, log.dated) == ("sentences", True, True)
    sentences = list(log)
    assert sentences[0].stamp == 1408129200.042
    assert sentences[0].line == b"$GPGGA,185959.46,5943.501,N,02444.201,E,1,10,0.8,2.3,M,,M,,*7B"
    assert len(sentences) + log.unreadable_count == 6592
    assert {found.text[-8:-3] for found in log.unreadable} == {",,\xff,\xff"}  # garbage that it prints


# Unreadable --------------------------------------------------------------------------------------------------------


def test_what_cannot_be_read_of_the_gateways_recordings_is_known():
    assert [(u.place, u.text) for u in unreadable(ACTISENSE + "actisense-serial-ng1-cat-usb-2021-05-14-1005.bin")] == [
        ("byte 0", "03")  # the end of the message before
    ]
    assert [(u.place, u.text) for u in unreadable(SAMPLES + "pgn1.ebl")] == [("byte 0", "03 00 10 e7 a7 84 83 d9 01")]
    torn = unreadable(SAMPLES + "ikonvert.log")
    assert len(torn) == 26
    assert [(u.place, u.text) for u in torn[:1]] == [
        ("line 118", "!PDGY,127250,2,3,255,485.564,Ai20AAAAAAE=$PDGY,000000,3,,5,485,1,0"),
    ]


def unreadable(name):
    log = open_log(recording(name))
    assert sum(1 for _ in log) == log.frames
    return log.unreadable


def test_the_clock_of_ikonvert_goes_on_though_it_writes_36_milliseconds_as_36():
    stamps = [frame.stamp for frame in open_log(recording(SAMPLES + "ikonvert.log"))]
    assert min(later - earlier for earlier, later in pairwise(stamps)) > -0.05


# One bus, several recorders -----------------------------------------------------------------------------------------


def frames(name):
    return list(open_log(recording(name)))


def without_source(frame):
    parts = split(frame.identifier)
    return parts.priority, parts.pgn, parts.destination, frame.data, frame.whole


@pytest.mark.parametrize("name", ["pgn127504", "pgn129538", "pgn129551"])
def test_the_ebl_of_a_bus_has_the_messages_of_its_canboat_log(name):
    ebl, raw = frames(f"{SAMPLES}{name}.ebl"), frames(f"{SAMPLES}{name}.raw")
    assert list(map(without_source, ebl)) == list(map(without_source, raw))
    assert {split(frame.identifier).source for frame in ebl} == {NULL}  # BST 94 does not tell it
    hours = {round(there.stamp - here.stamp, 3) / 3600 for here, there in zip(ebl, raw, strict=True)}
    assert len(hours) == 1  # the log is in the time of some zone
    assert hours.pop().is_integer()


def test_line_ends_make_no_difference():
    assert frames(SAMPLES + "candump-fast.txt") == frames(SAMPLES + "candump-fast-cr.txt") != []


def test_what_a_debugger_printed_in_hex_is_what_the_file_has():
    printed = bytes.fromhex(recording(SAMPLES + "ebl.in").read_text())
    assert printed == recording(SAMPLES + "pgn1.ebl").read_bytes()


@pytest.mark.parametrize(
    ("part", "whole"),
    [
        (CAN_UTILS + "fast_packet_pgn129029.txt", CAN_UTILS + "candump-2021-05-12_091355.log"),
        (ACTISENSE + "actisense-w2k1-raw-ascii-fast-packet-pgn129540.txt",
         ACTISENSE + "actisense-w2k1-raw-ascii-2022-09-16.txt"),
        (ACTISENSE + "actisense-w2k1-raw-ascii-fast-packet-pgn13820.txt",
         ACTISENSE + "actisense-w2k1-raw-ascii-2022-09-16.txt"),
        (SAMPLES + "sample-fast.raw.txt", SAMPLES + "susteranna2020.raw"),
    ],
)  # fmt: skip
def test_a_part_of_a_recording_has_frames_of_the_whole(part, whole):
    taken, of = frames(part), frames(whole)
    assert taken
    assert not Counter(map(repr, taken)) - Counter(map(repr, of))


def contents(name):
    return Counter((frame.identifier, frame.data) for frame in frames(CAN_UTILS + name))


def test_candumps_of_a_bus_at_power_on_have_the_same_frames_with_times_and_without():
    without, timed = contents("candump-bus-power-on-default.log"), contents("candump-bus-power-on-time-a.log")
    assert without.total() == 21
    assert not without - timed


def test_candumps_of_a_bus_in_every_form_of_time_have_the_same_frames():
    # Two thermometers: -t d and -t a missed a slow one, -t A was an hour later.
    logged = set(contents("candump_L.log"))
    assert len(logged) == 6
    assert set(contents("candump_default.log")) == set(contents("candump_t-z.log")) == logged
    assert set(contents("candump_t-a.log")) < logged
    assert set(contents("candump_t-d.log")) < logged
    assert len(set(contents("candump_t-a-uppercase.log")) & logged) == 3


def test_the_n2k_ascii_of_two_loggers_has_the_same_message():
    one, other = frames(ACTISENSE + "actisense-w2k1-n2k-ascii.txt")[1], frames(SAMPLES + "actisense-w2k-n2k.raw")
    assert one.identifier, one.data in {(frame.identifier, frame.data) for frame in other}


def test_messages_that_another_reader_of_a_gateway_printed_have_right_check_sums_and_are_read():
    text = recording(ACTISENSE + "actisense-ngt1-my-debug-20215131-1636.txt").read_text()
    printed = [bytes.fromhex(hexa) for hexa in re.findall("raw actisense message: ([0-9a-f]+)", text)]
    stream = b"".join(b"\x10\x02" + each.replace(b"\x10", b"\x10\x10") + b"\x10\x03" for each in printed)
    assert Ngt1.recognises(stream[:4096])
    reader = Ngt1(stream[:4096])
    read = [*reader.receive(stream), *reader.finish()]
    heard = [each for each in printed if each[0] == 0x93]
    assert (len(printed), len(heard)) == (1361, 1338)
    assert [frame.data for frame in read] == [each[13:-1] for each in heard]
