"""Which MQTT broker is told, and what it may ask for: the table `[mqtt]` of a configuration, understood."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any
from urllib.parse import unquote, urlsplit

import msgspec

from timonel.gateway.extras import mqtt_installed
from timonel.gateway.places import is_loopback

DISCOVERY = "homeassistant"
INTERVAL = 1.0  # s
PORTS = {"mqtt": 1883, "mqtts": 8883}
TOPIC_LENGTH = 200  # characters, so that no topic comes near the 65535 bytes of the protocol
NOT_PLAIN = re.compile(r"[^a-z0-9]+")
KEYS: dict[str, Any] = {
    "enabled": bool,
    "url": str,
    "user": str,
    "password_file": str,
    "authorities": str,
    "base": str,
    "interval": Annotated[float, msgspec.Meta(ge=0.1, le=3600)],
    "discovery": bool | str,
    "station": Annotated[int, msgspec.Meta(ge=1, le=4)],
}


class Place(msgspec.Struct, frozen=True):
    """Where a broker is, as its URL says; `user` and `password` None where it says none."""

    host: str
    port: int
    encrypted: bool
    user: str | None = None
    password: str | None = None


class Mqtt(msgspec.Struct, frozen=True):
    """The broker that is told how the vehicle is, under the topic `base`, at most every `interval` s.

    `authorities` is the PEM file of those who may vouch for a broker with TLS, None for the system's. `discovery` is
    the topic at which Home Assistant looks for devices, None for no such thing. Orders are taken as `station`; None:
    from nobody.
    """

    place: Place
    base: str
    interval: float = INTERVAL
    authorities: str | None = None
    discovery: str | None = DISCOVERY
    station: int | None = None


def broker_place(url: str) -> Place:
    """What a broker's URL says; raises ValueError that says what would be right, and no password."""
    parts = urlsplit(url)
    try:
        port = parts.port
    except ValueError:
        port = 0
    extra = (parts.path.strip("/"), parts.query, parts.fragment) != ("", "", "")
    if parts.scheme not in PORTS or not parts.hostname or port == 0 or extra:
        raise ValueError('should be like "mqtt://127.0.0.1:1883", or "mqtts://broker.example" with TLS')
    return Place(
        parts.hostname,
        port or PORTS[parts.scheme],
        parts.scheme == "mqtts",
        None if parts.username is None else unquote(parts.username),
        None if parts.password is None else unquote(parts.password),
    )


def plain(name: str) -> str:
    """A name as a level of a topic: small letters, digits and underscores."""
    return NOT_PLAIN.sub("_", name.lower()).strip("_") or "vehicle"


def topic(text: str) -> str:
    """A topic to publish at; raises ValueError for what is none."""
    wild = any(sign in text for sign in "+#\0")
    if not text or wild or text.startswith(("/", "$")) or text.endswith("/") or len(text) > TOPIC_LENGTH:
        raise ValueError(f'"{text}" should be a topic like "boat/alisea", without + and #')
    return text


class _Reader:
    """Makes the settings of a table's sound values; `wrong` is told of what is not right."""

    def __init__(self, values: Mapping[str, Any], directory: Path, wrong: Callable[[str, str], None]) -> None:
        self._values = values
        self._directory = directory
        self._wrong = wrong

    def mqtt(self, name: str) -> Mqtt:
        """Under the name of the vehicle, if nothing else is said."""
        discovery = self._values.get("discovery", True)
        mqtt = Mqtt(
            place=self._place(),
            base=self._topic("base", self._values.get("base", f"timonel/{plain(name)}")),
            interval=self._values.get("interval", INTERVAL),
            authorities=self._file("authorities"),
            discovery=self._topic("discovery", DISCOVERY if discovery is True else discovery) if discovery else None,
            station=self._values.get("station"),
        )
        if mqtt.station is not None and mqtt.place.user is None and not is_loopback(mqtt.place.host):
            self._wrong(
                "mqtt.station",
                f"whoever reaches {mqtt.place.host} could command as this station: let the broker know its users, "
                "and give user and password_file",
            )
        return mqtt

    def _place(self) -> Place:
        try:
            place = broker_place(self._values["url"])
        except KeyError:
            self._wrong("mqtt.url", 'missing; where the broker is, like "mqtt://127.0.0.1:1883"')
            return Place("127.0.0.1", PORTS["mqtt"], False)
        except ValueError as fault:
            self._wrong("mqtt.url", str(fault))
            return Place("127.0.0.1", PORTS["mqtt"], False)
        user = self._values.get("user", place.user)
        return msgspec.structs.replace(place, user=user, password=self._password(place))

    def _password(self, place: Place) -> str | None:
        """The first line of its file; else what stands in the URL."""
        path = self._file("password_file")
        if path is None:
            return place.password
        try:
            return Path(path).read_text().partition("\n")[0].strip()
        except (OSError, UnicodeDecodeError) as fault:
            reason = fault.strerror if isinstance(fault, OSError) else "not text"
            self._wrong("mqtt.password_file", f"{path}: {reason}")
            return None

    def _file(self, key: str) -> str | None:
        path = self._values.get(key)
        return None if path is None else str(self._directory / path)

    def _topic(self, key: str, text: str) -> str:
        try:
            return topic(text)
        except ValueError as fault:
            self._wrong(f"mqtt.{key}", str(fault))
            return DISCOVERY


def settle(values: Mapping[str, Any], name: str, directory: Path, wrong: Callable[[str, str], None]) -> Mqtt:
    """What the sound values of the table mean for a vehicle called `name`; files are beside the configuration."""
    if not mqtt_installed():
        wrong("mqtt", "needs aiomqtt: pip install timonel[mqtt]")
    return _Reader(values, directory, wrong).mqtt(name)
