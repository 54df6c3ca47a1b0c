"""`timonel track`: where a recording was, as a page that needs nothing else, or as GPX."""

import os
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import click
import numpy as np

from timonel import __version__
from timonel.cli.plot import rounded, write
from timonel.errors import RecordingError
from timonel.recording.track import Track, segments, track

KNOTS = 3600 / 1852


@click.command("track")
@click.argument("file", type=click.Path())
@click.option("-o", "--out", type=click.Path(dir_okay=False), default="track.html", show_default=True)
@click.option("--source", type=click.IntRange(0, 253), help="Whose positions; those of who tells most, if not given.")
def track_program(file: str, out: str, source: int | None) -> None:
    """Draw where the recording FILE was, on a map without tiles; or write it as GPX 1.1, if OUT ends in .gpx."""
    found = track(file, source)
    if out.endswith(".gpx"):
        try:
            Path(out).write_text("\n".join(_gpx(os.path.basename(file), found)), encoding="utf-8")
        except OSError as error:
            raise RecordingError(f"{out}: {error.strerror}") from error
    else:
        about = f"source {found.source}, {np.count_nonzero(~np.isnan(found.latitude))} positions"
        write(out, "track.html", os.path.basename(file), about, _data(found))
    if found.others:
        click.echo(
            f"positions of source {found.source}; others: {', '.join(map(str, found.others))} (--source)", err=True
        )
    click.echo(out)


def _data(found: Track) -> dict[str, Any]:
    begin = float(found.time[0])
    return {
        "dated": found.dated,
        "begin": begin,
        "time": _listed(found.time - begin, 2),
        "lat": _listed(found.latitude, 7),
        "lon": _listed(found.longitude, 7),
        "speed": rounded(found.speed * KNOTS),
    }


def _listed(values: "np.ndarray[Any, np.dtype[np.float64]]", places: int) -> list[float | None]:
    return [None if value != value else value for value in np.round(values, places).tolist()]


def _gpx(name: str, found: Track) -> Iterator[str]:
    """Source: GPX 1.1 schema, topografix.com/GPX/1/1."""
    yield '<?xml version="1.0" encoding="UTF-8"?>'
    yield f'<gpx version="1.1" creator="timonel {__version__}" xmlns="http://www.topografix.com/GPX/1/1">'
    yield f"<trk><name>{escape(name)}</name><src>NMEA 2000 source {found.source}</src>"
    columns = (found.time, found.latitude, found.longitude, found.altitude)
    for piece in segments(found):
        yield "<trkseg>"
        for time, latitude, longitude, altitude in zip(*(column[piece].tolist() for column in columns), strict=True):
            elevation = "" if altitude != altitude else f"<ele>{altitude:.2f}</ele>"
            moment = f"<time>{_moment(time)}</time>" if found.dated else ""
            yield f'<trkpt lat="{latitude:.7f}" lon="{longitude:.7f}">{elevation}{moment}</trkpt>'
        yield "</trkseg>"
    yield "</trk>\n</gpx>\n"


def _moment(time: float) -> str:
    moment = datetime.fromtimestamp(round(time * 1000) / 1000, UTC)
    return f"{moment:%Y-%m-%dT%H:%M:%S}.{moment.microsecond // 1000:03}Z"
