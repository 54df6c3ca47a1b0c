"""Recordings of a bus or a wire, read in the format that their content shows."""

from timonel.recording.formats import LogReader, Reader, open_any, open_log
from timonel.recording.lines import Kind, LogFrame, LogSentence, Record, Unreadable

__all__ = ["Kind", "LogFrame", "LogReader", "LogSentence", "Reader", "Record", "Unreadable", "open_any", "open_log"]
