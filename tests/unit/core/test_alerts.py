"""Alerts: priority, acknowledgement, silence (MSC.302(87))."""

from timonel.core.alerts import Alert, AlertChanged, AlertKind, Alerts, Priority

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
