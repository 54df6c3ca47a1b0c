"""Signal K's autopilot API v2: what a paired station may order, said on its port as everything else is said.

```
asked for                        said                  answer
engage, state auto               ENGAGE                200 when the pilot reports it, 504 when it has not within 2 s
disengage, state standby         DISENGAGE             the same
target, target/adjust            SETHEADING            the same
mode, tack, gybe, dodge, course  -                     501
```
It never goes round the transfer of command. While nobody has command the station asks for it first, and has it at once
by the rules; while another station has it the answer is 403, and whoever wants it asks as a console does (REQCMD).
Source: signalk-server, "Autopilot API"; that 501 where its providers say 500 is HTTP's word for it.
"""

from math import pi, radians, tau
from typing import Literal

import msgspec

from timonel.core.command import NOBODY
from timonel.interop.signalk.boat import MODES, STATES, STEERING
from timonel.interop.signalk.told import OWN
from timonel.vehicles.boat.pilot import Pilot
from timonel.web.api import Call, Problem, Reply, judged
from timonel.web.messages import Command, SteeringVerb
from timonel.web.outcome import Verdict
from timonel.web.signalk_api import Done, signalk

BASE = "/signalk/v2/api/vessels/self/autopilots"
DEFAULT = "_default"
ORDERS: dict[str, SteeringVerb] = {"auto": "ENGAGE", "standby": "DISENGAGE"}
NOT_IN_COMMAND = "not in command"
OPTIONS = {
    "states": [{"name": name, "engaged": STEERING[mode]} for mode, name in STATES.items()],
    "modes": sorted(set(MODES.values())),
}


class Wanted(msgspec.Struct, frozen=True):
    """A state or a mode by its name."""

    value: str


class Angle(msgspec.Struct, frozen=True):
    """A course, or a change of it."""

    value: float
    units: Literal["rad", "deg"] = "rad"

    @property
    def in_rad(self) -> float:
        return radians(self.value) if self.units == "deg" else self.value


# How it stands ----------------------------------------------------------------------------------------------


async def pilots(call: Call) -> Reply:
    signalk(call)
    return Reply({OWN: {"provider": OWN, "isDefault": True}})


async def default(call: Call) -> Reply:
    signalk(call)
    return Reply({"id": OWN})


async def choose_default(call: Call) -> Reply:
    """There is but one."""
    _pilot(call)
    return Reply(Done())


async def status(call: Call) -> Reply:
    pilot = _pilot(call)
    return Reply(
        {
            "options": OPTIONS,
            "state": STATES.get(pilot.mode),
            "mode": MODES.get(pilot.mode),
            "target": _target(pilot),
            "engaged": STEERING.get(pilot.mode, False),
        }
    )


async def options(call: Call) -> Reply:
    _pilot(call)
    return Reply(OPTIONS)


async def state(call: Call) -> Reply:
    return Reply({"value": STATES.get(_pilot(call).mode)})


async def mode(call: Call) -> Reply:
    return Reply({"value": MODES.get(_pilot(call).mode)})


async def target(call: Call) -> Reply:
    return Reply({"value": _target(_pilot(call))})


def _pilot(call: Call) -> Pilot:
    """The pilot that a path names. Raises Problem."""
    server = signalk(call)
    if call.path.get("id") not in (OWN, DEFAULT):
        raise Problem(404, "there is no such autopilot")
    return server.boat.helm.pilot


def _target(pilot: Pilot) -> float | None:
    """The course that is held, rad, in the boat's heading reference; None where there is none."""
    if not STEERING.get(pilot.mode, False) or pilot.setpoint is None:
        return None
    return round(radians(pilot.setpoint / 10), 9)


# Orders -----------------------------------------------------------------------------------------------------


async def engage(call: Call) -> Reply:
    _pilot(call)
    return await _order(call, "ENGAGE")


async def disengage(call: Call) -> Reply:
    _pilot(call)
    return await _order(call, "DISENGAGE")


async def set_state(call: Call) -> Reply:
    _pilot(call)
    verb = ORDERS.get(call.body.value)
    if verb is None:
        known = call.body.value in STATES.values()
        raise Problem(501 if known else 400, f"value: only {' and '.join(ORDERS)} can be set")
    return await _order(call, verb)


async def set_target(call: Call) -> Reply:
    _pilot(call)
    course = call.body.in_rad
    if not -pi <= course <= tau:
        raise Problem(400, "value: a course is -pi to 2 pi rad")
    return await _order(call, "SETHEADING", course % tau)


async def adjust_target(call: Call) -> Reply:
    held = _target(_pilot(call))
    change = call.body.in_rad
    if not -pi <= change <= pi:
        raise Problem(400, "value: a change of course is -pi to pi rad")
    if held is None:
        raise Problem(400, "no course is held")
    return await _order(call, "SETHEADING", (held + change) % tau)


async def not_here(call: Call) -> Reply:
    _pilot(call)
    raise Problem(501, "this autopilot cannot be told to")


async def _order(call: Call, verb: SteeringVerb, parameter: float | None = None) -> Reply:
    """Say it as the station that asks. Raises Problem."""
    console, station = call.console, _station(call)
    port = console.ports[station]
    if console.state.transfer.commander == NOBODY:
        port.carry_out(Command(0, "REQCMD"))
    order = Command(0, verb, parameter)
    result = port.carry_out(order)
    verdict = result if isinstance(result, Verdict) else await judged(result, order, console)
    match verdict.outcome:
        case "refused":
            raise Problem(403 if verdict.reason == NOT_IN_COMMAND else 400, verdict.reason)
        case "unconfirmed":
            raise Problem(504, verdict.reason)
    return Reply(Done())


def _station(call: Call) -> int:
    """As which station somebody orders: the only one that he may be, what he says, what is configured."""
    said = call.query.get("station")
    if said is not None and said not in map(str, call.console.names):
        raise Problem(400, "station: 1 to 4")
    station = call.rights.only_station if said is None else int(said)
    station = signalk(call).settings.station if station is None else station
    if station is None:
        raise Problem(400, "you may be several stations: say ?station=1..4, or station in [signalk]")
    if station not in call.rights.stations:
        raise Problem(403, "not paired with this station")
    return station
