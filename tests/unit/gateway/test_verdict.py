from collections.abc import Callable

import pytest

from timonel.gateway.verdict import CommandVerdict, Done, Grant, Refusal, RequestVerdict
from timonel.nmea0183.parp import CommandRequested, CommandTransferred, PilotMode, Status, Verb


def status(mode: PilotMode | None = PilotMode.STANDBY, *, heading: float | None = 90.0, commander: int = 2) -> Status:
    return Status(mode, mode or "", 0.0, heading, 0.0, commander)


def never(_: Status) -> bool:
    return False


def verdict(
    verb: Verb = Verb.ENGAGE, before: Status | None = None, shows: Callable[[Status], bool] = never
) -> CommandVerdict:
    return CommandVerdict(verb, 2, shows, sent=10.0, before=before)


def test_a_command_is_done_when_status_shows_its_effect():
    engaged = verdict(shows=lambda status: status.mode is PilotMode.HEADING_HOLD)
    assert engaged.hear(status(), 10.1) is None
    assert engaged.hear(status(PilotMode.HEADING_HOLD), 10.2) == Done()


def test_a_status_on_its_way_while_the_command_travels_decides_nothing():
    assert verdict(before=status()).hear(status(), 10.49) is None


def test_a_status_later_than_that_without_the_effect_is_a_refusal():
    assert verdict(before=status()).hear(status(), 10.5) == Refusal("STATUS shows no effect of ENGAGE")


def test_what_stood_in_the_way_before_and_after_is_the_reason_at_once():
    foreign = status(commander=1)
    assert verdict(before=foreign).hear(foreign, 10.0) == Refusal("station 01 is in command")


def test_what_somebody_else_already_does_is_not_our_effect():
    foreign = status(PilotMode.HEADING_HOLD, commander=1)
    engage = verdict(before=foreign, shows=lambda status: status.mode is PilotMode.HEADING_HOLD)
    assert engage.hear(foreign, 10.1) == Refusal("station 01 is in command")


def test_what_stands_in_the_way_only_now_may_be_older_than_the_command():
    engage = verdict(before=status())
    assert engage.hear(status(commander=1), 10.1) is None
    assert engage.hear(status(commander=1), 10.5) == Refusal("station 01 is in command")


@pytest.mark.parametrize(
    ("verb", "shown", "reason"),
    [
        (Verb.ENGAGE, status(commander=0), "nobody is in command"),
        (Verb.ENGAGE, status(PilotMode.ALARM), "the far end is in ALARM"),
        (Verb.ENGAGE, status(heading=None), "no heading"),
        (Verb.STBDTEN, status(PilotMode.ALARM), "the far end is in ALARM"),
        (Verb.SETHEADING, status(), "no heading is being held (STANDBY)"),
        (Verb.PORTONE, status(None), "no heading is being held (mode unknown)"),
        (Verb.DISENGAGE, status(PilotMode.ALARM), "STATUS shows no effect of DISENGAGE"),
        (Verb.RELCMD, status(PilotMode.ALARM), "STATUS shows no effect of RELCMD"),
        (Verb.TAKECMD, status(commander=3), "STATUS shows no effect of TAKECMD"),
    ],
)
def test_a_refusal_names_its_reason_as_far_as_status_tells_it(verb: Verb, shown: Status, reason: str):
    assert verdict(verb).hear(shown, 11.0) == Refusal(reason)


def test_only_status_decides_a_command():
    assert verdict().hear(CommandTransferred(2, 1), 11.0) is None


def request(announced: float | None = None) -> RequestVerdict:
    return RequestVerdict(2, 10.0, announced)


def test_a_request_while_nobody_commands_is_granted_by_that():
    assert request().hear(CommandTransferred(0, 2), 0.1) == Done(Grant.NOBODY)


def test_a_status_that_names_us_grants_where_the_transfer_was_lost():
    assert request().hear(status(commander=2), 0.1) == Done(Grant.NOBODY)


@pytest.mark.parametrize(("now", "grant"), [(9.7, Grant.ANSWERED), (9.75, Grant.SILENCE), (10.0, Grant.SILENCE)])
def test_a_transfer_before_the_deadline_is_an_answer_and_at_the_deadline_silence(now: float, grant: Grant):
    asked = request()
    assert asked.hear(CommandRequested(2), 0.0) is None
    assert asked.announced
    assert asked.hear(CommandTransferred(1, 2), now) == Done(grant)


def test_an_announced_request_that_comes_to_nothing_was_denied():
    asked = request(announced=0.0)
    assert asked.hear(status(commander=1), 10.9) is None
    assert asked.hear(status(commander=1), 11.0) == Refusal("denied; station 01 stays in command")


def test_a_repeated_announcement_does_not_move_the_deadline():
    asked = request(announced=0.0)
    asked.hear(CommandRequested(2), 5.0)
    assert isinstance(asked.hear(status(commander=1), 11.0), Refusal)


def test_when_the_next_one_is_asked_about_we_were_denied():
    assert request(announced=0.0).hear(CommandRequested(3), 4.0) == Refusal("denied; station 03 is asked about now")


def test_when_command_passes_us_by_though_we_were_announced_the_bridge_has_taken_it():
    assert request(announced=0.0).hear(CommandTransferred(3, 1), 4.0) == Refusal("station 01 has taken command")


def test_a_request_that_waits_behind_others_waits_on():
    asked = request()
    assert asked.hear(CommandRequested(3), 0.0) is None
    assert asked.hear(status(commander=1), 60.0) is None
    assert not asked.announced


def test_after_a_transfer_the_next_announcement_shows_that_the_queue_lives():
    asked = request()
    asked.hear(CommandTransferred(1, 3), 4.0)
    asked.hear(CommandRequested(2), 4.0)
    assert asked.hear(status(commander=3), 5.0) is None


def test_after_a_transfer_without_announcement_the_queue_is_empty():
    asked = request()
    asked.hear(CommandTransferred(3, 1), 4.0)
    assert asked.hear(status(commander=1), 4.4) is None
    assert asked.hear(status(commander=1), 4.5) == Refusal("station 01 has taken command")


def test_a_release_to_nobody_before_our_request_arrives_is_not_against_us():
    asked = request()
    asked.hear(CommandTransferred(1, 0), 4.0)
    assert asked.hear(status(commander=0), 4.5) is None
