"""Fast packets: every rule of the table of `nmea2000/fastpacket.py`; two messages are never joined."""

from itertools import combinations, pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from timonel.errors import EncodeError
from timonel.nmea2000.fastpacket import LONGEST, Reassembler, fragment

HEADING_CONTROL = 0x09F10523  # 127237 from 35
COURSE = bytes.fromhex("3f3cffff7f051fffffffffffffff7fff7fff7f8b1e")  # heading-to-steer 45.5 degrees true
OTHER = bytes.fromhex("004d3fff7fcf81cf81ffffffffff7fff7fff7f147f")  # 190.4 degrees magnetic
A, B, C = fragment(COURSE, 1), fragment(OTHER, 1), fragment(COURSE, 2)


def play(frames, step=0.001, start=0.0, reassembler=None):
    """What comes out of frames `step` seconds apart."""
    reassembler = Reassembler() if reassembler is None else reassembler
    messages = [reassembler.receive(HEADING_CONTROL, f, start + i * step) for i, f in enumerate(frames)]
    return [message for message in messages if message is not None]


# --- fragments -----------------------------------------------------------------------------------------


def test_the_worked_example_of_127237_comes_out_byte_for_byte():
    assert [frame.hex(" ") for frame in A] == [
        "20 15 3f 3c ff ff 7f 05",
        "21 1f ff ff ff ff ff ff",
        "22 ff 7f ff 7f ff 7f 8b",
        "23 1e ff ff ff ff ff ff",
    ]


def test_the_sequence_counter_takes_three_bits():
    assert fragment(b"", 9)[0][0] == 1 << 5


def test_more_than_223_bytes_are_refused():
    with pytest.raises(EncodeError, match="224 bytes are more than 223"):
        fragment(bytes(LONGEST + 1), 0)


@pytest.mark.parametrize("length", range(LONGEST + 1))
def test_every_length_comes_back_without_its_padding(length):
    payload = bytes(range(1, length + 1))
    frames = fragment(payload, 5)
    assert len(frames) == (1 if length <= 6 else 1 + -(-(length - 6) // 7))
    assert {len(frame) for frame in frames} == {8}
    assert play(frames) == [payload]


# --- the ordinary course -------------------------------------------------------------------------------


def test_messages_of_a_counter_that_stands_still_all_come_out():
    assert play(A + B + A + B) == [COURSE, OTHER, COURSE, OTHER]


def test_interleaved_sources_destinations_pgns_and_counters_do_not_meet():
    streams = [
        (HEADING_CONTROL, fragment(bytes([1] * 21), 1)),
        (HEADING_CONTROL, fragment(bytes([2] * 21), 2)),
        (HEADING_CONTROL + 1, fragment(bytes([3] * 21), 1)),
        (0x0DEF0123, fragment(bytes([4] * 21), 1)),
        (0x0DEF0223, fragment(bytes([5] * 21), 1)),
        (0x0DF80523, fragment(bytes([6] * 21), 1)),
    ]
    reassembler = Reassembler()
    out = [reassembler.receive(i, frames[k], 0.0) for k in range(4) for i, frames in streams]
    assert [message[0] for message in out if message] == [1, 2, 3, 4, 5, 6]
    assert reassembler.counters.completed == 6
    assert reassembler.pending == 0


def test_a_priority_changed_on_the_way_is_still_the_same_message():
    reassembler = Reassembler()
    assert [reassembler.receive(HEADING_CONTROL ^ (i << 26), frame, 0.0) for i, frame in enumerate(A)][3] == COURSE


def test_a_last_frame_without_padding_is_taken():
    assert play([*A[:3], A[3][:2]]) == [COURSE]


# --- time ----------------------------------------------------------------------------------------------


def test_a_message_may_take_just_less_than_250_ms():
    assert play(A, step=0.083) == [COURSE]


def test_a_message_that_took_250_ms_is_lost():
    reassembler = Reassembler(max_gap=1.0)
    for frame, now in zip(A, (0.0, 0.1, 0.2, 0.25), strict=True):
        assert reassembler.receive(HEADING_CONTROL, frame, now) is None
    assert reassembler.counters.expired == 1
    assert reassembler.counters.headless == 1


def test_a_pause_of_more_than_100_ms_ends_a_message():
    assert play(A[:2]) == []
    reassembler = Reassembler()
    play(A[:2], reassembler=reassembler)
    assert play(A[2:], start=0.102, reassembler=reassembler) == []
    assert reassembler.counters.expired == 1


def test_a_clock_that_was_set_back_ends_a_message():
    reassembler = Reassembler()
    play(A[:2], start=100.0, reassembler=reassembler)
    assert play(A[2:], start=90.0, reassembler=reassembler) == []


def test_expire_gives_up_what_is_too_old_and_counts_it():
    reassembler = Reassembler()
    play(A[:2], reassembler=reassembler)
    reassembler.expire(0.1)
    assert reassembler.pending == 1
    reassembler.expire(0.102)
    assert reassembler.pending == 0
    assert reassembler.counters.expired == 1


def test_a_shorter_age_limit_can_be_chosen():
    reassembler = Reassembler(max_age=0.01)
    assert play(A, step=0.003, reassembler=reassembler) == [COURSE]
    assert play(A, step=0.004, start=1.0, reassembler=reassembler) == []


# --- order ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [(1, 0, 2, 3), (0, 2, 1, 3), (0, 1, 3, 2), (1, 0, 3, 2)])
def test_exchanged_neighbours_are_put_in_order(order):
    reassembler = Reassembler()
    assert play([A[i] for i in order], reassembler=reassembler) == [COURSE]
    assert reassembler.counters.exchanged == (2 if order == (1, 0, 3, 2) else 1)
    assert reassembler.counters.broken == 0


@pytest.mark.parametrize("order", [(0, 2, 3, 1), (0, 3, 1, 2), (2, 0, 1, 3), (3, 2, 1, 0)])
def test_wider_disorder_loses_the_message(order):
    assert play([A[i] for i in order]) == []


def test_a_frame_that_comes_twice_in_a_row_is_ignored_and_counted():
    reassembler = Reassembler()
    assert play([frame for frame in A[:3] for _ in range(2)] + A[3:], reassembler=reassembler) == [COURSE]
    assert reassembler.counters.duplicates == 3


def test_the_same_index_with_other_content_loses_the_message():
    reassembler = Reassembler()
    assert play([A[0], A[1], B[1], *A[2:]], reassembler=reassembler) == []
    assert reassembler.counters.broken == 1
    assert reassembler.counters.headless == 2


def test_a_new_frame_0_starts_the_message_afresh():
    reassembler = Reassembler()
    assert play([*A[:3], *B], reassembler=reassembler) == [OTHER]
    assert reassembler.counters.interrupted == 1


def test_an_early_frame_1_does_not_wait_longer_than_the_gap():
    reassembler = Reassembler()
    play([A[1]], reassembler=reassembler)
    assert play([A[0], *A[2:]], start=0.101, reassembler=reassembler) == []


# --- losses --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("pause", [0.002, 0.099, 0.101, 0.2, 0.25])
def test_the_course_that_no_message_contained_does_not_come_out(pause):
    reassembler = Reassembler()
    assert play([A[0], A[2], A[3]], reassembler=reassembler) == []
    assert play(B[1:], start=0.002 + pause, reassembler=reassembler) == []
    assert play(B, start=1.0, reassembler=reassembler) == [OTHER]


@pytest.mark.parametrize("lost", range(4))
def test_after_a_lost_frame_the_next_message_comes_out(lost):
    assert play(A[:lost] + A[lost + 1 :] + B) == [OTHER]
    assert play(A[:lost] + A[lost + 1 :] + C) == [COURSE]


def test_frames_without_a_first_one_are_dropped_and_counted():
    reassembler = Reassembler()
    assert play(A[2:], reassembler=reassembler) == []
    assert reassembler.counters.headless == 2
    assert reassembler.pending == 0


def test_the_oldest_message_gives_way_when_every_slot_is_taken():
    reassembler = Reassembler(max_slots=2)
    for source in range(3):
        reassembler.receive(source, A[0], 0.0)
    assert reassembler.pending == 2
    assert reassembler.counters.evicted == 1
    assert [reassembler.receive(1, frame, 0.0) for frame in A[1:]][-1] == COURSE


@pytest.mark.parametrize("frame", [b"", b"\x00", b"\x00\xe0" + bytes(6), b"\x00\x15\x00", b"\x00\x05\x00"])
def test_a_frame_that_no_fast_packet_has_is_counted(frame):
    reassembler = Reassembler()
    assert play([frame], reassembler=reassembler) == []
    assert reassembler.counters.malformed == 1


def test_a_short_frame_in_the_middle_loses_the_message():
    reassembler = Reassembler()
    assert play([A[0], A[1][:7], *A[2:]], reassembler=reassembler) == []
    assert reassembler.counters.broken == 1


def test_a_last_frame_too_short_for_the_length_loses_the_message():
    reassembler = Reassembler()
    assert play([*A[:3], A[3][:1]], reassembler=reassembler) == []
    assert reassembler.counters.malformed == 1


# --- every way to lose and exchange frames, counter standing still -------------------------------------


def messages(lengths, alike):
    """Messages of so many frames each; the frames `alike` are the same in all of them."""
    body = [[k if k in alike else 16 * m + k for k in range(n)] for m, n in enumerate(lengths, 1)]
    return [bytes(b for k, value in enumerate(row) for b in [value] * (6 if k == 0 else 7)) for row in body]


def exchanges(frames, most):
    """The frames with up to `most` pairs of neighbours exchanged, no frame twice."""
    places = range(len(frames) - 1)
    for count in range(most + 1):
        for chosen in combinations(places, count):
            if all(b - a > 1 for a, b in pairwise(chosen)):
                mixed = list(frames)
                for i in chosen:
                    mixed[i], mixed[i + 1] = mixed[i + 1], mixed[i]
                yield count, mixed


def wrong_joins(lengths, pause, within_message):
    """(frames lost, pairs exchanged) of every case in which a message comes out that was never sent."""
    for alike in [s for r in range(max(lengths)) for s in combinations(range(max(lengths)), r)]:
        sent = messages(lengths, alike)
        frames = [(m, frame) for m, payload in enumerate(sent) for frame in fragment(payload, 0)]
        for losses in range(len(frames)):
            for kept in combinations(frames, len(frames) - losses):
                for count, arrived in exchanges(kept, most=2):
                    if within_message and [m for m, _ in arrived] != sorted(m for m, _ in arrived):
                        continue
                    reassembler = Reassembler()
                    out = {reassembler.receive(0, frame, m * pause) for m, frame in arrived} - {None}
                    if not out <= set(sent):
                        yield losses, count


@pytest.mark.parametrize("lengths", [(2, 2), (3, 3), (4, 4), (2, 4), (4, 2), (3, 2), (3, 4), (2, 2, 2), (3, 3, 3)])
def test_messages_more_than_the_gap_apart_are_never_joined(lengths):
    assert list(wrong_joins(lengths, pause=0.101, within_message=True)) == []


@pytest.mark.parametrize(
    ("lengths", "lost_in_order", "lost_with_an_exchange"),
    [((2, 2), 2, 1), ((3, 3), 2, 1), ((4, 4), 3, 2), ((3, 4), 2, 1), ((4, 2), 9, 2), ((3, 3, 3), 2, 1)],
)
def test_closer_messages_are_joined_only_after_as_many_losses_as_documented(
    lengths, lost_in_order, lost_with_an_exchange
):
    cases = list(wrong_joins(lengths, pause=0.0, within_message=False))
    assert min((losses for losses, count in cases if count == 0), default=9) == lost_in_order
    assert min((losses for losses, count in cases if count), default=9) == lost_with_an_exchange


@given(st.data())
def test_a_turning_counter_never_joins_whatever_is_lost_doubled_or_moved(data):
    sent = [bytes([m] * data.draw(st.integers(0, 60))) for m in range(7)]
    frames = [(key, f) for m, p in enumerate(sent) for key, f in enumerate(fragment(p, m), 100 * m)]
    arrived = data.draw(st.permutations(frames)) if data.draw(st.booleans()) else frames
    arrived = [frame for frame in arrived for _ in range(data.draw(st.sampled_from([0, 1, 1, 1, 1, 2])))]
    assert set(play([frame for _, frame in arrived])) <= set(sent)


@given(st.lists(st.binary(max_size=8), max_size=200))
def test_no_bytes_raise_or_keep_a_slot_past_the_bound(frames):
    reassembler = Reassembler(max_slots=4)
    play(frames, reassembler=reassembler)
    assert reassembler.pending <= 4
