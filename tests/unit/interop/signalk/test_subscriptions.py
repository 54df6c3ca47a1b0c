"""A client is told what it wants, when it wants."""

import pytest

from timonel.interop.signalk.model import Model
from timonel.interop.signalk.subscriptions import EVERYTHING, ROWS_MAX, Policy, Row, Subscriptions, matches
from timonel.interop.signalk.told import Told

HEADING, DEPTH = "navigation.headingTrue", "environment.depth.belowTransducer"


def model() -> Model:
    made = Model()
    made.update([Told("heading", "s", 0.0, {HEADING: 1.0}), Told("depth", "s", 0.0, {DEPTH: 20.0})], 0.0)
    return made


def told_at(row: Row, *, changes: float, until: float = 5.0) -> list[float]:
    """When a heading that is new every so many seconds is told, looked at ten times a second."""
    made, wanted, times = Model(), Subscriptions(row), []
    for tick in range(round(until * 10)):
        now = tick / 10
        made.update([Told("heading", "s", now // changes * changes, {HEADING: 1.0})], now)
        if due := wanted.due(made, now):
            wanted.told(due, made, now)
            times.append(now)
    return times


@pytest.mark.parametrize(
    ("row", "changes", "times"),
    [
        (Row("*"), 2.0, [0, 2, 4]),
        (Row("*", policy="instant", min_period=1000), 0.1, [0, 1, 2, 3, 4]),
        (Row("*", period=2000), 0.1, [0, 2, 4]),
        (Row("*", policy="fixed"), 0.1, [0, 1, 2, 3, 4]),
        (Row("*", policy="fixed", period=1000), 10.0, [0, 1, 2, 3, 4]),
        (Row("*", policy="ideal", period=2000), 10.0, [0, 2, 4]),
        (Row("*", policy="ideal", min_period=1000, period=3000), 0.5, [0, 1, 2, 3, 4]),
    ],
)
def test_a_policy_says_when(row: Row, changes: float, times: list[float]) -> None:
    assert told_at(row, changes=changes) == pytest.approx(times)


@pytest.mark.parametrize(
    ("row", "how"),
    [(Row("*"), "instant"), (Row("*", period=1), "fixed"), (Row("*", period=1, policy="ideal"), "ideal")],
)
def test_a_row_without_a_policy_has_that_of_what_it_names(row: Row, how: Policy) -> None:
    assert row.how == how


def test_only_the_paths_that_fit_are_told() -> None:
    wanted = Subscriptions(Row("navigation.*"))
    assert wanted.due(model(), 0.0) == [HEADING]


def test_what_was_told_is_not_told_again_until_it_changes() -> None:
    wanted, known = Subscriptions(EVERYTHING), model()
    wanted.told(wanted.due(known, 0.0), known, 0.0)
    known.update([Told("heading", "s", 0.0, {HEADING: 1.0}), Told("depth", "s", 1.0, {DEPTH: 21.0})], 1.0)
    assert wanted.due(known, 1.0) == [DEPTH]


def test_what_could_not_be_told_stays_due() -> None:
    wanted, known = Subscriptions(EVERYTHING), model()
    assert wanted.due(known, 0.0) == wanted.due(known, 0.1) != []


def test_a_row_that_is_given_up_is_told_no_more() -> None:
    wanted = Subscriptions(Row("navigation.*"), Row("environment.*"))
    wanted.unsubscribe("navigation.*")
    assert wanted.due(model(), 0.0) == [DEPTH]
    wanted.unsubscribe("*")
    assert wanted.due(model(), 0.0) == []


def test_rows_can_be_added_up_to_a_limit() -> None:
    wanted = Subscriptions()
    assert wanted.due(model(), 0.0) == []
    assert wanted.subscribe([Row(HEADING)])
    assert wanted.due(model(), 0.0) == [HEADING]
    assert not wanted.subscribe([Row("*")] * ROWS_MAX)
    assert not wanted.everything


@pytest.mark.parametrize(
    ("pattern", "path", "fits"),
    [
        ("*", HEADING, True),
        (HEADING, HEADING, True),
        ("navigation.*", HEADING, True),
        ("navigation.*", DEPTH, False),
        ("*.headingTrue", HEADING, True),
        ("nav*ing*e", HEADING, True),
        ("nav*x*e", HEADING, False),
        ("navigation.headingTrue*headingTrue", HEADING, False),
        ("", HEADING, False),
        ("navigation", HEADING, False),
    ],
)
def test_a_star_is_any_number_of_characters(pattern: str, path: str, fits: bool) -> None:
    assert matches(pattern, path) is fits


def test_a_pattern_full_of_stars_takes_no_longer_than_the_path() -> None:
    class Counted(str):
        finds = 0

        def find(self, *about: object) -> int:  # type: ignore[override]
            Counted.finds += 1
            return super().find(*about)  # type: ignore[arg-type]

    assert not matches("a*" * 99 + "b*a", Counted("a" * 200))
    assert 0 < Counted.finds <= 100
