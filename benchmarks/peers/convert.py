"""One measured run: frames of a bus to sentences, or sentences to frames, with PyPI's nmea2000 and pynmea2.

    python convert.py sentences|frames FILE -> {"messages", "out", "seconds"}

Both only read and write, and leave the conversion to their user: here it is the shortest that gives the usual ones.
"""

import json
import logging
import struct
import sys
import time
from collections.abc import Callable
from math import degrees, radians
from pathlib import Path
from typing import Any

import pynmea2
from nmea2000 import NMEA2000Field, NMEA2000Message, create_encoder
from nmea2000.decoder import NMEA2000Decoder
from nmea2000.input_formats import N2KFormat

CAN_FRAME = struct.Struct("=IB3x8s")
KNOT = 1852 / 3600
Values = dict[str, Any]
Sentence = tuple[str, str, tuple[str, ...]]


def _place(angle: float, width: int, letters: str) -> tuple[str, str]:
    whole, minutes = divmod(abs(angle) * 60, 60)
    return f"{int(whole):0{width}d}{minutes:09.6f}", letters[angle < 0]


def _speed(speed: float) -> tuple[str, ...]:
    return f"{speed / KNOT:.1f}", "N", f"{speed * 3.6:.1f}", "K"


def _heading(v: Values) -> Sentence:
    letter = "T" if v["reference"] == "True" else "M"
    return "II", f"HD{letter}", (f"{degrees(v['heading']):.1f}", letter)


def _position(v: Values) -> Sentence:
    return "GP", "GLL", (*_place(v["latitude"], 2, "NS"), *_place(v["longitude"], 3, "EW"), "", "A", "A")


def _rate(v: Values) -> Sentence:
    return "II", "ROT", (f"{degrees(v['rate']) * 60:.1f}", "A")


def _rudder(v: Values) -> Sentence:
    return "II", "RSA", (f"{degrees(v['position']):.1f}", "A", "", "V")


def _water(v: Values) -> Sentence:
    return "II", "VHW", ("", "T", "", "M", *_speed(v["speedWaterReferenced"]))


def _depth(v: Values) -> Sentence:
    return "II", "DBT", (f"{v['depth'] / 0.3048:.1f}", "f", f"{v['depth']:.2f}", "M", "", "F")


def _ground(v: Values) -> Sentence:
    return "GP", "VTG", (f"{degrees(v['cog']):.1f}", "T", "", "M", *_speed(v["sog"]), "A")


def _wind(v: Values) -> Sentence:
    return "II", "MWV", (f"{degrees(v['windAngle']):.1f}", "R", f"{v['windSpeed'] / KNOT:.1f}", "N", "A")


SENTENCES: dict[int, Callable[[Values], Sentence]] = {
    127250: _heading, 127251: _rate, 127245: _rudder, 128259: _water, 128267: _depth,
    129025: _position, 129026: _ground, 130306: _wind,
}  # fmt: skip


def to_sentences(file: Path) -> tuple[int, int, float]:
    decoder = NMEA2000Decoder(bound_format=N2KFormat.EBYTE)
    frames = [
        bytes((0x80 | size,)) + (identifier & 0x1FFFFFFF).to_bytes(4, "big") + payload[:size]
        for identifier, size, payload in CAN_FRAME.iter_unpack(file.read_bytes())
    ]
    made, began = 0, time.process_time()
    for frame in frames:
        message = decoder.decode(frame)
        if message is None or (build := SENTENCES.get(message.PGN)) is None:
            continue
        try:
            talker, formatter, fields = build({field.id: field.value for field in message.fields})
        except TypeError:  # a value that is not available
            continue
        made += bool(f"{getattr(pynmea2, formatter)(talker, formatter, fields)}\r\n".encode())
    return len(frames), made, time.process_time() - began


def _number(text: Any, scale: float = 1.0) -> float | None:
    return None if text in (None, "") else float(text) * scale


MESSAGES: dict[str, tuple[int, str, Callable[[Any], Values]]] = {
    "HDT": (127250, "vesselHeading", lambda s: {"heading": _angle(s.heading), "reference": "True"}),
    "HDM": (127250, "vesselHeading", lambda s: {"heading": _angle(s.heading), "reference": "Magnetic"}),
    "VHW": (128259, "speed", lambda s: {"speedWaterReferenced": _number(s.water_speed_knots, KNOT)}),
    "DBT": (128267, "waterDepth", lambda s: {"depth": _number(s.depth_meters)}),
    "GLL": (129025, "positionRapidUpdate", lambda s: {"latitude": s.latitude, "longitude": s.longitude}),
    "VTG": (
        129026, "cogSogRapidUpdate",
        lambda s: {"cogReference": "True", "cog": _angle(s.true_track), "sog": _number(s.spd_over_grnd_kts, KNOT)},
    ),
    "MWV": (
        130306, "windData",
        lambda s: {
            "windSpeed": _number(s.wind_speed, KNOT), "windAngle": _angle(s.wind_angle), "reference": "Apparent",
        },
    ),
}  # fmt: skip


def _angle(text: Any) -> float | None:
    return None if text in (None, "") else radians(float(text))


def to_frames(file: Path) -> tuple[int, int, float]:
    encoder: Any = create_encoder(output_format=N2KFormat.EBYTE)
    lines = file.read_text("latin-1").splitlines()
    made, began = 0, time.process_time()
    for line in lines:
        try:
            sentence: Any = pynmea2.parse(line)
        except pynmea2.ParseError:
            continue
        if (way := MESSAGES.get(getattr(sentence, "sentence_type", ""))) is None:
            continue
        pgn, name, read = way
        fields = [NMEA2000Field(id=key, value=value) for key, value in read(sentence).items() if value is not None]
        message = NMEA2000Message(PGN=pgn, id=name, source=1, destination=255, priority=2, fields=fields)
        made += bool(encoder.encode(message))
    return len(lines), made, time.process_time() - began


logging.disable(logging.CRITICAL)
work = to_sentences if sys.argv[1] == "sentences" else to_frames
messages, out, seconds = work(Path(sys.argv[2]))
print(json.dumps({"messages": messages, "out": out, "seconds": seconds}))
