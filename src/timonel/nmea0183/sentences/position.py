"""Position, course and speed over ground, time. Times are UTC in seconds of the day."""

from enum import StrEnum
from typing import Annotated

from timonel.nmea0183.fields import Integer, Letter, Number, Text
from timonel.nmea0183.sentence import Sentence
from timonel.nmea0183.sentences.kinds import (
    EastWest,
    FixMode,
    KilometresAnHour,
    Knots,
    Latitude,
    Longitude,
    MagneticAngle,
    PlainAngle,
    TrueAngle,
    UtcDate,
    UtcTime,
    Valid,
)


class NavigationalStatus(StrEnum):
    """How far the position may be trusted (edition 4.1). An unknown letter is read as `NOT_GIVEN`."""

    SAFE = "S"
    CAUTION = "C"
    UNSAFE = "U"
    NOT_GIVEN = "V"


class GLL(Sentence, frozen=True):
    """Position."""

    latitude_deg: Latitude = None
    longitude_deg: Longitude = None
    time: UtcTime = None
    valid: Valid = None
    mode: FixMode = None


class RMC(Sentence, frozen=True):
    """Recommended minimum: position, speed and course over ground, date, variation (positive east)."""

    time: UtcTime = None
    valid: Valid = None
    latitude_deg: Latitude = None
    longitude_deg: Longitude = None
    speed_kn: Annotated[float | None, Number(1, 0.0, 9999.9)] = None
    course_deg: PlainAngle = None
    date: UtcDate = None
    variation_deg: EastWest = None
    mode: FixMode = None
    navigational_status: Annotated[
        NavigationalStatus | None,
        Letter(NavigationalStatus, otherwise=NavigationalStatus.NOT_GIVEN, optional=True),
    ] = None


class GGA(Sentence, frozen=True):
    """Position and how good it is; `quality` 0 is no fix, 1 GNSS, 2 differential, 4 RTK fixed, 5 RTK float,
    6 dead reckoning, 7 manual, 8 simulator. Altitude is above mean sea level, geoid above the ellipsoid."""

    time: UtcTime = None
    latitude_deg: Latitude = None
    longitude_deg: Longitude = None
    quality: Annotated[int | None, Integer(1, 0, 9)] = None
    satellites: Annotated[int | None, Integer(2, 0, 99)] = None
    hdop: Annotated[float | None, Number(1, 0.0, 9999.9)] = None
    altitude_m: Annotated[float | None, Number(1, -1e6, 1e8, unit="M")] = None
    geoid_m: Annotated[float | None, Number(1, -1e6, 1e6, unit="M")] = None
    age_s: Annotated[float | None, Number(0, 0.0, 1e6)] = None
    reference_station: Annotated[str | None, Text()] = None


class VTG(Sentence, frozen=True):
    """Course and speed over ground."""

    course_deg: TrueAngle = None
    magnetic_course_deg: MagneticAngle = None
    speed_kn: Knots = None
    speed_kmh: KilometresAnHour = None
    mode: FixMode = None


class ZDA(Sentence, frozen=True):
    """Time, date and local zone: what must be added to local time to get UTC."""

    time: UtcTime = None
    day: Annotated[int | None, Integer(2, 1, 31)] = None
    month: Annotated[int | None, Integer(2, 1, 12)] = None
    year: Annotated[int | None, Integer(4, 0, 9999)] = None
    zone_hours: Annotated[int | None, Integer(2, -13, 13)] = None
    zone_minutes: Annotated[int | None, Integer(2, -59, 59)] = None
