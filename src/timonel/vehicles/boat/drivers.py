"""How pilots are told what to do. One driver a kind of pilot, all behind `Driver`."""

from math import radians
from typing import Protocol

from timonel.nmea2000.lookups import HeadingReference, SteeringMode, YesNo
from timonel.nmea2000.messages.steering import HeadingTrackControl
from timonel.nmea2000.sender import Outgoing

# Looked up once: a member of an enum costs as much as a call, and these stand between a key and the rudder.
HOLD, LET_GO, NO = SteeringMode.HEADING_CONTROL, SteeringMode.MAIN_STEERING, YesNo.NO


class Driver(Protocol):
    """Says to a pilot what it is to do."""

    def steer(self, setpoint: int | None, heading: float | None) -> list[Outgoing]:
        """The messages that make it hold `setpoint` (tenths of a degree), or let go if that is None.

        `heading` is the boat's own in degrees, in the same reference, if it is known.
        """


class StandardPilot:
    """PGN 127237 to everybody, as the standard has it.

    No recreational pilot is known to obey it as a command; the simulated one does, and pilots built for it.
    Fields that do not apply are not available. Source: spec/boat.md, Commands become NMEA 2000.
    """

    def __init__(self, reference: HeadingReference) -> None:
        self._reference = reference

    def steer(self, setpoint: int | None, heading: float | None) -> list[Outgoing]:
        """See `Driver`. Runs between a station's key and the rudder: keep it short."""
        payload = HeadingTrackControl(
            override=NO,
            steering_mode=LET_GO if setpoint is None else HOLD,
            heading_reference=self._reference,
            heading_to_steer_course=None if setpoint is None else radians(setpoint / 10),
            vessel_heading=None if heading is None else radians(heading),
        ).encode()
        return [Outgoing(127237, payload)]
