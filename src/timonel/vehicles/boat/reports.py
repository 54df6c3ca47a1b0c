"""What pilots say of themselves, read as each maker means it.

127237 has a field for the mode, but not every pilot means the same by it, and some mean nothing:

maker      mode field of 127237                    mode is told by              held heading is told by
Furuno     1 while the helm is jogged, 3 holding   127237                       127237
Raymarine  2 engaged in any mode, 0 standing by    65379                        65360
Navico     often not available                     65305, 65340, else 127237    127237, else 65341
Garmin     -                                       126720, when it changes      126720, of an unknown north
others     as canboat's `STEERING_MODE`            127237                       127237

A mode that is told but not understood is `Mode.UNKNOWN`, never STANDBY: the boat may be steering. So is mode 1 or
2 of a maker that has not introduced itself: a Raymarine pilot in 2 holds a course, a lever in 2 does not. And so is
the mode of a Garmin pilot that has not changed it since we listen. Its control heads command it with the messages in
which it reports: only what the pilot itself says counts, which it must have introduced itself for.
Source: spec/boat.md rule 11; canboat samples `furuno-fap7011c-autopilot-off-then-on`, `raymarine-ev1`.
"""

from collections.abc import Callable

import msgspec

from timonel.nmea2000.lookups import (
    DeviceClass,
    GarminPilotMode,
    HeadingReference,
    ManufacturerCode,
    SeatalkMode,
    SimnetApMode,
    SimnetApModeFlags,
    SimnetAutopilotMode,
    SteeringMode,
)
from timonel.nmea2000.messages.garmin import (
    GarminAutopilotHeadingToSteer,
    GarminAutopilotModeState,
    GarminAutopilotRateOfTurn,
)
from timonel.nmea2000.messages.navico import SimnetAutopilotAngle, SimnetAutopilotModeState, SimnetPilotMode
from timonel.nmea2000.messages.network import IsoAddressClaim
from timonel.nmea2000.messages.raymarine import SeatalkPilotLockedHeading, SeatalkPilotMode
from timonel.nmea2000.messages.steering import HeadingTrackControl
from timonel.vehicles.boat.pilot import Mode
from timonel.vehicles.boat.truth import Datum

AUTOPILOT = (DeviceClass.STEERING_AND_CONTROL, 150)
NAVICO = (ManufacturerCode.NAVICO, ManufacturerCode.SIMRAD, ManufacturerCode.B_AND_G)
TOLD = 5.0  # s that a mode told by a maker's own message counts; 65379 and 65305 come at 1 Hz
HOLD = 2.0  # s after which another device may be taken for the pilot; 127237 comes at 4 Hz

STANDARD = {
    SteeringMode.MAIN_STEERING: Mode.STANDBY,
    SteeringMode.HEADING_CONTROL_STANDALONE: Mode.HEADING_HOLD,
    SteeringMode.HEADING_CONTROL: Mode.HEADING_HOLD,
    SteeringMode.TRACK_CONTROL: Mode.TRACK,
}
FURUNO = STANDARD | {SteeringMode.NON_FOLLOW_UP: Mode.STANDBY}
RAYMARINE = {SteeringMode.MAIN_STEERING: Mode.STANDBY}
MAKERS = {ManufacturerCode.FURUNO: FURUNO, ManufacturerCode.RAYMARINE: RAYMARINE}
SEATALK = {
    SeatalkMode.STANDBY: Mode.STANDBY,
    SeatalkMode.AUTO: Mode.HEADING_HOLD,
    SeatalkMode.TRACK: Mode.TRACK,
}
SIMNET_FLAGS = {
    SimnetApModeFlags.STANDBY: Mode.STANDBY,
    SimnetApModeFlags.HEADING: Mode.HEADING_HOLD,
    SimnetApModeFlags.NAV: Mode.TRACK,
}
SIMNET = {
    SimnetAutopilotMode.STANDBY: Mode.STANDBY,
    SimnetAutopilotMode.HEADING: Mode.HEADING_HOLD,
    SimnetAutopilotMode.NON_FOLLOW_UP: Mode.STANDBY,
    SimnetAutopilotMode.NAVIGATION: Mode.TRACK,
}
GARMIN = {
    GarminPilotMode.STANDBY: Mode.STANDBY,
    GarminPilotMode.ENGAGED: Mode.HEADING_HOLD,
}

PilotMessage = (
    HeadingTrackControl
    | SeatalkPilotMode
    | SeatalkPilotLockedHeading
    | SimnetPilotMode
    | SimnetAutopilotModeState
    | SimnetAutopilotAngle
    | GarminAutopilotModeState
    | GarminAutopilotHeadingToSteer
    | GarminAutopilotRateOfTurn
)
Course = tuple[float, HeadingReference | None]


class Reading(msgspec.Struct, frozen=True, gc=False):
    """A report in the pilot's own terms: `course` in rad counted from `reference`, which not every pilot tells."""

    mode: Mode | None
    course: float | None = None
    reference: HeadingReference | None = None


class PilotReports:
    """Knows which device is the pilot, and reads it."""

    def __init__(self, chosen: Callable[[], int | None] | None = None) -> None:
        """`chosen` is the address of the pilot whose owner says which it is, or None while it is not there."""
        self._chosen = chosen
        self._names: dict[int, IsoAddressClaim] = {}
        self._pilot: Datum[int] = Datum(HOLD)
        self._told: Datum[Mode] = Datum(TOLD)
        self._locked: Datum[Course] = Datum(TOLD)
        self._reference: HeadingReference | None = None  # of the courses that the pilot tells in 127237
        self._garmin: tuple[int, Mode] | None = None  # who told it, and what; it is told only when it changes

    def introduce(self, name: IsoAddressClaim, source: int) -> None:
        """The device at `source` told its NAME."""
        self._names[source] = name

    def receive(self, message: PilotMessage, source: int, now: float) -> Reading | None:
        """What the pilot says of itself; None if `message` is not the pilot's or says nothing."""
        match message:
            case HeadingTrackControl():
                return self._read(message, source, now) if self._is_pilot(source, now) else None
            case SeatalkPilotLockedHeading():
                return self._lock(message, source, now)
            case SeatalkPilotMode(pilot_mode=SeatalkMode() as seatalk):
                return self._tell(SEATALK.get(seatalk, Mode.UNKNOWN), source, now)
            case SimnetPilotMode(mode=flags):
                return self._tell(SIMNET_FLAGS.get(flags, Mode.UNKNOWN), source, now)
            case SimnetAutopilotModeState(mode=SimnetAutopilotMode() as simnet):
                return self._tell(SIMNET.get(simnet, Mode.UNKNOWN), source, now)
            case SimnetAutopilotAngle(mode=SimnetApMode.HEADING, angle=float(angle)):
                return self._hold(angle, source, now)
            case GarminAutopilotModeState(mode_state=GarminPilotMode() as garmin):
                return self._tell_garmin(GARMIN.get(garmin, Mode.UNKNOWN), source, now)
            case GarminAutopilotHeadingToSteer(heading_to_steer=course):
                return self._tell_garmin(None, source, now, course)
            case GarminAutopilotRateOfTurn():
                return self._tell_garmin(None, source, now)
        return None

    def _lock(self, message: SeatalkPilotLockedHeading, source: int, now: float) -> Reading | None:
        """65360: with the mode that 65379 told, a report."""
        true, magnetic = message.target_heading_true, message.target_heading_magnetic
        if true is not None:
            self._locked.offer((true, HeadingReference.TRUE), now, source)
        elif magnetic is not None:
            self._locked.offer((magnetic, HeadingReference.MAGNETIC), now, source)
        mode = self._told.at(now, TOLD)
        if mode is None or not self._is_pilot(source, now, own_words=True):
            return None
        return Reading(mode, *self._locked_course(now))

    def _hold(self, angle: float, source: int, now: float) -> Reading | None:
        """65341: the held heading, counted as the pilot's 127237 counts."""
        mode = self._told.at(now, TOLD)
        if mode is None or self._reference is None or not self._is_pilot(source, now, own_words=True):
            return None
        return Reading(mode, angle, self._reference)

    def _tell(self, mode: Mode, source: int, now: float) -> Reading | None:
        if not self._is_pilot(source, now, own_words=True):
            return None
        if mode is Mode.HEADING_HOLD and self._told.at(now, TOLD) not in (None, mode):
            self._locked.withdraw(source)  # it is the course of the last time that it held one
        self._told.offer(mode, now, source)
        return Reading(mode, *self._locked_course(now))

    def _tell_garmin(self, mode: Mode | None, source: int, now: float, course: float | None = None) -> Reading | None:
        """126720 of the pilot itself: its control heads say the same, to command it."""
        name = self._names.get(source)
        named = name is not None and (name.device_class, name.device_function) == AUTOPILOT
        if not named or not self._is_pilot(source, now):
            return None
        if mode is not None:
            self._garmin = (source, mode)
        told = self._garmin[1] if self._garmin is not None and self._garmin[0] == source else Mode.UNKNOWN
        return Reading(told, course)

    def _read(self, message: HeadingTrackControl, source: int, now: float) -> Reading:
        mode = self._told.at(now, TOLD) or self._mode(message, source)
        if message.heading_to_steer_course is None:
            return Reading(mode, *self._locked_course(now))
        self._reference = message.heading_reference
        return Reading(mode, message.heading_to_steer_course, message.heading_reference)

    def _locked_course(self, now: float) -> tuple[float | None, HeadingReference | None]:
        return self._locked.at(now, TOLD) or (None, None)

    def _mode(self, message: HeadingTrackControl, source: int) -> Mode | None:
        name = self._names.get(source)
        maker = None if name is None else name.manufacturer_code
        told = message.steering_mode
        if told is None:
            return Mode.UNKNOWN if maker in NAVICO else None
        modes = MAKERS.get(maker, STANDARD) if maker is not None else STANDARD
        return modes.get(told, Mode.UNKNOWN)

    def _is_pilot(self, source: int, now: float, own_words: bool = False) -> bool:
        """Whoever says to be an autopilot or has its maker's words for the mode, else who sends 127237.

        Control heads send 127237 too: Raymarine's do, its pilot does not.
        """
        if self._chosen is not None and (chosen := self._chosen()) is not None and source != chosen:
            return False
        name = self._names.get(source)
        if own_words or (name is not None and (name.device_class, name.device_function) == AUTOPILOT):
            rank = 0
        else:
            rank = 1 if name is None else 2
        return self._pilot.offer(source, now, source, rank)
