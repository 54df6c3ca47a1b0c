"""Every route there is, once: what it is called with, who may, what does it. All else is not found.

`docs/security.md` and `/api/v1/openapi.json` are written from this table, and a test walks it with every role.
"""

from collections.abc import Awaitable, Callable
from typing import Any

import msgspec

from timonel.web import api, autopilot, signalk_api
from timonel.web.access import Least
from timonel.web.api import Call, Reply
from timonel.web.autopilot import BASE as AUTOPILOTS
from timonel.web.messages import AlertState, Answer, CommandState, Snapshot, You

Handle = Callable[[Call], Awaitable[Reply]]


class Parameter(msgspec.Struct, frozen=True):
    """Of the query: a JSON schema, and what it means."""

    name: str
    schema: dict[str, Any]
    about: str


class Route(msgspec.Struct, frozen=True):
    """A method and a path; `least` is the lowest role that may.

    In a path `{id}` is anything up to the next slash, `{path}` all that follows.
    `handle` None: a file, a socket, the description of all this. `body` is what comes in, `answer` what goes out with
    `status`; `refusals` are the statuses of its own that it may say no with.
    """

    method: str
    path: str
    least: Least
    about: str
    handle: Handle | None = None
    body: Any = None
    answer: Any = None
    status: int = 200
    query: tuple[Parameter, ...] = ()
    refusals: tuple[int, ...] = ()

    @property
    def changes(self) -> bool:
        """Whether it is more than a look."""
        return self.method in ("POST", "PUT", "DELETE")

    @property
    def described(self) -> bool:
        """Whether it is our own interface; that of Signal K is described by its specification."""
        return self.handle is not None and self.path.startswith("/api/")


SOCKET = "/api/v1/socket"
OPENAPI = "/api/v1/openapi.json"
FILES = "/{file}"
SIGNALK = "/signalk"
STREAM = "/signalk/v1/stream"
HISTORY = (
    Parameter("series", {"type": "string", "maxLength": 1000}, "names with commas between them; all without it"),
    Parameter("seconds", {"type": "integer", "minimum": 1, "maximum": 3600, "default": 600}, "how far back"),
    Parameter("step", {"type": "integer", "minimum": 1, "maximum": 3600, "default": 1}, "every so many seconds one"),
)
NOBODY, READER, STATION = Least.NOBODY, Least.READER, Least.STATION

ROUTES = (
    Route("GET", FILES, NOBODY, "The console's pages, scripts, fonts and sounds."),
    Route("GET", "/api/v1/about", NOBODY, "What this is.", api.about, answer=api.About),
    Route("GET", OPENAPI, NOBODY, "This interface, described."),
    Route("POST", "/api/v1/login", NOBODY, "Sign in: the cookie of a reader.", api.login, api.Login, You,
          refusals=(403,)),
    Route("POST", "/api/v1/logout", NOBODY, "Forget the cookie, and the stations with it.", api.logout, status=204),
    Route("GET", "/api/v1/you", READER, "Who you are.", api.you, answer=You),
    Route("GET", "/api/v1/state", READER, "Everything as it stands.", api.state, answer=Snapshot),
    Route("GET", "/api/v1/history", READER, "The last hour at 1 Hz.", api.history, answer=api.HistoryAnswer,
          query=HISTORY, refusals=(400,)),
    Route("GET", "/api/v1/stations", READER, "The stations, and who has command.", api.stations, answer=CommandState),
    Route("GET", "/api/v1/alerts", READER, "The alerts, most urgent first.", api.alerts, answer=list[AlertState]),
    Route("GET", "/tiles/{path}", READER, "A tile of the map, if there is one.", api.tile, status=204),
    Route("SOCKET", SOCKET, READER, "Everything as it changes; the orders of a station."),
    Route("POST", "/api/v1/pairings", READER, "Ask to be a station: six digits appear at the helm.", api.ask_pairing,
          api.PairingRequest, api.PairingAsked, 202, refusals=(404, 409)),
    Route("POST", "/api/v1/pairings/code", READER, "Tell the six digits: the cookie of a station.", api.tell_code,
          api.PairingCode, You, refusals=(403,)),
    Route("POST", "/api/v1/commands", STATION, "An order of a station, and what became of it.", api.command,
          api.CommandRequest, Answer, refusals=(400, 403)),
    Route("GET", SIGNALK, NOBODY, "Signal K: where it is served.", signalk_api.discovery),
    Route("GET", f"{SIGNALK}/v1/api", READER, "Signal K: all that is known of the boat.", signalk_api.everything),
    Route("GET", f"{SIGNALK}/v1/api/{{path}}", READER, "Signal K: a part of that.", signalk_api.part),
    Route("SOCKET", STREAM, READER, "Signal K: deltas as it changes."),
    Route("GET", AUTOPILOTS, READER, "Signal K: the autopilots.", autopilot.pilots),
    Route("GET", f"{AUTOPILOTS}/_providers/_default", READER, "Signal K: which autopilot is meant.", autopilot.default),
    Route("POST", f"{AUTOPILOTS}/_providers/_default/{{id}}", STATION, "Signal K: mean this autopilot.",
          autopilot.choose_default),
    Route("GET", f"{AUTOPILOTS}/{{id}}", READER, "Signal K: how an autopilot stands.", autopilot.status),
    Route("GET", f"{AUTOPILOTS}/{{id}}/options", READER, "Signal K: its states and modes.", autopilot.options),
    Route("GET", f"{AUTOPILOTS}/{{id}}/state", READER, "Signal K: its state.", autopilot.state),
    Route("GET", f"{AUTOPILOTS}/{{id}}/mode", READER, "Signal K: its mode.", autopilot.mode),
    Route("GET", f"{AUTOPILOTS}/{{id}}/target", READER, "Signal K: the course that it holds.", autopilot.target),
    Route("POST", f"{AUTOPILOTS}/{{id}}/engage", STATION, "Signal K: hold the present heading.", autopilot.engage),
    Route("POST", f"{AUTOPILOTS}/{{id}}/disengage", STATION, "Signal K: let go.", autopilot.disengage),
    Route("PUT", f"{AUTOPILOTS}/{{id}}/state", STATION, "Signal K: engage or let go.", autopilot.set_state,
          autopilot.Wanted),
    Route("PUT", f"{AUTOPILOTS}/{{id}}/target", STATION, "Signal K: hold a course.", autopilot.set_target,
          autopilot.Angle),
    Route("PUT", f"{AUTOPILOTS}/{{id}}/target/adjust", STATION, "Signal K: change the course.",
          autopilot.adjust_target, autopilot.Angle),
    *(
        Route(method, f"{AUTOPILOTS}/{{id}}/{what}", STATION, "Signal K: not done by this autopilot.",
              autopilot.not_here)
        for method, what in (
            ("PUT", "mode"), ("POST", "tack/port"), ("POST", "tack/starboard"), ("POST", "gybe/port"),
            ("POST", "gybe/starboard"), ("POST", "dodge"), ("PUT", "dodge"), ("DELETE", "dodge"),
            ("POST", "courseCurrentPoint"), ("POST", "courseNextPoint"),
        )
    ),
)  # fmt: skip
