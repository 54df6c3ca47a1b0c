"""Who tells Signal K what, and under which name: the table `[signalk]` of a configuration, understood."""

import hashlib
import uuid
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any
from urllib.parse import urlsplit

import msgspec

from timonel.errors import LinkError
from timonel.gateway.extras import web_installed
from timonel.links import urls

KEYS: dict[str, Any] = {
    "tcp": str,
    "push": str,
    "token": Annotated[str, msgspec.Meta(min_length=1)],
    "station": Annotated[int, msgspec.Meta(ge=1, le=4)],
    "mmsi": Annotated[str, msgspec.Meta(pattern="^[2-7][0-9]{8}$")],
    "uuid": str,
}
STREAM = "/signalk/v1/stream"
MACHINE = Path("/etc/machine-id")

Wrong = Callable[[str, str], None]


class SignalK(msgspec.Struct, frozen=True):
    """Where deltas go, and who the boat is.

    `tcp` is the URL of a port whose far end reads lines, `push` the stream of a server that takes deltas, with the
    `token` of one who may write. Who may be several stations is `station` where the autopilot API does not say.
    """

    tcp: str | None = None
    push: str | None = None
    token: str | None = None
    station: int | None = None
    urn: str | None = None


def settle(values: Mapping[str, Any], wrong: Wrong) -> SignalK:
    """What the sound `values` of the table mean; what is wrong is told with its key."""
    if "mmsi" in values and "uuid" in values:
        wrong("signalk.uuid", "the boat has an mmsi already; leave out one of them")
    if "token" in values and "push" not in values:
        wrong("signalk.token", "is for push, the server that takes deltas; the console's own is in [web]")
    return SignalK(
        tcp=_tcp(values.get("tcp"), wrong),
        push=_push(values.get("push"), wrong),
        token=values.get("token"),
        station=values.get("station"),
        urn=_urn(values, wrong),
    )


def _tcp(url: str | None, wrong: Wrong) -> str | None:
    if url is None:
        return None
    if url.partition("://")[0] not in ("tcp-listen", "tcp"):
        wrong("signalk.tcp", f'"{url}" should be like "tcp-listen://127.0.0.1:8375"')
        return None
    try:
        urls.check(url, "bytes")
    except LinkError as fault:
        wrong("signalk.tcp", str(fault))
        return None
    return url


def _push(url: str | None, wrong: Wrong) -> str | None:
    """The URL of the stream: what stands for the whole of a server is completed."""
    if url is None:
        return None
    if not web_installed():
        wrong("signalk.push", "needs websockets: pip install timonel[web]")
    parts = urlsplit(url)
    try:
        sound = parts.scheme in ("ws", "wss") and parts.hostname and parts.port != 0
    except ValueError:
        sound = False
    if not sound or parts.query or parts.fragment or parts.username is not None:
        wrong("signalk.push", f'"{url}" should be like "ws://127.0.0.1:3000"')
        return None
    return url if parts.path.strip("/") else f"{parts.scheme}://{parts.netloc}{STREAM}"


def _urn(values: Mapping[str, Any], wrong: Wrong) -> str | None:
    if mmsi := values.get("mmsi"):
        return f"urn:mrn:imo:mmsi:{mmsi}"
    text = values.get("uuid")
    if text is None:
        return None
    try:
        known = uuid.UUID(text)
    except ValueError:
        known = uuid.NAMESPACE_DNS  # of version 1
    if known.version != 4:
        wrong("signalk.uuid", f'"{text}" is no UUID of version 4, like "{uuid.uuid4()}"')
        return None
    return f"urn:mrn:signalk:uuid:{known}"


def own_urn(name: str) -> str:
    """Who a boat is that has not been told: the same one as long as it has this name on this computer."""
    try:
        machine = MACHINE.read_bytes()
    except OSError:
        machine = b""
    seed = hashlib.blake2b(name.encode(), key=hashlib.sha256(machine).digest(), digest_size=16)
    return f"urn:mrn:signalk:uuid:{uuid.UUID(bytes=seed.digest(), version=4)}"
