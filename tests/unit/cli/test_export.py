"""The frames as files for the tools of others."""

from pathlib import Path

import cantools.database

from tests.unit.cli.programs import timonel

FRAMES = str(Path(__file__).parents[3] / "docs" / "own_frames.toml")


def test_a_dbc_file_is_written_where_it_is_wanted(tmp_path):
    file = tmp_path / "rover.dbc"
    run = timonel("export", "dbc", "-o", str(file), "--frames", FRAMES)
    assert (run.returncode, run.stdout, run.stderr) == (0, b"", b"")
    names = {message.name for message in cantools.database.load_file(file).messages}
    assert {"BatteryVoltage", "SoilProbe"} <= names


def test_the_calibration_is_chosen():
    assert b" SG_ front : 0|16@1- (0.0335693359375,-62.5)" in timonel("export", "dbc").stdout
    documented = timonel("export", "dbc", "--calibration", "documented").stdout
    assert b" SG_ front : 0|16@1- (0.0335693359375,0.0)" in documented


def test_the_page_has_ones_own_frames():
    shown = timonel("export", "markdown", "--frames", FRAMES).stdout.decode()
    assert "| 200 | SoilProbe | laboratory | operator | 8 | 1 |" in shown


def test_a_mistake_in_a_file_is_told_without_a_file_being_written(tmp_path):
    bad = tmp_path / "bad.toml"
    bad.write_text("[[frame]]\nid = 104\n")
    run = timonel("export", "dbc", "--frames", str(bad), "-o", str(tmp_path / "rover.dbc"))
    assert run.returncode == 2
    assert f"{bad}:2, frame[1].id: 104 is MotorCurrentRight already; take another" in run.stderr.decode()
    assert not (tmp_path / "rover.dbc").exists()


CONFIGURATION = """
[vehicle]
kind = "rover"
frames = "own.toml"
[calibration]
base = "documented"
encoder_pulses = 256
[bus]
url = "loop://rover"
[[station]]
id = 1
url = "tcp-listen://127.0.0.1:5000"
"""


def test_a_configuration_has_frames_and_constants_of_its_own(tmp_path):
    (tmp_path / "own.toml").write_text(Path(FRAMES).read_text())
    config = tmp_path / "rover.toml"
    config.write_text(CONFIGURATION)
    text = timonel("export", "dbc", "--config", str(config)).stdout.decode()
    assert "front_rpm = 135000 / raw" in text
    assert "BO_ 200 SoilProbe" in text
    (tmp_path / "other.toml").write_text("")
    given = ("--frames", str(tmp_path / "other.toml"), "--calibration", "physical")
    text = timonel("export", "dbc", "--config", str(config), *given).stdout.decode()
    assert "front_rpm = 33750 / raw" in text
    assert "SoilProbe" not in text


def test_a_boat_has_no_frames_of_a_rover(tmp_path):
    config = tmp_path / "boat.toml"
    boat = CONFIGURATION.replace('"rover"', '"boat"')
    config.write_text(boat.replace('frames = "own.toml"\n[calibration]\nbase = "documented"\nencoder_pulses = 256', ""))
    run = timonel("export", "dbc", "--config", str(config))
    assert run.returncode == 2
    assert "boat.toml describes no rover" in run.stderr.decode()
