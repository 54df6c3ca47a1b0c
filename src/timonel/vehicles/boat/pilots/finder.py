"""Which device on the bus is the pilot: by NAME, never by an address that somebody once found it at.

A pilot says of itself, in PGN 60928, that it is of class 40 (steering) and there of function 150 (autopilot): the
function alone means something else in every other class. A converter that older pilots stand behind says what it is
in its product information.
"""

from collections.abc import Iterable

import msgspec

from timonel.nmea2000.devices import Device
from timonel.nmea2000.identifier import NULL
from timonel.nmea2000.lookups import DeviceClass, ManufacturerCode

AUTOPILOT = (DeviceClass.STEERING_AND_CONTROL, 150)
HEXADECIMAL = "0x"


def is_autopilot(device: Device) -> bool:
    """Whether a device says to be an autopilot."""
    return (device.claim.device_class, device.claim.device_function) == AUTOPILOT


def maker_called(word: str) -> ManufacturerCode | None:
    """The maker whose name is `word`, whatever stands between its words; None if there is none."""
    wanted = _letters(word)
    return next((maker for maker in ManufacturerCode if _letters(maker.name) == wanted), None)


def _letters(word: str) -> str:
    return "".join(letter for letter in word.lower() if letter.isalnum())


class Wanted(msgspec.Struct, frozen=True):
    """What the owner says about the pilot: its NAME, or who made it. Neither is any."""

    name: int | None = None
    maker: ManufacturerCode | None = None

    @classmethod
    def of(cls, text: str) -> "Wanted":
        """`0x...` is a NAME, a word is a maker, nothing is any. Raises ValueError for what is neither."""
        if not text:
            return cls()
        if text.startswith(HEXADECIMAL):
            name = int(text, 16)
            if name >= 1 << 64:
                raise ValueError(f"{text} has more than 64 bits")
            return cls(name=name)
        maker = maker_called(text)
        if maker is None:
            raise ValueError(f"{text!r} is neither a NAME like 0xC0509635E761AEC1 nor a maker that is known")
        return cls(maker=maker)

    def admits(self, device: Device) -> bool:
        """Whether it may be this device."""
        if self.name is not None:
            return device.name == self.name
        return self.maker is None or device.claim.manufacturer_code is self.maker


class Finder:
    """Finds the pilot of some makers among the devices of the bus; no makers are all makers.

    `model` is how the model or version of a converter begins that stands for the pilot.
    """

    def __init__(
        self,
        devices: Iterable[Device],
        wanted: Wanted,
        makers: frozenset[ManufacturerCode] = frozenset(),
        model: str = "",
    ) -> None:
        self._devices = devices
        self._wanted = wanted
        self._makers = makers
        self._model = model

    @property
    def candidates(self) -> list[Device]:
        """The devices that may be the pilot. One that the owner named need not say that it is one."""
        reachable = [device for device in self._devices if device.address < NULL and self._wanted.admits(device)]
        return reachable if self._wanted.name is not None else [device for device in reachable if self._fits(device)]

    @property
    def address(self) -> int | None:
        """Where the pilot is; None while there is none, or more than one."""
        found = self.candidates
        return found[0].address if len(found) == 1 else None

    @property
    def objection(self) -> str | None:
        """Why there is no address."""
        match len(self.candidates):
            case 0:
                return "no pilot found on the bus"
            case 1:
                return None
        return "several pilots on the bus: pilot_name says which"

    def _fits(self, device: Device) -> bool:
        if self._makers and device.claim.manufacturer_code not in self._makers:
            return False
        return self._is_converter(device) if self._model else is_autopilot(device)

    def _is_converter(self, device: Device) -> bool:
        product = device.product
        told = () if product is None else (product.model_id, product.model_version, product.software_version_code)
        return any(text.startswith(self._model) for text in told if text)
