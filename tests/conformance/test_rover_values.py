"""The worked values of the specification, in both calibrations, for single frames and for columns."""

import json
import math
from collections import defaultdict
from typing import Any

import numpy as np
import pytest

from tests.recordings import vectors
from timonel.vehicles.rover.calibration import CALIBRATIONS
from timonel.vehicles.rover.declaration import RoverFrame
from timonel.vehicles.rover.drive import LIMIT_STEPS, Stick, Wheels, mixed
from timonel.vehicles.rover.protocol import Protocol

PROTOCOLS = {name: Protocol(calibration) for name, calibration in CALIBRATIONS.items()}
BOTH = pytest.mark.parametrize("calibration", PROTOCOLS)
EXACT = {"rel": 0, "abs": 6e-7}  # as many digits as the vectors have
GRAVITY = 9.80665


def cases() -> dict[int, list[dict[str, Any]]]:
    found = defaultdict(list)
    for line in vectors("rover_values.jsonl").read_text().splitlines():
        case = json.loads(line)
        found[case["frame"]].append(case)
    return found


CASES = cases()


def int16(*raw: int) -> bytes:
    return b"".join(one.to_bytes(2, "little", signed=one < 0) for one in raw)


def values(frame: RoverFrame | None) -> list[float | None]:
    assert frame is not None
    return [getattr(frame, name) for name in type(frame).__struct_fields__]


def check(protocol: Protocol, identifier: int, data: bytes, wanted: list[float | None]) -> None:
    """A payload has these values by itself and in columns, and is what these values are sent as."""
    frame = protocol.decode(identifier, data)
    assert values(frame) == [None if value is None else pytest.approx(value, **EXACT) for value in wanted]
    columns = protocol.columns(identifier, np.frombuffer(data, np.uint8).reshape(1, -1))
    for name, value in zip(columns, wanted, strict=False):
        assert math.isnan(columns[name][0]) if value is None else columns[name][0] == pytest.approx(value, **EXACT)
    assert protocol.encode(frame) == (identifier, data)


def test_no_case_of_the_specification_is_left_out():
    assert CASES.keys() == {100, 104, 106, 108, 109, 110, 111}


@BOTH
@pytest.mark.parametrize("case", CASES[104], ids=lambda case: str(case["raw"]))
@pytest.mark.parametrize("identifier", [104, 105])
def test_a_current_is_what_the_specification_says(calibration, identifier, case):
    check(PROTOCOLS[calibration], identifier, int16(*[case["raw"]] * 3), [case[f"{calibration}_A"]] * 3)


@BOTH
@pytest.mark.parametrize("case", CASES[106], ids=lambda case: str(case["raw"]))
@pytest.mark.parametrize("identifier", [106, 107])
def test_a_wheel_speed_is_what_the_specification_says(calibration, identifier, case):
    check(PROTOCOLS[calibration], identifier, int16(*[case["raw"]] * 3), [case[f"{calibration}_rpm"]] * 3)


@BOTH
@pytest.mark.parametrize("case", CASES[108], ids=lambda case: str(case["raw"]))
def test_taps_and_cells_are_what_the_specification_says(calibration, case):
    protocol, data = PROTOCOLS[calibration], int16(*case["raw"])
    check(protocol, 108, data, case["taps_V"])
    frame = protocol.decode(108, data)
    columns = protocol.columns(108, np.frombuffer(data, np.uint8).reshape(1, -1))
    for number, volts in enumerate(case["cells_V"], 1):
        assert getattr(frame, f"cell{number}") == pytest.approx(volts, **EXACT)
        assert columns[f"cell{number}"][0] == getattr(frame, f"cell{number}")


@BOTH
@pytest.mark.parametrize("case", CASES[109], ids=lambda case: str(case["raw"]))
@pytest.mark.parametrize(("identifier", "count"), [(109, 6), (113, 3), (114, 3)])
def test_a_temperature_is_what_the_specification_says(calibration, identifier, count, case):
    check(PROTOCOLS[calibration], identifier, bytes([case["raw"]] * count), [case["degC"]] * count)


@BOTH
@pytest.mark.parametrize("case", CASES[110], ids=lambda case: case["data"])
def test_a_position_is_what_the_specification_says(calibration, case):
    wanted = [case["longitude_deg"], case["latitude_deg"]]
    check(PROTOCOLS[calibration], 110, bytes.fromhex(case["data"]), wanted)


@BOTH
@pytest.mark.parametrize("case", CASES[111], ids=lambda case: case["data"])
def test_the_imu_is_what_the_specification_says(calibration, case):
    accelerations = [g * GRAVITY for g in case["acceleration_g_at_16384"]]
    rates = [math.radians(rate) for rate in case["rate_deg_s_at_131"]]
    check(PROTOCOLS[calibration], 111, bytes.fromhex(case["data"]), accelerations + rates)


@pytest.mark.parametrize("case", CASES[100], ids=lambda case: f"{case['y']},{case['x']}")
def test_a_stick_is_mixed_as_the_specification_says(case):
    stick = PROTOCOLS["physical"].decode(100, bytes((case["y"] & 0xFF, case["x"] & 0xFF)))
    assert values(stick) == [case["y"], case["x"]]
    assert mixed(Stick(case["y"], case["x"]), LIMIT_STEPS) == Wheels(case["left_pct"], case["right_pct"])
