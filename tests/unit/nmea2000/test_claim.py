"""Getting an address, keeping it, losing it."""

import pytest

from tests.unit.nmea2000.bus import Bus, End
from timonel.core.frame import Frame
from timonel.nmea2000.claim import AddressClaimed, AddressLost, NoAddress, with_instance
from timonel.nmea2000.identifier import join
from timonel.nmea2000.messages.network import IsoRequest
from timonel.nmea2000.node import NodeSettings
from timonel.nmea2000.sender import Outgoing

OURS = NodeSettings(unique_number=1234, manufacturer=999)
LOWER, HIGHER = OURS.name - 1, OURS.name + 1
WHO = IsoRequest(pgn=60928)


def claim_at(address: int, name: int) -> Frame:
    return Frame(join(6, 60928, address), name.to_bytes(8, "little"))


def settled(address: int = 35) -> tuple[Bus, End]:
    """A node that has its address, alone on its bus."""
    end = End(OURS, address)
    bus = Bus(end)
    bus.run(0.6)
    assert end.node.operating
    end.happened.clear()
    bus.said.clear()
    return bus, end


def claims(bus: Bus) -> list[tuple[int, int]]:
    """Address and NAME of all claims that were made."""
    return [(target.source, int.from_bytes(payload, "little")) for _, target, payload in bus.heard(60928)]


def test_the_name_is_laid_out_as_the_standard_has_it() -> None:
    assert OURS.name.to_bytes(8, "little") == bytes.fromhex("d204e07c008232c0")


def test_it_asks_who_is_there_claims_and_is_silent_for_250_ms_before_it_speaks() -> None:
    end = End(OURS)
    bus = Bus(end)
    bus.run(10.0)
    request, claim, *rest = bus.said
    assert request == (0.05, (6, 59904, 254, 255), bytes((0x00, 0xEE, 0x00)))
    assert claim == (0.30, (6, 60928, 35, 255), OURS.name.to_bytes(8, "little"))
    assert end.happened == [AddressClaimed(35, OURS.name)]
    assert rest[0][0] == 0.55
    assert [target.pgn for _, target, _ in rest] == [126993]


def test_an_address_that_is_taken_is_not_tried() -> None:
    end = End(OURS)
    bus = Bus(end)
    bus.run(0.1)
    bus.claim(HIGHER, 35)
    bus.claim(HIGHER + 1, 36)
    bus.run(1.0)
    assert (end.node.address, end.happened) == (37, [AddressClaimed(37, OURS.name)])


def test_the_next_address_after_the_last_is_the_first() -> None:
    end = End(OURS, 251)
    bus = Bus(end)
    bus.run(0.1)
    bus.claim(HIGHER, 251)
    bus.run(1.0)
    assert end.node.address == 0


def test_who_has_the_lower_name_keeps_the_address() -> None:
    bus, end = settled()
    assert bus.claim(HIGHER, 35) == [((6, 60928, 35, 255), OURS.name.to_bytes(8, "little"))]
    assert end.node.operating
    assert end.happened == []


def test_who_has_the_higher_name_goes_to_the_next_free_address_and_is_silent_there_at_first() -> None:
    bus, end = settled()
    bus.claim(LOWER + (5 << 21), 36)
    assert bus.claim(LOWER, 35) == [((6, 60928, 37, 255), OURS.name.to_bytes(8, "little"))]
    assert (end.node.operating, end.node.address) == (False, 37)
    bus.run(bus.now + 0.24)
    assert not end.node.operating
    bus.run(bus.now + 0.02)
    assert end.node.operating
    assert end.happened == [AddressLost(35, LOWER), AddressClaimed(37, OURS.name)]


def test_two_nodes_that_want_one_address_end_with_two() -> None:
    one, other = End(OURS), End(NodeSettings(unique_number=7))
    bus = Bus(one, other)
    bus.run(2.0)
    assert (one.node.address, other.node.address) == (35, 36)
    assert one.node.operating
    assert other.node.operating
    assert one.devices.at(36) is not None
    assert other.devices.at(35) is not None


def test_a_bus_without_a_free_address_is_told_so_and_tried_again() -> None:
    bus, end = settled()
    for address in range(252):
        bus.claim(with_instance(LOWER, 0) - address, address)
    assert (end.node.address, end.node.operating) == (254, False)
    assert end.happened[-1] == NoAddress()
    bus.run(bus.now + 0.2)
    assert claims(bus)[-1] == (254, OURS.name)
    bus.say(WHO, 254)
    bus.run(bus.now + 0.2)
    assert claims(bus)[-1] == (254, OURS.name)
    bus.run(bus.now + 11.0)  # nobody answers the scan: all of them have gone
    assert end.node.operating
    assert end.happened[-1] == AddressClaimed(end.node.address, OURS.name)
    assert min(now for now, target, _ in bus.said if target.pgn == IsoRequest.PGN and now > 2) == 10.6


@pytest.mark.parametrize(("source", "destination"), [(254, 255), (254, 35), (7, 255), (7, 35)])
def test_a_request_for_claims_is_answered_whoever_asks(source: int, destination: int) -> None:
    bus, _ = settled()
    assert bus.say(WHO, source, destination) == [((6, 60928, 35, 255), OURS.name.to_bytes(8, "little"))]


def test_a_request_for_anothers_claim_is_not_ours_to_answer() -> None:
    bus, _ = settled()
    assert bus.say(WHO, 7, 36) == []


def test_nothing_is_answered_before_there_is_an_address() -> None:
    bus = Bus(End(OURS))
    assert bus.say(WHO, 7) == []


def test_a_twin_moves_our_instance_on() -> None:
    bus, end = settled()
    bus.run(2.0)
    twin = with_instance(OURS.name, 1)
    assert bus.claim(OURS.name, 35) == [((6, 60928, 35, 255), twin.to_bytes(8, "little"))]
    bus.run(3.0)
    assert end.happened == [AddressClaimed(35, twin)]
    assert end.node.name == twin


def test_a_twin_at_a_lower_address_moves_our_instance_on_too() -> None:
    bus, end = settled()
    bus.claim(OURS.name, 34)
    assert end.node.name == with_instance(OURS.name, 1)


def test_a_twin_at_a_higher_address_is_told_to_move_on() -> None:
    bus, end = settled()
    assert bus.claim(OURS.name, 77) == [((6, 60928, 35, 255), OURS.name.to_bytes(8, "little"))]
    bus.run(1.0)
    bus.claim(with_instance(OURS.name, 1), 77)
    bus.run(3.0)
    assert end.node.name == OURS.name


def test_a_twin_that_does_not_move_on_moves_us() -> None:
    bus, end = settled()
    bus.claim(OURS.name, 77)
    bus.run(1.0)
    bus.claim(OURS.name, 77)  # again: it does not get more time for that
    assert end.node.name == OURS.name
    bus.run(1.2)
    assert end.node.name == with_instance(OURS.name, 1)
    bus.run(3.0)
    assert (end.happened, end.node.name) == ([AddressClaimed(35, end.node.name)], with_instance(OURS.name, 1))


def test_what_others_claim_does_not_tell_that_the_twin_has_moved_on() -> None:
    bus, end = settled()
    bus.claim(OURS.name, 77)
    bus.claim(HIGHER, 78)
    bus.run(1.2)
    assert end.node.name == with_instance(OURS.name, 1)


@pytest.mark.parametrize("travel", [0.0, 0.01, 0.03, 0.1, 0.2])
@pytest.mark.parametrize("addresses", [(35, 36), (36, 35), (0, 251)])
def test_two_of_a_kind_whose_claims_cross_do_not_go_on_claiming(addresses: tuple[int, int], travel: float) -> None:
    """As two gateways of one computer do, of which one hears the bus through the other."""
    ends = [End(OURS, address) for address in addresses]
    said = 0
    under_way: list[tuple[float, End, Frame]] = []
    for now in (step / 100 for step in range(500)):
        arrived = [(end, frame) for due, end, frame in under_way if due <= now]
        under_way = [each for each in under_way if each[0] > now]
        spoken = [(end, end.expire(now)) for end in ends] + [(end, end.hear(frame, now)) for end, frame in arrived]
        for speaker, frames in spoken:
            said += sum(frame.identifier >> 8 & 0xFF00 == 0xEE00 for frame in frames)
            under_way += [(now + travel, end, frame) for frame in frames for end in ends if end is not speaker]
    assert [end.node.operating for end in ends] == [True, True]
    assert {end.node.address for end in ends} == set(addresses)
    assert ends[0].node.name != ends[1].node.name
    assert said <= 8


def test_a_twin_that_is_heard_while_we_look_around_changes_our_name_before_it_is_said() -> None:
    end = End(OURS)
    bus = Bus(end)
    bus.run(0.1)
    bus.claim(OURS.name, 99)
    bus.run(1.0)
    assert claims(bus)[1:] == [(35, with_instance(OURS.name, 1))]


def test_our_own_claim_that_comes_back_is_no_twin() -> None:
    bus, end = settled()
    bus.say(WHO, 7)
    assert bus.claim(OURS.name, 35) == []
    assert end.node.name == OURS.name
    assert end.devices.at(35) is None


def test_what_comes_back_a_second_later_is_a_twin() -> None:
    bus, end = settled()
    bus.say(WHO, 7)  # so that the claim is said now, at 0.6
    bus.run(1.59)
    bus.claim(OURS.name, 35)
    assert end.node.name == OURS.name
    bus.run(1.6)
    bus.claim(OURS.name, 35)
    assert end.node.name == with_instance(OURS.name, 1)


def test_a_claim_that_comes_back_after_its_address_was_lost_is_no_twin() -> None:
    bus, end = settled()
    bus.say(WHO, 7)
    bus.claim(LOWER, 35)
    bus.run(1.0)
    assert end.node.address == 36
    bus.claim(OURS.name, 35)
    assert end.node.name == OURS.name


def test_who_was_heard_as_the_scan_began_has_its_address() -> None:
    end = End(OURS)
    bus = Bus(end)
    bus.run(0.05)
    bus.claim(HIGHER, 35)
    bus.run(1.0)
    assert end.node.address == 36


def test_the_last_moment_in_which_a_twin_may_move_on_is_over_at_half_a_second() -> None:
    bus, end = settled()
    bus.claim(OURS.name, 77)
    bus.run(1.09)
    assert end.node.name == OURS.name
    bus.run(1.1)
    assert end.node.name == with_instance(OURS.name, 1)


def test_the_instance_after_the_last_is_the_first() -> None:
    assert with_instance(OURS.name, 255) == OURS.name | 255 << 32
    assert with_instance(with_instance(OURS.name, 255), 256) == OURS.name


@pytest.mark.parametrize("address", [0, 251])
def test_the_first_and_the_last_address_may_be_commanded(address: int) -> None:
    bus, end = settled()
    bus.say(Outgoing(65240, OURS.name.to_bytes(8, "little") + bytes((address,))), 7)
    bus.run(1.0)
    assert end.node.address == address


def test_a_commanded_address_is_taken() -> None:
    bus, end = settled()
    payload = OURS.name.to_bytes(8, "little") + bytes((99,))
    announcement = bytes((32, 9, 0, 2, 255)) + (65240).to_bytes(3, "little")
    bus.say(Outgoing(60416, announcement), 7)
    bus.say(Outgoing(60160, b"\x01" + payload[:7]), 7)
    assert bus.say(Outgoing(60160, b"\x02" + payload[7:].ljust(7, b"\xff")), 7) == [
        ((6, 60928, 99, 255), OURS.name.to_bytes(8, "little"))
    ]
    bus.run(1.0)
    assert end.happened == [AddressLost(35, 0), AddressClaimed(99, OURS.name)]


@pytest.mark.parametrize(
    "payload",
    [
        LOWER.to_bytes(8, "little") + bytes((99,)),
        OURS.name.to_bytes(8, "little") + bytes((252,)),
        OURS.name.to_bytes(8, "little") + bytes((35,)),
        OURS.name.to_bytes(8, "little"),
    ],
    ids=["another's NAME", "no address", "the same address", "cut short"],
)
def test_another_commanded_address_is_not(payload: bytes) -> None:
    bus, end = settled()
    assert bus.say(Outgoing(65240, payload), 7) == []
    assert end.node.address == 35


def test_a_node_is_commanded_to_an_address_even_while_it_has_none() -> None:
    end = End(OURS)
    bus = Bus(end)
    bus.say(Outgoing(65240, OURS.name.to_bytes(8, "little") + bytes((99,))), 7)
    bus.run(1.0)
    assert end.happened == [AddressClaimed(99, OURS.name)]


def test_a_bus_that_is_back_is_told_where_we_are_and_asked_who_is_there() -> None:
    _, end = settled()
    said = end._done(end.node.bus_back(9.0))
    assert [frame.identifier >> 8 & 0x3FF00 for frame in said] == [60928, 59904]
    assert end.node.operating
    fresh = End(OURS)
    assert fresh.node.bus_back(0.0) == []
    assert End(None).node.bus_back(0.0) == []


@pytest.mark.parametrize(("name", "events"), [(HIGHER, 0), (LOWER, 2)])
def test_a_storm_of_claims_is_answered_once_a_loss_and_ten_times_a_second_at_most(name: int, events: int) -> None:
    """10,000 claims a second for our address, for two seconds."""
    bus, end = settled()
    bus.run(1.0)
    bus.said.clear()
    for number in range(20_000):
        if number % 100 == 0:
            bus.run(1.0 + number / 10_000)
        for frame in end.hear(claim_at(35, name), bus.now):
            bus._carry([frame], end)
    ours = [claim for claim in claims(bus) if claim[1] == OURS.name]
    assert len(ours) == (1 if events else 21)
    assert len(end.happened) == events
    assert end.node.operating
    assert end.node.address == (36 if events else 35)


def test_a_storm_that_follows_us_costs_a_claim_a_loss() -> None:
    bus, end = settled()
    bus.run(1.0)
    bus.said.clear()
    for number in range(2_000):
        if number % 100 == 0:
            bus.run(1.0 + number / 10_000)
        if end.node.address != 254:
            bus._carry(end.hear(claim_at(end.node.address, LOWER - number), bus.now), end)
    bus.run(bus.now + 0.2)
    assert len([claim for claim in claims(bus) if claim[1] == OURS.name]) <= 5
    assert end.node.address == 254
