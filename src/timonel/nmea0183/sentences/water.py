"""Speed and way through the water, depth, temperature, current."""

from typing import Annotated

from timonel.nmea0183.fields import Angle, Number
from timonel.nmea0183.sentence import Sentence
from timonel.nmea0183.sentences.kinds import KilometresAnHour, Knots, MagneticAngle, Metres, TrueAngle

NauticalMiles = Annotated[float | None, Number(2, 0.0, 1e7, unit="N")]


class VHW(Sentence, frozen=True):
    """Heading and speed through the water. An empty heading has no unit letter (spec/boat.md)."""

    heading_deg: Annotated[float | None, Angle(unit="T", keep_unit=False)] = None
    magnetic_heading_deg: Annotated[float | None, Angle(unit="M", keep_unit=False)] = None
    speed_kn: Knots = None
    speed_kmh: KilometresAnHour = None


class VLW(Sentence, frozen=True):
    """Distance through the water: since the log was fitted, and since it was last reset."""

    total_nm: NauticalMiles = None
    trip_nm: NauticalMiles = None


class DPT(Sentence, frozen=True):
    """Depth below the transducer; `offset_m` is positive up to the surface, negative down to the keel."""

    depth_m: Metres = None
    offset_m: Annotated[float | None, Number(1, -1000.0, 1000.0)] = None
    range_m: Annotated[float | None, Number(1, 0.0, 1e8, optional=True)] = None


class Depth(Sentence, frozen=True):
    """The fields of DBT, DBS and DBK."""

    depth_ft: Annotated[float | None, Number(1, 0.0, 1e9, unit="f")] = None
    depth_m: Annotated[float | None, Number(1, 0.0, 1e8, unit="M")] = None
    depth_fathoms: Annotated[float | None, Number(1, 0.0, 1e8, unit="F")] = None


class DBT(Depth, frozen=True):
    """Depth below the transducer."""


class DBS(Depth, frozen=True):
    """Depth below the surface."""


class DBK(Depth, frozen=True):
    """Depth below the keel."""


class MTW(Sentence, frozen=True):
    """Water temperature in degrees Celsius."""

    temperature_c: Annotated[float | None, Number(1, -273.2, 1e4, unit="C")] = None


class VDR(Sentence, frozen=True):
    """Set (direction the current flows to) and drift."""

    set_deg: TrueAngle = None
    magnetic_set_deg: MagneticAngle = None
    drift_kn: Knots = None
