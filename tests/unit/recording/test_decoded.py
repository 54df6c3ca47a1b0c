"""Recordings message by message."""

import pytest

import timonel
from tests.recordings import recording
from timonel.errors import RecordingError
from timonel.recording.decoded import open_recording

SAMPLES = "canboat_canboat/samples"


def test_messages_have_names_fields_and_values():
    with timonel.open_recording(recording(f"{SAMPLES}/susteranna2020.raw")) as messages:
        heading = next(message for message in messages if message.name == "vesselHeading")
    assert (heading.pgn, heading.source, heading.time) == (127250, 23, 1598104356.95)
    assert heading.fields == {"sid": 0, "heading": 5.9782, "reference": "Magnetic"}
    assert heading.value.heading == 5.9782
    assert heading.value.deviation is None


def test_fast_packets_are_put_together_and_counted():
    messages = open_recording(recording(f"{SAMPLES}/candumpSample2.txt"))
    found = [message for message in messages if message.pgn == 129029]
    assert found
    assert all(len(message.data) > 8 for message in found)
    assert messages.counters.completed > len(found)


def test_times_without_a_date_are_none():
    messages = open_recording(recording(f"{SAMPLES}/simulator1.raw"))
    assert {message.time for message in messages} == {None}
    assert messages.log.timed


def test_what_could_not_be_read_is_told_or_refused():
    messages = open_recording(recording(f"{SAMPLES}/susteranna2020.raw"))
    assert len(list(messages)) == 4429
    assert messages.log.unreadable_count == 2
    with pytest.raises(RecordingError, match="line 202"):
        list(open_recording(recording(f"{SAMPLES}/susteranna2020.raw"), strict=True))


def test_frames_of_a_rover_are_messages_too(tmp_path):
    log = tmp_path / "rover.log"
    log.write_text("(1700000000.000000) can0 068#060006000600\n(1700000000.100000) can0 7F0#01\n")
    currents, unknown = open_recording(log)
    assert (currents.frame, currents.name, set(currents.fields)) == (
        104,
        "MotorCurrentRight",
        {"front", "middle", "rear"},
    )
    assert (unknown.name, unknown.fields, unknown.data) == (None, {}, b"\1")
