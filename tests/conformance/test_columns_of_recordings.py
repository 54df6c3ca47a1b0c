"""Recorded buses in columns: frames, messages and losses are those that are read one by one."""

import numpy as np
import pytest

from tests.conformance.recorded import recordings
from tests.recordings import recording
from tests.unit.recording.live import in_columns, one_by_one
from timonel.nmea2000.fastpacket import Reassembler
from timonel.nmea2000.identifier import split
from timonel.nmea2000.registry import is_fast
from timonel.recording import open_log
from timonel.recording.assembly import PACE, Assembly
from timonel.recording.chunks import open_frames
from timonel.recording.frames import concatenate, from_logframes

LONG = 12_000
"""Frames of a recording that are looked at in every way."""


def frames_of(name):
    return concatenate(open_frames(recording(name)))


def faulty(frames, fault):
    draw = np.random.default_rng(len(frames))
    places = np.arange(len(frames))
    match fault:
        case "lossy":
            return frames[places[draw.random(len(frames)) > 0.03]]
        case "shuffled":
            return frames[np.argsort(places + draw.integers(0, 3, len(frames)) * (draw.random(len(frames)) < 0.1))]
        case "doubled":
            return frames[np.sort(np.concatenate((places, places[draw.random(len(frames)) < 0.05])))]
    return frames


@pytest.mark.usefixtures("each_way")
@pytest.mark.parametrize("name", recordings())
def test_frames_read_at_once_are_those_read_one_by_one(name):
    log, reader = open_log(recording(name)), open_frames(recording(name))
    expected, found = from_logframes(list(log)), concatenate(reader)
    assert found.rows.tobytes() == expected.rows.tobytes()
    assert found.stamp.tolist() == expected.stamp.tolist()
    assert found.spill.tobytes() == expected.spill.tobytes()
    assert (reader.log.unreadable, reader.log.frames) == (log.unreadable, log.frames)


@pytest.mark.usefixtures("each_way")
@pytest.mark.parametrize("fault", ["none", "lossy", "shuffled", "doubled"])
@pytest.mark.parametrize("name", recordings())
def test_messages_and_counters_are_those_of_the_live_path(name, fault):
    frames = faulty(frames_of(name)[:LONG], fault)
    expected, reassembler = one_by_one(frames)
    for size in (len(frames) or 1, 1 + len(frames) // 7):
        assembly = Assembly()
        assert in_columns(frames, size, assembly) == expected
        assert assembly.counters == reassembler.counters


@pytest.mark.parametrize("name", recordings())
def test_the_live_path_with_its_clock_in_seconds_counts_the_same(name):
    frames = frames_of(name)
    reassembler, now = Reassembler(), 0.0
    for frame in frames.logframes():
        now = now + PACE / 1e9 if frame.stamp is None else frame.stamp
        if frame.extended and not frame.whole and is_fast(split(frame.identifier).pgn):
            reassembler.receive(frame.identifier, frame.data, now)
    assembly = Assembly()
    in_columns(frames, 1 << 16, assembly)
    assert assembly.counters == reassembler.counters
