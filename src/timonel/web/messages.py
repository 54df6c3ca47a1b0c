"""Everything that is said on the console's socket, `/api/v1/socket`; `static/messages.d.ts` is written from it.

```
server -> browser    snapshot, then changes 10 to 20 times a second; answer, pong, pairing, pairing_over
browser -> server    command, acknowledge, silence, choose, refuse_pairing, refresh, ping;
                     to a rover also stick, let_go, enable, stop, limit
```
A `snapshot` holds all topics. `changes` holds those that changed since the message numbered `since`: apply it where
that is the last `sequence` that was seen, else say `refresh` and a snapshot comes. A slow reader gets fewer changes,
never old ones. Nothing changed for a second: `changes` without topics come, so that silence means a dead link.

Values are SI: rad, m, m/s, K, V, A; where it says so degrees of latitude and longitude, rpm. `at` and `clock` are
seconds of the server's own clock: the age of a value is `clock` now minus `at`. A `stale` value is the last that was
known and is not to be shown as one that holds; null is not available.
"""

from typing import Annotated, Any, Literal

import msgspec

Quality = Literal["fresh", "stale", "absent"]
Reference = Literal["true", "magnetic"]
Role = Literal["reader", "station", "admin"]
Priority = Literal["alarm", "warning", "caution"]
Outcome = Literal["sent", "confirmed", "refused", "unconfirmed"]
PilotWord = Literal["STANDBY", "HEADING_HOLD", "TRACK", "ALARM", ""]
CommandVerb = Literal["REQCMD", "RELCMD", "TAKECMD", "ACKCMD", "DENYCMD"]
SteeringVerb = Literal["ENGAGE", "DISENGAGE", "SETHEADING", "PORTONE", "STBDONE", "PORTTEN", "STBDTEN"]
VerbWord = CommandVerb | SteeringVerb
LinkKind = Literal["bus", "in", "out", "gnss"]
EventKind = Literal["command", "pilot", "drive", "alert", "link", "refused", "security", "other"]
WhichLimit = Literal["power", "speed", "current"]

StationNumber = Annotated[int, msgspec.Meta(ge=1, le=4)]
Share = Annotated[float, msgspec.Meta(ge=-1, le=1)]
Id = Annotated[int, msgspec.Meta(ge=0, le=2**53 - 1)]


def written_as(type_script: str) -> msgspec.Meta:
    """What stands in `messages.d.ts` for a field."""
    return msgspec.Meta(extra={"ts": type_script})


# What topics are made of -----------------------------------------------------------------------------------


class Topic(msgspec.Struct, frozen=True, gc=False):
    """Base of what topics hold: replaced as a whole."""


class Measured(Topic, frozen=True, gc=False):
    """A measured value, and when it was heard; both null if it never was."""

    value: float | None
    at: float | None
    quality: Quality


class Direction(Measured, frozen=True, gc=False):
    """A measured direction, rad, 0 to 2 pi."""

    reference: Reference


class Wind(Topic, frozen=True, gc=False):
    """Speed in m/s; the angle in rad, 0 to 2 pi clockwise from the bow."""

    speed: float | None
    angle: float | None
    at: float | None
    quality: Quality


class Position(Topic, frozen=True, gc=False):
    """In degrees, north and east positive."""

    latitude: float | None
    longitude: float | None
    at: float | None
    quality: Quality


class StationState(Topic, frozen=True, gc=False):
    """A station: whether its wire is connected, null if it has none, and how many consoles are it."""

    id: int
    name: str
    connected: bool | None
    web: int


class Waiting(Topic, frozen=True, gc=False):
    """A station that asks for command."""

    station: int
    name: str


class CommandState(Topic, frozen=True, gc=False):
    """Who has command: 0 and "" are nobody.

    `queue` are those who ask, the first one is asked about; the commander may answer until `deadline`, a time of the
    server's clock. `policy` is what an unanswered request comes to.
    """

    commander: int
    commander_name: str
    stations: list[StationState]
    queue: list[Waiting]
    deadline: float | None
    policy: Literal["transfer", "deny"]


class LinkState(Topic, frozen=True, gc=False):
    """A link, since when it is as it is (`at`), and why. A `gnss` link is connected while there is a fix."""

    name: str
    kind: LinkKind
    connected: bool
    reason: str
    at: float | None


class AlertState(Topic, frozen=True, gc=False):
    """An alert as all stations see it. Silenced until `silenced_until`, it makes no sound and stays.

    `announced` is how often it was announced again because nobody acknowledged it.
    """

    id: int
    name: str
    text: str
    priority: Priority
    active: bool
    acknowledged: bool
    silenced_until: float | None
    since: float
    announced: int


class Happening(Topic, frozen=True, gc=False):
    """Something that happened `times` times in a row, the last time at `at`."""

    at: float
    text: str
    kind: EventKind
    times: int


class PilotState(Topic, frozen=True, gc=False):
    """Mode and set point (rad) of the autopilot; "" is a mode that is not understood.

    `pending` is a command that the pilot has not confirmed yet; `setpoint` is null where it is not known, and in
    STANDBY.
    """

    mode: PilotWord
    setpoint: float | None
    reference: Reference
    pending: bool


class StickState(Topic, frozen=True, gc=False):
    """The stick as it is obeyed now: x to the right, y forward, -1 to 1."""

    x: float
    y: float


class DriveState(Topic, frozen=True, gc=False):
    """What the drives are told: `left` and `right` are set points -1 to 1, `speed_limit` the share of full speed.

    `reason` is why they are permitted to move, or were stopped.
    """

    permitted: bool
    stick: StickState
    left: float
    right: float
    speed_limit: float
    reason: str


class WheelState(Topic, frozen=True, gc=False):
    """One wheel, forward positive: set point -1 to 1, speed in rpm, current in A, temperature in K.

    `state` is that of its side's motor driver, "running", "stopped", "no supply", "fault", null if it was never told;
    `quality` and `at` are those of the measured speed.
    """

    side: Literal["left", "right"]
    place: Literal["front", "middle", "rear"]
    setpoint: float
    rpm: float | None
    current: float | None
    temperature: float | None
    state: str | None
    at: float | None
    quality: Quality


class BatteryState(Topic, frozen=True, gc=False):
    """Voltages in V, of the whole and of the four cells; temperatures of the six modules in K.

    `state` is "ok", "under voltage", "over temperature", "over current", null if it was never told.
    """

    voltage: float | None
    cells: list[float | None]
    modules: list[float | None]
    state: str | None
    at: float | None
    quality: Quality


class Vector(Topic, frozen=True, gc=False):
    """x forward, y to the left, z up."""

    x: float | None
    y: float | None
    z: float | None


class ImuState(Topic, frozen=True, gc=False):
    """Specific force in m/s2 (z = +g at rest) and rate of turn in rad/s."""

    acceleration: Vector
    rate: Vector
    at: float | None
    quality: Quality


class MagnetometerState(Topic, frozen=True, gc=False):
    """Magnetic heading of a level rover in rad, and flux density in T."""

    heading: float | None
    strength: float | None
    at: float | None
    quality: Quality


class LimitsState(Topic, frozen=True, gc=False):
    """The limits in their steps, as the commander said them: power and speed 1..20, current 1..200; null: not said."""

    power: int | None
    speed: int | None
    current: int | None


class FrameRate(Topic, frozen=True, gc=False):
    """A frame of the modules: how often it comes, a second, and when it came last."""

    id: int
    name: str
    rate: float
    at: float


class Framing(Topic, frozen=True, gc=False):
    """What a station's link carried so far: whole frames, bytes that belong to none, `#` that began none."""

    port: str
    frames: int
    skipped: int
    rejected: int


class LinkQuality(Topic, frozen=True, gc=False):
    """How well frames come through; `rejected` frames of the bus were not as declared. Told twice a second."""

    frames: list[FrameRate]
    rejected: int
    framing: list[Framing]
    dialect: str


class OwnValue(Topic, frozen=True, gc=False):
    """A signal of an owner's frame; text for a code's name."""

    name: str
    unit: str
    value: float | str | None


class OwnFrame(Topic, frozen=True, gc=False):
    """A frame that the owner declared."""

    id: int
    name: str
    values: list[OwnValue]
    at: float
    quality: Quality


class DeviceState(Topic, frozen=True, gc=False):
    """A device on the NMEA 2000 bus; `ours` is the gateway itself. What it has not told is null.

    `name` is its NAME in hexadecimal digits, `function` what it says that it is, `since` when it was first heard.
    """

    address: int | None
    name: str
    maker: str
    model: str | None
    software: str | None
    serial: str | None
    function: str
    instance: int
    installation: str | None
    since: float
    ours: bool


class BoatTopics(Topic, frozen=True, gc=False):
    """All topics of a boat. Rudder and rate of turn are positive to starboard, variation to the east; utc is in s."""

    command: CommandState
    pilot: PilotState
    heading: Direction
    cog: Direction
    sog: Measured
    stw: Measured
    rudder: Measured
    rate_of_turn: Measured
    depth: Measured
    wind_apparent: Wind
    wind_true: Wind
    water_temperature: Measured
    position: Position
    utc: Measured
    variation: Measured
    devices: list[DeviceState]
    links: list[LinkState]
    alerts: list[AlertState]
    events: list[Happening]


class RoverTopics(Topic, frozen=True, gc=False):
    """All topics of a rover."""

    command: CommandState
    drive: DriveState
    wheels: list[WheelState]
    battery: BatteryState
    imu: ImuState
    magnetometer: MagnetometerState
    gps: Position
    limits: LimitsState
    quality: LinkQuality
    own: list[OwnFrame]
    links: list[LinkState]
    alerts: list[AlertState]
    events: list[Happening]


# Server -> browser ------------------------------------------------------------------------------------------


class You(Topic, frozen=True, gc=False):
    """Who you are here: a role, the station that you command as, and those that you may `choose` to be."""

    role: Role
    station: int | None
    may_choose: list[int]


class FromServer(msgspec.Struct, frozen=True, gc=False, tag_field="type"):
    """Base of what the server says."""


class Snapshot(FromServer, frozen=True, gc=False, tag="snapshot"):
    """Everything as it stands."""

    sequence: int
    clock: float
    vehicle: Literal["boat", "rover"]
    name: str
    you: You
    topics: Annotated[dict[str, Any], written_as("BoatTopics | RoverTopics")]


class Changes(FromServer, frozen=True, gc=False, tag="changes"):
    """The topics that changed since the message numbered `since`."""

    since: int
    sequence: int
    clock: float
    topics: Annotated[dict[str, Any], written_as("Partial<BoatTopics & RoverTopics>")]


class Answer(FromServer, frozen=True, gc=False, tag="answer"):
    """What became of the message with this id: `sent` at once, then how it ended; `refused` may come at once.

    A request for command waits for as long as the commander may answer; all else ends within 2 s.
    """

    id: int
    outcome: Outcome
    reason: str


class Pong(FromServer, frozen=True, gc=False, tag="pong"):
    """The answer to `ping`."""

    n: int
    clock: float


class Pairing(FromServer, frozen=True, gc=False, tag="pairing"):
    """Somebody at `address` who calls himself `name` wants to be `station`: tell him the six digits, or refuse.

    Only the station in command and admins are told.
    """

    pairing: int
    station: int
    station_name: str
    code: str
    name: str
    address: str
    deadline: float


class PairingOver(FromServer, frozen=True, gc=False, tag="pairing_over"):
    """A pairing was done, refused or forgotten."""

    pairing: int


# Browser -> server ------------------------------------------------------------------------------------------


class FromBrowser(msgspec.Struct, frozen=True, gc=False, tag_field="type", forbid_unknown_fields=True):
    """Base of what the browser says. An `id` is the client's own: the answer has it too."""


class Command(FromBrowser, frozen=True, gc=False, tag="command"):
    """A word of the `$PARP` family, as the station that you are. `parameter`: SETHEADING's heading, rad.

    A rover takes those about command: REQCMD, RELCMD, TAKECMD, ACKCMD, DENYCMD.
    """

    id: Id
    verb: VerbWord
    parameter: Annotated[float, msgspec.Meta(ge=-100, le=100)] | None = None


class Acknowledge(FromBrowser, frozen=True, gc=False, tag="acknowledge"):
    """Somebody has seen the alert."""

    id: Id
    alert: Annotated[int, msgspec.Meta(ge=0, le=65535)]


class Silence(FromBrowser, frozen=True, gc=False, tag="silence"):
    """No sound of this alert for 30 s, on any station."""

    id: Id
    alert: Annotated[int, msgspec.Meta(ge=0, le=65535)]


class Choose(FromBrowser, frozen=True, gc=False, tag="choose"):
    """Be this station from now on, one of `may_choose`; null: just look. A snapshot follows."""

    id: Id
    station: StationNumber | None


class RefusePairing(FromBrowser, frozen=True, gc=False, tag="refuse_pairing"):
    """That one is not to be a station."""

    id: Id
    pairing: Id


class Refresh(FromBrowser, frozen=True, gc=False, tag="refresh"):
    """A snapshot, please."""


class Ping(FromBrowser, frozen=True, gc=False, tag="ping"):
    """A pong, please."""

    n: Id


class Stick(FromBrowser, frozen=True, gc=False, tag="stick"):
    """The rover's stick: x to the right, y forward. Say it 20 to 50 times a second while your station is in command,
    at rest too: it rests after 200 ms without, the drives stop after 500 ms, and command is given up after 2 s.

    One console of a station holds it, who says it first, until `let_go`. `n` counts up. `seen` is the `clock` of the
    newest message from the server: a stick whose driver has seen nothing for 500 ms counts as at rest.
    """

    n: Id
    x: Share
    y: Share
    seen: float | None = None


class LetGo(FromBrowser, frozen=True, gc=False, tag="let_go"):
    """Nobody holds the stick any more: it is at rest at once, and another console of the station may take it."""


class Enable(FromBrowser, frozen=True, gc=False, tag="enable"):
    """Permit the drives to move; the stick must be at rest."""

    id: Id


class Stop(FromBrowser, frozen=True, gc=False, tag="stop"):
    """Stop the drives. Any station may."""

    id: Id


class Limit(FromBrowser, frozen=True, gc=False, tag="limit"):
    """A limit in its steps: power and speed 1..20, current 1..200."""

    id: Id
    which: WhichLimit
    value: Annotated[int, msgspec.Meta(ge=1, le=200)]


ServerMessage = Snapshot | Changes | Answer | Pong | Pairing | PairingOver
BrowserMessage = (
    Command | Acknowledge | Silence | Choose | RefusePairing | Refresh | Ping | Stick | LetGo | Enable | Stop | Limit
)
