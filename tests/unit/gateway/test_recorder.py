import asyncio
import errno
import os
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from tests.unit.gateway.fakes import FakeBus, FakePort, FakeVehicle
from timonel.core.alerts import AlertChanged
from timonel.core.command import Transferred
from timonel.core.effects import Effect, Rejected, Say, Transmit
from timonel.core.frame import Frame
from timonel.gateway import gateway as gateway_module
from timonel.gateway import recorder as recorder_module
from timonel.gateway.configuration import Configuration, parse
from timonel.gateway.gateway import Channel, Gateway
from timonel.gateway.moment import microseconds, moment, seconds
from timonel.gateway.recorder import Keeper, Recorder, event_message, front
from timonel.gateway.recording import recorded
from timonel.gateway.recording_settings import Recording
from timonel.recording import flight_writer
from timonel.recording.flight import BUS, Flight, Metadata, Record
from timonel.recording.flight_bus import frames_of
from timonel.recording.flight_tape import Page
from timonel.vehicles.boat.settings import BoatSettings

FRAME = Frame(0x09F11223, bytes(8))
HEADING = Say(b"$IIHDT,182.3,T*2F\r\n", "HDT")
STATUS = Say(b"$PARP,STATUS\r\n", "STATUS", urgent=True)
ANSWER: list[Effect] = [HEADING, Transferred(1, 2), Transmit(FRAME), STATUS]
EMPTY: Metadata = {}


class Rig:
    """A gateway between fakes, recorded into a directory."""

    def __init__(self, directory: Path, decoded: bool = False) -> None:
        self.directory = directory
        self.vehicle = FakeVehicle()
        self.bus = FakeBus()
        self.bridge = FakePort("Bridge")
        self.gateway = Gateway(self.vehicle, self.bus, [Channel("Bridge", self.bridge, self.bridge)])
        recording = Recording(str(directory), decoded=decoded)
        self.configuration = Configuration("test", BoatSettings(name="test"), "loop://a", recording=recording)

    def keeper(self) -> Keeper:
        return Keeper(self.gateway, self.configuration, lambda number: EMPTY)

    def records(self) -> list[Record]:
        return [record for path in sorted(self.directory.iterdir()) for record in Flight(path)]

    def notes(self) -> list[dict[str, object]]:
        return [record.fields for record in self.records() if record.topic == "recorder"]


@asynccontextmanager
async def a_recorded_gateway(directory: Path, decoded: bool = False) -> AsyncIterator[Rig]:
    rig = Rig(directory, decoded)
    async with recorded(rig.gateway, rig.configuration):
        await rig.gateway.open()
        yield rig
        await rig.gateway.close()


def told(records: list[Record]) -> list[tuple[str, int, object]]:
    """Topic, step and content of what the machine was told and answered."""
    return [
        (record.topic, record.step, None if record.topic == BUS else record.fields)
        for record in records
        if record.topic != "recorder"
    ]


# What is recorded -------------------------------------------------------------------------------------


def test_what_the_vehicle_is_told_and_what_it_answers_is_one_step(tmp_path: Path) -> None:
    async def scene() -> Rig:
        async with a_recorded_gateway(tmp_path) as rig:
            rig.vehicle.answers["bytes"] = ANSWER
            rig.bridge.receive(b"$PARP,TAKECMD\xff\r\n")
            return rig

    rig = asyncio.run(scene())
    assert told(rig.records()) == [
        ("in/Bridge", 0, {"text": "$PARP,TAKECMD\xff\r\n"}),
        ("events", 0, {"type": "Transferred", "previous": 1, "commander": 2}),
        ("out/all", 0, {"text": "$IIHDT,182.3,T*2F\r\n$PARP,STATUS\r\n"}),
        ("bus", 0, None),
    ]
    (frame,) = frames_of(rig.records()[-1].data, 0)
    assert (frame.identifier, frame.sent) == (FRAME.identifier, True)


def test_frames_ports_and_time_are_steps_too(tmp_path: Path) -> None:
    async def scene() -> Rig:
        async with a_recorded_gateway(tmp_path) as rig:
            rig.bus.receive([FRAME, FRAME])
            rig.bridge.changed(True, "")
            rig.vehicle.deadline = asyncio.get_running_loop().time()
            rig.bus.receive([FRAME])
            await asyncio.sleep(0.01)
            return rig

    records = asyncio.run(scene()).records()
    assert told(records)[:2] == [("ports", 1, {"port": "Bridge", "connected": True}), ("timer", 3, {})]
    assert [frame.step for frame in frames_of(records[-1].data, records[-1].step)] == [0, 0, 2]


def test_the_time_of_a_step_is_the_time_that_the_vehicle_is_told(tmp_path: Path) -> None:
    times: list[float] = []

    class Watch(FakeVehicle):
        def receive_bytes(self, port: str, data: bytes, now: float) -> list[Effect]:
            times.append(now)
            return []

    async def scene() -> Rig:
        rig = Rig(tmp_path)
        rig.gateway.vehicle = Watch()
        async with recorded(rig.gateway, rig.configuration):
            await rig.gateway.open()
            for _ in range(50):
                rig.bridge.receive(b"a")
                await asyncio.sleep(0.0001)
        return rig

    records = [record for record in asyncio.run(scene()).records() if record.topic == "in/Bridge"]
    assert [record.now_ns % 1000 for record in records] == [0] * 50
    assert [seconds(record.now_ns // 1000) for record in records] == times


@given(st.floats(0, (1 << 51) / 1e6))
def test_a_moment_survives_its_microseconds(clock: float) -> None:
    now = moment(clock)
    assert abs(now - clock) <= 0.5e-6 + clock * 2**-52
    assert seconds(microseconds(now)) == now


def test_links_and_faults_are_noted(tmp_path: Path) -> None:
    async def scene() -> Rig:
        async with a_recorded_gateway(tmp_path) as rig:
            rig.bus.changed(False, "no such device")
            rig.vehicle.fault = ZeroDivisionError()
            rig.bus.receive([FRAME])
            return rig

    assert asyncio.run(scene()).notes() == [
        {"type": "Link", "link": "bus", "connected": False, "reason": "no such device"},
        {"type": "Fault", "source": "bus"},
    ]


def test_bytes_in_an_event_are_characters_and_all_of_them() -> None:
    event = Rejected("malformed", bytes(range(256)), "Bridge")
    assert event_message(event).decode() == event_message(event).decode("utf-8")
    made = Record("events", 0, 0, 0, event_message(event)).fields
    assert made["data"].encode("latin-1") == event.data


def test_messages_in_clear_are_recorded_on_topics_of_their_own(tmp_path: Path) -> None:
    async def scene() -> Rig:
        async with a_recorded_gateway(tmp_path, decoded=True) as rig:
            rig.bus.receive([Frame(0x09F11223, bytes.fromhex("FF725AFF7FFF7FFD"))])
            rig.bus.receive([Frame(0x09F80223, bytes.fromhex("FFFC725A0100FFFF"))])
            return rig

    decoded = {record.topic: record.fields for record in asyncio.run(scene()).records() if "decoded" in record.topic}
    assert decoded["decoded/VesselHeading"]["heading"] == pytest.approx(2.3154)
    assert decoded["decoded/VesselHeading"]["reference"] == "MAGNETIC"
    assert decoded["decoded/VesselHeading"]["deviation"] is None
    assert set(decoded) == {"decoded/VesselHeading", "decoded/CogSogRapidUpdate"}


# Nobody waits for it ----------------------------------------------------------------------------------


def test_a_recorder_that_falls_over_is_left_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError

    async def scene() -> Rig:
        async with a_recorded_gateway(tmp_path) as rig:
            monkeypatch.setattr(recorder_module, "text", fail)
            rig.vehicle.answers["bytes"] = [HEADING]
            rig.bridge.receive(b"a")
            assert rig.gateway.recorder is None
            rig.bridge.receive(b"b")
            return rig

    rig = asyncio.run(scene())
    assert [what for what in rig.vehicle.told if what[0] == "bytes"] == [
        ("bytes", "Bridge", b"a"),
        ("bytes", "Bridge", b"b"),
    ]
    assert rig.bridge.lines == [HEADING.line] * 2
    assert rig.gateway.health.counts["fault"] == 1
    assert not rig.gateway.failed.is_set()


def test_without_a_table_nothing_is_recorded(tmp_path: Path) -> None:
    async def scene() -> None:
        rig = Rig(tmp_path)
        async with recorded(rig.gateway, replace(rig.configuration, recording=None)):
            assert rig.gateway.recorder is None

    asyncio.run(scene())
    assert list(tmp_path.iterdir()) == []


class Told:
    """An observer of the alerts."""

    def __init__(self) -> None:
        self.alerts: list[tuple[bool, str]] = []

    def frames_received(self, frames: object, now: float) -> None: ...
    def port(self, name: str, connected: bool, now: float) -> None: ...

    def effect(self, effect: Effect, now: float) -> None:
        if isinstance(effect, AlertChanged):
            self.alerts.append((effect.alert.active, effect.alert.text))


def full(fd: int, data: bytes) -> int:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


async def looks(keeper: Keeper, condition: Callable[[], object]) -> None:
    """Flush until the writer has seen it."""
    for _ in range(1000):
        keeper.look()
        if condition():
            return
        await asyncio.sleep(0.005)
    raise AssertionError("it did not come")


def test_a_full_disk_is_an_alert_until_recording_goes_on_and_the_gap_is_noted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(flight_writer, "RETRY", 0.0)

    async def scene() -> tuple[Rig, Told]:
        rig, observer = Rig(tmp_path), Told()
        rig.gateway.observers.append(observer)
        keeper = rig.keeper()
        keeper.start()
        await rig.gateway.open()
        rig.vehicle.answers["bytes"] = [HEADING]
        with monkeypatch.context() as patch:
            patch.setattr(os, "write", full)
            rig.bridge.receive(b"lost")
            await looks(keeper, lambda: observer.alerts)
            assert keeper.writer.written.lost_steps == 1
            assert rig.bridge.lines == [HEADING.line]  # nobody noticed
        rig.bridge.receive(b"kept")
        await looks(keeper, lambda: len(observer.alerts) > 1)
        await keeper.close()
        await rig.gateway.close()
        return rig, observer

    rig, observer = asyncio.run(scene())
    text = "nothing is recorded: No space left on device"
    assert observer.alerts == [(True, text), (False, text)]
    assert [fields for topic, _, fields in told(rig.records()) if topic == "in/Bridge"] == [{"text": "kept"}]
    assert {"type": "Gap", "steps": 1} in rig.notes()
    assert rig.gateway.health.counts["AlertChanged"] == 2


def test_a_disk_that_is_too_slow_is_an_alert(tmp_path: Path) -> None:
    async def scene() -> Told:
        rig, observer = Rig(tmp_path), Told()
        rig.gateway.observers.append(observer)
        keeper = rig.keeper()
        await rig.gateway.open()
        rig.gateway.recorder = keeper.recorder  # and nobody writes
        for _ in range(flight_writer.PAGES + 2):
            rig.bridge.receive(b"a")
            keeper.look()
        await rig.gateway.close()
        return observer

    assert asyncio.run(scene()).alerts == [(True, "nothing is recorded: the disk is too slow")]


# Time -------------------------------------------------------------------------------------------------


def test_a_clock_that_was_set_is_noted_and_a_drift_is_not() -> None:
    pages: list[Page] = []
    wall = 1_000_000_000
    recorder = Recorder(["a"], pages.append, 0.0, wall=lambda: wall)
    wall += 1_010_000_000
    recorder.flush(1.0)
    recorder.expired(1.5)
    wall += 3600 * 10**9
    recorder.flush(2.0)
    recorder.expired(2.5)
    recorder.flush(2.5)
    stamps = [index for page in pages for index in page.indexes.items()]
    assert [(page.first, page.last) for page in pages] == [
        (2_510_000_000, 2_510_000_000),
        (3_602_010_000_000 - 0, 3_602_510_000_000),
    ]
    assert len(stamps) == 3
    assert b'{"type":"ClockStep","seconds":3599.0}' in pages[1].data


def test_a_page_that_grows_is_handed_over_between_two_steps() -> None:
    pages: list[Page] = []
    recorder = Recorder(["a"], pages.append, 0.0)
    for number in range(300):
        recorder.bytes_received("a", bytes(5000), seconds(number))
        recorder.answered([HEADING], seconds(number))
    assert len(pages) > 1
    assert [page.steps for page in pages] == [len(page.indexes[2]) // 16 for page in pages]


# What stands at the front -----------------------------------------------------------------------------

TOML = """[vehicle]
kind = "rover"
frames = "own.toml"

[bus]
url = "loop://a"

[[station]]
id = 1
url = "tcp-listen://127.0.0.1:5001"
"""


def test_the_front_says_what_the_machine_was_made_from(tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(
        '[[frame]]\nid = 170\nname = "Gripper"\nto = "rover"\nfields = [{ name = "a", type = "u8" }]\n'
    )
    configuration = parse(TOML, str(tmp_path / "rover.toml"))

    async def scene() -> list[Metadata]:
        rig = Rig(tmp_path)
        made = front(rig.gateway, configuration, simulated=True, seed=7)
        return [made(0), made(1)]

    first, second = asyncio.run(scene())
    assert first["timonel.recording"] | {"segment": "1"} == second["timonel.recording"]
    assert (first["timonel.recording"]["simulated"], first["timonel.recording"]["seed"]) == ("yes", "7")
    assert first["timonel.machine"]["vehicle"] == "rover"
    assert first["timonel.machine"]["frames"] == (tmp_path / "own.toml").read_text()
    assert first["timonel.configuration"] == {"file": str(tmp_path / "rover.toml"), "text": TOML}
    assert set(first["timonel.versions"]) == {"timonel", "python", "msgspec"}
    assert len(first["timonel.recording"]["boot_id"]) == 36


def test_no_secret_is_recorded(tmp_path: Path) -> None:
    broker = '[mqtt]\nurl = "mqtt://boat:{}@10.0.0.2"\n'
    text = '[web]\ntoken = "correct horse battery"\nlisten = "127.0.0.1:8080"\n' + broker.format("secret")

    async def scene() -> Metadata:
        rig = Rig(tmp_path)
        return front(rig.gateway, replace(rig.configuration, text=text))(0)

    recorded_text = asyncio.run(scene())["timonel.configuration"]["text"]
    expected = '[web]\ntoken = (not recorded)\nlisten = "127.0.0.1:8080"\n' + broker.format("(not recorded)")
    assert recorded_text == expected


def test_a_computer_that_does_not_tell_its_boot_is_recorded_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder_module, "BOOT_ID", tmp_path / "nothing")

    async def scene() -> Metadata:
        rig = Rig(tmp_path)
        return front(rig.gateway, rig.configuration)(0)

    assert asyncio.run(scene())["timonel.recording"]["boot_id"] == ""


def test_the_gateway_lets_the_recorder_know_before_anything_is_done(tmp_path: Path) -> None:
    """What was intended is on record even if carrying it out fails."""

    async def scene() -> Rig:
        async with a_recorded_gateway(tmp_path) as rig:
            rig.vehicle.answers["frames"] = [Transmit(FRAME)]
            rig.bus.send = lambda frames: 1 / 0  # type: ignore[method-assign, assignment, return-value]
            rig.bus.receive([FRAME])
            return rig

    records = [record for record in asyncio.run(scene()).records() if record.topic == BUS]
    assert [frame.sent for record in records for frame in frames_of(record.data, record.step)] == [False, True]
    assert gateway_module.FAULTS > 1
