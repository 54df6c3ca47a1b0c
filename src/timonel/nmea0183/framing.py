"""Sentences out of a stream of bytes.

```
input                               effect
CR or LF                            ends a line; empty lines are nothing
$ or !                              begins a sentence; a later one in the same line begins it anew
TAG block `\\...\\` before it         dropped (IEC 61162-450 sources may send one; a broken one is garbage)
any other byte outside a sentence   dropped, counted in `garbage_bytes`
control or 8-bit byte inside        sentence dropped, counted in `unprintable`
longer than `longest`               sentence dropped, counted in `overlong`
```
What comes out, and what is counted, does not depend on how the stream was cut into pieces. At most
`longest` + 1 bytes are kept between calls.
"""

from timonel.nmea0183.tag_block import is_sound

_PRINTABLE = bytes(range(0x20, 0x7F))
_LINE = _PRINTABLE + b"\r\n"
_INNER = _PRINTABLE.translate(None, b"$!")


class SentenceFramer:
    """Cuts a stream into raw sentences, without their line ends; check sums are not looked at.

    `longest` counts from the start character to the last one before CR or LF. The standard writes at most
    80 there; real streams have more.
    """

    __slots__ = ("_rest", "garbage_bytes", "longest", "overlong", "unprintable")

    def __init__(self, longest: int = 256) -> None:
        self.longest = longest
        self.overlong = 0
        self.garbage_bytes = 0
        self.unprintable = 0
        self._rest = b""

    def receive(self, data: bytes) -> list[bytes]:
        """The sentences that `data` completes, in order. Written for speed: runs once a read."""
        line = data[:-2]
        if (
            data.endswith(b"\r\n")
            and line.translate(None, _INNER) == b"$"
            and line.startswith(b"$")
            and not self._rest
            and len(line) <= self.longest
        ):
            return [line]  # one sentence and nothing else, as a head says its commands
        data = self._rest + data
        clean = not data.translate(None, _LINE)
        lines = data.replace(b"\r", b"\n").split(b"\n")
        self._rest = self._bounded(lines.pop())
        sentences = []
        for line in lines:
            if not line:
                continue
            start = line.rfind(b"$")
            if start or b"!" in line:
                line = self._from_start(line, max(start, line.rfind(b"!")))
            if not line:
                continue
            if len(line) > self.longest:
                self.overlong += 1
            elif clean or not line.translate(None, _PRINTABLE):
                sentences.append(line)
            else:
                self.unprintable += 1
        return sentences

    def _from_start(self, line: bytes, start: int) -> bytes:
        """`line` from its last start character on; empty if it has none."""
        before = line if start < 0 else line[:start]
        if start < 0 or not is_sound(before):
            self.garbage_bytes += len(before)
        return b"" if start < 0 else line[start:]

    def _bounded(self, rest: bytes) -> bytes:
        """What must be kept of an unfinished line; one byte too many is enough to know it is overlong."""
        if len(rest) <= self.longest:
            return rest
        start = max(rest.rfind(b"$"), rest.rfind(b"!"))
        return self._from_start(rest, start)[: self.longest + 1]
