"""Many payloads at once give the values that one payload gives."""

import math
from typing import Annotated

import numpy as np
import pytest

from timonel.core.columns import CHUNK, columns
from timonel.core.fields import I16, U8, U16, U32, Ascii, Bits, Lookup, Number, Reserved, StringLau, Unsigned
from timonel.core.message import Message
from timonel.nmea2000.lookups import HeadingReference, SimnetEventType
from timonel.nmea2000.messages.navigation import GnssPositionData, TimeDate
from timonel.nmea2000.messages.network import ConfigurationInformation
from timonel.nmea2000.messages.steering import HeadingTrackControl, VesselHeading


class Odd(Message):
    low: Annotated[int | None, Unsigned(5)]
    signed: Annotated[int | None, Number(7, True)]
    across: Annotated[int | None, Unsigned(12)]
    long: Annotated[int, Bits(40)]
    event: Annotated[SimnetEventType | None, Lookup(8, SimnetEventType)]
    wide: Annotated[HeadingReference | None, Lookup(11, HeadingReference)]
    reserved: Annotated[None, Reserved(5)] = None
    label: Annotated[str | None, Ascii(3)]
    shifted: Annotated[float | None, U16(0.01, "C", offset=-273.15)]
    name: Annotated[str | None, StringLau()]
    behind: Annotated[int | None, U32()]


def rows(count: int, size: int) -> np.ndarray:
    return np.random.default_rng(127250).integers(0, 256, (count, size), dtype=np.uint8)


@pytest.mark.parametrize("message", [VesselHeading, HeadingTrackControl, GnssPositionData, TimeDate, Odd])
@pytest.mark.parametrize("size", [0, 1, 3, 5, 7, 8, 21, 60])
def test_columns_are_the_scalar_values_bit_for_bit(message: type[Message], size: int):
    payloads = rows(200, size)
    found = columns(message, payloads)
    for index, payload in enumerate(payloads):
        one = message.decode(payload.tobytes())
        for name, column in found.items():
            value = getattr(one, name)
            assert math.isnan(column[index]) if value is None else column[index] == float(value), name


def test_only_numbers_before_a_variable_field_have_a_column():
    assert list(columns(Odd, rows(2, 30))) == ["low", "signed", "across", "long", "event", "wide", "shifted"]
    assert columns(ConfigurationInformation, rows(2, 30)) == {}


def test_a_column_is_float64_of_one_value_per_payload():
    column = columns(VesselHeading, rows(7, 8))["heading"]
    assert (column.dtype, column.shape) == (np.dtype(np.float64), (7,))
    assert columns(VesselHeading, rows(0, 8))["heading"].shape == (0,)


def test_more_payloads_than_are_worked_on_at_a_time_come_out_in_order():
    payloads = np.full((2 * CHUNK + 3, 8), 0xFF, dtype=np.uint8)
    payloads[:, 1:3] = (np.arange(len(payloads)) % 60000).astype("<u2").view(np.uint8).reshape(-1, 2)
    found = columns(VesselHeading, payloads)
    assert (found["heading"] == np.arange(len(payloads)) % 60000 / 10000.0).all()
    assert np.isnan(found["sid"]).all()


class Eight(Message):
    first: Annotated[int | None, U8()]
    second: Annotated[float | None, I16(3.125e-5, "rad/s")]


@pytest.mark.parametrize("part", [np.s_[:, ::2], np.s_[::2], np.s_[:, 8:]])
def test_payloads_may_be_a_part_of_something_larger(part: tuple[slice, ...]):
    payloads = rows(50, 16)[part]
    for name, column in columns(Eight, payloads).items():
        assert np.array_equal(column, columns(Eight, payloads.copy())[name], equal_nan=True)
