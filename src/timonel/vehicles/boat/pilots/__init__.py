"""The pilots: one driver a kind, each in a file of its own, behind `driver.Driver`.

`KINDS` is what an owner may choose from, `make_driver` makes the one that is chosen. The way from a station's word to
the rudder is `helm` (who may), `pilot` (what is commanded and confirmed), a driver (in which bytes), `reports` (what
the pilot says of itself).
"""

from collections.abc import Callable, Iterable

import msgspec

from timonel.nmea2000.devices import Device
from timonel.vehicles.boat.pilots import garmin, group_function, navico, raymarine, sentence, standard
from timonel.vehicles.boat.pilots.driver import Compass, Driver, Evidence, Kind
from timonel.vehicles.boat.pilots.finder import Finder, Wanted
from timonel.vehicles.boat.settings import BoatSettings

__all__ = ["KINDS", "Choice", "Driver", "Evidence", "Finder", "Kind", "Wanted", "choose"]

KINDS: dict[str, Kind] = {
    kind.name: kind
    for kind in (
        standard.KIND,
        group_function.KIND,
        raymarine.EVOLUTION,
        raymarine.SPX,
        navico.KIND,
        garmin.KIND,
        sentence.KIND,
    )
}


class Choice(msgspec.Struct, frozen=True):
    """The driver of a boat. `finder` knows where its pilot is; None where nobody asks."""

    kind: Kind
    driver: Driver
    finder: Finder | None


def choose(settings: BoatSettings, devices: Iterable[Device], compass: Compass) -> Choice:
    """What the settings ask for. `devices` are those of the bus, as they are known from time to time."""
    finder = finder_of(settings, devices)
    driver = MAKE[settings.pilot](settings, finder, compass)
    asked = settings.pilot not in WITHOUT_ADDRESS or settings.pilot_name != ""
    return Choice(KINDS[settings.pilot], driver, finder if asked else None)


def finder_of(settings: BoatSettings, devices: Iterable[Device]) -> Finder:
    """Who may be the pilot of a kind."""
    wanted = Wanted.of(settings.pilot_name)
    match settings.pilot:
        case "raymarine":
            return Finder(devices, wanted, raymarine.MAKERS)
        case "raymarine-spx":
            return Finder(devices, wanted, raymarine.MAKERS, raymarine.CONVERTER)
        case "navico":
            return Finder(devices, wanted, navico.MAKERS)
        case "garmin":
            return Finder(devices, wanted, garmin.MAKERS)
    return Finder(devices, wanted)


MAKE: dict[str, Callable[[BoatSettings, Finder, Compass], Driver]] = {
    "standard": lambda settings, finder, compass: standard.StandardPilot(compass),
    "groupfunction": lambda settings, finder, compass: group_function.GroupFunctionPilot(finder, compass),
    "raymarine": lambda settings, finder, compass: raymarine.RaymarinePilot(finder, compass),
    "raymarine-spx": lambda settings, finder, compass: raymarine.ConvertedPilot(finder, compass),
    "navico": lambda settings, finder, compass: navico.NavicoPilot(finder, compass),
    "garmin": lambda settings, finder, compass: garmin.GarminPilot(finder, compass),
    "sentence": lambda settings, finder, compass: sentence.SentencePilot(
        compass, settings.pilot_sentences, settings.pilot_output
    ),
}
WITHOUT_ADDRESS = frozenset({"standard", "sentence"})
"""Those that tell everybody, or nobody on the bus: their pilot is looked for only if its owner names it."""
