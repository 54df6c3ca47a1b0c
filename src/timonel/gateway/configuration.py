"""The configuration of a gateway: a TOML file that is understood as a whole or not at all.

`docs/configuration.md` describes every key, those of a rover `docs/rover.md`; `docs/boat.toml` and `docs/rover.toml`
show them. All mistakes are told at once.
"""

import os
import tomllib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, Literal, get_type_hints

import msgspec

from timonel.core.mistakes import Mistakes, convert, did_you_mean, syntax_error, written
from timonel.errors import ConfigError, LinkError
from timonel.gateway import (
    broker,
    identity,
    link_settings,
    own_frames,
    recording_settings,
    signalk_settings,
    source_settings,
    web_settings,
)
from timonel.gateway.extras import mdns_installed
from timonel.gateway.link_settings import Input, Output, Station
from timonel.gateway.recording_settings import Recording
from timonel.gateway.web_settings import STATION_IDS, Web
from timonel.links import urls
from timonel.vehicles.boat.alert_settings import AlertSettings
from timonel.vehicles.boat.conversion import RATES
from timonel.vehicles.boat.pilots import Wanted
from timonel.vehicles.boat.settings import BoatSettings, Hertz, Port
from timonel.vehicles.boat.sources import SourceSettings
from timonel.vehicles.rover.calibration import Calibration, calibrated
from timonel.vehicles.rover.declaration import RoverFrame
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.settings import RoverSettings

Table = dict[str, Any]
Keys = dict[str, Any]
Settings = BoatSettings | RoverSettings

FLUSH_SECONDS = {"0ms": 0.0, "2ms": 0.002, "5ms": 0.005}

_BOAT = get_type_hints(BoatSettings, include_extras=True)
_ADDRESS = _BOAT.pop("address")
_BOAT.pop("rates")
_BOAT.pop("alerts")
_BOAT.pop("node")
_BOAT.pop("sources")
_ROVER = get_type_hints(RoverSettings, include_extras=True)
_KIND = {"kind": Literal["boat", "rover"]}
_BASE = {"base": Literal["documented", "physical"]}
_GATEWAY: Keys = {"flush": Literal["0ms", "2ms", "5ms"], "log": Literal["debug", "info", "warning", "error"]}
_NETWORK: Keys = {"mdns": bool}


class Kind(msgspec.Struct, frozen=True):
    """What may stand in the configuration of one kind of vehicle, and how it is put together.

    `lists` are the tables in double brackets. `settle` makes settings and protocol of the tables' sound values.
    """

    tables: dict[str, Keys]
    lists: dict[str, Keys]
    settle: Callable[["_Reader"], tuple[Settings, Protocol | None]]

    @property
    def keys(self) -> dict[str, Keys]:
        return self.tables | self.lists


class Configuration(msgspec.Struct, frozen=True):
    """A whole configuration, understood; `flush` is in s, `log` the least severe level that is logged."""

    file: str
    vehicle: Settings
    bus_url: str
    stations: tuple[Station, ...] = ()
    outputs: tuple[Output, ...] = ()
    inputs: tuple[Input, ...] = ()
    flush: float = 0.0
    log: str = "info"
    protocol: Protocol | None = None
    """Frames and calibration of a rover."""
    frames_file: str | None = None
    """The file of the rover's own frames."""
    recording: Recording | None = None
    web: Web | None = None
    mqtt: broker.Mqtt | None = None
    signalk: signalk_settings.SignalK | None = None
    mdns: bool = False
    """Whether other computers find what they can reach."""
    text: str = ""
    """The file as it stands."""

    @property
    def names(self) -> dict[int, str]:
        """What the stations are called, all four, by number."""
        named = {station.port.station: station.port.name for station in self.stations}
        return {number: named.get(number, f"Station {number}") for number in STATION_IDS}

    @property
    def consoles(self) -> list[Port]:
        """The ports that the console speaks on, one for each station that it may be."""
        stations = () if self.web is None else self.web.stations
        return [Port(f"{self.names[number]} web", number, console=True) for number in stations]

    @property
    def broker_port(self) -> Port | None:
        """The port that an MQTT broker speaks on, for the station that it is paired with."""
        number = None if self.mqtt is None else self.mqtt.station
        return None if number is None else Port(f"{self.names[number]} MQTT", number, console=True)

    @property
    def inner_ports(self) -> list[Port]:
        """Those that are no wires: the console's, and the broker's."""
        return self.consoles + ([] if self.broker_port is None else [self.broker_port])

    @property
    def ports(self) -> list[Port]:
        """All ways in: the wires of the stations, the inner ones, and those of the instruments."""
        return [s.port for s in self.stations] + self.inner_ports + [i.port for i in self.inputs]

    @property
    def instrument_urls(self) -> list[tuple[Port, str]]:
        """The ports that only instruments speak on, and where they are."""
        return [(given.port, given.url) for given in self.inputs]

    @property
    def bus_carries(self) -> urls.Carries:
        """Bytes where the bus is a rover's UART, to a controller that does the driving."""
        return "bytes" if isinstance(self.vehicle, RoverSettings) and self.vehicle.role == "operator" else "frames"


def load(path: str | Path) -> Configuration:
    """Read a configuration; raises ConfigError with one line for each mistake."""
    try:
        text = Path(path).read_bytes().decode()
    except OSError as fault:
        raise ConfigError(f"{path}: {fault.strerror}") from fault
    except UnicodeDecodeError as fault:
        raise ConfigError(f"{path}: not UTF-8 text (byte {fault.start})") from fault
    return parse(text, str(path))


def parse(text: str, file: str = "boat.toml") -> Configuration:
    """Understand the text of a configuration called `file`; raises as `load`."""
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as fault:
        raise syntax_error(file, text, fault) from fault
    mistakes = Mistakes(file, text)
    reader = _Reader(document, mistakes, file)
    configuration = msgspec.structs.replace(reader.configuration(), text=text)
    if mistakes or reader.elsewhere:
        raise ConfigError("\n".join(filter(None, (str(mistakes.error()), *reader.elsewhere))))
    return configuration


class _Reader:
    """Goes through all tables; what is wrong is noted and left out, so that the rest is looked at too."""

    def __init__(self, document: Table, mistakes: Mistakes, file: str) -> None:
        self.elsewhere: list[str] = []
        """What is wrong in the files that this one names, a line each."""
        self._wrong = mistakes.add
        self._file = file
        self._beside = Path(file).parent
        self._kind = _kind(document)
        for name in document.keys() - self._kind.keys.keys():
            self._wrong(name, f"unknown table{did_you_mean(name, self._kind.keys)}")
        self._given = document.keys()
        self._tables = {name: self._table(document, name) for name in self._kind.tables}
        self._lists = {name: self._list(document, name) for name in self._kind.lists}

    def _table(self, document: Table, name: str) -> Table:
        table = document.get(name, {})
        if not isinstance(table, dict):
            self._wrong(name, f"{written(table)} should be a table: [{name}]")
            return {}
        return table

    def _list(self, document: Table, name: str) -> list[Table]:
        tables = document.get(name, [])
        if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
            self._wrong(name, f"should stand in double brackets: [[{name}]]")
            return []
        return tables

    def configuration(self) -> Configuration:
        gateway = self._sound("gateway")
        bus_url = self._sound("bus").get("url")
        self._require("vehicle.kind", self._sound("vehicle").get("kind"), 'say which: "boat" or "rover"')
        settings, protocol = self._kind.settle(self)
        configuration = Configuration(
            file=self._file,
            vehicle=settings,
            bus_url=bus_url or "",
            stations=self._stations(),
            outputs=self._outputs(),
            inputs=self._inputs(),
            flush=FLUSH_SECONDS[gateway.get("flush", "0ms")],
            log=gateway.get("log", "info"),
            protocol=protocol,
            frames_file=self._frames_file(),
            recording=self._recording(),
            web=self._web(),
            mqtt=self._mqtt(),
            signalk=self._signalk(),
            mdns=self._mdns(),
        )
        wanted = "like socketcan://can0" if configuration.bus_carries == "frames" else "like serial:///dev/ttyUSB0"
        self._require("bus.url", bus_url, f"a bus is needed, {wanted}")
        self._check_as_a_whole(configuration)
        return configuration

    def boat(self) -> tuple[Settings, None]:
        """The settings of a boat stand in several tables."""
        vehicle = _without(self._sound("vehicle"), "kind")
        bus = self._sound("bus")
        node = identity.settle(bus, vehicle.get("name", "boat"))
        own = _only(bus, "address")
        own["alerts"] = AlertSettings(**self._sound("alerts"))
        self._check_pilot(vehicle)
        return BoatSettings(**vehicle, **own, node=node, rates=self._rates(), sources=self._sources()), None

    def _check_pilot(self, vehicle: Table) -> None:
        """A pilot that is named must be one, and only the driver `sentence` speaks on an output."""
        pilot, output = vehicle.get("pilot", "standard"), vehicle.get("pilot_output")
        try:
            Wanted.of(vehicle.get("pilot_name", ""))
        except ValueError as fault:
            self._wrong("vehicle.pilot_name", str(fault))
        if pilot != "sentence":
            for key in ("pilot_output", "pilot_sentences"):
                if key in vehicle:
                    self._wrong(f"vehicle.{key}", f'goes with pilot = "sentence", not with {written(pilot)}')
            return
        names = [table.get("name", table.get("url")) for table in self._lists["output"] if "format" not in table]
        if output is None:
            self._wrong("vehicle.pilot_output", "missing; the name of the [[output]] where the pilot is")
        elif output not in names:
            self._wrong("vehicle.pilot_output", f"there is no [[output]] with the name {written(output)}")

    def rover(self) -> tuple[Settings, Protocol]:
        """The settings of a rover, and what its frames mean."""
        vehicle = self._sound("vehicle")
        base = {"base": vehicle["calibration"]} if "calibration" in vehicle else {}
        calibration = calibrated(base | self._tables["calibration"], self._wrong)
        protocol = Protocol(calibration, self._own_frames(self._frames_file()))
        return RoverSettings(**_without(vehicle, "kind", "frames")), protocol

    def _frames_file(self) -> str | None:
        path = self._sound("vehicle").get("frames")
        return None if path is None else str(self._beside / path)

    def _own_frames(self, path: str | None) -> tuple[type[RoverFrame], ...]:
        """The frames that the owner declares, in a file beside this one."""
        if path is None:
            return ()
        try:
            return own_frames.load(path)
        except ConfigError as fault:
            self.elsewhere.append(str(fault))
            return ()

    def _sound(self, name: str) -> Table:
        """The values of a whole table that are right."""
        return self._values(name, self._tables[name], self._kind.tables[name])

    def _values(self, place: str, table: Table, keys: Keys) -> Table:
        """The values of a table that are right."""
        values = {}
        for key, value in table.items():
            if key not in keys:
                self._wrong(f"{place}.{key}", f"unknown key{_belongs(key, self._kind) or did_you_mean(key, keys)}")
                continue
            try:
                values[key] = convert(value, keys[key])
            except ValueError as fault:
                self._wrong(f"{place}.{key}", str(fault))
        return values

    def _require(self, key: str, value: object, text: str) -> None:
        section, _, name = key.rpartition(".")
        if value is None and name not in self._tables[section]:
            self._wrong(key, f"missing; {text}")

    def _rates(self) -> dict[str, float]:
        """Ceilings in Hz. `true` is the sentence's own rate, `false` none of it."""
        given = self._sound("sentences")
        return {key: (RATES[key] or 1.0) if value is True else float(value) for key, value in given.items()}

    def _sources(self) -> SourceSettings | None:
        """None where nothing is said of them."""
        if not self._given & {"sources", "correction"}:
            return None
        keys = self._kind.lists["correction"]
        given = enumerate(self._lists["correction"], 1)
        corrections = [self._values(f"correction[{number}]", table, keys) for number, table in given]
        ports = [station.port for station in self._stations()] + [given.port for given in self._inputs()]
        names = [port.name for port in ports if port.instrument]
        return source_settings.settle(self._sound("sources"), corrections, names, self._wrong)

    def _recording(self) -> Recording | None:
        """None where there is no such table, or it says so."""
        values = self._sound("recording")
        if "recording" not in self._given or not values.get("enabled", True):
            return None
        return recording_settings.settle(values, self._beside, self._wrong)

    def _web(self) -> Web | None:
        """None where there is no such table, or it says so."""
        values = self._sound("web")
        if "web" not in self._given or not values.get("enabled", True):
            return None
        return web_settings.settle(values, "token" in self._tables["web"], self._beside, self._wrong)

    def _mqtt(self) -> broker.Mqtt | None:
        """None where there is no such table, or it says so."""
        values = self._sound("mqtt")
        if "mqtt" not in self._given or not values.get("enabled", True):
            return None
        vehicle = self._sound("vehicle")
        name = str(vehicle.get("name", vehicle.get("kind")))
        return broker.settle(values, name, self._beside, self._wrong)

    def _mdns(self) -> bool:
        wanted: bool = self._sound("network").get("mdns", False)
        if wanted and not mdns_installed():
            self._wrong("network.mdns", "needs zeroconf: pip install timonel[mdns]")
        return wanted

    def _signalk(self) -> signalk_settings.SignalK | None:
        """None where there is no such table."""
        values = self._sound("signalk") if "signalk" in self._kind.tables else {}
        return signalk_settings.settle(values, self._wrong) if "signalk" in self._given else None

    def _stations(self) -> tuple[Station, ...]:
        may_share = "shared" in self._kind.lists["station"]
        given = self._places("station")
        return tuple(link_settings.station(*one, may_share, self._wrong) for one in given)

    def _outputs(self) -> tuple[Output, ...]:
        return tuple(link_settings.output(*one, self._wrong) for one in self._places("output"))

    def _inputs(self) -> tuple[Input, ...]:
        given = enumerate(self._places("input"), 1)
        return tuple(link_settings.instruments(*one, number, self._wrong) for number, one in given)

    def _places(self, name: str) -> Iterator[tuple[str, Table, Table]]:
        """Each table of a list: where it stands, what is given there, and what of that is right."""
        for number, table in enumerate(self._lists.get(name, ()), 1):
            place = f"{name}[{number}]"
            yield place, table, self._values(place, table, self._kind.lists[name])

    def _check_as_a_whole(self, configuration: Configuration) -> None:
        told = (configuration.web, configuration.mqtt, configuration.signalk) != (None, None, None)
        if not (told or self._lists["station"] or self._lists["output"] or configuration.inputs):
            self._wrong("station", "missing; without a [[station]] or an [[output]] nobody hears anything")
        self._check_urls(configuration)
        self._check_once(
            (f"station[{number}].id", station.port.station, station.port.station)
            for number, station in enumerate(configuration.stations, 1)
        )
        self._check_once(self._names(configuration))
        self._check_once((key, _device(url), url) for key, url in _urls(configuration))

    def _check_urls(self, configuration: Configuration) -> None:
        for key, url in _urls(configuration):
            try:
                urls.check(url, configuration.bus_carries if key == "bus.url" else "bytes")
            except LinkError as fault:
                self._wrong(key, str(fault))
            if isinstance(configuration.vehicle, RoverSettings) and urls.is_text_bus(url):
                self._wrong(key, f"{url}: a rover's frames have 11-bit identifiers, which these lines have not")

    def _names(self, configuration: Configuration) -> Iterator[tuple[str, object, object]]:
        for number, (table, station) in enumerate(zip(self._lists["station"], configuration.stations, strict=True), 1):
            key = "name" if "name" in table else "id"
            yield f"station[{number}].{key}", station.port.name, station.port.name
        for number, (table, output) in enumerate(zip(self._lists["output"], configuration.outputs, strict=True), 1):
            if "name" in table:
                yield f"output[{number}].name", output.name, output.name
        for number, given in enumerate(configuration.inputs, 1):
            yield f"input[{number}].name", given.port.name, given.port.name

    def _check_once(self, values: Iterable[tuple[str, object, object]]) -> None:
        """Note each (key, value, how it is shown) whose value has a key before it; None may come often."""
        first: dict[object, str] = {}
        for key, value, shown in values:
            if value is not None and (earlier := first.setdefault(value, key)) != key:
                self._wrong(key, f"{written(shown)} is {earlier} already")


KINDS = {
    "boat": Kind(
        tables={
            "vehicle": _KIND | _BOAT,
            "bus": {"url": str, "address": _ADDRESS} | identity.KEYS,
            "sentences": dict.fromkeys(RATES, bool | Hertz),
            "alerts": get_type_hints(AlertSettings, include_extras=True),
            "gateway": _GATEWAY,
            "recording": recording_settings.KEYS,
            "web": web_settings.KEYS,
            "mqtt": broker.KEYS,
            "network": _NETWORK,
            "signalk": signalk_settings.KEYS,
            "sources": source_settings.KEYS,
        },
        lists={
            "station": link_settings.BOAT_STATION,
            "output": link_settings.BOAT_OUTPUT,
            "input": link_settings.INPUT,
            "correction": source_settings.CORRECTION,
        },
        settle=_Reader.boat,
    ),
    "rover": Kind(
        tables={
            "vehicle": _KIND | _ROVER | {"frames": str},
            "bus": {"url": str},
            "calibration": _BASE | get_type_hints(Calibration, include_extras=True),
            "gateway": _GATEWAY,
            "recording": recording_settings.KEYS,
            "web": web_settings.KEYS,
            "mqtt": broker.KEYS,
            "network": _NETWORK,
        },
        lists={"station": link_settings.STATION, "output": link_settings.OUTPUT},
        settle=_Reader.rover,
    ),
}


def _kind(document: Table) -> Kind:
    """What the document says that it is about; a boat if it says nothing, or nothing known."""
    vehicle = document.get("vehicle")
    name = vehicle.get("kind") if isinstance(vehicle, dict) else None
    return KINDS.get(str(name), KINDS["boat"])


def _without(table: Table, *keys: str) -> Table:
    return {key: value for key, value in table.items() if key not in keys}


def _only(table: Table, *keys: str) -> Table:
    return {key: value for key, value in table.items() if key in keys}


def _belongs(key: str, kind: Kind) -> str:
    """Where a key that stands in the wrong table would be right, if that is one place."""
    places = [name for name, keys in kind.keys.items() if key in keys]
    return f" (it belongs in [{places[0]}])" if len(places) == 1 else ""


def _urls(configuration: Configuration) -> Iterator[tuple[str, str]]:
    """All URLs with their keys, one that does both once."""
    if configuration.bus_url:
        yield "bus.url", configuration.bus_url
    for number, station in enumerate(configuration.stations, 1):
        both = station.receive_url == station.send_url
        for key, url in (("url" if both else "in", station.receive_url), ("out", station.send_url)):
            if url and not (both and key == "out"):
                yield f"station[{number}].{key}", url
    for number, output in enumerate(configuration.outputs, 1):
        if output.url:
            yield f"output[{number}].url", output.url
    for number, given in enumerate(configuration.inputs, 1):
        if given.url:
            yield f"input[{number}].url", given.url
    if configuration.signalk is not None and configuration.signalk.tcp is not None:
        yield "signalk.tcp", configuration.signalk.tcp


def _device(url: str) -> object:
    """What two links cannot both have; None where they can, and for a URL that is not understood."""
    scheme = url.partition("://")[0]
    try:
        place = urls.parse(url).values
    except LinkError:
        return None
    if over := place.get("over"):  # a bus in lines of text
        return _device(str(over))
    if scheme in ("serial", "slcan"):
        return os.path.realpath(str(place["path"]))
    if scheme == "pty":
        return os.path.abspath(str(place["path"]))
    if scheme == "iec450":  # many hear and speak in one group
        return None
    return (scheme, place.get("host"), place["port"]) if place.get("port") else None
