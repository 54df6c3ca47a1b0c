"""Listeners of raw NMEA 2000: every frame of the bus and of ours as lines of text, and what they may send back.

```
frame                                   written as
of the bus                              received (`R` where the form has marks), to every listener
of ours                                 sent (`T`), to every listener
of a listener that may transmit         on the bus, heard by us, and sent (`T`) to every listener, also to who sent it;
                                        where the form has no marks, to every listener but that one, so that it does
                                        not take it for another's
```
A listener may transmit if its output says so, at most `frames_per_second` frames, and none from our own address but a
claim of it. Whoever may can say on the bus whatever a device can, to the pilot too: that is why it is off by default.

Nor may it speak for a device that was heard on the bus itself in the last `ON_THE_BUS` seconds, but for a claim of that
address: two gateways on one backbone, each a listener of the other, would send every frame round and round.

A slow listener has its last `WAITING` lines waiting, the older ones are dropped and counted.
"""

import time
from collections import Counter
from collections.abc import Callable, Sequence

import msgspec

from timonel.core.effects import Effect, Say, Transmit
from timonel.core.frame import Frame
from timonel.core.pace import Allowance
from timonel.gateway.gateway import Gateway
from timonel.links.link import ByteLink
from timonel.links.tcp_listen import TcpListenLink
from timonel.nmea2000.claim import CLAIM
from timonel.nmea2000.identifier import NULL, split
from timonel.nmea2000.text import FORMS, FormName, Heard, TextReader, TextWriter

ON_THE_BUS = 5.0  # s
WAITING = 2048  # lines: a second of a full bus


class FrameOutput(msgspec.Struct, frozen=True):
    """A link on which frames are told in `form`, and perhaps taken."""

    link: ByteLink
    form: FormName
    transmit: bool
    frames_per_second: int


class FrameOutputs:
    """All such listeners: an observer of the gateway, written for speed. `address` is our own on the bus now."""

    def __init__(self, gateway: Gateway, outputs: Sequence[FrameOutput], address: Callable[[], int]) -> None:
        self._gateway = gateway
        self._address = address
        self._speaker: ByteLink | None = None
        self._heard: dict[int, float] = {}  # when each address was last heard on the bus itself
        self._voices: dict[str, Voice] = {}
        self._links: dict[FormName, list[ByteLink]] = {}
        for output in outputs:
            self._links.setdefault(output.form, []).append(output.link)
            self._attach(output)
        self._writers = {form: TextWriter(FORMS[form]) for form in self._links}
        gateway.observers.append(self)

    def _attach(self, output: FrameOutput) -> None:
        if isinstance(output.link, TcpListenLink):
            output.link.urgent_max = WAITING
        if output.transmit:
            voice = self._voices[output.link.name] = Voice(self, output, self._address)
            self._gateway.attach(output.link, voice.receive)
            self._gateway.health.watch(f"{output.link.name} frames", lambda: voice.counters)
        else:
            self._gateway.attach(output.link, _unheard)

    @property
    def now(self) -> float:
        """The gateway's time, s."""
        return self._gateway.now

    def transmit(self, link: ByteLink, frames: list[Frame]) -> None:
        """A listener sent `frames`: they go on the bus, and everybody hears them."""
        self._speaker = link
        try:
            self._gateway.inject(link.name, frames)
        finally:
            self._speaker = None

    # As an observer -------------------------------------------------------------------------------

    def frames_received(self, frames: Sequence[Frame], now: float) -> None:
        if self._speaker is None:
            for frame in frames:
                self._heard[frame.identifier & 0xFF] = now
        self._tell(frames, now, sent=self._speaker is not None)

    def on_the_bus(self, address: int) -> bool:
        """Whether a device with this address was heard there lately."""
        return self.now - self._heard.get(address, -ON_THE_BUS) < ON_THE_BUS

    def effect(self, effect: Effect, now: float) -> None:
        if type(effect) is Transmit:
            speaker, self._speaker = self._speaker, None  # an answer is ours, whoever asked
            self._tell((effect.frame,), now, sent=True)
            self._speaker = speaker

    def port(self, name: str, connected: bool, now: float) -> None:
        """What a peer began to say before it left is worth nothing."""
        if (voice := self._voices.get(name)) is not None and not connected:
            voice.reset()

    def _tell(self, frames: Sequence[Frame], now: float, sent: bool) -> None:
        moment = time.time()
        for name, links in self._links.items():
            report = FORMS[name].report
            payloads = self._writers[name].payloads(frames, now)
            lines = [
                Say(line, "", urgent=True)
                for identifier, data in payloads
                if (line := report(identifier, data, moment, sent)) is not None
            ]
            if lines:
                self._write(lines, links, FORMS[name].marks)

    def _write(self, lines: Sequence[Say], links: Sequence[ByteLink], marks: bool) -> None:
        for link in links:
            if marks or link is not self._speaker:
                link.send(lines)
            elif isinstance(link, TcpListenLink):
                link.send_others(lines)


class Voice:
    """What the clients of one output may put on the bus."""

    def __init__(self, outputs: FrameOutputs, output: FrameOutput, address: Callable[[], int]) -> None:
        self.counters: Counter[str] = Counter()
        self._outputs = outputs
        self._link = output.link
        self._address = address
        self._form = FORMS[output.form]
        self._reader = TextReader(self._form)
        self._allowance = Allowance(output.frames_per_second)

    def receive(self, data: bytes) -> None:
        """Bytes of the clients, whole lines of each."""
        now = self._outputs.now
        frames: list[Frame] = []
        rejected = self._reader.rejected
        for heard in self._reader.receive(data):
            frames += self._allowed(heard, now)
        self.counters["lines not understood"] += self._reader.rejected - rejected
        if frames:
            self.counters["transmitted"] += len(frames)
            self._outputs.transmit(self._link, frames)

    def reset(self) -> None:
        """Begin anew with what comes next."""
        self._reader = TextReader(self._form)

    def _allowed(self, heard: Heard, now: float) -> list[Frame]:
        """The frames of a line that may go on the bus: all of them, or none."""
        if heard.sent or not heard.extended:
            self.counters["not to be sent"] += 1
            return []
        source, contends = heard.identifier & 0xFF, split(heard.identifier).pgn == CLAIM
        if source == self._address() and source != NULL and not contends:
            self.counters["from our own address"] += 1
            return []
        if self._outputs.on_the_bus(source) and source != NULL and not contends:
            self.counters["from the address of a device of the bus"] += 1
            return []
        frames = self._reader.frames(heard)
        if not all(self._allowance.take(now) for _ in frames):
            self.counters["beyond the allowance"] += len(frames)
            return []
        return frames


def _unheard(_: bytes) -> None:
    """What a listener says that may not transmit."""
