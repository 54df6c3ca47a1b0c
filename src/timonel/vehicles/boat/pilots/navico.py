"""Navico's pilots (Simrad, B&G, Lowrance): AC-12 and AC-42, NAC-2 and NAC-3, tiller pilots on SimNet.

what                       message
engage, let go             130850 to everybody with the pilot's address in it: event 9, event 6
change of course           130850: event 26, to port or starboard by an angle, relative to the course steered
a control head is there    65305 reports 3 and 11 (send status, send mode), every second

A pilot whose address stands in a command copies it into 130851 within 70 ms; that says nothing about whether it
obeys, for it refuses when a sensor is missing. Mode: 65305 report 10, 65340 of an AC-42, 65341. Course: 127237,
else 65341. No way is known to command a course as such, so that courses are approached by changes of at most ten
degrees, as its control heads make them. Byte 7 of every command is 00: a NAC-3 ignores others.

Source: canboat samples `sample-single` (ten degrees, and the reply), `simnet-tp32` (heading mode, one degree, and the
replies), `simrad_event_timer_*` (65305 asked for and told); canboat `simnetApCommand`, `simnetDeviceStatusRequest`;
SignalK/signalk-autopilot issue 91 for byte 7.
"""

from collections.abc import Sequence
from math import radians

from timonel.nmea2000.lookups import (
    HeadingReference,
    ManufacturerCode,
    SimnetApEvent,
    SimnetDeviceModel,
    SimnetDirection,
)
from timonel.nmea2000.messages.navico import (
    SimnetApCommand,
    SimnetCommandApChangeCourse,
    SimnetDeviceModeRequest,
    SimnetDeviceStatusRequest,
    SimnetPilotMode,
)
from timonel.nmea2000.sender import outgoing
from timonel.vehicles.boat.pilot import Mode, PilotReport
from timonel.vehicles.boat.pilots.driver import Answer, Compass, Evidence, Kind
from timonel.vehicles.boat.pilots.engaged import BySteps
from timonel.vehicles.boat.pilots.finder import Finder
from timonel.vehicles.boat.reports import PilotMessage, Reading

MAKERS = frozenset({ManufacturerCode.NAVICO, ManufacturerCode.SIMRAD, ManufacturerCode.B_AND_G})
LONGEST_STEP = 100  # tenths: what a key of a control head changes at most

KIND = Kind(
    name="navico",
    steers="Simrad and B&G pilots: AC-12, AC-42, NAC-2, NAC-3, tiller pilots on SimNet",
    evidence=Evidence.CAPTURED,
    sources="canboat samples sample-single, simnet-tp32, simrad_event_timer; SignalK/signalk-autopilot",
    sends="130850, 65305",
    confirmed_by="65305, 65340, 65341, 127237",
    absolute=False,
    references="as its 127237 says",
    adopts=True,
)


class NavicoPilot(BySteps):
    """See above."""

    keep_alive = (1.0,)

    def __init__(self, finder: Finder, compass: Compass) -> None:
        super().__init__(finder, compass)
        self._reference: HeadingReference | None = None
        self._model = SimnetDeviceModel.OTHER_DEVICE

    def objection(self, setpoint: int, now: float) -> str | None:
        """See `Driver`. What its courses are counted from is known only once it tells one."""
        if self._reference is None and self._mode is not Mode.HEADING_HOLD:
            return self.finder.objection
        return super().objection(setpoint, now)

    def theirs(self, setpoint: int, now: float) -> int | None:
        """See `EngagedPilot`. What its courses are counted from, the pilot says itself."""
        return None if self._reference is None else self.turned(setpoint, self._reference, now)

    def reported(
        self, message: PilotMessage, reading: Reading, report: PilotReport, pending: bool, now: float
    ) -> Sequence[Answer]:
        """See `Driver`."""
        if reading.reference is not None:
            self._reference = reading.reference
        if isinstance(message, SimnetPilotMode) and message.model is not None:
            self._model = message.model
        return super().reported(message, reading, report, pending, now)

    def engage(self) -> list[Answer]:
        """See `EngagedPilot`."""
        address = self.finder.address
        return [] if address is None else [self._event(SimnetApEvent.HEADING_MODE, address)]

    def release(self) -> list[Answer]:
        """See `EngagedPilot`. Without an address in it every pilot obeys, and none answers."""
        return [self._event(SimnetApEvent.STANDBY, self.finder.address)]

    def change(self, step: int) -> tuple[int, list[Answer]]:
        """See `BySteps`."""
        address = self.finder.address
        size = min(abs(step), LONGEST_STEP)
        if address is None:
            return 0, []
        towards = SimnetDirection.STARBOARD if step > 0 else SimnetDirection.PORT
        turn = SimnetCommandApChangeCourse(address=address, direction=towards, angle=radians(size / 10))
        return (size if step > 0 else -size), [outgoing(turn)]

    def show(self, which: int) -> list[Answer]:
        """See `EngagedPilot`."""
        return [
            outgoing(SimnetDeviceStatusRequest(model=self._model)),
            outgoing(SimnetDeviceModeRequest(model=self._model)),
        ]

    def _event(self, event: SimnetApEvent, address: int | None) -> Answer:
        return outgoing(SimnetApCommand(address=address, event=event))
