"""Recorded buses: every file of a known format reads, and its fast packets come out as public decoders count them."""

import gzip
import json
from collections import Counter

import pytest

from tests.recordings import ROOT, recording
from timonel.nmea2000.fastpacket import Reassembler
from timonel.nmea2000.identifier import split
from timonel.nmea2000.registry import is_fast
from timonel.recording import open_log

SAMPLES = "canboat_canboat/samples/"
CAN_UTILS = "aldas_go-nmea-client/socketcan/testdata/"
ACTISENSE = "aldas_go-nmea-client/actisense/testdata/"
FORMATS = (
    "canboat-raw",
    "candump",
    "candump -L",
    "candump -t",
    "ydraw",
    "actisense-n2k-ascii",
    "actisense-ebl",
    "actisense-dle",
    "ikonvert",
    "pcap",
)
PACE = 0.0006  # s from frame to frame where a recording has no times: a busy bus


def messages(log):
    """(source, PGN, payload) of every message of a recording."""
    reassembler = Reassembler()
    for number, line in enumerate(log):
        identifier = split(line.identifier)
        payload = line.data
        if is_fast(identifier.pgn) and not line.whole:
            now = number * PACE if line.stamp is None else line.stamp
            payload = reassembler.receive(line.identifier, line.data, now)
        if payload is not None:
            yield identifier.source, identifier.pgn, payload


def listed():
    """(file, messages that canboat decodes or None) of the recordings whose format is read here."""
    for row in (ROOT / "SOURCES.md").read_text().splitlines():
        cells = [cell.strip() for cell in row.split("|")]
        if len(cells) > 8 and cells[2] in FORMATS:
            yield cells[1], int(cells[5]) if cells[5].isdigit() else None


# canboat counts here what is no message, or passes over what is one.
OTHERWISE = {
    SAMPLES + "boatkit-fusion-menu.raw": 5,  # a PGN that it does not decode
    SAMPLES + "fusion-130820-status.raw": 8,  # as above
    SAMPLES + "pgn129551.raw": 2,  # as above
    SAMPLES + "pgn130330.raw": 3,  # whole 126208 beside the frames of 130330
    SAMPLES + "dirona-actisense-serial.raw": 39870,  # it counts the gateway's own PGNs
    SAMPLES + "sample-single.raw.txt": 653,  # as above, and three lines without data
    "SignalK_signalk-server/samples/aava-n2k.data": 20995,  # as above
    SAMPLES + "raymarine-ev1.raw": 23273,  # as above, and each of the 524 frames of 130916 as a message
    SAMPLES + "susteranna2020.raw": 4429,  # each frame of a fast packet as a message
    SAMPLES + "sample-YDWG02-2.txt": 10,  # the last line has nine bytes
    SAMPLES + "ikonvert.log": 8923,  # it is not listed how many it decodes
    SAMPLES + "actisense1.ebl": 14,  # it counts the gateway's own
    SAMPLES + "pgn127504.ebl": 5,  # as above
    SAMPLES + "pgn129538.ebl": 3,  # as above
    SAMPLES + "pgn129551.ebl": 2,  # as above
    ACTISENSE + "actisense-serial-ng1-cat-usb-2021-05-14-1005.bin": 1288,  # as above
    SAMPLES + "can0-3.pcap": 24322,  # it joins frames of any age: eight messages are not whole within 250 ms
    CAN_UTILS + "candump-bus-power-on-time-a.log": 28,  # it does not read `candump -t`
    CAN_UTILS + "candump_t-a-uppercase.log": 5,
    CAN_UTILS + "candump_t-a.log": 7,
    CAN_UTILS + "candump_t-d.log": 6,
    CAN_UTILS + "candump_t-z.log": 7,
}


def test_every_listed_recording_gives_as_many_messages_as_canboat_decodes():
    counted = {name: sum(1 for _ in messages(open_log(recording(name)))) for name, _ in listed()}
    assert len(counted) > 80
    assert counted == {name: OTHERWISE.get(name, count) for name, count in listed()}


GATEWAYS = (SAMPLES + "ikonvert.log", SAMPLES + "pgn1.ebl", ACTISENSE)  # these are looked at elsewhere


def test_only_known_lines_of_the_listed_recordings_cannot_be_read():
    unreadable = {}
    for name, _ in listed():
        if name.startswith(GATEWAYS):
            continue
        log = open_log(recording(name))
        assert sum(1 for _ in log) == log.frames
        assert log.bytes_read == log.size
        unreadable |= {(name, line.line): line.reason for line in log.unreadable}
    assert unreadable == {
        (SAMPLES + "sample-YDWG02-2.txt", 76): "neither a comment nor a frame",  # nine bytes
        (SAMPLES + "sample-single.raw.txt", 262): "fewer than seven fields",
        (SAMPLES + "sample-single.raw.txt", 356): "fewer than seven fields",
        (SAMPLES + "sample-single.raw.txt", 419): "fewer than seven fields",
        (SAMPLES + "susteranna2020.raw", 202): "fewer than seven fields",
        (SAMPLES + "susteranna2020.raw", 2425): "fewer than seven fields",
    }


def _contents(line):
    return [content for content in json.loads(line).values() if isinstance(content, dict) and "pgn" in content]


@pytest.mark.parametrize(
    "name",
    [
        "candumpSample2.txt",
        "simulator1.raw",
        "furuno-fap7011c-autopilot-off-then-on.raw",
    ],
)
def test_every_payload_is_the_one_that_canboats_analyzer_wrote(name):
    with gzip.open(recording(SAMPLES + name + ".canboat.jsonl.gz"), "rt") as lines:
        decoded = [message for line in lines for message in _contents(line)]
    expected = Counter((message["src"], message["pgn"], bytes.fromhex(message["data"])) for message in decoded)
    assert Counter(messages(open_log(recording(SAMPLES + name)))) == expected
