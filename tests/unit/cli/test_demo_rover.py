import os
import signal
import socket
import time
from contextlib import closing
from pathlib import Path

import pytest

from tests.unit.cli.programs import start, timonel
from tests.unit.cli.test_face import drawn
from timonel.cli.demo_rover import configure, how_to_connect
from timonel.cli.rover_traffic import RoverTraffic, spoken
from timonel.cli.rover_view import RoverView
from timonel.core.command import Transferred
from timonel.core.effects import Say, Transmit
from timonel.core.frame import Frame
from timonel.vehicles.rover.drive import Permission
from timonel.vehicles.rover.frames import (
    BatteryState,
    BatteryVoltage,
    BmsStatus,
    GpsPosition,
    Magnetometer,
    MotorCurrentRight,
    WheelSpeedSetLeft,
    WheelSpeedSetRight,
)
from timonel.vehicles.rover.framing import Strzyga
from timonel.vehicles.rover.protocol import Protocol

PROTOCOL = Protocol()
REST, PERMIT, STOP = (Strzyga.write(number, data) for number, data in ((100, b"\0\0"), (101, b"1"), (101, b"\xce")))


def two_free_ports() -> int:
    while True:
        with socket.create_server(("127.0.0.1", 0)) as server:
            port = int(server.getsockname()[1])
            try:
                socket.create_server(("127.0.0.1", port + 1)).close()
            except OSError:
                continue
            return port


def test_the_demo_shows_a_rover_that_obeys_its_stations_until_ctrl_c(tmp_path: Path) -> None:
    port = two_free_ports()
    demo = start("demo", "rover", "--no-view", "--no-web", "--directory", str(tmp_path), "--port", str(port))
    try:
        while True:
            try:
                operator = socket.create_connection(("127.0.0.1", port), 10)
                break
            except ConnectionError:  # refused, or reset in the moment it begins to listen
                assert demo.poll() is None
                time.sleep(0.05)
        with closing(operator):
            operator.settimeout(10)
            assert b"#" in operator.recv(4096)
            operator.sendall(REST + PERMIT + REST)
            assert demo.stdout.readline() == b"command passes from nobody to station 1\n"
            assert demo.stdout.readline() == b"drives enabled: station 1\n"
            uart = os.open(tmp_path / "rover", os.O_RDWR | os.O_NOCTTY)
            os.write(uart, STOP)
            assert demo.stdout.readline() == b"drives stopped: a station ordered a stop\n"
            os.close(uart)
    finally:
        demo.send_signal(signal.SIGINT)
        _, told = demo.communicate(timeout=20)
    assert demo.returncode == 0, told.decode()
    assert [path.name for path in tmp_path.iterdir()] == ["recordings"]
    verified = timonel("replay", "--verify", str(tmp_path / "recordings"))
    assert (verified.returncode, verified.stderr) == (0, b"")


def test_a_second_demo_is_told_that_the_port_is_taken() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = str(server.getsockname()[1])
        shown = timonel("demo", "rover", "--no-web", "--port", port)
    assert shown.returncode == 1
    assert shown.stderr.decode() == f"127.0.0.1:{port}: Address already in use; --port takes another one\n"


def test_what_to_connect_is_what_there_is_and_fits_a_terminal() -> None:
    hints = how_to_connect(configure(Path("/run/user/1000/timonel"), 5001, PROTOCOL))
    assert [line for line in hints if len(line) > 78] == []
    for place in (
        "timonel drive tcp://127.0.0.1:5001",
        "timonel drive tcp://127.0.0.1:5002 --station 2",
        "timonel drive serial:///run/user/1000/timonel/rover --station 3",
    ):
        assert place in "\n".join(hints)


def frame(message: object) -> Frame:
    return Frame(*PROTOCOL.encode(message), extended=False)


@pytest.mark.parametrize(
    ("message", "text"),
    [
        (MotorCurrentRight(front=1.0, middle=-2.0, rear=0.5), "front 1.0  middle -2.0  rear 0.5 A"),
        (WheelSpeedSetLeft(front_percent=30, middle_percent=30, rear_percent=-5), "front 30  middle 30  rear -5 %"),
        (BmsStatus(status=BatteryState.UNDER_VOLTAGE), "status under voltage"),
        (GpsPosition(longitude_deg=21.0, latitude_deg=52.0), "longitude 21.00000  latitude 52.00000°"),
        (GpsPosition(longitude_deg=None, latitude_deg=None), "nothing available"),
        (Magnetometer(x=20e-6, y=0.0, z=-40e-6), "magnetic heading 0°  strength 44.7  x 20.0  y 0.0  z -40.0 µT"),
        (
            BatteryVoltage(tap1=4.0, tap2=8.0, tap3=12.0, tap4=16.0),
            "cell1 4.00  cell2 4.00  cell3 4.00  cell4 4.00  tap1 4.00  tap2 8.00  tap3 12.00  tap4 16.00 V",
        ),
    ],
)
def test_values_are_told_in_units_for_the_eye(message: object, text: str) -> None:
    identifier, data = PROTOCOL.encode(message)
    assert spoken(PROTOCOL.decode(identifier, data), data) == text


def test_a_frame_that_nobody_declared_is_told_in_bytes() -> None:
    traffic = RoverTraffic(PROTOCOL)
    traffic.frames_received([Frame(250, b"\1\2", extended=False)], 1.0)
    assert traffic.messages[250].name == "Frame 250"
    assert spoken(traffic.decoded(traffic.messages, 250), b"\1\2") == "01 02"


def busy_view() -> RoverView:
    view = RoverView(PROTOCOL, ["drive    timonel drive tcp://127.0.0.1:5001"], title="timonel demo rover")
    for tenth in range(30):
        view.frames_received([frame(MotorCurrentRight(front=1.0, middle=-2.0, rear=0.5))], tenth / 10)
        view.effect(Say(b"#\x68", "104"), tenth / 10)
        for kind, percent in ((WheelSpeedSetLeft, 30), (WheelSpeedSetRight, -12)):
            setpoints = kind(front_percent=percent, middle_percent=percent, rear_percent=percent)
            view.effect(Transmit(frame(setpoints)), tenth / 10)
    view.effect(Transferred(0, 2), 2.9)
    view.effect(Permission(True, "station 2"), 2.9)
    view.port("Operator", True, 0.0)
    return view


def test_the_view_shows_everything_that_goes_through_at_80_by_24() -> None:
    text = "\n".join(drawn(busy_view().page(80, 24, 3.0)))
    for part in (
        "timonel demo rover",
        "bus 10 in 20 out frames/s   to stations 10 frames/s",
        " ENABLED   wheels left  +30 %  right  -12 %   station 2",
        "command 02 Jetson",
        "● Operator",
        " 104  Motor current right    10.0   0.1  front 1.0  middle -2.0  rear 0.5 A",
        " 102  Wheel speed set right  10.0   0.1  front -12  middle -12  rear -12 %",
        "drives enabled: station 2",
        "drive    timonel drive tcp://127.0.0.1:5001",
    ):
        assert part in text


@pytest.mark.parametrize(("width", "height"), [(80, 24), (200, 60), (60, 12), (40, 8)])
def test_the_view_fills_the_terminal_exactly(width: int, height: int) -> None:
    for view in (busy_view(), RoverView(PROTOCOL)):
        assert [len(line) for line in drawn(view.page(width, height, 3.0), width, height)] == [width] * height


def test_before_anything_goes_through_it_says_so() -> None:
    text = "\n".join(drawn(RoverView(PROTOCOL).page(80, 24, 3.0)))
    assert "STOPPED   wheels left   -- %  right   -- %   nobody has enabled the drives yet" in text
    assert "command nobody" in text
