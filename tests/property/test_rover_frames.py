"""What is true of every frame of a rover, built-in or an owner's own, told by its declaration."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from timonel.errors import EncodeError
from timonel.vehicles.rover.calibration import DOCUMENTED, PHYSICAL
from timonel.vehicles.rover.codec import Codec, Part
from timonel.vehicles.rover.conversions import Linear
from timonel.vehicles.rover.declaration import RoverFrame
from timonel.vehicles.rover.declared import parse
from timonel.vehicles.rover.protocol import Protocol

OWN = parse((Path(__file__).parents[2] / "docs" / "own_frames.toml").read_text(), "own_frames.toml")
PROTOCOLS = {"documented": Protocol(DOCUMENTED, OWN), "physical": Protocol(PHYSICAL, OWN)}
CODECS = [protocol.codec(number) for protocol in PROTOCOLS.values() for number in protocol.declarations]
EVERY_FRAME = pytest.mark.parametrize("codec", CODECS, ids=lambda codec: codec.frame.__name__)
FEW = settings(max_examples=15, deadline=None)
TRANSCENDENTAL = {"magnetic_heading"}  # math and NumPy may differ in the last digit of an arc tangent


def payloads(codec: Codec) -> st.SearchStrategy[bytes]:
    size = codec.frame.size
    words = st.sampled_from([b"\0\0", b"\xff\xff", b"\0\x80", b"\xff\x7f", b"\0\0\xc0\x7f"])
    edges = st.lists(words, min_size=size, max_size=size).map(lambda parts: b"".join(parts)[:size])
    return st.binary(min_size=size, max_size=size) | edges


def sendable(codec: Codec, frame: RoverFrame) -> bool:
    """Whether all values are within the limits of what we send."""
    return all(part.fault(getattr(frame, part.name)) is None for part in codec.parts)


def same(one: float | None, other: float) -> bool:
    return math.isnan(other) if one is None else float(one) == other


@EVERY_FRAME
def test_any_payload_is_read_and_what_was_read_is_sent_as_the_same_values(codec: Codec):
    @given(payloads(codec))
    @FEW
    def check(data: bytes) -> None:
        frame = codec.decode(data)
        assert type(frame) is codec.frame
        if sendable(codec, frame):
            assert codec.decode(codec.encode(frame)) == frame
        else:
            with pytest.raises(EncodeError, match="outside"):
                codec.encode(frame)

    check()


@EVERY_FRAME
def test_the_bytes_come_back_where_each_has_one_meaning(codec: Codec):
    @given(payloads(codec))
    @FEW
    def check(data: bytes) -> None:
        frame = codec.decode(data)
        if sendable(codec, frame) and not any(part.signal.real for part in codec.parts):
            assert codec.encode(frame) == data

    check()


@EVERY_FRAME
def test_columns_are_the_single_values_bit_for_bit(codec: Codec):
    @given(st.lists(payloads(codec), min_size=1, max_size=8))
    @FEW
    def check(several: list[bytes]) -> None:
        columns = codec.columns(np.frombuffer(b"".join(several), np.uint8).reshape(len(several), -1))
        assert list(columns) == [part.name for part in codec.parts] + list(codec.frame.DERIVED)
        for row, data in enumerate(several):
            frame = codec.decode(data)
            for name, column in columns.items():
                one = getattr(frame, name)
                if name in TRANSCENDENTAL and one is not None:
                    assert math.isclose(one, column[row], abs_tol=1e-14)
                else:
                    assert same(one, column[row]), name

    check()


PARTS = [(codec, part) for codec in CODECS for part in codec.parts]


@pytest.mark.parametrize(("codec", "part"), PARTS, ids=lambda value: getattr(value, "name", ""))
def test_every_raw_value_comes_back_from_what_it_means(codec: Codec, part: Part):
    @given(st.integers(*map(math.ceil, part.signal.range)) if not part.signal.real else st.floats(-90, 90, width=32))
    @FEW
    def check(raw: float) -> None:
        special = dict(part.signal.special)
        if raw in special or (raw == 0 and not isinstance(part.formula, Linear)):
            return
        value = eval(part.formula.value("raw"), {"raw": raw})
        back = eval(part.formula.raw("value"), {"value": value})
        assert (back if part.signal.real else round(back)) == raw
        assert part.fault(value) is None

    check()


@given(st.integers(0, 255), st.binary(max_size=16))
def test_no_bytes_of_any_identifier_raise(identifier: int, data: bytes):
    for protocol in PROTOCOLS.values():
        found = protocol.decode(identifier, data)
        declared = protocol.declaration(identifier)
        assert (found is not None) == (declared is not None and declared.size == len(data))


NUMBERS = st.floats() | st.floats(-50, 50) | st.integers() | st.integers(0, 20)
ANYTHING = NUMBERS | st.none() | st.text(max_size=2) | st.lists(st.none(), max_size=1)


@EVERY_FRAME
def test_no_value_is_sent_as_something_else(codec: Codec):
    names = [part.name for part in codec.parts]

    @given(st.fixed_dictionaries(dict.fromkeys(names, ANYTHING)))
    @FEW
    def check(values: dict[str, object]) -> None:
        try:
            data = codec.encode(codec.frame(**values))
        except EncodeError:
            return
        read = codec.decode(data)
        for part in codec.parts:
            given_, found = values[part.name], getattr(read, part.name)
            assert part.fault(given_) is None
            if given_ is None:
                assert found is None
            elif isinstance(part.formula, Linear):
                step = 1e-6 * abs(given_) if part.signal.real else abs(part.formula.factor) / 2
                assert abs(found - given_) <= step * (1 + 1e-9) + 1e-30

    check()
