"""What a station knows of the far end from the sentences that it hears: a pure machine, told the time.

```
sentence       what it changes
STATUS         the status, its age and the commander
CMDTRANSFER    the commander; nobody is announced any more (the next one is announced anew)
CMDREQUEST     who is announced, and until when the commander may answer
anything else  nothing: other sentences are not ours, and bad ones are counted by cause in `rejected`
```
A denial has no sentence. An announced request is therefore forgotten a second after its deadline, when command
would have passed if it had not been denied.
"""

from collections import Counter

import msgspec

from timonel.nmea0183 import parp
from timonel.nmea0183.checksum import Fault
from timonel.nmea0183.framing import SentenceFramer
from timonel.nmea0183.parp import CommandRequested, CommandTransferred, PilotMode

STALE = 3.0
"""Seconds without STATUS after which the last one says nothing about now; it comes at 2 Hz."""
OVERDUE = 1.0
"""Seconds after a deadline by which its consequence must have been heard."""


class StationStatus(msgspec.Struct, frozen=True):
    """What the last STATUS said; None is a value that is not known.

    `mode` is None before the first STATUS and for a word that is not in the protocol, which then stands in
    `mode_text`. `commander` 0 is nobody. The rudder is positive to starboard. `age` is in seconds.
    """

    mode: PilotMode | None = None
    mode_text: str = ""
    setpoint_deg: float | None = None
    heading_deg: float | None = None
    rudder_deg: float | None = None
    commander: int | None = None
    age: float | None = None

    @property
    def stale(self) -> bool:
        """Whether it is too old to steer by."""
        return self.age is None or self.age >= STALE


class Request(msgspec.Struct, frozen=True):
    """The announced request of `station`: the commander has `seconds_left` to answer."""

    station: int
    seconds_left: float


class StatusChanged(msgspec.Struct, frozen=True):
    """A STATUS said something that the one before did not."""

    status: StationStatus


class Lost(msgspec.Struct, frozen=True):
    """A wire broke, or no STATUS came for 3 s: nothing is known, nothing can be commanded."""

    reason: str


class Back(msgspec.Struct, frozen=True):
    """The wires are whole and STATUS comes again."""


StationEvent = StatusChanged | CommandTransferred | CommandRequested | Lost | Back


class Lookout:
    """Hears what the far end says. `request_seconds` is how long a commander there may take to answer."""

    def __init__(self, request_seconds: float = 10.0) -> None:
        self.request_seconds = request_seconds
        self.commander: int | None = None
        self.rejected: Counter[str] = Counter()
        self._framer = SentenceFramer()
        self._status: parp.Status | None = None
        self._heard: float | None = None
        self._announced: tuple[int, float] | None = None

    def receive(self, data: bytes) -> list[parp.Report]:
        """The reports that `data` completes; they count when they are told to `hear`, in order."""
        reports = [self._read(line) for line in self._framer.receive(data) if line.startswith(b"$PARP,")]
        return [report for report in reports if report is not None]

    def _read(self, line: bytes) -> parp.Report | None:
        report = parp.read_report(line)
        if isinstance(report, Fault):
            self.rejected[report.value] += 1
            return None
        return report

    def hear(self, report: parp.Report, now: float) -> list[StationEvent]:
        """Take one report to heart; what is new in it."""
        match report:
            case parp.Status():
                return self._hear_status(report, now)
            case CommandTransferred():
                self.commander = report.commander
                self._announced = None
                return [report]
            case CommandRequested():
                self._announced = (report.station, now + self.request_seconds)
                return [report]

    def _hear_status(self, status: parp.Status, now: float) -> list[StationEvent]:
        news = status != self._status
        self._status, self._heard, self.commander = status, now, status.commander
        return [StatusChanged(self.status(now))] if news else []

    def announced(self, station: int) -> float | None:
        """When the request of `station` was announced; None if it is not the one that is."""
        if self._announced is None or self._announced[0] != station:
            return None
        return self._announced[1] - self.request_seconds

    def answered(self) -> None:
        """The announced request has had its answer."""
        self._announced = None

    @property
    def last(self) -> parp.Status | None:
        """The last STATUS as it was; None before the first."""
        return self._status

    def status(self, now: float) -> StationStatus:
        if self._status is None or self._heard is None:
            return StationStatus()
        status = StationStatus(**msgspec.structs.asdict(self._status), age=now - self._heard)
        return msgspec.structs.replace(status, commander=self.commander)

    def requests(self, now: float) -> tuple[Request, ...]:
        """The announced request, as far as it is known; who waits behind it the wire does not tell."""
        if self._announced is None or now >= self._announced[1] + OVERDUE:
            return ()
        station, deadline = self._announced
        return (Request(station, max(0.0, deadline - now)),)
