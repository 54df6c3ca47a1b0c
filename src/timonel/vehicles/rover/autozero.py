"""The zero of the current sensors, found while no current flows: the average of what they read at rest.

Source: spec/rover.md, Raw to SI: the ACS714 idles at half of its supply, which differs from board to board.
"""

import struct

from msgspec.structs import replace

from timonel.vehicles.rover.calibration import Calibration
from timonel.vehicles.rover.frames import MotorCurrentLeft, MotorCurrentRight

READINGS = 20  # of a side, before its average counts: a second of them
_THREE = struct.Struct("<3h")


class AutoZero:
    """Averages frames 104 and 105; whoever calls `receive` knows that the drives are disabled and the wheels stand."""

    def __init__(self) -> None:
        self._sums: dict[int, tuple[int, int, int]] = {}
        self._counts: dict[int, int] = {}

    def receive(self, identifier: int, data: bytes) -> None:
        """A frame came in at rest; what is not 104 or 105 is none of ours."""
        if identifier in (MotorCurrentRight.FRAME, MotorCurrentLeft.FRAME) and len(data) == _THREE.size:
            front, middle, rear = self._sums.get(identifier, (0, 0, 0))
            one, two, three = _THREE.unpack(data)
            self._sums[identifier] = front + one, middle + two, rear + three
            self._counts[identifier] = self._counts.get(identifier, 0) + 1

    def zeroed(self, calibration: Calibration) -> Calibration:
        """The calibration with the averages as its zeros; of a side that was heard too little the zeros stay."""
        zeros = {}
        for identifier, name in (
            (MotorCurrentRight.FRAME, "current_zero_right"),
            (MotorCurrentLeft.FRAME, "current_zero_left"),
        ):
            if (count := self._counts.get(identifier, 0)) >= READINGS:
                zeros[name] = tuple(total / count for total in self._sums[identifier])
        return replace(calibration, **zeros)
