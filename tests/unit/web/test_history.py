"""The last hour at 1 Hz."""

import pytest

from timonel.web.history import History


def filled(samples: int, seconds: int) -> History:
    history = History(("depth", "latitude"), samples)
    for second in range(seconds):
        history.take({"depth": float(second), "latitude": 39.5000123}, 100.0 + second)
    return history


def test_the_newest_samples_are_kept_oldest_first() -> None:
    assert filled(10, 4).last("depth", 600) == [0.0, 1.0, 2.0, 3.0]
    assert filled(10, 25).last("depth", 600) == [float(second) for second in range(15, 25)]
    assert filled(10, 25).last("depth", 3) == [22.0, 23.0, 24.0]


def test_every_so_many_th_ends_with_the_newest() -> None:
    assert filled(10, 25).last("depth", 10, step=4) == [16.0, 20.0, 24.0]
    assert filled(10, 25).last("depth", 10, step=3600) == [24.0]


def test_there_is_nothing_before_the_first() -> None:
    assert filled(10, 0).last("depth", 10) == []


def test_what_is_not_known_is_null() -> None:
    history = filled(10, 1)
    history.take({"depth": None}, 101.0)
    assert history.last("depth", 10) == [0.0, None]
    assert history.last("latitude", 10) == [39.5000123, None]


@pytest.mark.parametrize(("pause", "empty"), [(1.4, 0), (3.0, 2), (1000.0, 9)])
def test_seconds_that_were_missed_are_empty(pause: float, empty: int) -> None:
    history = filled(10, 5)
    history.take({"depth": 7.0}, 104.0 + pause)
    assert history.last("depth", 1 + empty) == [None] * empty + [7.0]


def test_an_hour_of_everything_is_small() -> None:
    history = History([f"value{number}" for number in range(40)])
    assert sum(ring.itemsize * len(ring) for ring in history._rings.values()) < 1_000_000


def test_a_copy_stays_as_it_was() -> None:
    history = filled(10, 5)
    copy = history.copy()
    history.take({"depth": 99.0}, 105.0)
    assert copy.last("depth", 1) == [4.0]
    assert copy.ended == 104.0
