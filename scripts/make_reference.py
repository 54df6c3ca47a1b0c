"""Writes the pages that follow from declarations: in docs/ pgns.md, conversion.md, rover_frames.md and security.md."""

from itertools import starmap
from pathlib import Path

from timonel.core.reference import section
from timonel.nmea0183.sentence import Sentence
from timonel.nmea2000.registry import interval, variants
from timonel.vehicles.boat.conversion import CONVERSIONS, Conversion
from timonel.vehicles.boat.instruments import READINGS, Reading
from timonel.vehicles.rover import reference
from timonel.vehicles.rover.protocol import Protocol
from timonel.web.access import Least
from timonel.web.routes import ROUTES

DOCS = Path(__file__).parents[1] / "docs"
PGNS = """# PGNs

Written by `scripts/make_reference.py` from the declarations in `timonel.nmea2000.messages`; do not edit.

`bit` is where a field begins, counted from the lowest bit of the first byte; numbers are little-endian. Fields
are numbered as PGN 126208 counts them. The highest values of a number or a list are those that mean "not
available", "out of range" and "reserved"; they read as None, and None is sent as "not available". Angles are in
rad, temperatures in K, all else in SI as the table says; positions are in degrees, dates in days since
1970-01-01, times in s since midnight UTC.
"""
CONVERSION = """# From NMEA 2000 to NMEA 0183

Written by `scripts/make_reference.py` from `timonel.vehicles.boat.conversion`; do not edit.

A sentence is said when one of its messages comes, at most as often as the table says; `[sentences]` in the
configuration sets other rates, 0 is never. A source that jitters about the rate passes whole.

* A value that is not available leaves its field empty, and a sentence with none of its values is not said. A value
  of an earlier message counts for 3 s (`max_age`), a time of day for 2 s. No time is ever that of the computer.
* true = magnetic + variation, magnetic = compass + deviation, east positive. HDT is the heading of a true compass,
  else that of a magnetic one with its own variation, that of 127258, or that of the World Magnetic Model; where none is
  to be had there is no HDT. A compass that tells no deviation has none.
* Of several sources the first is kept to while it speaks. One that tells better takes over at once; any other does
  when the first has been silent for 1 s (what comes at 10 Hz) or 2 s, or says that it has no heading, position or fix
  any more.
* Water temperature comes from 130316, 130312, 130311 or 130310, the first that is alive; position from 129025, else
  from 129029; date and time from 129029, 126992 or 129033; MWV,T from wind against the water, else from the boat's.
* Status and mode follow the method of 129029: no fix is `V,N`, an estimated, manual or simulated position is `V` too.
* Names of waypoints come from 129285, cut to 8 characters; a waypoint without a name is called by its number. RMB
  leaves the origin out where both names do not fit.
* A value that no sentence can hold, an altitude of a million kilometres, is rejected and counted.

| sentence | talker | at most | brought about by |
|---|---|---|---|
"""
AIS_ROW = "| VDM, VDO | AI | as heard | the ten PGNs of [AIS](ais.md) |\n"
ROVER = """# Frames of the rover

Written by `scripts/make_reference.py` from the declarations in `timonel.vehicles.rover.frames`; do not edit.

The identifier is the same on UART and CAN, numbers are little-endian. `to` says whom a frame is for: the controller
(`rover`), the motor drivers on the CAN bus, or everybody who listens (`operator`). Formulas are those of the
calibration `physical`. `sent` are the limits of what we send; what is outside is read as it is. Rates, signs and axes
that the original leaves open are our choice. Frames of one's own: `own_frames.md`.
"""
SECURITY = """# Security

Written by `scripts/make_reference.py` from the table of routes in `timonel.web.routes`; do not edit.

NMEA 0183, NMEA 2000 and the rover's frames know no identity: whoever has a wire is believed, within what its port may
say. A port commands as its own station and no other; listeners (`[[output]]`) and instruments (`[[input]]`) never
command. One exception is yours to make: a raw NMEA 2000 output with `transmit = true` puts on the bus what its
listeners send, past command transfer, as a second plotter on the backbone could. It is off by default; keep such a
port on this computer. By MQTT somebody commands only if `station` pairs the broker with one.

The console is for a network, where everything is hostile until it has shown otherwise; [console.md](console.md) tells
how it is set up.

## The console

- It listens on this computer alone unless configured otherwise, and then needs a token to see and a pairing to command.
- Every request must name a host that is ours: an address of the connection, this computer, or `hosts` (DNS rebinding).
  Else 421.
- A socket, and all that changes something, must come from a page of ours, or from a program that is no browser: by
  `Origin`, else by `Sec-Fetch-Site`. Else 403. What changes something is JSON, which no form of another site can send.
- No secret stands in a URL, in the log, or in what a script can read. Cookies are `HttpOnly`, `SameSite=Strict`, with
  TLS `Secure`, sealed with a key that only this computer has.
- Five failures in a minute are let go through from one address (of IPv6: one network), in HTTP and on the socket
  together; after that it gets 429.
- Every answer has a `Content-Security-Policy` that allows nothing but what we serve, and may not be framed.
- A request has at most 16 KiB, a message on the socket 4 KiB, a browser says at most 120 messages a second, and at most
  256 browsers look. What is not understood ends the socket.
- Signal K is read and ordered by the same rules ([signalk.md](signalk.md)); its stream takes subscriptions and nothing
  else, 20 messages a second of each of at most 32 clients. An order of its autopilot API is the word of a station.
- Files are served by their own plain names from one directory; nothing leads out of it.

## Routes and roles

What is not in this table is not found. `nobody` has not signed in; a gateway without a token has only admins.

| method | path | what | nobody | reader | station | admin |
|---|---|---|---|---|---|---|
"""
SECURITY_TESTS = """
On the socket a reader is told everything and may do nothing; a station may do what its wire may, as that station.

## How this is proven

`tests/unit/web/test_routes.py` walks this table with every role. `tests/robustness/test_web_security.py` attacks a
running gateway: hosts, origins, tokens, guesses, paths out of the directory, long and malformed requests and messages,
and it looks for the token in the log. `tests/unit/web/test_api.py` compares all answers with the description that
`/api/v1/openapi.json` gives of them.
"""


READING = """
# From NMEA 0183 to NMEA 2000

What instruments say on an `[[input]]`, or on a station's wire with `instruments = true`; [sources](sources.md) tells
when it is heard, and when it goes onto the bus. A sentence makes these messages, each at most as often as it is sent by
the book:

| sentence | at most | messages |
|---|---|---|
"""
READING_RULES = """
* What is empty is not available; what is marked invalid (status V, mode N, quality 0) is not told. No position is ever
  0, 0 for want of one. A receiver that had a fix and lost it tells 129029 without a position.
* Signs and references are those of the sentence: HDM stays magnetic, HDG brings its deviation and variation along, and
  the bearings of a leg are counted from what APB says. Only A is a heading that was measured: THS with another mode is
  none. MWV,T becomes wind from the bow (reference 3).
* An estimated, manual or simulated position is told in 129029, which can say so, and nowhere else.
* What one port tells in several sentences is taken from the best while it comes: HDG before HDM, THS before HDT, DPT
  before DBT before DBS before DBK, GGA before RMC for 129029, XTE before APB before RMB for the cross-track error.
* DBS and DBK need to know where the transducer is: `depth_offset_m` of a `[[correction]]`. Without it DBS is told as
  from a transducer in the surface, and DBK not at all.
* A date goes with a time of day for 10 s, over midnight too. APB and RMB of the same 3 s make one 129284.
* Waypoints with names are numbered from 60001, and 129285 tells which is which. RMB's cross-track error of 9.99 nm is
  where it ends, not a distance.
* The variation of RMC is not told: most senders compute it.
"""


def pgns() -> str:
    return "\n".join([PGNS, *map(section, variants())])


def conversion() -> str:
    said, read = map(_row, CONVERSIONS), starmap(_reading, READINGS.items())
    return CONVERSION + "".join(said) + AIS_ROW + READING + "".join(read) + READING_RULES


def _reading(sentence: type[Sentence], reading: Reading) -> str:
    """The ceiling is that of the first message."""
    first = reading.messages[0].PGN
    rate = 1 / (interval(first or 0) or 1.0)
    messages = ", ".join(f"{message.PGN} {message.__name__}" for message in reading.messages)
    return f"| {sentence.__name__} | {rate:g} Hz | {messages} |\n"


def _row(line: Conversion) -> str:
    messages = ", ".join(f"{message.PGN} {message.__name__}" for message in line.messages)
    return f"| {line.key} | {line.talker} | {line.rate:g} Hz | {messages} |\n"


def rover_frames() -> str:
    return f"{ROVER}\n{reference.page(Protocol())}\n{reference.constants()}"


def security() -> str:
    rows = [
        f"| {route.method} | `{route.path}` | {route.about} | "
        + " | ".join("yes" if least >= route.least else "no" for least in Least)
        + " |\n"
        for route in ROUTES
    ]
    return SECURITY + "".join(rows) + SECURITY_TESTS


PAGES = {
    "pgns.md": pgns,
    "conversion.md": conversion,
    "rover_frames.md": rover_frames,
    "security.md": security,
}

if __name__ == "__main__":
    for name, page in PAGES.items():
        (DOCS / name).write_text(page())
