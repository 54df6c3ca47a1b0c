"""What an owner may set about a boat: the `[vehicle]` and `[sentences]` tables of a configuration."""

from typing import Annotated, Literal

import msgspec

Seconds = Annotated[float, msgspec.Meta(gt=0, le=3600)]
Hertz = Annotated[float, msgspec.Meta(ge=0, le=1000)]


class BoatSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Settings of the boat with the defaults of spec/boat.md."""

    name: str = "boat"
    dialect: Literal["standard", "ar-1.0"] = "standard"
    pilot: Literal["standard"] = "standard"
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
    """The gateway's own source address on the bus."""
    rates: dict[str, Hertz] = {}
    """Sentences at most a second by formatter, 0 for never; what is not named keeps its default."""


class Port(msgspec.Struct, frozen=True):
    """A way in or out: who speaks on it. `station` None is a wire that several stations share.

    A `console` is no wire, but the gateway's own: it says words for which a vehicle's wires have none.
    """

    name: str
    station: int | None = None
    console: bool = False
