"""Fields that several sentences share, in the words of the standard."""

import datetime
from enum import StrEnum
from typing import Annotated

from timonel.nmea0183.fields import (
    Angle,
    Date,
    Letter,
    Mode,
    Number,
    Position,
    Signed,
    Status,
    Text,
    TimeOfDay,
)


class Reference(StrEnum):
    """What a direction is counted from."""

    TRUE = "T"
    MAGNETIC = "M"


PlainAngle = Annotated[float | None, Angle()]
TrueAngle = Annotated[float | None, Angle(unit="T")]
MagneticAngle = Annotated[float | None, Angle(unit="M")]
Knots = Annotated[float | None, Number(1, 0.0, 9999.9, unit="N")]
KilometresAnHour = Annotated[float | None, Number(1, 0.0, 9999.9, unit="K")]
Metres = Annotated[float | None, Number(1, 0.0, 1e8)]
SignedAngle = Annotated[float | None, Number(1, -180.0, 180.0)]
EastWest = Annotated[float | None, Signed(1, 180.0, "E", "W")]
Latitude = Annotated[float | None, Position(90, "N", "S")]
Longitude = Annotated[float | None, Position(180, "E", "W")]
CrossTrackError = Annotated[float | None, Signed(3, 1e5, "L", "R", unit="N")]
UtcTime = Annotated[float | None, TimeOfDay()]
UtcDate = Annotated[datetime.date | None, Date()]
AOrV = Annotated[bool | None, Status()]
Valid = Annotated[bool | None, Status(mode="mode")]
FixMode = Annotated[Mode | None, Letter(Mode, otherwise=Mode.NOT_VALID)]
DirectionReference = Annotated[Reference | None, Letter(Reference)]
Name = Annotated[str | None, Text()]
