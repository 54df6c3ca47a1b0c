"""`ydraw+tcp://192.168.4.1:1457`: a bus behind a gateway that writes it as lines of text.

Any form of `timonel.nmea2000.text` over any link that carries bytes. Forms that carry whole messages are taken apart
into frames here, so that everything behind hears frames, and what we send is put together again before it is written.
A gateway of the form `ydraw` says what it put on the bus itself: what of that was ours does not come back, what was
another client's is heard. Nothing waits longer than half a second to be sent.
"""

import time
from collections import deque
from collections.abc import Sequence

import msgspec

from timonel.core.effects import Say
from timonel.core.frame import Frame
from timonel.links.framed import FramedBus
from timonel.links.link import ByteLink, Counters
from timonel.nmea2000.text import FORMS, FormName, TextReader, TextWriter

ECHO_WITHIN = 5.0  # s after which a frame of ours is not an echo any more
ECHOES_MAX = 512


class TextBus(FramedBus):
    """Frames over `port`, in lines of `form`."""

    def __init__(self, port: ByteLink, form: FormName) -> None:
        super().__init__(port)
        self.form = form
        self._form = FORMS[form]
        self._reader = TextReader(self._form)
        self._writer = TextWriter(self._form)
        self._echoes: deque[tuple[float, Frame]] = deque(maxlen=ECHOES_MAX)
        self._rejected = 0

    @property
    def counters(self) -> Counters:
        """Those of the port, with frames, and with the lines that were not understood."""
        tally = super().counters
        return msgspec.structs.replace(tally, rejected=tally.rejected + self._rejected + self._reader.rejected)

    def send(self, frames: Sequence[Frame]) -> None:
        """Write `frames`; what the form cannot say is dropped and counted."""
        now = self._loop.time()
        lines = []
        for identifier, data in self._writer.payloads(frames, now):
            line = self._form.command(identifier, data, time.time())
            if line is None:
                self._dropped += 1
            else:
                lines.append(Say(line, "", urgent=True))
        self._frames_out += len(frames)
        if self._form.marks:
            self._echoes.extend((now, frame) for frame in frames)
        if lines:
            self._port.send(lines)

    def _hear(self, data: bytes) -> None:
        frames = [
            frame
            for heard in self._reader.receive(data)
            for frame in self._reader.frames(heard)
            if not (heard.sent and self._is_echo(frame))
        ]
        self._hand_over(frames)

    def _is_echo(self, frame: Frame) -> bool:
        """Whether a frame that the gateway sent is one that we gave it; each counts once.

        Gateways may put their own address in place of ours.
        """
        oldest = self._loop.time() - ECHO_WITHIN
        while self._echoes and self._echoes[0][0] < oldest:
            self._echoes.popleft()
        for place, (_, sent) in enumerate(self._echoes):
            if sent.data == frame.data and sent.identifier >> 8 == frame.identifier >> 8:
                del self._echoes[place]
                return True
        return False

    def _port_changed(self, connected: bool, reason: str) -> None:
        """What comes from now on does not belong to what came before."""
        self._rejected += self._reader.rejected
        self._reader = TextReader(self._form)
        self._echoes.clear()
        self._changed(connected, reason)


def text_bus(*, form: FormName, over: str, url: str = "", name: str = "") -> TextBus:
    """The bus that a URL of two schemes means. Raises LinkError."""
    from timonel.links.urls import commanding_link

    bus = TextBus(commanding_link(over, name=name or url), form)
    bus.url = url
    return bus
