"""Raymarine's pilots: Evolution on SeaTalkNG, and older ones that a converter stands before.

what                       Evolution                                 behind a converter (`raymarine-spx`)
engage, let go             126208 command of 65379: 0x40, 0x00       key in 126720, 16 bytes: 01, 02
a course (magnetic)        126208 command of 65360                   the same, at most 30 degrees away
a control head is there    65384 every second, 126720 every 2 s      -

The bytes of the Evolution are those of its own control heads in the recordings `raymarine-ev1` and `pgn65379` of
canboat. It acknowledges with 126208, and at once tells the mode in 65379 and the course in 65360. A pilot whose
address is not known is still let go, by the key Standby to everybody.

Source of the converter's bytes: SignalK/signalk-autopilot `raystngconv.js`, and its issue 92 for a pilot that ignores
keys of course. No recording shows them.
"""

from math import radians

from timonel.nmea2000.identifier import GLOBAL
from timonel.nmea2000.lookups import ManufacturerCode, SeatalkKey, SeatalkMode
from timonel.nmea2000.messages.group_function import command
from timonel.nmea2000.messages.raymarine import (
    Seatalk1Keystroke,
    SeatalkKeepAlive,
    SeatalkPilotLockedHeading,
    SeatalkPilotMode,
)
from timonel.nmea2000.sender import Outgoing, outgoing
from timonel.vehicles.boat.pilot import Mode
from timonel.vehicles.boat.pilots.approach import difference
from timonel.vehicles.boat.pilots.driver import Answer, Evidence, Kind
from timonel.vehicles.boat.pilots.engaged import ByCourse

MAKERS = frozenset({ManufacturerCode.RAYMARINE})
CONVERTER = "SeaTalk-STNG-Converter"
"""How the converter's model is called in its product information."""
HEAD = 0x21  # the control head that a key comes from
LONGEST_JUMP = 300  # tenths: a converter's pilot that is told more at once may turn the other way round
KEY_TAIL = bytes.fromhex("ff ff ff ff ff c1 c2 cd 66 80 d3 42 b1 c8")
SHORT_TAIL = bytes.fromhex("00 00 00 00 00 00 ff ff")
KEY_SIZE, SHORT_SIZE = 22, 16  # bytes

IDENTIFICATION = Outgoing(126720, bytes.fromhex("3b 9f f0 81 90 00 03"))
"""A control head is there, as the recorded one says it: `Seatalk1DeviceIdentification` with a reserved byte of 00."""

EVOLUTION = Kind(
    name="raymarine",
    steers="Raymarine Evolution (EV-1, EV-2 with an ACU) on SeaTalkNG",
    evidence=Evidence.CAPTURED,
    sources="canboat samples raymarine-ev1, pgn65379; SignalK/signalk-autopilot",
    sends="126208 of 65379 and 65360, 65384, 126720",
    confirmed_by="65379, 65360",
    absolute=True,
    references="magnetic",
    adopts=True,
)
SPX = Kind(
    name="raymarine-spx",
    steers="Raymarine SPX, S1-S3 and ST pilots behind a SeaTalk-STNG converter",
    evidence=Evidence.REVERSE_ENGINEERED,
    sources="SignalK/signalk-autopilot raystngconv and issue 92",
    sends="126720, 126208 of 65360",
    confirmed_by="65379, 65360",
    absolute=True,
    references="magnetic",
    adopts=True,
)


def key(pressed: SeatalkKey, destination: int = GLOBAL) -> Outgoing:
    """A key of a p70 control head."""
    return outgoing(_keystroke(pressed, KEY_TAIL), destination)


def short_key(pressed: SeatalkKey, destination: int = GLOBAL) -> Outgoing:
    """A key as converters to SeaTalk 1 take it."""
    payload = _keystroke(pressed, SHORT_TAIL.ljust(len(KEY_TAIL), b"\0")).encode()[:SHORT_SIZE]
    return Outgoing(Seatalk1Keystroke.PGN or 0, payload, destination)


def _keystroke(pressed: SeatalkKey, tail: bytes) -> Seatalk1Keystroke:
    return Seatalk1Keystroke(device=HEAD, key=pressed, keyinverted=0xFF ^ pressed, unknown_data=tail)


class RaymarinePilot(ByCourse):
    """An Evolution."""

    keep_alive = (1.0, 2.0)

    def engage(self) -> list[Answer]:
        """See `EngagedPilot`."""
        address = self.finder.address
        return [] if address is None else [self._mode_command(SeatalkMode.AUTO, address)]

    def release(self) -> list[Answer]:
        """See `EngagedPilot`."""
        address = self.finder.address
        if address is None:
            return [key(SeatalkKey.STANDBY)]
        return [self._mode_command(SeatalkMode.STANDBY, address)]

    def set_course(self, target: int) -> list[Answer]:
        """See `ByCourse`."""
        address = self.finder.address
        if address is None:
            return []
        course = radians(target / 10)
        return [outgoing(command(SeatalkPilotLockedHeading, target_heading_magnetic=course), address)]

    def show(self, which: int) -> list[Answer]:
        """See `EngagedPilot`."""
        if which == 0:
            return [outgoing(SeatalkKeepAlive(unknown=bytes(6)))]
        return [IDENTIFICATION]

    def _mode_command(self, mode: SeatalkMode, address: int) -> Outgoing:
        return outgoing(command(SeatalkPilotMode, pilot_mode=mode, sub_mode=0xFFFF), address)


class ConvertedPilot(ByCourse):
    """A SeaTalk 1 pilot behind a converter."""

    def objection(self, setpoint: int, now: float) -> str | None:
        """See `Driver`. A course far from the one that is held is refused."""
        if (reason := super().objection(setpoint, now)) is not None:
            return reason
        target, course = self.theirs(setpoint, now), self._course
        if self._mode is not Mode.HEADING_HOLD or target is None:
            return None
        if course is None:
            return "the pilot does not tell its course"
        return None if abs(difference(target, course)) <= LONGEST_JUMP else "more than 30 degrees at once"

    def engage(self) -> list[Answer]:
        """See `EngagedPilot`."""
        address = self.finder.address
        return [] if address is None else [short_key(SeatalkKey.AUTO, address)]

    def release(self) -> list[Answer]:
        """See `EngagedPilot`."""
        address = self.finder.address
        return [short_key(SeatalkKey.STANDBY, GLOBAL if address is None else address)]

    def set_course(self, target: int) -> list[Answer]:
        """See `ByCourse`."""
        address = self.finder.address
        if address is None:
            return []
        course = radians(target / 10)
        return [outgoing(command(SeatalkPilotLockedHeading, target_heading_magnetic=course), address)]
