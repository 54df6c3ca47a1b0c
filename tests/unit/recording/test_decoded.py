"""Recordings message by message."""

import pytest

import timonel
from tests.recordings import recording
from timonel.errors import RecordingError
from timonel.nmea2000.fastpacket import fragment
from timonel.nmea2000.identifier import join
from timonel.recording import LogFrame, decoded
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


def test_no_more_identifiers_are_kept_than_a_bus_can_have_in_use(monkeypatch):
    monkeypatch.setattr(decoded, "MOST_IDENTIFIERS", 3)
    addresses = decoded.Addresses()
    identifiers = [join(2, 127250, source) for source in range(9)] * 2
    assert [addresses[identifier][2] for identifier in identifiers] == list(range(9)) * 2
    assert len(addresses) <= 3


def test_frames_without_times_come_a_millisecond_after_the_one_before():
    track = [LogFrame(None, join(2, 127237, 5), frame) for frame in fragment(bytes(13), 1)]
    other = LogFrame(None, join(2, 127250, 5), bytes(8))
    late = [frame for part in track for frame in [part, *[other] * 99]]
    assert [message.pgn for message in messages(late) if message.pgn == 127237] == [127237]
    too_late = [frame for part in track for frame in [part, *[other] * 100]]
    assert {message.pgn for message in messages(too_late)} == {127250}


def test_frames_without_times_go_on_from_the_last_one_that_has_a_time():
    first, *others = fragment(bytes(21), 1)
    identifier = join(2, 127237, 5)
    rest = [LogFrame(None, identifier, frame) for frame in others]
    (message,) = messages([LogFrame(1_700_000_000.0, identifier, first), *rest])
    assert (message.pgn, message.time, message.data) == (127237, None, bytes(21))


def messages(frames):
    decoder = decoded.Decoder()
    return [message for frame in frames if (message := decoder.receive(frame)) is not None]
