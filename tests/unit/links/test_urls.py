import subprocess
import sys

import pytest

from timonel.errors import LinkError
from timonel.links.python_can import PythonCanLink
from timonel.links.urls import SCHEMES, bus_link, byte_link, check, link, parse, with_default

GOOD = {
    "serial:///dev/ttyUSB0": {"path": "/dev/ttyUSB0"},
    "serial:///dev/serial/by-id/usb-FTDI_FT232R-if00-port0?baud=4800": {
        "path": "/dev/serial/by-id/usb-FTDI_FT232R-if00-port0",
        "baud": 4800,
    },
    "pty://run/Bridge?mode=660": {"path": "run/Bridge", "mode": 0o660},
    "pty:///tmp/a%20name": {"path": "/tmp/a name"},
    "tcp://192.168.1.5:10110": {"host": "192.168.1.5", "port": 10110},
    "tcp-listen://[::1]:0": {"host": "::1", "port": 0},
    "udp://192.168.1.255:10110": {"host": "192.168.1.255", "port": 10110},
    "udp://:10110": {"host": None, "port": 10110},
    "udp://192.168.4.1:1456?local=1456": {"host": "192.168.4.1", "port": 1456, "local": 1456},
    "iec450://NAVD?source=HE0002&interface=192.168.1.5": {
        "host": "239.192.0.4",
        "port": 60004,
        "source": "HE0002",
        "interface": "192.168.1.5",
    },
    "iec450://239.192.0.9:60009": {"host": "239.192.0.9", "port": 60009},
    "socketcan://can0": {"channel": "can0"},
    "slcan:///dev/ttyACM0?bitrate=250000": {"path": "/dev/ttyACM0", "bitrate": 250_000},
    "can+gs_usb://0?bitrate=250000&listen_only=no&app=x": {
        "channel": 0,
        "bitrate": 250_000,
        "listen_only": False,
        "app": "x",
        "interface": "gs_usb",
    },
    "loop://Boat": {"channel": "Boat"},
    "file://logs/bus.log?speed=2.5&loop=yes": {"path": "logs/bus.log", "speed": 2.5, "loop": True},
    "file:///bus.log?speed=max": {"path": "/bus.log", "speed": None},
    "file:///bus.log?speed=0": {"path": "/bus.log", "speed": None},
}

BAD = {
    "/dev/ttyUSB0": '"/dev/ttyUSB0" is not a URL (one looks like serial:///dev/ttyUSB0)',
    "sockcan://can0": 'unknown scheme "sockcan" (did you mean "socketcan"?)',
    "qwxyz://can0": 'unknown scheme "qwxyz"',
    "serial:///dev/ttyUSB0?buad=4800": 'unknown parameter "buad" (did you mean "baud"?)',
    "serial:///dev/ttyUSB0?baud=fast": 'baud: "fast" is not a whole number from 50 to 4000000',
    "serial:///dev/ttyUSB0?baud=49": 'baud: "49" is not a whole number from 50 to 4000000',
    "serial:///dev/ttyUSB0?baud=4800&baud=9600": "baud is given twice",
    "serial:///dev/ttyUSB0?baud": "bad query field: 'baud'",
    "serial://": "a path is missing",
    "serial:///dev/tty%00": "a path cannot hold a NUL",
    "tcp://host..name:1": "label empty or too long",
    "pty://x?mode=888": 'mode: "888" is not a file mode like 660',
    "tcp://host": "a port is missing (host:port)",
    "tcp://host:0": "port 0 is below 1",
    "tcp://host:70000": "Port out of range 0-65535",
    "tcp://host:port": "Port could not be cast to integer value as 'port'",
    "tcp://host:1/path": "only host and port can stand here",
    "tcp://me@host:1": "only host and port can stand here",
    "tcp-listen://:10110": "a host is missing (127.0.0.1 is this machine alone, 0.0.0.0 all its networks)",
    "udp://h:1456?local=0": 'local: "0" is not a whole number from 1 to 65535',
    "iec450://NAVT": 'unknown transmission group "NAVT" (one of MISC, TGTD',
    "iec450://ship:60004": "ship is not a multicast address (239.192.0.1 to 239.192.0.64)",
    "iec450://127.0.0.1:60004": "127.0.0.1 is not a multicast address",
    "iec450://NAVD?source=II1": 'source: "II1" is not a talker and four digits, as II0001',
    "iec450://NAVD?interface=eth0": 'interface: "eth0" is not the IPv4 address of a network adapter',
    "tcp://host:1?timeout=3": 'unknown parameter "timeout"',
    "socketcan://an/interface": '"an/interface" cannot be the name of an interface',
    "socketcan://sixteen-letters-": '"sixteen-letters-" cannot be the name of an interface',
    "slcan:///dev/ttyACM0?bitrate=250": 'bitrate: "250" is not one of 10000, 20000, 50000',
    "can+gsusb://0": 'python-can has no interface "gsusb" (did you mean "gs_usb"?)',
    "file:///x?speed=-1": 'speed: "-1" is not a positive number or "max"',
    "file:///x?speed=nan": 'speed: "nan" is not a positive number or "max"',
    "file:///x?loop=1": 'loop: "1" is not yes or no',
}


@pytest.mark.parametrize("url", GOOD)
def test_a_good_url_is_understood(url):
    assert parse(url).values == GOOD[url]


@pytest.mark.parametrize("url", BAD)
def test_a_bad_url_is_refused_with_what_is_wrong_in_it(url):
    with pytest.raises(LinkError) as refusal:
        parse(url)
    assert BAD[url] in str(refusal.value)


@pytest.mark.parametrize("url", GOOD)
def test_every_good_url_makes_a_link_that_knows_its_url_and_name(url):
    made = link(url, name="Bridge")
    assert (made.url, made.name) == (url, "Bridge")
    assert link(url).name == url


def test_every_scheme_has_a_good_url():
    assert {url.partition("://")[0] for url in GOOD} - {"can+gs_usb"} == set(SCHEMES)


def test_a_bus_is_no_port_and_a_port_is_no_bus():
    with pytest.raises(LinkError, match=r"not the URL of a port \(a port is one of serial, pty, tcp, tcp-"):
        byte_link("socketcan://can0")
    with pytest.raises(LinkError, match="not the URL of a bus"):
        bus_link("serial:///dev/ttyUSB0")
    check("serial:///dev/ttyUSB0", "bytes")
    check("loop://boat", "frames")


def test_the_parameters_of_a_python_can_driver_are_passed_on():
    made = link("can+virtual://boat?rx_queue_size=10")
    assert isinstance(made, PythonCanLink)
    assert (made.interface, made.channel, made.parameters) == ("virtual", "boat", {"rx_queue_size": 10})


def test_without_python_can_a_url_that_needs_it_says_how_to_get_it(monkeypatch):
    monkeypatch.setattr("timonel.links.urls.find_spec", lambda name: None)
    with pytest.raises(LinkError, match=r"can\+gs_usb needs python-can: pip install timonel\[can\]"):
        parse("can+gs_usb://0")


def test_checking_urls_loads_no_transport():
    script = (
        "import sys; from timonel.links.urls import parse;"
        "parse('serial:///dev/ttyUSB0'); parse('slcan:///dev/ttyACM0'); parse('tcp://host:1');"
        "print(sorted({'asyncio', 'serialx', 'can', 'socket'} & set(sys.modules)))"
    )
    answer = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("url", "key", "completed"),
    [
        ("slcan:///dev/a", "bitrate", "slcan:///dev/a?bitrate=7"),
        ("slcan:///dev/a?baud=9600", "bitrate", "slcan:///dev/a?baud=9600&bitrate=7"),
        ("slcan:///dev/a?bitrate=125000", "bitrate", "slcan:///dev/a?bitrate=125000"),
        ("socketcan://can0", "bitrate", "socketcan://can0"),
        ("tcp://a:1", "raw", "tcp://a:1"),
    ],
)
def test_a_parameter_that_is_left_out_can_be_given_where_there_is_such_a_one(url: str, key: str, completed: str):
    assert with_default(url, key, "7") == completed
