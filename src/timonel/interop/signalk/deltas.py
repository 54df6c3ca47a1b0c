"""Messages of Signal K in words: hello, deltas, and the tree of the REST interface.

Times are seconds of the machine; `epoch` is when its time was 0, in seconds since 1970.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import msgspec

from timonel.interop.signalk.boat import timestamp
from timonel.interop.signalk.model import Entry
from timonel.interop.signalk.paths import PATHS, Path
from timonel.interop.signalk.told import OWN, Told, Value

SCHEMA = "1.7.0"
SELF = "vessels.self"
DIGITS = 9  # of a degree of latitude a tenth of a millimetre

Tree = dict[str, Any]


class Vessel(msgspec.Struct, frozen=True):
    """Who we are: `urn` as `urn:mrn:signalk:uuid:...` or `urn:mrn:imo:mmsi:...`."""

    urn: str
    name: str

    @property
    def context(self) -> str:
        """Whose deltas they are."""
        return f"vessels.{self.urn}"

    @property
    def base(self) -> Tree:
        """What a vessel tells of itself in the tree."""
        number = self.urn.removeprefix("urn:mrn:imo:mmsi:")
        who = {"uuid": self.urn} if number == self.urn else {"mmsi": number}
        return {**who, "name": self.name}


def hello(vessel: str, now: float, epoch: float) -> bytes:
    """The first message of a stream; `vessel` is the context of its own deltas."""
    return msgspec.json.encode(
        {
            "name": OWN,
            "version": SCHEMA,
            "self": vessel,
            "roles": ["master", "main"],
            "timestamp": timestamp(now + epoch),
        }
    )


def delta(context: str, news: Iterable[Told], epoch: float) -> bytes:
    """A delta of what is new."""
    updates = [
        {
            "$source": told.source,
            "timestamp": timestamp((told.heard or 0.0) + epoch),
            "values": [{"path": path, "value": rounded(value)} for path, value in told.values.items()],
        }
        for told in news
    ]
    return msgspec.json.encode({"context": context, "updates": updates})


def meta(context: str, paths: Iterable[str], now: float, epoch: float) -> bytes:
    """A delta of what paths mean."""
    told = [{"path": path, "value": described(PATHS[path])} for path in paths if path in PATHS]
    return msgspec.json.encode({"context": context, "updates": [{"timestamp": timestamp(now + epoch), "meta": told}]})


def described(path: Path) -> Tree:
    """The meta of a path."""
    units = {"units": path.units} if path.units else {}
    return {**units, "description": path.description}


def rounded(value: Value) -> Any:
    """A value as it is written: no more digits than anybody measures, and never -0."""
    if isinstance(value, float):
        return round(value, DIGITS) + 0.0
    if isinstance(value, dict):
        return {key: rounded(part) if isinstance(part, float) else part for key, part in value.items()}
    return value


def tree(vessel: Vessel, entries: Mapping[str, Entry], epoch: float) -> Tree:
    """Everything, as `/signalk/v1/api/` shows it."""
    own: Tree = dict(vessel.base)
    for path, entry in entries.items():
        *above, last = path.split(".")
        place = own
        for step in above:
            place = place.setdefault(step, {})
        place.setdefault(last, {}).update(_leaf(path, entry, epoch))
    sources = sorted({entry.source.removeprefix(f"{OWN}.") for entry in entries.values()} - {OWN})
    return {
        "version": SCHEMA,
        "self": vessel.context,
        "vessels": {vessel.urn: own},
        "sources": {OWN: {"label": OWN, "type": "NMEA2000"} | {each: {} for each in sources}},
    }


def _leaf(path: str, entry: Entry, epoch: float) -> Tree:
    leaf: Tree = {
        "value": rounded(entry.value),
        "$source": entry.source,
        "timestamp": timestamp(entry.heard + epoch),
    }
    return leaf | ({"meta": described(PATHS[path])} if path in PATHS else {})
