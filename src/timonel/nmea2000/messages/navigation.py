"""Time, position, speed, depth, and the way to the waypoint."""

from typing import Annotated

from timonel.core.fields import (
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    Date,
    Lookup,
    Repeat,
    Reserved,
    StringLau,
    TimeOfDay,
    Unsigned,
)
from timonel.core.message import Message
from timonel.nmea2000.lookups import (
    CalculationType,
    GnssIntegrity,
    GnssMethod,
    GnssType,
    HeadingReference,
    OffOn,
    RouteDirection,
    TimeSource,
    WaterReference,
    XteMode,
    YesNo,
)

ALTITUDE = 9.2e12  # m; a float cannot tell higher values in 64 bits from those that are not available


class SystemTime(Message, pgn=126992):
    """PGN 126992: date and time UTC, and whose clock it is.

    Single frame, priority 3, 1 Hz. Layout: canboat `systemTime`.
    """

    sid: Annotated[int | None, U8()]
    source: Annotated[TimeSource | None, Lookup(4, TimeSource)]
    reserved: Annotated[None, Reserved(4)] = None
    date: Annotated[int | None, Date()]
    time: Annotated[float | None, TimeOfDay()]


class Speed(Message, pgn=128259):
    """PGN 128259: speed through water, and over ground.

    Single frame, priority 2, 1 Hz. Layout: canboat `speed`.
    """

    sid: Annotated[int | None, U8()]
    speed_water_referenced: Annotated[float | None, U16(0.01, "m/s")]
    speed_ground_referenced: Annotated[float | None, U16(0.01, "m/s")]
    speed_water_referenced_type: Annotated[WaterReference | None, Lookup(8, WaterReference)]
    speed_direction: Annotated[int | None, Unsigned(4)]
    reserved: Annotated[None, Reserved(12)] = None


class WaterDepth(Message, pgn=128267):
    """PGN 128267: depth below the transducer.

    Single frame, priority 3, 1 Hz. Layout: canboat `waterDepth`.

    `offset` is positive from the transducer up to the waterline, negative down to the keel; `range` is the
    greatest depth that can be measured.
    """

    sid: Annotated[int | None, U8()]
    depth: Annotated[float | None, U32(0.01, "m")]
    offset: Annotated[float | None, I16(0.001, "m")]
    range: Annotated[int | None, U8(10, "m")]


class DistanceLog(Message, pgn=128275):
    """PGN 128275: distance sailed through water, in all and since reset.

    Fast packet, priority 6, 1 Hz. Layout: canboat `distanceLog`.
    """

    date: Annotated[int | None, Date()]
    time: Annotated[float | None, TimeOfDay()]
    log: Annotated[int | None, U32(1, "m")]
    trip_log: Annotated[int | None, U32(1, "m")]


class PositionRapidUpdate(Message, pgn=129025):
    """PGN 129025: position, and nothing else.

    Single frame, priority 2, 10 Hz. Layout: canboat `positionRapidUpdate`.
    """

    latitude: Annotated[float | None, I32(1e-7, "deg", limit=90)]
    longitude: Annotated[float | None, I32(1e-7, "deg", limit=180)]


class CogSogRapidUpdate(Message, pgn=129026):
    """PGN 129026: course and speed over ground.

    Single frame, priority 2, 4 Hz. Layout: canboat `cogSogRapidUpdate`.
    """

    sid: Annotated[int | None, U8()]
    cog_reference: Annotated[HeadingReference | None, Lookup(2, HeadingReference)]
    reserved: Annotated[None, Reserved(6)] = None
    cog: Annotated[float | None, U16(1e-4, "rad")]
    sog: Annotated[float | None, U16(0.01, "m/s")]
    reserved6: Annotated[None, Reserved(16)] = None


class ReferenceStation(Message):
    """Where the corrections of a GNSS position come from; repeated in 129029."""

    reference_station_type: Annotated[GnssType | None, Lookup(4, GnssType)]
    reference_station_id: Annotated[int | None, Unsigned(12)]
    age_of_dgnss_corrections: Annotated[float | None, U16(0.01, "s")]


class GnssPositionData(Message, pgn=129029):
    """PGN 129029: position with time, altitude and quality.

    Fast packet, priority 3, 1 Hz. Layout: canboat `gnssPositionData`.

    `altitude` is above mean sea level, `geoidal_separation` is mean sea level above the ellipsoid.
    """

    sid: Annotated[int | None, U8()] = None
    date: Annotated[int | None, Date()] = None
    time: Annotated[float | None, TimeOfDay()] = None
    latitude: Annotated[float | None, I64(1e-16, "deg", limit=90)] = None
    longitude: Annotated[float | None, I64(1e-16, "deg", limit=180)] = None
    altitude: Annotated[float | None, I64(1e-6, "m", limit=ALTITUDE)] = None
    gnss_type: Annotated[GnssType | None, Lookup(4, GnssType)] = None
    method: Annotated[GnssMethod | None, Lookup(4, GnssMethod)] = None
    integrity: Annotated[GnssIntegrity, Lookup(2, GnssIntegrity)] = GnssIntegrity.NO_INTEGRITY_CHECKING
    reserved: Annotated[None, Reserved(6)] = None
    number_of_svs: Annotated[int | None, U8()] = None
    hdop: Annotated[float | None, I16(0.01)] = None
    pdop: Annotated[float | None, I16(0.01)] = None
    geoidal_separation: Annotated[float | None, I32(0.01, "m")] = None
    reference_stations: Annotated[int | None, U8()] = None
    stations: Annotated[tuple[ReferenceStation, ...], Repeat(ReferenceStation, "reference_stations")] = ()


class TimeDate(Message, pgn=129033):
    """PGN 129033: date and time UTC, and the offset of local time.

    Single frame, priority 3, 1 Hz. Layout: canboat `timeDate`.
    """

    date: Annotated[int | None, Date()]
    time: Annotated[float | None, TimeOfDay()]
    local_offset: Annotated[int | None, I16(60, "s")]


class CrossTrackError(Message, pgn=129283):
    """PGN 129283: distance from the track; positive asks to steer left.

    Single frame, priority 3, 1 Hz. Layout: canboat `crossTrackError`.
    """

    sid: Annotated[int | None, U8()]
    xte_mode: Annotated[XteMode | None, Lookup(4, XteMode)]
    reserved: Annotated[None, Reserved(2)] = None
    navigation_terminated: Annotated[YesNo | None, Lookup(2, YesNo)]
    xte: Annotated[float | None, I32(0.01, "m")]
    reserved6: Annotated[None, Reserved(16)] = None


class NavigationData(Message, pgn=129284):
    """PGN 129284: the way to the destination waypoint.

    Fast packet, priority 3, 1 Hz. Layout: canboat `navigationData`.
    """

    sid: Annotated[int | None, U8()] = None
    distance_to_waypoint: Annotated[float | None, U32(0.01, "m")] = None
    course_bearing_reference: Annotated[HeadingReference | None, Lookup(2, HeadingReference)] = None
    perpendicular_crossed: Annotated[YesNo | None, Lookup(2, YesNo)] = None
    arrival_circle_entered: Annotated[YesNo | None, Lookup(2, YesNo)] = None
    calculation_type: Annotated[CalculationType | None, Lookup(2, CalculationType)] = None
    eta_time: Annotated[float | None, TimeOfDay()] = None
    eta_date: Annotated[int | None, Date()] = None
    bearing_origin_to_destination_waypoint: Annotated[float | None, U16(1e-4, "rad")] = None
    bearing_position_to_destination_waypoint: Annotated[float | None, U16(1e-4, "rad")] = None
    origin_waypoint_number: Annotated[int | None, U32()] = None
    destination_waypoint_number: Annotated[int | None, U32()] = None
    destination_latitude: Annotated[float | None, I32(1e-7, "deg", limit=90)] = None
    destination_longitude: Annotated[float | None, I32(1e-7, "deg", limit=180)] = None
    waypoint_closing_velocity: Annotated[float | None, I16(0.01, "m/s")] = None


class SetDriftRapidUpdate(Message, pgn=129291):
    """PGN 129291: the current, whither it sets and how fast.

    Single frame, priority 3, 1 Hz. Layout: canboat `setDriftRapidUpdate`.
    """

    sid: Annotated[int | None, U8()]
    set_reference: Annotated[HeadingReference | None, Lookup(2, HeadingReference)]
    reserved: Annotated[None, Reserved(6)] = None
    set: Annotated[float | None, U16(1e-4, "rad")]
    drift: Annotated[float | None, U16(0.01, "m/s")]
    reserved6: Annotated[None, Reserved(16)] = None


class Waypoint(Message):
    """A waypoint of a route; repeated in 129285."""

    wp_id: Annotated[int | None, U16()]
    wp_name: Annotated[str | None, StringLau()]
    wp_latitude: Annotated[float | None, I32(1e-7, "deg", limit=90)]
    wp_longitude: Annotated[float | None, I32(1e-7, "deg", limit=180)]


class NavigationRouteWpInformation(Message, pgn=129285):
    """PGN 129285: a route and its waypoints.

    Fast packet, priority 6, on event. Layout: canboat `navigationRouteWpInformation`.
    """

    start_rps: Annotated[int | None, U16()]
    nitems: Annotated[int | None, U16()] = None
    database_id: Annotated[int | None, U16()]
    route_id: Annotated[int | None, U16()]
    navigation_direction_in_route: Annotated[RouteDirection | None, Lookup(3, RouteDirection)]
    supplementary_route_wp_data_available: Annotated[OffOn | None, Lookup(2, OffOn)]
    reserved: Annotated[None, Reserved(3)] = None
    route_name: Annotated[str | None, StringLau()]
    reserved9: Annotated[None, Reserved(8)] = None
    waypoints: Annotated[tuple[Waypoint, ...], Repeat(Waypoint, "nitems")] = ()
