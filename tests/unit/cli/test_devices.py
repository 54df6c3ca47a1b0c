"""`timonel devices` on recordings; on a bus it is met in `tests/interop/test_n2k_device.py`."""

from pathlib import Path

import msgspec
import pytest

from tests.recordings import recording
from tests.unit.cli.programs import timonel
from timonel.gateway.devices import DeviceShown

EV1 = "canboat_canboat/samples/raymarine-ev1.raw"
CONFIGURATION = '[vehicle]\nkind = "boat"\n[bus]\nurl = "{url}"\n[[output]]\nurl = "tcp-listen://127.0.0.1:10110"\n'


def listed(*arguments: str) -> list[DeviceShown]:
    done = timonel("devices", *arguments, "--json")
    assert (done.returncode, done.stderr) == (0, b"")
    return [msgspec.json.decode(line, type=DeviceShown) for line in done.stdout.splitlines()]


def test_the_devices_of_a_recording_are_told_and_who_gave_no_name() -> None:
    rows = listed(str(recording(EV1)))
    assert [(row.address, row.maker, row.function) for row in rows] == [
        (0, "Raymarine", "Mode Controller"),
        (172, None, None),
        (204, "Raymarine", "Autopilot"),
    ]
    assert rows[2].name == "C0509635E761AEC1"


@pytest.mark.parametrize("way", ["url", "configuration"])
def test_a_recording_may_be_given_as_a_bus(way: str, tmp_path: Path) -> None:
    source = f"file://{recording(EV1)}?speed=max"
    if way == "configuration":
        path = tmp_path / "boat.toml"
        path.write_text(CONFIGURATION.format(url=source))
        source = str(path)
    assert [row.address for row in listed(source)] == [0, 172, 204]


def test_people_get_a_table() -> None:
    done = timonel("devices", str(recording(EV1)))
    assert done.stdout.splitlines()[0].split()[:3] == [b"address", b"maker", b"class"]
    assert b"Autopilot" in done.stdout


def test_a_bus_that_is_not_there_is_said() -> None:
    done = timonel("devices", "slcan:///dev/nothing", "--seconds", "1")
    assert done.returncode == 1
    assert done.stderr.decode().strip() == "slcan:///dev/nothing: No such file or directory"
    assert timonel("devices", "sockcan://can0").returncode == 1
    assert timonel("devices", "/nowhere.log").returncode == 1
