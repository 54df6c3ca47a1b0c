"""Wind, always the direction it comes from."""

from enum import StrEnum
from typing import Annotated

from timonel.nmea0183.fields import Letter, Number
from timonel.nmea0183.sentence import Sentence
from timonel.nmea0183.sentences.kinds import AOrV, Knots, MagneticAngle, PlainAngle, TrueAngle


class WindReference(StrEnum):
    """Relative is as felt aboard; theoretical is against the water, its angle still counted from the bow."""

    RELATIVE = "R"
    THEORETICAL = "T"


class SpeedUnit(StrEnum):
    KILOMETRES_AN_HOUR = "K"
    METRES_A_SECOND = "M"
    KNOTS = "N"
    STATUTE_MILES_AN_HOUR = "S"


class MWV(Sentence, frozen=True):
    """Wind angle 0..360 clockwise from the bow, and wind speed in `unit`."""

    angle_deg: PlainAngle = None
    reference: Annotated[WindReference | None, Letter(WindReference)] = None
    speed: Annotated[float | None, Number(1, 0.0, 99999.9)] = None
    unit: Annotated[SpeedUnit | None, Letter(SpeedUnit)] = None
    valid: AOrV = None


class MWD(Sentence, frozen=True):
    """Wind direction from north, and wind speed."""

    direction_deg: TrueAngle = None
    magnetic_direction_deg: MagneticAngle = None
    speed_kn: Knots = None
    speed_ms: Annotated[float | None, Number(1, 0.0, 9999.9, unit="M")] = None
