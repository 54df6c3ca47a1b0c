"""Frames (`struct can_frame`) on standard input, one sentence each on standard output: PyPI nmea2000 and pynmea2.

`EBYTE` is the format of nmea2000 that is nearest to a frame.
"""

import logging
import os
import struct
from collections.abc import Callable
from math import degrees

import pynmea2
from nmea2000.decoder import NMEA2000Decoder
from nmea2000.input_formats import N2KFormat

CAN_FRAME = struct.Struct("=IB3x8s")
KNOT = 1852 / 3600
Values = dict[str, float]
Build = Callable[[Values], tuple[str, str, tuple[str, ...]]]


def _position(degrees_: float, width: int, letters: str) -> tuple[str, str]:
    whole, minutes = divmod(abs(degrees_) * 60, 60)
    return f"{int(whole):0{width}d}{minutes:09.6f}", letters[degrees_ < 0]


def _speed(speed: float) -> tuple[str, ...]:
    return f"{speed / KNOT:.1f}", "N", f"{speed * 3.6:.1f}", "K"


def hdt(v: Values) -> tuple[str, str, tuple[str, ...]]:
    return "II", "HDT", (f"{degrees(v['heading']):.1f}", "T")


def rot(v: Values) -> tuple[str, str, tuple[str, ...]]:
    return "II", "ROT", (f"{degrees(v['rate']) * 60:.1f}", "A")


def gll(v: Values) -> tuple[str, str, tuple[str, ...]]:
    return "GP", "GLL", (*_position(v["latitude"], 2, "NS"), *_position(v["longitude"], 3, "EW"), "", "A", "A")


def vtg(v: Values) -> tuple[str, str, tuple[str, ...]]:
    return "GP", "VTG", (f"{degrees(v['cog']):.1f}", "T", "", "M", *_speed(v["sog"]), "A")


def vhw(v: Values) -> tuple[str, str, tuple[str, ...]]:
    return "II", "VHW", (f"{degrees(v['heading']):.1f}", "T", "", "M", *_speed(v["speedWaterReferenced"]))


def mwv(v: Values) -> tuple[str, str, tuple[str, ...]]:
    return "II", "MWV", (f"{degrees(v['windAngle']):.1f}", "R", f"{v['windSpeed'] / KNOT:.1f}", "N", "A")


BUILD: dict[int, Build] = {127250: hdt, 127251: rot, 129025: gll, 129026: vtg, 128259: vhw, 130306: mwv}


def main() -> None:
    logging.disable(logging.CRITICAL)
    decoder = NMEA2000Decoder(bound_format=N2KFormat.EBYTE)
    known: Values = {}
    rest = b""
    while data := os.read(0, 1 << 16):
        data = rest + data
        whole = len(data) - len(data) % CAN_FRAME.size
        rest = data[whole:]
        for identifier, size, payload in CAN_FRAME.iter_unpack(data[:whole]):
            packet = bytes((0x80 | size,)) + (identifier & 0x1FFFFFFF).to_bytes(4, "big") + payload[:size]
            message = decoder.decode(packet)
            if message is not None:
                known.update((field.id, field.value) for field in message.fields if field.value is not None)
                talker, formatter, fields = BUILD[message.PGN](known)
                os.write(1, f"{getattr(pynmea2, formatter)(talker, formatter, fields)}\r\n".encode())


main()
