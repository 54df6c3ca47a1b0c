"""How the log looks: text on a terminal, one JSON object a line for everything else."""

import logging
import select
import sys
from datetime import UTC, datetime
from typing import TextIO

import msgspec


class TextFormatter(logging.Formatter):
    """`12:00:01 WARNING Bridge: not connected`, in the computer's own time."""

    def __init__(self) -> None:
        super().__init__("%(asctime)s %(levelname)-8s %(message)s", "%H:%M:%S")


class JsonFormatter(logging.Formatter):
    """`{"time": ..., "level": ..., "text": ...}` and what the record has in `fields`."""

    def format(self, record: logging.LogRecord) -> str:
        line = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "text": record.getMessage(),
            **getattr(record, "fields", {}),
        }
        if record.exc_info:
            line["traceback"] = self.formatException(record.exc_info)
        return msgspec.json.encode(line, enc_hook=str).decode()


class Handler(logging.StreamHandler[TextIO]):
    """Writes what there is room for and counts the rest: a log that nobody reads must not stop the boat."""

    def __init__(self, stream: TextIO) -> None:
        super().__init__(stream)
        self.dropped = 0

    def emit(self, record: logging.LogRecord) -> None:
        if not _has_room(self.stream):
            self.dropped += 1
            return
        if self.dropped:
            text = f"{self.dropped} lines of the log were dropped: nobody read them"
            super().emit(logging.makeLogRecord({"msg": text, "levelno": logging.WARNING, "levelname": "WARNING"}))
            self.dropped = 0
        super().emit(record)


def _has_room(stream: TextIO) -> bool:
    """Whether a line can be written without waiting: a pipe with room has 4 KiB of it (pipe(7))."""
    try:
        descriptor = stream.fileno()
    except OSError:  # in memory
        return True
    poll = select.poll()
    poll.register(descriptor, select.POLLOUT)
    return poll.poll(0) == [(descriptor, select.POLLOUT)]


def start(level: str, stream: TextIO = sys.stderr) -> None:
    """Log everything from `level` on to `stream`."""
    handler = Handler(stream)
    handler.setFormatter(TextFormatter() if stream.isatty() else JsonFormatter())
    logging.basicConfig(level=level.upper(), handlers=[handler], force=True)
