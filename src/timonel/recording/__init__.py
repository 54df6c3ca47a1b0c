"""Recordings of a bus, read in the format that their content shows."""

from timonel.recording.formats import LogReader, Unreadable, open_log
from timonel.recording.lines import LogFrame

__all__ = ["LogFrame", "LogReader", "Unreadable", "open_log"]
