"""What an MQTT broker is told of a vehicle: topics under one base, JSON documents, values in SI.

```
<base>/availability       online; offline when we end, or, by the broker, when we are lost            retained
<base>/heading, ...       {"value": 0.7819, "unit": "rad", "quality": "fresh", "reference": "true"}   retained
<base>/command            {"commander": 1, "name": "Bridge", "queue": [...], "policy": "transfer"}    retained
<base>/pilot              mode and set point of a boat's pilot                                        retained
<base>/drive              whether a rover's drives may move, why, and what they are told              retained
<base>/position           {"latitude": 39.55, "longitude": 2.63, "quality": "fresh"}                  retained
<base>/alerts, /links     what people must still see, and what is connected                           retained
<base>/event              something that happened, a refusal too: {"kind": "refused", "text": "..."}
<base>/order              orders, where a station is paired; <base>/answer says what became of each
```
A value that nobody tells, or that is older than its age limit, is null and its `quality` says which.
"""

from collections.abc import Sequence
from typing import Literal

import msgspec

ONLINE, OFFLINE = "online", "offline"
AVAILABILITY, EVENT, ORDER, ANSWER = "availability", "event", "order", "answer"

Vehicle = Literal["boat", "rover"]
Kind = Literal["angle", "helm_angle", "turn_rate", "speed", "wind_speed", "depth", "temperature", "voltage", "rpm"]
UNITS: dict[Kind, str] = {
    "angle": "rad",
    "helm_angle": "rad",
    "turn_rate": "rad/s",
    "speed": "m/s",
    "wind_speed": "m/s",
    "depth": "m",
    "temperature": "K",
    "voltage": "V",
    "rpm": "rpm",
}
"""Kinds of values: an `angle` counts from 0 to 2 pi, a `helm_angle` is positive to starboard."""


class Value(msgspec.Struct, frozen=True):
    """A value that is told: the last level of its topic, its name for people, its kind."""

    key: str
    name: str
    kind: Kind


VALUES: dict[Vehicle, tuple[Value, ...]] = {
    "boat": (
        Value("heading", "Heading", "angle"),
        Value("cog", "Course over ground", "angle"),
        Value("sog", "Speed over ground", "speed"),
        Value("stw", "Speed through water", "speed"),
        Value("depth", "Depth", "depth"),
        Value("wind_apparent_speed", "Apparent wind speed", "wind_speed"),
        Value("wind_apparent_angle", "Apparent wind angle", "angle"),
        Value("wind_true_speed", "True wind speed", "wind_speed"),
        Value("wind_true_angle", "True wind angle", "angle"),
        Value("water_temperature", "Water temperature", "temperature"),
        Value("rudder", "Rudder", "helm_angle"),
        Value("rate_of_turn", "Rate of turn", "turn_rate"),
        Value("variation", "Magnetic variation", "helm_angle"),
    ),
    "rover": (
        Value("battery_voltage", "Battery voltage", "voltage"),
        *(Value(f"cell{number}", f"Battery cell {number}", "voltage") for number in range(1, 5)),
        Value("wheel_speed", "Wheel speed", "rpm"),
        Value("heading", "Magnetic heading", "angle"),
    ),
}


class Document(msgspec.Struct, frozen=True, omit_defaults=True):
    """Base of what stands at a topic."""


class Reading(Document, frozen=True):
    """A measured value in `unit`. `reference` is that of a direction."""

    value: float | None
    unit: str
    quality: str
    reference: str | None = None


class Requester(Document, frozen=True):
    """A station that asks for command."""

    station: int
    name: str


class Command(Document, frozen=True):
    """Who has command, 0 and "" are nobody; who asks for it; what an unanswered request comes to."""

    commander: int
    name: str
    queue: list[Requester]
    policy: str


class Pilot(Document, frozen=True):
    """Mode and set point (rad, null in STANDBY) of an autopilot; `pending` is a command not confirmed yet."""

    mode: str
    setpoint: float | None
    reference: str
    pending: bool


class Drive(Document, frozen=True):
    """Whether a rover's drives may move and why, the set points of both sides (-1..1), the state of the battery."""

    permitted: bool
    reason: str
    left: float
    right: float
    battery: str | None


class Position(Document, frozen=True):
    """In degrees, north and east positive; left out where it is not known."""

    quality: str
    latitude: float | None = None
    longitude: float | None = None


class Alert(Document, frozen=True):
    """An alert that people must still see."""

    id: int
    name: str
    text: str
    priority: str
    active: bool
    acknowledged: bool
    silenced: bool


class Link(Document, frozen=True):
    """A bus, a port or a receiver, whether it is connected, and if not why."""

    name: str
    kind: str
    connected: bool
    reason: str


class Happened(Document, frozen=True):
    """Something that happened, in words."""

    kind: str
    text: str


class Answer(Document, frozen=True):
    """What became of the order with this id: `sent` at once, then `confirmed`, `refused` or `unconfirmed`."""

    id: int
    outcome: str
    reason: str


def written(document: Document | Sequence[Document]) -> bytes:
    """A document as it is published."""
    return msgspec.json.encode(document)
