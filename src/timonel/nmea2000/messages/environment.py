"""Wind, temperature, humidity and pressure."""

from typing import Annotated

from timonel.core.fields import I16, U8, U16, U24, Lookup, Reserved
from timonel.core.message import Message
from timonel.nmea2000.lookups import HumiditySource, TemperatureSource, WindReference


class WindData(Message, pgn=130306):
    """PGN 130306: wind speed and where the wind blows from.

    Single frame, priority 2, 10 Hz. Layout: canboat `windData`.

    `reference` says whether the angle is from the bow or from north, and what the wind was measured against.
    """

    sid: Annotated[int | None, U8()]
    wind_speed: Annotated[float | None, U16(0.01, "m/s")]
    wind_angle: Annotated[float | None, U16(1e-4, "rad")]
    reference: Annotated[WindReference | None, Lookup(3, WindReference)]
    reserved: Annotated[None, Reserved(21)] = None


class EnvironmentalParametersObsolete(Message, pgn=130310):
    """PGN 130310: water and air temperature, air pressure (130311 and 130312 came after it).

    Single frame, priority 5, 2 Hz. Layout: canboat `environmentalParametersObsolete`.
    """

    sid: Annotated[int | None, U8()]
    water_temperature: Annotated[float | None, U16(0.01, "K")]
    outside_ambient_air_temperature: Annotated[float | None, U16(0.01, "K")]
    atmospheric_pressure: Annotated[int | None, U16(100, "Pa")]
    reserved: Annotated[None, Reserved(8)] = None


class EnvironmentalParameters(Message, pgn=130311):
    """PGN 130311: one temperature, one humidity and the air pressure.

    Single frame, priority 5, 2 Hz. Layout: canboat `environmentalParameters`.
    """

    sid: Annotated[int | None, U8()]
    temperature_source: Annotated[TemperatureSource | None, Lookup(6, TemperatureSource)]
    humidity_source: Annotated[HumiditySource | None, Lookup(2, HumiditySource)]
    temperature: Annotated[float | None, U16(0.01, "K")]
    humidity: Annotated[float | None, I16(0.004, "%")]
    atmospheric_pressure: Annotated[int | None, U16(100, "Pa")]


class Temperature(Message, pgn=130312):
    """PGN 130312: one temperature and its set point (130316 came after it).

    Single frame, priority 5, every 2 s. Layout: canboat `temperature`.
    """

    sid: Annotated[int | None, U8()]
    instance: Annotated[int | None, U8()]
    source: Annotated[TemperatureSource | None, Lookup(8, TemperatureSource)]
    actual_temperature: Annotated[float | None, U16(0.01, "K")]
    set_temperature: Annotated[float | None, U16(0.01, "K")]
    reserved: Annotated[None, Reserved(8)] = None


class TemperatureExtendedRange(Message, pgn=130316):
    """PGN 130316: one temperature and its set point.

    Single frame, priority 5, every 2 s. Layout: canboat `temperatureExtendedRange`.
    """

    sid: Annotated[int | None, U8()]
    instance: Annotated[int | None, U8()]
    source: Annotated[TemperatureSource | None, Lookup(8, TemperatureSource)]
    temperature: Annotated[float | None, U24(0.001, "K")]
    set_temperature: Annotated[float | None, U16(0.1, "K")]
