from timonel.core.effects import Transmit
from timonel.nmea0183.checksum import seal
from timonel.nmea0183.selection import Hearing
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.vehicle import Boat

HDT, DEPTH = seal("HEHDT,182.3,T"), seal("SDDPT,5.0,0.0,")


def told(hears: Hearing | None, *sentences: bytes) -> tuple[Boat, set[int]]:
    """The boat, and the PGNs that it put on the bus."""
    boat = Boat(BoatSettings(), [Port("Compass", instrument=True, hears=hears)], 0.0)
    effects = [
        effect for second in range(10) for line in sentences for effect in boat.receive_bytes("Compass", line, second)
    ]
    return boat, {effect.frame.identifier >> 8 & 0x1FFFF for effect in effects if isinstance(effect, Transmit)}


def test_what_the_owner_does_not_want_of_an_instrument_is_counted_and_not_told_on_the_bus() -> None:
    boat, pgns = told(Hearing(only=("HDT",)), HDT, DEPTH)
    assert (pgns, boat.counters["sentences that this port's owner does not want"]) == ({127250}, 10)


def test_without_a_wish_all_of_it_is_told() -> None:
    boat, pgns = told(None, HDT, DEPTH)
    assert (pgns, boat.counters["sentences that this port's owner does not want"]) == ({127250, 128267}, 0)
