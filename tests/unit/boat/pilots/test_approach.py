"""The way to a course step by step: every line of its rule table, and nothing else."""

import pytest

from timonel.vehicles.boat.pilot import Mode
from timonel.vehicles.boat.pilots.approach import LET_GO, OTHER_HEAD, Approach, difference


def under_way(target=900, before=450, step=100):
    """Engaged, with a step on its way."""
    approach = Approach()
    approach.begin(target, engaged=True)
    approach.step(before, step)
    return approach


@pytest.mark.parametrize(("a", "b", "apart"), [(10, 3590, 20), (3590, 10, -20), (1800, 0, -1800), (500, 400, 100)])
def test_a_difference_goes_the_short_way_round(a, b, apart):
    assert difference(a, b) == apart


def test_nothing_is_under_way_at_first():
    approach = Approach()
    assert (approach.active, approach.stepping, approach.left(450)) == (False, False, 0)
    assert approach.end() is False


@pytest.mark.parametrize("mode", [Mode.STANDBY, Mode.TRACK, Mode.UNKNOWN, None])
def test_a_pilot_that_is_not_engaged_yet_is_waited_for(mode):
    approach = Approach()
    approach.begin(900, engaged=False)
    assert approach.report_mode(mode) is None
    assert (approach.active, approach.engaged) == (True, False)


def test_a_pilot_that_reports_heading_hold_is_engaged():
    approach = Approach()
    approach.begin(900, engaged=False)
    assert approach.report_mode(Mode.HEADING_HOLD) is None
    assert approach.engaged


@pytest.mark.parametrize("mode", [Mode.STANDBY, Mode.TRACK, Mode.UNKNOWN])
def test_a_pilot_that_lets_go_ends_the_way(mode):
    approach = under_way()
    assert approach.report_mode(mode) == LET_GO
    assert not approach.active
    assert not approach.stepping


def test_a_report_without_a_mode_changes_nothing():
    approach = under_way()
    assert approach.report_mode(None) is None
    assert approach.active


@pytest.mark.parametrize("course", [450, 453, 446])
def test_the_course_as_before_the_step_is_waited_for(course):
    approach = under_way()
    assert approach.report_course(course) is None
    assert approach.stepping


@pytest.mark.parametrize("course", [550, 546, 555])
def test_the_course_as_the_step_should_make_it_is_progress(course):
    approach = under_way()
    assert approach.report_course(course) is None
    assert not approach.stepping
    assert approach.active


@pytest.mark.parametrize("course", [500, 460, 540, 570, 350, 2250])
def test_any_other_course_ends_the_way(course):
    approach = under_way()
    assert approach.report_course(course) == OTHER_HEAD
    assert not approach.active


@pytest.mark.parametrize(("step", "waits", "follows"), [(6, 452, 455), (-6, 448, 445), (10, 455 - 1, 459)])
def test_a_small_step_is_told_from_none(step, waits, follows):
    approach = under_way(before=450, step=step)
    assert approach.report_course(waits) is None
    assert approach.stepping
    assert approach.report_course(follows) is None
    assert not approach.stepping


def test_a_course_without_a_step_under_way_is_nobodys_fault():
    approach = Approach()
    approach.begin(900, engaged=True)
    assert approach.report_course(123) is None
    assert approach.active


@pytest.mark.parametrize(("course", "left"), [(900, 0), (905, 0), (895, 0), (894, 6), (800, 100), (1000, -100)])
def test_what_is_left_is_nothing_within_half_a_degree(course, left):
    approach = Approach()
    approach.begin(900, engaged=True)
    assert approach.left(course) == left


def test_a_pilot_that_is_only_to_be_engaged_has_nothing_left():
    approach = Approach()
    approach.begin(None, engaged=True)
    assert approach.left(450) == 0


def test_a_new_aim_waits_for_the_step_that_is_under_way():
    approach = under_way()
    approach.begin(1200, engaged=True)
    assert approach.stepping
    assert approach.report_course(550) is None
    assert approach.left(550) == 650


def test_a_new_aim_of_a_pilot_that_is_to_be_engaged_anew_forgets_the_step():
    approach = under_way()
    approach.begin(1200, engaged=False)
    assert not approach.stepping
