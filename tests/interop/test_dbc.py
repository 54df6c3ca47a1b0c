"""The exported DBC gives cantools the values that we have."""

import json
from pathlib import Path
from typing import Any

import cantools.database
import numpy as np
import pytest

from tests.recordings import vectors
from timonel.gateway import own_frames
from timonel.interop import dbc
from timonel.vehicles.rover import declared
from timonel.vehicles.rover.calibration import DOCUMENTED, PHYSICAL
from timonel.vehicles.rover.conversions import Linear
from timonel.vehicles.rover.protocol import Protocol

OWN = own_frames.load(Path(__file__).parents[2] / "docs" / "own_frames.toml")
PROTOCOLS = {"documented": Protocol(DOCUMENTED, OWN), "physical": Protocol(PHYSICAL, OWN)}
BOTH = pytest.mark.parametrize("calibration", PROTOCOLS)
PAYLOADS = 200


def database(protocol: Protocol) -> Any:
    return cantools.database.load_string(dbc.export(protocol), "dbc", strict=True)


@pytest.fixture(scope="module")
def databases() -> dict[str, Any]:
    return {name: database(protocol) for name, protocol in PROTOCOLS.items()}


@BOTH
def test_every_frame_that_fits_can_is_in_the_file_with_its_length_and_period(databases, calibration):
    frames = PROTOCOLS[calibration].declarations
    messages = {message.frame_id: message for message in databases[calibration].messages}
    assert messages.keys() == {number for number, frame in frames.items() if frame.size <= 8}
    for number, message in messages.items():
        frame = frames[number]
        assert (message.name, message.length) == (frame.__name__, frame.size)
        assert message.cycle_time == round(1000 / frame.RATE)
        assert message.senders == [frame.SENDER.replace(" ", "_")]
        assert not message.is_extended_frame


@BOTH
def test_cantools_reads_the_same_values(databases, calibration):
    random = np.random.default_rng(104)
    for message in databases[calibration].messages:
        codec = PROTOCOLS[calibration].codec(message.frame_id)
        for payload in random.integers(0, 256, (PAYLOADS, message.length), np.uint8):
            theirs = message.decode(payload.tobytes(), decode_choices=False)
            ours = codec.decode(payload.tobytes())
            for part in codec.parts:
                value = getattr(ours, part.name)
                if isinstance(part.formula, Linear) and value is not None:
                    assert theirs[part.name] == pytest.approx(value, rel=1e-12, abs=1e-12), message.name


@BOTH
def test_a_wheel_speed_is_raw_and_its_comment_has_the_formula(databases, calibration):
    signal = databases[calibration].get_message_by_name("WheelSpeedRight").get_signal_by_name("front_rpm")
    numerator = {"documented": 34560000, "physical": 33750}[calibration]
    assert signal.comment == f"Raw: front_rpm = {numerator} / raw [rpm]. Raw -1 is 0. Raw 0 is not available."
    assert (signal.scale, signal.offset, signal.unit) == (1, 0, None)
    for case in map(json.loads, vectors("rover_values.jsonl").read_text().splitlines()):
        if case["frame"] == 106 and case["raw"] not in (0, -1):
            data = case["raw"].to_bytes(2, "little", signed=True) * 3
            raw = databases[calibration].decode_message(106, data, decode_choices=False)["front_rpm"]
            assert numerator / raw == pytest.approx(case[f"{calibration}_rpm"], abs=1e-6)


def test_states_have_their_names(databases):
    known = databases["physical"]
    assert known.decode_message(116, b"\x03")["status"] == "no supply"
    assert known.decode_message(101, b"1")["code"] == "permit"
    assert known.decode_message(164, b"\x02\xff\xff") == {"state": "closed", "force": "not available"}


def test_what_does_not_fit_a_can_frame_is_named_in_the_files_comment():
    text = dbc.export(PROTOCOLS["physical"])
    assert "longer than a CAN frame: 111 Imu, 160 ArmJoints, 161 ArmJointsSet, 162 ArmCurrents." in text


def test_a_comment_tells_what_is_derived(databases):
    comment = databases["physical"].get_message_by_name("BatteryVoltage").comment
    assert "cell2 = tap2 - tap1 [V]." in comment


def test_a_sender_that_is_not_named_is_nobody():
    own = declared.parse(
        '[[frame]]\nid = 121\nname = "Mine"\nto = "operator"\ndoc = \'say "hi"\'\n'
        'fields = [{ name = "a", type = "u8" }]', "own.toml",
    )  # fmt: skip
    message = database(Protocol(own=own)).get_message_by_name("Mine")
    assert (message.senders, message.comment) == ([], "say 'hi'")
