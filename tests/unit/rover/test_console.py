"""What a console says to a rover beside a station's frames."""

from timonel.core.alerts import Alert
from timonel.core.command import NOBODY, Verb
from timonel.core.effects import Event, Refused
from timonel.vehicles.rover import console
from timonel.vehicles.rover.console import Console
from timonel.vehicles.rover.declared import FREE
from timonel.vehicles.rover.drive import Permission, Stop
from timonel.vehicles.rover.frames import FRAMES, CurrentLimit, PowerLimit, SpeedLimit
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.settings import Port, RoverSettings
from timonel.vehicles.rover.vehicle import Rover

PORTS = [Port("Operator", 1), Port("Operator web", 1, console=True), Port("Jetson web", 2, console=True)]
PERMIT = Console.write(101, b"\x31")


def rover() -> Rover:
    return Rover(RoverSettings(), PORTS, now=0.0, protocol=Protocol())


def test_a_console_has_words_about_command() -> None:
    machine = rover()
    transfer = machine.helm.transfer
    machine.receive_bytes("Jetson web", console.command(Verb.REQUEST), 0.0)
    assert transfer.commander == 2
    machine.receive_bytes("Operator web", console.command(Verb.REQUEST), 0.1)
    assert transfer.queue == (1,)
    machine.receive_bytes("Jetson web", console.command(Verb.DENY), 0.2)
    assert (transfer.commander, transfer.queue) == (2, ())
    machine.receive_bytes("Operator web", console.command(Verb.REQUEST), 0.3)
    machine.receive_bytes("Jetson web", console.command(Verb.ACKNOWLEDGE), 0.4)
    assert transfer.commander == 1
    machine.receive_bytes("Operator web", console.command(Verb.RELEASE), 0.5)
    assert transfer.commander == NOBODY
    assert machine.receive_bytes("Jetson web", console.command(Verb.TAKE), 0.6)[-1] == Refused(
        "only the bridge takes command", 2
    )


def test_a_word_about_command_that_there_is_not_does_nothing() -> None:
    machine = rover()
    effects = machine.receive_bytes("Operator web", Console.write(console.Word.COMMAND, b"\x09"), 0.0)
    assert not any(isinstance(effect, Event) for effect in effects)


def test_a_frame_of_a_console_needs_nothing_behind_it() -> None:
    machine = rover()
    effects = machine.receive_bytes("Operator web", PERMIT, 0.0)
    assert Permission(True, "station 1") in effects
    assert machine.framing()["Operator web"].waiting == 0


def test_a_wire_does_not_know_the_words_of_a_console() -> None:
    machine = rover()
    machine.receive_bytes("Operator", console.command(Verb.REQUEST), 0.0)
    machine.expire(1.0)
    assert machine.helm.transfer.commander == NOBODY
    assert machine.framing()["Operator"].counters.skipped > 0


def test_a_console_acknowledges_and_silences_alerts() -> None:
    machine = rover()
    machine.receive_bytes("Operator web", PERMIT, 0.0)
    machine.expire(0.5)

    def lost() -> Alert:
        return machine.helm.alerts.standing[0]

    assert not lost().acknowledged
    machine.receive_bytes("Jetson web", console.silence(lost().kind.id), 1.0)
    assert lost().silenced_until == 31.0
    machine.receive_bytes("Jetson web", console.acknowledge(lost().kind.id), 2.0)
    assert lost().acknowledged


def test_a_console_that_is_cut_stops_the_rover_as_a_wire_does() -> None:
    machine = rover()
    machine.receive_bytes("Operator web", PERMIT, 0.0)
    effects = machine.port_changed("Operator web", False, 0.1)
    assert Permission(False, Stop.UNPLUGGED.value) in effects


def test_half_a_frame_of_a_console_that_left_is_not_finished_by_the_next() -> None:
    machine = rover()
    machine.receive_bytes("Operator web", PERMIT[:3], 0.0)
    machine.port_changed("Operator web", False, 0.0)
    machine.receive_bytes("Operator web", PERMIT[3:] + PERMIT, 0.0)
    assert machine.drive.permitted, "and it is still the framing of a console"


def test_limits_are_known_as_they_were_said() -> None:
    machine = rover()
    machine.receive_bytes("Operator web", PERMIT + Console.write(SpeedLimit.FRAME, b"\x0a"), 0.0)
    assert machine.limit(SpeedLimit.FRAME) == 10
    assert machine.limit(PowerLimit.FRAME) is None
    machine.receive_bytes("Operator web", Console.write(CurrentLimit.FRAME, b"\xff"), 0.0)
    assert machine.limit(CurrentLimit.FRAME) is None, "out of range"


def test_the_words_have_ids_that_no_frame_can_have() -> None:
    taken = {frame.FRAME for frame in FRAMES}.union(*FREE.values())
    assert not taken & set(console.CONSOLE)
