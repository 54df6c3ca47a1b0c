"""What is told of a recording without decoding it."""

from collections import Counter

import pytest

from tests.recordings import recording
from timonel.errors import RecordingError
from timonel.recording.decoded import open_recording
from timonel.recording.decoding import Pass
from timonel.recording.tables import Tables
from timonel.recording.wanted import Wanted, wanted
from timonel.vehicles.rover.protocol import Protocol

SAMPLES = "canboat_canboat/samples"


def summary(name, **options):
    recorded = Pass(recording(f"{SAMPLES}/{name}"), **options)
    for _ in recorded:
        pass
    return recorded.summary


def test_every_message_is_counted_by_name_and_by_source():
    found = summary("susteranna2020.raw")
    messages = list(open_recording(recording(f"{SAMPLES}/susteranna2020.raw")))
    by_name = Counter((message.pgn, message.name) for message in messages)
    assert {key: tally.count for key, tally in found.messages.items()} == by_name
    assert {key: device.messages for key, device in found.devices.items()} == Counter(m.source for m in messages)
    assert (found.frames, found.count, found.unreadable_count) == (6086, 4429, 2)


def test_what_a_chunk_has_told_apart_is_what_tables_are_made_of():
    (chunk,) = [chunk for chunk in Pass(recording(f"{SAMPLES}/can0-2.pcap")) if chunk.frames > 1024]
    assert {len(found) > 1 for found in chunk.selected.values()} == {True, False}
    lots = [[(lot.name, lot.messages.row.tolist()) for lot in made] for made in (
        Tables().lots(chunk.groups, chunk.selected),
        Tables().lots(chunk.groups),
    )]  # fmt: skip
    assert lots[0] == lots[1]


def test_times_span_and_rate_are_those_of_the_messages():
    found = summary("susteranna2020.raw")
    times = [message.time for message in open_recording(recording(f"{SAMPLES}/susteranna2020.raw"))]
    assert found.first / 1e9 == min(times)
    assert found.seconds == pytest.approx(max(times) - min(times), abs=1e-6)
    wind = [m.time for m in open_recording(recording(f"{SAMPLES}/susteranna2020.raw")) if m.name == "windData"]
    assert found.messages[130306, "windData"].rate == pytest.approx((len(wind) - 1) / (max(wind) - min(wind)))


def test_losses_are_those_of_the_live_path():
    found = summary("susteranna2020.raw")
    messages = open_recording(recording(f"{SAMPLES}/susteranna2020.raw"))
    list(messages)
    counters = messages.counters
    assert (found.counters.completed, found.counters.headless) == (counters.completed, counters.headless)
    assert found.lost > 0


def test_devices_are_known_by_what_they_say_of_themselves():
    found = summary("can0-2.pcap")
    assert found.devices[36].claim["manufacturerCode"] == "Airmar"
    assert found.devices[36].name == "C078880010E8F235"
    assert found.devices[16].claim is None


def test_a_recording_without_times_has_no_span():
    found = summary("candumpSample2.txt")
    assert (found.timed, found.dated, found.first, found.seconds) == (False, False, None, None)
    assert all(tally.rate is None for tally in found.messages.values())


def test_numbers_and_names_choose_what_is_read():
    protocol = Protocol()
    heading = Wanted(frozenset({127250}), frozenset(), frozenset({"vesselHeading"}))
    assert wanted(["vesselHeading"], protocol) == heading
    assert wanted(["127250"], protocol).pgns == {127250}
    assert wanted(["104", "DriveEnable"], protocol).standard == {104, 101}
    assert wanted([], protocol) == Wanted()
    assert {key for key, _ in summary("susteranna2020.raw", wanted=heading).messages} == {127250}


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ("vesselHedding", 'did you mean "vesselHeading"'),
        ("DriveEnabel", 'did you mean "DriveEnable"'),
        ("300000", "no PGN"),
    ],
)
def test_a_word_that_is_no_message_is_refused(word, told):
    with pytest.raises(RecordingError, match=told):
        wanted([word], Protocol())
