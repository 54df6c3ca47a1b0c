"""JSON lines made of columns are, byte for byte, those that are made message by message."""

import json

import numpy as np
import pytest

from tests.conformance.recorded import recordings
from tests.recordings import recording
from timonel.nmea2000 import catalogue
from timonel.recording import LogFrame, open_log
from timonel.recording.assembly import Assembly
from timonel.recording.decoded import Decoder
from timonel.recording.frames import from_logframes
from timonel.recording.sinks import jsonl
from timonel.recording.sinks.jsonl import JsonLines

pytestmark = pytest.mark.usefixtures("each_way")


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


def random_messages(seed):
    """Payloads of noise for every definition; every other one begins as its constants have it."""
    draw = np.random.default_rng(seed)
    for pgn in catalogue.pgns():
        for definition in catalogue.variants(pgn) if pgn < 1 << 18 else ():
            mask, value, _ = definition.pattern
            for count in range(4):
                size = int(draw.integers(0, 224)) if definition.fast else 8
                noise = int.from_bytes(draw.bytes(size), "little")
                data = noise & ~mask | value if count % 2 else noise
                payload = (data & (1 << 8 * size) - 1).to_bytes(size, "little")
                identifier = 3 << 26 | pgn << 8 | int(draw.integers(0, 253))
                yield LogFrame(1.5, identifier, payload, whole=definition.fast)


@pytest.mark.parametrize("labels", [True, False])
def test_noise_in_any_definition_gives_the_lines_of_single_messages(labels, monkeypatch):
    monkeypatch.setattr(jsonl, "FEW", 1)
    frames = list(random_messages(seed=7))
    for one, other in zip(at_once(frames, labels).splitlines(), one_by_one(frames, labels).splitlines(), strict=True):
        assert one == other


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
