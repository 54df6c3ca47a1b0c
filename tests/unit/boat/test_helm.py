"""The helm: whose word reaches the pilot."""

import pytest

from timonel.core.alerts import AlertChanged
from timonel.core.command import Denied, OnTimeout, Requested, Transferred
from timonel.core.effects import Event, Refused
from timonel.nmea0183.parp import Command, Verb
from timonel.vehicles.boat.alerts import NO_COMMANDER, PILOT_NOT_FOLLOWING
from timonel.vehicles.boat.helm import Helm
from timonel.vehicles.boat.pilot import Mode, PilotReport, Steer


def helm_in_command(commander: int, **options: object) -> Helm:
    helm = Helm(0.0, **options)  # type: ignore[arg-type]
    helm.pilot.bus_heard(0.0)
    helm.pilot.heading_heard(90.0, 0.0)
    assert helm.receive(Command(Verb.REQCMD), commander, 0.0) == [Transferred(0, commander)]
    return helm


def engaged(commander: int = 1) -> Helm:
    helm = helm_in_command(commander)
    helm.receive(Command(Verb.ENGAGE), commander, 0.0)
    assert helm.pilot.mode is Mode.HEADING_HOLD
    return helm


def courses(effects: list[Event]) -> list[int | None]:
    return [effect.setpoint for effect in effects if isinstance(effect, Steer)]


@pytest.mark.parametrize(
    ("verb", "course"),
    [(Verb.PORTONE, 890), (Verb.STBDONE, 910), (Verb.PORTTEN, 800), (Verb.STBDTEN, 1000)],
)
def test_a_turn_is_what_its_name_says(verb: Verb, course: int):
    assert courses(engaged().receive(Command(verb), 1, 0.0)) == [course]


def test_a_heading_is_set_as_given():
    assert courses(engaged().receive(Command(Verb.SETHEADING, heading_tenths=455), 1, 0.0)) == [455]
    assert courses(engaged().receive(Command(Verb.SETHEADING, heading_tenths=0), 1, 0.0)) == [0]


def test_disengage_lets_go():
    helm = engaged()
    assert courses(helm.receive(Command(Verb.DISENGAGE), 1, 0.0)) == [None]
    assert helm.pilot.mode is Mode.STANDBY


def test_without_an_address_on_the_bus_a_pilot_is_only_let_go():
    helm = engaged()
    helm.mute = True
    assert helm.receive(Command(Verb.STBDTEN), 1, 0.0) == [Refused("no address on the bus", 1)]
    assert courses(helm.receive(Command(Verb.DISENGAGE), 1, 0.0)) == [None]
    assert helm.receive(Command(Verb.ENGAGE), 1, 0.0) == [Refused("no address on the bus", 1)]


def test_who_is_not_in_command_steers_nothing():
    helm = engaged(2)
    for station in (1, 3, 4):
        assert helm.receive(Command(Verb.STBDTEN), station, 0.0) == [Refused("not in command", station)]
    assert helm.pilot.setpoint == 900


def test_command_passes_as_the_stations_say():
    helm = helm_in_command(1)
    assert helm.receive(Command(Verb.REQCMD), 2, 0.0) == [Requested(2)]
    assert helm.receive(Command(Verb.DENYCMD), 1, 0.0) == [Denied(2)]
    helm.receive(Command(Verb.REQCMD), 2, 0.0)
    assert helm.receive(Command(Verb.ACKCMD), 1, 0.0) == [Transferred(1, 2)]
    assert helm.receive(Command(Verb.TAKECMD), 1, 0.0) == [Transferred(2, 1)]
    assert helm.receive(Command(Verb.RELCMD), 1, 0.0) == [Transferred(1, 0)]


def test_an_answer_to_somebody_else_is_refused():
    helm = helm_in_command(1)
    helm.receive(Command(Verb.REQCMD), 2, 0.0)
    assert helm.receive(Command(Verb.RELCMD, requester=3), 1, 0.0) == [Refused("no such request", 1)]
    assert helm.receive(Command(Verb.RELCMD, requester=2), 1, 0.0) == [Transferred(1, 2)]


def test_what_is_overdue_comes_before_what_is_said():
    helm = helm_in_command(1)
    helm.receive(Command(Verb.REQCMD), 2, 0.0)
    helm.pilot.bus_heard(10.0)
    assert helm.receive(Command(Verb.STBDTEN), 1, 10.0) == [Transferred(1, 2), Refused("not in command", 1)]


def test_a_pilot_that_steers_when_command_is_given_up_raises_an_alert_until_somebody_takes_it():
    helm = engaged()
    effects = helm.receive(Command(Verb.RELCMD), 1, 0.0)
    assert effects[0] == Transferred(1, 0)
    assert isinstance(effects[1], AlertChanged)
    assert effects[1].alert.text == "station 1 gave up command and nobody took it while the pilot steers"
    assert helm.alerts.active(NO_COMMANDER)
    assert helm.pilot.mode is Mode.HEADING_HOLD
    helm.receive(Command(Verb.REQCMD), 3, 0.0)
    assert not helm.alerts.active(NO_COMMANDER)


def test_a_boat_that_stands_by_needs_no_commander():
    helm = helm_in_command(1)
    assert helm.receive(Command(Verb.RELCMD), 1, 0.0) == [Transferred(1, 0)]


def test_in_alarm_there_is_a_louder_alert_already():
    helm = engaged()
    helm.expire(3.0)
    assert helm.pilot.mode is Mode.ALARM
    assert helm.receive(Command(Verb.RELCMD), 1, 3.0) == [Transferred(1, 0)]


def test_the_deadline_is_the_nearest_of_all():
    helm = helm_in_command(1)
    assert helm.deadline == 3.0, "the backbone"
    helm.pilot.bus_heard(9.0)
    helm.receive(Command(Verb.REQCMD), 2, 0.5)
    assert helm.deadline == 10.5, "the request"
    helm.alerts.arise(PILOT_NOT_FOLLOWING, "", 1.0)
    helm.alerts.silence(PILOT_NOT_FOLLOWING.id, -28.0)
    assert helm.deadline == 2.0, "the silenced alert"


def test_nothing_happens_before_the_deadline_and_everything_at_it():
    helm = helm_in_command(1, request_timeout=2.0, on_timeout=OnTimeout.DENY)
    helm.receive(Command(Verb.REQCMD), 2, 0.0)
    assert helm.expire(1.99) == []
    assert helm.expire(2.0) == [Denied(2)]
    effects = helm.expire(3.0)
    assert isinstance(effects[0], AlertChanged)
    helm.alerts.silence(effects[0].alert.kind.id, 3.0)
    assert [effect.alert.silenced_until for effect in helm.expire(33.0) if isinstance(effect, AlertChanged)] == [None]


def test_the_pilots_own_report_is_nobodys_command():
    helm = helm_in_command(1)
    helm.pilot.reported(PilotReport(Mode.TRACK, 100), 0.0)
    helm.receive(Command(Verb.RELCMD), 1, 0.0)
    assert helm.alerts.active(NO_COMMANDER), "a pilot on a track steers too"


def test_a_request_waits_ten_seconds_unless_it_is_told_otherwise():
    helm = helm_in_command(1)
    helm.receive(Command(Verb.REQCMD), 2, 0.0)
    assert helm.transfer.deadline == 10.0
    helm.pilot.bus_heard(10.0)
    assert Transferred(1, 2) in helm.expire(10.0)
