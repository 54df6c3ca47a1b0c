"""What consoles say on their station's port, and what becomes of it."""

import asyncio
from math import radians
from typing import get_args

import pytest

from tests.unit.web.scene import Scene, heading, pilot_holds, scene, wire
from timonel.vehicles.boat.alerts import COMMANDER_UNPLUGGED
from timonel.vehicles.rover.alerts import LINK_LOST
from timonel.web import port as ports
from timonel.web.messages import (
    Acknowledge,
    Command,
    CommandVerb,
    Enable,
    LetGo,
    Limit,
    Silence,
    SteeringVerb,
    Stick,
    Stop,
)
from timonel.web.outcome import CONFIRMED, Verdict
from timonel.web.port import VERBS, Order, Port, RoverPort


def say(here: Scene, station: int, order: Order) -> Verdict | None:
    """What is known of it at once."""
    result = here.console.ports[station].carry_out(order)
    return result if isinstance(result, Verdict) else result(here.gateway.now)


def command(here: Scene, station: int, verb: str, parameter: float | None = None) -> Verdict | None:
    return say(here, station, Command(1, verb, parameter))  # type: ignore[arg-type]


# A boat -----------------------------------------------------------------------------------------------------


def test_a_console_commands_as_its_station_through_the_machine_of_the_wires() -> None:
    async def play() -> None:
        async with scene(stations=[wire(1, "Bridge")]) as here:
            await here.hear(heading(90.0))
            helm = here.gateway.vehicle.helm  # type: ignore[attr-defined]
            assert command(here, 2, "TAKECMD") == Verdict("refused", "only the bridge takes command")
            assert command(here, 2, "REQCMD") == CONFIRMED
            assert command(here, 3, "ENGAGE") == Verdict("refused", "not in command")
            assert command(here, 2, "STBDTEN") == Verdict("refused", "no set point")
            assert command(here, 2, "ENGAGE") is None
            assert command(here, 2, "SETHEADING", radians(123.4)) is None
            assert helm.pilot.setpoint == 1234
            assert command(here, 1, "TAKECMD") == CONFIRMED
            assert helm.transfer.commander == 1
            assert here.gateway.vehicle.counters["commands"] == 7  # type: ignore[attr-defined]

    asyncio.run(play())


def test_a_course_is_confirmed_when_the_pilot_reports_it() -> None:
    async def play() -> None:
        async with scene() as here:
            await here.hear(heading(90.0))
            command(here, 1, "TAKECMD")
            judge = here.console.ports[1].carry_out(Command(1, "ENGAGE"))
            assert not isinstance(judge, Verdict)
            assert judge(here.gateway.now) is None
            await here.hear(*pilot_holds(90.0))
            assert judge(here.gateway.now) == CONFIRMED

    asyncio.run(play())


def test_a_request_waits_in_the_queue_and_an_answer_to_it_is_confirmed_at_once() -> None:
    async def play() -> None:
        async with scene() as here:
            command(here, 1, "TAKECMD")
            waiting = here.console.ports[2].carry_out(Command(1, "REQCMD"))
            assert not isinstance(waiting, Verdict)
            assert waiting(here.gateway.now) is None
            assert command(here, 2, "REQCMD") == Verdict("refused", "already requested")
            assert command(here, 1, "DENYCMD") == CONFIRMED
            assert waiting(here.gateway.now) == Verdict("refused", "denied")
            command(here, 2, "REQCMD")
            assert command(here, 1, "ACKCMD") == CONFIRMED
            assert command(here, 2, "RELCMD") == CONFIRMED
            assert command(here, 2, "RELCMD") == Verdict("refused", "not in command")

    asyncio.run(play())


def test_a_heading_that_nobody_named_is_not_set() -> None:
    async def play() -> None:
        async with scene() as here:
            assert command(here, 1, "SETHEADING") == Verdict("refused", "no heading")

    asyncio.run(play())


def test_more_than_a_port_may_say_is_refused() -> None:
    async def play() -> None:
        async with scene() as here:
            ends = [command(here, 3, "ENGAGE") for _ in range(30)]
            assert Verdict("refused", "too many commands") in ends

    asyncio.run(play())


def test_an_alert_is_silenced_and_acknowledged_for_everybody() -> None:
    async def play() -> None:
        async with scene() as here:
            boat, now = here.gateway.vehicle, here.gateway.now
            for event in boat.expire(now + 3.0):
                here.console.state.effect(event, now)
            assert say(here, 4, Silence(1, 101)) == CONFIRMED
            alert = here.console.state.alert(101)
            assert alert is not None
            assert alert.silenced_until is not None
            assert say(here, 4, Acknowledge(1, 101)) == CONFIRMED
            assert here.console.state.alert(101).acknowledged  # type: ignore[union-attr]
            assert say(here, 4, Acknowledge(1, 101)) == CONFIRMED, "somebody did already"
            assert say(here, 4, Acknowledge(1, 999)) == Verdict("refused", "no such alert")

    asyncio.run(play())


def test_a_commander_whose_console_is_gone_for_a_while_is_unplugged_unless_it_has_a_wire(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(ports, "GRACE", 0.05)

    async def play() -> None:
        async with scene() as here:
            alerts = here.gateway.vehicle.helm.alerts  # type: ignore[attr-defined]
            bridge = here.console.ports[1]
            bridge.enter(7)
            bridge.enter(8)
            command(here, 1, "TAKECMD")
            bridge.leave(7)
            bridge.leave(8)
            bridge.enter(9)  # the page is loaded anew
            await asyncio.sleep(0.1)
            assert not alerts.active(COMMANDER_UNPLUGGED)
            bridge.leave(9)
            assert not alerts.active(COMMANDER_UNPLUGGED)
            await asyncio.sleep(0.1)
            assert alerts.active(COMMANDER_UNPLUGGED)
            bridge.enter(10)
            assert not alerts.active(COMMANDER_UNPLUGGED)

    asyncio.run(play())


def test_a_boat_has_no_drives_to_enable() -> None:
    async def play() -> None:
        async with scene() as here:
            for order in (Enable(1), Stop(1), Limit(1, "speed", 5)):
                assert say(here, 1, order) == Verdict("refused", "not a word of this vehicle")

    asyncio.run(play())


# A rover ----------------------------------------------------------------------------------------------------


def rover_port(here: Scene, station: int = 1) -> RoverPort:
    port = here.console.ports[station]
    assert isinstance(port, RoverPort)
    return port


def enabled(here: Scene, station: int = 1, console: int = 7) -> RoverPort:
    port = rover_port(here, station)
    port.enter(console)
    command(here, station, "REQCMD")
    assert say(here, station, Enable(1)) == CONFIRMED
    return port


def obeyed(here: Scene) -> tuple[int, int]:
    """Right and forward, in percent."""
    stick = here.gateway.vehicle.drive.obeyed(here.gateway.now)  # type: ignore[attr-defined]
    return stick.y, -stick.x


def test_a_stick_pushed_forward_and_right_goes_forward_and_right() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            port = enabled(here)
            port.stick(7, Stick(1, x=0.25, y=0.5))
            await asyncio.sleep(0.03)
            assert obeyed(here) == (25, 50)

    asyncio.run(play())


def test_a_stick_of_a_station_that_is_not_in_command_is_no_request() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            enabled(here, 2)
            other = rover_port(here, 3)
            other.enter(9)
            other.stick(9, Stick(1, 0.0, 1.0))
            transfer = here.gateway.vehicle.helm.transfer  # type: ignore[attr-defined]
            assert (transfer.commander, transfer.queue) == (2, ())
            assert say(here, 3, Enable(1)) == Verdict("refused", "not in command")
            assert say(here, 3, Limit(1, "power", 3)) == Verdict("refused", "not in command")
            assert transfer.queue == ()

    asyncio.run(play())


def test_anybody_stops_it() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            enabled(here, 2)
            assert say(here, 4, Stop(1)) == CONFIRMED
            assert not here.gateway.vehicle.drive.permitted  # type: ignore[attr-defined]

    asyncio.run(play())


def test_sticks_beyond_fifty_a_second_give_way_to_the_newest_and_rest_at_once() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            port = enabled(here)
            said: list[bytes] = []
            link = port._link
            say_on = link.say
            link.say = lambda data: (said.append(data), say_on(data))  # type: ignore[method-assign,assignment,func-returns-value]
            for number in range(1, 60):
                port.stick(7, Stick(number, 0.0, number / 100))
            assert len(said) <= 3
            await asyncio.sleep(0.05)
            assert obeyed(here) == (0, 59)
            before = len(said)
            port.stick(7, Stick(60, 0.0, 0.0))
            assert len(said) == before + 1
            assert obeyed(here) == (0, 0)

    asyncio.run(play())


def test_letting_go_rests_at_once_and_what_waited_is_not_said_any_more() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            port = enabled(here)
            for number in range(1, 10):
                port.stick(7, Stick(number, 0.0, 0.9))
            port.let_go(7, LetGo())
            assert obeyed(here) == (0, 0)
            await asyncio.sleep(0.05)
            assert obeyed(here) == (0, 0)
            assert here.gateway.vehicle.drive.permitted  # type: ignore[attr-defined]

    asyncio.run(play())


def test_one_console_of_a_station_holds_the_stick_until_it_lets_go() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            port = enabled(here)
            port.enter(8)
            port.stick(7, Stick(1, 0.0, 0.5))
            port.stick(8, Stick(1, 0.0, -0.5))
            port.let_go(8)
            await asyncio.sleep(0.03)
            assert obeyed(here) == (0, 50)
            port.let_go(7)
            port.stick(8, Stick(2, 0.0, -0.5))
            await asyncio.sleep(0.03)
            assert obeyed(here) == (0, -50)

    asyncio.run(play())


def test_a_stick_that_was_overtaken_or_whose_driver_sees_nothing_moves_nothing() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            port, now = enabled(here), here.gateway.now
            port.stick(7, Stick(5, 0.0, 0.5, seen=now - 0.1))
            await asyncio.sleep(0.03)
            assert obeyed(here) == (0, 50)
            port.stick(7, Stick(4, 0.0, 0.9))
            await asyncio.sleep(0.03)
            assert obeyed(here) == (0, 50)
            for number, seen in enumerate((now - 0.7, now + 60.0, float("inf")), 6):
                port.stick(7, Stick(number, 0.0, 0.5, seen=seen))
                assert obeyed(here) == (0, 0)

    asyncio.run(play())


def test_a_console_that_held_the_stick_and_is_gone_stops_the_rover_others_do_not() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            port = enabled(here)
            port.enter(8)
            drive = here.gateway.vehicle.drive  # type: ignore[attr-defined]
            port.stick(7, Stick(1, 0.0, 0.5))
            port.leave(8)
            assert drive.permitted
            port.enter(8)
            port.leave(7)
            assert not drive.permitted
            assert obeyed(here) == (0, 0)
            assert say(here, 1, Enable(1)) == Verdict("refused", "stick not at rest")
            port.stick(8, Stick(1, 0.0, 0.0))
            assert say(here, 1, Enable(1)) == CONFIRMED, "the other one goes on"

    asyncio.run(play())


def test_a_stick_that_falls_silent_rests_then_stops_then_gives_command_up() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            port = enabled(here)
            rover = here.gateway.vehicle
            port.stick(7, Stick(1, 0.0, 0.5))
            said = here.gateway.now
            assert rover.drive.obeyed(said + 0.21).x == 0  # type: ignore[attr-defined]
            rover.expire(said + 0.51)
            assert not rover.drive.permitted  # type: ignore[attr-defined]
            assert rover.helm.alerts.active(LINK_LOST)  # type: ignore[attr-defined]
            rover.expire(said + 2.01)
            assert rover.helm.transfer.commander == 0  # type: ignore[attr-defined]

    asyncio.run(play())


def test_who_commands_a_rover_is_settled_in_words() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            assert command(here, 2, "TAKECMD") == Verdict("refused", "only the bridge takes command")
            assert command(here, 2, "REQCMD") == CONFIRMED
            assert command(here, 1, "TAKECMD") == CONFIRMED
            assert command(here, 3, "REQCMD") is None
            assert command(here, 1, "ACKCMD") == CONFIRMED
            assert command(here, 3, "RELCMD") == CONFIRMED
            assert command(here, 3, "ENGAGE") == Verdict("refused", "not a word of this vehicle")
            assert VERBS.keys() == set(get_args(CommandVerb))
            assert not VERBS.keys() & set(get_args(SteeringVerb))

    asyncio.run(play())


def test_limits_are_confirmed_as_the_machine_takes_them() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            enabled(here)
            assert say(here, 1, Limit(1, "speed", 10)) == CONFIRMED
            assert say(here, 1, Limit(1, "current", 200)) == CONFIRMED
            assert say(here, 1, Limit(1, "power", 21)) == Verdict("refused", "limit out of range")

    asyncio.run(play())


def test_an_alert_of_a_rover_is_silenced_and_acknowledged() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            port = enabled(here)
            port.stick(7, Stick(1, 0.0, 0.5))
            rover, later = here.gateway.vehicle, here.gateway.now + 0.6
            for event in rover.expire(later):
                here.console.state.effect(event, later)
            assert say(here, 3, Silence(1, LINK_LOST.id)) == CONFIRMED
            assert say(here, 3, Acknowledge(1, LINK_LOST.id)) == CONFIRMED
            assert rover.helm.alerts.standing[0].acknowledged  # type: ignore[attr-defined]

    asyncio.run(play())


def test_a_port_that_is_of_no_vehicle_says_nothing() -> None:
    port = Port(1, None, None, None)  # type: ignore[arg-type]
    with pytest.raises(NotImplementedError):
        port.carry_out(Stop(1))
    with pytest.raises(NotImplementedError):
        port.leave(1)
