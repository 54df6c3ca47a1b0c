"""Where a recording was: the positions of one source, and how fast it went. Needs the extra `columns`."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from timonel.errors import RecordingError
from timonel.recording.selection import columns

if TYPE_CHECKING:
    from timonel.recording.selection import MessageColumns
    from timonel.recording.series import Values

POSITIONS = ("positionRapidUpdate", "gnssPositionData")
"""The messages with positions of one's own, the more frequent one first."""

GAP = 60.0
"""s without a position after which a track is interrupted."""

_NEAR = 2.0  # s within which a speed is that of a position
_LATITUDES, _LONGITUDES = 90.0, 180.0


class Track(msgspec.Struct, frozen=True, eq=False):
    """`time` s, `latitude` and `longitude` in degrees, `altitude` m and `speed` m/s (NaN where not known).

    NaN stands for all where the track is interrupted.
    """

    message: str
    source: int
    others: tuple[int, ...]
    dated: bool
    time: "Values"
    latitude: "Values"
    longitude: "Values"
    altitude: "Values"
    speed: "Values"


def track(path: str | Path, source: int | None = None) -> Track:
    """The track of a recording, from the `source` with most positions if none is named.

    Raises RecordingError if there are no positions, or none of the source.
    """
    for name in POSITIONS:
        found = columns(path, name)
        there = _there(found)
        sources, counts = np.unique(found.source[there], return_counts=True)
        if source is None and len(sources):
            return _of(path, found, int(sources[counts.argmax()]), sources.tolist())
        if source in sources:
            return _of(path, found, int(source or 0), sources.tolist())
    of = "" if source is None else f" of source {source}"
    raise RecordingError(f"{path} has no positions{of}")


def _there(found: "MessageColumns") -> "np.ndarray[tuple[int], np.dtype[np.bool_]]":
    if not len(found):
        return np.zeros(0, np.bool_)
    with np.errstate(invalid="ignore"):
        fine = (np.abs(found["latitude"]) <= _LATITUDES) & (np.abs(found["longitude"]) <= _LONGITUDES)
    return np.asarray(fine, np.bool_)


def _of(path: str | Path, found: "MessageColumns", source: int, sources: list[int]) -> Track:
    rows = np.flatnonzero(_there(found) & (found.source == source))
    elapsed = found.elapsed[rows]
    order = np.argsort(elapsed, kind="stable")
    rows, time = rows[order], elapsed[order]
    altitude = found["altitude"][rows] if "altitude" in found.fields else np.full(len(rows), np.nan)
    parts = (time, found["latitude"][rows], found["longitude"][rows], altitude, _speed(path, source, time))
    gaps = np.flatnonzero(np.diff(time) > GAP) + 1
    others = tuple(other for other in sources if other != source)
    return Track(found.name, source, others, found.dated, *(np.insert(part, gaps, np.nan) for part in parts))


def _speed(path: str | Path, source: int, time: "Values") -> "Values":
    """Speed over ground as the same source tells it."""
    found = columns(path, "cogSogRapidUpdate")
    if not len(found):
        return np.full(len(time), np.nan)
    rows = np.flatnonzero((found.source == source) & ~np.isnan(found["sog"]))
    told, speed = found.elapsed[rows], found["sog"][rows]
    if not len(rows):
        return np.full(len(time), np.nan)
    after = np.clip(np.searchsorted(told, time), 0, len(told) - 1)
    before = np.maximum(after - 1, 0)
    nearest = np.where(np.abs(told[before] - time) < np.abs(told[after] - time), before, after)
    return np.where(np.abs(told[nearest] - time) <= _NEAR, speed[nearest], np.nan)


def segments(found: Track) -> Iterator[slice]:
    """The pieces between its interruptions."""
    breaks = np.flatnonzero(np.isnan(found.latitude))
    start = 0
    for end in [*breaks.tolist(), len(found.latitude)]:
        if end > start:
            yield slice(start, end)
        start = end + 1
