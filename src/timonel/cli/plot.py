"""`timonel plot`: values of a recording over time, as one page that needs nothing else."""

import html
import os
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import click
import msgspec
import numpy as np

from timonel.errors import RecordingError
from timonel.gateway import own_frames
from timonel.recording.series import Series, Values, by_unit, series
from timonel.vehicles.rover.protocol import Protocol

PAGES = files("timonel.cli") / "pages"
_DIGITS = 6  # that count of a value; a screen has fewer


@click.command()
@click.argument("file", type=click.Path())
@click.argument("names", nargs=-1, required=True)
@click.option("-o", "--out", type=click.Path(dir_okay=False), default="plot.html", show_default=True)
@click.option("--frames", type=click.Path(), help="A TOML or Python file with frames of one's own rover.")
def plot(file: str, names: tuple[str, ...], out: str, frames: str | None) -> None:
    """Draw NAMES, values of the recording FILE, over time: a page for any browser, with zoom, day and night.

    A name is a field (heading), a field of a message (vesselHeading.heading), or a message (rudder), whose every
    value is drawn. Angles are in degrees and do not jump at 360, speeds in knots; times are UTC.
    """
    protocol = Protocol(own=own_frames.load(frames)) if frames else None
    found, dated = series(file, names, protocol)
    write(out, "plot.html", os.path.basename(file), ", ".join(names), _data(found, dated), uplot=True)
    for one in found:
        click.echo(f"{one.name}: {np.count_nonzero(~np.isnan(one.value))} values", err=True)
    click.echo(out)


def write(out: str, page: str, title: str, about: str, data: Any, uplot: bool = False) -> None:
    """Write a page with its data in it. Raises RecordingError if that cannot be done."""
    parts = {"title": html.escape(title), "about": html.escape(about), "data": embedded(data)}
    if uplot:
        parts["uplot_js"] = (PAGES / "uplot" / "uPlot.iife.min.js").read_text()
        parts["uplot_css"] = (PAGES / "uplot" / "uPlot.min.css").read_text()
    text = Template((PAGES / page).read_text()).safe_substitute(parts)
    try:
        Path(out).write_text(text, encoding="utf-8")
    except OSError as error:
        raise RecordingError(f"{out}: {error.strerror}") from error


def embedded(data: Any) -> str:
    """JSON that can stand in a page: what is in it cannot end the element that it stands in."""
    return msgspec.json.encode(data).decode().replace("<", "\\u003c")


def _data(found: list[Series], dated: bool) -> dict[str, Any]:
    begin = float(min(one.time[0] for one in found))
    charts = [
        {"unit": unit, "circular": some[0].circular, "series": [_plain(one, begin) for one in some]}
        for unit, some in by_unit(found)
    ]
    return {"dated": dated, "begin": begin, "charts": charts}


def _plain(one: Series, begin: float) -> dict[str, Any]:
    time = np.round(one.time - begin, 3).tolist()
    return {"name": one.name, "time": time, "value": rounded(one.value)}


def rounded(values: Values) -> list[float | None]:
    """What can be told apart on a screen; None for NaN."""
    largest = float(np.nanmax(np.abs(values), initial=1e-9))
    places = max(0, _DIGITS - 1 - int(np.floor(np.log10(largest))))
    return [None if value != value else value for value in np.round(values, places).tolist()]
