"""Digital Yacht's iKonvert: one message a line, whole, and lines about the gateway itself.

    !PDGY,129039,4,43,255,481.706,ErZcAw6BGlf/h2BIHkP//wAABgAG//8AdAH/
    PGN, priority, source, destination, seconds and milliseconds since the gateway was switched on, data in base64
    $PDGY,000000,3,,5,798,1,0

The milliseconds have no leading zeros: 482.36 comes before 482.117. Source: canboat `ikonvert.h`, `ikonvert.log`.
"""

import re
from binascii import Error, a2b_base64
from collections.abc import Sequence

from timonel.recording.lines import Kind, LogFrame, is_comment
from timonel.recording.messages import message

_LINE = re.compile(r"!PDGY,(\d+),(\d+),(\d+),(\d+),(\d{1,15})\.(\d{1,3}),([A-Za-z0-9+/]+=*)\s*")
_STATUS = re.compile(r"\$PDGY,[^!$]*")


class IKonvert:
    """Lines of iKonvert."""

    name = "iKonvert"
    kind: Kind = "frames"
    dated = False

    def __init__(self, sample: Sequence[str]) -> None:
        pass

    def read(self, line: str) -> LogFrame | None:
        """A message; None for a comment or a line about the gateway. ValueError for any other line."""
        match = _LINE.fullmatch(line)
        if match is None:
            if is_comment(line) or _STATUS.fullmatch(line):
                return None
            raise ValueError("neither a message nor a line about the gateway")
        pgn, priority, source, destination, seconds, milliseconds, data = match.groups()
        stamp = int(seconds) + int(milliseconds) / 1000
        return message(stamp, int(priority), int(pgn), int(source), int(destination), _bytes(data))


def _bytes(text: str) -> bytes:
    try:
        return a2b_base64(text, strict_mode=True)
    except Error as error:
        raise ValueError(f"base64: {error}") from error
