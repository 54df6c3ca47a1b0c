"""Where the bow points and how fast it turns. Angles in degrees clockwise."""

from enum import StrEnum
from typing import Annotated

from timonel.nmea0183.fields import Letter, Number
from timonel.nmea0183.sentence import Sentence
from timonel.nmea0183.sentences.kinds import AOrV, EastWest, MagneticAngle, PlainAngle, TrueAngle


class HDT(Sentence, frozen=True):
    """True heading."""

    heading_deg: TrueAngle = None


class HDM(Sentence, frozen=True):
    """Magnetic heading."""

    magnetic_heading_deg: MagneticAngle = None


class HDG(Sentence, frozen=True):
    """Compass heading and what makes it magnetic (deviation) and true (variation), both positive east."""

    heading_deg: PlainAngle = None
    deviation_deg: EastWest = None
    variation_deg: EastWest = None


class HeadingMode(StrEnum):
    """How a true heading was found. A letter that is not listed is read as `NOT_VALID`."""

    AUTONOMOUS = "A"
    ESTIMATED = "E"
    MANUAL = "M"
    SIMULATOR = "S"
    NOT_VALID = "V"


class THS(Sentence, frozen=True):
    """True heading and status; takes the place of HDT in newer editions."""

    heading_deg: PlainAngle = None
    mode: Annotated[HeadingMode | None, Letter(HeadingMode, otherwise=HeadingMode.NOT_VALID)] = None


class ROT(Sentence, frozen=True):
    """Rate of turn in degrees a minute, positive to starboard."""

    rate_deg_min: Annotated[float | None, Number(1, -1e6, 1e6)] = None
    valid: AOrV = None


class HSC(Sentence, frozen=True):
    """Heading steering command: the heading to steer, true and magnetic."""

    heading_deg: TrueAngle = None
    magnetic_heading_deg: MagneticAngle = None
