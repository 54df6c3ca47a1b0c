"""Walks through every state that a machine can reach.

A machine is copied, given every input in turn, and what comes out is looked at; states that differ only in when
they happen are one. The machines are the shipped ones with their shipped constants, on a clock that ticks once a
second: every limit of theirs is a whole number of seconds.
"""

from collections.abc import Callable, Hashable, Iterator
from typing import Any, Generic, TypeVar

import msgspec

from timonel.core.alerts import Alerts
from timonel.core.command import STATIONS, CommandTransfer, Verb
from timonel.core.effects import Event
from timonel.vehicles.boat.pilot import DATA_AGE, Mode, Pilot, PilotReport, Steer

M = TypeVar("M")
TICK = 1.0  # s


class Step(msgspec.Struct, frozen=True):
    """One input to a machine: what it is called, what it does, and how much time passes before it."""

    name: str
    apply: Callable[[Any, float], list[Event]]
    wait: float = 0.0


class Transition(msgspec.Struct, Generic[M], frozen=True):
    """What one input did. `before` and `after` are machines, not to be changed."""

    step: str
    before: M
    after: M
    effects: list[Event]
    now: float
    changed: bool


def explore(
    start: M, steps: list[Step], copy: Callable[[M], M], state: Callable[[M, float], Hashable]
) -> Iterator[Transition[M]]:
    """Every transition from every state reachable from `start`, breadth first."""
    seen = {state(start, 0.0)}
    frontier = [(start, 0.0)]
    while frontier:
        following = []
        for machine, time in frontier:
            before = state(machine, time)
            for step in steps:
                now = time + step.wait
                twin = copy(machine)
                effects = step.apply(twin, now)
                key = state(twin, now)
                yield Transition(step.name, machine, twin, effects, now, key != before)
                if key not in seen:
                    seen.add(key)
                    following.append((twin, now))
        frontier = following


def twin_of(machine: M) -> M:
    """A machine that goes its own way from here."""
    twin = object.__new__(type(machine))
    twin.__dict__.update(machine.__dict__)
    return twin


# Command transfer ---------------------------------------------------------------------------------


def command_state(command: CommandTransfer, now: float) -> Hashable:
    """All that the transfer of command knows."""
    assert command.__dict__.keys() == {"timeout", "on_timeout", "commander", "queue", "deadline"}
    return command.commander, command.queue, command.deadline and command.deadline - now


def say(verb: Verb, station: int, requester: int | None = None) -> Step:
    def apply(command: CommandTransfer, now: float) -> list[Event]:
        return command.receive(verb, station, now, requester)

    return Step(f"{verb.name} {station}" + (f" for {requester}" if requester else ""), apply)


COMMAND_STEPS = [
    *(say(verb, station) for verb in Verb for station in STATIONS),
    *(
        say(verb, station, requester)
        for verb in (Verb.RELEASE, Verb.ACKNOWLEDGE, Verb.DENY)
        for station in STATIONS
        for requester in STATIONS
    ),
    Step("tick", lambda command, now: command.expire(now), TICK),
]


# Pilot --------------------------------------------------------------------------------------------


class WatchedPilot(Pilot):
    """A pilot of whom we remember what it was told last: the course, None to let go, or "nothing" yet."""

    def __init__(self, adopts: bool = False) -> None:
        super().__init__(Alerts(), 0.0)
        self.adopts = adopts
        self.told: int | str | None = "nothing"


def pilot_twin(pilot: WatchedPilot) -> WatchedPilot:
    twin = twin_of(pilot)
    twin._alerts = twin_of(pilot._alerts)
    twin._alerts._alerts = dict(pilot._alerts._alerts)
    return twin


PILOT_STATE = {
    *("_alerts", "_mode", "_setpoint", "_alarm", "_bus_heard", "_bus_silent", "_heading", "_heading_heard"),
    *("_report", "_report_heard", "_report_due", "_command", "_ours", "_may_hold", "_repeat_at"),
    *("_recover_at", "told", "adopts", "objection", "manner"),
}


def pilot_state(pilot: WatchedPilot, now: float) -> Hashable:
    """All that the pilot knows; a time, and the manner of the last order, is left out where no rule asks for it."""
    assert pilot.__dict__.keys() == PILOT_STATE
    assert pilot.objection is None
    command = pilot._command
    return (
        pilot._mode,
        pilot._setpoint,
        pilot._alarm,
        None if pilot._bus_silent else pilot._bus_heard - now,
        pilot._heading,
        max(pilot._heading_heard - now, -DATA_AGE),
        pilot._report,
        max(pilot._report_heard - now, -DATA_AGE),
        None if pilot._report is None or pilot._bus_silent else max(pilot._report_due - now, 0.0),
        command and (command.mode, command.setpoint, command.deadline - now, command.told),
        pilot._ours,
        pilot._may_hold,
        pilot._repeat_at - now if pilot._repeats else None,
        pilot._recover_at and pilot._recover_at - now,
        frozenset(id for id, alert in pilot._alerts._alerts.items() if alert.active),
        pilot.told,
    )


def watched(apply: Callable[[Pilot, float], list[Event]]) -> Callable[[WatchedPilot, float], list[Event]]:
    """An input, with what is due before it and at once after it, as the gateway's timer does it."""

    def remember(pilot: WatchedPilot, now: float) -> list[Event]:
        effects = pilot.expire(now) + apply(pilot, now) + pilot.expire(now)
        for effect in effects:
            if isinstance(effect, Steer):
                pilot.told = effect.setpoint
        return effects

    return remember


def heard(apply: Callable[[Pilot, float], list[Event]]) -> Callable[[WatchedPilot, float], list[Event]]:
    """What comes in from the backbone is a frame in the first place."""
    return watched(lambda pilot, now: pilot.bus_heard(now) + apply(pilot, now))


HEADING, ELSEWHERE = 900, 1200  # tenths: the boat's heading, and a course that is not it

PILOT_STEPS = [
    Step("engage", watched(lambda pilot, now: pilot.engage(1, now))),
    Step("disengage", watched(lambda pilot, now: pilot.disengage(now))),
    Step("set", watched(lambda pilot, now: pilot.set_heading(ELSEWHERE, 1, now))),
    Step("turn", watched(lambda pilot, now: pilot.turn(ELSEWHERE - (pilot.setpoint or 0), 1, now))),
    Step("frame", heard(lambda pilot, now: [])),
    Step("heading", heard(lambda pilot, now: pilot.heading_heard(HEADING / 10, now))),
    Step("reports standby", heard(lambda pilot, now: pilot.reported(PilotReport(Mode.STANDBY), now))),
    Step("reports hold", heard(lambda pilot, now: pilot.reported(PilotReport(Mode.HEADING_HOLD, HEADING), now))),
    Step("reports unknown", heard(lambda pilot, now: pilot.reported(PilotReport(Mode.UNKNOWN), now))),
    Step("tick", watched(lambda pilot, now: []), TICK),
]
