"""Every driver against a pilot that answers as its maker's pilots do: engaged, turned, let go, and what goes wrong."""

from itertools import pairwise

import pytest

from tests.unit.boat.pilots.at_sea import AtSea, apart
from timonel.core.frame import Frame
from timonel.nmea0183.parp import Verb
from timonel.nmea2000.identifier import join
from timonel.nmea2000.lookups import HeadingReference
from timonel.nmea2000.messages.network import IsoAddressClaim
from timonel.vehicles.boat.pilot import Mode
from timonel.vehicles.boat.simulated_pilots import DIALECTS
from timonel.vehicles.boat.simulator import COMPASS

STEERED = ("groupfunction", "raymarine", "raymarine-spx", "navico", "garmin", "sentence")
HEARD = tuple(kind for kind in STEERED if kind != "sentence")
ADOPTING = ("raymarine", "raymarine-spx", "navico", "garmin")
STEPPING = ("navico", "garmin")
KEEP_ALIVE = {65384, 126720, 65305}

every_driver = pytest.mark.parametrize("kind", STEERED)
every_heard = pytest.mark.parametrize("kind", HEARD)
every_adopting = pytest.mark.parametrize("kind", ADOPTING)
every_stepping = pytest.mark.parametrize("kind", STEPPING)


def orders(afloat, since=0):
    """What went to the pilot beside what shows that a control head is there."""
    shown = ("3b9f0000", "3b9ff0819000", "419f6403", "419f640b", "419f0103", "419f010b", "e5981017040415")
    steered = [payload for _, pgn, _, payload in afloat.sent if pgn in (126208, 126720, 130850, 65384, 65305)]
    return [payload for payload in steered[since:] if not payload.hex().startswith(shown)]


def test_there_is_a_simulated_pilot_for_every_driver_but_the_standards_own():
    assert set(STEERED) == set(DIALECTS)


# As it should go --------------------------------------------------------------------------------------


@every_driver
def test_a_pilot_is_engaged_turned_by_ten_degrees_settles_and_stands_by(kind):
    afloat = AtSea(kind).in_command()
    assert afloat.refusals(afloat.say(Verb.ENGAGE)) == []
    afloat.until(lambda: afloat.dialect.law.engaged, within=0.2)
    afloat.run(1.5)
    assert (afloat.mode, afloat.alerts) == (Mode.HEADING_HOLD, [])
    assert apart(afloat.setpoint, 45) <= 0.2
    assert apart(afloat.held, 45) <= 0.2
    wanted = (afloat.setpoint + 10) % 360
    assert afloat.refusals(afloat.say(Verb.STBDTEN)) == []
    afloat.run(2.0)
    assert apart(afloat.held, wanted) <= 0.5
    afloat.run(15.0)
    assert (afloat.mode, afloat.alerts) == (Mode.HEADING_HOLD, [])
    assert apart(afloat.setpoint, wanted) <= 0.5
    assert apart(afloat.heading, wanted) <= 1.0
    afloat.say(Verb.DISENGAGE)
    afloat.until(lambda: not afloat.dialect.law.engaged, within=0.2)
    afloat.run(2.0)
    assert (afloat.mode, afloat.alerts) == (Mode.STANDBY, [])


@every_driver
def test_a_course_to_port_across_north_is_come_to(kind):
    afloat = AtSea(kind).engaged()
    for degrees in (20.0, 355.0):
        assert afloat.refusals(afloat.say(Verb.SETHEADING, degrees)) == []
        afloat.run(6.0)
        assert apart(afloat.held, degrees) <= 0.6
        assert apart(afloat.setpoint, degrees) <= 0.5
        assert afloat.alerts == []


@every_driver
def test_a_boat_that_counts_from_magnetic_north_steers_the_same_course(kind):
    afloat = AtSea(kind, heading_reference="magnetic").engaged()
    assert apart(afloat.setpoint, 45 - 2.1) <= 0.2
    afloat.say(Verb.STBDTEN)
    afloat.run(3.0)
    assert apart(afloat.held, 55) <= 0.6
    assert afloat.alerts == []


@every_driver
def test_after_a_course_is_held_the_pilot_hears_only_that_we_are_there(kind):
    afloat = AtSea(kind).engaged()
    afloat.say(Verb.STBDTEN)
    afloat.run(4.0)
    before = len(orders(afloat))
    afloat.run(10.0)
    said = orders(afloat)[before:]
    if kind in ADOPTING:
        assert said == []
    assert apart(afloat.held, 55) <= 0.6


# Who may ----------------------------------------------------------------------------------------------


@every_driver
def test_a_station_that_is_not_in_command_makes_no_driver_send_anything(kind):
    afloat = AtSea(kind).in_command()
    before = len(afloat.sent), len(afloat.lines)
    for verb in (Verb.ENGAGE, Verb.SETHEADING, Verb.STBDTEN, Verb.PORTONE, Verb.DISENGAGE):
        assert afloat.refusals(afloat.say(verb, 120.0, station=2)) == ["not in command"]
    assert len(afloat.sent) == before[0]
    assert not any("HTC" in line for line in afloat.lines[before[1] :])
    assert not afloat.dialect.law.engaged


@every_driver
def test_before_anybody_commands_it_no_driver_says_a_word(kind):
    afloat = AtSea(kind).run(20.0)
    assert afloat.sent == []
    assert not any("HTC" in line for line in afloat.lines)


@every_adopting
def test_when_command_is_given_up_the_pilot_keeps_its_course_and_hears_only_that_we_are_there(kind):
    afloat = AtSea(kind).engaged()
    afloat.say(Verb.RELCMD)
    before = len(orders(afloat))
    held = afloat.held
    afloat.run(15.0)
    assert orders(afloat)[before:] == []
    assert afloat.dialect.law.engaged
    assert afloat.held == held


@every_stepping
def test_a_course_that_is_still_being_approached_is_left_where_it_is_when_command_is_given_up(kind):
    afloat = AtSea(kind).engaged()
    afloat.say(Verb.SETHEADING, 45.0 + 90.0)
    afloat.run(0.15)
    afloat.say(Verb.RELCMD)
    before = len(orders(afloat))
    afloat.run(8.0)
    assert orders(afloat)[before:] == []
    assert apart(afloat.held, 135) > 45
    assert apart(afloat.setpoint, afloat.held) <= 0.5
    assert "pilot not following" in afloat.alerts


@every_stepping
def test_the_same_when_command_passes_to_another_station(kind):
    afloat = AtSea(kind).in_command()
    afloat.say(Verb.RELCMD)
    afloat.say(Verb.REQCMD, station=2)
    afloat.say(Verb.ENGAGE, station=2)
    afloat.run(2.0)
    afloat.say(Verb.SETHEADING, 135.0, station=2)
    afloat.run(0.15)
    afloat.say(Verb.TAKECMD)
    before = len(orders(afloat))
    afloat.run(8.0)
    assert orders(afloat)[before:] == []
    assert apart(afloat.held, 135) > 45


# Which pilot ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", HEARD)
def test_a_pilot_that_is_not_on_the_bus_is_not_engaged_but_standby_is_sent_to_everybody_at_once(kind):
    afloat = AtSea(kind)
    afloat.silent = True
    afloat.in_command()
    assert afloat.refusals(afloat.say(Verb.ENGAGE)) == ["no pilot found on the bus"]
    assert orders(afloat) == []
    afloat.say(Verb.DISENGAGE)
    assert len(orders(afloat)) == 1
    assert [destination for _, pgn, destination, _ in afloat.sent if pgn != 65305][-1] == 255


def second_pilot(afloat, address=77):
    claim = next(device.claim for device in afloat.boat.devices if device.address == afloat.dialect.address)
    fields = {name: getattr(claim, name) for name in claim.__struct_fields__} | {"unique_number": 4711}
    return IsoAddressClaim(**fields), address


@pytest.mark.parametrize("kind", ["groupfunction", "raymarine", "navico", "garmin"])
def test_of_two_pilots_none_is_engaged_until_the_owner_says_which(kind):
    afloat = AtSea(kind).in_command()
    claim, address = second_pilot(afloat)
    afloat.boat.receive_frames([Frame(join(6, 60928, address), claim.encode())], afloat.now)
    assert afloat.refusals(afloat.say(Verb.ENGAGE)) == ["several pilots on the bus: pilot_name says which"]
    name = next(device.name for device in afloat.boat.devices if device.address == afloat.dialect.address)
    chosen = AtSea(kind, pilot_name=f"0x{name:016X}").in_command()
    chosen.boat.receive_frames([Frame(join(6, 60928, address), claim.encode())], chosen.now)
    assert chosen.refusals(chosen.say(Verb.ENGAGE)) == []
    chosen.run(1.0)
    assert chosen.dialect.law.engaged


@pytest.mark.parametrize("kind", HEARD)
def test_a_pilot_that_moves_to_another_address_is_told_there(kind):
    afloat = AtSea(kind)
    afloat.dialect.address = 17
    afloat.sea.__init__(dialect=afloat.dialect, heading=0.785)
    afloat.in_command().say(Verb.ENGAGE)
    afloat.run(2.0)
    assert afloat.dialect.law.engaged
    assert afloat.mode is Mode.HEADING_HOLD


# What the pilot does otherwise -------------------------------------------------------------------------


@every_heard
def test_a_pilot_that_refuses_to_engage_is_shown_as_it_is_after_two_seconds_with_an_alert(kind):
    afloat = AtSea(kind).in_command()
    afloat.dialect.refuses = True
    afloat.say(Verb.ENGAGE)
    assert afloat.mode is Mode.HEADING_HOLD
    afloat.run(1.9)
    assert afloat.alerts == []
    afloat.run(0.2)
    assert afloat.alerts == ["pilot not following"]
    afloat.run(2.0)
    assert afloat.mode in (Mode.STANDBY, Mode.UNKNOWN)
    before = len(orders(afloat))
    afloat.run(10.0)
    assert [order for order in orders(afloat)[before:] if order != orders(afloat)[-1]] == []
    assert not afloat.dialect.law.engaged


@every_heard
def test_a_pilot_that_obeys_nobody_raises_the_alert_and_is_not_shown_at_a_course_it_has_not(kind):
    afloat = AtSea(kind).engaged()
    afloat.deaf = True
    held = afloat.held
    afloat.say(Verb.STBDTEN)
    afloat.run(3.0)
    assert afloat.alerts == ["pilot not following"]
    afloat.run(2.0)
    assert apart(afloat.setpoint, held) <= 0.5


@every_heard
def test_a_pilot_that_falls_silent_raises_an_alert(kind):
    afloat = AtSea(kind).engaged()
    afloat.silent = True
    afloat.run(11.0)
    assert "pilot silent" in afloat.alerts
    afloat.silent = False
    afloat.run(2.0)
    assert "pilot silent" not in afloat.alerts
    assert afloat.mode is Mode.HEADING_HOLD


@every_heard
def test_what_another_control_head_sets_is_shown_and_not_fought_over(kind):
    afloat = AtSea(kind).engaged()
    afloat.another_head_turns(-20.0).run(2.0)
    assert apart(afloat.setpoint, 25) <= 0.5
    before = len(orders(afloat))
    afloat.run(10.0)
    assert orders(afloat)[before:] == []
    assert apart(afloat.held, 25) <= 0.5
    assert afloat.alerts == []


@every_stepping
def test_a_course_on_the_way_is_given_up_when_another_control_head_sets_another(kind):
    afloat = AtSea(kind).engaged()
    afloat.say(Verb.SETHEADING, 165.0)
    afloat.run(0.3)
    afloat.another_head_turns(-35.0).run(1.0)
    before, held = len(orders(afloat)), afloat.held
    afloat.run(6.0)
    assert orders(afloat)[before:] == []
    assert afloat.held == held
    assert "pilot not following" in afloat.alerts
    assert apart(afloat.setpoint, held) <= 0.5


@every_stepping
def test_a_step_that_the_pilot_does_not_follow_is_not_taken_again(kind):
    afloat = AtSea(kind).engaged()
    afloat.deaf = True
    before = len(orders(afloat))
    afloat.say(Verb.SETHEADING, 135.0)
    afloat.run(5.0)
    afloat.deaf = False
    afloat.run(5.0)
    assert len(orders(afloat)) == before + 1
    assert apart(afloat.held, 45) <= 0.5


@every_heard
def test_a_pilot_that_lets_go_by_itself_is_shown_standing_by_and_not_engaged_again(kind):
    afloat = AtSea(kind).engaged()
    afloat.dialect.let_go()
    afloat.sea.tell(afloat.dialect._mode() if kind == "garmin" else afloat.dialect.told())
    afloat.run(3.0)
    assert afloat.mode is Mode.STANDBY
    afloat.run(10.0)
    assert not afloat.dialect.law.engaged


@every_heard
def test_commands_one_after_the_other_without_waiting_end_at_the_last_course(kind):
    afloat = AtSea(kind).in_command()
    afloat.say(Verb.ENGAGE)
    for _ in range(3):
        afloat.say(Verb.STBDTEN)
    afloat.run(6.0)
    assert apart(afloat.held, 75) <= 0.6
    assert apart(afloat.setpoint, 75) <= 0.5
    assert afloat.alerts == []


@every_heard
def test_a_boat_whose_heading_is_lost_stops_steering_to_a_course(kind):
    afloat = AtSea(kind).engaged()
    afloat.say(Verb.SETHEADING, 74.0)
    afloat.muted.add(COMPASS)
    afloat.run(4.0)
    assert afloat.mode is Mode.ALARM
    before = len(orders(afloat))
    assert afloat.refusals(afloat.say(Verb.STBDTEN)) != []
    afloat.run(2.0)
    assert orders(afloat)[before:] == []
    afloat.say(Verb.DISENGAGE)
    assert len(orders(afloat)) == before + 1


# What cannot be known -----------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["raymarine", "raymarine-spx"])
def test_without_variation_a_true_course_is_refused_to_a_pilot_that_counts_from_magnetic_north(kind):
    afloat = AtSea(kind)
    afloat.sea._due = [
        [(source, build) for source, build in due if build.__name__ != "_variation"] for due in afloat.sea._due
    ]
    afloat.in_command()
    assert afloat.refusals(afloat.say(Verb.ENGAGE)) == [
        "no magnetic variation: the pilot's courses cannot be told from ours"
    ]
    assert orders(afloat) == []


def test_a_navico_pilot_that_counts_from_true_north_needs_no_variation_for_a_true_course():
    afloat = AtSea("navico")
    afloat.sea._due = [
        [(source, build) for source, build in due if build.__name__ != "_variation"] for due in afloat.sea._due
    ]
    afloat.in_command().say(Verb.ENGAGE)
    afloat.run(2.0)
    afloat.say(Verb.STBDTEN)
    afloat.run(3.0)
    assert apart(afloat.held, 55) <= 0.6


def test_a_navico_pilot_whose_reference_needs_variation_is_not_turned_without_it():
    afloat = AtSea("navico")
    afloat.dialect.reference = afloat.dialect.law.reference = HeadingReference.MAGNETIC
    afloat.sea._due = [
        [(source, build) for source, build in due if build.__name__ != "_variation"] for due in afloat.sea._due
    ]
    afloat.in_command().say(Verb.ENGAGE)
    afloat.run(3.0)
    assert afloat.dialect.law.engaged
    before = len(orders(afloat))
    assert afloat.refusals(afloat.say(Verb.STBDTEN)) != []
    assert orders(afloat)[before:] == []


def test_a_garmin_pilot_that_was_never_heard_standing_by_is_not_turned():
    afloat = AtSea("garmin")
    afloat.dialect.law.hold(0.5, HeadingReference.MAGNETIC)
    afloat.in_command()
    assert afloat.mode is Mode.UNKNOWN
    refused = afloat.refusals(afloat.say(Verb.ENGAGE))
    assert refused == ["the pilot's courses cannot be told from ours: they were not heard while it stood by"]
    assert orders(afloat) == []
    afloat.say(Verb.DISENGAGE)
    afloat.run(2.5)
    assert not afloat.dialect.law.engaged
    assert afloat.refusals(afloat.say(Verb.ENGAGE)) == []


def test_a_converters_pilot_refuses_to_be_turned_by_more_than_thirty_degrees_at_once():
    afloat = AtSea("raymarine-spx").engaged()
    before = len(orders(afloat))
    assert afloat.refusals(afloat.say(Verb.SETHEADING, 76.0)) == ["more than 30 degrees at once"]
    assert orders(afloat)[before:] == []
    assert afloat.refusals(afloat.say(Verb.SETHEADING, 74.0)) == []
    afloat.run(2.0)
    assert apart(afloat.held, 74) <= 0.5


# Being there --------------------------------------------------------------------------------------------


def test_a_navico_pilot_that_we_engaged_does_not_let_go_for_want_of_a_control_head():
    afloat = AtSea("navico").engaged()
    afloat.say(Verb.RELCMD)
    afloat.run(30.0)
    assert afloat.dialect.law.engaged
    asked = [(when, payload[3]) for when, pgn, _, payload in afloat.sent if pgn == 65305]
    assert [report for _, report in asked] == [3, 11] * (len(asked) // 2)
    assert 30 <= len(asked) // 2 <= 34


def test_a_simulated_navico_pilot_lets_go_when_nobody_asks_for_its_state():
    afloat = AtSea("navico").engaged()
    afloat.deaf = True
    afloat.run(11.0)
    assert not afloat.dialect.law.engaged


@pytest.mark.parametrize(("kind", "pgn", "interval"), [("raymarine", 65384, 1.0), ("raymarine", 126720, 2.0),
                                                       ("garmin", 126720, 2.1)])  # fmt: skip
def test_a_control_head_shows_that_it_is_there(kind, pgn, interval):
    afloat = AtSea(kind).engaged()
    afloat.run(20.0)
    times = [when for when, sent, _, payload in afloat.sent if sent == pgn and orders_not(payload)]
    gaps = [round(later - earlier, 2) for earlier, later in pairwise(times)]
    assert set(gaps) <= {interval, round(interval + 0.05, 2), round(interval - 0.05, 2)}
    assert len(gaps) >= 20 / interval - 2


def orders_not(payload):
    return payload.hex().startswith(("3b9f0000", "3b9ff0819000", "e5981017040415"))


# Again ---------------------------------------------------------------------------------------------------


@every_driver
def test_the_same_day_gives_the_same_bytes(kind):
    days = []
    for _ in range(2):
        afloat = AtSea(kind).engaged()
        afloat.say(Verb.SETHEADING, 70.0)
        afloat.run(3.0).say(Verb.DISENGAGE)
        days.append(afloat.run(1.0).effects)
    assert days[0] == days[1]
