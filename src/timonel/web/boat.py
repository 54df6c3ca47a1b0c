"""What a boat shows."""

from collections.abc import Callable, Mapping
from math import nan, radians, tau
from typing import Any

from timonel.core.command import CommandTransfer
from timonel.gateway.configuration import Configuration
from timonel.gateway.devices import DeviceShown, roll
from timonel.gateway.gateway import Gateway
from timonel.nmea2000.lookups import HeadingReference, WindReference
from timonel.vehicles.boat.pilot import Mode
from timonel.vehicles.boat.truth import Datum, Heading
from timonel.vehicles.boat.vehicle import Boat
from timonel.web.messages import (
    DeviceState,
    Direction,
    LinkState,
    Measured,
    PilotState,
    Position,
    Reference,
    Wind,
)
from timonel.web.state import State, Topics, finite, fresh, measured, quality, seconds

NO_WIND = Wind(None, None, None, "absent")
NOWHERE = Position(None, None, None, "absent")

Sample = Callable[[Mapping[str, Any]], float | None]
SAMPLES: dict[str, Sample] = {
    "heading": lambda topics: fresh(topics["heading"]),
    "setpoint": lambda topics: topics["pilot"].setpoint,
    "rudder": lambda topics: fresh(topics["rudder"]),
    "rate_of_turn": lambda topics: fresh(topics["rate_of_turn"]),
    "cog": lambda topics: fresh(topics["cog"]),
    "sog": lambda topics: fresh(topics["sog"]),
    "stw": lambda topics: fresh(topics["stw"]),
    "depth": lambda topics: fresh(topics["depth"]),
    "wind_apparent_speed": lambda topics: fresh(topics["wind_apparent"], "speed"),
    "wind_apparent_angle": lambda topics: fresh(topics["wind_apparent"], "angle"),
    "wind_true_speed": lambda topics: fresh(topics["wind_true"], "speed"),
    "wind_true_angle": lambda topics: fresh(topics["wind_true"], "angle"),
    "water_temperature": lambda topics: fresh(topics["water_temperature"]),
    "latitude": lambda topics: fresh(topics["position"], "latitude"),
    "longitude": lambda topics: fresh(topics["position"], "longitude"),
}


class BoatState(State):
    """The topics of a boat."""

    def __init__(self, gateway: Gateway, configuration: Configuration, boat: Boat) -> None:
        super().__init__(gateway, configuration)
        self._boat = boat
        self._age = boat.settings.max_age
        self._reference: Reference = boat.settings.heading_reference
        self._devices: tuple[object, list[DeviceState]] = (None, [])

    @property
    def transfer(self) -> CommandTransfer:
        return self._boat.helm.transfer

    def topics(self, now: float) -> Topics:
        """Everything as it stands at `now` (s)."""
        truth, age = self._boat.truth, self._age
        return super().topics(now) | {
            "pilot": self._pilot(),
            "heading": self._heading(now),
            "cog": self._cog(now),
            "sog": part(truth.course, "sog", now, age),
            "stw": part(truth.speed, "speed_water_referenced", now, age),
            "rudder": measured(truth.rudder.value, truth.rudder.heard, now, age),
            "rate_of_turn": part(truth.rate, "rate", now, age),
            "depth": part(truth.depth, "depth", now, age),
            "wind_apparent": self._wind(WindReference.APPARENT, now),
            "wind_true": self._wind_true(now),
            "water_temperature": measured(truth.sea_temperature.value, truth.sea_temperature.heard, now, 2 * age),
            "position": self._position(now),
            "utc": part(truth.clock, "unix", now, age),
            "variation": self._variation(now),
            "devices": self._roll(),
        }

    def samples(self, topics: Mapping[str, Any]) -> dict[str, float | None]:
        """The values whose course over time is kept."""
        return {name: sample(topics) for name, sample in SAMPLES.items()}

    def _pilot(self) -> PilotState:
        pilot = self._boat.helm.pilot
        holds = pilot.mode is not Mode.STANDBY and pilot.setpoint is not None
        setpoint = finite(radians((pilot.setpoint or 0) / 10)) if holds else None
        return PilotState(pilot.mode.value, setpoint, self._reference, pilot.pending)

    def _heading(self, now: float) -> Direction:
        truth = self._boat.truth
        datum: Datum[Heading] = truth.true if self._reference == "true" else truth.magnetic
        angle = None if datum.value is None else datum.value.angle
        return self._direction(measured(angle, datum.heard, now, self._age), self._reference)

    def _cog(self, now: float) -> Direction:
        course = self._boat.truth.course
        told = course.value
        magnetic = told is not None and told.cog_reference is HeadingReference.MAGNETIC
        return self._direction(part(course, "cog", now, self._age), "magnetic" if magnetic else "true")

    def _direction(self, value: Measured, reference: Reference) -> Direction:
        return Direction(value.value, value.at, value.quality, reference)

    def _wind(self, kind: WindReference, now: float, bow: float = 0.0) -> Wind:
        """Wind of a kind, its angle counted from `bow`."""
        datum = self._boat.truth.winds.get(kind)
        told = None if datum is None else datum.value
        if datum is None or told is None:
            return NO_WIND
        angle = None if told.wind_angle is None else (told.wind_angle - bow) % tau
        worth = quality(datum.heard, now, self._age)
        return Wind(finite(told.wind_speed), finite(angle), seconds(datum.heard), worth)

    def _wind_true(self, now: float) -> Wind:
        """Against the water; else over ground, as far as the heading is known."""
        water = self._wind(WindReference.TRUE_WATER, now)
        if water.quality == "fresh":
            return water
        heading = self._boat.truth.true_heading(now)
        ground = self._wind(WindReference.TRUE_NORTH, now, nan if heading is None else heading)
        return ground if ground.quality == "fresh" or water.quality == "absent" else water

    def _position(self, now: float) -> Position:
        datum = self._boat.truth.position
        if datum.value is None or datum.heard == float("-inf"):
            return NOWHERE
        latitude, longitude = datum.value
        worth = quality(datum.heard, now, self._age)
        return Position(finite(latitude, 7), finite(longitude, 7), seconds(datum.heard), worth)

    def _variation(self, now: float) -> Measured:
        told = self._boat.truth.told_variation
        value = measured(told.value, told.heard, now, self._age)
        if value.quality == "fresh":
            return value
        modelled = self._boat.truth.variation(now)
        return value if modelled is None else measured(modelled, self._boat.truth.position.heard, now, self._age)

    def _roll(self) -> list[DeviceState]:
        """Who is on the bus; put into words only when that has changed."""
        boat = self._boat
        known = (boat.devices.revision, boat.node.address, boat.node.name)
        if self._devices[0] != known:
            self._devices = (known, [device_state(device) for device in roll(boat.devices, 0.0, boat.node)])
        return self._devices[1]

    def _links(self, now: float) -> list[LinkState]:
        fix = self._boat.truth.position
        connected = now - fix.heard < self._age
        since = None if fix.heard == float("-inf") or connected else seconds(fix.heard)
        return [*super()._links(now), LinkState("GNSS", "gnss", connected, "" if connected else "no position", since)]


def device_state(device: DeviceShown) -> DeviceState:
    """A device as the console shows it; what was described at time 0 was heard at minus its age."""
    return DeviceState(
        device.address,
        device.name or "",
        device.maker or "",
        device.model,
        device.software,
        device.serial,
        device.function or "",
        device.instance or 0,
        device.installation,
        -(device.seconds or 0.0),
        device.ours,
    )


def part(datum: Datum[Any], name: str, now: float, age: float) -> Measured:
    """A value of what a datum holds."""
    value = None if datum.value is None else getattr(datum.value, name)
    return measured(value, datum.heard, now, age)
