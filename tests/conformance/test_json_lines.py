"""JSON lines made of columns are, byte for byte, those that are made message by message."""

import json

import pytest

from tests.conformance.recorded import recordings
from tests.recordings import recording
from timonel.recording import open_log
from timonel.recording.assembly import Assembly
from timonel.recording.decoded import Decoder
from timonel.recording.frames import from_logframes
from timonel.recording.sinks import jsonl
from timonel.recording.sinks.jsonl import JsonLines


def one_by_one(frames, labels=True):
    decoder = Decoder()
    found = (decoder.receive(frame) for frame in frames)
    return b"".join(f"{message.line(labels)}\n".encode() for message in found if message)


def at_once(frames, labels=True, chunk=1 << 20):
    assembly, lines, found = Assembly(), JsonLines(labels), []
    every = from_logframes(frames)
    for start in range(0, len(every), chunk):
        part = every[start : start + chunk]
        found.append(bytes(lines.lines(assembly.receive(part), start, len(part))))
    return b"".join(found)


@pytest.mark.parametrize("name", recordings())
def test_columns_give_the_lines_of_single_messages(name, monkeypatch):
    monkeypatch.setattr(jsonl, "FEW", 1)
    frames = list(open_log(recording(name)))
    assert at_once(frames) == one_by_one(frames)


@pytest.mark.parametrize(
    "name", ["canboat_canboat/samples/susteranna2020.raw", "canboat_canboat/samples/candumpSample2.txt"]
)
def test_the_lines_do_not_depend_on_chunks_or_on_what_is_frequent(name):
    frames = list(open_log(recording(name)))
    assert at_once(frames, labels=False, chunk=500) == one_by_one(frames, labels=False)


def test_a_line_is_an_object_with_canboats_names_in_their_order():
    frames = list(open_log(recording("canboat_canboat/samples/susteranna2020.raw")))
    lines = at_once(frames).splitlines()
    head = ["time", "priority", "source", "destination", "pgn", "name", "data", "fields"]
    assert all(list(json.loads(line)) == head for line in lines)
    heading = next(line for line in lines if b'"vesselHeading"' in line)
    assert heading == (
        b'{"time": 1598104356.950000, "priority": 2, "source": 23, "destination": 255, "pgn": 127250, '
        b'"name": "vesselHeading", "data": "0086E9FF7FFF7FFD", '
        b'"fields": {"sid": 0, "heading": 5.9782, "reference": "Magnetic"}}'
    )
