"""The rover's UART framings, by the name that a configuration gives them."""

from timonel.vehicles.rover.framing.framer import Counters, Framer
from timonel.vehicles.rover.framing.hal062 import Hal062
from timonel.vehicles.rover.framing.strzyga import Strzyga
from timonel.vehicles.rover.framing.strzyga_crc import StrzygaCrc

DIALECTS: dict[str, type[Framer]] = {"strzyga": Strzyga, "strzyga-crc": StrzygaCrc, "hal062": Hal062}

__all__ = ["DIALECTS", "Counters", "Framer", "Hal062", "Strzyga", "StrzygaCrc"]
