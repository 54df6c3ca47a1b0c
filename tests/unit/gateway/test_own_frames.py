"""The files in which an owner declares frames."""

import re
from pathlib import Path

import pytest

from timonel.errors import ConfigError
from timonel.gateway import own_frames
from timonel.vehicles.rover.protocol import Protocol

DOCS = Path(__file__).parents[3] / "docs"
PYTHON = re.search(r"```python\n(.*?)```", (DOCS / "own_frames.md").read_text(), re.DOTALL)[1]


def test_frames_are_declared_in_toml():
    assert [frame.FRAME for frame in own_frames.load(DOCS / "own_frames.toml")] == [160, 161, 162, 163, 164, 200, 201]


def test_frames_are_declared_in_python_as_the_page_shows(tmp_path):
    file = tmp_path / "own.py"
    file.write_text(PYTHON)
    protocol = Protocol(own=own_frames.load(file))
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
