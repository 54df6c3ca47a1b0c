"""What became of a command."""

from timonel.core.alerts import Alerts
from timonel.core.command import CommandTransfer, Verb
from timonel.core.effects import Refused, Rejected, SecurityEvent
from timonel.vehicles.boat.pilot import Mode, Pilot, PilotReport
from timonel.web.outcome import CONFIRMED, Verdict, at_once, refused, request, steering


def engaged() -> Pilot:
    pilot = Pilot(Alerts(), now=0.0)
    pilot.heading_heard(90.0, 0.0)
    pilot.engage(1, 0.0)
    return pilot


def test_what_the_machine_says_against_it_is_the_refusal() -> None:
    assert refused([Refused("not in command", 3)], 3) == Verdict("refused", "not in command")
    assert refused([Refused("not in command", 2)], 3) is None, "of another station"
    assert refused([Rejected("too many commands")], 3) == Verdict("refused", "too many commands")
    assert refused([SecurityEvent("another station's id", "x")], 3) == Verdict("refused", "another station's id")


def test_a_course_is_confirmed_by_the_pilots_report() -> None:
    pilot = engaged()
    judge = steering(pilot, Mode.HEADING_HOLD, 0.0)
    assert judge(0.1) is None
    pilot.reported(PilotReport(Mode.STANDBY), 0.2)
    assert judge(0.2) is None, "an old report"
    pilot.reported(PilotReport(Mode.HEADING_HOLD, 900), 0.3)
    assert judge(0.3) == CONFIRMED


def test_a_course_that_nobody_reports_is_unconfirmed_after_two_seconds() -> None:
    judge = steering(engaged(), Mode.HEADING_HOLD, 0.0)
    assert judge(1.99) is None
    assert judge(2.0) == Verdict("unconfirmed", "the pilot has not confirmed")


def test_a_report_that_comes_too_late_confirms_nothing() -> None:
    pilot = engaged()
    pilot.expire(2.0)
    assert steering(pilot, Mode.HEADING_HOLD, 0.0)(2.05) == Verdict("unconfirmed", "the pilot has not confirmed")


def test_a_course_that_somebody_let_go_of_is_not_confirmed() -> None:
    pilot = engaged()
    judge = steering(pilot, Mode.HEADING_HOLD, 0.0)
    pilot.disengage(0.5)
    assert judge(0.6) == Verdict("unconfirmed", "something else was commanded")
    pilot.reported(PilotReport(Mode.STANDBY), 0.7)
    assert judge(0.8) == Verdict("unconfirmed", "the mode has changed")
    assert steering(pilot, Mode.STANDBY, 0.5)(0.8) == CONFIRMED


def test_an_alarm_confirms_no_course() -> None:
    pilot = engaged()
    pilot.bus_heard(0.0)
    pilot.expire(3.0)
    assert pilot.mode is Mode.ALARM
    assert steering(pilot, Mode.HEADING_HOLD, 2.0)(3.1) == Verdict("unconfirmed", "the mode has changed")


def test_a_request_waits_until_it_is_granted_or_denied() -> None:
    transfer = CommandTransfer()
    transfer.receive(Verb.REQUEST, 1, 0.0)
    assert request(transfer, 1)(0.0) == CONFIRMED
    for station in (2, 3):
        transfer.receive(Verb.REQUEST, station, 0.0)
    second, third = request(transfer, 2), request(transfer, 3)
    assert second(9.0) is None
    transfer.receive(Verb.DENY, 1, 9.0)
    assert second(9.0) == Verdict("refused", "denied")
    assert third(9.0) is None
    transfer.expire(19.0)
    assert third(19.0) == CONFIRMED


def test_what_shows_at_once_is_confirmed_at_once_or_not_within_two_seconds() -> None:
    holds: list[bool] = []
    judge = at_once(lambda: bool(holds), sent=5.0)
    assert judge(5.0) is None
    assert judge(7.0) == Verdict("unconfirmed")
    holds.append(True)
    assert judge(7.0) == CONFIRMED
    assert CONFIRMED.final
    assert not Verdict("sent").final
