"""Messages in columns: those of the live path, however the frames come and are cut into chunks."""

import random

import pytest

from tests.unit.recording.live import in_columns, one_by_one
from timonel.nmea2000.fastpacket import fragment
from timonel.nmea2000.identifier import join
from timonel.recording import LogFrame
from timonel.recording.assembly import Assembly
from timonel.recording.frames import NO_STAMP, from_logframes

pytestmark = pytest.mark.usefixtures("each_way")

TRACK, GNSS, HEADING, ADDRESSED = 127237, 129029, 127250, 126208


def bus(messages=200, seed=1, pause=0.004):
    """Frames of several senders, interleaved as on a bus: (stamp, identifier, data)."""
    draw = random.Random(seed)
    senders = [join(3, pgn, source) for pgn in (TRACK, GNSS) for source in (1, 2, 3)]
    senders.append(join(3, ADDRESSED, 5, 9))
    sequence = dict.fromkeys(senders, 0)
    queues = {sender: [] for sender in senders}
    frames, now = [], 1_700_000_000.0
    while messages or any(queues.values()):
        sender = draw.choice(senders)
        if not queues[sender] and messages:
            size = {TRACK: 21, GNSS: 43}.get(sender >> 8 & 0x3FFFF, draw.randrange(224))
            queues[sender] = fragment(draw.randbytes(size), sequence[sender])
            sequence[sender] += 1
            messages -= 1
        if queues[sender]:
            frames.append(LogFrame(now, sender, queues[sender].pop(0)))
        if draw.random() < 0.3:
            frames.append(LogFrame(now, join(2, HEADING, 7), draw.randbytes(8)))
        now = round(now + draw.expovariate(1 / pause), 6)
    return frames


def faulty(frames, fault, seed=2):
    """A copy of the frames in which something went wrong."""
    draw = random.Random(seed)
    match fault:
        case "lossy":
            return [frame for frame in frames if draw.random() > 0.05]
        case "doubled":
            return [each for frame in frames for each in (frame,) * (1 + (draw.random() < 0.05))]
        case "exchanged":
            order = sorted(range(len(frames)), key=lambda place: place + (draw.random() < 0.1) * draw.uniform(0, 3))
            return [
                LogFrame(at.stamp, frames[place].identifier, frames[place].data)
                for at, place in zip(frames, order, strict=True)
            ]
        case "late":
            return [LogFrame(frame.stamp + draw.choice((0, 0, 0, 0.05, 0.2)), *fields(frame)) for frame in frames]
        case "short":
            return [LogFrame(frame.stamp, frame.identifier, cut(draw, frame.data)) for frame in frames]
        case "untimed":
            return [LogFrame(None, *fields(frame)) for frame in frames]
        case "half untimed":
            return [LogFrame(draw.choice((None, frame.stamp)), *fields(frame)) for frame in frames]
        case "standing counters":
            return [
                LogFrame(frame.stamp, frame.identifier, bytes((frame.data[0] & 31,)) + frame.data[1:])
                for frame in frames
            ]
        case "noise":
            return [LogFrame(frame.stamp, frame.identifier, noise(draw, frame.data)) for frame in frames]
    return frames


def fields(frame):
    return frame.identifier, frame.data


def cut(draw, data):
    return data[: draw.randrange(9)] if draw.random() < 0.05 else data


def noise(draw, data):
    return draw.randbytes(draw.randrange(9)) if draw.random() < 0.1 else data


FAULTS = [
    "none",
    "lossy",
    "doubled",
    "exchanged",
    "late",
    "short",
    "untimed",
    "half untimed",
    "standing counters",
    "noise",
]


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("pause", [0.0, 0.003])
def test_messages_and_counters_are_those_of_the_live_path_for_any_chunks(fault, pause):
    frames = from_logframes(faulty(bus(pause=pause or 1e-9), fault))
    expected, reassembler = one_by_one(frames)
    assert fault == "noise" or len(expected) > 60
    for size in (len(frames), 300, 9):
        assembly = Assembly()
        assert in_columns(frames, size, assembly) == expected
        assert assembly.counters == reassembler.counters
        assert assembly.frames == len(frames)


@pytest.mark.parametrize("fault", ["none", "lossy", "noise"])
@pytest.mark.parametrize("slots", [1, 3, 6])
def test_where_slots_run_out_the_oldest_gives_way_as_on_the_live_path(fault, slots):
    frames = from_logframes(faulty(bus(), fault))
    expected, reassembler = one_by_one(frames, slots)
    assert reassembler.counters.evicted
    for size in (len(frames), 100, 7):
        assembly = Assembly(max_slots=slots)
        assert in_columns(frames, size, assembly) == expected
        assert assembly.counters == reassembler.counters


def test_messages_are_whole_though_most_of_what_others_announce_never_comes():
    sender, lost = join(3, GNSS, 1), fragment(bytes(223), 0)[0]
    sent = [(lost,), fragment(b"these bytes are of a message that is whole", 0)] * 40
    frames = [
        LogFrame(1.0 + at * 1e-3, sender, data) for at, data in enumerate(one for all_of in sent for one in all_of)
    ]
    whole = from_logframes(frames)
    expected, reassembler = one_by_one(whole)
    assembly = Assembly()
    assert in_columns(whole, len(whole), assembly) == expected
    assert assembly.counters == reassembler.counters
    assert assembly.counters.completed == 40


def test_messages_of_one_size_that_overlap_in_time_have_each_its_own_bytes():
    said = {source: fragment(bytes(range(source, source + 43)), 0) for source in range(4)}
    frames = [
        LogFrame(1.0 + number * 1e-4, join(3, GNSS, source), said[source][number])
        for number in range(7)
        for source in (said if number < 6 else reversed(said))
    ]
    whole = from_logframes(frames)
    found = in_columns(whole, len(whole), Assembly())
    assert [(identifier & 0xFF, payload[0]) for _, _, identifier, payload in found] == [(3, 3), (2, 2), (1, 1), (0, 0)]
    assert found == one_by_one(whole)[0]


def test_more_streams_than_a_bus_can_have_are_put_together_one_by_one():
    frames = [
        LogFrame(1.0 + number * 1e-3, join(3, pgn, source), data)
        for number, (pgn, source) in enumerate((pgn, source) for pgn in range(130816, 130852) for source in range(250))
        for data in fragment(bytes(10), 0)
    ]
    found = from_logframes(frames)
    expected, reassembler = one_by_one(found)
    assembly = Assembly()
    assert in_columns(found, len(found), assembly) == expected
    assert assembly.counters == reassembler.counters
    assert len(expected) == 9000


def groups(frames, **wanted):
    return Assembly(**wanted).receive(from_logframes(frames))


def test_a_group_tells_from_whom_to_whom_and_how_urgent():
    frames = [
        LogFrame(1.5, join(6, 59904, 4, 9), b"\x00\xee\x00"),
        LogFrame(2.5, join(2, 59904, 5, 255), b"\x14\xf0\x01"),
    ]
    (group,) = groups(frames)
    assert (group.pgn, group.frame) == (59904, None)
    assert group.stamp.tolist() == [1_500_000_000, 2_500_000_000]
    assert group.source.tolist() == [4, 5]
    assert group.destination.tolist() == [9, 255]
    assert group.priority.tolist() == [6, 2]
    assert group.lengths.tolist() == [3, 3]
    assert group.payloads[:, :3].tolist() == [[0, 0xEE, 0], [0x14, 0xF0, 1]]


def test_a_pgn_without_a_destination_goes_to_everybody():
    (group,) = groups([LogFrame(None, join(2, HEADING, 4), bytes(8))])
    assert group.destination.tolist() == [255]
    assert group.stamp.tolist() == [NO_STAMP]


def test_standard_frames_are_grouped_by_identifier():
    frames = [LogFrame(1.0, number, bytes((number,)), extended=False) for number in (104, 108, 104)]
    frames.append(LogFrame(1.0, join(2, HEADING, 4), bytes(8)))
    found = groups(frames)
    assert [(group.pgn, group.frame, len(group.row)) for group in found] == [
        (HEADING, None, 1),
        (None, 104, 2),
        (None, 108, 1),
    ]


def test_messages_that_a_recorder_had_put_together_stay_as_they_are():
    frames = [LogFrame(1.0, join(3, TRACK, 1), data) for data in fragment(bytes(range(21)), 0)]
    whole = LogFrame(1.0, join(3, TRACK, 1), bytes(range(30)), whole=True)
    short = LogFrame(1.0, join(3, TRACK, 1), b"\x01\x02", whole=True)
    found = from_logframes([*frames[:2], whole, *frames[2:], short])
    expected, _ = one_by_one(found)
    assert [payload for *_, payload in expected] == [whole.data, bytes(range(21)), short.data]
    for size in (1, 3, 10):
        assert in_columns(found, size) == expected


def test_only_what_is_wanted_is_put_together():
    frames = [*bus(50), LogFrame(1.0, 104, b"\x00", extended=False)]
    assert [group.pgn for group in groups(frames, pgns=[HEADING, GNSS])] == [HEADING, GNSS]
    assert [group.frame for group in groups(frames, standard={104})] == [104]
    assert groups(frames, pgns=()) == []
    everything = {group.pgn: group for group in groups(frames)}
    (wanted,) = groups(frames, pgns={ADDRESSED})
    assert wanted.row.tolist() == everything[ADDRESSED].row.tolist()


def test_no_frames_make_no_messages():
    assert groups([]) == []
