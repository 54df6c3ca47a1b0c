"""PGN 127237 to everybody, as the standard has it.

No recreational pilot is known to obey it as a command; the simulated one does, and pilots built for it.
Fields that do not apply are not available. Source: spec/boat.md, Commands become NMEA 2000.
"""

import struct
from collections.abc import Sequence
from math import radians

from timonel.nmea2000.lookups import SteeringMode, YesNo
from timonel.nmea2000.messages.steering import HeadingTrackControl
from timonel.nmea2000.sender import Outgoing
from timonel.vehicles.boat.pilot import TURN, Manner
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
STEPS_A_RAD = 10_000

COURSE_AT, HEADING_AT = (
    slot.offset // 8
    for slot in HeadingTrackControl.layout
    if slot.name in ("heading_to_steer_course", "vessel_heading") and slot.offset is not None
)
FILL_IN = struct.Struct(f"<{COURSE_AT}sH{HEADING_AT - COURSE_AT - 2}sH").pack
"""A 127237: its bytes before the course to steer, the course, the bytes up to the present heading, and that."""


class StandardPilot(Driver):
    """See above."""

    messages_only = True

    def __init__(self, compass: Compass) -> None:
        self._compass = compass
        self._reference = compass.reference
        blank = self._told(0, None)
        self._before, self._between = blank[:COURSE_AT], blank[COURSE_AT + 2 : HEADING_AT]

    def steer(self, setpoint: int | None, heading: float | None, now: float, manner: Manner) -> Sequence[Answer]:
        """See `Driver`. Runs between a station's key and the rudder: of a course only what changes is made anew."""
        if setpoint is None or heading is None or not (0 <= setpoint < TURN and 0.0 <= heading <= 360.0):
            return [Outgoing(127237, self._told(setpoint, heading))]
        course, present = round(radians(setpoint / 10) * STEPS_A_RAD), round(radians(heading) * STEPS_A_RAD)
        return [Outgoing(127237, FILL_IN(self._before, course, self._between, present))]

    def _told(self, setpoint: int | None, heading: float | None) -> bytes:
        return HeadingTrackControl(
            override=NO,
            steering_mode=LET_GO if setpoint is None else HOLD,
            heading_reference=self._reference,
            heading_to_steer_course=None if setpoint is None else radians(setpoint / 10),
            vessel_heading=None if heading is None else radians(heading),
        ).encode()

    def hear(self, reading: Reading, heading: float | None, now: float) -> float | None:
        """See `Driver`."""
        return self._compass.ours(reading.course, reading.reference, now)
