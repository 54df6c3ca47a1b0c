"""Frames that an owner declares in TOML are frames like the built-in ones."""

import struct
from pathlib import Path

import numpy as np
import pytest

from timonel.errors import ConfigError, EncodeError
from timonel.vehicles.rover.declaration import Party
from timonel.vehicles.rover.declared import parse
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.reference import section

EXAMPLE = Path(__file__).parents[3] / "docs" / "own_frames.toml"
FRAME = """
[[frame]]
id = 200
name = "SoilProbe"
to = "operator"
"""


def declared(fields: str, frame: str = FRAME) -> Protocol:
    return Protocol(own=parse(f"{frame}fields = [{fields}]", "own.toml"))


def mistakes(text: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        parse(text, "own.toml")
    return str(caught.value).splitlines()


@pytest.fixture(scope="module")
def example() -> Protocol:
    return Protocol(own=parse(EXAMPLE.read_text(), EXAMPLE.name))


def test_the_example_declares_an_arm_and_a_soil_probe(example):
    assert {number for number in example.declarations if number > 120} == {160, 161, 162, 163, 164, 200, 201}
    assert example.lengths(Party.ROVER) == {100: 2, 101: 1, 115: 1, 119: 1, 120: 1, 161: 10, 163: 1, 201: 3}
    arm = example.declarations[160]
    assert (arm.SENDER, arm.RATE, arm.SEGMENTED) == ("arm", 20, True)


def test_the_examples_arm_is_read_and_set(example):
    joints = example.decode(160, struct.pack("<5h", 15708, -15708, 0, 1, -32768))
    assert (joints.base, joints.shoulder, joints.elbow, joints.pitch, joints.roll) == (
        pytest.approx(1.5708), pytest.approx(-1.5708), 0.0, pytest.approx(1e-4), None,
    )  # fmt: skip
    setting = example.declarations[161](base=0.5, shoulder=1.6, elbow=-2.4, pitch=0.0, roll=0.0)
    assert example.encode(setting) == (161, struct.pack("<5h", 5000, 16000, -24000, 0, 0))
    with pytest.raises(EncodeError, match=r"shoulder: 1.7 rad is outside -0.5\.\.1.6"):
        example.encode(example.declarations[161](base=0.0, shoulder=1.7, elbow=0.0, pitch=0.0, roll=0.0))


def test_the_examples_probe_is_read(example):
    probe = example.decode(200, struct.pack("<hBBf", 1234, 90, 255, 0.25))
    assert probe == example.declarations[200](temperature_c=12.34, moisture_percent=45.0, ph=None, conductivity=0.25)
    assert example.encode(probe) == (200, struct.pack("<hBBf", 1234, 90, 255, 0.25))


def test_labels_are_names_of_raw_values(example):
    found = example.decode(164, b"\x02\x0a\x00")
    assert (found.state.name, found.force) == ("CLOSED", 1.0)
    assert example.decode(164, b"\x09\x0a\x00").state.name == "UNKNOWN_9"
    assert example.encode(example.declarations[164](state=4, force=None)) == (164, b"\x04\xff\xff")


def test_own_frames_have_columns(example):
    payloads = np.frombuffer(struct.pack("<hBBf", 1234, 90, 255, 0.25), np.uint8).reshape(1, 8)
    found = example.columns(200, payloads)
    assert {name: float(column[0]) for name, column in found.items() if name != "ph"} == {
        "temperature_c": 12.34, "moisture_percent": 45.0, "conductivity": 0.25,
    }  # fmt: skip
    assert np.isnan(found["ph"]).all()


def test_own_frames_have_a_section_on_the_page(example):
    text = section(example.codec(164))
    assert text.startswith("### 164 GripperStatus\n\n| field |")
    assert "| state | 0 | u8 |  | 0 open, 1 moving, 2 closed, 3 holding, 4 fault | |" in text
    assert "| force | 1 | u16 | N | raw * 0.1; 65535: None |  |" in text
    assert "positive to the left" in section(example.codec(160))
    assert "| depth | 1 | u16 | m | raw * 0.001 | 0 to 0.35 |" in section(example.codec(201))


@pytest.mark.parametrize(
    ("type_", "size", "raw"),
    [
        ("u8", 1, 200),
        ("i8", 1, -100),
        ("u16", 2, 60000),
        ("i16", 2, -30000),
        ("u32", 4, 4_000_000_000),
        ("i32", 4, -2_000_000_000),
    ],
)
def test_every_type_of_whole_numbers_is_read_and_written(type_, size, raw):
    protocol = declared(f'{{ name = "value", type = "{type_}" }}')
    data = raw.to_bytes(size, "little", signed=raw < 0)
    assert protocol.decode(200, data).value == raw
    assert protocol.encode(protocol.declarations[200](value=raw)) == (200, data)


def test_a_real_number_that_is_none_is_not_available_either_way():
    protocol = declared('{ name = "value", type = "f32" }')
    for number in (float("nan"), float("inf"), float("-inf")):
        assert protocol.decode(200, struct.pack("<f", number)).value is None
    _, data = protocol.encode(protocol.declarations[200](value=None))
    assert protocol.decode(200, data).value is None
    with pytest.raises(EncodeError, match=r"value: 1e\+39 is outside"):
        protocol.encode(protocol.declarations[200](value=1e39))


def test_special_values_are_numbers_or_nothing_and_may_be_written_as_people_write_them():
    protocol = declared('{ name = "value", type = "i16", special = { 0xFFFF = 0, 0x8000 = "none", 7 = 1.5 } }')
    values = [protocol.decode(200, struct.pack("<h", raw)).value for raw in (-1, -32768, 7, 8)]
    assert values == [0.0, None, 1.5, 8]


@pytest.mark.parametrize("name", ["data", "self", "index", "round", "frame", "unpack", "error", "abs", "pack", "cls"])
def test_a_field_may_be_called_as_things_are_called_in_programs(name):
    protocol = declared(f'{{ name = "{name}", type = "u8", scale = 0.5, special = {{ 255 = "none" }} }}')
    made = protocol.declarations[200](**{name: 21.0})
    assert protocol.encode(made) == (200, b"\x2a")
    assert protocol.decode(200, b"\x2a") == made


def test_limits_follow_a_scale_that_turns_things_round():
    protocol = declared('{ name = "depth", type = "u8", scale = -0.1, min = -2.0, max = -0.5 }')
    assert protocol.encode(protocol.declarations[200](depth=-2.0)) == (200, b"\x14")
    with pytest.raises(EncodeError, match=r"depth: -0.4 is outside -2\.\.-0.5"):
        protocol.encode(protocol.declarations[200](depth=-0.4))


def test_a_file_without_frames_declares_none():
    assert parse("", "own.toml") == ()


@pytest.mark.parametrize(
    ("frame", "text"),
    [
        ('id = 104\nname = "Mine"\nto = "rover"', ":2, frame[1].id: 104 is MotorCurrentRight already; take another"),
        (
            'id = 99\nname = "Mine"\nto = "rover"',
            ":2, frame[1].id: 99 is not free; free are 121..159 (the platform's own), 160..199 (the manipulator), "
            "200..239 (the laboratory)",
        ),
        ('id = "x"\nname = "Mine"\nto = "rover"', ':2, frame[1].id: "x" should be a whole number'),
        ('name = "Mine"\nto = "rover"', ":1, frame[1].id: missing"),
        ('id = 160\nto = "rover"', ":1, frame[1].name: missing"),
        ('id = 160\nname = "Mine"', ":1, frame[1].to: missing"),
        ('id = 160\nname = "my arm"\nto = "rover"', ':3, frame[1].name: "my arm" should be a word like ArmJoints'),
        ('id = 160\nname = "Imu"\nto = "rover"', ':3, frame[1].name: "Imu" is another frame already'),
        (
            'id = 160\nname = "Mine"\nto = "rovr"',
            ':4, frame[1].to: "rovr" should be "motors" or "operator" or "rover" (did you mean "rover"?)',
        ),
        (
            'id = 160\nname = "Mine"\nto = "rover"\nrate = 80',
            ":5, frame[1].rate: 80 should be a number above 0, at most 50",
        ),
        ('id = 160\nname = "Mine"\nto = "rover"\nrat = 8', ':5, frame[1].rat: unknown key (did you mean "rate"?)'),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_frame_is_told_with_its_line_and_a_remedy(frame, text):
    found = mistakes(f'[[frame]]\n{frame}\nfields = [{{ name = "a", type = "u8" }}]\n')
    assert f"own.toml{text}" in found


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ('{ type = "u8" }', "fields[1].name: missing"),
        ('{ name = "a" }', "fields[1].type: missing"),
        ('{ name = "A b", type = "u8" }', 'fields[1].name: "A b" should be a word like base_angle'),
        ('{ name = "class", type = "u8" }', 'fields[1].name: "class" should be a word like base_angle'),
        ('{ name = "layout", type = "u8" }', 'fields[1].name: "layout" should be a word like base_angle'),
        (f'{{ name = "{"a" * 33}", type = "u8" }}', f'fields[1].name: "{"a" * 33}" should be a word like base_angle'),
        ('{ name = "a", type = "u8" }, { name = "a", type = "u8" }', 'fields[2].name: "a" is another field already'),
        (
            '{ name = "a", type = "u9" }',
            'fields[1].type: "u9" should be "f32" or "i16" or "i32" or "i8" or "u16" or "u32" or "u8"',
        ),
        ('{ name = "a", type = "u8", scal = 2 }', 'fields[1].scal: unknown key (did you mean "scale"?)'),
        ('{ name = "a", type = "u8", scale = 0 }', "fields[1].scale: 0 makes every value the same"),
        ('{ name = "a", type = "u8", scale = "x" }', 'fields[1].scale: "x" should be a number'),
        ('{ name = "a", type = "u8", max = 256 }', "fields[1].max: 256 does not fit the field's type"),
        ('{ name = "a", type = "u8", min = 9, max = 3 }', "fields[1].max: should be above min"),
        ('{ name = "a", type = "f32", special = { 1 = 2 } }', "fields[1].special: this belongs to whole numbers only"),
        ('{ name = "a", type = "u8", special = 3 }', "fields[1].special: should be a table of raw values"),
        (
            '{ name = "a", type = "u8", special = { x = 2 } }',
            'fields[1].special.x: "x" should be a raw value, like 7 or 0xFFFF',
        ),
        ('{ name = "a", type = "u8", special = { 256 = 2 } }', "special.256: 256 does not fit the field's type"),
        ('{ name = "a", type = "u8", special = { 1 = "no" } }', 'special.1: "no" should be a number or "none"'),
        ('{ name = "a", type = "u8", labels = { 1 = 2 } }', "fields[1].labels.1: 2 should be a word or two"),
        ('{ name = "a", type = "u8", labels = { 1 = "x", 2 = "X" } }', 'fields[1].labels.2: "X" is 1 already'),
        (
            '{ name = "a", type = "u8", scale = 2, labels = { 1 = "x" } }',
            "fields[1].labels: a labelled field has neither scale nor offset",
        ),
        ("3", "fields: should be a list of tables: [[frame[1].fields]]"),
        ("", "fields: missing; a frame needs at least one"),
        (
            '{ name = "a", type = "u32" }, { name = "b", type = "u32" }, { name = "c", type = "u8" }',
            "segmented: 9 bytes do not fit a CAN frame of 8; say segmented = true",
        ),
        (
            ", ".join(f'{{ name = "{name}", type = "u32" }}' for name in "abcd"),
            "fields: 16 bytes are too many; at most 15, in two segments",
        ),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_field_is_told_by_its_place_with_a_remedy(fields, text):
    found = mistakes(f"{FRAME}fields = [{fields}]\n")
    assert len([line for line in found if line.endswith(text)]) == 1


def test_two_frames_of_ones_own_cannot_share_an_identifier():
    field = 'fields = [{ name = "a", type = "u8" }]\n'
    other = FRAME.replace("SoilProbe", "Other")
    assert mistakes(f"{FRAME}{field}{other}{field}") == [
        "own.toml:9, frame[2].id: 200 is SoilProbe already; take another"
    ]


def test_a_table_of_another_name_is_not_passed_over():
    assert mistakes("[frames]\n") == ['own.toml:1, frames: unknown table (did you mean "frame"?)']
    assert mistakes("frame = 3\n") == ["own.toml:1, frame: should be a list of tables: [[frame]]"]


def test_a_slip_in_the_syntax_has_its_place():
    [found] = mistakes("[[frame]]\nid = \n")
    assert found.startswith("own.toml:2, column 6: ")
