"""What happened so far, counted for health and told to the log, with a limit on what a peer can make us write."""

import logging
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import msgspec

from timonel.core.alerts import AlertChanged, Priority
from timonel.core.command import NOBODY, Denied, Overridden, Requested, Transferred
from timonel.core.effects import Effect, Refused, Rejected, SecurityEvent
from timonel.core.pace import Allowance
from timonel.vehicles.boat.foreign_alerts import FIRST, PLACES
from timonel.vehicles.boat.pilot import Mode, PilotChanged, Steer
from timonel.vehicles.boat.pilots.driver import GaveUp, Progressed
from timonel.vehicles.boat.sources import SourceChanged, SourceDamaged
from timonel.vehicles.rover.drive import Permission

LINES, LINES_WINDOW = 10, 10.0  # so many log lines about the same thing in so many seconds
KINDS_MAX = 256  # that are told apart, however inventive a peer is
ALWAYS_SAID = (Transferred, AlertChanged, Permission)
FOREIGN = "alert of another device"

logger = logging.getLogger("timonel")


class Health:
    """Counts by kind of event, and the log lines about them."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self._allowances: defaultdict[str, Allowance] = defaultdict(partial(Allowance, LINES, LINES_WINDOW))
        self._unsaid: Counter[str] = Counter()
        self._watched: dict[str, Callable[[], Mapping[str, int]]] = {}

    def event(self, event: Effect, now: float) -> None:
        """Count and log something that happened at `now` (s)."""
        kind = _kind(event)
        if kind not in self.counts and len(self.counts) >= KINDS_MAX:
            kind = "other"
        self.counts[kind] += 1
        if (isinstance(event, ALWAYS_SAID) and kind != FOREIGN) or self._allowances[kind].take(now):
            self._log(event, self._unsaid.pop(kind, 0))
        else:
            self._unsaid[kind] += 1

    def _log(self, event: Effect, unsaid: int) -> None:
        more = f" (and {unsaid} more before)" if unsaid else ""
        logger.log(level(event), "%s%s", describe(event), more, extra={"fields": fields(event)})

    def link(self, name: str, connected: bool, reason: str) -> None:
        """Log that a link came or went."""
        fields = {"event": "link", "link": name, "connected": connected, "reason": reason}
        state = "connected" if connected else "not connected"
        text = f"{name}: {state} ({reason})" if reason else f"{name}: {state}"
        logger.log(logging.INFO if connected else logging.WARNING, text, extra={"fields": fields})

    def fault(self, source: str) -> None:
        """Count and log the exception that is being handled, which what came from `source` brought about."""
        self.counts["fault"] += 1
        logger.exception(
            "%s: fault in the gateway itself", source, extra={"fields": {"event": "fault", "link": source}}
        )

    def watch(self, name: str, counters: Callable[[], Mapping[str, int]]) -> None:
        """Let `report` tell what `counters` gives then."""
        self._watched[name] = counters

    def report(self) -> None:
        """Log all counters that are not zero."""
        watched = self._watched | {"events": lambda: self.counts}
        counters = {name: _not_zero(counters()) for name, counters in watched.items()}
        text = "; ".join(f"{name}: {_listed(counts)}" for name, counts in counters.items() if counts)
        logger.info("health: %s", text or "nothing heard yet", extra={"fields": {"event": "health", **counters}})


def _not_zero(counts: Mapping[str, int]) -> dict[str, int]:
    return {name: count for name, count in counts.items() if count}


def _listed(counts: dict[str, int]) -> str:
    return ", ".join(f"{name.replace('_', ' ')} {count}" for name, count in counts.items())


def _kind(event: Effect) -> str:
    match event:
        case Rejected(reason=reason, source=source):
            return f"rejected {source}: {reason}" if source else f"rejected: {reason}"
        case Refused(reason=reason, station=station):
            return f"refused {station}: {reason}"
        case SecurityEvent(reason=reason, port=port):
            return f"security {port}: {reason}"
        case AlertChanged(alert=alert) if FIRST <= alert.kind.id < FIRST + PLACES:
            return FOREIGN
        case _:
            return type(event).__name__


def level(event: Effect) -> int:
    """How severe an event is, as `logging` has it."""
    match event:
        case AlertChanged(alert=alert) if alert.active and not alert.acknowledged:
            return logging.ERROR if alert.kind.priority <= Priority.ALARM else logging.WARNING
        case SecurityEvent() | SourceDamaged(damaged=True):
            return logging.WARNING
        case Steer() | Progressed():  # repeated every second, or several times
            return logging.DEBUG
        case _:
            return logging.INFO


def describe(event: Effect) -> str:
    """An event as a sentence for people."""
    match event:
        case Transferred(previous=previous, commander=commander):
            return f"command passes from {_station(previous)} to {_station(commander)}"
        case Requested(station=station):
            return f"{_station(station)} requests command"
        case Denied(station=station):
            return f"the request of {_station(station)} is denied"
        case Overridden(stations=stations):
            return f"the bridge insists: no more requests of {', '.join(map(_station, stations))}"
        case Refused(reason=reason, station=station):
            return f"{_station(station)} refused: {reason}"
        case SecurityEvent(reason=reason, port=port, station=station):
            return f"{port}: {reason} (station {station} named)"
        case Rejected(reason=reason, data=data, source=source):
            return f"{source or 'a peer'}: rejected, {reason}: {_readable(data)}"
        case PilotChanged(mode=mode, setpoint=setpoint):
            return f"pilot: {'unknown mode' if mode is Mode.UNKNOWN else mode.value}{_course(setpoint)}"
        case Steer(setpoint=setpoint):
            return "to the pilot: " + ("let go" if setpoint is None else f"hold{_course(setpoint)}")
        case Progressed():
            return "the pilot followed a step"
        case GaveUp(reason=reason):
            return f"the pilot's course is given up: {reason}"
        case SourceChanged(datum=datum, source=source, previous=previous):
            return f"{datum}: from {source}" + (f", no longer {previous}" if previous else "")
        case SourceDamaged(port=port, damaged=damaged, share=share):
            return f"{port}: {share:.0%} of its sentences are damaged, " + ("it comes last" if damaged else "it counts")
        case Permission(granted=granted, reason=reason):
            return f"drives {'enabled' if granted else 'stopped'}: {reason}"
        case AlertChanged(alert=alert):
            return f"{alert.kind.priority.name.lower()} {_state(event)}: {alert.kind.name}: {alert.text}"
        case _:
            values = ", ".join(f"{name} {_plain(value)}" for name, value in msgspec.structs.asdict(event).items())
            return f"{type(event).__name__}: {values}"


def _station(number: int) -> str:
    return "nobody" if number == NOBODY else f"station {number}"


def _course(tenths: int | None) -> str:
    return "" if tenths is None else f" {tenths / 10:05.1f}"


def _state(changed: AlertChanged) -> str:
    alert = changed.alert
    if not alert.active:
        return "is over"
    if alert.silenced_until is not None:
        return "silenced"
    return "acknowledged" if alert.acknowledged else "stands"


def _readable(data: bytes) -> str:
    """What a peer sent, fit for a log."""
    return repr(data[:100])[2:-1]


def fields(event: Effect) -> dict[str, Any]:
    """An event as JSON has it."""
    return {"event": type(event).__name__} | {
        name: _plain(value) for name, value in msgspec.structs.asdict(event).items()
    }


def _plain(value: object) -> Any:
    if isinstance(value, bytes):
        return _readable(value)
    return msgspec.to_builtins(value)
