"""The files in which an owner declares frames and calibration."""

import re
from pathlib import Path

import pytest

from timonel.errors import ConfigError
from timonel.gateway import own_frames
from timonel.vehicles.rover.calibration import DOCUMENTED, PHYSICAL

DOCS = Path(__file__).parents[3] / "docs"
PYTHON = re.search(r"```python\n(.*?)```", (DOCS / "own_frames.md").read_text(), re.DOTALL)[1]


def test_frames_are_declared_in_toml():
    assert [frame.FRAME for frame in own_frames.load(DOCS / "own_frames.toml")] == [160, 161, 162, 163, 164, 200, 201]


def test_frames_are_declared_in_python_as_the_page_shows(tmp_path):
    file = tmp_path / "own.py"
    file.write_text(PYTHON)
    protocol = own_frames.protocol(None, file)
    motor = protocol.decode(165, b"\x1f\x0c\xb0\x04")
    assert (motor.current, motor.supply) == (pytest.approx(16.6663, abs=1e-4), pytest.approx(12.0))
    assert motor.power == pytest.approx(200.0, abs=0.1)


@pytest.mark.parametrize(
    ("program", "text"),
    [
        ("class X(", "SyntaxError: "),
        ("1 / 0", "ZeroDivisionError: division by zero"),
        ("import nowhere_to_be_found", "ModuleNotFoundError: "),
        (PYTHON.replace("frame=165", "frame=104"), "frame[1].id: 104 is MotorCurrentRight already; take another"),
        (PYTHON.replace("rate=10", "rate=60"), "frame[1].rate: 60 should be a number above 0, at most 50"),
    ],
)
def test_what_is_wrong_in_a_python_file_is_told(tmp_path, program, text):
    file = tmp_path / "own.py"
    file.write_text(program)
    with pytest.raises(ConfigError, match=re.escape(str(file)) + r"[,:] " + re.escape(text)):
        own_frames.load(file)


def test_a_file_that_is_not_there_is_told(tmp_path):
    for name in ("own.toml", "own.py"):
        with pytest.raises(ConfigError, match=f"{name}: No such file or directory"):
            own_frames.load(tmp_path / name)


def test_a_file_that_is_no_text_is_told(tmp_path):
    (tmp_path / "own.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(ConfigError, match=r"own.toml: not UTF-8 text \(byte 0\)"):
        own_frames.load(tmp_path / "own.toml")


@pytest.fixture
def config(tmp_path) -> Path:
    file = tmp_path / "rover.toml"
    file.write_text('[vehicle]\nframes = "own.toml"\n[calibration]\nbase = "documented"\nencoder_pulses = 256\n')
    (tmp_path / "own.toml").write_text((DOCS / "own_frames.toml").read_text())
    return file


def test_a_configuration_names_frames_beside_it_and_constants(config):
    protocol = own_frames.protocol(config)
    assert 200 in protocol.declarations
    assert protocol.calibration.encoder_pulses == 256
    assert protocol.calibration.current_zero_right == DOCUMENTED.current_zero_right


def test_what_is_asked_for_takes_the_place_of_the_configuration(config, tmp_path):
    (tmp_path / "other.toml").write_text("")
    protocol = own_frames.protocol(config, tmp_path / "other.toml", "physical")
    assert max(protocol.declarations) == 120
    assert protocol.calibration == PHYSICAL


def test_without_a_configuration_the_protocol_is_the_specifications():
    assert own_frames.protocol(None).calibration == PHYSICAL


def test_mistakes_in_the_constants_are_told_with_their_lines(config):
    config.write_text("[calibration]\npulses = 3\nadc_volts = -1\n")
    with pytest.raises(ConfigError) as caught:
        own_frames.protocol(config)
    assert str(caught.value).splitlines() == [
        f'{config}:2, calibration.pulses: unknown key (did you mean "encoder_pulses"?)',
        f"{config}:3, calibration.adc_volts: -1 should be a number above 0",
    ]


def test_a_slip_in_the_syntax_is_told(config):
    config.write_text("[calibration\n")
    with pytest.raises(ConfigError, match=f"{config}:1, column 13"):
        own_frames.protocol(config)
