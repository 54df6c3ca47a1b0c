import asyncio
from contextlib import asynccontextmanager

from tests.unit.gateway.fakes import FakePort
from tests.unit.links.far_side import Ear, line, until
from timonel.core.effects import Say
from timonel.links.shaped import Shaped
from timonel.nmea0183.ration import Ration
from timonel.nmea0183.selection import Selection, Selector

HDT, MTW = Say(b"$IIHDT,182.3,T*2F\r\n", "HDT"), Say(b"$IIMTW,18.3,C*1E\r\n", "MTW")
ALARM = line("$IIALR,,301,A,V,bus silent*00", urgent=True)


@asynccontextmanager
async def a_port(selection=None, rate=None, connected=True):
    port, ear = FakePort("Plotter"), Ear()
    shaped = Shaped(port, None if selection is None else Selector(selection), None if rate is None else Ration(rate))
    await shaped.open(ear.receive, ear.changed)
    port.changed(connected, "")
    yield shaped, port, ear
    await shaped.close(0.0)


def run(scene):
    asyncio.run(scene())


def test_it_is_the_port_to_all_who_look_at_it():
    async def scene():
        async with a_port(Selection()) as (shaped, port, ear):
            port.receive(b"$PARP")
            assert (shaped.url, shaped.name, shaped.counters) == (port.url, port.name, port.counters)
            assert (ear.data, ear.changes, shaped.skipped) == (b"$PARP", [(True, "")], {})
        assert port.closed == 1

    run(scene)


def test_only_what_was_chosen_is_sent():
    async def scene():
        async with a_port(Selection(only=("HDT",))) as (shaped, port, _):
            shaped.send([MTW])
            shaped.send([HDT, MTW])
            assert port.batches == [[HDT]]

    run(scene)


def test_what_is_meant_for_this_port_alone_is_sent_whatever_is_chosen_of_the_rest():
    async def scene():
        async with a_port(Selection(only=("HDT",))) as (shaped, port, _):
            shaped.send_whatever([MTW])
            assert port.batches == [[MTW]]

    run(scene)


def test_what_has_no_room_now_is_sent_by_itself_when_there_is():
    async def scene():
        async with a_port(rate=4000.0) as (shaped, port, _):
            for _ in range(40):
                shaped.send([HDT])
                shaped.send([MTW])
            sent = len(port.lines)
            assert sent < 40
            await until(lambda: len(port.lines) == sent + 2)
            assert shaped.skipped.total() == 80 - sent - 2

    run(scene)


def test_an_urgent_line_does_not_wait_for_the_turn_of_data():
    async def scene():
        async with a_port(rate=100.0) as (shaped, port, _):
            for _ in range(40):
                shaped.send([HDT])
            shaped.send([ALARM])
            assert port.lines[-1] == ALARM.line

    run(scene)


def test_who_was_gone_does_not_hear_what_had_waited():
    async def scene():
        async with a_port(rate=2000.0) as (shaped, port, _):
            for _ in range(40):
                shaped.send([HDT])
            sent = len(port.lines)
            port.changed(False, "unplugged")
            port.changed(True, "")
            await asyncio.sleep(0.1)
            assert len(port.lines) == sent

    run(scene)


def test_while_nobody_is_there_the_port_itself_counts_what_is_lost():
    async def scene():
        async with a_port(rate=100.0, connected=False) as (shaped, port, _):
            for _ in range(40):
                shaped.send([HDT])
            assert len(port.lines) == 40

    run(scene)


def test_at_the_end_what_waits_goes_as_far_as_there_is_time():
    async def scene():
        async with a_port(rate=1000.0) as (shaped, port, _):
            for _ in range(20):
                shaped.send([HDT])
            sent = len(port.lines)
            shaped.send([MTW])
            await shaped.close(5.0)
            assert len(port.lines) == sent + 2

    run(scene)
