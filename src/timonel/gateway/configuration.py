"""The configuration of a gateway: a TOML file that is understood as a whole or not at all.

`docs/configuration.md` describes every key, those of a rover `docs/rover.md`; `docs/boat.toml` and `docs/rover.toml`
show them. All mistakes are told at once.
"""

import os
import secrets
import tomllib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, get_type_hints

import msgspec

from timonel.core.mistakes import Mistakes, convert, did_you_mean, syntax_error, written
from timonel.errors import ConfigError, LinkError
from timonel.gateway import broker, identity, own_frames, shaping, signalk_settings, source_settings
from timonel.gateway.extras import mdns_installed, recorder_installed, web_installed
from timonel.gateway.measures import duration, size
from timonel.gateway.places import is_loopback, place
from timonel.links import urls
from timonel.nmea0183.selection import EVERYTHING, Selection
from timonel.nmea2000.text import FormName
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

StationId = Annotated[int, msgspec.Meta(ge=1, le=4)]
STATION_IDS = (1, 2, 3, 4)
RECORDINGS = "recordings"
CONSOLE_AT = "127.0.0.1:8080"
TOKEN_LENGTH = 12  # characters that a token has at least
FRAMES_PER_SECOND = 400  # of one output's listeners: a quarter of what a bus carries
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
_RECORDING: Keys = {
    "directory": str,
    "segment_size": str,
    "segment_age": str,
    "budget": str,
    "decoded": bool,
    "enabled": bool,
}
_WEB: Keys = {
    "enabled": bool,
    "listen": str,
    "token": Annotated[str, msgspec.Meta(min_length=TOKEN_LENGTH)],
    "certificate": str,
    "key": str,
    "hosts": list[str],
    "stations": list[StationId],
    "tiles": str,
}
_NETWORK: Keys = {"mdns": bool}
_STATION: Keys = {"id": StationId, "name": str, "url": str, "in": str, "out": str}
_OUTPUT: Keys = {"url": str, "name": str}
_INPUT: Keys = {"url": str, "name": str}
_FRAMES: Keys = {
    "format": FormName,
    "transmit": bool,
    "frames_per_second": Annotated[int, msgspec.Meta(ge=1, le=2000)],
}


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


class Recording(msgspec.Struct, frozen=True):
    """Where the flight recorder writes, when it begins a new file (bytes, s), and what all may take (bytes).

    `decoded` is whether messages are recorded in clear too.
    """

    directory: str
    segment_size: int = 64_000_000
    segment_age: float = 3600.0
    budget: int = 2_000_000_000
    decoded: bool = False


class Web(msgspec.Struct, frozen=True):
    """Where the console is served, and to whom.

    `hosts` are the names by which browsers may call it beside its addresses, `stations` those that a console may be,
    `tiles` a directory of map tiles, z/x/y.png.
    Without a `token` whoever reaches it sees and may be a station, which is for this computer alone.
    """

    host: str = "127.0.0.1"
    port: int = 8080
    token: str | None = None
    certificate: str | None = None
    key: str | None = None
    hosts: tuple[str, ...] = ()
    stations: tuple[int, ...] = STATION_IDS
    tiles: str | None = None


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
        return None if path is None else str(Path(self._file).parent / path)

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
        if not recorder_installed():
            self._wrong("recording", "needs mcap and zstandard: pip install timonel[recording]")
        recording = Recording(
            directory=str(Path(self._file).parent / values.get("directory", RECORDINGS)),
            decoded=values.get("decoded", False),
            **self._measures(_only(values, "segment_size", "budget"), size),
            **self._measures(_only(values, "segment_age"), duration),
        )
        if recording.budget < 2 * recording.segment_size:
            self._wrong("recording.budget", "is less than two segments of segment_size")
        return recording

    def _web(self) -> Web | None:
        """None where there is no such table, or it says so."""
        values = self._sound("web")
        if "web" not in self._given or not values.get("enabled", True):
            return None
        if not web_installed():
            self._wrong("web", "needs starlette, uvicorn and websockets: pip install timonel[web]")
        try:
            host, port = place(values.get("listen", CONSOLE_AT))
        except ValueError as fault:
            self._wrong("web.listen", str(fault))
            return Web()
        if not is_loopback(host) and "token" not in self._tables["web"]:
            self._wrong("web.token", f"missing; {host} is not this computer alone: say who may see, like {_a_token()}")
        if ("key" in values) != ("certificate" in values):
            self._wrong("web", "certificate and key go together")
        wanted = _only(values, "certificate", "key", "tiles")
        files = {key: str(Path(self._file).parent / path) for key, path in wanted.items()}
        if "tiles" in files and not Path(files["tiles"]).is_dir():
            self._wrong("web.tiles", f"{files['tiles']} is no directory of map tiles, z/x/y.png")
        return Web(
            host,
            port,
            values.get("token"),
            hosts=tuple(values.get("hosts", ())),
            stations=tuple(sorted(set(values.get("stations", STATION_IDS)))),
            **files,
        )

    def _mqtt(self) -> broker.Mqtt | None:
        """None where there is no such table, or it says so."""
        values = self._sound("mqtt")
        if "mqtt" not in self._given or not values.get("enabled", True):
            return None
        vehicle = self._sound("vehicle")
        name = str(vehicle.get("name", vehicle.get("kind")))
        return broker.settle(values, name, Path(self._file).parent, self._wrong)

    def _mdns(self) -> bool:
        wanted: bool = self._sound("network").get("mdns", False)
        if wanted and not mdns_installed():
            self._wrong("network.mdns", "needs zeroconf: pip install timonel[mdns]")
        return wanted

    def _signalk(self) -> signalk_settings.SignalK | None:
        """None where there is no such table."""
        values = self._sound("signalk") if "signalk" in self._kind.tables else {}
        return signalk_settings.settle(values, self._wrong) if "signalk" in self._given else None

    def _measures(self, values: Table, read: Callable[[str], float]) -> Table:
        """Those that can be read, by name."""
        measures = {}
        for key, text in values.items():
            try:
                measures[key] = read(text)
            except ValueError as fault:
                self._wrong(f"recording.{key}", str(fault))
        return measures

    def _stations(self) -> tuple[Station, ...]:
        return tuple(
            self._station(f"station[{number}]", table) for number, table in enumerate(self._lists["station"], 1)
        )

    def _station(self, place: str, table: Table) -> Station:
        keys = self._kind.lists["station"]
        values = self._values(place, table, keys)
        if "id" not in table and not values.get("shared"):
            or_shared = ", or shared = true for a wire that several stations share" if "shared" in keys else ""
            self._wrong(f"{place}.id", f"missing; 1..4{or_shared}")
        if "url" in table and ("in" in table or "out" in table):
            self._wrong(f"{place}.url", "one link does both; leave out in and out")
        elif "url" not in table and "in" not in table:
            self._wrong(f"{place}.in", "missing; what the station says, or url where one link does both")
        station = None if values.get("shared") else values.get("id")
        name = values.get("name") or (f"Station {values['id']}" if "id" in values else place)
        url = values.get("url")
        instruments = values.get("instruments", False)
        if instruments and station is None:
            self._wrong(f"{place}.instruments", "not on a wire that several stations share")
        return Station(
            Port(name, station, instrument=instruments),
            values.get("in", url),
            values.get("out", url),
            shaping.settle(values, place, True, self._wrong),
            values.get("bytes_per_second"),
        )

    def _outputs(self) -> tuple[Output, ...]:
        return tuple(self._output(f"output[{number}]", table) for number, table in enumerate(self._lists["output"], 1))

    def _output(self, place: str, table: Table) -> Output:
        values = self._values(place, table, self._kind.lists["output"])
        if "url" not in table:
            self._wrong(f"{place}.url", "missing; where the listeners are, like tcp-listen://127.0.0.1:10110")
        form = values.get("format")
        for key in _only(values, "transmit", "frames_per_second"):
            if form is None:
                self._wrong(f"{place}.{key}", "is for frames; say with format which form they have")
        for key in _only(values, *shaping.KEYS):
            if form is not None:
                self._wrong(f"{place}.{key}", "is for sentences; with a format there are frames alone")
        url = values.get("url", "")
        return Output(
            values.get("name") or url,
            url,
            form,
            **_only(values, "transmit", "frames_per_second"),
            selection=shaping.settle(values, place, False, self._wrong),
            bytes_per_second=values.get("bytes_per_second"),
        )

    def _inputs(self) -> tuple[Input, ...]:
        return tuple(self._input(number, table) for number, table in enumerate(self._lists.get("input", ()), 1))

    def _input(self, number: int, table: Table) -> Input:
        place = f"input[{number}]"
        values = self._values(place, table, self._kind.lists["input"])
        if "url" not in table:
            self._wrong(f"{place}.url", "missing; where the instruments are, like serial:///dev/ttyUSB0?baud=4800")
        hears = shaping.hearing(values, place, self._wrong)
        return Input(Port(values.get("name") or f"Input {number}", instrument=True, hears=hears), values.get("url", ""))

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
            "recording": _RECORDING,
            "web": _WEB,
            "mqtt": broker.KEYS,
            "network": _NETWORK,
            "signalk": signalk_settings.KEYS,
            "sources": source_settings.KEYS,
        },
        lists={
            "station": _STATION | {"shared": bool, "instruments": bool} | shaping.KEYS,
            "output": _OUTPUT | _FRAMES | shaping.KEYS,
            "input": _INPUT | shaping.HEARING_KEYS,
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
            "recording": _RECORDING,
            "web": _WEB,
            "mqtt": broker.KEYS,
            "network": _NETWORK,
        },
        lists={"station": _STATION, "output": _OUTPUT},
        settle=_Reader.rover,
    ),
}


def _kind(document: Table) -> Kind:
    """What the document says that it is about; a boat if it says nothing, or nothing known."""
    vehicle = document.get("vehicle")
    name = vehicle.get("kind") if isinstance(vehicle, dict) else None
    return KINDS.get(str(name), KINDS["boat"])


def _a_token() -> str:
    """A line that nobody guesses, to copy."""
    return f'token = "{secrets.token_urlsafe(15)}"'


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
