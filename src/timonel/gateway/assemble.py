"""From a configuration to a gateway that can be opened."""

import asyncio

import msgspec

from timonel.gateway.configuration import Configuration, Output, Station
from timonel.gateway.gateway import Channel, Gateway
from timonel.gateway.variation import variation
from timonel.links.link import ByteLink
from timonel.links.urls import bus_link, byte_link
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.vehicle import Boat


def boat(settings: BoatSettings, ports: list[Port], now: float) -> Boat:
    """The machine of a boat, with the World Magnetic Model if its owner wants it."""
    return Boat(settings, ports, now, variation if settings.variation_model else None)


def assemble(configuration: Configuration) -> Gateway:
    """A gateway on the running loop with all links made and none opened. Raises LinkError."""
    ports = [station.port for station in configuration.stations]
    vehicle = boat(configuration.vehicle, ports, asyncio.get_running_loop().time())
    channels = [_station(station) for station in configuration.stations]
    channels += [_output(output) for output in configuration.outputs]
    bus = bus_link(configuration.bus_url, name="bus")
    gateway = Gateway(vehicle, bus, channels, flush=configuration.flush)
    gateway.health.watch("boat", lambda: vehicle.counters)
    gateway.health.watch("fast packet", lambda: msgspec.structs.asdict(vehicle.fast_packets))
    return gateway


def _station(station: Station) -> Channel:
    name = station.port.name
    receive = _link(station.receive_url, name)
    if station.send_url == station.receive_url:
        return Channel(name, receive, receive)
    return Channel(name, receive, _link(station.send_url, f"{name} OUT"))


def _output(output: Output) -> Channel:
    return Channel(output.name, None, byte_link(output.url, name=output.name))


def _link(url: str | None, name: str) -> ByteLink | None:
    return None if url is None else byte_link(url, name=name)
