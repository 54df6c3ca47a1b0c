"""Rudder and heading control."""

from enum import StrEnum
from typing import Annotated

from timonel.nmea0183.fields import Letter, Number
from timonel.nmea0183.sentence import Sentence
from timonel.nmea0183.sentences.kinds import AOrV, DirectionReference, PlainAngle, SignedAngle

LimitAngle = Annotated[float | None, Number(1, 0.0, 180.0)]
Miles = Annotated[float | None, Number(2, 0.0, 9999.9)]


class RSA(Sentence, frozen=True):
    """Rudder angles, positive to starboard; a single rudder is the starboard one."""

    starboard_deg: SignedAngle = None
    starboard_valid: AOrV = None
    port_deg: SignedAngle = None
    port_valid: AOrV = None


class RudderDirection(StrEnum):
    LEFT = "L"
    RIGHT = "R"


class SteeringMode(StrEnum):
    """What the heading controller obeys; `STAND_ALONE` takes no heading from outside."""

    MANUAL = "M"
    STAND_ALONE = "S"
    HEADING_CONTROL = "H"
    TRACK_CONTROL = "T"
    RUDDER_CONTROL = "R"


class TurnMode(StrEnum):
    RADIUS = "R"
    RATE = "T"
    NOT_CONTROLLED = "N"


class HeadingTrackControl(Sentence, frozen=True):
    """The fields that HTC and HTD share. Empty is *no change* in a command, *not available* in a report.

    With `override` the modes are not in use. The rudder angle is a magnitude; a direction without one is an
    order all the same (non-follow-up steering).
    """

    override: AOrV = None
    rudder_angle_deg: LimitAngle = None
    rudder_direction: Annotated[RudderDirection | None, Letter(RudderDirection)] = None
    steering_mode: Annotated[SteeringMode | None, Letter(SteeringMode)] = None
    turn_mode: Annotated[TurnMode | None, Letter(TurnMode)] = None
    rudder_limit_deg: LimitAngle = None
    off_heading_limit_deg: LimitAngle = None
    radius_nm: Miles = None
    rate_deg_min: Annotated[float | None, Number(1, -9999.9, 9999.9)] = None
    heading_to_steer_deg: PlainAngle = None
    off_track_limit_nm: Miles = None
    track_deg: PlainAngle = None
    reference: DirectionReference = None


class HTC(HeadingTrackControl, frozen=True):
    """Heading/track control command."""


class HTD(HeadingTrackControl, frozen=True):
    """Heading/track control data: the command in force, and whether its limits are kept (True)."""

    within_rudder_limit: AOrV = None
    within_off_heading_limit: AOrV = None
    within_off_track_limit: AOrV = None
    heading_deg: PlainAngle = None
