"""Decoded tables kept beside a recording, so that a second question is answered at once. Needs pyarrow.

`log.candump.timonel/` has the Parquet files of `sinks.arrow`, and `cache.json`, which says of what they are. Where a
recording's directory cannot be written to, they are in the user's cache. Tables of another size or time of the
recording, or of another version of this program, are made anew; they are complete or not there.
"""

import os
import shutil
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path

import msgspec

from timonel.errors import RecordingError
from timonel.nmea2000 import catalogue
from timonel.recording.decoding import Pass
from timonel.recording.sinks.arrow import Choice, Files, write
from timonel.vehicles.rover.protocol import Protocol

LAYOUT = 2
"""Of the tables: rises when they are written otherwise."""

_NOTE = "cache.json"


class Note(msgspec.Struct, frozen=True):
    """What tables are of."""

    size: int
    modified_ns: int
    version: str


def tables(file: str, version: str, tell: Callable[[int], object] = lambda _: None) -> str:
    """The directory of a recording's tables, made by this `version` of the program, now if they are not there.

    Raises RecordingError for a recording that cannot be read, and where there is no room for the tables.
    """
    place = _place(Path(file))
    note = _note(file, version)
    if _kept(place) != note:
        _make(file, place, note, tell)
    return str(place)


def _place(file: Path) -> Path:
    beside = file.with_name(f"{file.name}.timonel")
    if os.access(beside if beside.exists() else file.parent, os.W_OK):
        return beside
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return cache / "timonel" / f"{file.name}-{sha256(os.fsencode(file.resolve())).hexdigest()[:16]}"


def _note(file: str, version: str) -> Note:
    try:
        status = os.stat(file)
    except OSError as error:
        raise RecordingError(f"{file}: {error.strerror}") from error
    return Note(status.st_size, status.st_mtime_ns, f"{version}, canboat {catalogue.VERSION}, layout {LAYOUT}")


def _kept(place: Path) -> Note | None:
    try:
        return msgspec.json.decode((place / _NOTE).read_bytes(), type=Note)
    except (OSError, msgspec.MsgspecError):
        return None


def _make(file: str, place: Path, note: Note, tell: Callable[[int], object]) -> None:
    """Into a directory of another name first: whoever finds the tables finds all of them."""
    protocol = Protocol()
    recording = Pass(file, protocol)
    new = place.with_name(f"{place.name}.{os.getpid()}")
    try:
        new.mkdir(parents=True)
        write(recording, Files(new, "parquet"), protocol, Choice(), tell)
        (new / _NOTE).write_bytes(msgspec.json.encode(note))
        shutil.rmtree(place, ignore_errors=True)
        new.rename(place)
    except OSError as error:
        raise RecordingError(f"{new}: {error.strerror}") from error
    finally:
        shutil.rmtree(new, ignore_errors=True)
