"""The drives, rule by rule (spec/rover.md, Driving)."""

import pytest

from tests.recordings import vectors
from timonel.core.effects import Event, Refused
from timonel.vehicles.rover.drive import STANDSTILL, Drive, Permission, Stick, Stop, Wheels, mixed

FORWARD = Stick(0, -100)
REST = Stick(0, 0)


def permitted(now: float = 0.0) -> Drive:
    drive = Drive(now)
    drive.heard(now)
    assert drive.permit(1, now) == [Permission(True, "station 1")]
    return drive


def said(effects: list[Event]) -> list[Wheels]:
    return [effect for effect in effects if isinstance(effect, Wheels)]


def driving(now: float = 0.0) -> Drive:
    drive = permitted(now)
    assert said(drive.stick(FORWARD, 1, now)) == [Wheels(100, 100)]
    return drive


def timeline(drive: Drive, until: float) -> list[tuple[float, Wheels]]:
    """What the wheels are told up to `until`, if nobody says anything more."""
    wheels = []
    while drive.deadline <= until:
        now = drive.deadline
        wheels += [(now, one) for one in said(drive.expire(now))]
    return wheels


# Mixing -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("stick", "limit", "wheels"),
    [
        (FORWARD, 20, Wheels(100, 100)),
        (Stick(0, 100), 20, Wheels(-100, -100)),
        (Stick(100, 0), 20, Wheels(100, -100)),
        (Stick(50, -100), 20, Wheels(100, 50)),
        (Stick(35, -35), 20, Wheels(70, 0)),
        (FORWARD, 10, Wheels(50, 50)),
        (FORWARD, 1, Wheels(5, 5)),
        (Stick(0, -99), 1, Wheels(4, 4)),
        (Stick(0, 99), 1, Wheels(-4, -4)),
    ],
)
def test_the_stick_is_mixed_clamped_and_limited(stick: Stick, limit: int, wheels: Wheels):
    assert mixed(stick, limit) == wheels


def test_the_mixer_gives_the_values_of_the_specification():
    import json

    lines = [json.loads(line) for line in vectors("rover_values.jsonl").read_text().splitlines()]
    cases = [line for line in lines if line["frame"] == 100]
    assert len(cases) > 5
    for case in cases:
        assert mixed(Stick(case["y"], case["x"]), 20) == Wheels(case["left_pct"], case["right_pct"])


# Permission ---------------------------------------------------------------------------------------


def test_nothing_moves_without_permission():
    drive = Drive(0.0)
    assert drive.stick(FORWARD, 1, 0.0) == []
    assert drive.wheels(0.0) == STANDSTILL


def test_permission_needs_the_stick_at_rest():
    drive = Drive(0.0)
    drive.stick(Stick(0, -1), 1, 0.0)
    assert drive.permit(1, 0.0) == [Refused("stick not at rest", 1)]
    drive.stick(Stick(1, 0), 1, 0.1)
    assert drive.permit(1, 0.1) == [Refused("stick not at rest", 1)]
    drive.stick(REST, 1, 0.2)
    assert drive.permit(1, 0.2) == [Permission(True, "station 1")]


def test_permission_once_given_is_not_given_again():
    assert permitted().permit(1, 0.1) == []


def test_a_stop_withdraws_permission_and_says_so_once():
    drive = driving()
    assert drive.stop(Stop.ORDERED, 0.1) == [Permission(False, "a station ordered a stop"), STANDSTILL]
    assert drive.stop(Stop.ORDERED, 0.2) == [STANDSTILL]
    assert drive.stick(FORWARD, 1, 0.3) == []


@pytest.mark.parametrize(
    ("reason", "told"),
    [
        (Stop.ROVER_SILENT, "the rover fell silent"),
        (Stop.UNPLUGGED, "the link of the commander was unplugged"),
    ],
)
def test_a_stop_says_why(reason: Stop, told: str):
    assert driving().stop(reason, 0.1) == [Permission(False, told), STANDSTILL]


def test_who_still_pushes_the_stick_after_a_stop_is_not_permitted():
    drive = driving()
    drive.stop(Stop.ORDERED, 0.1)
    assert drive.permit(1, 0.2) == [Refused("stick not at rest", 1)]


def test_a_new_commander_is_not_answerable_for_the_old_ones_stick():
    drive = driving()
    assert drive.passes(0.1) == [Permission(False, "command passed"), STANDSTILL]
    assert drive.permit(2, 0.2) == [Permission(True, "station 2")]
    assert drive.wheels(0.2) == STANDSTILL


# Values -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stick", [Stick(101, 0), Stick(-101, 0), Stick(0, 101), Stick(0, -101), Stick(127, -128)])
def test_a_stick_out_of_range_is_refused_and_moves_nothing(stick: Stick):
    drive = permitted()
    assert drive.stick(stick, 1, 0.0) == [Refused("stick out of range", 1)]
    assert drive.wheels(0.0) == STANDSTILL


def test_the_edges_of_the_range_are_within():
    drive = permitted()
    assert drive.stick(Stick(100, -100), 1, 0.0) == [Wheels(100, 0)]
    assert drive.stick(Stick(-100, 100), 1, 0.1) == [Wheels(-100, 0)]


@pytest.mark.parametrize("limit", [0, 21, 255])
def test_a_limit_out_of_range_is_refused(limit: int):
    drive = driving()
    assert drive.limit(limit, 1) == [Refused("limit out of range", 1)]
    assert drive.wheels(0.0) == Wheels(100, 100)


def test_a_limit_counts_from_the_next_set_point():
    drive = driving()
    assert drive.limit(20, 1) == drive.limit(1, 1) == []
    assert drive.wheels(0.0) == Wheels(5, 5)


# The ladder ---------------------------------------------------------------------------------------


def test_a_stick_two_hundred_milliseconds_old_is_zero_at_once_and_permission_stays():
    drive = driving()
    drive.heard(0.19)
    wheels = timeline(drive, 0.3)
    assert [one for now, one in wheels if now < 0.2] == [Wheels(100, 100)] * 9
    assert wheels[9][0] == 0.2
    assert {one for now, one in wheels[9:]} == {STANDSTILL}
    assert drive.permitted


def test_a_fresh_stick_moves_on_after_a_stale_one():
    drive = driving()
    drive.heard(0.3)
    timeline(drive, 0.3)
    assert said(drive.stick(FORWARD, 1, 0.35)) == [Wheels(100, 100)]


def test_a_commander_silent_for_half_a_second_loses_permission():
    drive = driving()
    timeline(drive, 0.4999)
    assert drive.permitted
    assert drive.expire(0.5) == [Permission(False, "the commander fell silent"), STANDSTILL]
    assert not drive.permitted


def test_who_speaks_keeps_permission():
    drive = driving()
    for step in range(1, 20):
        drive.heard(step / 10)
        timeline(drive, step / 10)
    assert drive.permitted


def test_silence_counts_for_the_set_points_even_before_anybody_looks():
    drive = driving()
    assert drive.wheels(0.19) == Wheels(100, 100)
    assert drive.wheels(0.2) == STANDSTILL
    drive.stick(FORWARD, 1, 0.4)
    assert drive.wheels(0.49) == Wheels(100, 100)
    assert drive.wheels(0.5) == STANDSTILL, "nobody was heard for half a second"


def test_a_stick_is_as_old_as_its_bytes():
    drive = permitted()
    drive.stick(FORWARD, 1, 0.10, age=0.05)
    assert drive.wheels(0.24) == Wheels(100, 100)
    assert drive.wheels(0.25) == STANDSTILL


def test_silence_counts_from_the_bytes_that_were_heard_last():
    drive = permitted()
    drive.heard(0.3, age=0.1)
    assert drive.expire(0.69)[-1] == STANDSTILL
    assert drive.permitted
    assert drive.expire(0.7) == [Permission(False, "the commander fell silent"), STANDSTILL]


# Repetition ---------------------------------------------------------------------------------------


def test_while_permitted_the_wheels_are_told_fifty_times_a_second():
    drive = permitted()
    times = []
    for step in range(10):
        drive.heard(step / 10)
        times += [now for now, _ in timeline(drive, (step + 1) / 10)]
    assert 48 <= len(times) <= 51


def test_a_fifty_hertz_stick_is_passed_on_at_once_and_nothing_between():
    drive = permitted()
    told = []
    for step in range(50):
        now = step * 0.02
        drive.heard(now)
        told += [(now, one) for one in said(drive.stick(Stick(step, 0), 1, now))]
        timeline_until = now + 0.019
        told += timeline(drive, timeline_until)
    assert [one.left for _, one in told] == list(range(50))


def test_a_faster_stick_is_held_to_fifty_hertz():
    drive = permitted()
    told = 0
    for step in range(1000):
        now = step / 1000
        drive.heard(now)
        told += len(timeline(drive, now)) + len(said(drive.stick(FORWARD, 1, now)))
    assert told <= 52


def test_a_stop_is_repeated_fast_at_first_and_for_ever_after():
    drive = driving()
    drive.stop(Stop.ORDERED, 1.0)
    times = [round(now, 3) for now, one in timeline(drive, 3.0) if one == STANDSTILL]
    assert len([now for now in times if now <= 1.5]) >= 24
    assert times[-1] - times[-2] == pytest.approx(0.2)
    assert times[-1] > 2.79


def test_half_a_second_after_a_stop_its_repetition_slows_down():
    drive = driving()
    drive.stop(Stop.ORDERED, 1.0)
    drive.expire(1.49)
    assert drive.deadline == pytest.approx(1.51)
    drive.expire(1.5 + 0.02)
    assert drive.deadline == pytest.approx(1.72)


def test_the_burst_after_a_stop_ends_to_the_moment():
    drive = driving()
    drive.stop(Stop.ORDERED, 1.0)
    drive.expire(1.5)
    assert drive.deadline == pytest.approx(1.7)


def test_at_power_on_the_wheels_are_told_to_stand():
    drive = Drive(0.0)
    assert drive.deadline == 0.0
    assert drive.expire(0.0) == [STANDSTILL]
