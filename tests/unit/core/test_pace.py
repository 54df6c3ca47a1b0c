"""Rate ceilings."""

import random

from timonel.core.pace import Allowance, Pace


def ready(pace: Pace, now: float) -> bool:
    if not pace.open(now):
        return False
    pace.count(now)
    return True


def passed(pace: Pace, times: list[float]) -> int:
    return sum(ready(pace, time) for time in times)


def test_a_jittering_ten_hertz_source_comes_out_as_ten_hertz():
    jitter = random.Random(1)
    times = [step * 0.1 + jitter.uniform(-0.04, 0.04) for step in range(1000)]
    assert passed(Pace(0.1), times) == 1000


def test_a_source_slightly_fast_is_held_to_the_ceiling():
    assert 990 <= passed(Pace(0.1), [step / 10.5 for step in range(1050)]) <= 1001


def test_a_source_ten_times_too_fast_is_held_to_the_ceiling():
    assert passed(Pace(1.0), [step / 10 for step in range(1000)]) <= 101


def test_a_slow_source_is_never_held_back_and_saves_nothing_up():
    pace = Pace(0.1)
    assert ready(pace, 0.0)
    assert [ready(pace, 5.0), ready(pace, 5.01), ready(pace, 5.02), ready(pace, 5.03)] == [
        True,
        True,
        False,
        False,
    ]


def test_no_interval_is_no_ceiling():
    assert passed(Pace(0.0), [0.0] * 5) == 5


def test_an_allowance_counts_what_lies_within_the_window():
    allowance = Allowance(2)
    assert [allowance.take(t) for t in (0.0, 0.5, 0.9, 1.0, 1.4, 1.5)] == [
        True,
        True,
        False,
        True,
        False,
        True,
    ]
