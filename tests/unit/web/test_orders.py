"""What becomes of orders that come by MQTT."""

from collections.abc import Callable

import pytest

from timonel.interop.mqtt import Answer, Vehicle
from timonel.web.messages import Acknowledge, Command, Stop
from timonel.web.orders import AT_MOST, WAITING_MAX, Orders
from timonel.web.outcome import CONFIRMED, Verdict
from timonel.web.port import Order, Port, Result

REQUEST = b'{"type":"command","id":7,"verb":"REQCMD"}'


class FakePort(Port):
    """Does nothing, and says what it is told to say of that."""

    def __init__(self, result: Callable[[Order], Result]) -> None:
        self.carried_out: list[Order] = []
        self.entered = 0
        self._result = result

    def enter(self, console: int) -> None:
        self.entered += 1

    def leave(self, console: int) -> None:
        self.entered -= 1

    def carry_out(self, order: Order) -> Result:
        self.carried_out.append(order)
        return self._result(order)


class Scene:
    def __init__(self, vehicle: Vehicle = "boat", result: Callable[[Order], Result] = lambda _: CONFIRMED) -> None:
        self.answers: list[Answer] = []
        self.rejected: list[str] = []
        self.port = FakePort(result)
        self.orders = Orders(vehicle, self.port, self.answers.append, self.rejected.append)

    def hear(self, payload: bytes, now: float = 0.0, *, retained: bool = False) -> None:
        self.orders.hear(payload, retained, now)


def test_an_order_is_carried_out_and_answered() -> None:
    scene = Scene()
    scene.hear(REQUEST)
    assert scene.port.carried_out == [Command(7, "REQCMD")]
    assert scene.answers == [Answer(7, "confirmed", "")]


def test_what_the_machine_refuses_is_refused_with_its_reason() -> None:
    scene = Scene(result=lambda _: Verdict("refused", "not in command"))
    scene.hear(REQUEST)
    assert scene.answers == [Answer(7, "refused", "not in command")]


def test_what_takes_time_is_sent_and_then_what_it_came_to() -> None:
    scene = Scene(result=lambda _: lambda now: CONFIRMED if now >= 1.5 else None)
    scene.hear(REQUEST, now=0.0)
    assert scene.answers == [Answer(7, "sent", "")]
    assert scene.orders.waiting
    scene.orders.look(1.0)
    assert len(scene.answers) == 1
    scene.orders.look(1.5)
    assert scene.answers[1:] == [Answer(7, "confirmed", "")]
    assert not scene.orders.waiting


def test_a_retained_order_is_refused() -> None:
    scene = Scene()
    scene.hear(REQUEST, retained=True)
    assert scene.port.carried_out == []
    assert scene.rejected == ["an order must not be retained"]


@pytest.mark.parametrize(
    "payload",
    [b"", b"REQCMD", b"\xff\xfe", b"[" * 4000, b'{"type":"command","id":1,"verb":"SINK"}',
     b'{"type":"command","id":1,"verb":"REQCMD","more":1}', b'{"type":"stick","n":1,"x":0,"y":1}',
     b'{"type":"enable","id":1}', b'{"type":"limit","id":1,"which":"speed","value":3}'],
)  # fmt: skip
@pytest.mark.parametrize("vehicle", ["boat", "rover"])
def test_what_is_no_order_is_rejected(vehicle: Vehicle, payload: bytes) -> None:
    scene = Scene(vehicle)
    scene.hear(payload)
    assert scene.port.carried_out == []
    assert len(scene.rejected) == 1
    assert scene.rejected[0].startswith("not understood")


def test_a_rover_takes_stop_and_what_concerns_alerts_and_nothing_else() -> None:
    scene = Scene("rover")
    scene.hear(b'{"type":"stop","id":1}')
    scene.hear(b'{"type":"acknowledge","id":2,"alert":206}')
    scene.hear(REQUEST)
    assert scene.port.carried_out == [Stop(1), Acknowledge(2, 206)]
    assert len(scene.rejected) == 1


def test_no_more_orders_are_taken_than_a_person_could_mean() -> None:
    scene = Scene()
    for _ in range(AT_MOST + 1):
        scene.hear(REQUEST, now=3.0)
    assert len(scene.port.carried_out) == AT_MOST
    assert scene.rejected == ["too many orders"]
    scene.hear(REQUEST, now=4.0)
    assert len(scene.port.carried_out) == AT_MOST + 1


def test_orders_that_are_never_decided_do_not_pile_up() -> None:
    scene = Scene(result=lambda _: lambda now: None)
    for number in range(WAITING_MAX + 1):
        scene.hear(REQUEST, now=float(number))
    assert scene.answers[-1] == Answer(7, "refused", "too many orders")
    assert len(scene.port.carried_out) == WAITING_MAX


def test_a_broker_that_is_gone_is_nobody_at_the_port() -> None:
    scene = Scene()
    scene.orders.plug(True)
    assert scene.port.entered == 1
    scene.orders.plug(False)
    assert scene.port.entered == 0
