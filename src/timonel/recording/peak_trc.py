"""PEAK-System's TRC, which PCAN-View and PCAN-Explorer write, versions 1.0 to 2.1.

    ;$FILEVERSION=1.1
    ;$STARTTIME=43008.920986006946
         1)      1059.9  Rx     18EBFF00  8  01 A0 0F A6 60 3B D1 40

    ;$FILEVERSION=2.1
    ;$COLUMNS=N,O,T,B,I,d,R,L,D
          1      1059.900 DT  1 18EBFF00 Rx -  8    01 A0 0F A6 60 3B D1 40
    number, milliseconds since the start, direction, identifier (of 29 bits if longer than 4 digits), length, data

STARTTIME is in days since 1899-12-30; without it times count from 1970-01-01. Source: PEAK_CAN_TRC_File_Format;
python-can `trc.py`, whose reader is not used because it passes over what it cannot read.
"""

import re
from collections.abc import Sequence

from timonel.recording.lines import Kind, LogFrame, is_comment, moment

_COLUMNS = {"1.0": "N,O,I,L,D", "1.1": "N,O,d,I,L,D", "1.2": "N,O,B,d,I,L,D", "1.3": "N,O,B,d,I,R,L,D"}
_REQUIRED = {"N", "O", "I", "D"}
_NUMBER = re.compile(r"\d+\)?")
_OFFSET = re.compile(r"\d+(?:\.\d+)?")
_IDENTIFIER = re.compile(r"[0-9A-F]{3,8}", re.IGNORECASE)
_BYTES = re.compile(r"(?:[0-9A-F]{2}(?:\s+|$))*", re.IGNORECASE)
_DIRECTIONS = ("Rx", "Tx")
_EPOCH = 25569  # days from 1899-12-30 to 1970-01-01
_A_DAY = 86400.0
_FD = ("FD", "FB", "FE", "BI")
_BUS_STATE = "FFFFFFFF"  # the identifier of what is no frame, in version 1.0


class PeakTrc:
    """Lines of TRC."""

    name = "PEAK TRC"
    kind: Kind = "frames"

    def __init__(self, sample: Sequence[str]) -> None:
        self._columns = _COLUMNS["1.0"].split(",")
        self._began = 0.0
        self.dated = any(line.startswith(";$STARTTIME=") for line in sample)

    def read(self, line: str) -> LogFrame | None:
        """A frame; None for a heading, a remote request or another event. ValueError for any other line."""
        if line[:1] == ";":
            self._heading(line)
            return None
        if is_comment(line):
            return None
        fields = dict(zip(self._columns, line.split(None, len(self._columns) - 1), strict=False))
        if not _NUMBER.fullmatch(fields.get("N", "")):
            raise ValueError("neither a heading nor a frame")
        return self._frame(fields) if _is_data(fields) else None

    def _frame(self, fields: dict[str, str]) -> LogFrame | None:
        identifier, offset, text = fields.get("I", ""), fields.get("O", ""), fields.get("D", "")
        if text.startswith("RTR"):
            return None
        if not (_IDENTIFIER.fullmatch(identifier) and _OFFSET.fullmatch(offset) and _BYTES.fullmatch(text)):
            raise ValueError("not a classic CAN frame")
        length = fields.get("L") or fields.get("l")
        payload, number, extended = bytes.fromhex(text), int(identifier, 16), len(identifier) > 4
        if len(payload) > 8 or str(len(payload)) != length:
            raise ValueError(f"{length} bytes announced, {len(payload)} found")
        if number >> (29 if extended else 11):
            raise ValueError("an identifier has 11 bits in four digits, 29 in more")
        return LogFrame(moment(self._began + float(offset) / 1000), number, payload, extended)

    def _heading(self, line: str) -> None:
        key, _, value = line.partition("=")
        match key:
            case ";$FILEVERSION":
                self._columns = _COLUMNS.get(value.strip(), _COLUMNS["1.0"]).split(",")
            case ";$COLUMNS":
                columns = value.strip().split(",")
                if not _REQUIRED.issubset(columns):
                    raise ValueError("columns without a number, a time, an identifier or data")
                self._columns = columns
            case ";$STARTTIME":
                self._began = moment((float(value) - _EPOCH) * _A_DAY)


def _is_data(fields: dict[str, str]) -> bool:
    """Whether a line is of a frame with data, and not of another event."""
    event = fields.get("T", "DT")
    if event in _FD:
        raise ValueError("not a classic CAN frame")
    return event == "DT" and fields.get("d", "Rx") in _DIRECTIONS and fields.get("I") != _BUS_STATE
