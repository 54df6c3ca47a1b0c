"""What speaks and listens: the tables `[[station]]`, `[[output]]` and `[[input]]` of a configuration, understood."""

from collections.abc import Callable
from typing import Annotated, Any

import msgspec

from timonel.gateway import shaping
from timonel.nmea0183.selection import EVERYTHING, Selection
from timonel.nmea2000.text import FormName
from timonel.vehicles.boat.settings import Port

FRAMES_PER_SECOND = 400  # of one output's listeners: a quarter of what a bus carries
STATION: dict[str, Any] = {
    "id": Annotated[int, msgspec.Meta(ge=1, le=4)],
    "name": str,
    "url": str,
    "in": str,
    "out": str,
}
BOAT_STATION = STATION | {"shared": bool, "instruments": bool} | shaping.KEYS
OUTPUT: dict[str, Any] = {"url": str, "name": str}
_FRAMES: dict[str, Any] = {
    "format": FormName,
    "transmit": bool,
    "frames_per_second": Annotated[int, msgspec.Meta(ge=1, le=2000)],
}
BOAT_OUTPUT = OUTPUT | _FRAMES | shaping.KEYS
INPUT: dict[str, Any] = {"url": str, "name": str} | shaping.HEARING_KEYS

Values = dict[str, Any]
Wrong = Callable[[str, str], None]


class Station(msgspec.Struct, frozen=True):
    """A station's port and its links: `receive_url` is what it says, `send_url` what it hears.

    Both are the same where one link does both; None where there is none.
    """

    port: Port
    receive_url: str | None
    send_url: str | None
    selection: Selection = EVERYTHING
    bytes_per_second: int | None = None
    """What it may hear at most; None is what its link carries."""


class Output(msgspec.Struct, frozen=True):
    """A link for listeners that never command.

    With a `form` it is told the frames of the bus instead of sentences, and may `transmit` some of its own.
    """

    name: str
    url: str
    form: FormName | None = None
    transmit: bool = False
    frames_per_second: int = FRAMES_PER_SECOND
    selection: Selection = EVERYTHING
    bytes_per_second: int | None = None


class Input(msgspec.Struct, frozen=True):
    """A link to instruments, which tell something and never command."""

    port: Port
    url: str


def station(place: str, given: Values, values: Values, may_share: bool, wrong: Wrong) -> Station:
    """A station of what is `given` at a place, of which `values` are right."""
    if "id" not in given and not values.get("shared"):
        or_shared = ", or shared = true for a wire that several stations share" if may_share else ""
        wrong(f"{place}.id", f"missing; 1..4{or_shared}")
    if "url" in given and ("in" in given or "out" in given):
        wrong(f"{place}.url", "one link does both; leave out in and out")
    elif "url" not in given and "in" not in given:
        wrong(f"{place}.in", "missing; what the station says, or url where one link does both")
    number = None if values.get("shared") else values.get("id")
    name = values.get("name") or (f"Station {values['id']}" if "id" in values else place)
    instruments = values.get("instruments", False)
    if instruments and number is None:
        wrong(f"{place}.instruments", "not on a wire that several stations share")
    return Station(
        Port(name, number, instrument=instruments),
        values.get("in", values.get("url")),
        values.get("out", values.get("url")),
        shaping.settle(values, place, True, wrong),
        values.get("bytes_per_second"),
    )


def output(place: str, given: Values, values: Values, wrong: Wrong) -> Output:
    """Listeners, of what is `given` at a place, of which `values` are right."""
    if "url" not in given:
        wrong(f"{place}.url", "missing; where the listeners are, like tcp-listen://127.0.0.1:10110")
    form = values.get("format")
    frames = {key: values[key] for key in ("transmit", "frames_per_second") if key in values}
    for key in frames:
        if form is None:
            wrong(f"{place}.{key}", "is for frames; say with format which form they have")
    for shaped in values:
        if form is not None and shaped in shaping.KEYS:
            wrong(f"{place}.{shaped}", "is for sentences; with a format there are frames alone")
    url = values.get("url", "")
    return Output(
        values.get("name") or url,
        url,
        form,
        **frames,
        selection=shaping.settle(values, place, False, wrong),
        bytes_per_second=values.get("bytes_per_second"),
    )


def instruments(place: str, given: Values, values: Values, number: int, wrong: Wrong) -> Input:
    """Instruments, of what is `given` at a place, of which `values` are right; they are the input of a number."""
    if "url" not in given:
        wrong(f"{place}.url", "missing; where the instruments are, like serial:///dev/ttyUSB0?baud=4800")
    hears = shaping.hearing(values, place, wrong)
    return Input(Port(values.get("name") or f"Input {number}", instrument=True, hears=hears), values.get("url", ""))
