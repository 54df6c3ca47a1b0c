import asyncio
import gc
import os
import subprocess
import sys
import tty
import weakref
from collections.abc import Awaitable, Callable
from itertools import accumulate
from pathlib import Path

import pytest

import timonel
from tests.unit.gateway.concentrator import Cable, Concentrator, run
from timonel.errors import EncodeError, LinkError, NoAnswerError, RefusedError, StationError
from timonel.gateway.lookout import Back, Lost, Request, StatusChanged
from timonel.gateway.station import EVENTS_KEPT, Station, bursts
from timonel.gateway.verdict import Grant
from timonel.links.link import Changed
from timonel.nmea0183 import parp
from timonel.nmea0183.parp import CommandRequested, CommandTransferred, PilotMode, Verb

Scene = Callable[[Station, Concentrator], Awaitable[None]]


def play(
    scene: Scene, *, station: int = 2, commander: int = 2, holding: bool = False, esp32: bool = False
) -> Concentrator:
    """A scene between a station and a far end on which `commander` commands, half a second after it began."""

    async def main() -> Concentrator:
        far = Concentrator(esp32=esp32)
        far.commander = commander
        if holding:
            far.mode, far.setpoint = PilotMode.HEADING_HOLD, 1825
        async with Station(Cable(far, delay=0.01), station=station) as s:
            await asyncio.sleep(0.55)
            await scene(s, far)
        return far

    return run(main())


def now() -> float:
    return asyncio.get_running_loop().time()


# Steering -------------------------------------------------------------------------------------


def test_engage_returns_when_status_shows_heading_hold():
    async def scene(s: Station, far: Concentrator) -> None:
        await s.engage()
        assert s.status.mode is PilotMode.HEADING_HOLD
        assert s.status.setpoint_deg == 182.5

    assert play(scene).verbs == [Verb.ENGAGE]


def test_disengage_returns_when_status_shows_standby():
    async def scene(s: Station, far: Concentrator) -> None:
        await s.disengage()
        assert s.status.mode is PilotMode.STANDBY

    play(scene, holding=True)


def test_a_heading_is_set_to_the_tenth():
    async def scene(s: Station, far: Concentrator) -> None:
        await s.set_heading(45.53)
        assert s.status.setpoint_deg == 45.5

    play(scene, holding=True)


def test_three_hundred_and_sixty_degrees_are_north():
    async def scene(s: Station, far: Concentrator) -> None:
        await s.set_heading(360.0)
        assert s.status.setpoint_deg == 0.0

    play(scene, holding=True)


@pytest.mark.parametrize(("degrees", "setpoint"), [(1, 183.5), (-1, 181.5), (10, 192.5), (-23, 159.5), (178, 0.5)])
def test_a_turn_moves_the_set_point(degrees: int, setpoint: float):
    async def scene(s: Station, far: Concentrator) -> None:
        await s.turn(degrees)
        assert s.status.setpoint_deg == setpoint

    play(scene, holding=True)


@pytest.mark.parametrize(
    ("degrees", "verbs"),
    [
        (0, []),
        (1, [Verb.STBDONE]),
        (-1, [Verb.PORTONE]),
        (10, [Verb.STBDTEN]),
        (-10, [Verb.PORTTEN]),
        (5, [Verb.STBDONE] * 5),
        (7, [Verb.PORTONE] * 3 + [Verb.STBDTEN]),
        (-18, [Verb.STBDONE] * 2 + [Verb.PORTTEN] * 2),
    ],
)
def test_a_turn_takes_the_fewest_tens_and_ones(degrees: int, verbs: list[Verb]):
    assert [verb for burst in bursts(degrees) for verb in burst] == verbs


def test_a_turn_ends_where_it_should_and_never_passes_that():
    steps = {Verb.PORTTEN: -10, Verb.PORTONE: -1, Verb.STBDONE: 1, Verb.STBDTEN: 10}
    for degrees in range(-180, 181):
        turned = [steps[verb] for burst in bursts(degrees) for verb in burst]
        assert sum(turned) == degrees
        assert max(map(abs, accumulate(turned)), default=0) <= max(abs(degrees), 4)


def test_a_long_turn_never_gives_a_port_more_than_twenty_commands_a_second():
    async def scene(s: Station, far: Concentrator) -> None:
        await s.turn(175)

    far = play(scene, holding=True)
    assert len(far.times) == 22
    assert all(later - earlier >= 1.0 for earlier, later in zip(far.times, far.times[20:], strict=False))


@pytest.mark.parametrize("degrees", [0.5, 181, -181, float("nan")])
def test_a_turn_is_a_whole_number_of_degrees_up_to_half_a_circle(degrees: float):
    async def scene(s: Station, far: Concentrator) -> None:
        with pytest.raises(EncodeError, match="turn"):
            await s.turn(degrees)

    assert play(scene, holding=True).verbs == []


@pytest.mark.parametrize("heading", [-0.1, 360.1, float("nan")])
def test_a_heading_outside_the_circle_is_a_mistake(heading: float):
    async def scene(s: Station, far: Concentrator) -> None:
        with pytest.raises(EncodeError, match="heading"):
            await s.set_heading(heading)

    assert play(scene, holding=True).verbs == []


STEERING = {
    "ENGAGE": lambda s: s.engage(),
    "DISENGAGE": lambda s: s.disengage(),
    "SETHEADING": lambda s: s.set_heading(45.0),
    "STBDTEN": lambda s: s.turn(10),
}
ALL = STEERING | {
    "RELCMD": lambda s: s.release(),
    "ACKCMD": lambda s: s.acknowledge(),
    "DENYCMD": lambda s: s.deny(),
}


@pytest.mark.parametrize("esp32", [False, True])
@pytest.mark.parametrize("verb", ALL)
def test_who_does_not_command_is_refused_with_the_commander_named(verb: str, esp32: bool):
    async def scene(s: Station, far: Concentrator) -> None:
        far.mode = PilotMode.HEADING_HOLD
        await asyncio.sleep(0.5)
        with pytest.raises(RefusedError, match=f"^{verb}: station 01 is in command$"):
            await ALL[verb](s)

    play(scene, commander=1, esp32=esp32)


@pytest.mark.parametrize("verb", ALL)
def test_without_any_status_there_is_no_answer(verb: str):
    async def scene(s: Station, far: Concentrator) -> None:
        far.mute = True
        began = now()
        with pytest.raises(NoAnswerError, match=f"^{verb}: no STATUS within 1.5 s$"):
            await ALL[verb](s)
        assert 1.5 <= now() - began < 1.6

    play(scene, holding=True)


@pytest.mark.parametrize("verb", ALL)
def test_while_the_far_end_is_lost_a_command_fails_at_once(verb: str):
    async def scene(s: Station, far: Concentrator) -> None:
        far.mute = True
        await asyncio.sleep(4.0)
        began = now()
        with pytest.raises(NoAnswerError, match=f"^{verb}: no STATUS for 3 s$"):
            await ALL[verb](s)
        assert now() - began < 0.01

    play(scene, holding=True)


def test_in_alarm_engaging_is_refused_for_that_reason():
    async def scene(s: Station, far: Concentrator) -> None:
        far.mode = PilotMode.ALARM
        await asyncio.sleep(0.5)
        with pytest.raises(RefusedError, match="ALARM"):
            await s.engage()
        await s.disengage()

    play(scene)


def test_without_a_heading_engaging_is_refused_for_that_reason():
    async def scene(s: Station, far: Concentrator) -> None:
        far.heading = None
        await asyncio.sleep(0.5)
        with pytest.raises(RefusedError, match=r"no heading$"):
            await s.engage()

    play(scene)


def test_in_standby_a_turn_is_refused_for_that_reason():
    async def scene(s: Station, far: Concentrator) -> None:
        with pytest.raises(RefusedError, match=r"STBDTEN: no heading is being held \(STANDBY\)"):
            await s.turn(10)

    play(scene)


@pytest.mark.parametrize("verb", STEERING)
def test_a_far_end_that_does_nothing_has_refused_within_a_second(verb: str):
    async def scene(s: Station, far: Concentrator) -> None:
        far.stubborn = True
        far.mode = PilotMode.STANDBY if verb == "ENGAGE" else PilotMode.HEADING_HOLD
        await asyncio.sleep(0.5)
        began = now()
        with pytest.raises(RefusedError, match=f"STATUS shows no effect of {verb}"):
            await STEERING[verb](s)
        assert now() - began <= 1.0

    play(scene, holding=True)


def test_a_slow_far_end_that_says_status_at_two_hertz_only_is_waited_for():
    async def scene(s: Station, far: Concentrator) -> None:
        await s.engage()
        await s.turn(10)
        await s.set_heading(100.0)
        assert s.status.setpoint_deg == 100.0
        await s.disengage()
        await s.release()

    play(scene, esp32=True)


def test_disengage_overtakes_what_is_under_way_and_drops_what_waits():
    async def scene(s: Station, far: Concentrator) -> None:
        far.stubborn = True
        under_way = asyncio.create_task(s.set_heading(45.0))
        waiting = asyncio.create_task(s.engage())
        await asyncio.sleep(0.1)
        far.stubborn = False
        await s.disengage()
        results = await asyncio.gather(under_way, waiting, return_exceptions=True)
        assert [str(result) for result in results] == [
            "SETHEADING: no heading is being held (STANDBY)",
            "ENGAGE: disengaged meanwhile",
        ]

    assert play(scene, holding=True).verbs == [Verb.SETHEADING, Verb.DISENGAGE]


def test_disengage_ends_a_long_turn():
    async def scene(s: Station, far: Concentrator) -> None:
        turning = asyncio.create_task(s.turn(170))
        await asyncio.sleep(0.5)
        await s.disengage()
        with pytest.raises(RefusedError, match="disengaged meanwhile"):
            await turning
        assert s.status.mode is PilotMode.STANDBY

    assert play(scene, holding=True).verbs == [Verb.STBDTEN] * 10 + [Verb.DISENGAGE]


def test_disengage_is_sent_even_where_nothing_is_heard_any_more():
    async def scene(s: Station, far: Concentrator) -> None:
        far.mute = True
        await asyncio.sleep(4.0)
        with pytest.raises(NoAnswerError):
            await s.disengage()
        await asyncio.sleep(0.1)

    assert play(scene, holding=True).mode is PilotMode.STANDBY


# Command --------------------------------------------------------------------------------------


def test_a_request_while_nobody_commands_is_granted_at_once():
    async def scene(s: Station, far: Concentrator) -> None:
        assert not s.in_command
        assert await s.request() is Grant.NOBODY
        assert s.in_command
        assert await s.request() is Grant.ALREADY

    assert play(scene, commander=0).verbs == [Verb.REQCMD]


@pytest.mark.parametrize(("seconds", "grant"), [(4.0, Grant.ANSWERED), (10.0, Grant.SILENCE)])
def test_a_request_waits_for_the_commander(seconds: float, grant: Grant):
    async def scene(s: Station, far: Concentrator) -> None:
        asyncio.get_running_loop().call_later(seconds, far.transfer, 2)
        assert await s.request() is grant

    play(scene, commander=1)


def test_a_denied_request_is_known_when_command_should_have_passed():
    async def scene(s: Station, far: Concentrator) -> None:
        began = now()
        with pytest.raises(RefusedError, match=r"^REQCMD: denied; station 01 stays in command$"):
            await s.request()
        assert 11.0 <= now() - began <= 11.6

    play(scene, commander=1)


def test_an_overridden_request_is_refused_at_once():
    async def scene(s: Station, far: Concentrator) -> None:
        asyncio.get_running_loop().call_later(2.0, far.transfer, 1)
        with pytest.raises(RefusedError, match="station 01 has taken command"):
            await s.request()

    play(scene, commander=3)


def test_a_request_that_the_commander_has_not_answered_in_time_can_be_waited_for_again():
    async def scene(s: Station, far: Concentrator) -> None:
        with pytest.raises(NoAnswerError, match="station 01 has been asked and has not answered within 2 s"):
            await s.request(timeout=2.0)
        asyncio.get_running_loop().call_later(2.0, far.transfer, 2)
        assert await s.request() is Grant.ANSWERED

    play(scene, commander=1)


def test_a_request_that_is_never_announced_says_so():
    async def scene(s: Station, far: Concentrator) -> None:
        far.deaf = True
        with pytest.raises(NoAnswerError, match="station 01 is in command and has not been asked"):
            await s.request()

    play(scene, commander=1)


def test_a_request_into_silence_has_no_answer():
    async def scene(s: Station, far: Concentrator) -> None:
        far.mute = True
        with pytest.raises(NoAnswerError, match="no STATUS for 3 s"):
            await s.request()

    play(scene, commander=1)


def test_release_gives_command_to_nobody_or_to_who_asked():
    async def scene(s: Station, far: Concentrator) -> None:
        await s.release()
        assert s.status.commander == 0
        await s.request()
        far.announce(3)
        await s.release()
        assert s.status.commander == 3

    play(scene)


def test_acknowledge_gives_command_to_who_asked():
    async def scene(s: Station, far: Concentrator) -> None:
        far.announce(3)
        await asyncio.sleep(1.01)
        assert s.requests == (Request(3, pytest.approx(9.0)),)
        await s.acknowledge()
        assert s.requests == ()
        assert s.status.commander == 3

    play(scene)


def test_acknowledge_without_a_request_is_refused():
    async def scene(s: Station, far: Concentrator) -> None:
        with pytest.raises(RefusedError, match="STATUS shows no effect of ACKCMD"):
            await s.acknowledge()

    play(scene)


def test_deny_turns_the_announced_request_down():
    async def scene(s: Station, far: Concentrator) -> None:
        far.announce(3)
        await asyncio.sleep(0.1)
        await s.deny()
        assert s.requests == ()
        assert far.asking is None
        assert s.in_command

    play(scene)


def test_the_bridge_takes_command_from_anybody():
    async def scene(s: Station, far: Concentrator) -> None:
        far.announce(4)
        await s.take()
        assert s.in_command
        assert s.requests == ()

    play(scene, station=1, commander=3)


def test_nobody_but_the_bridge_may_take_command():
    async def scene(s: Station, far: Concentrator) -> None:
        with pytest.raises(RefusedError, match="TAKECMD: only the bridge may, and this is station 02"):
            await s.take()

    assert play(scene, commander=1).verbs == []


def test_a_far_end_that_does_not_let_the_bridge_take_command_has_refused():
    async def scene(s: Station, far: Concentrator) -> None:
        far.stubborn = True
        with pytest.raises(RefusedError, match="STATUS shows no effect of TAKECMD"):
            await s.take()

    play(scene, station=1, commander=3)


# The wire -------------------------------------------------------------------------------------


def test_leaving_changes_nothing_at_the_far_end():
    async def scene(s: Station, far: Concentrator) -> None:
        await s.engage()

    far = play(scene)
    assert (far.commander, far.mode) == (2, PilotMode.HEADING_HOLD)


@pytest.mark.parametrize(("commander", "verbs"), [(2, [Verb.RELCMD]), (1, [])])
def test_leaving_releases_command_where_that_was_asked_for(commander: int, verbs: list[Verb]):
    async def main() -> Concentrator:
        far = Concentrator()
        far.commander = commander
        async with Station(Cable(far), station=2, release_on_exit=True):
            await asyncio.sleep(0.1)
        return far

    assert run(main()).verbs == verbs


def test_events_tell_what_happens_from_then_on_until_the_station_closes():
    async def main() -> list[object]:
        far = Concentrator()
        async with Station(Cable(far), station=2) as s:
            events = s.events()
            await s.request()
            far.announce(3)
            await asyncio.sleep(0.1)
            far.mute = True
            await asyncio.sleep(4.0)
            far.mute = False
            await asyncio.sleep(0.6)
        return [event async for event in events] + [event async for event in events]

    heard = [event for event in run(main()) if not isinstance(event, StatusChanged)]
    assert heard == [CommandTransferred(0, 2), CommandRequested(3), Lost("no STATUS for 3 s"), Back()]


def test_events_that_nobody_reads_give_way_to_newer_ones():
    async def scene(s: Station, far: Concentrator) -> None:
        events = s.events()
        for number in range(EVENTS_KEPT + 10):
            far.heading = number / 10
            far.status()
        await asyncio.sleep(0.02)
        event = await anext(events)
        assert isinstance(event, StatusChanged)
        assert event.status.heading_deg == 1.0

    play(scene)


def test_a_wire_that_breaks_is_named_and_comes_back():
    async def main() -> None:
        far = Concentrator()
        in_port, out_port = Cable(Concentrator(), "IN port"), Cable(far, "OUT port")
        async with Station(in_port, out_port, station=2) as s:
            await asyncio.sleep(0.1)
            in_port.changed(False, "unplugged")
            assert s.lost == "IN port: unplugged"
            with pytest.raises(NoAnswerError, match="REQCMD: IN port: unplugged"):
                await s.request()
            in_port.changed(True, "")
            assert s.lost is None

    run(main())


def test_what_is_heard_on_the_in_port_of_two_counts_for_nothing():
    async def main() -> None:
        in_far, out_far = Concentrator(), Concentrator()
        in_far.commander = 4
        async with Station(Cable(in_far, "IN port"), Cable(out_far, "OUT port"), station=2) as s:
            await asyncio.sleep(0.1)
            assert s.status.commander == 0

    run(main())


def test_a_command_that_is_under_way_when_the_station_closes_ends():
    async def main() -> None:
        far = Concentrator()
        far.commander = 1
        async with Station(Cable(far), station=2) as s:
            asking = asyncio.create_task(s.request())
            await asyncio.sleep(0.1)
        with pytest.raises(NoAnswerError, match="the station was closed"):
            await asking

    run(main())


def test_a_turn_waits_for_the_first_status_since_it_starts_from_there():
    async def main() -> None:
        far = Concentrator()
        far.commander, far.mode, far.setpoint = 2, PilotMode.HEADING_HOLD, 1825
        async with Station(Cable(far, delay=0.2), station=2) as s:
            assert s.status.setpoint_deg is None
            await s.turn(10)
            assert s.status.setpoint_deg == 192.5

    run(main())


def test_a_turn_without_any_status_is_not_sent():
    async def main() -> list[Verb]:
        far = Concentrator()
        far.mute = True
        async with Station(Cable(far), station=2) as s:
            with pytest.raises(NoAnswerError, match=r"^STBDTEN: no STATUS within 1.5 s$"):
                await s.turn(10)
        return far.verbs

    assert run(main()) == []


def test_links_are_closed_when_opening_is_given_up():
    class NeverOpen(Cable):
        async def open(self, receive: Callable[[bytes], None], changed: Changed) -> None:
            await asyncio.sleep(3600)

    async def main() -> None:
        in_port, out_port = Cable(Concentrator(), "IN port"), NeverOpen(Concentrator(), "OUT port")
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(1.0), Station(in_port, out_port, station=2):
                pass
        assert in_port.closed
        assert out_port.closed

    run(main())


def test_events_that_are_read_no_more_are_forgotten():
    async def scene(s: Station, far: Concentrator) -> None:
        kept, dropped = s.events(), weakref.ref(s.events())
        gc.collect()
        assert dropped() is None
        far.announce(3)
        await asyncio.sleep(0.02)
        assert await anext(kept) == CommandRequested(3)

    play(scene)


def test_printed_examples_with_wrong_check_sums_are_dropped_and_counted():
    async def scene(s: Station, far: Concentrator) -> None:
        far.say(b"$PARP,CMDTRANSFER,01,02*3A\r\n")
        await asyncio.sleep(0.1)
        assert s.rejected == {"wrong check sum": 1}
        assert s.status.commander == 1

    play(scene, commander=1, esp32=True)


@pytest.mark.parametrize("station", [0, 5])
def test_a_station_that_there_is_not_is_a_mistake(station: int):
    with pytest.raises(StationError, match=f"station: {station} is not 1"):
        Station.open("tcp://127.0.0.1:1", station=station)


def test_the_url_of_something_else_is_a_mistake():
    with pytest.raises(LinkError, match="not the URL of a port"):
        Station.open("loop://demo", station=1)


def test_timonel_has_the_station_and_importing_it_loads_nothing():
    assert timonel.Station is Station
    with pytest.raises(AttributeError, match="Statoin"):
        _ = timonel.Statoin  # type: ignore[attr-defined]
    code = "import sys, timonel; print({'asyncio', 'msgspec', 'timonel.gateway.station'} & set(sys.modules))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout == "set()\n"


async def steer(s: Station) -> None:
    await s.request()
    await s.engage()
    await s.turn(+10)
    assert s.status.setpoint_deg == 192.5
    await s.disengage()


def test_it_steers_over_tcp():
    async def main() -> list[Verb]:
        far = Concentrator()

        async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            far.plug(writer.write)
            while data := await reader.read(100):
                far.receive(data)
            far.unplug()
            writer.close()

        server = await asyncio.start_server(serve, "127.0.0.1", 0)
        port = server.sockets[0].getsockname()[1]
        async with Station.open(f"tcp://127.0.0.1:{port}", station=2) as s:
            await steer(s)
        server.close()
        await asyncio.sleep(0.05)
        return far.verbs

    assert asyncio.run(main()) == [Verb.REQCMD, Verb.ENGAGE, Verb.STBDTEN, Verb.DISENGAGE]


def serve_terminal(far: Concentrator) -> tuple[int, str]:
    """A pseudo-terminal with `far` at its master end; the descriptor to close and the path to open."""
    master, program_end = os.openpty()
    tty.setraw(program_end)
    path = os.ttyname(program_end)
    os.close(program_end)
    os.set_blocking(master, False)
    loop = asyncio.get_running_loop()

    def readable() -> None:
        try:
            far.receive(os.read(master, 1000))
        except OSError:  # nobody has it open
            loop.remove_reader(master)
            loop.call_later(0.02, loop.add_reader, master, readable)

    loop.add_reader(master, readable)
    far.plug(lambda line: os.write(master, line) and None)
    return master, path


def test_it_steers_over_two_serial_ports_one_each_way(tmp_path: Path):
    async def main() -> None:
        far, out = Concentrator(), Concentrator()
        in_fd, in_path = serve_terminal(far)
        out_fd, out_path = serve_terminal(out)
        far.plug(lambda line: os.write(out_fd, line) and None)
        out.unplug()
        async with Station.open(f"serial://{in_path}", out=f"serial://{out_path}", station=2) as s:
            await steer(s)
        far.unplug()
        for fd in (in_fd, out_fd):
            asyncio.get_running_loop().remove_reader(fd)
            os.close(fd)

    asyncio.run(main())


def test_the_transfer_that_a_gateway_says_before_its_status_is_enough():
    async def scene(s: Station, far: Concentrator) -> None:
        far.deaf = True
        asyncio.get_running_loop().call_later(0.1, far.say, parp.cmdtransfer(0, 2))
        began = now()
        assert await s.request() is Grant.NOBODY
        assert now() - began < 0.2

    play(scene, commander=0)
