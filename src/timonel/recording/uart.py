"""The rover's serial line, its bytes as they came: frames of any of the framings, which is told from the content.

The frames are those that are declared, of both directions; an id whose frame has another length than declared is
noise. Bytes have no time. Source: `vehicles.rover.framing`.
"""

from timonel.recording.blocks import Results
from timonel.recording.lines import Kind, LogFrame
from timonel.recording.strays import unreadable_bytes
from timonel.vehicles.rover.frames import FRAMES
from timonel.vehicles.rover.framing import DIALECTS, Framer

_LENGTHS = {frame.FRAME: frame.size for frame in FRAMES}
_NOW = 0.0  # no time passes, so nothing is taken for silence before the end


class Uart:
    """A stream of one framing."""

    kind: Kind = "uart"
    dated = False

    @staticmethod
    def recognises(head: bytes) -> bool:
        """Whether one of the framings finds more bytes in frames than out of them."""
        return 2 * max(_framed(head, dialect) for dialect in DIALECTS.values()) > len(head)

    def __init__(self, head: bytes) -> None:
        dialect = max(DIALECTS, key=lambda name: _framed(head, DIALECTS[name]))
        self.name = f"UART {dialect}"
        self._framer = DIALECTS[dialect](_LENGTHS)
        self._at = 0

    def receive(self, data: bytes) -> Results:
        skipped = self._framer.counters.skipped
        yield from _frames(self._framer.receive(data, _NOW))
        yield from self._skipped(skipped, data)
        self._at += len(data)

    def finish(self) -> Results:
        skipped = self._framer.counters.skipped
        yield from _frames(self._framer.finish())
        yield from self._skipped(skipped, b"")

    def _skipped(self, before: int, data: bytes) -> Results:
        if count := self._framer.counters.skipped - before:
            yield unreadable_bytes(self._at, data, f"{count} bytes in no frame, from about here on")


def _frames(found: list[tuple[int, bytes]]) -> Results:
    return (LogFrame(None, number, data, extended=False) for number, data in found)


def _framed(head: bytes, dialect: type[Framer]) -> int:
    framer = dialect(_LENGTHS)
    framer.receive(head, _NOW)
    framer.finish()
    return len(head) - framer.counters.skipped if framer.counters.frames else 0
