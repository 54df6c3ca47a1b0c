"""No reachable state of the shipped rover in which a wheel is told to turn without permission, a fresh stick and
command: every state of helm and drives, with two stations, on a clock that ticks ten times a second.

The limits of the ladder (200 ms, 500 ms, 2 s) are whole ticks; requests time out after 1 s, so that they end within
the time that a lost commander has.
"""

from collections.abc import Callable, Hashable
from functools import cache

from tests.property.exploration import Step, Transition, explore, twin_of
from timonel.core.command import NOBODY, Transferred, Verb
from timonel.core.effects import Event
from timonel.vehicles.rover.drive import SILENT, STALE, STANDSTILL, Permission, Stick, Wheels
from timonel.vehicles.rover.helm import LOST, Helm

STATIONS = (1, 2)
TICK = 0.1
ROUNDING = 1e-9  # s
REQUEST_TIMEOUT = 1.0


class WatchedHelm(Helm):
    """A helm of whom we remember what really happened: who said what when, in words of our own."""

    def __init__(self) -> None:
        super().__init__(0.0, request_timeout=REQUEST_TIMEOUT)
        self.stick_at: float | None = None  # when the commander's last stick came in
        self.heard_at: float | None = None  # when anything of the commander came in, or it took command
        self.allowed = False  # the commander permitted motion, and nothing withdrew it since


def helm_twin(helm: WatchedHelm) -> WatchedHelm:
    twin = twin_of(helm)
    twin.transfer = twin_of(helm.transfer)
    twin.alerts = twin_of(helm.alerts)
    twin.alerts._alerts = dict(helm.alerts._alerts)
    twin.drive = twin_of(helm.drive)
    return twin


def ticks(time: float | None, now: float, oldest: float) -> int | None:
    return None if time is None else round(max(time - now, -oldest) * 10)


def helm_state(helm: WatchedHelm, now: float) -> Hashable:
    """All that decides; how far the 50 Hz rhythm has come does not."""
    drive, transfer = helm.drive, helm.transfer
    return (
        transfer.commander,
        transfer.queue,
        ticks(transfer.deadline, now, LOST),
        None if transfer.commander == NOBODY else ticks(helm._heard, now, LOST),
        drive.permitted,
        drive._stick,
        ticks(drive._stick_heard, now, STALE),
        ticks(drive._heard, now, SILENT),
        drive._said,
        ticks(helm.stick_at, now, STALE),
        ticks(helm.heard_at, now, SILENT),
        helm.allowed,
    )


def settled(helm: WatchedHelm, now: float) -> list[Event]:
    """Everything that is due up to `now`, each at its time."""
    effects: list[Event] = []
    while helm.deadline <= now + ROUNDING:
        effects += helm.expire(max(helm.deadline, 0.0))
    return effects


def said(station: int, name: str, apply: Callable[[Helm, float], list[Event]]) -> Step:
    def step(helm: WatchedHelm, now: float) -> list[Event]:
        effects = settled(helm, now) + apply(helm, now)
        remember(helm, effects, now, station, name)
        return effects

    return Step(f"{station} {name}", step)


def remember(helm: WatchedHelm, effects: list[Event], now: float, station: int, name: str) -> None:
    """What happened, by the words of the specification rather than by the machine's."""
    passed = any(isinstance(effect, Transferred) for effect in effects)
    if passed:
        helm.stick_at, helm.heard_at, helm.allowed = None, now, False
    if station == helm.transfer.commander:
        helm.heard_at = now
        if name in ("forward", "rest"):
            helm.stick_at = now
        if name == "permits" and any(isinstance(e, Permission) and e.granted for e in effects):
            helm.allowed = True
    if name == "stops":
        helm.allowed = False


def tick(helm: WatchedHelm, now: float) -> list[Event]:
    effects = settled(helm, now)
    remember(helm, effects, now, 0, "tick")
    if helm.heard_at is not None and now - helm.heard_at >= SILENT - ROUNDING:
        helm.allowed = False
    return effects


FORWARD, REST = Stick(0, -100), Stick(0, 0)
STEPS = [
    *(said(s, "forward", lambda helm, now, s=s: helm.stick(FORWARD, s, now)) for s in STATIONS),
    *(said(s, "rest", lambda helm, now, s=s: helm.stick(REST, s, now)) for s in STATIONS),
    *(said(s, "permits", lambda helm, now, s=s: helm.permission(True, s, now)) for s in STATIONS),
    *(said(s, "stops", lambda helm, now, s=s: helm.permission(False, s, now)) for s in STATIONS),
    *(said(s, "releases", lambda helm, now, s=s: helm.say(Verb.RELEASE, s, now)) for s in STATIONS),
    *(said(s, "is heard", lambda helm, now, s=s: helm.heard(s, now)) for s in STATIONS),
    Step("tick", tick, TICK),
]


@cache
def transitions() -> list[Transition[WatchedHelm]]:
    return list(explore(WatchedHelm(), STEPS, helm_twin, helm_state))


def test_the_whole_space_is_walked():
    assert len(transitions()) > 20_000


def test_no_wheel_turns_without_permission_a_fresh_stick_and_command():
    for transition in transitions():
        helm, now = transition.after, transition.now
        if helm.drive.wheels(now) == STANDSTILL and helm.drive._said == STANDSTILL:
            continue
        assert helm.transfer.commander != NOBODY, transition.step
        assert helm.allowed, transition.step
        assert helm.stick_at is not None, transition.step
        assert now - helm.stick_at < STALE + ROUNDING, transition.step
        assert helm.heard_at is not None
        assert now - helm.heard_at < SILENT + ROUNDING, transition.step


def test_what_the_wheels_were_told_last_is_what_they_should_be_told():
    for transition in transitions():
        helm, now = transition.after, transition.now
        if helm.drive.wheels(now) == STANDSTILL:
            assert helm.drive._said == STANDSTILL, transition.step


def test_permission_is_an_event_of_the_commander_with_the_stick_at_rest():
    for transition in transitions():
        granted = [e for e in transition.effects if isinstance(e, Permission) and e.granted]
        if granted:
            station, name = transition.step.split(maxsplit=1)
            assert name == "permits"
            assert transition.after.transfer.commander == int(station)
            before = transition.before
            if before.transfer.commander == int(station):
                assert before.drive._stick.at_rest


def test_a_stop_of_any_station_stops_in_one_step():
    for transition in transitions():
        if transition.step.endswith("stops"):
            assert not transition.after.drive.permitted
            assert [e for e in transition.effects if isinstance(e, Wheels)][-1] == STANDSTILL


def test_a_transfer_withdraws_the_permission():
    for transition in transitions():
        if any(isinstance(effect, Transferred) for effect in transition.effects):
            kinds = [type(effect) for effect in transition.effects]
            after = transition.effects[len(kinds) - 1 - kinds[::-1].index(Transferred) :]
            assert STANDSTILL in after
            if transition.after.drive.permitted:
                assert transition.step.endswith("permits"), "given anew by the new commander"


def test_a_commander_is_released_two_seconds_after_it_was_heard_last_and_not_before():
    for transition in transitions():
        helm = transition.after
        if helm.transfer.commander != NOBODY:
            assert transition.now - helm._heard < LOST - ROUNDING
        released = Transferred(transition.before.transfer.commander, NOBODY) in transition.effects
        if released and transition.step == "tick":
            assert transition.now - transition.before._heard >= LOST - ROUNDING


def test_the_bridge_takes_command_by_one_frame_from_every_state():
    for transition in transitions():
        if transition.step in ("1 forward", "1 rest", "1 permits"):
            assert transition.after.transfer.commander == 1


def test_nobody_elses_frame_moves_a_wheel():
    for transition in transitions():
        commander = transition.before.transfer.commander
        if transition.step.startswith(("tick", str(commander))) or transition.step.endswith(("stops", "releases")):
            continue
        if transition.after.transfer.commander == commander:
            assert transition.after.drive._stick == transition.before.drive._stick
            assert not (transition.after.drive.permitted and not transition.before.drive.permitted)
