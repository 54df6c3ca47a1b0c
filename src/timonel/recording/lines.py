"""What the readers of every log format share: the frame they give, and the times they read."""

from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Protocol

import msgspec

from timonel.core.frame import Frame


class LogFrame(msgspec.Struct, frozen=True, gc=False):
    """One line of a recording: a frame, or a message that its recorder had already put together (`whole`).

    `stamp` is in unix seconds, None if the line has none. `data` of a whole message may be longer than eight
    bytes and must not go through fast-packet reassembly; a message of a single-frame PGN is not marked.
    """

    stamp: float | None
    identifier: int
    data: bytes
    extended: bool = True
    whole: bool = False

    @property
    def frame(self) -> Frame:
        """The CAN frame; only for what is not `whole`."""
        return Frame(self.identifier, self.data, self.extended)


class LineFormat(Protocol):
    """How the lines of one format are read; the first lines settle what a single one leaves open."""

    name: str

    def __init__(self, sample: Sequence[str]) -> None: ...

    def read(self, line: str) -> LogFrame | None:
        """The frame of a line, None if it has none (a comment); ValueError if it is no such line."""


class DateTime:
    """Reads ISO 8601 dates with times, also with a space or a dash between, and without a zone (UTC)."""

    def __init__(self) -> None:
        self._text = ""
        self._second = 0.0

    # Once a line, and most lines are of the same second as the one before.
    def read(self, text: str) -> float:
        """Unix seconds; ValueError for anything else."""
        fraction = text[19:].removesuffix("Z")
        if fraction and not (fraction[0] == "." and fraction[1:].isdigit()):
            return _utc(text)
        if text[:19] != self._text:
            self._second = _utc(text[:19])
            self._text = text[:19]
        return self._second + float(fraction) if fraction else self._second


def _utc(text: str) -> float:
    moment = datetime.fromisoformat(text)
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def is_comment(line: str) -> bool:
    return not line or line[0] == "#" or line.isspace()
