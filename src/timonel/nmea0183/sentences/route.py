"""Steering to a waypoint. A cross-track error is positive where the boat must steer left to get back."""

from typing import Annotated

from timonel.nmea0183.fields import Number, Signed
from timonel.nmea0183.sentence import Sentence
from timonel.nmea0183.sentences.kinds import (
    AOrV,
    CrossTrackError,
    DirectionReference,
    FixMode,
    Latitude,
    Longitude,
    Name,
    PlainAngle,
    Valid,
)


class APB(Sentence, frozen=True):
    """What a track pilot needs: cross-track error, bearings and heading to steer, each with its reference."""

    valid: Valid = None
    locked: AOrV = None
    cross_track_error_nm: CrossTrackError = None
    arrived: AOrV = None
    perpendicular_passed: AOrV = None
    leg_bearing_deg: PlainAngle = None
    leg_bearing_reference: DirectionReference = None
    destination: Name = None
    bearing_deg: PlainAngle = None
    bearing_reference: DirectionReference = None
    heading_to_steer_deg: PlainAngle = None
    heading_to_steer_reference: DirectionReference = None
    mode: FixMode = None


class RMB(Sentence, frozen=True):
    """Recommended minimum for a leg. Cross-track error and range stop at 9.99 and 999.9 as the standard says.

    Senders disagree which of `origin` and `destination` comes first: do not rely on it when reading.
    """

    valid: Valid = None
    cross_track_error_nm: Annotated[float | None, Signed(2, 1e5, "L", "R", ceiling=9.99)] = None
    origin: Name = None
    destination: Name = None
    latitude_deg: Latitude = None
    longitude_deg: Longitude = None
    range_nm: Annotated[float | None, Number(1, 0.0, 1e5, ceiling=999.9)] = None
    bearing_deg: PlainAngle = None
    closing_speed_kn: Annotated[float | None, Number(1, -9999.9, 9999.9)] = None
    arrived: AOrV = None
    mode: FixMode = None


class XTE(Sentence, frozen=True):
    """Cross-track error."""

    valid: Valid = None
    locked: AOrV = None
    cross_track_error_nm: CrossTrackError = None
    mode: FixMode = None
