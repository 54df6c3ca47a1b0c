"""Services by name on the local network (mDNS and DNS-SD, RFC 6762 and 6763), so that programs find them untold.

```
_nmea-0183._tcp                    [[output]] over tcp-listen with sentences; no station, which could command
_http._tcp  (_https)               the console
_signalk-http._tcp  (-https)       the console's Signal K server: REST
_signalk-ws._tcp  (-wss)           the same: deltas
_signalk-tcp._tcp                  [signalk] tcp
```
Only what other computers can reach is told, and nothing for another port than the configuration has. It is told in the
background, since names are asked for before they are taken, which takes a second; it is taken back at the end.
Source: signalk.org/specification 1.7.0, "Discovery and Connection Establishment".
"""

import asyncio
import logging
import socket
from collections import Counter
from collections.abc import AsyncIterator, Iterator, Sequence
from contextlib import asynccontextmanager
from ipaddress import ip_address
from typing import TYPE_CHECKING, Any

import msgspec

from timonel import __version__
from timonel.gateway.configuration import Configuration
from timonel.gateway.places import is_loopback
from timonel.gateway.signalk_settings import own_urn
from timonel.interop.signalk.told import OWN
from timonel.links import urls
from timonel.vehicles.boat.settings import BoatSettings

if TYPE_CHECKING:
    from zeroconf.asyncio import AsyncZeroconf

AGAIN = 30.0  # s until a network that is not there is tried once more
END_WITHIN = 2.0  # s
LABEL = 63  # bytes of a name (RFC 1035)
EVERYWHERE = ("0.0.0.0", "::")

logger = logging.getLogger("timonel")


class Service(msgspec.Struct, frozen=True):
    """A service as it is told: its `kind` like `_http._tcp`, where it listens, and what is said about it."""

    kind: str
    name: str
    host: str
    port: int
    about: dict[str, str] = {}


def services(configuration: Configuration) -> list[Service]:
    """What of a gateway other computers can reach, each under a name of its own."""
    reachable = [each for each in _services(configuration) if each.port and not is_loopback(each.host)]
    count: Counter[tuple[str, str]] = Counter()
    named = []
    for each in reachable:
        name = each.name.encode()[: LABEL - 5].decode(errors="ignore")
        count[each.kind, name] += 1
        number = count[each.kind, name]
        named.append(msgspec.structs.replace(each, name=name if number == 1 else f"{name} ({number})"))
    return named


def _services(configuration: Configuration) -> Iterator[Service]:
    vehicle = configuration.vehicle.name
    for output in configuration.outputs:
        if isinstance(configuration.vehicle, BoatSettings) and output.form is None:
            yield from _listening(output.url, "_nmea-0183._tcp", vehicle, {})
    about = _about_signalk(configuration)
    if (web := configuration.web) is not None:
        secure = "s" if web.certificate else ""
        yield Service(f"_http{secure}._tcp", vehicle, web.host, web.port, {"path": "/"})
        if about:
            yield Service(f"_signalk-http{secure}._tcp", vehicle, web.host, web.port, about)
            yield Service(f"_signalk-ws{secure}._tcp", vehicle, web.host, web.port, about)
    if configuration.signalk is not None and configuration.signalk.tcp is not None:
        yield from _listening(configuration.signalk.tcp, "_signalk-tcp._tcp", vehicle, about)


def _listening(url: str, kind: str, name: str, about: dict[str, str]) -> Iterator[Service]:
    if url.startswith("tcp-listen://"):
        place = urls.parse(url).values
        yield Service(kind, name, str(place["host"]), int(place["port"] or 0), about)


def _about_signalk(configuration: Configuration) -> dict[str, str]:
    if not isinstance(configuration.vehicle, BoatSettings):
        return {}
    name = configuration.vehicle.name
    urn = (configuration.signalk.urn if configuration.signalk is not None else None) or own_urn(name)
    return {
        "txtvers": "1",
        "roles": "master, main",
        "self": urn,
        "swname": OWN,
        "swvers": __version__,
        "vname": name,
    }


@asynccontextmanager
async def announced(configuration: Configuration) -> AsyncIterator[None]:
    """While it is entered, other computers find what they can reach, if the configuration wants that."""
    told = services(configuration) if configuration.mdns else []
    if not told:
        if configuration.mdns:
            logger.info("mDNS: nothing to tell: all that listens does so for this computer alone")
        yield
        return
    announcer = Announcer(told)
    announcing = asyncio.create_task(announcer.run(), name="mDNS")
    try:
        yield
    finally:
        announcing.cancel()
        await asyncio.gather(announcing, return_exceptions=True)
        await announcer.close()


class Announcer:
    """Tells of services on `interfaces`, by their addresses; None: on all."""

    def __init__(self, told: Sequence[Service], interfaces: Sequence[str] | None = None) -> None:
        self._told = told
        self._interfaces = interfaces
        self._network: AsyncZeroconf | None = None

    async def run(self) -> None:
        """Until all are told, and names are theirs."""
        while not await self._try():
            await asyncio.sleep(AGAIN)

    async def _try(self) -> bool:
        from zeroconf import Error
        from zeroconf.asyncio import AsyncZeroconf

        choice: dict[str, Any] = {} if self._interfaces is None else {"interfaces": list(self._interfaces)}
        try:
            self._network = AsyncZeroconf(**choice)
            for service in self._told:
                await self._network.async_register_service(await self._info(service), allow_name_change=True)
        except (OSError, Error) as fault:
            logger.warning("mDNS: %s; tried again in %g s", fault, AGAIN)
            await self.close()
            return False
        kinds = ", ".join(dict.fromkeys(service.kind for service in self._told))
        logger.info("mDNS: %s", kinds, extra={"fields": {"event": "mdns", "kinds": kinds}})
        return True

    async def _info(self, service: Service) -> Any:
        from zeroconf import ServiceInfo

        return ServiceInfo(
            f"{service.kind}.local.",
            f"{service.name}.{service.kind}.local.",
            port=service.port,
            properties=service.about,
            server=f"{OWN}-{socket.gethostname().partition('.')[0]}.local.",
            parsed_addresses=await self._addresses(service.host),
        )

    async def _addresses(self, host: str) -> list[str]:
        if self._interfaces is not None:
            return list(self._interfaces)
        if host in EVERYWHERE:
            return own_addresses()
        found = await asyncio.get_running_loop().getaddrinfo(host, None, type=socket.SOCK_STREAM)
        return list(dict.fromkeys(str(address[0]) for *_, address in found))

    async def close(self) -> None:
        """Take it all back."""
        network, self._network = self._network, None
        if network is not None:
            try:
                async with asyncio.timeout(END_WITHIN):
                    await network.async_unregister_all_services()
                    await network.async_close()
            except TimeoutError:
                logger.warning("mDNS: could not be taken back within %g s", END_WITHIN)


def own_addresses() -> list[str]:
    """The addresses of this computer that others may reach it at."""
    import ifaddr

    found = [ip.ip if isinstance(ip.ip, str) else ip.ip[0] for each in ifaddr.get_adapters() for ip in each.ips]
    return [text for text in found if not (ip_address(text).is_loopback or ip_address(text).is_link_local)]
