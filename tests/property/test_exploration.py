"""Every invariant of spec/command.md, over the whole reachable state space of the shipped machines.

The transfer of command and the pilot meet in the helm, which lets a word through or not; so each is explored
alone, and the helm over their reachable states.
"""

from collections.abc import Iterator
from functools import cache

import pytest

from tests.property.exploration import (
    COMMAND_STEPS,
    PILOT_STEPS,
    Transition,
    WatchedPilot,
    command_state,
    explore,
    pilot_state,
    pilot_twin,
    twin_of,
)
from timonel.core.command import BRIDGE, NOBODY, STATIONS, CommandTransfer, Denied, OnTimeout, Requested, Transferred
from timonel.core.command import Verb as Say
from timonel.core.effects import Refused
from timonel.nmea0183.parp import Command, Verb
from timonel.vehicles.boat.alerts import BACKBONE_SILENT
from timonel.vehicles.boat.helm import TRANSFER, TURNS, Helm
from timonel.vehicles.boat.pilot import DATA_AGE, Mode, Pilot, Steer
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.vehicle import Boat

STEERING = [verb for verb in Verb if verb not in TRANSFER]


@pytest.fixture(params=OnTimeout, ids=lambda policy: policy.value)
def on_timeout(request: pytest.FixtureRequest) -> OnTimeout:
    policy: OnTimeout = request.param
    return policy


@cache
def commands(on_timeout: OnTimeout = OnTimeout.TRANSFER) -> list[Transition[CommandTransfer]]:
    start = CommandTransfer(on_timeout=on_timeout)
    return list(explore(start, COMMAND_STEPS, twin_of, command_state))


@cache
def pilots() -> list[Transition[WatchedPilot]]:
    """Both kinds: one that is given its course, and one that chooses it when it is engaged."""
    kinds = (WatchedPilot(adopts) for adopts in (False, True))
    return [transition for pilot in kinds for transition in explore(pilot, PILOT_STEPS, pilot_twin, pilot_state)]


def command_states() -> Iterator[tuple[CommandTransfer, float]]:
    for transition in commands():
        if transition.step == "tick":  # one a state
            yield transition.before, transition.now - 1.0


def pilot_states() -> Iterator[tuple[WatchedPilot, float]]:
    for transition in pilots():
        if transition.step == "tick":
            yield transition.before, transition.now - 1.0


def of(kind: type, transition: Transition[CommandTransfer]) -> list[object]:
    return [effect for effect in transition.effects if isinstance(effect, kind)]


def test_the_whole_space_is_walked():
    assert len(list(command_states())) > 600
    assert len(list(pilot_states())) > 5000


# 1, 5: one commander, and nobody at power-on -------------------------------------------------------


def test_there_is_at_most_one_commander_and_never_a_stranger(on_timeout: OnTimeout):
    for transition in commands(on_timeout):
        after = transition.after
        assert after.commander in (NOBODY, *STATIONS)
        assert set(after.queue) <= set(STATIONS)
        assert len(set(after.queue)) == len(after.queue), "a station stands in the queue at most once"
        assert after.commander not in after.queue, "a commander never stands in its own queue"
        assert after.commander or not after.queue, "nobody waits for what nobody has"
        assert (after.deadline is None) == (not after.queue), "the head, and only the head, has a deadline"


# 3: the bridge takes ------------------------------------------------------------------------------


def test_the_bridge_takes_command_in_one_step_from_every_state(on_timeout: OnTimeout):
    for transition in commands(on_timeout):
        if transition.step == "TAKE 1":
            assert (transition.after.commander, transition.after.queue) == (BRIDGE, ())


# 4, 10: requests end in time, and only so -----------------------------------------------------------


def test_an_announced_request_is_resolved_at_its_deadline(on_timeout: OnTimeout):
    for transition in commands(on_timeout):
        deadline = transition.before.deadline
        if transition.step == "tick" and deadline is not None and transition.now >= deadline:
            head = transition.before.queue[0]
            assert head not in transition.after.queue
            granted = on_timeout is OnTimeout.TRANSFER
            assert (transition.after.commander == head) == granted
            assert bool(of(Denied, transition)) != granted
        assert transition.after.deadline is None or transition.after.deadline <= transition.now + 10.0


def test_a_deadline_moves_only_with_a_new_head(on_timeout: OnTimeout):
    for transition in commands(on_timeout):
        before, after = transition.before, transition.after
        if before.queue[:1] == after.queue[:1]:
            assert before.deadline == after.deadline


def test_a_waiting_request_leaves_the_queue_only_by_answer_deadline_or_override(on_timeout: OnTimeout):
    answers = {"RELEASE", "ACKNOWLEDGE", "DENY"}
    for transition in commands(on_timeout):
        before, after = transition.before, transition.after
        gone = [station for station in before.queue if station not in after.queue]
        word, *who = transition.step.split()
        if transition.step == "TAKE 1":
            assert gone == list(before.queue)
        elif word in answers and int(who[0]) == before.commander:
            assert gone in ([], list(before.queue[:1]))
        elif word == "tick" and before.deadline is not None and transition.now >= before.deadline:
            assert gone == [before.queue[0]]
        else:
            assert gone == []


# 7: every change is announced, and truly ------------------------------------------------------------


def test_each_change_of_commander_is_announced_once_and_from_whom_everybody_knew(on_timeout: OnTimeout):
    for transition in commands(on_timeout):
        told = transition.before.commander
        for transferred in of(Transferred, transition):
            assert isinstance(transferred, Transferred)
            assert transferred.previous == told
            assert transferred.commander != told
            told = transferred.commander
        assert told == transition.after.commander
        assert len(of(Transferred, transition)) <= 1


def test_each_new_head_of_the_queue_is_announced_once(on_timeout: OnTimeout):
    for transition in commands(on_timeout):
        before, after = transition.before.queue[:1], transition.after.queue[:1]
        expected = [Requested(after[0])] if after and after != before else []
        assert of(Requested, transition) == expected


# 8, 9: what is lawful has its effect, what is not has none ------------------------------------------


def lawful(transition: Transition[CommandTransfer]) -> bool:
    """spec/command.md, the table, said once more and differently."""
    word, station, requester = [*transition.step.replace(" for ", " ").split(), "0", "0"][:3]
    before = transition.before
    if int(requester) and list(before.queue[:1]) != [int(requester)]:
        return False
    return {
        "REQUEST": int(station) != before.commander and int(station) not in before.queue,
        "RELEASE": int(station) == before.commander,
        "ACKNOWLEDGE": int(station) == before.commander and before.queue != (),
        "DENY": int(station) == before.commander and before.queue != (),
        "TAKE": int(station) == BRIDGE,
    }[word]


def test_a_lawful_word_has_its_effect(on_timeout: OnTimeout):
    for transition in commands(on_timeout):
        if transition.step == "tick" or not lawful(transition):
            continue
        word, station = transition.step.split()[0], int(transition.step.split()[1])
        before, after = transition.before, transition.after
        assert not of(Refused, transition), transition.step
        match word:
            case "REQUEST" if before.commander == NOBODY:
                assert after.commander == station
            case "REQUEST":
                assert after.queue == (*before.queue, station)
                assert after.commander == before.commander
            case "RELEASE" | "ACKNOWLEDGE":
                assert after.commander == (before.queue or (NOBODY,))[0]
                assert after.queue == before.queue[1:]
            case "DENY":
                assert after.commander == before.commander
                assert after.queue == before.queue[1:]
                assert of(Denied, transition) == [Denied(before.queue[0])]


def test_a_refused_word_leaves_the_state_identical(on_timeout: OnTimeout):
    for transition in commands(on_timeout):
        if transition.step == "tick" or lawful(transition):
            continue
        assert len(of(Refused, transition)) == 1, transition.step
        assert not transition.changed


# 6: ports may go -----------------------------------------------------------------------------------


def test_losing_any_ports_changes_neither_commander_nor_queue():
    boat = Boat(BoatSettings(), [Port(f"IN{station}", station) for station in STATIONS], now=0.0)
    for command, now in command_states():
        boat.helm.transfer = command
        state = command_state(command, now)
        for station in STATIONS:
            boat.port_changed(f"IN{station}", False, 0.0)
            assert command_state(command, now) == state
        for station in STATIONS:
            boat.port_changed(f"IN{station}", True, 0.0)
        assert command_state(command, now) == state


# 2: nobody steers but the commander ----------------------------------------------------------------


def helm_of(command: CommandTransfer, pilot: WatchedPilot) -> Helm:
    helm = Helm(0.0)
    helm.transfer = twin_of(command)
    helm.pilot = pilot_twin(pilot)
    helm.alerts = helm.pilot._alerts
    return helm


def steering(verb: Verb) -> Command:
    return Command(verb, heading_tenths=1234 if verb is Verb.SETHEADING else None)


def in_command(commander: int) -> CommandTransfer:
    command = CommandTransfer()
    if commander:
        command.receive(Say.REQUEST, commander, 0.0)
    return command


def test_a_steering_command_of_any_other_station_never_has_an_effect():
    for number, (pilot, now) in enumerate(pilot_states()):
        commander = number % 5
        helm = helm_of(in_command(commander), pilot)
        state = pilot_state(helm.pilot, now)  # type: ignore[arg-type]
        for station in set(STATIONS) - {commander}:
            effects = helm.receive(steering(STEERING[number % len(STEERING)]), station, now)
            assert effects == [Refused("not in command", station)]
            assert pilot_state(helm.pilot, now) == state  # type: ignore[arg-type]


def test_in_every_state_of_command_only_the_commander_is_let_through_to_the_pilot():
    for command, now in command_states():
        for station in STATIONS:
            for verb in STEERING:
                helm = helm_of(command, WatchedPilot())
                helm.pilot = Pilot(helm.alerts, now)
                effects = helm.receive(steering(verb), station, now)
                assert (Refused("not in command", station) in effects) == (station != command.commander)


def test_no_word_about_command_touches_the_pilot():
    for number, (pilot, now) in enumerate(pilot_states()):
        helm = helm_of(in_command(number % 5), pilot)
        state = pilot_state(helm.pilot, now)  # type: ignore[arg-type]
        for verb in TRANSFER:
            helm.receive(Command(verb), 1 + number % 4, now)
        after = pilot_state(helm.pilot, now)  # type: ignore[arg-type]
        assert [part for part in after if not isinstance(part, frozenset)] == [  # type: ignore[attr-defined]
            part
            for part in state
            if not isinstance(part, frozenset)  # type: ignore[attr-defined]
        ]


# 13: the bridge stops everything --------------------------------------------------------------------


def test_from_every_state_the_bridge_commands_and_stands_by_in_two_sentences():
    some_command = [command for command, _ in command_states()]
    for number, (pilot, now) in enumerate(pilot_states()):
        helm = helm_of(some_command[number % len(some_command)], pilot)
        helm.transfer.deadline = None if helm.transfer.deadline is None else now + 5.0
        helm.receive(Command(Verb.TAKECMD), BRIDGE, now)
        effects = helm.receive(Command(Verb.DISENGAGE), BRIDGE, now)
        assert (helm.transfer.commander, helm.pilot.mode) == (BRIDGE, Mode.STANDBY)
        assert Steer(None) in effects


# 11: the pilot --------------------------------------------------------------------------------------


def steers(transition: Transition[WatchedPilot]) -> list[int | None]:
    return [effect.setpoint for effect in transition.effects if isinstance(effect, Steer)]


def test_disengage_stands_by_in_one_step_and_tells_the_pilot():
    for transition in pilots():
        if transition.step == "disengage":
            assert transition.after.mode is Mode.STANDBY
            assert steers(transition)[-1] is None


def test_in_alarm_nothing_is_obeyed_but_disengage():
    for transition in pilots():
        if transition.before.mode is Mode.ALARM and transition.step in ("engage", "set", "turn"):
            assert not transition.changed
            assert not steers(transition)
            assert any(isinstance(effect, Refused) for effect in transition.effects)


def test_set_point_commands_never_change_the_mode():
    for transition in pilots():
        if transition.step in ("set", "turn"):
            assert transition.after.mode is transition.before.mode


def test_a_refused_command_leaves_the_pilot_identical_and_any_other_has_its_effect():
    for transition in pilots():
        refused = any(isinstance(effect, Refused) for effect in transition.effects)
        match transition.step:
            case "engage":
                fresh = transition.before.heading(transition.now) is not None
                assert refused == (transition.before.mode is Mode.ALARM or not fresh)
            case "set":
                assert refused == (transition.before.mode is not Mode.HEADING_HOLD)
        if refused:
            assert not transition.changed
        elif transition.step in ("engage", "set", "turn"):
            assert transition.after.mode is Mode.HEADING_HOLD
            assert steers(transition) == [transition.after.setpoint]


def test_only_the_commander_engages():
    for transition in pilots():
        if transition.step in ("engage", "set", "turn"):
            continue
        for course in steers(transition):
            if course is not None:
                assert transition.step == "tick", "a course is repeated in time, not because something was heard"
                assert course == transition.before.told, "and it is the one that was commanded"
                assert transition.before.mode is Mode.HEADING_HOLD


def test_in_alarm_the_pilot_is_never_told_to_steer():
    for transition in pilots():
        if transition.before.mode is Mode.ALARM or transition.after.mode is Mode.ALARM:
            assert all(course is None for course in steers(transition)), transition.step


def test_standby_is_shown_only_if_the_pilot_was_told_so_or_told_so_itself():
    for transition in pilots():
        after = transition.after
        if after.mode is Mode.STANDBY and after.told not in (None, "nothing"):
            assert after._report is not None, transition.step
            assert after._report.mode is Mode.STANDBY, transition.step


def test_a_backbone_silent_for_three_seconds_never_shows_a_held_heading():
    for transition in pilots():
        after = transition.after
        if transition.now - after._bus_heard >= DATA_AGE:
            assert after._alerts.active(BACKBONE_SILENT)
            assert after.mode in (Mode.ALARM, Mode.STANDBY)


def test_a_heading_is_not_shown_as_held_three_seconds_after_it_was_lost():
    for transition in pilots():
        after = transition.after
        if after.mode is Mode.HEADING_HOLD and after._heading is not None and transition.step == "tick":
            assert transition.now - after._heading_heard < DATA_AGE


def test_a_mode_that_is_not_understood_is_never_shown_as_standby():
    for transition in pilots():
        if transition.step == "reports unknown" and transition.before._command is None:
            assert transition.after.mode in (Mode.UNKNOWN, Mode.ALARM)


def test_the_set_point_stays_within_the_circle_and_ten_ones_are_a_ten():
    for start in range(3600):
        pilot = Pilot(Helm(0.0).alerts, 0.0)
        pilot.heading_heard(start / 10, 0.0)
        pilot.engage(1, 0.0)
        assert pilot.setpoint == start
        for ones, tens in ((Verb.STBDONE, Verb.STBDTEN), (Verb.PORTONE, Verb.PORTTEN)):
            for _ in range(10):
                pilot.turn(TURNS[ones], 1, 0.0)
                assert pilot.setpoint is not None
                assert 0 <= pilot.setpoint < 3600
            by_ones = pilot.setpoint
            pilot.set_heading(start, 1, 0.0)
            pilot.turn(TURNS[tens], 1, 0.0)
            assert pilot.setpoint == by_ones
            pilot.set_heading(start, 1, 0.0)
