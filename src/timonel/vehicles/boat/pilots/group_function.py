"""PGN 126208: command the fields of the pilot's 127237, as the standard has it for every message.

A pilot that obeys answers with an acknowledgement; whether it steers, its 127237 tells. No recording shows a pilot
that takes a course in this way. Source: canboat `nmeaCommandGroupFunction`.
"""

from collections.abc import Sequence
from math import radians

from timonel.nmea2000.identifier import GLOBAL
from timonel.nmea2000.lookups import SteeringMode
from timonel.nmea2000.messages.group_function import command
from timonel.nmea2000.messages.steering import HeadingTrackControl
from timonel.nmea2000.sender import outgoing
from timonel.vehicles.boat.pilot import Manner
from timonel.vehicles.boat.pilots.driver import Answer, Compass, Driver, Evidence, Kind
from timonel.vehicles.boat.pilots.finder import Finder
from timonel.vehicles.boat.reports import Reading

KIND = Kind(
    name="groupfunction",
    steers="pilots that let a group function set fields of their 127237",
    evidence=Evidence.STANDARD,
    sources="NMEA 2000; canboat `nmeaCommandGroupFunction`",
    sends="126208",
    confirmed_by="127237",
    absolute=True,
    references="true or magnetic, as the boat's",
)


class GroupFunctionPilot(Driver):
    """See above."""

    def __init__(self, finder: Finder, compass: Compass) -> None:
        self.finder = finder
        self._compass = compass

    def objection(self, setpoint: int, now: float) -> str | None:
        """See `Driver`."""
        return self.finder.objection

    def steer(self, setpoint: int | None, heading: float | None, now: float, manner: Manner) -> Sequence[Answer]:
        """See `Driver`."""
        address = self.finder.address
        if setpoint is None:
            let_go = command(HeadingTrackControl, steering_mode=SteeringMode.MAIN_STEERING)
            return [outgoing(let_go, GLOBAL if address is None else address)]
        if address is None:
            return []
        hold = command(
            HeadingTrackControl,
            steering_mode=SteeringMode.HEADING_CONTROL,
            heading_reference=self._compass.reference,
            heading_to_steer_course=radians(setpoint / 10),
        )
        return [outgoing(hold, address)]

    def hear(self, reading: Reading, heading: float | None, now: float) -> float | None:
        """See `Driver`."""
        return self._compass.ours(reading.course, reading.reference, now)
