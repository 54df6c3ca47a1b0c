"""Simulated pilots that speak as the makers' pilots do in the recordings: commanded, they answer as those answered.

dialect         obeys                                        answers at once                 says by itself
groupfunction   126208 command of 127237                     126208 acknowledgement          127237
raymarine       126208 command of 65379 and 65360, keys      126208, 65379, 65360            65359, 65360, 65379
raymarine-spx   keys of 16 bytes, 126208 command of 65360    65379, 65360                    65379, 65360
navico          130850 with byte 7 = 00                      130851, if it was addressed     65305, 65341, 127237
garmin          126720 to it: mode state, maneuver           126720: mode state, heading     126720
sentence        HTC                                          -                               -

Each steers with the law of `simulator.SimulatedPilot`. A test may make one `refuse` (it understands, but does not
engage) or turn it by another head (`turn`). The simulated Navico pilot lets go when no control head asked for its
state for ten seconds, as the real one is said to. Whether a real pilot does in every case what these do, nobody has
tried.
"""

from collections.abc import Callable
from math import pi, radians, tau

from timonel.nmea0183 import sentences as s
from timonel.nmea0183.registry import parse
from timonel.nmea2000.identifier import GLOBAL
from timonel.nmea2000.lookups import (
    DeviceClass,
    GarminManeuver,
    GarminPilotMode,
    HeadingReference,
    ManufacturerCode,
    ParameterError,
    PgnErrorCode,
    SeatalkKey,
    SeatalkMode,
    SimnetApEvent,
    SimnetApMode,
    SimnetApModeFlags,
    SimnetApStatus,
    SimnetDeviceModel,
    SimnetDirection,
    SteeringMode,
    TransmissionIntervalError,
    YesNo,
)
from timonel.nmea2000.messages.garmin import (
    GarminAutopilotHeadingToSteer,
    GarminAutopilotManeuver,
    GarminAutopilotModeState,
    GarminAutopilotRateOfTurn,
)
from timonel.nmea2000.messages.group_function import (
    NmeaAcknowledgeGroupFunction,
    NmeaCommandGroupFunction,
    message_of,
)
from timonel.nmea2000.messages.navico import (
    SimnetApCommand,
    SimnetAutopilotAngle,
    SimnetCommandApChangeCourse,
    SimnetDeviceModeRequest,
    SimnetDeviceStatus,
    SimnetDeviceStatusRequest,
    SimnetPilotMode,
)
from timonel.nmea2000.messages.network import ProductInformation
from timonel.nmea2000.messages.raymarine import (
    Seatalk1Keystroke,
    SeatalkPilotHeading,
    SeatalkPilotLockedHeading,
    SeatalkPilotMode,
)
from timonel.nmea2000.messages.steering import HeadingTrackControl
from timonel.nmea2000.registry import decode
from timonel.nmea2000.sender import Outgoing, outgoing
from timonel.vehicles.boat.pilots import htc
from timonel.vehicles.boat.simulator import TICK, Heard, SimulatedPilot

EVERY_SECOND = round(1 / TICK)  # ticks
FOUR_HERTZ = round(0.25 / TICK)
TEN_HERTZ = round(0.1 / TICK)
ABANDONED = round(10 / TICK)
COMPASS_ERROR = radians(3)  # of the Garmin pilot's own compass, which nothing on the bus corrects


class Dialect:
    """A pilot in its maker's words. `address` is where it is, `maker` and `kind` what it says it is."""

    address = 93
    maker = ManufacturerCode.SIGNAL_K
    kind = (DeviceClass.STEERING_AND_CONTROL, 150)
    product: ProductInformation | None = None
    reference = HeadingReference.MAGNETIC

    def __init__(self) -> None:
        self.law = SimulatedPilot()
        self.law.reference = self.reference
        self.refuses = False

    def receive(self, heard: Heard, heading: float) -> list[Outgoing]:
        """What somebody told it, and what it answers at once. `heading` is its own, in its reference."""
        return []

    def speak(self, tick: int, heading: float, rate: float) -> list[Outgoing]:
        """What it says by itself at a tick."""
        return []

    def told(self) -> list[Outgoing]:
        """What it says when its mode or its course has changed."""
        return []

    def turn(self, change: float) -> list[Outgoing]:
        """Another control head changes the course by `change` rad."""
        self.law.setpoint = (self.law.setpoint + change) % tau
        return self.told()

    def engage(self, course: float) -> None:
        """Hold `course`, unless it refuses."""
        if not self.refuses:
            self.law.hold(course, self.reference)

    def let_go(self) -> None:
        self.law.engaged = False


class GroupFunctionDialect(Dialect):
    """Lets the fields of its 127237 be commanded."""

    def receive(self, heard: Heard, heading: float) -> list[Outgoing]:
        """See `Dialect`."""
        command = decode(heard.pgn, heard.payload)
        if not isinstance(command, NmeaCommandGroupFunction) or command.pgn != HeadingTrackControl.PGN:
            return []
        wanted = message_of(HeadingTrackControl, command.parameters)
        if isinstance(wanted, HeadingTrackControl) and not (self.refuses and wanted.steering_mode):
            self.law.receive(wanted)
        return [_acknowledgement(command, heard.source)]

    def speak(self, tick: int, heading: float, rate: float) -> list[Outgoing]:
        """See `Dialect`."""
        return [outgoing(self.law.status(heading, self.law.order))] if tick % FOUR_HERTZ == 0 else []


class RaymarineDialect(Dialect):
    """An EV-1."""

    maker = ManufacturerCode.RAYMARINE

    def receive(self, heard: Heard, heading: float) -> list[Outgoing]:
        """See `Dialect`."""
        match decode(heard.pgn, heard.payload):
            case NmeaCommandGroupFunction(pgn=SeatalkPilotMode.PGN) as command:
                self._set_mode(message_of(SeatalkPilotMode, command.parameters), heading)
                return [_acknowledgement(command, heard.source), *self.told()]
            case NmeaCommandGroupFunction(pgn=SeatalkPilotLockedHeading.PGN) as command:
                self._set_course(message_of(SeatalkPilotLockedHeading, command.parameters))
                return [_acknowledgement(command, heard.source), *self.told()]
            case Seatalk1Keystroke(key=SeatalkKey.STANDBY):
                self.let_go()
                return self.told()
        return []

    def speak(self, tick: int, heading: float, rate: float) -> list[Outgoing]:
        """See `Dialect`."""
        said: list[Outgoing] = []
        if tick % TEN_HERTZ == 0:
            said.append(outgoing(SeatalkPilotHeading(sid=None, heading_true=None, heading_magnetic=heading)))
        if tick % FOUR_HERTZ == 0 and self.law.engaged:
            said.append(self._locked())
        if tick % EVERY_SECOND == 0:
            said.append(self._mode())
        return said

    def told(self) -> list[Outgoing]:
        """See `Dialect`."""
        return [self._mode(), self._locked()] if self.law.engaged else [self._mode()]

    def _set_mode(self, wanted: object, heading: float) -> None:
        match wanted:
            case SeatalkPilotMode(pilot_mode=SeatalkMode.STANDBY):
                self.let_go()
            case SeatalkPilotMode(pilot_mode=SeatalkMode.AUTO) if not self.law.engaged:
                self.engage(heading)

    def _set_course(self, wanted: object) -> None:
        match wanted:
            case SeatalkPilotLockedHeading(target_heading_magnetic=float(course)) if self.law.engaged:
                self.law.setpoint = course

    def _mode(self) -> Outgoing:
        mode = SeatalkMode.AUTO if self.law.engaged else SeatalkMode.STANDBY
        return outgoing(SeatalkPilotMode(pilot_mode=mode, sub_mode=0, pilot_mode_data=2))

    def _locked(self) -> Outgoing:
        locked = SeatalkPilotLockedHeading(
            sid=None, target_heading_true=None, target_heading_magnetic=self.law.setpoint
        )
        return outgoing(locked)


class ConvertedDialect(RaymarineDialect):
    """An SPX behind a converter."""

    kind = (DeviceClass.INTERNETWORK_DEVICE, 130)
    product = ProductInformation(
        nmea2000_version=1.3,
        product_code=1,
        model_id="SeaTalk-STNG-Converter",
        software_version_code="1.0",
        model_version="1",
        model_serial_code="0",
        certification_level=None,
        load_equivalency=1,
    )

    def receive(self, heard: Heard, heading: float) -> list[Outgoing]:
        """See `Dialect`."""
        match decode(heard.pgn, heard.payload):
            case Seatalk1Keystroke(key=SeatalkKey.AUTO) if not self.law.engaged:
                self.engage(heading)
            case Seatalk1Keystroke(key=SeatalkKey.STANDBY):
                self.let_go()
            case NmeaCommandGroupFunction(pgn=SeatalkPilotLockedHeading.PGN) as command:
                self._set_course(message_of(SeatalkPilotLockedHeading, command.parameters))
            case _:
                return []
        return self.told()


class NavicoDialect(Dialect):
    """A NAC-3."""

    maker = ManufacturerCode.NAVICO
    reference = HeadingReference.TRUE

    def __init__(self) -> None:
        super().__init__()
        self._asked = 0  # the tick at which a control head last asked
        self._tick = 0

    def receive(self, heard: Heard, heading: float) -> list[Outgoing]:
        """See `Dialect`."""
        match decode(heard.pgn, heard.payload):
            case SimnetDeviceStatusRequest() | SimnetDeviceModeRequest():
                self._asked = self._tick
            case SimnetApCommand() | SimnetCommandApChangeCourse() as command if self._meant(command, heard.payload):
                self._obey(command, heading)
                echo = [Outgoing(130851, heard.payload)] if command.address is not None else []
                return echo + self.told()
        return []

    def speak(self, tick: int, heading: float, rate: float) -> list[Outgoing]:
        """See `Dialect`."""
        self._tick = tick
        if not self.law.engaged:
            self._asked = tick
        elif tick - self._asked > ABANDONED:
            self.let_go()
        said = self.told() if tick % FOUR_HERTZ == 0 else []
        return said + self._state() if tick % EVERY_SECOND == 0 else said

    def told(self) -> list[Outgoing]:
        """See `Dialect`. 65341 says heading mode even when it stands by; only its angle is missing then."""
        course = self.law.setpoint if self.law.engaged else None
        control = HeadingTrackControl(
            rudder_limit_exceeded=YesNo.NO,
            off_heading_limit_exceeded=YesNo.NO,
            override=YesNo.NO,
            steering_mode=SteeringMode.HEADING_CONTROL if self.law.engaged else SteeringMode.MAIN_STEERING,
            heading_reference=self.reference,
            heading_to_steer_course=course,
        )
        return [outgoing(SimnetAutopilotAngle(mode=SimnetApMode.HEADING, angle=course)), outgoing(control)]

    def _meant(self, command: SimnetApCommand | SimnetCommandApChangeCourse, payload: bytes) -> bool:
        return command.address in (None, self.address) and payload[7] == 0

    def _obey(self, command: SimnetApCommand | SimnetCommandApChangeCourse, heading: float) -> None:
        match command:
            case SimnetApCommand(event=SimnetApEvent.STANDBY):
                self.let_go()
            case SimnetApCommand(event=SimnetApEvent.HEADING_MODE):
                self.engage(heading)
            case SimnetCommandApChangeCourse(direction=SimnetDirection.PORT, angle=float(angle)):
                self.law.setpoint = (self.law.setpoint - angle) % tau
            case SimnetCommandApChangeCourse(direction=SimnetDirection.STARBOARD, angle=float(angle)):
                self.law.setpoint = (self.law.setpoint + angle) % tau

    def _state(self) -> list[Outgoing]:
        engaged, model = self.law.engaged, SimnetDeviceModel.NAC
        status = SimnetApStatus.AUTOMATIC if engaged else SimnetApStatus.MANUAL
        mode = SimnetApModeFlags.HEADING if engaged else SimnetApModeFlags.STANDBY
        return [
            outgoing(SimnetDeviceStatus(model=model, status=status)),
            outgoing(SimnetPilotMode(model=model, mode=mode)),
        ]


BUTTONS = {  # degrees
    GarminManeuver.DECREASE_HEADING_1_DEGREE: -1,
    GarminManeuver.DECREASE_HEADING_10_DEGREES: -10,
    GarminManeuver.INCREASE_HEADING_1_DEGREE: 1,
    GarminManeuver.INCREASE_HEADING_10_DEGREES: 10,
}


class GarminDialect(Dialect):
    """A Reactor. It counts by a compass of its own."""

    maker = ManufacturerCode.GARMIN

    def receive(self, heard: Heard, heading: float) -> list[Outgoing]:
        """See `Dialect`."""
        if heard.destination not in (self.address, GLOBAL):
            return []
        match decode(heard.pgn, heard.payload):
            case GarminAutopilotModeState(mode_state=GarminPilotMode.ENGAGED) if not self.law.engaged:
                self.engage(heading)
                return self._mode() if self.law.engaged else []
            case GarminAutopilotModeState(mode_state=GarminPilotMode.STANDBY):
                self.let_go()
                return self._mode()
            case GarminAutopilotManeuver(maneuver_code=GarminManeuver() as button) if self.law.engaged:
                return self.turn(radians(BUTTONS.get(button, 0)))
        return []

    def speak(self, tick: int, heading: float, rate: float) -> list[Outgoing]:
        """See `Dialect`."""
        if not self.law.engaged:
            return [self._heading(heading)] if tick % TEN_HERTZ == 0 else []
        return [outgoing(GarminAutopilotRateOfTurn(rate_of_turn=rate))] if tick % EVERY_SECOND == 0 else []

    def told(self) -> list[Outgoing]:
        """See `Dialect`."""
        return [self._heading(self.law.setpoint)]

    def _mode(self) -> list[Outgoing]:
        mode = GarminPilotMode.ENGAGED if self.law.engaged else GarminPilotMode.STANDBY
        return [outgoing(GarminAutopilotModeState(mode_state=mode))]

    def _heading(self, heading: float) -> Outgoing:
        """As recorded, byte 8 is 00 where the layout has a reserved one."""
        told = GarminAutopilotHeadingToSteer(heading_to_steer=(heading + COMPASS_ERROR + pi) % tau - pi).encode()
        return Outgoing(126720, told[:8] + b"\0" + told[9:])


class SentenceDialect(Dialect):
    """A heading controller that takes HTC; its bytes come from the gateway's output."""

    reference = HeadingReference.TRUE

    def hear(self, line: bytes, heading: float) -> None:
        """A line of NMEA 0183; whatever is no HTC is not for it."""
        match parse(line.strip()):
            case s.HTC() as command:
                self._obey(htc.order(command), heading)

    def _obey(self, order: htc.Order, heading: float) -> None:
        match order:
            case htc.LetGo():
                self.let_go()
            case htc.Hold(course=float(course), reference=HeadingReference() as reference) if not self.refuses:
                self.law.hold(course, reference)


DIALECTS: dict[str, Callable[[], Dialect]] = {
    "groupfunction": GroupFunctionDialect,
    "raymarine": RaymarineDialect,
    "raymarine-spx": ConvertedDialect,
    "navico": NavicoDialect,
    "garmin": GarminDialect,
    "sentence": SentenceDialect,
}
"""By the name of the driver that they are for. The standard's own pilot needs none."""


def _acknowledgement(command: NmeaCommandGroupFunction, to: int) -> Outgoing:
    """That a command was understood, as an EV-1 says it."""
    count = len(command.parameters)
    answer = NmeaAcknowledgeGroupFunction(
        pgn=command.pgn,
        pgn_error_code=PgnErrorCode.ACKNOWLEDGE,
        transmission_interval_priority_error_code=TransmissionIntervalError.ACKNOWLEDGE,
        number_of_parameters=count,
        parameters=(ParameterError.ACKNOWLEDGE,) * count,
    )
    return outgoing(answer, to)
