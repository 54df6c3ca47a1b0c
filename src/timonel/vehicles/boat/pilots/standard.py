"""PGN 127237 to everybody, as the standard has it.

No recreational pilot is known to obey it as a command; the simulated one does, and pilots built for it.
Fields that do not apply are not available. Source: spec/boat.md, Commands become NMEA 2000.
"""

from collections.abc import Sequence
from math import radians

from timonel.nmea2000.lookups import SteeringMode, YesNo
from timonel.nmea2000.messages.steering import HeadingTrackControl
from timonel.nmea2000.sender import Outgoing
from timonel.vehicles.boat.pilot import Manner
from timonel.vehicles.boat.pilots.driver import Answer, Compass, Driver, Evidence, Kind
from timonel.vehicles.boat.reports import Reading

KIND = Kind(
    name="standard",
    steers="pilots that obey PGN 127237 as a command: the simulated one, and pilots of your own",
    evidence=Evidence.STANDARD,
    sources="NMEA 2000; canboat `headingTrackControl`",
    sends="127237",
    confirmed_by="127237",
    absolute=True,
    references="true or magnetic, as the boat's",
)

# Looked up once: a member of an enum costs as much as a call, and these stand between a key and the rudder.
HOLD, LET_GO, NO = SteeringMode.HEADING_CONTROL, SteeringMode.MAIN_STEERING, YesNo.NO


class StandardPilot(Driver):
    """See above."""

    messages_only = True

    def __init__(self, compass: Compass) -> None:
        self._compass = compass
        self._reference = compass.reference

    def steer(self, setpoint: int | None, heading: float | None, now: float, manner: Manner) -> Sequence[Answer]:
        """See `Driver`. Runs between a station's key and the rudder: keep it short."""
        payload = HeadingTrackControl(
            override=NO,
            steering_mode=LET_GO if setpoint is None else HOLD,
            heading_reference=self._reference,
            heading_to_steer_course=None if setpoint is None else radians(setpoint / 10),
            vessel_heading=None if heading is None else radians(heading),
        ).encode()
        return [Outgoing(127237, payload)]

    def hear(self, reading: Reading, heading: float | None, now: float) -> float | None:
        """See `Driver`."""
        return self._compass.ours(reading.course, reading.reference, now)
