"""Where the console is served, and to whom: the table `[web]` of a configuration, understood."""

import secrets
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any

import msgspec

from timonel.gateway.extras import web_installed
from timonel.gateway.places import is_loopback, place

STATION_IDS = (1, 2, 3, 4)
CONSOLE_AT = "127.0.0.1:8080"
TOKEN_LENGTH = 12  # characters that a token has at least
KEYS: dict[str, Any] = {
    "enabled": bool,
    "listen": str,
    "token": Annotated[str, msgspec.Meta(min_length=TOKEN_LENGTH)],
    "certificate": str,
    "key": str,
    "hosts": list[str],
    "stations": list[Annotated[int, msgspec.Meta(ge=1, le=4)]],
    "tiles": str,
}


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


def settle(
    values: Mapping[str, Any], has_token: bool, beside: Path, wrong: Callable[[str, str], object]
) -> Web:  # fmt: skip
    """What the table says, of which `values` are right; files stand `beside` the configuration.

    `has_token` is whether a token stands there, right or not.
    """
    if not web_installed():
        wrong("web", "needs starlette, uvicorn and websockets: pip install timonel[web]")
    try:
        host, port = place(values.get("listen", CONSOLE_AT))
    except ValueError as fault:
        wrong("web.listen", str(fault))
        return Web()
    if not is_loopback(host) and not has_token:
        wrong("web.token", f"missing; {host} is not this computer alone: say who may see, like {_a_token()}")
    if ("key" in values) != ("certificate" in values):
        wrong("web", "certificate and key go together")
    files = {key: str(beside / values[key]) for key in ("certificate", "key", "tiles") if key in values}
    if "tiles" in files and not Path(files["tiles"]).is_dir():
        wrong("web.tiles", f"{files['tiles']} is no directory of map tiles, z/x/y.png")
    stations = tuple(sorted(set(values.get("stations", STATION_IDS))))
    return Web(host, port, values.get("token"), hosts=tuple(values.get("hosts", ())), stations=stations, **files)


def _a_token() -> str:
    """A line that nobody guesses, to copy."""
    return f'token = "{secrets.token_urlsafe(15)}"'
