"""What the routes of the HTTP interface do: each takes a call and gives a reply."""

import asyncio
import hashlib
from collections.abc import Mapping
from typing import Annotated, Any

import msgspec

from timonel import __version__
from timonel.web.access import Least, Rights
from timonel.web.console import Console
from timonel.web.history import HOUR, PERIOD
from timonel.web.messages import Acknowledge, Answer, Command, Limit, Silence, StationNumber, Stop, You
from timonel.web.outcome import Judge, Verdict
from timonel.web.port import Order
from timonel.web.state import seconds

DECIDE_EVERY = 0.05  # s


class Problem(Exception):
    """A request that cannot be served: the status, and a sentence that says why."""

    def __init__(self, status: int, text: str, headers: Mapping[str, str] | None = None) -> None:
        super().__init__(text)
        self.status = status
        self.text = text
        self.headers = headers or {}


class Call(msgspec.Struct, frozen=True):
    """A request that may be made: of whom, and what it says. `body` is what the route declares.

    `path` is what stands in the places that the route leaves open, `host` by which name we were called.
    """

    console: Console
    rights: Rights
    address: str
    query: Mapping[str, str]
    body: Any
    path: Mapping[str, str] = {}
    host: str = ""


class Reply(msgspec.Struct, frozen=True):
    """What comes back: something to be put in words, or words of a kind."""

    what: Any = None
    status: int = 200
    headers: Mapping[str, str] = {}
    words: bytes | None = None


# What goes in and out ---------------------------------------------------------------------------------------


class ErrorText(msgspec.Struct, frozen=True):
    """Why a request was not served."""

    error: str


class Login(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The token of the configuration."""

    token: Annotated[str, msgspec.Meta(max_length=200)]


class PairingRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Which station this console wants to be, and what it is called there."""

    station: StationNumber
    name: Annotated[str, msgspec.Meta(max_length=40)] = ""


class PairingAsked(msgspec.Struct, frozen=True):
    """Tell the six digits that are shown at the helm, until `deadline` of the server's `clock`."""

    pairing: int
    station: int
    deadline: float
    clock: float


class PairingCode(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The six digits."""

    pairing: Annotated[int, msgspec.Meta(ge=0, le=2**53 - 1)]
    code: Annotated[str, msgspec.Meta(min_length=6, max_length=6)]


class CommandRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An order as on the socket, and the station that gives it, if you may be several."""

    order: Command | Acknowledge | Silence | Stop | Limit
    station: StationNumber | None = None


class HistoryAnswer(msgspec.Struct, frozen=True):
    """Values every `step` seconds up to `ended`, a time of the server's `clock`, oldest first; null: not known."""

    clock: float
    ended: float
    step: float
    series: dict[str, list[float | None]]


class About(msgspec.Struct, frozen=True):
    """What this is, whether a token is needed, and the nearest zoom of the map tiles that it has, null for none."""

    name: str
    vehicle: str
    version: str
    token_needed: bool
    tiles: int | None


# Who you are ------------------------------------------------------------------------------------------------


async def about(call: Call) -> Reply:
    console = call.console
    feed = console.feed
    nearest = None if console.tiles is None else console.tiles.nearest
    return Reply(About(feed.name, feed.vehicle, __version__, not console.access.open, nearest))


async def you(call: Call) -> Reply:
    return Reply(_you(call.rights))


async def login(call: Call) -> Reply:
    access, body = call.console.access, call.body
    if not access.knows(body.token, call.address):
        raise Problem(403, "wrong token")
    if access.open:
        return Reply(_you(call.rights))
    rights = call.rights if call.rights.least >= Least.READER else Rights(Least.READER)
    return Reply(_you(rights), headers={"Set-Cookie": access.seal(rights.stations)})


async def logout(call: Call) -> Reply:
    return Reply(status=204, headers={"Set-Cookie": call.console.access.forget()})


async def ask_pairing(call: Call) -> Reply:
    console, body = call.console, call.body
    now = console.gateway.now
    if body.station not in console.ports:
        raise Problem(404, "no console may be this station")
    if body.station in call.rights.stations:
        raise Problem(409, "you may be this station already")
    name = "".join(letter if letter.isprintable() else "?" for letter in body.name)
    asked = console.pairings.ask(body.station, name, call.address, now) if console.asking.take(now) else None
    if asked is None:
        raise Problem(429, "too many ask at once; try again in a minute", {"Retry-After": "60"})
    return Reply(PairingAsked(asked.number, asked.station, seconds(asked.deadline), seconds(now)), 202)


async def tell_code(call: Call) -> Reply:
    console, body = call.console, call.body
    access, now = console.access, console.gateway.now
    access.check(call.address)
    station = console.pairings.tell(body.pairing, body.code, now)
    if station is None:
        access.failed(call.address)
        raise Problem(403, "these are not the digits, or it is too late")
    rights = Rights(max(call.rights.least, Least.STATION), tuple(sorted({*call.rights.stations, station})))
    return Reply(_you(rights), headers={"Set-Cookie": access.seal(rights.stations)})


def _you(rights: Rights) -> You:
    return rights.you(rights.only_station)


# What is shown ----------------------------------------------------------------------------------------------


async def state(call: Call) -> Reply:
    console = call.console
    console.refresh(console.gateway.now)
    return Reply(words=console.feed.snapshot(_you(call.rights)))


async def stations(call: Call) -> Reply:
    return Reply(call.console.state.topics(call.console.gateway.now)["command"])


async def alerts(call: Call) -> Reply:
    return Reply(call.console.state.topics(call.console.gateway.now)["alerts"])


async def history(call: Call) -> Reply:
    """Put in words beside the loop: an hour of everything takes as long as many commands."""
    kept, now = call.console.history, call.console.gateway.now
    names = [name for name in call.query.get("series", "").split(",") if name] or kept.names
    if unknown := [name for name in names if name not in kept.names]:
        raise Problem(400, f"no such series: {unknown[0][:40]}; there are {', '.join(kept.names)}")
    samples, step = _whole(call.query, "seconds", 600, HOUR), _whole(call.query, "step", 1, HOUR)
    copy = kept.copy()

    def words() -> bytes:
        series = {name: copy.last(name, samples, step) for name in names}
        return msgspec.json.encode(HistoryAnswer(seconds(now), seconds(copy.ended), step * PERIOD, series))

    return Reply(words=await asyncio.to_thread(words))


def _whole(query: Mapping[str, str], name: str, default: int, highest: int) -> int:
    text = query.get(name, str(default))
    if not (text.isascii() and text.isdecimal() and len(text) < 6 and 1 <= int(text) <= highest):
        raise Problem(400, f"{name}: {text[:40]!r} is not a whole number in 1..{highest}")
    return int(text)


async def tile(call: Call) -> Reply:
    """A tile that there is not is nothing to complain of: nobody has the whole earth."""
    tiles = call.console.tiles
    found = None if tiles is None else await asyncio.to_thread(tiles.get, call.path["path"])
    if found is None:
        return Reply(status=204)
    return Reply(
        words=found,
        headers={"Content-Type": "image/png", "Cache-Control": "private, max-age=86400", "ETag": _tag(found)},
    )


def _tag(words: bytes) -> str:
    return f'"{hashlib.blake2b(words, digest_size=12).hexdigest()}"'


# What is said -----------------------------------------------------------------------------------------------


async def command(call: Call) -> Reply:
    """The way of the socket: the same port, the same verdict. Waits for it, 2 s at most."""
    console, body = call.console, call.body
    station = call.rights.only_station if body.station is None else body.station
    if station is None:
        raise Problem(400, "station: say which you are, you may be several")
    if station not in call.rights.stations:
        raise Problem(403, "not paired with this station")
    result = console.ports[station].carry_out(body.order)
    verdict = result if isinstance(result, Verdict) else await judged(result, body.order, console)
    return Reply(Answer(body.order.id, verdict.outcome, verdict.reason))


async def judged(judge: Judge, order: Order, console: Console) -> Verdict:
    """How it ended; of a request for command, which takes as long as people do, that it waits."""
    while (verdict := judge(console.gateway.now)) is None:
        if isinstance(order, Command) and order.verb == "REQCMD":
            return Verdict("sent", "the commander is asked")
        await asyncio.sleep(DECIDE_EVERY)
    return verdict
