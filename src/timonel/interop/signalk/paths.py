"""The paths that we tell, with units and meaning, as `meta` has them.

Source: Signal K schema 1.7.0, `keyswithmetadata.json`; `steering.autopilot.engaged` and `.mode` are of the autopilot
API v2, `steering.command` is ours.
"""

from typing import Literal

import msgspec

Unit = Literal["rad", "rad/s", "m", "m/s", "K", "deg", ""]


class Path(msgspec.Struct, frozen=True):
    """A path's unit, "" for none, and what it means."""

    units: Unit
    description: str


def _course(kind: str) -> dict[str, Path]:
    base = f"navigation.course{kind}"
    return {
        f"{base}.crossTrackError": Path("m", "Distance from the track; positive asks to steer left"),
        f"{base}.bearingTrackTrue": Path("rad", "Bearing of the track, true"),
        f"{base}.bearingTrackMagnetic": Path("rad", "Bearing of the track, magnetic"),
        f"{base}.nextPoint.distance": Path("m", "Distance to the waypoint"),
        f"{base}.nextPoint.bearingTrue": Path("rad", "Bearing of the waypoint, true"),
        f"{base}.nextPoint.bearingMagnetic": Path("rad", "Bearing of the waypoint, magnetic"),
        f"{base}.nextPoint.velocityMadeGood": Path("m/s", "Speed towards the waypoint"),
        f"{base}.nextPoint.position": Path("", "Where the waypoint is"),
    }


PATHS = {
    "navigation.headingTrue": Path("rad", "Where the bow points, true"),
    "navigation.headingMagnetic": Path("rad", "Where the bow points, magnetic"),
    "navigation.magneticDeviation": Path("rad", "Deviation of the compass, east positive"),
    "navigation.magneticVariation": Path("rad", "Variation, east positive"),
    "navigation.rateOfTurn": Path("rad/s", "Rate of turn, positive to starboard"),
    "navigation.attitude": Path("", "Roll, pitch and yaw; positive with starboard down and bow up"),
    "navigation.position": Path("", "Where the boat is, WGS84"),
    "navigation.gnss.methodQuality": Path("", "How the position was found"),
    "navigation.gnss.satellites": Path("", "Satellites in use"),
    "navigation.gnss.antennaAltitude": Path("m", "Altitude of the antenna above mean sea level"),
    "navigation.gnss.geoidalSeparation": Path("m", "Mean sea level above the ellipsoid"),
    "navigation.gnss.horizontalDilution": Path("", "HDOP"),
    "navigation.gnss.positionDilution": Path("", "PDOP"),
    "navigation.courseOverGroundTrue": Path("rad", "Course over ground, true"),
    "navigation.courseOverGroundMagnetic": Path("rad", "Course over ground, magnetic"),
    "navigation.speedOverGround": Path("m/s", "Speed over ground"),
    "navigation.speedThroughWater": Path("m/s", "Speed through water"),
    "navigation.log": Path("m", "Distance sailed through water"),
    "navigation.trip.log": Path("m", "Distance sailed through water since reset"),
    "navigation.datetime": Path("", "Date and time of the bus, UTC"),
    "environment.depth.belowTransducer": Path("m", "Depth below the transducer"),
    "environment.depth.belowSurface": Path("m", "Depth below the waterline"),
    "environment.depth.belowKeel": Path("m", "Depth below the keel"),
    "environment.depth.surfaceToTransducer": Path("m", "Transducer below the waterline"),
    "environment.depth.transducerToKeel": Path("m", "Keel below the transducer"),
    "environment.wind.speedApparent": Path("m/s", "Apparent wind"),
    "environment.wind.angleApparent": Path("rad", "Apparent wind from the bow, negative to port"),
    "environment.wind.speedTrue": Path("m/s", "Wind against the water"),
    "environment.wind.angleTrueWater": Path("rad", "Wind against the water from the bow, negative to port"),
    "environment.wind.speedOverGround": Path("m/s", "Wind over ground"),
    "environment.wind.angleTrueGround": Path("rad", "Wind over ground from the bow, negative to port"),
    "environment.wind.directionTrue": Path("rad", "Where the wind over ground comes from, true"),
    "environment.wind.directionMagnetic": Path("rad", "Where the wind over ground comes from, magnetic"),
    "environment.current": Path("", "Current: whither it sets, and how fast"),
    "environment.water.temperature": Path("K", "Temperature of the water"),
    "steering.rudderAngle": Path("rad", "Rudder, positive to starboard"),
    "steering.autopilot.state": Path("", "State of the autopilot; null: not understood"),
    "steering.autopilot.mode": Path("", "What the autopilot steers by"),
    "steering.autopilot.engaged": Path("", "Whether the autopilot steers"),
    "steering.autopilot.target.headingTrue": Path("rad", "Course that the autopilot holds, true"),
    "steering.autopilot.target.headingMagnetic": Path("rad", "Course that the autopilot holds, magnetic"),
    "steering.command": Path("", "The station in command; null: nobody"),
    **_course("GreatCircle"),
    **_course("Rhumbline"),
}
