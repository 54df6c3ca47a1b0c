"""A frame of 12 bytes crosses CAN in two."""

import pytest

from timonel.vehicles.rover.segments import Joiner, split

IMU = bytes(range(12))
LENGTHS = {111: 12, 160: 10}


@pytest.fixture
def joiner() -> Joiner:
    return Joiner(LENGTHS)


def test_a_long_frame_is_a_full_one_and_the_rest():
    assert split(IMU) == [IMU[:8], IMU[8:]]


def test_a_short_frame_is_one():
    assert split(bytes(8)) == [bytes(8)]


def test_two_halves_are_the_frame(joiner):
    assert joiner.receive(111, IMU[:8], now=1.0) is None
    assert joiner.deadline == pytest.approx(1.02)
    assert joiner.receive(111, IMU[8:], now=1.019) == IMU
    assert (joiner.deadline, joiner.dropped) == (None, 0)


def test_a_first_half_waits_20_ms(joiner):
    joiner.receive(111, IMU[:8], now=1.0)
    joiner.expire(now=1.0199)
    assert joiner.dropped == 0
    joiner.expire(now=1.0201)
    assert (joiner.deadline, joiner.dropped) == (None, 1)


def test_a_second_half_that_comes_too_late_is_dropped_too(joiner):
    joiner.receive(111, IMU[:8], now=1.0)
    assert joiner.receive(111, IMU[8:], now=1.03) is None
    assert joiner.dropped == 2


def test_a_second_half_alone_is_dropped(joiner):
    assert joiner.receive(111, IMU[8:], now=1.0) is None
    assert joiner.dropped == 1


def test_a_first_half_takes_the_place_of_an_older_one(joiner):
    joiner.receive(111, bytes(8), now=1.0)
    joiner.receive(111, IMU[:8], now=1.01)
    assert joiner.receive(111, IMU[8:], now=1.02) == IMU
    assert joiner.dropped == 1


def test_halves_of_wrong_lengths_are_dropped_both(joiner):
    joiner.receive(111, IMU[:8], now=1.0)
    assert joiner.receive(111, b"123", now=1.001) is None
    assert joiner.dropped == 2


def test_frames_of_other_identifiers_do_not_meet(joiner):
    joiner.receive(111, IMU[:8], now=1.0)
    joiner.receive(160, bytes(8), now=1.001)
    assert joiner.receive(160, b"ab", now=1.002) == bytes(8) + b"ab"
    assert joiner.receive(111, IMU[8:], now=1.003) == IMU


def test_an_identifier_that_is_not_segmented_joins_nothing(joiner):
    joiner.receive(112, bytes(8), now=1.0)
    assert joiner.receive(112, b"abcd", now=1.0) is None
    assert joiner.dropped == 2
