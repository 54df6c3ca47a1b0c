"""Heading, rudder and pilot."""

from typing import Annotated

from timonel.core.fields import I16, I32, U8, U16, Date, Lookup, Reserved
from timonel.core.message import Message
from timonel.nmea2000.lookups import (
    DirectionRudder,
    HeadingReference,
    SteeringMode,
    TurnMode,
    VariationSource,
    YesNo,
)


class HeadingTrackControl(Message, pgn=127237):
    """PGN 127237: what the pilot is told to steer, and what it says it steers.

    Fast packet, priority 2, 4 Hz. Layout: canboat `headingTrackControl`.

    The mode means what the maker of the pilot means by it. Rudder and turns are positive to starboard;
    `heading_reference` holds for all headings and for the track.
    """

    rudder_limit_exceeded: Annotated[YesNo | None, Lookup(2, YesNo)] = None
    off_heading_limit_exceeded: Annotated[YesNo | None, Lookup(2, YesNo)] = None
    off_track_limit_exceeded: Annotated[YesNo | None, Lookup(2, YesNo)] = None
    override: Annotated[YesNo | None, Lookup(2, YesNo)] = None
    steering_mode: Annotated[SteeringMode | None, Lookup(3, SteeringMode)] = None
    turn_mode: Annotated[TurnMode | None, Lookup(3, TurnMode)] = None
    heading_reference: Annotated[HeadingReference | None, Lookup(2, HeadingReference)] = None
    reserved: Annotated[None, Reserved(5)] = None
    commanded_rudder_direction: Annotated[DirectionRudder | None, Lookup(3, DirectionRudder)] = None
    commanded_rudder_angle: Annotated[float | None, I16(1e-4, "rad")] = None
    heading_to_steer_course: Annotated[float | None, U16(1e-4, "rad")] = None
    track: Annotated[float | None, U16(1e-4, "rad")] = None
    rudder_limit: Annotated[float | None, U16(1e-4, "rad")] = None
    off_heading_limit: Annotated[float | None, U16(1e-4, "rad")] = None
    radius_of_turn_order: Annotated[int | None, I16(1, "m")] = None
    rate_of_turn_order: Annotated[float | None, I16(3.125e-5, "rad/s")] = None
    off_track_limit: Annotated[int | None, I16(1, "m")] = None
    vessel_heading: Annotated[float | None, U16(1e-4, "rad")] = None


class Rudder(Message, pgn=127245):
    """PGN 127245: where the rudder is, and where it was told to go.

    Single frame, priority 2, 10 Hz. Layout: canboat `rudder`.

    Positive turns the boat to starboard; some senders have it the other way round.
    """

    instance: Annotated[int | None, U8()]
    direction_order: Annotated[DirectionRudder | None, Lookup(3, DirectionRudder)]
    reserved: Annotated[None, Reserved(5)] = None
    angle_order: Annotated[float | None, I16(1e-4, "rad")]
    position: Annotated[float | None, I16(1e-4, "rad")]
    reserved6: Annotated[None, Reserved(16)] = None


class VesselHeading(Message, pgn=127250):
    """PGN 127250: where the bow points, and what turns it into true heading.

    Single frame, priority 2, 10 Hz. Layout: canboat `vesselHeading`.
    """

    sid: Annotated[int | None, U8()]
    heading: Annotated[float | None, U16(1e-4, "rad")]
    deviation: Annotated[float | None, I16(1e-4, "rad")]
    variation: Annotated[float | None, I16(1e-4, "rad")]
    reference: Annotated[HeadingReference | None, Lookup(2, HeadingReference)]
    reserved: Annotated[None, Reserved(6)] = None


class RateOfTurn(Message, pgn=127251):
    """PGN 127251: how fast the bow turns, positive clockwise (to starboard).

    Single frame, priority 2, 10 Hz. Layout: canboat `rateOfTurn`.
    """

    sid: Annotated[int | None, U8()]
    rate: Annotated[float | None, I32(3.125e-8, "rad/s")]
    reserved: Annotated[None, Reserved(24)] = None


class Attitude(Message, pgn=127257):
    """PGN 127257: yaw, pitch (bow up is positive) and roll (starboard down is positive).

    Single frame, priority 3, 1 Hz. Layout: canboat `attitude`.
    """

    sid: Annotated[int | None, U8()]
    yaw: Annotated[float | None, I16(1e-4, "rad")]
    pitch: Annotated[float | None, I16(1e-4, "rad")]
    roll: Annotated[float | None, I16(1e-4, "rad")]
    reserved: Annotated[None, Reserved(8)] = None


class MagneticVariation(Message, pgn=127258):
    """PGN 127258: variation at the position, positive east; `age_of_service` is the date of its model.

    Single frame, priority 7, 1 Hz. Layout: canboat `magneticVariation`.
    """

    sid: Annotated[int | None, U8()]
    source: Annotated[VariationSource | None, Lookup(4, VariationSource)]
    reserved: Annotated[None, Reserved(4)] = None
    age_of_service: Annotated[int | None, Date()]
    variation: Annotated[float | None, I16(1e-4, "rad")]
    reserved6: Annotated[None, Reserved(16)] = None
