"""The flight recorder: writes down what the machine is told and what it answers, in order.

```
told                       topic of the step that begins      answered      topic, in the same step
frames of the bus          bus                                Say           out/all, all lines together
bytes of a port            in/<station>                       Transmit      bus, flagged as sent
a port came or went        ports                              all else      events, with all its fields
time passed                timer
```
Nothing here waits for the disk: records are put together on the loop, and a thread writes them once a second. Where
the disk does not take them they are lost, which is an alert, counted, and noted in the recording when it goes on.
"""

import asyncio
import platform
import re
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any
from uuid import uuid4

import msgspec

from timonel import __version__
from timonel.core.alerts import AlertKind, Alerts, Priority
from timonel.core.effects import Effect, Event, Say, Transmit
from timonel.core.frame import Frame
from timonel.gateway import machine
from timonel.gateway.configuration import Configuration
from timonel.gateway.gateway import Gateway
from timonel.gateway.interpreter import Interpreter, interpreter
from timonel.gateway.moment import A_SECOND, microseconds
from timonel.recording.flight import EVENTS, IN, OUT, PORTS, RECORDER, TIMER, Metadata
from timonel.recording.flight_bus import SENT
from timonel.recording.flight_tape import Page, Tape, text
from timonel.recording.flight_writer import FlightWriter, Limits, Written

FORMAT = "2"
READABLE = ("1", FORMAT)
"""1 had the frames of the bus in rows."""
FLUSH = 1.0  # s
CLOCK_STEP = 50_000_000  # ns: a wall clock that goes astray by more within a second was set
CLOSE_WITHIN = 2.0  # s
NOT_RECORDING = AlertKind(301, "recording", Priority.WARNING)
SECRET = re.compile(r"\b(token)[\"']?\s*=.*")
IN_URL = re.compile(r"(://[^\s/@\"':]*):[^\s/@\"']*@")  # a user's password
BOOT_ID = Path("/proc/sys/kernel/random/boot_id")


class Recorder:
    """Writes down the life of one machine; `put` takes the pages.

    `now` is the machine's time in s, `wall` a clock in ns since 1970.
    """

    def __init__(
        self,
        stations: Sequence[str],
        put: Callable[[Page], object],
        now: float,
        *,
        wall: Callable[[], int] = time.time_ns,
        interpreter: Interpreter | None = None,
    ) -> None:
        self._put = put
        self._wall = wall
        self._interpreter = interpreter
        self._tape = Tape(stations, wall() - microseconds(now) * 1000)
        numbers = self._tape.numbers
        self._ins = {station: numbers[IN + station] for station in stations}
        self._out, self._events, self._timer, self._ports = (numbers[name] for name in (OUT, EVENTS, TIMER, PORTS))

    # What the machine is told -------------------------------------------------------------------------

    def frames_received(self, frames: Sequence[Frame], now: float) -> None:
        """Frames came in from the bus."""
        tape = self._tape
        us = self._begin_step(now)
        tape.frames(frames, us)
        if self._interpreter is not None:
            self._interpreter.receive(frames, us, tape)

    def bytes_received(self, port: str, data: bytes, now: float) -> None:
        """Bytes came in on a station's port."""
        us = self._begin_step(now)
        self._tape.add(self._ins[port], us, text(data))

    def port_changed(self, port: str, connected: bool, now: float) -> None:
        """A port came or went."""
        us = self._begin_step(now)
        self._tape.add(self._ports, us, msgspec.json.encode({"port": port, "connected": connected}))

    def expired(self, now: float) -> None:
        """Time passed."""
        us = self._begin_step(now)
        self._tape.add(self._timer, us, b"{}")

    def _begin_step(self, now: float) -> int:
        tape = self._tape
        if tape.full:
            self._take()
        tape.step += 1
        return round(now * A_SECOND)

    # What it answers ----------------------------------------------------------------------------------

    def answered(self, effects: Sequence[Effect], now: float) -> None:
        """What the machine wants done. Runs once an answer: written for speed."""
        us = round(now * A_SECOND)
        tape = self._tape
        said, sent, events = taken_apart(effects)
        for event in events:
            tape.add(self._events, us, event_message(event))
        if said:
            tape.add(self._out, us, text(said))
        if sent:
            tape.frames(sent, us, SENT)

    # What else happens --------------------------------------------------------------------------------

    def note(self, kind: str, now: float, **fields: Any) -> None:
        """Something that is no business of the machine's."""
        message = msgspec.json.encode({"type": kind, **fields})
        self._tape.add(self._tape.numbers[RECORDER], microseconds(now), message)

    def flush(self, now: float) -> None:
        """Hand over what was recorded, and see whether somebody set the clock. `now` is the time it is."""
        self._take()
        offset = self._wall() - microseconds(now) * 1000
        step, self._tape.offset = offset - self._tape.offset, offset
        if abs(step) > CLOCK_STEP:
            self.note("ClockStep", now, seconds=step / 1e9)

    def _take(self) -> None:
        if page := self._tape.take():
            self._put(page)


def taken_apart(effects: Sequence[Effect]) -> tuple[bytes, list[Frame], list[Effect]]:
    """All that is said, the frames that are sent, and the rest. Runs once an answer: written for speed."""
    said = b""
    sent: list[Frame] = []
    events: list[Effect] = []
    for effect in effects:
        if type(effect) is Say:
            said = said + effect.line if said else effect.line
        elif type(effect) is Transmit:
            sent.append(effect.frame)
        else:
            events.append(effect)
    return said, sent, events


def event_message(event: Effect) -> bytes:
    """An event with all its fields, bytes as text of as many characters."""
    fields = {name: _plain(getattr(event, name)) for name in event.__struct_fields__}
    return msgspec.json.encode({"type": type(event).__name__, **fields})


def _plain(value: object) -> object:
    return value.decode("latin-1") if isinstance(value, bytes) else value


# The recorder of a gateway ----------------------------------------------------------------------------


class Keeper:
    """Flushes a gateway's recorder once a second, and tells people when nothing is recorded."""

    def __init__(self, gateway: Gateway, configuration: Configuration, front: Callable[[int], Metadata]) -> None:
        assert configuration.recording is not None
        recording = configuration.recording
        limits = Limits(recording.segment_size, recording.segment_age, recording.budget)
        self.writer = FlightWriter(Path(recording.directory), configuration.vehicle.name, limits, front)
        stations = [channel.name for channel in gateway.channels if channel.receive is not None]
        self.recorder = Recorder(
            stations,
            self.writer.put,
            gateway.now,
            interpreter=interpreter(configuration) if recording.decoded else None,
        )
        self._gateway = gateway
        self._alerts = Alerts()
        self._lost = 0
        self._lost_in_all = 0

    def start(self) -> None:
        self._gateway.recorder = self.recorder
        self._gateway.health.watch("recorder", partial(_counters, self.writer.written))
        self.writer.start()
        self._task = asyncio.get_running_loop().create_task(self._keep(), name="flight recorder")

    async def close(self) -> None:
        """Write what is left, for at most two seconds."""
        self._task.cancel()
        self._gateway.recorder = None
        self.recorder.flush(self._gateway.now)
        await asyncio.to_thread(self.writer.close, CLOSE_WITHIN)

    async def _keep(self) -> None:
        while True:
            await asyncio.sleep(FLUSH)
            self.look()

    def look(self) -> None:
        """Once a second."""
        now = self._gateway.now
        self.recorder.flush(now)
        lost, self._lost = self.writer.written.lost_steps - self._lost, self.writer.written.lost_steps
        self._lost_in_all += lost
        trouble = self.writer.trouble or ("the disk is too slow" if lost else None)
        if trouble is not None:
            self._tell(self._alerts.arise(NOT_RECORDING, f"nothing is recorded: {trouble}", now), now)
        elif self._alerts.active(NOT_RECORDING):
            self._alerts.acknowledge(NOT_RECORDING.id)  # no station can: it ends with its cause
            self.recorder.note("Gap", now, steps=self._lost_in_all)
            self._lost_in_all = 0
            self._tell(self._alerts.rectify(NOT_RECORDING), now)

    def _tell(self, events: list[Event], now: float) -> None:
        for event in events:
            self.recorder.note(type(event).__name__, now, **msgspec.to_builtins(event))
        self._gateway.happened(events)


def _counters(written: Written) -> dict[str, int]:
    return msgspec.structs.asdict(written)


def front(
    gateway: Gateway, configuration: Configuration, simulated: bool = False, seed: int | None = None
) -> Callable[[int], Metadata]:
    """What stands at the front of each segment, by its number. Raises ConfigError."""
    run = {
        "format": FORMAT,
        "run": uuid4().hex,
        "began_ns": str(time.time_ns()),
        "began_monotonic_ns": str(time.monotonic_ns()),
        "boot_id": _boot_id(),
        "simulated": "yes" if simulated else "no",
        "seed": "" if seed is None else str(seed),
    }
    versions = {"timonel": __version__, "python": platform.python_version(), "msgspec": msgspec.__version__}
    made_of = machine.describe(configuration, gateway.began)
    file = {"file": configuration.file, "text": without_secrets(configuration.text)}
    return lambda number: {
        "timonel.recording": run | {"segment": str(number)},
        "timonel.versions": versions,
        "timonel.machine": made_of,
        "timonel.configuration": file,
    }


def without_secrets(text: str) -> str:
    """A configuration that may be shown to anybody."""
    return IN_URL.sub(r"\1:(not recorded)@", SECRET.sub(r"\1 = (not recorded)", text))


def _boot_id() -> str:
    """Which boot of the computer this is; "" where the kernel does not tell."""
    try:
        return BOOT_ID.read_text().strip()
    except OSError:
        return ""
