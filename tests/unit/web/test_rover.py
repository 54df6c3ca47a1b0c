"""What a rover shows."""

import asyncio

import msgspec
import pytest

from tests.unit.web.scene import HERE, Scene, configuration, scene
from timonel.core.frame import Frame
from timonel.gateway.assemble import assemble
from timonel.vehicles.rover import declared
from timonel.vehicles.rover.console import Console
from timonel.vehicles.rover.declaration import RoverFrame
from timonel.vehicles.rover.frames import BatteryState as State
from timonel.vehicles.rover.frames import (
    BatteryTemperature,
    BatteryVoltage,
    BmsStatus,
    DriverState,
    GpsPosition,
    MotorCurrentLeft,
    MotorDriverStatusLeft,
    MotorTemperatureLeft,
    WheelSpeedLeft,
)
from timonel.vehicles.rover.protocol import Protocol
from timonel.web.messages import RoverTopics
from timonel.web.rover import SAMPLES, RoverState
from timonel.web.state import Topics

OWN = """
[[frame]]
id = 160
name = "ArmJoints"
to = "operator"
segmented = true
fields = [
  { name = "j1", type = "i32" },
  { name = "j2", type = "i32", scale = 0.5, unit = "rad" },
  { name = "grip", type = "u8", labels = { 1 = "open", 2 = "shut" } },
]
"""


def topics(here: Scene, later: float = 0.0) -> Topics:
    return here.console.state.topics(here.gateway.now + later)


def can(message: RoverFrame) -> Frame:
    return Frame(*Protocol().encode(message), extended=False)


def test_all_topics_that_are_declared_are_told() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            assert topics(here).keys() == set(RoverTopics.__struct_fields__)
            assert here.console.state.samples(topics(here)).keys() == SAMPLES.keys()

    asyncio.run(play())


def test_a_wheel_has_set_point_speed_current_and_temperature() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            await here.hear(
                can(WheelSpeedLeft(front_rpm=30.0, middle_rpm=-20.0, rear_rpm=0.0)),
                can(MotorCurrentLeft(front=2.0, middle=1.0, rear=0.0)),
                can(MotorTemperatureLeft(front_c=25.0, middle_c=30.5, rear_c=35.0)),
                can(MotorDriverStatusLeft(status=DriverState.RUNNING)),
            )
            wheels = {(wheel.side, wheel.place): wheel for wheel in topics(here)["wheels"]}
            assert len(wheels) == 6
            front = wheels["left", "front"]
            assert front.rpm == pytest.approx(30.0, abs=0.1)
            assert front.current == pytest.approx(2.0, abs=0.05)
            assert (front.temperature, front.state, front.quality) == (298.15, "running", "fresh")
            assert wheels["left", "rear"].rpm == 0.0
            assert wheels["right", "front"].quality == "absent"
            assert wheels["right", "front"].rpm is None
            stale = topics(here, later=1.1)["wheels"][0]
            assert (stale.quality, stale.current, stale.state) == ("stale", None, None)
            assert here.console.state.samples(topics(here))["left_front_rpm"] == front.rpm
            assert here.console.state.samples(topics(here, later=1.1))["left_front_rpm"] is None

    asyncio.run(play())


def test_the_battery_has_cells_modules_and_a_state() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            await here.hear(
                can(BatteryVoltage(tap1=4.1, tap2=8.2, tap3=12.3, tap4=16.4)),
                can(BatteryTemperature(**{f"module{number}_c": 20.0 for number in range(1, 7)})),
                can(BmsStatus(status=State.UNDER_VOLTAGE)),
            )
            battery = topics(here)["battery"]
            assert battery.voltage == pytest.approx(16.4, abs=0.02)
            assert battery.cells == pytest.approx([4.1] * 4, abs=0.02)
            assert battery.modules == [293.15] * 6
            assert (battery.state, battery.quality) == ("under voltage", "fresh")

    asyncio.run(play())


def test_without_a_fix_there_is_no_position() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            await here.hear(can(GpsPosition(longitude_deg=None, latitude_deg=None)))
            gps = topics(here)["gps"]
            assert (gps.latitude, gps.quality) == (None, "absent")
            assert gps.at is not None
            await here.hear(can(GpsPosition(longitude_deg=21.0, latitude_deg=52.25)))
            assert topics(here)["gps"].latitude == 52.25

    asyncio.run(play())


def test_the_drive_shows_what_is_obeyed_forward_and_right_positive() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            rover, now = here.gateway.vehicle, here.gateway.now
            assert topics(here)["drive"].reason == "nobody has enabled the drives yet"
            said = Console.write(101, b"\x31") + Console.write(119, b"\x0a") + Console.write(100, b"\x14\xb0")
            for effect in rover.receive_bytes("Station 1 web", said, now):
                here.console.state.effect(effect, now)
            drive = here.console.state.topics(now)["drive"]
            assert (drive.permitted, drive.speed_limit, drive.reason) == (True, 0.5, "station 1")
            assert (drive.stick.x, drive.stick.y) == (0.2, 0.8)
            assert (drive.left, drive.right) == (0.5, 0.3)
            assert here.console.state.topics(now)["wheels"][0].setpoint == 0.5
            limits = topics(here)["limits"]
            assert (limits.power, limits.speed, limits.current) == (None, 10, None)
            rested = here.console.state.topics(now + 0.21)["drive"]
            assert (rested.stick.x, rested.stick.y, rested.left) == (0.0, 0.0, 0.0)

    asyncio.run(play())


def test_the_quality_of_the_link_counts_frames_a_second_and_what_was_rejected() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            state, now = here.console.state, here.gateway.now
            bms = can(BmsStatus(status=State.OK))
            state.topics(now)
            state.frames_received([bms] * 10, now)
            here.gateway.vehicle.receive_frames([Frame(99, b"", extended=False)], now)
            assert state.topics(now + 0.4)["quality"].frames == [], "it is looked at twice a second"
            quality = state.topics(now + 1.0)["quality"]
            (rate,) = quality.frames
            assert (rate.id, rate.name, rate.rate) == (118, "BmsStatus", 10.0)
            assert quality.rejected == 1
            assert quality.dialect == "strzyga"
            assert [framing.port for framing in quality.framing] == [f"Station {n} web" for n in (1, 2, 3, 4)]

    asyncio.run(play())


def test_what_is_no_telemetry_of_ours_is_not_shown() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            state, now = here.console.state, here.gateway.now
            wrong = [Frame(118, b"\x01"), Frame(118, b"\x01\x02", extended=False), Frame(7, b"\x01", extended=False)]
            state.frames_received(wrong, now)
            assert topics(here)["battery"].state is None
            state.topics(now)
            assert state.topics(now + 1.0)["quality"].frames == []

    asyncio.run(play())


def test_an_owners_frame_is_shown_with_names_units_and_words() -> None:
    async def play() -> None:
        made_of = msgspec.structs.replace(
            configuration("rover", HERE), protocol=Protocol(own=declared.parse(OWN, "own.toml"))
        )
        gateway = assemble(made_of)
        state = RoverState(gateway, made_of, gateway.vehicle)  # type: ignore[arg-type]
        whole = (7).to_bytes(4, "little") + (6).to_bytes(4, "little") + b"\x02"
        assert state.topics(1.0)["own"] == []
        state.frames_received([Frame(160, whole[:8], extended=False)], 1.0)
        assert state.topics(1.0)["own"] == []
        state.frames_received([Frame(160, whole[8:], extended=False)], 1.001)
        (own,) = state.topics(1.1)["own"]
        assert (own.id, own.name, own.quality) == (160, "ArmJoints", "fresh")
        assert [(each.name, each.unit, each.value) for each in own.values] == [
            ("j1", "", 7.0), ("j2", "rad", 3.0), ("grip", "", "shut"),
        ]  # fmt: skip

    asyncio.run(play())
