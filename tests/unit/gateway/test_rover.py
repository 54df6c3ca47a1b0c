"""The client of a rover on the gateway itself, with the simulated rover, in counted time."""

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import AsyncExitStack
from pathlib import Path

import pytest

import timonel
from tests.unit.gateway.concentrator import Cable, run
from tests.unit.gateway.test_station_on_gateway import Socket
from timonel.errors import ConfigError, EncodeError, LinkError, NoAnswerError, RefusedError, StationError
from timonel.gateway.gateway import Channel, Gateway
from timonel.gateway.rover import KEPT, Frames, Phase, Rover
from timonel.gateway.simulation import Simulation
from timonel.gateway.telemetry import Quality
from timonel.links.uart_bus import UartBus
from timonel.links.urls import bus_link
from timonel.vehicles.rover.declaration import Party
from timonel.vehicles.rover.frames import (
    BatteryState,
    CurrentLimit,
    DriveCommand,
    GpsPosition,
    MotorCurrentRight,
    MotorTemperatureLeft,
    PowerLimit,
    SpeedLimit,
)
from timonel.vehicles.rover.framing import Strzyga
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.settings import Port, RoverSettings
from timonel.vehicles.rover.simulator import Fault, SimulatedRover
from timonel.vehicles.rover.vehicle import Rover as Controller

NAMES = {1: "operator", 2: "jetson"}
DOCS = Path(__file__).parents[3] / "docs"


class Scenery:
    """A simulated rover, its controller and the cables to its stations."""

    def __init__(self) -> None:
        self.protocol = Protocol()
        self.rover = SimulatedRover()
        self.sockets = {number: Socket(name) for number, name in NAMES.items()}
        ports = [Port(name, number) for number, name in NAMES.items()]
        self.controller = Controller(RoverSettings(), ports, asyncio.get_running_loop().time(), self.protocol)
        channels = [Channel(socket.name, socket, socket) for socket in self.sockets.values()]
        self.gateway = Gateway(self.controller, bus_link("loop://test", name="bus"), channels)
        self.heard: list[tuple[int, int, bytes]] = []
        self.mute = False

    async def enter(self, stack: AsyncExitStack) -> None:
        await self.gateway.open()
        stack.push_async_callback(self.gateway.close, 0.0)
        await stack.enter_async_context(Simulation(self.rover, bus_link("loop://test", name="rover")))

    def client(self, station: int) -> Rover:
        framer = Strzyga(self.protocol.lengths(Party.OPERATOR))
        return Rover(UartBus(Tapped(self, station), framer), self.protocol, station=station)

    def said(self, station: int, *identifiers: int) -> list[bytes]:
        """The data of the frames that a station has said, of some identifiers."""
        return [data for who, identifier, data in self.heard if who == station and identifier in identifiers]

    @property
    def speed(self) -> float:
        return self.rover.body.speed


class Tapped(Cable):
    """A cable that takes down what the station says, and can be cut in the direction of the station."""

    def __init__(self, scenery: Scenery, station: int) -> None:
        super().__init__(scenery.sockets[station], NAMES[station], delay=0.01)
        self.scenery, self.station = scenery, station

    def send(self, lines):
        for say in lines:
            self.scenery.heard.append((self.station, say.line[1], say.line[2:]))
        super().send(lines)

    async def open(self, receive, changed):
        def hear(data: bytes) -> None:
            if not self.scenery.mute:
                self.counters.bytes_in += len(data)
                receive(data)

        await super().open(hear, changed)


Scene = Callable[[Scenery], Awaitable[None]]


def play(scene: Scene) -> None:
    async def main() -> None:
        async with AsyncExitStack() as stack:
            scenery = Scenery()
            await scenery.enter(stack)
            await asyncio.sleep(1.0)
            await scene(scenery)

    run(main())


def test_a_client_enables_and_drives_and_the_rover_stands_when_the_block_is_left():
    async def scene(s: Scenery) -> None:
        async with s.client(2) as r:
            await asyncio.sleep(0.5)
            assert r.phase is Phase.IDLE
            await r.enable()
            assert r.enabled
            await r.drive(forward=0.5, hold=3.0)
            await asyncio.sleep(2.0)
            assert s.speed > 0.4
            assert all(wheel.rpm > 20 for wheel in r.wheels)
        assert s.rover.setpoints == ((0, 0, 0), (0, 0, 0))
        assert not s.controller.drive.permitted
        await asyncio.sleep(2.0)
        assert s.speed == 0

    play(scene)


def test_set_points_are_said_20_times_a_second_and_go_to_rest_when_nobody_calls_again():
    async def scene(s: Scenery) -> None:
        async with s.client(1) as r:
            await r.enable()
            s.heard.clear()
            await r.drive(forward=1.0, right=-0.25, hold=0.5)
            await asyncio.sleep(1.0)
            said = s.said(1, 100)
            assert 19 <= len(said) <= 22
            assert set(said[:9]) == {b"\xe7\x9c"}
            assert set(said[12:]) == {b"\x00\x00"}
            assert r.setpoint == (0, 0)
            assert r.enabled

    play(scene)


def test_set_points_that_come_faster_than_50_hz_are_thinned_and_the_latest_wins():
    async def scene(s: Scenery) -> None:
        async with s.client(1) as r:
            await r.enable()
            await asyncio.sleep(0.1)
            s.heard.clear()
            for percent in range(1, 101):
                await r.drive(forward=percent / 100)
                await asyncio.sleep(0.001)
            await asyncio.sleep(0.06)
            said = s.said(1, 100)
            assert len(said) <= 9
            assert said[-1] == b"\x00\x9c"

    play(scene)


def test_leaving_by_an_exception_stops_the_rover_too():
    async def scene(s: Scenery) -> None:
        async def program() -> None:
            async with s.client(1) as r:
                await r.enable()
                await r.drive(1.0, hold=5.0)
                await asyncio.sleep(1.0)
                raise ZeroDivisionError

        with pytest.raises(ZeroDivisionError):
            await program()
        assert s.rover.setpoints == ((0, 0, 0), (0, 0, 0))
        assert s.said(1, 101).count(b"\xce") >= 5

    play(scene)


def test_a_client_that_only_listens_says_nothing_and_stops_nobody():
    async def scene(s: Scenery) -> None:
        async with s.client(1) as driver:
            await driver.enable()
            async with s.client(2) as listener:
                await driver.drive(0.5, hold=5.0)
                await asyncio.sleep(1.0)
                assert listener.battery.voltage == pytest.approx(16.4, abs=0.5)
            assert driver.enabled
            assert s.said(2, *range(256)) == []

    play(scene)


def test_the_operator_takes_over_and_nothing_more_is_heard_of_the_jetson():
    async def scene(s: Scenery) -> None:
        async with s.client(1) as operator, s.client(2) as jetson:
            await jetson.enable()
            await jetson.drive(0.5, hold=10.0)
            await asyncio.sleep(1.0)
            await operator.enable()
            assert s.controller.helm.transfer.commander == 1
            assert not jetson.enabled
            with pytest.raises(RefusedError, match=r"drive: not enabled: .*motor driver: stopped; somebody"):
                await jetson.drive(0.5)
            s.heard.clear()
            await operator.drive(-0.5, hold=2.0)
            await asyncio.sleep(1.5)
            assert s.speed < -0.3
            assert s.said(2, *range(256)) == []

    play(scene)


def test_a_station_that_has_to_ask_is_refused_while_somebody_else_drives():
    async def scene(s: Scenery) -> None:
        async with s.client(1) as operator, s.client(2) as jetson:
            await operator.enable()
            with pytest.raises(NoAnswerError, match="enable: somebody else drives, and has not given command within"):
                await jetson.enable(timeout=3.0)
            assert operator.enabled
            assert s.said(2, 101) == []

    play(scene)


def test_a_stop_is_obeyed_from_whoever_does_not_drive():
    async def scene(s: Scenery) -> None:
        async with s.client(1) as operator, s.client(2) as jetson:
            await jetson.enable()
            await jetson.drive(0.5, hold=10.0)
            await asyncio.sleep(1.0)
            await operator.stop()
            assert not s.controller.drive.permitted
            assert not jetson.enabled
            assert s.said(1, 100) == []

    play(scene)


def test_enabling_is_given_up_when_a_stop_comes_first():
    async def scene(s: Scenery) -> None:
        async with s.client(1) as operator, s.client(2) as jetson:
            await operator.enable()
            asking = asyncio.create_task(jetson.enable())
            await asyncio.sleep(1.0)
            await jetson.stop()
            with pytest.raises(RefusedError, match="enable: it was stopped"):
                await asking

    play(scene)


def test_a_driver_that_cannot_run_is_told():
    async def scene(s: Scenery) -> None:
        s.rover.silence(Fault.MOTOR_SUPPLY)
        async with s.client(1) as r:
            await asyncio.sleep(0.5)
            with pytest.raises(RefusedError, match="motor driver: no supply"):
                await r.enable()

    play(scene)


def test_a_driver_that_fails_under_way_ends_the_drive_with_a_stop():
    async def scene(s: Scenery) -> None:
        async with s.client(1) as r:
            await r.enable()
            await r.drive(0.5, hold=10.0)
            await asyncio.sleep(1.0)
            s.rover.silence(Fault.MOTOR_SUPPLY)
            await asyncio.sleep(0.3)
            assert not r.enabled
            assert "no supply" in r.why_idle
            assert not s.controller.drive.permitted

    play(scene)


def test_a_driver_that_falls_silent_ends_the_drive_with_a_stop():
    async def scene(s: Scenery) -> None:
        async with s.client(1) as r:
            await r.enable()
            await r.drive(0.5, hold=10.0)
            s.rover.silence(Fault.RIGHT_BOARD)
            await asyncio.sleep(1.3)
            assert r.why_idle == "no word from the right motor driver for 1 s"
            assert not s.controller.drive.permitted

    play(scene)


def test_without_a_word_from_the_rover_nothing_can_be_enabled():
    async def scene(s: Scenery) -> None:
        s.mute = True
        async with s.client(1) as r:
            with pytest.raises(NoAnswerError, match="no word from the right motor driver and the left motor driver"):
                await r.enable(timeout=1.0)
            await asyncio.sleep(1.5)
            assert r.lost == "nothing heard for 2 s"
            with pytest.raises(NoAnswerError, match="enable: nothing heard for 2 s"):
                await r.enable()
            with pytest.raises(NoAnswerError, match="stop: nothing heard"):
                await r.stop()

    play(scene)


def test_a_lost_link_ends_the_drive_and_needs_a_new_permission():
    async def scene(s: Scenery) -> None:
        async with s.client(1) as r:
            await r.enable()
            await r.drive(0.5, hold=10.0)
            link = r._bus._port
            link.changed(False, "unplugged")
            with pytest.raises(NoAnswerError, match="drive: unplugged"):
                await r.drive(0.5)
            link.changed(True, "")
            await asyncio.sleep(0.1)
            with pytest.raises(RefusedError, match="not enabled: the link was lost: unplugged"):
                await r.drive(0.5)
            await asyncio.sleep(0.6)
            assert not s.controller.drive.permitted
            await r.enable()

    play(scene)


@pytest.mark.parametrize(
    ("forward", "right", "hold", "text"),
    [
        (1.01, 0, 0.5, "forward: 1.01 is outside -1..1"),
        (0, -2, 0.5, "right: -2 is outside -1..1"),
        (float("nan"), 0, 0.5, "forward: nan is outside -1..1"),
        (0, 0, 11, "hold: 11 is outside 0..10"),
    ],
)
def test_what_is_out_of_range_is_told_and_not_sent(forward: float, right: float, hold: float, text: str):
    async def scene(s: Scenery) -> None:
        async with s.client(1) as r:
            await r.enable()
            with pytest.raises(EncodeError, match=text):
                await r.drive(forward, right, hold=hold)
            assert r.setpoint == (0, 0)

    play(scene)


def test_limits_are_said_while_we_drive_and_repeated():
    async def scene(s: Scenery) -> None:
        async with s.client(2) as r:
            await r.speed_limit(0.29)
            await r.power_limit(1)
            assert s.heard == []
            await r.enable()
            await r.current_limit(0.1)
            await asyncio.sleep(2.2)
            assert s.controller.drive.speed_limit == 5
            assert s.said(2, SpeedLimit.FRAME)[0] == b"\x05"
            assert s.said(2, PowerLimit.FRAME)[0] == b"\x14"
            assert s.said(2, CurrentLimit.FRAME)[0] == b"\x14"
            assert len(s.said(2, SpeedLimit.FRAME)) == 3
            with pytest.raises(EncodeError, match=r"speed limit: 0.04 is outside 0.05..1"):
                await r.speed_limit(0.04)

    play(scene)


def test_telemetry_is_typed_and_tells_its_age_and_worth():
    async def scene(s: Scenery) -> None:
        async with s.client(2) as r:
            assert r.battery.quality is Quality.NEVER
            assert r.position.latitude_deg is None
            with pytest.raises(NoAnswerError, match="MotorCurrentRight: never heard"):
                r.telemetry[MotorCurrentRight]
            await asyncio.sleep(1.5)
            current = r.telemetry[MotorCurrentRight]
            assert current.frame.front == pytest.approx(0.0, abs=0.3)
            assert (current.quality, current.age < 0.1) == (Quality.FRESH, True)
            assert r.battery.state is BatteryState.OK
            assert r.battery.cells == pytest.approx([4.1] * 4, abs=0.1)
            assert len(r.battery.temperatures_c) == 6
            assert r.position.latitude_deg == pytest.approx(52.2194, abs=1e-4)
            assert [(wheel.side, wheel.place) for wheel in r.wheels][3] == ("right", "front")
            assert {wheel.quality for wheel in r.wheels} == {Quality.FRESH}
            assert r.link.share == 1.0
            s.mute = True
            await asyncio.sleep(2.0)
            assert r.telemetry[MotorCurrentRight].quality is Quality.STALE
            assert r.telemetry[MotorTemperatureLeft].quality is Quality.FRESH
            assert GpsPosition in set(r.telemetry)

    play(scene)


def test_frames_are_read_as_they_come_until_the_block_is_left():
    async def scene(s: Scenery) -> None:
        kinds = set()

        async def read(frames) -> None:
            async for frame in frames:
                kinds.add(type(frame))

        async with s.client(2) as r:
            reading = asyncio.create_task(read(r.frames()))
            await asyncio.sleep(1.2)
        await reading
        assert len(kinds) == 14

    play(scene)


def test_own_frames_are_said_and_those_with_a_method_are_not():
    async def scene(s: Scenery) -> None:
        async with s.client(2) as r:
            await r.send(PowerLimit(steps=3))
            assert s.said(2, 115) == [b"\x03"]
            for frame in (DriveCommand(x=0, y=0), GpsPosition(latitude_deg=1.0, longitude_deg=1.0)):
                with pytest.raises(EncodeError, match="not a frame to send"):
                    await r.send(frame)

    play(scene)


def test_what_is_asked_of_open_has_to_be_there():
    for mistake, fault, text in (
        ({"station": 5}, StationError, "5 is not 1"),
        ({"dialect": "strzyga-crx"}, ConfigError, 'did you mean "strzyga-crc"'),
        ({"calibration": "physics"}, ConfigError, "physics"),
        ({"url": "tpc://a:1"}, LinkError, "unknown scheme"),
    ):
        with pytest.raises(fault, match=text):
            Rover.open(**({"url": "tcp://a:1", "station": 2} | mistake))
    assert timonel.Rover is Rover


def test_the_owners_frames_are_read_from_their_file():
    r = Rover.open("tcp://127.0.0.1:1", station=2, frames=DOCS / "own_frames.toml", calibration="documented")
    assert r.protocol.declaration(160).__name__ == "ArmJoints"
    assert r.protocol.calibration.encoder_pulses == 1


def test_through_an_operators_gateway_the_client_drives_the_controller_at_the_far_end_of_its_uart():
    async def scene(s: Scenery) -> None:
        uart = UartBus(Tapped(s, 1), Strzyga(s.protocol.lengths(Party.OPERATOR)))
        socket = Socket("desk")
        now = asyncio.get_running_loop().time()
        far = Controller(RoverSettings(role="operator"), [Port("desk", 1)], now, s.protocol)
        gateway = Gateway(far, uart, [Channel("desk", socket, socket)])
        await gateway.open()
        cable = Cable(socket, "desk", delay=0.01)
        bus = UartBus(cable, Strzyga(s.protocol.lengths(Party.OPERATOR)))
        async with Rover(bus, s.protocol, station=1) as r:
            await asyncio.sleep(0.5)
            await r.enable()
            await r.drive(0.5, hold=3.0)
            await asyncio.sleep(2.0)
            assert s.speed > 0.3
        assert s.rover.setpoints == ((0, 0, 0), (0, 0, 0))
        assert s.said(1, 102, 103) == []
        await gateway.close(0.0)

    play(scene)


def test_who_is_enabled_is_not_enabled_again():
    async def scene(s: Scenery) -> None:
        async with s.client(1) as r:
            await r.enable()
            s.heard.clear()
            await r.enable()
            assert s.said(1, 101) == []

    play(scene)


def test_a_permission_that_does_not_count_is_not_taken_for_one():
    async def scene(s: Scenery) -> None:
        async with s.client(1) as operator, s.client(2) as jetson:
            await operator.enable()
            await operator.stop()
            with pytest.raises(NoAnswerError, match="the motor drivers do not run; somebody else may be in command"):
                await jetson.enable(timeout=1.0)
            assert s.said(2, 101)
            assert not s.controller.drive.permitted
            await jetson.enable()
            assert s.controller.helm.transfer.commander == 2

    play(scene)


def test_a_reader_that_does_not_read_hears_the_newest():
    async def scene(s: Scenery) -> None:
        frames = Frames()
        for steps in range(1, KEPT + 3):
            frames.put(PowerLimit(steps=steps))
        assert (await anext(frames)).steps == 3

    play(scene)


def test_what_cannot_be_opened_is_closed():
    async def scene(s: Scenery) -> None:
        class Broken(Tapped):
            async def open(self, receive, changed):
                await super().open(receive, changed)
                raise asyncio.CancelledError

        link = Broken(s, 2)
        r = Rover(UartBus(link, Strzyga(s.protocol.lengths(Party.OPERATOR))), s.protocol, station=2)
        with pytest.raises(asyncio.CancelledError):
            await r.__aenter__()
        assert link.closed

    play(scene)
