"""The helm of a rover: whose word reaches the drives."""

from timonel.core.alerts import AlertChanged
from timonel.core.command import Denied, OnTimeout, Requested, Transferred, Verb
from timonel.core.effects import Event, Refused
from timonel.vehicles.rover.alerts import LINK_LOST
from timonel.vehicles.rover.drive import STANDSTILL, Permission, Stick, Wheels
from timonel.vehicles.rover.helm import Helm

FORWARD, REST = Stick(0, -100), Stick(0, 0)


def of(kind: type, effects: list[Event]) -> list[Event]:
    return [effect for effect in effects if isinstance(effect, kind)]


def driven_by(station: int) -> Helm:
    helm = Helm(0.0)
    helm.stick(REST, station, 0.0)
    helm.permission(True, station, 0.0)
    helm.stick(FORWARD, station, 0.0)
    assert helm.transfer.commander == station
    assert helm.drive.wheels(0.0) == Wheels(100, 100)
    return helm


def run(helm: Helm, until: float) -> list[Event]:
    effects: list[Event] = []
    while helm.deadline <= until:
        effects += helm.expire(helm.deadline)
    return effects


def test_a_drive_frame_of_the_bridge_takes_command():
    helm = driven_by(2)
    effects = helm.stick(REST, 1, 0.1)
    assert of(Transferred, effects) == [Transferred(2, 1)]
    assert of(Permission, effects) == [Permission(False, "command passed")]


def test_a_permission_frame_of_the_bridge_takes_command_and_counts():
    helm = driven_by(2)
    effects = helm.permission(True, 1, 0.1)
    assert of(Transferred, effects) == [Transferred(2, 1)]
    assert of(Permission, effects) == [Permission(False, "command passed"), Permission(True, "station 1")]
    assert helm.drive.wheels(0.1) == STANDSTILL


def test_a_frame_of_another_station_requests_command_once_and_counts_only_when_granted():
    helm = driven_by(1)
    assert of(Requested, helm.stick(FORWARD, 2, 0.1)) == [Requested(2)]
    assert helm.permission(True, 2, 0.1) == []
    assert helm.drive.wheels(0.1) == Wheels(100, 100)
    effects = helm.say(Verb.ACKNOWLEDGE, 1, 0.15)
    assert of(Transferred, effects) == [Transferred(1, 2)]
    assert not helm.drive.permitted
    helm.permission(True, 2, 0.16)
    assert helm.drive.permitted


def test_a_denied_station_asks_again_with_its_next_frame():
    helm = driven_by(1)
    helm.stick(REST, 2, 0.1)
    assert of(Denied, helm.say(Verb.DENY, 1, 0.1)) == [Denied(2)]
    assert of(Requested, helm.stick(REST, 2, 0.15)) == [Requested(2)]


def test_the_old_commanders_frames_have_no_effect_from_that_moment():
    helm = driven_by(2)
    helm.permission(True, 1, 0.1)
    helm.stick(Stick(0, -50), 1, 0.1)
    helm.stick(FORWARD, 2, 0.12)
    assert helm.drive.wheels(0.12) == Wheels(50, 50)
    assert helm.speed_limit(1, 2, 0.12) == [Refused("not in command", 2)]


def test_anybody_stops_the_drives_and_command_stays():
    for station in (1, 2, 3, 4):
        helm = driven_by(2)
        effects = helm.permission(False, station, 0.1)
        assert of(Permission, effects) == [Permission(False, "a station ordered a stop")]
        assert of(Wheels, effects)[-1] == STANDSTILL
        assert helm.transfer.commander == 2


def test_a_stop_takes_no_command():
    helm = Helm(0.0)
    helm.permission(False, 1, 0.0)
    assert helm.transfer.commander == 0


def test_a_speed_limit_is_the_commanders():
    helm = driven_by(1)
    helm.speed_limit(10, 1, 0.1)
    assert helm.drive.wheels(0.1) == Wheels(50, 50)


def test_a_commander_that_falls_silent_while_driving_is_an_alarm():
    helm = driven_by(1)
    effects = run(helm, 0.5)
    assert of(Permission, effects) == [Permission(False, "the commander fell silent")]
    assert [e.alert.text for e in effects if isinstance(e, AlertChanged)] == [
        "station 1 was driving and has not been heard for 0.5 s"
    ]
    assert helm.alerts.active(LINK_LOST)


def test_a_commander_that_is_back_and_permits_anew_ends_the_alarm():
    helm = driven_by(1)
    run(helm, 0.6)
    helm.stick(FORWARD, 1, 0.7)
    helm.permission(True, 1, 0.7)
    assert helm.alerts.active(LINK_LOST), "it pushes the stick, so it does not drive"
    helm.stick(REST, 1, 0.8)
    helm.permission(True, 1, 0.8)
    assert not helm.alerts.active(LINK_LOST)


def test_a_commander_that_stopped_before_it_went_is_no_alarm():
    helm = driven_by(1)
    helm.permission(False, 1, 0.1)
    effects = run(helm, 3.0)
    assert of(Transferred, effects) == [Transferred(1, 0)]
    assert of(AlertChanged, effects) == []


def test_a_commander_silent_for_two_seconds_is_released():
    helm = driven_by(1)
    run(helm, 1.99)
    assert helm.transfer.commander == 1
    assert of(Transferred, helm.expire(2.0)) == [Transferred(1, 0)]
    assert helm.alerts.active(LINK_LOST)


def test_who_waits_gets_the_command_of_a_lost_commander_without_permission():
    helm = driven_by(1)
    helm.stick(REST, 3, 0.5)
    run(helm, 1.9)
    helm.heard(3, 1.9)
    assert of(Transferred, run(helm, 2.0)) == [Transferred(1, 3)]
    assert not helm.drive.permitted
    assert not helm.alerts.active(LINK_LOST)
    assert helm.deadline <= 4.0


def test_the_alert_ends_when_somebody_commands_again():
    helm = driven_by(1)
    run(helm, 2.0)
    helm.stick(REST, 2, 3.0)
    assert not helm.alerts.active(LINK_LOST)


def test_any_frame_of_the_commander_keeps_command():
    helm = driven_by(1)
    for step in range(1, 50):
        helm.heard(1, step / 10)
        run(helm, step / 10)
    assert helm.transfer.commander == 1


def test_frames_of_others_do_not():
    helm = driven_by(1)
    for step in range(1, 21):
        helm.heard(2, step / 10)
    assert helm.transfer.commander == 0


def test_a_new_commander_has_its_own_two_seconds():
    helm = driven_by(1)
    helm.stick(REST, 2, 0.1)
    run(helm, 1.5)
    helm.heard(1, 1.5)
    helm.say(Verb.RELEASE, 1, 1.9)
    run(helm, 3.8)
    assert helm.transfer.commander == 2
    run(helm, 3.9)
    assert helm.transfer.commander == 0


def test_a_request_left_unanswered_is_granted_or_denied_as_configured():
    for policy, commander in ((OnTimeout.TRANSFER, 3), (OnTimeout.DENY, 2)):
        helm = Helm(0.0, request_timeout=1.0, on_timeout=policy)
        helm.stick(REST, 2, 0.0)
        helm.stick(REST, 3, 0.0)
        helm.heard(2, 0.9)
        run(helm, 1.0)
        assert helm.transfer.commander == commander


def test_a_bridge_that_speaks_is_never_asked_out_of_command():
    helm = Helm(0.0, request_timeout=1.0)
    helm.stick(REST, 2, 0.0)
    helm.stick(REST, 1, 0.0)
    helm.stick(REST, 2, 0.1)
    helm.heard(1, 1.0)
    assert of(Denied, run(helm, 1.1)) == [Denied(2)]
    assert helm.transfer.commander == 1
    helm.say(Verb.RELEASE, 1, 1.2)
    helm.stick(REST, 2, 1.2)
    helm.stick(REST, 3, 1.3)
    helm.heard(2, 2.2)
    run(helm, 2.3)
    assert helm.transfer.commander == 3, "the policy is the configured one again"


def test_a_request_has_ten_seconds_unless_configured_otherwise():
    helm = Helm(0.0)
    helm.stick(REST, 2, 0.0)
    helm.stick(REST, 3, 0.0)
    for second in range(1, 10):
        helm.heard(2, float(second))
    run(helm, 9.99)
    assert helm.transfer.commander == 2
    run(helm, 10.0)
    assert helm.transfer.commander == 3


def test_two_seconds_of_silence_count_from_the_last_byte_of_what_was_heard():
    for age in (0.0, 0.25):
        helm = Helm(0.0)
        helm.stick(REST, 2, 0.0)
        helm.heard(2, 1.0, age)
        assert run(helm, 2.99 - age)
        assert helm.transfer.commander == 2
        run(helm, 3.0 - age)
        assert helm.transfer.commander == 0


def test_without_a_word_about_its_age_a_frame_is_heard_now():
    for say in (lambda helm: helm.heard(2, 1.0), lambda helm: helm.permission(True, 2, 1.0)):
        helm = Helm(0.0)
        helm.stick(REST, 2, 0.0)
        say(helm)
        run(helm, 2.99)
        assert helm.transfer.commander == 2
        run(helm, 3.0)
        assert helm.transfer.commander == 0
