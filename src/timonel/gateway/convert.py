"""A recording through the vehicle's machine, on the recording's own time: the same input gives the same bytes."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence

import msgspec

from timonel.core.effects import Effect, Rejected, Say
from timonel.recording import LogFrame
from timonel.vehicles.vehicle import Vehicle

NOMINAL_INTERVAL = 0.001  # s between frames of a recording without times
JUMP = 60.0  # s: stamps that go back further are another recording, not disorder
LONGEST_PAUSE = 3600.0  # s that are played of a longer pause; STATUS goes on at 2 Hz all the while


class RecordedTime(msgspec.Struct):
    """Makes machine time, which starts at 0 and never goes back, from a recording's stamps.

    A stamp a little before the last one counts as the last; from one that goes back by more than a minute, time
    goes on from there. Of a pause, an hour passes at most. Each is counted.
    """

    now: float = 0.0
    missing: int = 0
    backward: int = 0
    shortened: int = 0
    origin: float | None = None

    def receive(self, stamp: float | None) -> float:
        """Machine time in s of a frame with this stamp (unix s), or None for a frame without."""
        if stamp is None:
            self.missing += 1
            self.now += NOMINAL_INTERVAL
            return self.now
        if self.origin is None:
            self.origin = stamp - self.now
        time = stamp - self.origin
        if time < self.now or time > self.now + LONGEST_PAUSE:
            time = self._irregular(stamp, time)
        self.now = time
        return time

    def _irregular(self, stamp: float, time: float) -> float:
        if time > self.now:
            self.shortened += 1
            time = self.now + LONGEST_PAUSE
        else:
            self.backward += 1
            if time > self.now - JUMP:
                return self.now
            time = self.now
        self.origin = stamp - time
        return time


class Conversion:
    """One vehicle that listens to a recording; `write` takes each line it says."""

    def __init__(self, vehicle: Vehicle, write: Callable[[bytes], object]) -> None:
        self.time = RecordedTime()
        self.frames = 0
        self.messages = 0
        """Whole messages that the recording already had put together."""
        self.sentences: Counter[str] = Counter()
        self.rejected: Counter[str] = Counter()
        self._vehicle = vehicle
        self._write = write

    def receive(self, recorded: Iterable[LogFrame]) -> None:
        """Play `recorded` in order; timers of the vehicle go off between frames when they are due."""
        vehicle = self._vehicle
        for entry in recorded:
            before = self.time.now
            now = self.time.receive(entry.stamp)
            while (due := vehicle.deadline) <= now:
                self._carry_out(vehicle.expire(max(due, before)))
            if entry.whole:
                self.messages += 1
                effects = vehicle.receive_message(entry.identifier, entry.data, now)
            else:
                self.frames += 1
                effects = vehicle.receive_frames((entry.frame,), now)
            if effects:
                self._carry_out(effects)

    def _carry_out(self, effects: Sequence[Effect]) -> None:
        for effect in effects:
            if type(effect) is Say:
                self._write(effect.line)
                self.sentences[effect.line[1 : effect.line.index(b",")].decode()] += 1
            elif type(effect) is Rejected:
                self.rejected[effect.reason] += 1
