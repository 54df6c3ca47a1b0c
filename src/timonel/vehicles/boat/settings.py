"""What an owner may set about a boat: the `[vehicle]` and `[sentences]` tables of a configuration."""

from typing import Annotated, Literal

import msgspec

from timonel.nmea0183.selection import Hearing
from timonel.nmea2000.node import NodeSettings
from timonel.vehicles.boat.alert_settings import AlertSettings
from timonel.vehicles.boat.sources import SourceSettings

Seconds = Annotated[float, msgspec.Meta(gt=0, le=3600)]
Hertz = Annotated[float, msgspec.Meta(ge=0, le=1000)]
PilotName = Literal["standard", "groupfunction", "raymarine", "raymarine-spx", "navico", "garmin", "sentence"]


class BoatSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Settings of the boat with the defaults of spec/boat.md."""

    name: str = "boat"
    dialect: Literal["standard", "ar-1.0"] = "standard"
    pilot: PilotName = "standard"
    """Which driver steers; `vehicles.boat.pilots.KINDS` tells what each is."""
    pilot_name: str = ""
    """Which device is the pilot: its NAME as 0x..., or the word for its maker; empty: the only one there is."""
    pilot_output: str = ""
    """The output, by its name, on which the driver `sentence` speaks."""
    pilot_sentences: tuple[Literal["HTC", "HSC", "APB"], ...] = ("HTC",)
    """What the driver `sentence` says."""
    obey_htc: bool = False
    """Whether HTC of the station in command is obeyed as its other commands are."""
    request_timeout: Literal["transfer", "deny"] = "transfer"
    """What a request comes to that the commander leaves unanswered."""
    request_seconds: Seconds = 10.0
    heading_reference: Literal["true", "magnetic"] = "true"
    """What headings and set points in STATUS and in commands to the pilot refer to."""
    variation_model: bool = True
    """Whether the World Magnetic Model stands in where the bus tells no variation."""
    max_age: Seconds = 3.0
    """How long a value counts after it was heard, s."""
    fast_packet_age: Seconds = 0.25
    """How long the frames of one message may take, s."""
    commands_per_second: Annotated[int, msgspec.Meta(ge=1, le=10000)] = 20
    """Commands that one port may give in a second; the rest is dropped and counted."""
    address: Annotated[int, msgspec.Meta(ge=0, le=251)] = 0x23
    """The gateway's own source address on the bus, or the one that its node tries first."""
    node: NodeSettings | None = None
    """What the gateway says of itself on the bus; None: it claims no address and answers nothing."""
    backbone: Literal["required", "optional"] = "required"
    """Whether it is an alarm that a backbone has never been heard; one that was heard and falls silent always is."""
    sources: SourceSettings | None = None
    """The order of several sources of one datum, their corrections, and what is derived."""
    alerts: AlertSettings | None = None
    """How the table of alerts speaks with other devices; None: it has ours only, and the bus does not hear of them."""
    rates: dict[str, Hertz] = {}
    """Sentences at most a second by formatter, 0 for never; what is not named keeps its default."""


class Port(msgspec.Struct, frozen=True):
    """A way in or out: who speaks on it. `station` None is a wire that several stations share.

    A `console` is no wire, but the gateway's own: it says words for which a vehicle's wires have none. What an
    `instrument` says goes onto the bus; one that is no station's wire may not command.
    """

    name: str
    station: int | None = None
    console: bool = False
    instrument: bool = False
    hears: Hearing | None = None
    """Which of an instrument's sentences are heard; None is all of them."""
