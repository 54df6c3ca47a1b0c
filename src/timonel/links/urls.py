"""The URLs of links: which schemes there are, what each may say, and the link that one means.

```
bytes    serial  pty  tcp  tcp-listen  udp  iec450
frames   socketcan  slcan  can+<interface of python-can>  loop  file  <form of text>+<what carries bytes>
```
To check a URL loads none of the transports, only their names and the rules below; `docs/links.md` describes
each.
"""

from collections.abc import Callable, Iterable
from importlib import import_module
from importlib.util import find_spec
from ipaddress import IPv4Address
from typing import Literal, cast
from urllib.parse import SplitResult, parse_qsl, unquote, urlsplit

import msgspec

from timonel.errors import LinkError
from timonel.links.link import BusLink, ByteLink

Carries = Literal["bytes", "frames"]
Value = str | int | float | bool | None
Values = dict[str, Value]

COMMAND_AGE = 0.5  # s that a command may wait to be sent
BAUD = 115200  # of a serial port whose URL does not say
TEXTS = ("ydraw", "candump", "n2kascii", "seasmart")  # the forms of timonel.nmea2000.text
GROUPS = ("MISC", "TGTD", "SATD", "NAVD", "VDRD", "RCOM", "TIME", "PROP")  # of IEC 61162-450, in the order of addresses
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
    from timonel.links.tcp_listen import TcpListenLink
    from timonel.links.wire import Port

    made = byte_link(url, name=name)
    if isinstance(made, Port | TcpListenLink):
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
        fitting += ", or text as ydraw+tcp" if carries == "frames" else ""
        raise LinkError(f"{url}: not the URL of {wanted} ({wanted} is one of {fitting})")


def is_text_bus(url: str) -> bool:
    """Whether a URL means a bus in lines of text, which has NMEA 2000's identifiers of 29 bits alone."""
    return url.partition("+")[0] in TEXTS


def with_default(url: str, key: str, value: str) -> str:
    """`url` with a parameter that it leaves to the default, if its scheme has such a one. Raises LinkError."""
    parse(url)
    query = url.partition("?")[2]
    name = url.partition("://")[0]
    if is_text_bus(url) or key not in _scheme(name).parameters or key in dict(parse_qsl(query)):
        return url
    return f"{url}{'&' if '?' in url else '?'}{key}={value}"


def parse(url: str) -> Address:
    """Understand a URL; raises LinkError that says what is wrong in it."""
    name, separator, rest = url.partition("://")
    if not separator:
        raise LinkError(f'"{url}" is not a URL (one looks like serial:///dev/ttyUSB0)')
    form, plus, over = name.partition("+")
    if plus and form != "can":
        return _text_bus(url, form, f"{over}://{rest}")
    scheme = _scheme(name)
    try:
        parts = urlsplit("//" + rest, allow_fragments=False)
        values = scheme.place(parts) | _parameters(scheme, parts.query)
    except (LinkError, ValueError) as fault:
        raise LinkError(f"{url}: {fault}") from None
    if name.startswith("can+"):
        values["interface"] = name.removeprefix("can+")
    return Address(url, scheme.carries, scheme.maker, values)


def _text_bus(url: str, form: str, over: str) -> Address:
    """A bus in lines of text, over a link that carries bytes."""
    if form not in TEXTS:
        raise LinkError(f'{url}: unknown form "{form}"{_did_you_mean(form, (*TEXTS, "can"))}')
    if parse(over).carries != "bytes":
        raise LinkError(f"{url}: {form} is text, and {over.partition('://')[0]} carries none")
    return Address(url, "frames", "timonel.links.text_bus:text_bus", {"form": form, "over": over})


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


def _transmission_group(parts: SplitResult) -> Values:
    """By the standard's name, or as address and port."""
    name = parts.netloc.upper()
    if name in GROUPS:
        number = 1 + GROUPS.index(name)
        return {"host": f"239.192.0.{number}", "port": 60000 + number}
    if ":" not in parts.netloc:
        raise LinkError(f'unknown transmission group "{parts.netloc}" (one of {", ".join(GROUPS)}, or address:port)')
    values = _host_and_port(parts)
    if not _is_multicast(str(values["host"])):
        raise LinkError(f"{values['host']} is not a multicast address (239.192.0.1 to 239.192.0.64)")
    return values


def _is_multicast(text: str) -> bool:
    try:
        return IPv4Address(text).is_multicast
    except ValueError:
        return False


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


def _interface_address(text: str) -> str:
    try:
        return str(IPv4Address(text))
    except ValueError:
        raise ValueError("is not the IPv4 address of a network adapter") from None


def _system(text: str) -> str:
    if not (len(text) == 6 and text[:2].isalpha() and text[:2].isupper() and text[2:].isdigit() and text.isascii()):
        raise ValueError("is not a talker and four digits, as II0001")
    return text


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
    "udp": Scheme("bytes", "timonel.links.udp:UdpLink", _host_or_port, {"local": _whole(1, 65535)}),
    "iec450": Scheme(
        "bytes",
        "timonel.links.iec450:Iec450Link",
        _transmission_group,
        {"source": _system, "interface": _interface_address},
    ),
    "socketcan": Scheme("frames", "timonel.links.socketcan:SocketCanLink", _interface),
    "slcan": Scheme("frames", "timonel.links.slcan:SlcanLink", _path, {"bitrate": _bitrate, "baud": _baud}),
    "loop": Scheme("frames", "timonel.links.loop:LoopLink", _channel),
    "file": Scheme("frames", "timonel.links.file:FileLink", _path, {"speed": speed, "loop": _yes_or_no}),
}
PYTHON_CAN = Scheme("frames", "timonel.links.python_can:PythonCanLink", _numbered_channel)
