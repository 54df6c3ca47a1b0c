"""The boat as a device of the bus: nothing is steered without an address, and nothing is lost for the want of one."""

import msgspec
import pytest

from tests.unit.boat.test_vehicle import PORTS, frames, heading, lines, parp_lines, sent
from timonel.core.effects import Effect, Refused, SayTo, Transmit
from timonel.core.frame import Frame
from timonel.nmea0183 import parp
from timonel.nmea0183.parp import Verb
from timonel.nmea2000.claim import AddressClaimed, AddressLost
from timonel.nmea2000.identifier import join, split
from timonel.nmea2000.messages.network import IsoRequest, ProductInformation
from timonel.nmea2000.node import NodeSettings
from timonel.nmea2000.sender import outgoing
from timonel.vehicles.boat.alerts import NO_ADDRESS
from timonel.vehicles.boat.pilot import Steer
from timonel.vehicles.boat.settings import BoatSettings
from timonel.vehicles.boat.vehicle import Boat

NODE = NodeSettings(unique_number=1234)
STEERING = 127237


class Adrift:
    """A boat that has just been switched on, with a heading once a second, and station 1 in command."""

    def __init__(self, node: NodeSettings | None = NODE, **settings: str) -> None:
        self.boat = Boat(BoatSettings(node=node, **settings), PORTS, now=0.0)  # type: ignore[arg-type]
        self.now = 0.0
        self.effects: list[Effect] = []
        self.bus(frames(heading(90.0)))
        self.say(Verb.REQCMD)

    def bus(self, heard: list[Frame]) -> list[Effect]:
        return self._done(self.boat.receive_frames(heard, self.now))

    def claim(self, name: int, address: int) -> list[Effect]:
        return self.bus([Frame(join(6, 60928, address), name.to_bytes(8, "little"))])

    def say(self, verb: Verb, parameter: float = 0.0) -> list[Effect]:
        return self._done(self.boat.receive_bytes("IN1", parp.command(verb, 1, parameter), self.now))

    def run(self, until: float) -> list[Effect]:
        """Let time pass; what came of it."""
        before = len(self.effects)
        while (due := self.boat.deadline) <= until:
            self.now = max(self.now, due)
            self._done(self.boat.expire(self.now))
            self.bus(frames(heading(90.0)))
        self.now = until
        return self.effects[before:]

    def no_address(self) -> "Adrift":
        """All addresses belong to devices with lower NAMEs."""
        self.run(1.0)
        for address in range(252):
            self.claim(address + 1, address)
        assert not self.boat.node.operating
        return self

    def _done(self, effects: list[Effect]) -> list[Effect]:
        self.effects += effects
        return effects


def steered(effects: list[Effect]) -> list[int]:
    """The address that each steering order came from."""
    targets = [split(frame.identifier) for frame in sent(effects) if frame.data[0] & 0x1F == 0]
    return [target.source for target in targets if target.pgn == STEERING]


def test_a_command_in_the_first_half_second_waits_for_the_address_and_only_the_last_one_counts() -> None:
    adrift = Adrift()
    assert parp_lines(adrift.say(Verb.ENGAGE)) == ["PARP,STATUS,HEADING_HOLD,090.0,090.0,,01"]
    adrift.say(Verb.STBDTEN)
    assert steered(adrift.effects) == []
    effects = adrift.run(0.7)
    assert steered(effects) == [35]
    claimed = effects.index(AddressClaimed(35, NODE.name))
    order = next(index for index, effect in enumerate(effects) if isinstance(effect, Transmit) and steered([effect]))
    assert claimed < order
    assert adrift.boat.helm.pilot.setpoint == 1000


def test_a_boat_without_a_node_steers_at_once_from_its_fixed_address() -> None:
    assert steered(Adrift(None).say(Verb.ENGAGE)) == [35]


def test_an_order_waits_while_an_address_is_looked_for_and_leaves_from_the_new_one() -> None:
    adrift = Adrift()
    adrift.run(1.0)
    assert steered(adrift.say(Verb.ENGAGE)) == [35]
    assert AddressLost(35, 5) in adrift.claim(5, 35)
    assert steered(adrift.say(Verb.STBDONE)) == []
    assert steered(adrift.run(1.3)) == [36]


def test_without_any_address_people_are_alarmed_and_the_pilot_is_not_promised_anything() -> None:
    adrift = Adrift().no_address()
    assert adrift.boat.helm.alerts.active(NO_ADDRESS)
    assert any(",107,A,V,no address on the bus" in line for line in lines(adrift.effects))
    assert Refused("no address on the bus", 1) in adrift.say(Verb.ENGAGE)
    assert steered(adrift.effects) == []


def test_a_pilot_that_hears_sentences_needs_no_address() -> None:
    adrift = Adrift(pilot="sentence", pilot_output="Pilot").no_address()
    assert adrift.boat.helm.alerts.active(NO_ADDRESS)
    effects = adrift.say(Verb.ENGAGE)
    assert parp_lines(effects)[-1].startswith("PARP,STATUS,HEADING_HOLD")
    assert [effect.key for effect in effects if isinstance(effect, SayTo)] == ["HTC"]


def test_disengage_is_accepted_without_an_address_and_said_as_soon_as_there_is_one() -> None:
    adrift = Adrift()
    adrift.run(1.0)
    adrift.say(Verb.ENGAGE)
    adrift.no_address()
    assert parp_lines(adrift.say(Verb.DISENGAGE))[0].startswith("PARP,STATUS,STANDBY")
    effects = adrift.run(15.0)  # all the others have gone meanwhile
    assert steered(effects)[0] == adrift.boat.node.address != 254
    assert not adrift.boat.helm.alerts.active(NO_ADDRESS)
    assert parp_lines(adrift.say(Verb.ENGAGE)) == ["PARP,STATUS,HEADING_HOLD,090.0,090.0,,01"]


def test_an_old_set_point_is_not_said_to_the_pilot_after_the_wait() -> None:
    adrift = Adrift()
    adrift.run(1.0)
    adrift.say(Verb.ENGAGE)
    adrift.claim(5, 35)
    assert adrift.boat._waiting is None
    adrift.boat._waiting = (Steer(910), adrift.now - 2.0)
    assert steered(adrift.run(1.3)) == []


def test_what_is_not_for_us_to_send_now_is_counted() -> None:
    adrift = Adrift()
    assert adrift.boat._transmit([]) == []
    assert adrift.boat._transmit([outgoing(IsoRequest(pgn=60928))]) == []
    assert adrift.boat.counters["messages without an address"] == 1


def test_a_whole_message_of_the_network_management_is_heard_too() -> None:
    adrift = Adrift()
    adrift.run(1.0)
    adrift.claim(5, 7)
    product = ProductInformation.decode(bytes.fromhex("3408") + bytes(2) + b"EV-1".ljust(32, b"\xff") + bytes(98))
    adrift.boat.receive_message(join(6, 126996, 7), product.encode(), adrift.now)
    device = adrift.boat.devices.at(7)
    assert device is not None
    assert device.product is not None
    assert device.product.model_id == "EV-1"


def test_the_network_management_counts_as_a_living_bus_and_a_bus_that_is_back_hears_our_claim() -> None:
    adrift = Adrift()
    adrift.run(1.0)
    boat = adrift.boat
    boat.expire(10.0)
    effects = boat.receive_frames(frames(heading(90.0)), 10.0)
    assert [split(frame.identifier).pgn for frame in sent(effects)] == [60928, 59904]


@pytest.mark.parametrize("name", [5, (1 << 64) - 1], ids=["lost", "won"])
def test_a_storm_of_claims_delays_no_command(name: int) -> None:
    """10,000 claims in a second for the address that we have; a command every 100 ms."""
    adrift = Adrift()
    adrift.run(2.0)
    adrift.say(Verb.ENGAGE)
    began = len(adrift.effects)
    storm = [Frame(join(6, 60928, 35), name.to_bytes(8, "little"))] * 100
    for batch in range(100):
        adrift.now = 2.0 + batch / 100
        adrift.bus(storm)
        if batch % 10 == 0:
            answer = adrift.say(Verb.STBDONE if batch % 20 else Verb.PORTONE)
            assert parp_lines(answer)[0].startswith("PARP,STATUS,HEADING_HOLD")
            assert steered(answer) == [35] or not adrift.boat.node.operating or adrift.boat.node.address == 36
    said = [split(frame.identifier).pgn for frame in sent(adrift.effects[began:])]
    assert said.count(60928) <= 12
    assert len([effect for effect in adrift.effects[began:] if isinstance(effect, AddressLost)]) == (name == 5)


def test_a_recording_of_what_a_boat_is_made_of_makes_the_same_boat() -> None:
    settings = BoatSettings(node=NodeSettings(unique_number=7, installation1="Kajüte"), address=9)
    again = msgspec.json.decode(msgspec.json.encode(settings), type=BoatSettings)
    assert again == settings
    boats = [Boat(each, PORTS, now=0.0) for each in (settings, again)]
    said = [[boat.expire(now) for now in (0.05, 0.3, 0.55, 1.0)] for boat in boats]
    assert said[0] == said[1]
    assert boats[0].node.address == 9
