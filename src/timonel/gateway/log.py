"""How the log looks: text on a terminal, one JSON object a line for everything else."""

import logging
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


def start(level: str, stream: TextIO = sys.stderr) -> None:
    """Log everything from `level` on to `stream`."""
    handler = logging.StreamHandler(stream)
    handler.setFormatter(TextFormatter() if stream.isatty() else JsonFormatter())
    logging.basicConfig(level=level.upper(), handlers=[handler], force=True)
