"""What the routes of Signal K do: discovery, and what is known as a tree."""

from typing import Any

import msgspec

from timonel import __version__
from timonel.interop.signalk.deltas import SCHEMA, tree
from timonel.interop.signalk.told import OWN
from timonel.web.api import Call, Problem, Reply
from timonel.web.signalk import SignalK


class Failed(msgspec.Struct, frozen=True, rename={"status_code": "statusCode"}):
    """Why a request of Signal K was not served."""

    message: str
    status_code: int
    state: str = "FAILED"


class Done(msgspec.Struct, frozen=True, rename={"status_code": "statusCode"}):
    """A request of Signal K was served."""

    state: str = "COMPLETED"
    status_code: int = 200
    message: str = "OK"


def signalk(call: Call) -> SignalK:
    """The server of a boat. Raises Problem for a rover, which Signal K knows nothing of."""
    if call.console.signalk is None:
        raise Problem(404, "there is no such page")
    return call.console.signalk


async def discovery(call: Call) -> Reply:
    signalk(call)
    secure = "s" if call.console.access.web.certificate else ""
    version = {
        "version": SCHEMA,
        "signalk-http": f"http{secure}://{call.host}/signalk/v1/api/",
        "signalk-ws": f"ws{secure}://{call.host}/signalk/v1/stream",
    }
    return Reply({"endpoints": {"v1": version}, "server": {"id": OWN, "version": __version__}})


async def everything(call: Call) -> Reply:
    return Reply(_tree(call))


async def part(call: Call) -> Reply:
    """A part of the tree; `vessels/self` is our own."""
    known = _tree(call)
    steps = [step for step in call.path["path"].split("/") if step]
    if steps[:2] == ["vessels", "self"]:
        steps[1] = signalk(call).vessel.urn
    place: Any = known
    for step in steps:
        if not isinstance(place, dict) or step not in place:
            raise Problem(404, "nothing is known there")
        place = place[step]
    return Reply(words=msgspec.json.encode(place))


def _tree(call: Call) -> dict[str, Any]:
    server = signalk(call)
    server.refresh(call.console.gateway.now)
    return tree(server.vessel, server.model.entries, server.epoch)
