"""A gateway with a console, a bus that a test speaks on, and the application without its server."""

import asyncio
import json
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from math import radians
from typing import Any

import msgspec

from timonel.core.frame import Frame
from timonel.core.message import Message
from timonel.gateway.assemble import assemble
from timonel.gateway.configuration import Configuration
from timonel.gateway.gateway import Gateway
from timonel.gateway.link_settings import Station
from timonel.gateway.web_settings import Web
from timonel.links.link import BusLink
from timonel.links.urls import bus_link
from timonel.nmea2000.fastpacket import fragment
from timonel.nmea2000.identifier import join
from timonel.nmea2000.lookups import HeadingReference, SteeringMode
from timonel.nmea2000.messages.steering import HeadingTrackControl, VesselHeading
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.settings import RoverSettings
from timonel.web.app import App
from timonel.web.console import Console

KEY = b"k" * 32
HOST = "127.0.0.1:8080"
TOKEN = "correct horse battery"
HERE = Web()
OPEN_TO_ALL = Web("0.0.0.0", 8080, TOKEN, hosts=("boat.local",))


class Scene(msgspec.Struct):
    """Everything that a test touches."""

    gateway: Gateway
    console: Console
    app: App
    bus: BusLink
    sent: list[Frame]

    async def hear(self, *frames: Frame) -> None:
        """Something comes in from the bus."""
        self.bus.send(frames)
        await asyncio.sleep(0.01)

    async def get(self, path: str, **headers: str) -> "Answered":
        return await request(self.app, "GET", path, **headers)

    async def post(self, path: str, body: Any = None, **headers: str) -> "Answered":
        return await request(self.app, "POST", path, body, **headers)


class Answered(msgspec.Struct):
    """What came back."""

    status: int
    headers: dict[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        return json.loads(self.body)

    @property
    def cookie(self) -> str:
        """What a browser sends back."""
        return self.headers["set-cookie"].partition(";")[0]


def configuration(vehicle: str, web: Web, stations: Sequence[Station] = ()) -> Configuration:
    settings = BoatSettings(name="Alba") if vehicle == "boat" else RoverSettings(name="Strzyga")
    protocol = None if vehicle == "boat" else Protocol()
    return Configuration("test", settings, "loop://web", tuple(stations), web=web, protocol=protocol)


@asynccontextmanager
async def scene(vehicle: str = "boat", web: Web = HERE, stations: Sequence[Station] = ()) -> AsyncIterator[Scene]:
    made_of = configuration(vehicle, web, stations)
    gateway = assemble(made_of)
    console = Console(gateway, made_of, KEY)
    bus = bus_link("loop://web", name="far end")
    sent: list[Frame] = []
    await bus.open(sent.extend, lambda connected, reason: None)
    await gateway.open()
    try:
        yield Scene(gateway, console, App(console), bus, sent)
    finally:
        await gateway.close(0.0)
        await bus.close(0.0)


def wire(number: int, name: str) -> Station:
    """A station with a wire that nobody has."""
    return Station(Port(name, number), f"serial:///nowhere/{name}", None)


def heading(degrees: float, reference: HeadingReference = HeadingReference.TRUE) -> Frame:
    return frame(VesselHeading(sid=None, heading=radians(degrees), deviation=None, variation=None, reference=reference))


def frame(message: Message, source: int = 10) -> Frame:
    pgn = type(message).PGN
    assert pgn is not None
    return Frame(join(2, pgn, source), message.encode())


def pilot_holds(degrees: float) -> list[Frame]:
    """What a pilot reports that holds a course."""
    report = HeadingTrackControl(
        **dict.fromkeys(HeadingTrackControl.__struct_fields__, None)
        | {
            "steering_mode": SteeringMode.HEADING_CONTROL,
            "heading_reference": HeadingReference.TRUE,
            "heading_to_steer_course": radians(degrees),
        }
    )
    return [Frame(join(2, 127237, 204), part) for part in fragment(report.encode(), 0)]


async def request(app: App, method: str, path: str, body: Any = None, **headers: str) -> Answered:
    """One request; an underscore in a header's name is a hyphen, "" leaves a header out."""
    content = b"" if body is None else body if isinstance(body, bytes) else json.dumps(body).encode()
    given = {"host": HOST, "content-type": "application/json"} | {
        name.replace("_", "-"): value for name, value in headers.items()
    }
    address = given.pop("address", "127.0.0.1")
    path, _, query = path.partition("?")
    scope = {
        "type": "http",
        "method": method,
        "path": path,
        "query_string": query.encode(),
        "headers": [(name.encode(), value.encode("latin-1")) for name, value in given.items() if value],
        "client": (address, 40000),
        "server": ("127.0.0.1", 8080),
        "scheme": "http",
    }
    said: list[Any] = []

    async def receive() -> dict[str, Any]:
        return {"type": "http.request", "body": content, "more_body": False}

    async def send(message: Any) -> None:
        said.append(message)

    await app(scope, receive, send)
    start, *rest = said
    told = {name.decode(): value.decode("latin-1") for name, value in start["headers"]}
    return Answered(start["status"], told, b"".join(part["body"] for part in rest))
