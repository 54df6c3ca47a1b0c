"""Garmin's pilots: Reactor and GHP, told as their control heads tell them.

what                       message, PGN 126720
engage, let go             mode state 5, mode state 2, to the pilot's computer
change of course           the button of one or ten degrees to port or starboard
a control head is there    heartbeat, every 2.1 s

The computer repeats the mode to everybody within 65 ms, and tells the new heading to steer within 50 ms of a button.
It does not say what north that is counted from. But while it stands by it tells, five times a second and more, the
heading that it would hold, which otherwise it tells only when it changes: what lies between that stream and our own
heading is measured, and taken off afterwards. Until that was measured no course can be commanded. The mode is told
only when it changes, and is unknown until then. Shadow drive, which is a hand on the wheel, is no mode of ours.

Source: canboat samples `garmin-ap-reactor-126720` (a session with a GHP Reactor) and
`boatkit-garmin-autopilot-controls` (all four buttons); canboat issues 748, 753, 758.
"""

from math import degrees, radians, tau

from timonel.nmea2000.identifier import GLOBAL
from timonel.nmea2000.lookups import GarminManeuver, GarminPilotMode, ManufacturerCode
from timonel.nmea2000.messages.garmin import (
    GarminAutopilotHeartbeat,
    GarminAutopilotManeuver,
    GarminAutopilotModeState,
)
from timonel.nmea2000.sender import Outgoing, outgoing
from timonel.vehicles.boat.pilot import Mode, tenths
from timonel.vehicles.boat.pilots.driver import Answer, Compass, Evidence, Kind
from timonel.vehicles.boat.pilots.engaged import BySteps
from timonel.vehicles.boat.pilots.finder import Finder
from timonel.vehicles.boat.reports import Reading

MAKERS = frozenset({ManufacturerCode.GARMIN})
HEARTBEAT = outgoing(GarminAutopilotHeartbeat(heartbeat_data=bytes.fromhex("04 00 c8 00")))
PRESSED_SIZE = 9  # bytes: a button is told without the last field
TEN, ONE = 100, 10  # tenths
STREAM_GAP = 0.5  # s from one heading to the next while it stands by; 0.1 s in the recording
STREAM = 10  # headings in a row that are a stream, and no buttons pressed

KIND = Kind(
    name="garmin",
    steers="Garmin Reactor and GHP, with a control head of their own on the bus",
    evidence=Evidence.CAPTURED,
    sources="canboat samples garmin-ap-reactor-126720, boatkit-garmin-autopilot-controls; canboat issue 758",
    sends="126720",
    confirmed_by="126720",
    absolute=False,
    references="not told; measured against our own heading while it stands by",
    adopts=True,
)


class GarminPilot(BySteps):
    """See above."""

    uncountable = "the pilot's courses cannot be told from ours: they were not heard while it stood by"
    tells_course = False  # it holds the last heading that it told standing by
    keep_alive = (2.1,)

    def __init__(self, finder: Finder, compass: Compass) -> None:
        super().__init__(finder, compass)
        self._offset: float | None = None  # rad, from the pilot's heading to ours
        self._told: float | None = None  # the course that it told last, in rad as it counts
        self._told_at = 0.0
        self._streamed = 0

    def hear(self, reading: Reading, heading: float | None, now: float) -> float | None:
        """See `Driver`. Standing by it tells what its compass reads; the last of that it holds when engaged."""
        if reading.course is not None:
            self._measure(reading.course, reading.mode, heading, now)
        if reading.mode is not Mode.HEADING_HOLD or self._offset is None or self._told is None:
            return None
        return (self._told + self._offset) % tau

    def _measure(self, course: float, mode: Mode | None, heading: float | None, now: float) -> None:
        self._streamed = self._streamed + 1 if now - self._told_at <= STREAM_GAP else 1
        self._told, self._told_at = course, now
        stands_by = mode is Mode.STANDBY or (mode is Mode.UNKNOWN and self._streamed > STREAM)
        if stands_by and heading is not None:
            self._offset = radians(heading) - course

    def theirs(self, setpoint: int, now: float) -> int | None:
        """See `EngagedPilot`."""
        return None if self._offset is None else tenths(setpoint / 10 - degrees(self._offset))

    def engage(self) -> list[Answer]:
        """See `EngagedPilot`."""
        address = self.finder.address
        return [] if address is None else [_mode(GarminPilotMode.ENGAGED, address)]

    def release(self) -> list[Answer]:
        """See `EngagedPilot`."""
        address = self.finder.address
        return [_mode(GarminPilotMode.STANDBY, GLOBAL if address is None else address)]

    def change(self, step: int) -> tuple[int, list[Answer]]:
        """See `BySteps`. One button."""
        address = self.finder.address
        if address is None:
            return 0, []
        size = TEN if abs(step) > TEN - ONE // 2 else ONE
        return (size if step > 0 else -size), [_button(BUTTONS[size if step > 0 else -size], address)]

    def show(self, which: int) -> list[Answer]:
        """See `EngagedPilot`."""
        address = self.finder.address
        return [] if address is None else [Outgoing(HEARTBEAT.pgn, HEARTBEAT.payload, address)]


BUTTONS = {
    -ONE: GarminManeuver.DECREASE_HEADING_1_DEGREE,
    -TEN: GarminManeuver.DECREASE_HEADING_10_DEGREES,
    ONE: GarminManeuver.INCREASE_HEADING_1_DEGREE,
    TEN: GarminManeuver.INCREASE_HEADING_10_DEGREES,
}


def _mode(mode: GarminPilotMode, address: int) -> Outgoing:
    return outgoing(GarminAutopilotModeState(mode_state=mode), address)


def _button(button: GarminManeuver, address: int) -> Outgoing:
    return Outgoing(126720, GarminAutopilotManeuver(maneuver_code=button, value=None).encode()[:PRESSED_SIZE], address)
