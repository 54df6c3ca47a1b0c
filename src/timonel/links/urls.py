"""The URLs of links: which schemes there are, what each may say, and the link that one means.

```
bytes    serial  pty  tcp  tcp-listen  udp
frames   socketcan  slcan  can+<interface of python-can>  loop  file
```
To check a URL loads none of the transports, only their names and the rules below; `docs/links.md` describes
each.
"""

from collections.abc import Callable, Iterable
from importlib import import_module
from importlib.util import find_spec
from typing import Literal, cast
from urllib.parse import SplitResult, parse_qsl, unquote, urlsplit

import msgspec

from timonel.errors import LinkError
from timonel.links.link import BusLink, ByteLink

Carries = Literal["bytes", "frames"]
Value = str | int | float | bool | None
Values = dict[str, Value]

COMMAND_AGE = 0.5  # s that a command may wait to be sent
BITRATES = (10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000)


class Scheme(msgspec.Struct, frozen=True):
    """What stands behind one scheme: `place` reads host or path, `parameters` the query."""

    carries: Carries
    maker: str
    place: Callable[[SplitResult], Values]
    parameters: dict[str, Callable[[str], Value]] = {}


class Address(msgspec.Struct, frozen=True):
    """A URL that was understood."""

    url: str
    carries: Carries
    maker: str
    values: Values


def link(url: str, *, name: str = "") -> ByteLink | BusLink:
    """The link that a URL means, not opened yet; `name` is what it is called in logs. Raises LinkError."""
    address = parse(url)
    module, _, maker = address.maker.partition(":")
    make = getattr(import_module(module), maker)
    return cast(ByteLink | BusLink, make(url=url, name=name, **address.values))


def byte_link(url: str, *, name: str = "") -> ByteLink:
    """`link` for a port; raises LinkError for the URL of a bus too."""
    check(url, "bytes")
    return cast(ByteLink, link(url, name=name))


def commanding_link(url: str, *, name: str = "") -> ByteLink:
    """`byte_link` for who commands: what could not go out within half a second is dropped, never sent late."""
    from timonel.links.wire import Port

    made = byte_link(url, name=name)
    if isinstance(made, Port):
        made.stale_after = COMMAND_AGE
    return made


def bus_link(url: str, *, name: str = "") -> BusLink:
    """`link` for a bus; raises LinkError for the URL of a port too."""
    check(url, "frames")
    return cast(BusLink, link(url, name=name))


def check(url: str, carries: Carries) -> None:
    """Raises LinkError if `url` is not one of a link that carries this; opens nothing."""
    if parse(url).carries != carries:
        wanted = "a port" if carries == "bytes" else "a bus"
        fitting = ", ".join(name for name, scheme in SCHEMES.items() if scheme.carries == carries)
        raise LinkError(f"{url}: not the URL of {wanted} ({wanted} is one of {fitting})")


def with_default(url: str, key: str, value: str) -> str:
    """`url` with a parameter that it leaves to the default, if its scheme has such a one. Raises LinkError."""
    parse(url)
    query = url.partition("?")[2]
    if key not in _scheme(url.partition("://")[0]).parameters or key in dict(parse_qsl(query)):
        return url
    return f"{url}{'&' if '?' in url else '?'}{key}={value}"


def parse(url: str) -> Address:
    """Understand a URL; raises LinkError that says what is wrong in it."""
    name, separator, rest = url.partition("://")
    if not separator:
        raise LinkError(f'"{url}" is not a URL (one looks like serial:///dev/ttyUSB0)')
    scheme = _scheme(name)
    try:
        parts = urlsplit("//" + rest, allow_fragments=False)
        values = scheme.place(parts) | _parameters(scheme, parts.query)
    except (LinkError, ValueError) as fault:
        raise LinkError(f"{url}: {fault}") from None
    if name.startswith("can+"):
        values["interface"] = name.removeprefix("can+")
    return Address(url, scheme.carries, scheme.maker, values)


def _scheme(name: str) -> Scheme:
    if name.startswith("can+"):
        _check_interface(name.removeprefix("can+"))
        return PYTHON_CAN
    if name not in SCHEMES:
        raise LinkError(f'unknown scheme "{name}"{_did_you_mean(name, SCHEMES)}')
    return SCHEMES[name]


def _check_interface(interface: str) -> None:
    if find_spec("can") is None:
        raise LinkError(f"can+{interface} needs python-can: pip install timonel[can]")
    known: Iterable[str] = import_module("can.interfaces").VALID_INTERFACES
    if interface not in known:
        raise LinkError(f'python-can has no interface "{interface}"{_did_you_mean(interface, known)}')


def _did_you_mean(word: str, known: Iterable[str]) -> str:
    from difflib import get_close_matches

    near = get_close_matches(word, list(known), n=1)
    return f' (did you mean "{near[0]}"?)' if near else ""


def _parameters(scheme: Scheme, query: str) -> Values:
    values: Values = {}
    for key, text in parse_qsl(query, keep_blank_values=True, strict_parsing=bool(query)):
        if key in values:
            raise LinkError(f"{key} is given twice")
        values[key] = _parameter(scheme, key, text)
    return values


def _parameter(scheme: Scheme, key: str, text: str) -> Value:
    if scheme is PYTHON_CAN:
        return _as_it_is(text)
    if key not in scheme.parameters:
        raise LinkError(f'unknown parameter "{key}"{_did_you_mean(key, scheme.parameters)}')
    try:
        return scheme.parameters[key](text)
    except ValueError as fault:
        raise LinkError(f'{key}: "{text}" {fault}') from None


# Where: what stands between "://" and "?"


def _path(parts: SplitResult) -> Values:
    if not (path := unquote(parts.netloc + parts.path)):
        raise LinkError("a path is missing")
    if "\0" in path:
        raise LinkError("a path cannot hold a NUL")
    return {"path": path}


def _channel(parts: SplitResult) -> Values:
    return {"channel": _path(parts)["path"]}


def _numbered_channel(parts: SplitResult) -> Values:
    return {"channel": _as_it_is(str(_path(parts)["path"]))}


def _interface(parts: SplitResult) -> Values:
    channel = str(_path(parts)["path"])
    if len(channel) > 15 or "/" in channel:
        raise LinkError(f'"{channel}" cannot be the name of an interface')
    return {"channel": channel}


def _host_and_port(parts: SplitResult, lowest: int = 1) -> Values:
    if parts.path not in ("", "/") or parts.username is not None:
        raise LinkError("only host and port can stand here")
    if not parts.hostname:
        raise LinkError("a host is missing (127.0.0.1 is this machine alone, 0.0.0.0 all its networks)")
    parts.hostname.encode("idna")  # what a resolver would trip over: ValueError
    return {"host": parts.hostname, "port": _port(parts, lowest)}


def _listening(parts: SplitResult) -> Values:
    return _host_and_port(parts, lowest=0)


def _host_or_port(parts: SplitResult) -> Values:
    if parts.netloc.startswith(":"):
        return {"host": None, "port": _port(parts, 0)}
    return _host_and_port(parts)


def _port(parts: SplitResult, lowest: int) -> int:
    if parts.port is None:
        raise LinkError("a port is missing (host:port)")
    if parts.port < lowest:
        raise LinkError(f"port {parts.port} is below {lowest}")
    return parts.port


# How: what a parameter may be; each raises ValueError with the end of the sentence `key: "text" ...`


def _whole(lowest: int, highest: int) -> Callable[[str], int]:
    def read(text: str) -> int:
        if not (text.isascii() and text.isdigit() and lowest <= int(text) <= highest):
            raise ValueError(f"is not a whole number from {lowest} to {highest}")
        return int(text)

    return read


def _bitrate(text: str) -> int:
    if text not in map(str, BITRATES):
        raise ValueError(f"is not one of {', '.join(map(str, BITRATES))}")
    return int(text)


def _mode(text: str) -> int:
    if not (len(text) == 3 and all(digit in "01234567" for digit in text)):
        raise ValueError("is not a file mode like 660")
    return int(text, 8)


def speed(text: str) -> float | None:
    """A multiple of a recording's own pace, None for `max`. Raises ValueError with the end of a sentence."""
    if text in ("max", "0"):
        return None
    try:
        speed = float(text)
    except ValueError:
        speed = -1.0
    if not 0 < speed < float("inf"):
        raise ValueError('is not a positive number or "max"')
    return speed


def _yes_or_no(text: str) -> bool:
    if text not in ("yes", "no"):
        raise ValueError("is not yes or no")
    return text == "yes"


def _as_it_is(text: str) -> Value:
    """A driver's own parameter: a number if it looks like one, then yes or no, then text."""
    if text.isascii() and text.isdigit():
        return int(text)
    return {"yes": True, "true": True, "no": False, "false": False}.get(text.lower(), text)


_baud = _whole(50, 4_000_000)

SCHEMES = {
    "serial": Scheme("bytes", "timonel.links.serial:SerialLink", _path, {"baud": _baud}),
    "pty": Scheme("bytes", "timonel.links.pty:PtyLink", _path, {"mode": _mode}),
    "tcp": Scheme("bytes", "timonel.links.tcp:TcpLink", _host_and_port),
    "tcp-listen": Scheme("bytes", "timonel.links.tcp_listen:TcpListenLink", _listening, {"raw": _yes_or_no}),
    "udp": Scheme("bytes", "timonel.links.udp:UdpLink", _host_or_port),
    "socketcan": Scheme("frames", "timonel.links.socketcan:SocketCanLink", _interface),
    "slcan": Scheme("frames", "timonel.links.slcan:SlcanLink", _path, {"bitrate": _bitrate, "baud": _baud}),
    "loop": Scheme("frames", "timonel.links.loop:LoopLink", _channel),
    "file": Scheme("frames", "timonel.links.file:FileLink", _path, {"speed": speed, "loop": _yes_or_no}),
}
PYTHON_CAN = Scheme("frames", "timonel.links.python_can:PythonCanLink", _numbered_channel)
