"""From a configuration to a gateway that can be opened."""

import asyncio
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import msgspec

from timonel.gateway.configuration import Configuration
from timonel.gateway.frame_output import FrameOutput, FrameOutputs
from timonel.gateway.gateway import Channel, Gateway
from timonel.gateway.link_settings import Output, Station
from timonel.gateway.moment import moment
from timonel.gateway.shaping import shaped
from timonel.gateway.variation import variation
from timonel.links.inner import InnerLink
from timonel.links.link import BusLink, ByteLink
from timonel.links.shaped import Shaped
from timonel.links.uart_bus import UartBus
from timonel.links.urls import bus_link, byte_link, commanding_link, with_default
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.vehicle import Boat
from timonel.vehicles.rover.declaration import Party
from timonel.vehicles.rover.framing import DIALECTS
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.settings import Port as RoverPort
from timonel.vehicles.rover.settings import RoverSettings
from timonel.vehicles.rover.vehicle import Rover
from timonel.vehicles.vehicle import Vehicle

ROVER_BITRATE = 500_000

Watched = dict[str, Callable[[], Mapping[str, int]]]
"""Counters for health, by name."""


def boat(settings: BoatSettings, ports: list[Port], now: float) -> Boat:
    """The machine of a boat, with the World Magnetic Model if its owner wants it."""
    return Boat(settings, ports, now, variation if settings.variation_model else None)


def rover(settings: RoverSettings, ports: list[Port], now: float, protocol: Protocol) -> Rover:
    """The machine of a rover."""
    bound = [
        RoverPort(port.name, port.station, port.console)
        for port in ports
        if port.station is not None  # of a rover it never is
    ]
    return Rover(settings, bound, now, protocol)


def assemble(configuration: Configuration) -> Gateway:
    """A gateway on the running loop with all links made and none opened. Raises LinkError."""
    now = moment(asyncio.get_running_loop().time())
    match configuration.vehicle:
        case BoatSettings() as settings:
            vehicle, bus, watched = _boat(configuration, settings, now)
        case RoverSettings() as settings:
            vehicle, bus, watched = _rover(configuration, settings, now)
    raw = isinstance(configuration.vehicle, RoverSettings)
    channels = [_station(station, raw) for station in configuration.stations]
    channels += [_output(output, raw) for output in configuration.outputs if output.form is None]
    channels += [Channel(port.name, _link(url, port.name, raw), None) for port, url in configuration.instrument_urls]
    channels += [Channel(port.name, InnerLink(name=port.name), None) for port in configuration.inner_ports]
    gateway = Gateway(vehicle, bus, channels, flush=configuration.flush, began=now)
    watched |= {
        f"{link.name} skipped": partial(getattr, link, "skipped") for link in gateway.links if isinstance(link, Shaped)
    }
    for name, counters in watched.items():
        gateway.health.watch(name, counters)
    if isinstance(vehicle, Boat) and (told := _frame_outputs(configuration.outputs)):
        FrameOutputs(gateway, told, lambda: vehicle.address)
    return gateway


def _frame_outputs(outputs: Sequence[Output]) -> list[FrameOutput]:
    return [
        FrameOutput(byte_link(output.url, name=output.name), output.form, output.transmit, output.frames_per_second)
        for output in outputs
        if output.form is not None
    ]


def _boat(configuration: Configuration, settings: BoatSettings, now: float) -> tuple[Vehicle, BusLink, Watched]:
    vehicle = boat(settings, configuration.ports, now)
    watched: Watched = {
        "boat": lambda: vehicle.counters,
        "node": lambda: vehicle.node.counters,
        "fast packet": lambda: msgspec.structs.asdict(vehicle.fast_packets),
    }
    return vehicle, bus_link(configuration.bus_url, name="bus"), watched


def _rover(configuration: Configuration, settings: RoverSettings, now: float) -> tuple[Vehicle, BusLink, Watched]:
    protocol = configuration.protocol or Protocol()
    vehicle = rover(settings, configuration.ports, now, protocol)
    watched: Watched = {"rover": lambda: vehicle.counters}
    watched |= {f"{port} framing": partial(_framing, vehicle, port) for port in vehicle.framing()}
    return vehicle, _rover_bus(configuration.bus_url, settings, protocol), watched


def _rover_bus(url: str, settings: RoverSettings, protocol: Protocol) -> BusLink:
    """A CAN bus; in the role `operator` the UART of a controller that drives."""
    if settings.role == "controller":
        return bus_link(with_default(url, "bitrate", str(ROVER_BITRATE)), name="bus")
    framer = DIALECTS[settings.dialect](protocol.lengths(Party.OPERATOR), settings.idle)
    return UartBus(commanding_link(with_default(url, "raw", "yes"), name="bus"), framer)


def _framing(vehicle: Rover, port: str) -> Mapping[str, int]:
    return Counter(msgspec.structs.asdict(vehicle.framing()[port].counters))


def _station(station: Station, raw: bool) -> Channel:
    name = station.port.name
    receive = _link(station.receive_url, name, raw)
    one_link = station.send_url == station.receive_url
    send = receive if one_link else _link(station.send_url, f"{name} OUT", raw)
    if send is not None and not raw:
        send = shaped(send, station.selection, station.bytes_per_second, station=True)
    return Channel(name, send if one_link else receive, send)


def _output(output: Output, raw: bool) -> Channel:
    link = _link(output.url, output.name, raw)
    if link is not None and not raw:
        link = shaped(link, output.selection, output.bytes_per_second, station=False)
    return Channel(output.name, None, link)


def _link(url: str | None, name: str, raw: bool) -> ByteLink | None:
    """A port; with `raw` for frames instead of lines."""
    if url is None:
        return None
    return byte_link(with_default(url, "raw", "yes") if raw else url, name=name)
