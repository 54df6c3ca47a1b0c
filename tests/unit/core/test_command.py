"""Command transfer, rule by rule (spec/command.md)."""

from timonel.core.command import (
    CommandTransfer,
    Denied,
    OnTimeout,
    Overridden,
    Requested,
    Transferred,
    Verb,
    waiting,
)
from timonel.core.effects import Refused


def commanded_by(station: int, **options: object) -> CommandTransfer:
    command = CommandTransfer(**options)  # type: ignore[arg-type]
    assert command.receive(Verb.REQUEST, station, now=0.0) == [Transferred(0, station)]
    return command


def test_at_power_on_nobody_is_in_command_and_nobody_waits():
    command = CommandTransfer()
    assert (command.commander, command.queue, command.deadline) == (0, (), None)


def test_who_asks_first_gets_command_at_once():
    assert CommandTransfer().receive(Verb.REQUEST, 3, now=0.0) == [Transferred(0, 3)]


def test_a_station_that_does_not_exist_is_refused():
    for station in (0, 5):
        assert CommandTransfer().receive(Verb.REQUEST, station, now=0.0) == [Refused("no such station", station)]


def test_a_silent_commander_loses_command_after_ten_seconds():
    command = commanded_by(1)
    assert command.receive(Verb.REQUEST, 2, now=5.0) == [Requested(2)]
    assert command.deadline == 15.0
    assert command.expire(now=14.9) == []
    assert command.expire(now=15.0) == [Transferred(1, 2)]
    assert command.deadline is None


def test_where_silence_denies_the_commander_stays():
    command = commanded_by(1, on_timeout=OnTimeout.DENY)
    command.receive(Verb.REQUEST, 2, now=5.0)
    assert command.expire(now=15.0) == [Denied(2)]
    assert (command.commander, command.queue, command.deadline) == (1, (), None)


def test_the_time_to_answer_can_be_set():
    command = commanded_by(1, timeout=3.0)
    command.receive(Verb.REQUEST, 2, now=1.0)
    assert command.expire(now=3.9) == []
    assert command.expire(now=4.0) == [Transferred(1, 2)]


def test_a_repeated_request_is_refused_and_moves_no_deadline():
    command = commanded_by(1)
    command.receive(Verb.REQUEST, 2, now=2.0)
    assert command.receive(Verb.REQUEST, 2, now=9.0) == [Refused("already requested", 2)]
    assert (command.queue, command.deadline) == ((2,), 12.0)


def test_the_commander_need_not_ask():
    command = commanded_by(2)
    assert command.receive(Verb.REQUEST, 2, now=1.0) == [Refused("already in command", 2)]
    assert command.queue == ()


def test_released_command_goes_to_the_head_of_the_queue_and_the_next_is_announced_anew():
    command = commanded_by(1)
    command.receive(Verb.REQUEST, 2, now=2.0)
    assert command.receive(Verb.REQUEST, 3, now=3.0) == []
    assert command.receive(Verb.RELEASE, 1, now=4.0) == [Transferred(1, 2), Requested(3)]
    assert command.deadline == 14.0
    assert command.expire(now=14.0) == [Transferred(2, 3)]


def test_command_released_to_an_empty_queue_is_nobodys():
    command = commanded_by(4)
    assert command.receive(Verb.RELEASE, 4, now=1.0) == [Transferred(4, 0)]


def test_only_the_commander_releases_answers_and_denies():
    command = commanded_by(1)
    command.receive(Verb.REQUEST, 2, now=1.0)
    for verb in (Verb.RELEASE, Verb.ACKNOWLEDGE, Verb.DENY):
        for station in (2, 3):
            assert command.receive(verb, station, now=2.0) == [Refused("not in command", station)]
    assert (command.commander, command.queue, command.deadline) == (1, (2,), 11.0)


def test_nobody_releases_what_nobody_has():
    assert CommandTransfer().receive(Verb.RELEASE, 1, now=0.0) == [Refused("not in command", 1)]


def test_an_acknowledged_request_is_granted():
    command = commanded_by(1)
    command.receive(Verb.REQUEST, 2, now=1.0)
    assert command.receive(Verb.ACKNOWLEDGE, 1, now=2.0) == [Transferred(1, 2)]


def test_a_denied_request_leaves_the_queue_and_the_next_is_announced():
    command = commanded_by(1)
    command.receive(Verb.REQUEST, 2, now=1.0)
    command.receive(Verb.REQUEST, 3, now=2.0)
    assert command.receive(Verb.DENY, 1, now=3.0) == [Denied(2), Requested(3)]
    assert (command.commander, command.queue, command.deadline) == (1, (3,), 13.0)


def test_there_must_be_a_request_to_answer():
    command = commanded_by(1)
    for verb in (Verb.ACKNOWLEDGE, Verb.DENY):
        assert command.receive(verb, 1, now=1.0) == [Refused("no request to answer", 1)]
    assert command.commander == 1


def test_an_answer_names_the_announced_requester_or_is_refused():
    command = commanded_by(1)
    command.receive(Verb.REQUEST, 2, now=1.0)
    command.receive(Verb.REQUEST, 3, now=1.0)
    for verb in (Verb.RELEASE, Verb.ACKNOWLEDGE, Verb.DENY):
        assert command.receive(verb, 1, now=2.0, requester=3) == [Refused("no such request", 1)]
    assert command.receive(Verb.RELEASE, 1, now=2.0, requester=2) == [Transferred(1, 2), Requested(3)]


def test_the_bridge_takes_command_at_once_and_voids_the_queue():
    command = commanded_by(2)
    command.receive(Verb.REQUEST, 3, now=1.0)
    command.receive(Verb.REQUEST, 1, now=2.0)
    assert command.receive(Verb.TAKE, 1, now=3.0) == [Overridden((3,)), Transferred(2, 1)]
    assert (command.commander, command.queue, command.deadline) == (1, (), None)


def test_a_bridge_that_insists_keeps_command_and_voids_the_queue():
    command = commanded_by(1)
    command.receive(Verb.REQUEST, 2, now=1.0)
    assert command.receive(Verb.TAKE, 1, now=2.0) == [Overridden((2,))]
    assert command.receive(Verb.TAKE, 1, now=3.0) == []
    assert (command.commander, command.queue, command.deadline) == (1, (), None)


def test_nobody_but_the_bridge_takes_command():
    for station in (2, 3, 4):
        command = commanded_by(1)
        assert command.receive(Verb.TAKE, station, now=1.0) == [Refused("only the bridge takes command", station)]
        assert command.commander == 1


def test_an_answer_that_comes_too_late_finds_command_gone():
    command = commanded_by(1)
    command.receive(Verb.REQUEST, 2, now=0.0)
    assert command.receive(Verb.DENY, 1, now=10.0) == [Transferred(1, 2), Refused("not in command", 1)]


def test_a_late_timer_gives_the_next_request_its_whole_time():
    command = commanded_by(1)
    command.receive(Verb.REQUEST, 2, now=0.0)
    command.receive(Verb.REQUEST, 3, now=1.0)
    assert command.expire(now=50.0) == [Transferred(1, 2), Requested(3)]
    assert command.deadline == 60.0


def test_displays_see_who_waits_and_how_long_the_head_still_waits():
    command = commanded_by(1)
    command.receive(Verb.REQUEST, 2, now=1.0)
    command.receive(Verb.REQUEST, 4, now=2.0)
    assert waiting(command, now=4.0) == [(2, 7.0), (4, None)]
    assert waiting(command, now=99.0) == [(2, 0.0), (4, None)]
    assert waiting(CommandTransfer(), now=0.0) == []


def test_a_configuration_names_what_silence_means():
    assert [OnTimeout("transfer"), OnTimeout("deny")] == list(OnTimeout)
