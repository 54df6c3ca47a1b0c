"""What drivers do in corners that a day at sea seldom has."""

import pytest

from tests.unit.boat.pilots.at_sea import AtSea
from timonel.nmea0183.parp import Verb
from timonel.nmea2000.devices import Devices
from timonel.nmea2000.lookups import HeadingReference
from timonel.vehicles.boat.pilot import Manner, Mode, PilotReport
from timonel.vehicles.boat.pilots import Wanted, choose
from timonel.vehicles.boat.pilots.driver import NEVER, Compass, Driver
from timonel.vehicles.boat.pilots.engaged import ByCourse, BySteps, EngagedPilot
from timonel.vehicles.boat.pilots.finder import Finder
from timonel.vehicles.boat.reports import Reading
from timonel.vehicles.boat.settings import BoatSettings

TRUE = HeadingReference.TRUE
ON_THE_BUS = ("groupfunction", "raymarine", "raymarine-spx", "navico", "garmin")
COMPASS = Compass(TRUE, lambda angle, reference, now: angle, lambda angle, reference, now: angle)


def alone(kind):
    """A driver on a bus without a pilot."""
    return choose(BoatSettings(pilot=kind), Devices(), COMPASS).driver


@pytest.mark.parametrize("kind", ON_THE_BUS)
@pytest.mark.parametrize("manner", [Manner.ENGAGE, Manner.COURSE, Manner.REPEAT])
def test_a_pilot_that_vanished_after_the_command_was_accepted_is_told_nothing(kind, manner):
    assert list(alone(kind).steer(900, 90.0, 0.0, manner)) == []


@pytest.mark.parametrize("kind", ON_THE_BUS)
def test_a_pilot_that_vanished_is_let_go_by_a_word_to_everybody(kind):
    (release,) = alone(kind).steer(None, 90.0, 0.0, Manner.COURSE)
    assert release.destination == 255


@pytest.mark.parametrize("kind", ["raymarine", "raymarine-spx"])
def test_a_pilot_that_vanished_while_it_held_a_course_is_told_no_other(kind):
    assert alone(kind).set_course(900) == []


@pytest.mark.parametrize("kind", ["navico", "garmin"])
def test_no_step_is_under_way_to_a_pilot_that_vanished(kind):
    assert alone(kind).change(100) == (0, [])


def test_a_garmin_pilot_that_vanished_hears_no_heartbeat():
    assert alone("garmin").show(0) == []


@pytest.mark.parametrize("kind", ["standard", "sentence"])
def test_drivers_that_tell_everybody_object_to_nothing_and_owe_nothing(kind):
    driver = alone(kind)
    assert driver.objection(900, 0.0) is None
    assert driver.deadline == NEVER
    assert list(driver.expire(0.0)) == list(driver.passed()) == []
    report = PilotReport(Mode.STANDBY)
    assert list(driver.reported(None, Reading(Mode.STANDBY), report, True, 0.0)) == []  # type: ignore[arg-type]
    assert driver.hear(Reading(Mode.HEADING_HOLD, 1.5, TRUE), None, 0.0) == 1.5


def test_a_driver_must_say_how_it_steers():
    finder = Finder(Devices(), Wanted())
    bare = EngagedPilot(finder, COMPASS)
    for missing in (
        lambda: Driver().steer(None, None, 0.0, Manner.COURSE),
        lambda: Driver().hear(Reading(None), None, 0.0),
        bare.engage,
        bare.release,
        lambda: bare.proceed(0, 0),
        lambda: ByCourse(finder, COMPASS).set_course(0),
        lambda: BySteps(finder, COMPASS).change(0),
    ):
        with pytest.raises(NotImplementedError):
            missing()
    assert bare.show(0) == []


def test_a_garmin_pilot_that_told_no_heading_has_no_course():
    garmin = alone("garmin")
    assert garmin.hear(Reading(Mode.HEADING_HOLD), 90.0, 0.0) is None
    assert garmin.hear(Reading(Mode.HEADING_HOLD, 1.0), 90.0, 0.0) is None
    garmin.hear(Reading(Mode.STANDBY, 1.0), 90.0, 0.1)
    garmin.hear(Reading(Mode.STANDBY, 1.0), None, 0.2)
    assert garmin.hear(Reading(Mode.HEADING_HOLD), 90.0, 0.3) == pytest.approx(1.5707963)
    assert garmin.hear(Reading(Mode.UNKNOWN, 1.0), 90.0, 0.4) is None


def test_buttons_pressed_one_after_the_other_are_not_the_stream_of_a_garmin_pilot_that_stands_by():
    garmin = alone("garmin")
    for press in range(9):
        garmin.hear(Reading(Mode.UNKNOWN, 1.0 + press / 57.3), 90.0, 0.4 * press)
    assert garmin.theirs(900, 4.0) is None
    for _ in range(3):
        garmin.hear(Reading(Mode.UNKNOWN, 1.0), 90.0, 3.5)
    assert garmin.theirs(900, 4.0) is not None


def test_a_converters_pilot_that_holds_a_course_it_does_not_tell_is_not_turned():
    afloat = AtSea("raymarine-spx").engaged()
    driver = afloat.boat.steering.driver
    driver._course = None
    assert driver.objection(500, afloat.now) == "the pilot does not tell its course"


def test_the_loop_catches_up_with_a_control_head_that_was_late():
    afloat = AtSea("navico").engaged()
    driver = afloat.boat.steering.driver
    answers = driver.expire(afloat.now + 100.0)
    assert len(answers) == 2
    assert driver.deadline == afloat.now + 100.0
    assert list(driver.expire(afloat.now + 99.0)) == []


def test_a_course_that_is_not_followed_at_once_is_said_again_where_it_is_the_same_course():
    afloat = AtSea("raymarine").engaged()
    afloat.deaf = True
    before = len(afloat.commands(126208))
    afloat.say(Verb.STBDTEN)
    afloat.run(1.5)
    said = afloat.commands(126208)[before:]
    assert len(said) == 2
    assert len(set(said)) == 1
