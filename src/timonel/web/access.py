"""Who may do what: the web is hostile.

role       who                                                                     may
(nobody)   whoever reaches the server                                              load the pages, sign in
reader     who knows the token                                                     see everything
station    who was paired with a station                                           command as that station
admin      whoever reaches a server without a token, which this computer alone can   be any station, pair others

A token is told once, at `login`, or as `Authorization: Bearer` by a program; a browser then has a cookie that no script
reads, sealed with a key of this computer's. Neither ever stands in a URL. Five failures a minute are let go through
from one address, on whatever way they come; after that nothing of it is looked at for the rest of the minute.

A request must name a host that is ours (DNS rebinding), and one that opens a socket or changes something must come
from a page of ours, or from no page at all.
"""

import base64
import binascii
import hashlib
import hmac
import ipaddress
import secrets
from collections.abc import Callable, Collection, Mapping
from enum import IntEnum
from typing import Any

import msgspec

from timonel.gateway.web_settings import Web
from timonel.web.messages import Role, You

COOKIE = "timonel"
COOKIE_AGE = 90 * 86400  # s
FAILURES, FAILURES_WINDOW = 5, 60.0
ADDRESSES_MAX = 10_000
LOOPBACK = ("localhost", "127.0.0.1", "::1")
BROWSER_TELLS = (b"origin", b"sec-fetch-site")

Headers = Mapping[bytes, bytes]


class Least(IntEnum):
    """The roles in order."""

    NOBODY = 0
    READER = 1
    STATION = 2
    ADMIN = 3


ROLES: dict[Least, Role] = {Least.READER: "reader", Least.STATION: "station", Least.ADMIN: "admin"}


class Rights(msgspec.Struct, frozen=True):
    """What somebody may: a role, and the stations that he may be."""

    least: Least
    stations: tuple[int, ...] = ()

    def you(self, station: int | None) -> You:
        """For himself. Raises KeyError for nobody."""
        return You(ROLES[self.least], station, list(self.stations))

    @property
    def only_station(self) -> int | None:
        """Whom he is when he does not say; None if he must choose, or may only look."""
        return self.stations[0] if self.least is Least.STATION and len(self.stations) == 1 else None


NOBODY = Rights(Least.NOBODY)


class Sealed(msgspec.Struct, frozen=True):
    """What a cookie says: the stations that its browser was paired with, and when it was given (unix s)."""

    stations: tuple[int, ...]
    given: int


class TooManyFailures(Exception):
    """Somebody at this address guesses; nothing of it is looked at for so many seconds."""

    def __init__(self, seconds: float) -> None:
        super().__init__(f"too many failures; try again in {seconds:.0f} s")
        self.seconds = seconds


class Failures:
    """Failed attempts by address, told the time in s."""

    def __init__(self) -> None:
        self._failures: dict[str, list[float]] = {}

    def check(self, address: str, now: float) -> None:
        """Raises TooManyFailures."""
        recent = self._recent(address, now)
        if len(recent) >= FAILURES:
            raise TooManyFailures(recent[-FAILURES] + FAILURES_WINDOW - now)

    def count(self, address: str, now: float) -> None:
        """One more."""
        if len(self._failures) >= ADDRESSES_MAX:
            self._failures = {each: recent for each in self._failures if (recent := self._recent(each, now))}
        self._failures[place_of(address)] = [*self._recent(address, now), now]

    def _recent(self, address: str, now: float) -> list[float]:
        return [each for each in self._failures.get(place_of(address), ()) if each > now - FAILURES_WINDOW]


def place_of(address: str) -> str:
    """Whose address it is: of IPv6 the network, since whoever has one address there has all of them."""
    try:
        ip = ipaddress.ip_address(address)
    except ValueError:
        return address
    return str(ipaddress.ip_network((ip, 64), strict=False)) if ip.version == 6 else address


class Access:
    """Knows who somebody is. `key` seals cookies; `clock` is monotonic, `wall` unix time, both in s."""

    def __init__(self, web: Web, key: bytes, clock: Callable[[], float], wall: Callable[[], float]) -> None:
        self.web = web
        self.failures = Failures()
        self._clock = clock
        self._wall = wall
        self._key = hashlib.blake2b(digest(web.token or ""), key=key, person=b"timonel console"[:16]).digest()

    @property
    def open(self) -> bool:
        """Whether no token is needed."""
        return self.web.token is None

    def who(self, headers: Headers, address: str) -> Rights:
        """Whose request it is. Raises TooManyFailures."""
        if self.open:
            return Rights(Least.ADMIN, self.web.stations)
        bearer = headers.get(b"authorization", b"")
        if bearer:
            scheme, _, token = bearer.partition(b" ")
            right = scheme.lower() == b"bearer" and self.knows(token.strip().decode("latin-1"), address)
            if not right:
                return NOBODY
        sealed = self._unseal(cookie(headers, COOKIE))
        if sealed is None:
            return Rights(Least.READER) if bearer else NOBODY
        stations = tuple(station for station in sealed.stations if station in self.web.stations)
        return Rights(Least.STATION if stations else Least.READER, stations)

    def knows(self, token: str, address: str) -> bool:
        """Whether somebody at an address knows the token; failures are counted. Raises TooManyFailures."""
        self.check(address)
        right = self.web.token is None or hmac.compare_digest(digest(token), digest(self.web.token))
        if not right:
            self.failed(address)
        return right

    def check(self, address: str) -> None:
        """Raises TooManyFailures for an address that guesses."""
        self.failures.check(address, self._clock())

    def failed(self, address: str) -> None:
        """Somebody at an address guessed wrong."""
        self.failures.count(address, self._clock())

    # Cookies ------------------------------------------------------------------------------------------

    def seal(self, stations: Collection[int]) -> str:
        """A `Set-Cookie` that lets a browser see, and be these stations."""
        told = msgspec.json.encode(Sealed(tuple(sorted(stations)), int(self._wall())))
        value = f"{_text(told)}.{_text(self._mac(told))}"
        return f"{COOKIE}={value}; Max-Age={COOKIE_AGE}; {self._attributes}"

    def forget(self) -> str:
        """A `Set-Cookie` that takes it back."""
        return f"{COOKIE}=; Max-Age=0; {self._attributes}"

    @property
    def _attributes(self) -> str:
        return "Path=/; HttpOnly; SameSite=Strict" + ("; Secure" if self.web.certificate else "")

    def _mac(self, told: bytes) -> bytes:
        return hashlib.blake2b(told, key=self._key, digest_size=32).digest()

    def _unseal(self, value: str) -> Sealed | None:
        told, _, mac = value.partition(".")
        try:
            said, seal = _bytes(told), _bytes(mac)
            if not hmac.compare_digest(self._mac(said), seal):
                return None
            sealed = msgspec.json.decode(said, type=Sealed)
        except (ValueError, binascii.Error):
            return None
        return sealed if self._wall() < sealed.given + COOKIE_AGE else None

    # Where from ---------------------------------------------------------------------------------------

    def is_ours(self, host: str, own_address: str | None) -> bool:
        """Whether a Host header names us: an address of ours, this computer, or a name of the configuration."""
        name = host_name(host)
        known = (*LOOPBACK, self.web.host, own_address, *self.web.hosts)
        return name is not None and name in {each.lower() for each in known if each and each not in ("0.0.0.0", "::")}

    def is_from_us(self, headers: Headers) -> bool:
        """Whether a request comes from a page of ours, or from a program that is no browser."""
        origin = headers.get(b"origin")
        if origin is not None:
            scheme, _, host = origin.decode("latin-1").lower().partition("://")
            return scheme in ("http", "https") and host == headers.get(b"host", b"").decode("latin-1").lower()
        return headers.get(b"sec-fetch-site", b"same-origin") == b"same-origin"


def host_name(host: str) -> str | None:
    """The name in a Host header, in small letters without its port; None if it is none."""
    host = host.lower()
    if host.startswith("["):
        name, bracket, port = host[1:].partition("]")
        port = port.removeprefix(":") if bracket else "?"
    else:
        name, _, port = host.partition(":")
    return name if name and (not port or port.isdecimal()) else None


def cookie(headers: Headers, name: str) -> str:
    """A cookie's value, "" without."""
    for part in headers.get(b"cookie", b"").decode("latin-1").split(";"):
        key, _, value = part.strip().partition("=")
        if key == name:
            return value
    return ""


def digest(text: str) -> bytes:
    """What tells two secrets apart in a time that does not tell where they differ."""
    return hashlib.sha256(text.encode()).digest()


def new_key() -> bytes:
    """Nobody knows it."""
    return secrets.token_bytes(32)


def _text(data: bytes) -> str:
    return base64.urlsafe_b64encode(data).decode().rstrip("=")


def _bytes(text: str) -> bytes:
    return base64.b64decode(text.encode() + b"=" * (-len(text) % 4), altchars=b"-_", validate=True)


def headers_of(scope: Mapping[str, Any]) -> dict[bytes, bytes]:
    """The headers of a request; of one that comes twice the last."""
    return dict(scope["headers"])
