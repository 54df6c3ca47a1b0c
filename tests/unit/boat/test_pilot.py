"""The pilot as the stations see it, rule by rule (spec/boat.md)."""

import pytest

from timonel.core.alerts import AlertChanged, Alerts
from timonel.core.effects import Event, Refused
from timonel.vehicles.boat.alerts import BACKBONE_SILENT, HEADING_LOST, PILOT_NOT_FOLLOWING, PILOT_SILENT
from timonel.vehicles.boat.pilot import Manner, Mode, Pilot, PilotChanged, PilotReport, Steer, same_course, tenths

HOLD, STANDBY, TRACK, ALARM, UNKNOWN = (
    Mode.HEADING_HOLD,
    Mode.STANDBY,
    Mode.TRACK,
    Mode.ALARM,
    Mode.UNKNOWN,
)


class Boat:
    """A pilot with the alerts it raises, and a short way of saying what the bus does."""

    def __init__(self) -> None:
        self.alerts = Alerts()
        self.pilot = Pilot(self.alerts, now=0.0)

    def lives(self, now: float, heading: float | None = 90.0) -> list[Event]:
        """A frame comes in, and with it a heading."""
        effects = self.pilot.bus_heard(now)
        return effects if heading is None else effects + self.pilot.heading_heard(heading, now)

    def engaged(self, now: float = 1.0, heading: float = 90.0) -> "Boat":
        self.lives(now, heading)
        assert self.pilot.engage(1, now)[-1] == Steer(tenths(heading))
        return self

    def silent_from(self, start: float) -> "Boat":
        self.lives(start)
        self.pilot.expire(start + 3.0)
        assert self.pilot.mode is ALARM
        return self


def steers(effects: list[Event]) -> list[int | None]:
    return [effect.setpoint for effect in effects if isinstance(effect, Steer)]


def alerts(effects: list[Event]) -> list[tuple[str, bool]]:
    return [(e.alert.kind.name, e.alert.active) for e in effects if isinstance(e, AlertChanged)]


def shown(pilot: Pilot) -> tuple[Mode, int | None]:
    return pilot.mode, pilot.setpoint


# Commands ---------------------------------------------------------------------------------------------------


def test_at_power_on_the_pilot_stands_by():
    assert shown(Boat().pilot) == (STANDBY, 0)


def test_engage_holds_the_present_heading():
    boat = Boat()
    boat.lives(1.0, heading=182.4985)
    assert boat.pilot.engage(1, 1.0) == [PilotChanged(HOLD, 1825), Steer(1825)]
    assert shown(boat.pilot) == (HOLD, 1825)


def test_a_command_is_pending_until_the_pilot_reports_that_it_does():
    boat = Boat()
    assert not boat.pilot.pending
    boat.engaged()
    assert boat.pilot.pending
    boat.pilot.reported(PilotReport(HOLD, 900), 1.2)
    assert not boat.pilot.pending


@pytest.mark.parametrize(("degrees", "expected"), [(359.97, 0), (0.04, 0), (359.94, 3599), (0.05001, 1)])
def test_a_course_is_rounded_to_a_tenth_and_never_three_hundred_and_sixty(degrees: float, expected: int):
    assert tenths(degrees) == expected


def test_engage_needs_a_heading_younger_than_three_seconds():
    boat = Boat()
    assert boat.pilot.engage(2, 0.0) == [Refused("no heading", 2)]
    boat.lives(1.0)
    assert boat.pilot.heading(3.999) == 90.0
    assert boat.pilot.heading(4.0) is None
    assert boat.pilot.engage(2, 4.0) == [Refused("no heading", 2)]
    assert boat.pilot.mode is STANDBY


def test_disengage_stands_by_from_every_mode():
    boat = Boat().engaged()
    assert boat.pilot.disengage(2.0) == [PilotChanged(STANDBY, 0), Steer(None)]
    assert boat.pilot.disengage(3.0) == [PilotChanged(STANDBY, 0), Steer(None)]
    assert shown(boat.pilot) == (STANDBY, 0)


def test_set_points_wrap():
    boat = Boat().engaged(heading=359.5)
    assert steers(boat.pilot.turn(10, 1, 2.0)) == [5]
    assert steers(boat.pilot.turn(-100, 1, 3.0)) == [3505]
    assert steers(boat.pilot.set_heading(3700, 1, 4.0)) == [100]
    assert steers(boat.pilot.set_heading(-100, 1, 5.0)) == [3500]


def test_in_standby_nothing_turns():
    boat = Boat()
    boat.lives(1.0)
    assert boat.pilot.set_heading(1200, 1, 1.0) == [Refused("not in heading hold", 1)]
    assert boat.pilot.turn(10, 1, 1.0) == [Refused("no set point", 1)]
    assert shown(boat.pilot) == (STANDBY, 0)


def test_in_track_nothing_turns_but_engage_takes_over_at_the_present_heading():
    boat = Boat()
    boat.lives(1.0)
    boat.pilot.reported(PilotReport(TRACK, 450), 1.0)
    assert shown(boat.pilot) == (TRACK, 450)
    assert boat.pilot.set_heading(1200, 1, 1.0) == [Refused("not in heading hold", 1)]
    assert boat.pilot.turn(10, 1, 1.0) == [Refused("not in heading hold", 1)]
    assert steers(boat.pilot.engage(1, 1.0)) == [900]


def test_a_held_heading_that_nobody_told_can_be_set_but_not_turned():
    boat = Boat()
    boat.lives(1.0)
    boat.pilot.reported(PilotReport(HOLD), 1.0)
    assert shown(boat.pilot) == (HOLD, None)
    assert boat.pilot.turn(10, 1, 1.0) == [Refused("no set point", 1)]
    assert steers(boat.pilot.set_heading(1200, 1, 1.0)) == [1200]


# Repetition -------------------------------------------------------------------------------------------------


def test_while_engaged_the_course_is_repeated_every_second():
    boat = Boat().engaged(now=1.0)
    boat.lives(1.9)
    assert boat.pilot.deadline == 2.0
    assert boat.pilot.expire(1.99) == []
    assert boat.pilot.expire(2.0) == [Steer(900)]
    boat.lives(3.0)
    assert boat.pilot.expire(2.99) == []
    assert boat.pilot.expire(3.0) == [Steer(900)]
    assert boat.pilot.deadline == 4.0


def test_a_stop_is_repeated_once_and_then_rests():
    boat = Boat().engaged(now=1.0)
    boat.pilot.disengage(1.5)
    boat.lives(2.5)
    assert boat.pilot.expire(2.5) == [Steer(None)]
    boat.lives(3.6)
    assert boat.pilot.expire(3.6) == []
    assert boat.pilot.deadline == 6.6


def test_a_pilot_that_follows_is_repeated_to():
    boat = Boat().engaged(now=1.0)
    assert boat.pilot.reported(PilotReport(HOLD, 900), 1.2) == []
    boat.lives(2.0)
    assert boat.pilot.expire(2.0) == [Steer(900)]


def test_a_course_set_at_the_pilots_own_head_is_shown_and_no_longer_repeated():
    boat = Boat().engaged(now=1.0)
    boat.pilot.reported(PilotReport(HOLD, 900), 1.2)
    assert boat.pilot.reported(PilotReport(HOLD, 1000), 1.5) == [PilotChanged(HOLD, 1000)]
    boat.lives(2.0)
    assert boat.pilot.expire(2.0) == []
    assert steers(boat.pilot.turn(10, 1, 2.1)) == [1010]
    boat.lives(3.1)
    assert boat.pilot.expire(3.1) == [Steer(1010)]


def test_a_pilot_that_rounds_the_course_is_still_ours():
    boat = Boat().engaged(now=1.0, heading=90.4)
    assert boat.pilot.reported(PilotReport(HOLD, 900), 1.2) == [PilotChanged(HOLD, 900)]
    boat.lives(2.0)
    assert boat.pilot.expire(2.0) == [Steer(900)]


def test_a_pilot_that_holds_without_saying_what_is_taken_to_hold_ours_but_not_repeated_to_for_ever():
    boat = Boat().engaged(now=1.0)
    assert boat.pilot.reported(PilotReport(HOLD), 1.2) == []
    assert shown(boat.pilot) == (HOLD, 900)
    boat.lives(2.0)
    assert boat.pilot.expire(2.0) == [Steer(900)]


@pytest.mark.parametrize(
    ("a", "b", "same"),
    [(0, 5, True), (0, 6, False), (3599, 4, True), (3599, 5, False), (5, 0, True), (0, 1800, False)],
)
def test_half_a_degree_is_the_same_course(a: int, b: int, same: bool):
    assert same_course(a, b) is same


# What the pilot reports -------------------------------------------------------------------------------------


def test_the_pilots_report_is_the_truth():
    boat = Boat()
    boat.lives(1.0)
    assert boat.pilot.reported(PilotReport(HOLD, 450), 1.0) == [PilotChanged(HOLD, 450)]
    assert boat.pilot.reported(PilotReport(HOLD, 450), 1.1) == []
    assert boat.pilot.reported(PilotReport(STANDBY, 450), 1.2) == [PilotChanged(STANDBY, 0)]
    assert boat.pilot.reported(PilotReport(STANDBY, 460), 1.3) == []


def test_a_mode_that_is_not_understood_is_shown_as_unknown():
    boat = Boat()
    boat.pilot.reported(PilotReport(UNKNOWN), 1.0)
    assert shown(boat.pilot) == (UNKNOWN, None)


def test_a_report_without_a_mode_says_nothing():
    boat = Boat().engaged()
    boat.pilot.reported(PilotReport(HOLD, 900), 1.2)
    assert boat.pilot.reported(PilotReport(None, 450), 1.3) == []
    assert shown(boat.pilot) == (HOLD, 900)


def test_a_course_that_the_pilot_holds_of_itself_is_not_repeated():
    boat = Boat()
    boat.lives(1.0)
    boat.pilot.reported(PilotReport(HOLD, 450), 1.0)
    boat.lives(3.0)
    assert boat.pilot.expire(3.0) == []


def test_until_a_command_is_two_seconds_old_other_reports_do_not_count():
    boat = Boat()
    boat.lives(1.0)
    boat.pilot.reported(PilotReport(STANDBY), 1.0)
    boat.pilot.engage(1, 1.0)
    assert boat.pilot.reported(PilotReport(STANDBY), 1.1) == []
    assert boat.pilot.mode is HOLD
    assert boat.pilot.reported(PilotReport(HOLD, 900), 1.4) == []
    assert boat.pilot.reported(PilotReport(STANDBY), 1.5) == [PilotChanged(STANDBY, 0)]


def test_a_course_not_yet_followed_is_not_confirmed():
    boat = Boat().engaged(now=1.0)
    boat.pilot.reported(PilotReport(HOLD, 900), 1.2)
    boat.pilot.turn(100, 1, 1.5)
    assert boat.pilot.reported(PilotReport(HOLD, 900), 1.6) == []
    assert shown(boat.pilot) == (HOLD, 1000)


# Pilot not following ----------------------------------------------------------------------------------------


def not_following() -> Boat:
    boat = Boat()
    boat.lives(1.0)
    boat.pilot.reported(PilotReport(STANDBY), 1.0)
    boat.pilot.engage(1, 1.0)
    boat.lives(2.9)
    boat.pilot.expire(2.0)
    boat.pilot.reported(PilotReport(STANDBY), 2.9)
    return boat


def test_a_pilot_that_does_not_engage_within_two_seconds_raises_an_alert_and_is_let_go():
    boat = not_following()
    assert boat.pilot.expire(2.99) == []
    effects = boat.pilot.expire(3.0)
    assert alerts(effects) == [("pilot not following", True)]
    assert effects[1:] == [PilotChanged(STANDBY, 0), Steer(None)]
    boat.lives(5.0)
    assert boat.pilot.expire(5.0) == []


def test_the_alert_names_what_was_not_followed():
    boat = not_following()
    boat.pilot.expire(3.0)
    assert boat.alerts.standing[0].text == "engage not followed for 2 s"
    boat.pilot.reported(PilotReport(HOLD, 900), 4.0)
    boat.pilot.disengage(4.1)
    boat.lives(6.0)
    boat.alerts.acknowledge(PILOT_NOT_FOLLOWING.id)
    boat.alerts.rectify(PILOT_NOT_FOLLOWING)
    boat.pilot.reported(PilotReport(HOLD, 900), 6.0)
    effects = boat.pilot.expire(6.1)
    assert boat.alerts.standing[0].text == "standby not followed for 2 s"
    assert effects[-1] == PilotChanged(HOLD, 900), "a pilot that will not let go is not shown as standing by"


def test_a_command_that_is_followed_rectifies_the_alert():
    boat = not_following()
    boat.pilot.expire(3.0)
    boat.lives(4.0)
    boat.pilot.engage(1, 4.0)
    assert alerts(boat.pilot.reported(PilotReport(HOLD, 900), 4.2)) == [("pilot not following", False)]


def test_a_course_not_followed_is_given_up_for_what_the_pilot_holds():
    boat = Boat().engaged(now=1.0)
    boat.pilot.reported(PilotReport(HOLD, 900), 1.1)
    boat.pilot.turn(100, 1, 1.5)
    boat.lives(3.4)
    boat.pilot.reported(PilotReport(HOLD, 900), 3.4)
    effects = boat.pilot.expire(3.5)
    assert alerts(effects) == [("pilot not following", True)]
    assert shown(boat.pilot) == (HOLD, 900)
    assert boat.pilot.deadline > 4.5, "somebody else's course is not repeated"


def test_a_pilot_that_was_never_heard_raises_no_alert():
    boat = Boat().engaged(now=1.0)
    boat.lives(2.9)
    assert boat.pilot.expire(3.0) == [Steer(900)]
    assert shown(boat.pilot) == (HOLD, 900)


def test_a_pilot_that_fell_silent_before_the_command_leaves_the_command_standing():
    boat = Boat()
    boat.pilot.reported(PilotReport(STANDBY), 0.0)
    boat.engaged(now=2.0)
    boat.lives(3.9)
    effects = boat.pilot.expire(4.0)
    assert alerts(effects) == [("pilot not following", True)]
    assert shown(boat.pilot) == (HOLD, 900)


# Pilot silent -----------------------------------------------------------------------------------------------


def alive_until(boat: Boat, start: int, end: int) -> list[Event]:
    effects: list[Event] = []
    for now in range(start, end + 1):
        effects += boat.lives(float(now)) + boat.pilot.expire(float(now))
    return effects


def test_a_pilot_that_stops_reporting_raises_an_alert_and_its_course_is_no_longer_known():
    boat = Boat()
    boat.lives(0.0)
    boat.pilot.reported(PilotReport(HOLD, 450), 0.0)
    assert alive_until(boat, 1, 9) == []
    assert alerts(alive_until(boat, 10, 10)) == [("pilot silent", True)]
    assert shown(boat.pilot) == (UNKNOWN, None)
    assert alerts(boat.pilot.reported(PilotReport(HOLD, 450), 11.0)) == [("pilot silent", False)]
    assert shown(boat.pilot) == (HOLD, 450)


def test_our_own_course_stays_shown_when_the_pilot_stops_reporting():
    boat = Boat().engaged(now=1.0)
    boat.pilot.reported(PilotReport(HOLD, 900), 1.0)
    effects = alive_until(boat, 2, 11)
    assert alerts(effects) == [("pilot silent", True)]
    assert shown(boat.pilot) == (HOLD, 900)


def test_a_silent_pilot_that_stood_by_still_stands_by():
    boat = Boat()
    boat.lives(0.0)
    boat.pilot.reported(PilotReport(STANDBY), 0.0)
    assert alerts(alive_until(boat, 1, 10)) == [("pilot silent", True)]
    assert shown(boat.pilot) == (STANDBY, 0)


def test_a_silent_backbone_is_not_blamed_on_the_pilot():
    boat = Boat()
    boat.lives(0.0)
    boat.pilot.reported(PilotReport(STANDBY), 0.0)
    assert alerts(boat.pilot.expire(3.0)) == [("backbone silent", True)]
    assert boat.pilot.expire(15.0) == []
    boat.lives(20.0)
    boat.pilot.reported(PilotReport(STANDBY), 20.5)
    assert alive_until(boat, 21, 30) == []
    assert alerts(alive_until(boat, 31, 31)) == [("pilot silent", True)]


def test_after_a_silent_backbone_the_pilot_has_its_whole_time_to_report():
    boat = Boat()
    boat.lives(0.0)
    boat.pilot.reported(PilotReport(STANDBY), 0.0)
    boat.pilot.expire(3.0)
    boat.lives(20.0)
    boat.pilot.disengage(20.0)
    assert alerts(alive_until(boat, 21, 29)) == [("pilot not following", True)]
    assert alerts(alive_until(boat, 30, 30)) == [("pilot silent", True)]


# Backbone silent --------------------------------------------------------------------------------------------


def test_a_backbone_silent_for_three_seconds_is_an_alarm():
    boat = Boat().engaged(now=1.0)
    boat.lives(1.5)
    assert boat.pilot.expire(4.49) != boat.pilot.expire(4.5)
    assert boat.alerts.active(BACKBONE_SILENT)
    assert boat.pilot.mode is ALARM


def test_silence_is_noticed_at_its_third_second():
    boat = Boat()
    boat.lives(1.0, heading=None)
    assert boat.pilot.deadline == 4.0
    assert boat.pilot.expire(3.99) == []
    effects = boat.pilot.expire(4.0)
    assert alerts(effects) == [("backbone silent", True)]
    assert effects[-1] == PilotChanged(ALARM, 0)
    assert boat.pilot.expire(5.0) == []
    assert boat.pilot.deadline == float("inf")


def test_a_gateway_that_never_hears_a_backbone_alarms_too():
    assert alerts(Boat().pilot.expire(3.0)) == [("backbone silent", True)]


def test_in_alarm_the_held_set_point_stays_readable():
    boat = Boat().engaged(now=1.0).silent_from(1.0)
    assert shown(boat.pilot) == (ALARM, 900)


def test_in_alarm_steering_is_refused():
    boat = Boat().engaged(now=1.0).silent_from(1.0)
    assert boat.pilot.engage(1, 4.0) == [Refused("alarm", 1)]
    assert boat.pilot.set_heading(100, 1, 4.0) == [Refused("not in heading hold", 1)]
    assert boat.pilot.turn(10, 1, 4.0) == [Refused("not in heading hold", 1)]
    assert shown(boat.pilot) == (ALARM, 900)


def test_in_alarm_nothing_is_repeated():
    boat = Boat().engaged(now=1.0).silent_from(1.0)
    assert boat.pilot.expire(9.0) == []


def test_in_alarm_disengage_stands_by_in_one_step_and_is_sent_again_when_the_backbone_is_back():
    boat = Boat().engaged(now=1.0).silent_from(1.0)
    assert boat.pilot.disengage(5.0) == [PilotChanged(STANDBY, 0), Steer(None)]
    assert boat.pilot.mode is STANDBY
    boat.pilot.expire(7.0)
    assert steers(boat.lives(9.0)) == [None]
    assert steers(boat.lives(9.1)) == []


def test_a_disengage_that_the_backbone_heard_is_not_owed():
    boat = Boat().engaged(now=1.0)
    boat.pilot.disengage(2.0)
    boat.silent_from(2.0)
    assert steers(boat.lives(9.0)) == []


def test_when_data_is_back_without_a_pilots_report_the_boat_stands_by_and_the_pilot_is_told():
    boat = Boat().engaged(now=1.0).silent_from(1.0)
    effects = boat.lives(6.0)
    assert alerts(effects) == [("backbone silent", False)]
    assert effects[1:] == [PilotChanged(STANDBY, 0), Steer(None)]
    boat.lives(7.0)
    assert boat.pilot.expire(7.0) == [], "it never re-engages by itself"


def test_a_boat_that_stood_by_all_along_sends_nothing_when_the_backbone_is_back():
    boat = Boat().silent_from(1.0)
    assert steers(boat.lives(6.0)) == []
    assert boat.pilot.mode is STANDBY


def reporting_pilot_then_silence() -> Boat:
    boat = Boat().engaged(now=1.0)
    boat.pilot.reported(PilotReport(HOLD, 900), 1.0)
    return boat.silent_from(1.0)


def test_a_pilot_heard_before_has_a_second_to_report_when_data_is_back():
    boat = reporting_pilot_then_silence()
    assert boat.lives(6.0)[1:] == []
    assert boat.pilot.mode is ALARM
    assert boat.pilot.reported(PilotReport(HOLD, 950), 6.3) == [PilotChanged(HOLD, 950)]
    boat.lives(8.0)
    assert boat.pilot.expire(8.0) == [], "the course is the pilot's now, not ours"


def test_a_pilot_that_does_not_report_in_that_second_is_told_to_stand_by():
    boat = reporting_pilot_then_silence()
    boat.lives(6.0)
    assert boat.pilot.deadline == 7.0
    assert boat.pilot.expire(6.99) == []
    assert boat.pilot.expire(7.0) == [PilotChanged(STANDBY, 0), Steer(None)]


def test_a_report_that_tells_no_mode_does_not_end_the_alarm_in_heading_hold():
    boat = reporting_pilot_then_silence()
    boat.lives(6.0)
    assert boat.pilot.reported(PilotReport(None, 950), 6.3) == [PilotChanged(STANDBY, 0), Steer(None)]


def test_disengage_during_that_second_counts():
    boat = reporting_pilot_then_silence()
    boat.lives(6.0)
    boat.pilot.disengage(6.2)
    assert boat.pilot.reported(PilotReport(HOLD, 900), 6.3) == []
    assert boat.pilot.mode is STANDBY


# Heading lost -----------------------------------------------------------------------------------------------


def heading_lost(report: PilotReport | None = None) -> Boat:
    boat = Boat().engaged(now=1.0)
    if report is not None:
        boat.pilot.reported(PilotReport(HOLD, 900), 1.0)
    boat.lives(3.9, heading=None)
    boat.pilot.expire(2.0)
    boat.pilot.expire(3.0)
    if report is not None:
        boat.pilot.reported(report, 3.9)
    return boat


def test_a_heading_lost_for_three_seconds_while_holding_one_is_an_alarm():
    boat = heading_lost()
    assert boat.pilot.deadline == 4.0
    assert boat.pilot.expire(3.99) == []
    effects = boat.pilot.expire(4.0)
    assert alerts(effects) == [("heading lost", True)]
    assert effects[-1] == PilotChanged(ALARM, 900)


def test_a_heading_lost_in_standby_is_no_alarm():
    boat = Boat()
    boat.lives(1.0)
    boat.lives(5.0, heading=None)
    assert boat.pilot.expire(5.0) == []


def test_a_pilot_that_holds_a_heading_we_never_saw_is_no_alarm():
    boat = Boat()
    boat.lives(1.0, heading=None)
    boat.pilot.reported(PilotReport(HOLD, 450), 1.0)
    boat.lives(6.0, heading=None)
    assert boat.pilot.expire(6.0) == []
    assert shown(boat.pilot) == (HOLD, 450)


def test_when_the_heading_is_back_the_boat_stands_by_unless_the_pilot_reports():
    boat = heading_lost()
    boat.pilot.expire(4.0)
    effects = boat.lives(5.0)
    assert alerts(effects) == [("heading lost", False)]
    assert effects[1:] == [PilotChanged(STANDBY, 0), Steer(None)]


def test_when_the_heading_is_back_the_mode_is_what_the_pilot_reports():
    boat = heading_lost(PilotReport(HOLD, 900))
    boat.pilot.expire(4.0)
    assert boat.lives(5.0)[1:] == [PilotChanged(HOLD, 900)]
    boat.lives(6.5)
    assert boat.pilot.expire(6.5) == [], "it never re-engages by itself"


def test_a_pilot_that_gave_up_when_the_heading_went_stands_by():
    boat = heading_lost(PilotReport(HOLD, 900))
    boat.pilot.expire(4.0)
    assert boat.pilot.reported(PilotReport(STANDBY), 4.5) == []
    assert boat.pilot.mode is ALARM
    assert boat.lives(5.0)[1:] == [PilotChanged(STANDBY, 0)]


def test_a_pilot_that_holds_on_is_not_believed_before_the_heading_is_back():
    boat = reporting_pilot_then_silence()
    boat.lives(6.0, heading=None)
    effects = boat.pilot.reported(PilotReport(HOLD, 900), 6.2)
    assert alerts(effects) == [("heading lost", True)]
    assert boat.pilot.mode is ALARM
    assert boat.lives(7.0)[1:] == [PilotChanged(HOLD, 900)]


def test_heading_and_backbone_lost_together_must_both_be_back():
    boat = Boat().engaged(now=1.0)
    boat.lives(1.5, heading=None)
    assert alerts(boat.pilot.expire(4.0)) == [("heading lost", True)]
    assert alerts(boat.pilot.expire(4.5)) == [("backbone silent", True)]
    boat.lives(6.0, heading=None)
    assert boat.pilot.mode is ALARM
    boat.lives(6.1)
    assert boat.pilot.mode is STANDBY


def test_disengage_ends_the_alarm_of_a_lost_heading():
    boat = heading_lost()
    boat.pilot.expire(4.0)
    effects = boat.pilot.disengage(4.5)
    assert alerts(effects) == [("heading lost", False)]
    assert boat.pilot.mode is STANDBY
    assert not boat.alerts.active(HEADING_LOST)


def test_in_alarm_a_report_is_kept_but_not_shown():
    boat = heading_lost()
    boat.pilot.expire(4.0)
    assert boat.pilot.reported(PilotReport(TRACK, 100), 4.1) == []
    assert boat.pilot.mode is ALARM
    assert PILOT_SILENT not in [alert.kind for alert in boat.alerts.standing]


# At the boundary --------------------------------------------------------------------------------------------


def test_the_modes_are_the_words_of_status():
    assert [mode.value for mode in Mode] == ["STANDBY", "HEADING_HOLD", "TRACK", "ALARM", ""]


def test_a_report_three_seconds_old_is_no_report_when_a_command_was_not_followed():
    boat = Boat()
    boat.pilot.reported(PilotReport(STANDBY), 1.0)
    boat.engaged(now=2.0)
    boat.lives(3.9)
    boat.pilot.expire(4.0)
    assert shown(boat.pilot) == (HOLD, 900)


def test_a_report_three_seconds_old_is_no_report_when_data_is_back():
    boat = Boat().engaged(now=1.0)
    boat.pilot.reported(PilotReport(HOLD, 900), 1.0)
    boat.pilot.expire(4.0)
    boat.pilot.reported(PilotReport(HOLD, 900), 4.5)
    boat.lives(7.5)
    assert boat.pilot.mode is ALARM, "it has a second to report"


def test_a_pilot_that_was_let_go_is_not_told_so_after_every_silence():
    boat = Boat().engaged(now=1.0).silent_from(1.0)
    assert steers(boat.lives(6.0)) == [None]
    boat.lives(7.0)
    boat.silent_from(7.0)
    assert steers(boat.lives(12.0)) == []


def test_alerts_say_what_is_wrong():
    boat = Boat().engaged(now=1.0)
    boat.pilot.reported(PilotReport(HOLD, 900), 1.0)
    for now in (2.0, 3.0, 4.0):
        boat.lives(now, heading=None)
        boat.pilot.expire(now)
    alive_until(boat, 5, 11)
    boat.pilot.expire(14.0)
    assert {alert.text for alert in boat.alerts.standing} == {
        "no heading for 3 s while holding one",
        "the pilot has not reported for 10 s",
        "nothing heard from the backbone for 3 s",
    }


# Drivers ----------------------------------------------------------------------------------------------------


def test_a_course_that_the_driver_objects_to_is_refused_with_its_reason():
    boat = Boat()
    boat.lives(1.0)
    asked = []
    boat.pilot.objection = lambda setpoint, now: asked.append((setpoint, now)) or "no pilot found on the bus"
    assert boat.pilot.engage(2, 1.0) == [Refused("no pilot found on the bus", 2)]
    boat.pilot.objection = None
    boat.pilot.engage(2, 1.0)
    boat.pilot.objection = lambda setpoint, now: asked.append((setpoint, now)) or "too far"
    assert boat.pilot.set_heading(3700, 2, 1.5) == [Refused("too far", 2)]
    assert boat.pilot.turn(-1000, 2, 1.5) == [Refused("too far", 2)]
    assert asked == [(900, 1.0), (100, 1.5), (3500, 1.5)]
    assert shown(boat.pilot) == (HOLD, 900)


def test_a_driver_that_objects_to_everything_does_not_keep_anybody_from_letting_go():
    boat = Boat().engaged()
    boat.pilot.objection = lambda setpoint, now: "never"
    assert steers(boat.pilot.disengage(2.0)) == [None]


def adopting():
    boat = Boat()
    boat.pilot.adopts = True
    return boat


def test_a_pilot_that_chooses_its_own_course_is_engaged_as_soon_as_it_says_so():
    boat = adopting().engaged()
    assert boat.pilot.manner is Manner.ENGAGE
    boat.pilot.reported(PilotReport(HOLD, None), 1.1)
    assert not boat.pilot.pending
    boat.pilot.reported(PilotReport(HOLD, 927), 1.2)
    assert shown(boat.pilot) == (HOLD, 927)
    assert boat.pilot.expire(3.5) == []  # its course is its own: nothing is repeated


def test_such_a_pilot_that_holds_a_heading_already_is_brought_to_the_present_one():
    boat = adopting()
    boat.lives(0.5)
    boat.pilot.reported(PilotReport(HOLD, 800), 0.5)
    boat.engaged()
    assert boat.pilot.manner is Manner.COURSE
    boat.pilot.reported(PilotReport(HOLD, 800), 1.1)
    assert boat.pilot.pending


def test_a_course_of_such_a_pilot_is_confirmed_only_by_a_course_that_is_told():
    boat = adopting().engaged()
    boat.pilot.set_heading(1000, 1, 1.2)
    boat.pilot.reported(PilotReport(HOLD, None), 1.3)
    assert boat.pilot.pending
    boat.pilot.reported(PilotReport(HOLD, 1003), 1.4)
    assert not boat.pilot.pending


def test_every_step_that_is_followed_gives_two_more_seconds():
    boat = adopting().engaged()
    boat.pilot.reported(PilotReport(HOLD, 900), 1.1)
    boat.pilot.set_heading(1300, 1, 1.2)
    boat.pilot.progressed(2.5)
    boat.lives(3.0)
    assert alerts(boat.pilot.expire(3.3)) == []
    boat.lives(4.0)
    assert alerts(boat.pilot.expire(4.5)) == [("pilot not following", True)]
    boat.pilot.progressed(4.6)
    assert not boat.pilot.pending


def test_what_is_given_up_is_told_with_its_reason_and_the_report_is_the_truth():
    boat = adopting().engaged()
    boat.pilot.reported(PilotReport(HOLD, 900), 1.1)
    boat.pilot.set_heading(1300, 1, 1.2)
    boat.pilot.reported(PilotReport(HOLD, 950), 1.3)
    effects = boat.pilot.gave_up("another course was set elsewhere", 1.4)
    (told,) = [effect.alert.text for effect in effects if isinstance(effect, AlertChanged)]
    assert told == "engage not followed: another course was set elsewhere"
    assert shown(boat.pilot) == (HOLD, 950)
    assert boat.pilot.gave_up("again", 1.5) == []


def test_what_is_said_again_is_said_to_be():
    boat = Boat().engaged()
    assert boat.pilot.manner is Manner.COURSE
    assert steers(boat.pilot.expire(2.0)) == [900]
    assert boat.pilot.manner is Manner.REPEAT
    boat.pilot.disengage(2.1)
    assert boat.pilot.manner is Manner.COURSE


def test_a_backbone_that_may_be_missing_is_missed_only_after_it_was_heard():
    boat = Boat()
    boat.pilot.expect_no_bus()
    assert boat.pilot.deadline == float("inf")
    assert boat.pilot.expire(1e6) == []
    boat.silent_from(1e6)
