import asyncio
import logging
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager

import pytest

from tests.unit.gateway.fakes import FakeBus, FakePort, FakeVehicle
from timonel.core.command import Transferred
from timonel.core.effects import Effect, Say, SayTo, Transmit
from timonel.core.frame import Frame
from timonel.gateway.gateway import FAULTS, Channel, Gateway

HEADING = Say(b"$IIHDT,182.3,T*2F\r\n", "HDT")
DEPTH = Say(b"$IIDPT,4.1,0.0*6B\r\n", "DPT")
STATUS = Say(b"$PARP,STATUS,STANDBY,000.0,182.3,+0.0,00*5D\r\n", "STATUS", urgent=True)
FRAME = Frame(0x09F11223, bytes(8))


class Rig:
    """A gateway between fakes: a bridge with one link, a cockpit with two, and a listener."""

    def __init__(self, flush: float) -> None:
        self.vehicle = FakeVehicle()
        self.bus = FakeBus()
        self.bridge = FakePort("Bridge")
        self.cockpit_in = FakePort("Cockpit")
        self.cockpit_out = FakePort("Cockpit OUT")
        self.plotter = FakePort("Plotter")
        self.gateway = Gateway(
            self.vehicle,
            self.bus,
            [
                Channel("Bridge", self.bridge, self.bridge),
                Channel("Cockpit", self.cockpit_in, self.cockpit_out),
                Channel("Plotter", None, self.plotter),
            ],
            flush=flush,
        )

    @property
    def outs(self) -> list[FakePort]:
        return [self.bridge, self.cockpit_out, self.plotter]

    def hear(self, answer: Sequence[Effect]) -> None:
        """A frame comes in, and the vehicle wants `answer` done."""
        self.vehicle.answers["frames"] = list(answer)
        self.bus.receive([FRAME])


@asynccontextmanager
async def a_gateway(flush: float = 0.0) -> AsyncIterator[Rig]:
    rig = Rig(flush)
    await rig.gateway.open()
    yield rig
    await rig.gateway.close()


def test_an_order_for_one_port_goes_to_that_port_alone_ahead_of_its_data() -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            rig.hear([SayTo(b"$AGHTC,V,,,H,N,,,,,45.5,,,M*72\r\n", "HTC", "Plotter")])
            assert (rig.bridge.lines, rig.cockpit_out.lines) == ([], [])
            ((line,),) = rig.plotter.batches
            assert (line.key, line.urgent, line.state) == ("HTC", True, True)
            rig.hear([SayTo(b"x", "HTC", "nowhere")])
            assert len(rig.plotter.batches) == 1

    asyncio.run(scene())


def test_what_the_vehicle_says_goes_to_every_out_link_and_to_no_in_link() -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            rig.hear([HEADING])
            assert [out.lines for out in rig.outs] == [[HEADING.line]] * 3
            assert rig.cockpit_in.lines == []

    asyncio.run(scene())


def test_a_line_is_the_same_object_for_all_links() -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            rig.hear([HEADING])
            assert {id(out.batches[0][0]) for out in rig.outs} == {id(HEADING)}

    asyncio.run(scene())


def test_the_lines_of_a_batch_of_frames_are_sent_together() -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            rig.hear([HEADING, DEPTH])
            assert rig.bridge.batches == [[HEADING, DEPTH]]

    asyncio.run(scene())


def test_an_urgent_line_goes_ahead_of_the_data_of_its_batch() -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            rig.hear([HEADING, STATUS])
            assert rig.bridge.lines == [STATUS.line, HEADING.line]

    asyncio.run(scene())


def test_with_a_flush_time_data_of_several_batches_is_sent_together() -> None:
    async def scene() -> None:
        async with a_gateway(flush=0.005) as rig:
            rig.hear([HEADING])
            rig.hear([DEPTH])
            assert rig.bridge.batches == []
            await asyncio.sleep(0.02)
            assert rig.bridge.batches == [[HEADING, DEPTH]]

    asyncio.run(scene())


def test_with_a_flush_time_an_urgent_line_waits_for_nothing() -> None:
    async def scene() -> None:
        async with a_gateway(flush=0.005) as rig:
            rig.hear([HEADING, STATUS])
            assert rig.bridge.batches == [[STATUS]]

    asyncio.run(scene())


def test_a_closing_gateway_sends_what_was_waiting_for_its_flush() -> None:
    async def scene() -> None:
        async with a_gateway(flush=5.0) as rig:
            rig.hear([HEADING])
        assert rig.bridge.lines == [HEADING.line]

    asyncio.run(scene())


def test_frames_for_the_bus_are_sent_in_one_go() -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            rig.hear([Transmit(FRAME), HEADING, Transmit(FRAME)])
            assert rig.bus.batches == [[FRAME, FRAME]]

    asyncio.run(scene())


def test_bytes_of_a_station_reach_the_vehicle_with_the_name_of_its_port() -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            rig.cockpit_in.receive(b"$PARP")
            assert rig.vehicle.told == [("bytes", "Cockpit", b"$PARP")]

    asyncio.run(scene())


def test_what_a_listener_says_is_heard_by_nobody() -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            rig.plotter.receive(b"$PARP,ENGAGE,000.0,01*1F\r\n")
            rig.cockpit_out.receive(b"$PARP,ENGAGE,000.0,02*1C\r\n")
            assert rig.vehicle.told == []

    asyncio.run(scene())


def test_the_vehicle_is_told_of_stations_that_come_and_go_and_of_no_other_link() -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            rig.bridge.changed(False, "unplugged")
            rig.cockpit_out.changed(False, "unplugged")
            rig.plotter.changed(True, "readers: 1")
            rig.bus.changed(False, "bus off")
            assert rig.vehicle.told == [("port", "Bridge", False)]

    asyncio.run(scene())


def test_the_vehicle_is_told_the_time_when_its_deadline_has_come() -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            loop = asyncio.get_running_loop()
            due = rig.vehicle.deadline = loop.time() + 0.02
            rig.hear([])
            await asyncio.sleep(0.06)
            assert len(rig.vehicle.expired) == 1
            assert rig.vehicle.expired[0] >= due

    asyncio.run(scene())


def test_a_deadline_that_moves_nearer_is_met() -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            loop = asyncio.get_running_loop()
            rig.vehicle.deadline = loop.time() + 60
            rig.hear([])
            rig.vehicle.deadline = loop.time() + 0.01
            rig.hear([])
            await asyncio.sleep(0.05)
            assert len(rig.vehicle.expired) == 1

    asyncio.run(scene())


def test_a_deadline_of_a_vehicle_that_is_told_nothing_is_met_too() -> None:
    async def scene() -> None:
        rig = Rig(flush=0.0)
        rig.vehicle.deadline = asyncio.get_running_loop().time()
        rig.vehicle.answers["expire"] = [STATUS]
        await rig.gateway.open()
        await asyncio.sleep(0.05)
        await rig.gateway.close()
        assert rig.bridge.lines == [STATUS.line]

    asyncio.run(scene())


def test_a_fault_of_our_own_is_logged_with_the_links_name_and_the_rest_goes_on(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            rig.vehicle.fault = ZeroDivisionError()
            rig.cockpit_in.receive(b"$")
            rig.vehicle.fault = None
            rig.hear([HEADING])
            assert rig.bridge.lines == [HEADING.line]
            assert not rig.gateway.failed.is_set()

    asyncio.run(scene())
    [record] = [record for record in caplog.records if record.levelno == logging.ERROR]
    assert record.getMessage() == "Cockpit: fault in the gateway itself"
    assert record.exc_info is not None


def test_a_gateway_whose_faults_come_thick_gives_up() -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            rig.vehicle.fault = ZeroDivisionError()
            for _ in range(FAULTS - 1):
                rig.cockpit_in.receive(b"$")
            assert not rig.gateway.failed.is_set()
            rig.cockpit_in.receive(b"$")
            assert rig.gateway.failed.is_set()

    asyncio.run(scene())


def test_a_fault_in_what_is_due_is_tried_again() -> None:
    async def scene() -> None:
        rig = Rig(flush=0.0)
        rig.vehicle.deadline = 0.0
        rig.vehicle.fault = ZeroDivisionError()
        await rig.gateway.open()
        await asyncio.sleep(0.05)
        rig.vehicle.fault = None
        await asyncio.sleep(0.2)
        await rig.gateway.close()
        assert rig.vehicle.told == [("expire",)] * 2

    asyncio.run(scene())


class Notes:
    """An observer."""

    def __init__(self) -> None:
        self.seen: list[object] = []

    def frames_received(self, frames: Sequence[Frame], now: float) -> None:
        self.seen += frames

    def effect(self, effect: Effect, now: float) -> None:
        self.seen.append(effect)

    def port(self, name: str, connected: bool, now: float) -> None:
        self.seen.append((name, connected))


def test_an_observer_sees_frames_effects_and_links() -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            notes = Notes()
            rig.gateway.observers.append(notes)
            rig.hear([HEADING, Transferred(0, 1), Transmit(FRAME)])
            rig.plotter.changed(True, "")
            assert notes.seen == [FRAME, HEADING, Transferred(0, 1), Transmit(FRAME), ("Plotter", True)]

    asyncio.run(scene())


def test_an_observer_that_falls_over_sees_no_more_and_takes_nobody_along() -> None:
    class Clumsy(Notes):
        def effect(self, effect: Effect, now: float) -> None:
            raise ZeroDivisionError

    async def scene() -> None:
        async with a_gateway() as rig:
            notes = Notes()
            rig.gateway.observers += [Clumsy(), notes]
            for _ in range(FAULTS):
                rig.hear([HEADING])
            assert rig.gateway.observers == [notes]
            assert notes.seen == [FRAME, HEADING] * FAULTS
            assert rig.bridge.lines == [HEADING.line] * FAULTS
            assert not rig.gateway.failed.is_set()

    asyncio.run(scene())


def test_events_are_counted() -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            rig.hear([Transferred(0, 1), HEADING])
            assert rig.gateway.health.counts == {"Transferred": 1}

    asyncio.run(scene())


def test_every_link_is_opened_once_and_closed_once_and_hears_nothing_any_more() -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            pass
        links: list[FakeBus | FakePort] = [rig.bus, rig.bridge, rig.cockpit_in, rig.cockpit_out, rig.plotter]
        assert [(link.opened, link.closed) for link in links] == [(1, 1)] * 5
        rig.bridge.receive(b"$PARP")
        assert rig.vehicle.told == []

    asyncio.run(scene())


def test_a_link_that_is_attached_is_opened_heard_by_its_owner_alone_and_closed() -> None:
    async def scene() -> None:
        rig, link, heard = Rig(0.0), FakePort("Raw"), []
        rig.gateway.attach(link, heard.append)
        await rig.gateway.open()
        link.changed(True, "")
        link.receive(b"hello")
        rig.hear([HEADING])
        assert (heard, link.batches, rig.gateway.connections["Raw"].connected) == ([b"hello"], [], True)
        assert [told for told in rig.vehicle.told if told[0] == "bytes"] == []
        await rig.gateway.close()
        link.receive(b"too late")
        assert (link.closed, heard) == (1, [b"hello"])

    asyncio.run(scene())


def test_what_an_attached_link_says_cannot_bring_the_gateway_down() -> None:
    def fall_over(data: bytes) -> None:
        raise ZeroDivisionError

    async def scene() -> None:
        rig, link = Rig(0.0), FakePort("Raw")
        rig.gateway.attach(link, fall_over)
        await rig.gateway.open()
        link.receive(b"hello")
        assert rig.gateway.health.counts["fault"] == 1
        await rig.gateway.close()

    asyncio.run(scene())


def test_frames_that_are_injected_go_on_the_bus_and_are_heard_as_all_that_is_there() -> None:
    async def scene() -> None:
        async with a_gateway() as rig:
            rig.vehicle.answers["frames"] = [HEADING]
            rig.gateway.inject("Raw", [FRAME])
            assert rig.bus.batches == [[FRAME]]
            assert rig.vehicle.told == [("frames", FRAME)]
            assert rig.bridge.lines == [HEADING.line]

    asyncio.run(scene())
