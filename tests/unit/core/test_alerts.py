"""Alerts: priority, acknowledgement, silence (MSC.302(87))."""

import msgspec
import pytest

from timonel.core.alerts import Alert, AlertChanged, AlertKind, Alerts, Patience, PressingAlert, Priority
from timonel.core.effects import Event

FIRE = AlertKind(1, "fire", Priority.ALARM)
LEAK = AlertKind(2, "leak", Priority.WARNING)
DAMP = AlertKind(3, "damp", Priority.CAUTION)


def test_an_alert_arises_once():
    alerts = Alerts()
    assert alerts.arise(FIRE, "engine room", now=1.0) == [AlertChanged(Alert(FIRE, "engine room", 1.0))]
    assert alerts.arise(FIRE, "engine room", now=2.0) == []
    assert alerts.active(FIRE)


def test_an_acknowledged_alert_stays_until_it_is_rectified():
    alerts = Alerts()
    alerts.arise(FIRE, "", now=1.0)
    assert alerts.acknowledge(1) == [AlertChanged(Alert(FIRE, "", 1.0, acknowledged=True))]
    assert alerts.acknowledge(1) == []
    assert alerts.rectify(FIRE) == [AlertChanged(Alert(FIRE, "", 1.0, active=False, acknowledged=True))]
    assert alerts.standing == []


def test_a_rectified_alert_stays_until_somebody_has_seen_it():
    alerts = Alerts()
    alerts.arise(FIRE, "", now=1.0)
    assert alerts.rectify(FIRE) == [AlertChanged(Alert(FIRE, "", 1.0, active=False))]
    assert alerts.rectify(FIRE) == []
    assert not alerts.active(FIRE)
    assert len(alerts.standing) == 1
    assert alerts.acknowledge(1) == [AlertChanged(Alert(FIRE, "", 1.0, active=False, acknowledged=True))]
    assert alerts.standing == []


def test_an_alert_that_comes_back_is_new():
    alerts = Alerts()
    alerts.arise(FIRE, "", now=1.0)
    alerts.rectify(FIRE)
    assert alerts.arise(FIRE, "", now=5.0) == [AlertChanged(Alert(FIRE, "", 5.0))]


def test_a_caution_needs_no_acknowledgement():
    alerts = Alerts()
    assert alerts.arise(DAMP, "", now=1.0) == [AlertChanged(Alert(DAMP, "", 1.0, acknowledged=True))]
    alerts.rectify(DAMP)
    assert alerts.standing == []


def test_what_was_never_raised_can_be_neither_rectified_nor_acknowledged_nor_silenced():
    alerts = Alerts()
    assert alerts.rectify(FIRE) == alerts.acknowledge(1) == alerts.silence(1, now=0.0) == []


def test_a_silenced_alert_sounds_again_after_thirty_seconds():
    alerts = Alerts()
    alerts.arise(FIRE, "", now=1.0)
    assert alerts.deadline is None
    assert alerts.silence(1, now=2.0) == [AlertChanged(Alert(FIRE, "", 1.0, silenced_until=32.0))]
    assert alerts.deadline == 32.0
    assert alerts.expire(now=31.9) == []
    assert alerts.expire(now=32.0) == [AlertChanged(Alert(FIRE, "", 1.0))]
    assert alerts.deadline is None


def test_an_acknowledged_alert_is_not_silenced_and_does_not_sound_again():
    alerts = Alerts()
    alerts.arise(FIRE, "", now=1.0)
    alerts.silence(1, now=2.0)
    alerts.acknowledge(1)
    assert alerts.deadline is None
    assert alerts.silence(1, now=3.0) == []


def test_the_most_urgent_stands_first_then_the_oldest():
    alerts = Alerts()
    alerts.arise(DAMP, "", now=1.0)
    alerts.arise(LEAK, "", now=2.0)
    alerts.arise(FIRE, "", now=3.0)
    other = AlertKind(4, "smoke", Priority.ALARM)
    alerts.arise(other, "", now=2.5)
    assert [alert.kind for alert in alerts.standing] == [other, FIRE, LEAK, DAMP]


# What nobody acknowledges ---------------------------------------------------------------------------

SMOKE = AlertKind(4, "smoke", Priority.EMERGENCY)
PATIENT = Patience(alarm=30.0, warning=60.0)


def changed(events: list[Event]) -> list[Alert]:
    return [event.alert for event in events if isinstance(event, AlertChanged)]


@pytest.mark.parametrize(("kind", "interval"), [(SMOKE, 30.0), (FIRE, 30.0), (LEAK, 60.0)])
def test_what_nobody_acknowledges_is_announced_again_and_again(kind: AlertKind, interval: float):
    alerts = Alerts(PATIENT)
    alerts.arise(kind, "", now=1.0)
    for times in (1, 2, 3):
        due = 1.0 + times * interval
        assert alerts.deadline == due
        assert alerts.expire(due - 0.1) == []
        assert alerts.expire(due) == [AlertChanged(PressingAlert(kind, "", 1.0, announced=times))]


def test_without_patience_nothing_is_announced_again():
    alerts = Alerts()
    alerts.arise(FIRE, "", now=1.0)
    assert alerts.deadline is None
    assert alerts.expire(1e6) == []
    assert changed(alerts.silence(1, now=1e6))[0].announced == 0
    assert not changed(alerts.acknowledge(1))[0].transferred


def test_a_caution_is_not_announced_again():
    alerts = Alerts(PATIENT)
    alerts.arise(DAMP, "", now=1.0)
    assert alerts.deadline is None


@pytest.mark.parametrize("end", [lambda alerts: alerts.acknowledge(1), lambda alerts: alerts.rectify(FIRE)])
def test_what_is_acknowledged_or_over_is_not_announced_again(end):
    alerts = Alerts(PATIENT)
    alerts.arise(FIRE, "", now=1.0)
    alerts.expire(31.0)
    end(alerts)
    assert alerts.deadline is None
    assert alerts.expire(100.0) == []


def test_what_is_silenced_is_announced_again_after_it_has_sounded_again():
    alerts = Alerts(PATIENT)
    alerts.arise(FIRE, "", now=1.0)
    alerts.silence(1, now=25.0)
    assert alerts.deadline == 55.0
    assert [alert.announced for alert in changed(alerts.expire(55.0))] == [0]
    assert alerts.deadline == 85.0
    assert [alert.announced for alert in changed(alerts.expire(85.0))] == [1]


def test_what_is_over_sounds_again_after_its_silence_and_is_not_announced():
    alerts = Alerts(PATIENT)
    alerts.arise(FIRE, "", now=1.0)
    alerts.silence(1, now=2.0)
    alerts.rectify(FIRE)
    assert [alert.silenced_until for alert in changed(alerts.expire(32.0))] == [None]
    assert alerts.deadline is None


def test_a_warning_that_nobody_acknowledges_becomes_an_alarm():
    alerts = Alerts(Patience(alarm=30.0, warning=60.0, escalation=100.0))
    alerts.arise(LEAK, "", now=1.0)
    assert changed(alerts.expire(61.0))[0].kind.priority is Priority.WARNING
    assert alerts.deadline == 101.0
    raised = changed(alerts.expire(101.0))[0]
    assert (raised.kind.priority, raised.announced) == (Priority.ALARM, 2)
    assert alerts.deadline == 131.0, "as an alarm it is announced as alarms are"
    assert changed(alerts.rectify(LEAK))[0].kind.priority is Priority.ALARM
    alerts.acknowledge(2)
    assert changed(alerts.arise(LEAK, "", now=200.0))[0].kind.priority is Priority.WARNING, "a new one begins anew"


def test_a_warning_may_become_an_alarm_without_being_announced_before():
    alerts = Alerts(Patience(escalation=100.0))
    alerts.arise(LEAK, "", now=1.0)
    alerts.arise(FIRE, "", now=1.0)
    assert [alert.kind.priority for alert in changed(alerts.expire(101.0))] == [Priority.ALARM]
    assert alerts.deadline is None, "an alarm is not announced again, and no more than an alarm"


# Words, and other systems ---------------------------------------------------------------------------


def test_what_somebody_had_acknowledged_before_we_heard_of_it_arises_so():
    alerts = Alerts(PATIENT)
    assert alerts.arise(FIRE, "", now=1.0, acknowledged=True) == [AlertChanged(Alert(FIRE, "", 1.0, acknowledged=True))]
    assert alerts.deadline is None


def test_an_alert_gets_other_words_and_keeps_its_state():
    alerts = Alerts()
    named = AlertKind(1, "fire in the galley", Priority.EMERGENCY)
    assert alerts.reword(named, "") == []
    alerts.arise(FIRE, "", now=1.0)
    alerts.acknowledge(1)
    wanted = Alert(named, "deck 2", 1.0, acknowledged=True)
    assert alerts.reword(named, "deck 2") == [AlertChanged(wanted)]
    assert alerts.reword(named, "deck 2") == []
    assert alerts.get(1) == wanted


def test_other_words_do_not_make_a_warning_of_what_became_an_alarm():
    alerts = Alerts(Patience(escalation=10.0))
    alerts.arise(LEAK, "", now=0.0)
    alerts.expire(10.0)
    assert changed(alerts.reword(LEAK, "bilge"))[0].kind.priority is Priority.ALARM
    assert alerts.reword(LEAK, "bilge") == []


def test_an_alert_for_which_another_system_is_responsible_is_quiet_and_stays_while_it_holds():
    alerts = Alerts(PATIENT)
    alerts.arise(FIRE, "", now=1.0)
    alerts.silence(1, now=2.0)
    assert alerts.transfer(1) == [AlertChanged(PressingAlert(FIRE, "", 1.0, acknowledged=True, transferred=True))]
    assert alerts.transfer(1) == alerts.acknowledge(1) == []
    assert alerts.deadline is None
    alerts.rectify(FIRE)
    assert alerts.standing == []


def test_responsibility_is_not_taken_for_what_is_over_or_never_was():
    alerts = Alerts()
    assert alerts.transfer(1) == []
    alerts.arise(FIRE, "", now=1.0)
    alerts.rectify(FIRE)
    assert alerts.transfer(1) == []


def test_an_alert_that_is_forgotten_stands_no_longer():
    alerts = Alerts(PATIENT)
    assert alerts.forget(1) == []
    alerts.arise(FIRE, "", now=1.0)
    alerts.silence(1, now=2.0)
    assert alerts.forget(1) == [AlertChanged(Alert(FIRE, "", 1.0, active=False, acknowledged=True))]
    assert (alerts.standing, alerts.deadline) == ([], None)


def test_an_alert_that_presses_nobody_is_told_as_ever():
    """Recordings of older versions hold alerts as text."""
    plain = msgspec.json.decode(msgspec.json.encode(Alert(FIRE, "", 1.0)))
    assert set(plain) == {"kind", "text", "since", "active", "acknowledged", "silenced_until"}
