import asyncio

from tests.unit.links.far_side import Ear
from timonel.core.frame import Frame
from timonel.links import loop
from timonel.links.loop import LoopLink

FRAMES = [Frame(number, b"") for number in range(5)]


async def end(name: str) -> tuple[LoopLink, Ear]:
    link, ear = LoopLink(name), Ear()
    await link.open(ear.receive_frames, ear.changed)
    return link, ear


def test_every_other_end_hears_the_frames_in_order_and_the_sender_does_not():
    async def session():
        (one, heard_by_one), (two, heard_by_two), (_, heard_by_three) = [await end("boat") for _ in range(3)]
        one.send(FRAMES[:2])
        two.send(FRAMES[2:])
        assert heard_by_three.frames == []
        await asyncio.sleep(0)
        assert heard_by_one.frames == FRAMES[2:]
        assert heard_by_two.frames == FRAMES[:2]
        assert heard_by_three.frames == FRAMES
        assert (one.counters.frames_out, one.counters.frames_in) == (2, 3)
        assert heard_by_one.changes == [(True, "")]

    asyncio.run(session())


def test_two_names_are_two_buses():
    async def session():
        (one, _), (_, heard_by_other) = await end("boat"), await end("rover")
        one.send(FRAMES)
        await asyncio.sleep(0)
        assert heard_by_other.frames == []

    asyncio.run(session())


def test_a_closed_end_hears_nothing_more_and_what_it_sends_is_dropped():
    async def session():
        (one, _), (two, heard_by_two) = await end("boat"), await end("boat")
        one.send(FRAMES)
        await two.close()
        one.send(FRAMES)
        two.send(FRAMES)
        await asyncio.sleep(0)
        assert heard_by_two.frames in ([], FRAMES)
        assert two.counters.dropped == 5

    asyncio.run(session())


def test_an_end_that_falls_behind_loses_the_oldest(monkeypatch):
    monkeypatch.setattr(loop, "QUEUE", 3)

    async def session():
        (one, _), (two, heard_by_two) = await end("boat"), await end("boat")
        one.send(FRAMES)
        await asyncio.sleep(0)
        assert heard_by_two.frames == FRAMES[2:]
        assert two.counters.overrun == 2

    asyncio.run(session())


def test_ends_that_answer_each_other_leave_the_loop_its_turn():
    async def session():
        (one, _), (two, _) = await end("boat"), await end("boat")
        turns = 0
        one._receive = one.send
        two._receive = two.send
        one.send(FRAMES)
        while two.counters.frames_in < 100:
            turns += 1
            await asyncio.sleep(0)
        assert turns >= 20

    asyncio.run(session())
