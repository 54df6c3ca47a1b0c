"""How Home Assistant finds a vehicle by itself: a retained document for each entity (its MQTT discovery).

`<prefix>/<component>/<device>/<entity>/config` says what an entity is called, where its state is and how that becomes
what people read: degrees, knots and degrees Celsius of radians, metres a second and kelvins. Source: Home Assistant,
"MQTT discovery", and the pages of the components sensor, binary_sensor, device_tracker, button, number and select.

An order that a device of Home Assistant gives is one as the console's HTTP interface takes it.
"""

from collections.abc import Iterable, Iterator, Mapping
from math import degrees, pi
from typing import Any

import msgspec

from timonel.interop.mqtt import AVAILABILITY, ORDER, VALUES, Kind, Value, Vehicle

Config = dict[str, Any]
KNOTS = 3600 / 1852
FREEZING = 273.15  # K


class Shown(msgspec.Struct, frozen=True):
    """How a kind of values is read: `value * factor + offset` in `unit`, to so many `digits`."""

    unit: str
    factor: float = 1.0
    offset: float = 0.0
    digits: int = 1
    device_class: str | None = None


SHOWN: dict[Kind, Shown] = {
    "angle": Shown("°", degrees(1)),
    "helm_angle": Shown("°", degrees(1)),
    "turn_rate": Shown("°/min", degrees(60)),
    "speed": Shown("kn", KNOTS, device_class="speed"),
    "wind_speed": Shown("kn", KNOTS, device_class="wind_speed"),
    "depth": Shown("m", device_class="distance"),
    "temperature": Shown("°C", offset=-FREEZING, device_class="temperature"),
    "voltage": Shown("V", digits=2, device_class="voltage"),
    "rpm": Shown("rpm", digits=0),
}


class Device(msgspec.Struct, frozen=True):
    """The vehicle as a device: what it is known by, its name for people, where its topics are."""

    id: str
    name: str
    vehicle: Vehicle
    base: str
    version: str


class Entity(msgspec.Struct, frozen=True):
    """One thing of a device: its component of Home Assistant, its key, and what is said of it. None takes it back."""

    component: str
    key: str
    config: Config | None


def discovery(device: Device, prefix: str, alerts: Mapping[int, str], station: int | None) -> dict[str, Config | None]:
    """What is to stand at which topic; None: nothing more.

    `alerts` are those that are known, by number. Whoever looks may give orders if a `station` is paired.
    """
    entities = [*_entities(device, alerts), *_orders(device, station)]
    return {
        f"{prefix}/{entity.component}/{device.id}/{entity.key}/config": _whole(entity, device) for entity in entities
    }


def _whole(entity: Entity, device: Device) -> Config | None:
    if entity.config is None:
        return None
    return {
        "unique_id": f"{device.id}_{entity.key}",
        "availability_topic": f"{device.base}/{AVAILABILITY}",
        **entity.config,
        "device": {
            "identifiers": [device.id],
            "name": device.name,
            "manufacturer": "timonel",
            "model": f"{device.vehicle} gateway",
            "sw_version": device.version,
        },
        "origin": {"name": "timonel", "sw_version": device.version},
    }


# What is to be seen ---------------------------------------------------------------------------------------------


def _entities(device: Device, alerts: Mapping[int, str]) -> Iterator[Entity]:
    base = device.base
    for value in VALUES[device.vehicle]:
        yield Entity("sensor", value.key, _sensor(base, value))
    yield Entity(
        "sensor", "command", _text(base, "Command", "command", "value_json.name or 'nobody'", "mdi:ship-wheel")
    )
    yield Entity("device_tracker", "position", {
        "name": "Position", "json_attributes_topic": f"{base}/position", "source_type": "gps",
    })  # fmt: skip
    yield from _boat(base) if device.vehicle == "boat" else _rover(base)
    yield Entity("binary_sensor", "bus", _switch(
        base, "Bus", "links", "value_json | selectattr('kind', 'eq', 'bus') | selectattr('connected') | list",
        "connectivity",
    ))  # fmt: skip
    urgent = "value_json | rejectattr('priority', 'eq', 'caution') | list"
    yield Entity("binary_sensor", "alarm", _switch(base, "Alarm", "alerts", urgent, "problem"))
    yield from _alerts(base, alerts.items())


def _boat(base: str) -> Iterator[Entity]:
    yield Entity("sensor", "pilot_mode", _text(base, "Pilot", "pilot", "value_json.mode or None", "mdi:robot"))
    setpoint = Value("pilot", "Set point", "angle")
    yield Entity("sensor", "setpoint", _sensor(base, setpoint) | {"value_template": _converted("setpoint", "angle")})


def _rover(base: str) -> Iterator[Entity]:
    permitted = _switch(base, "Drives", "drive", "value_json.permitted", "running")
    yield Entity("binary_sensor", "drives", permitted | {"json_attributes_topic": f"{base}/drive"})
    yield Entity("sensor", "battery_state", _text(base, "Battery", "drive", "value_json.battery", "mdi:battery"))


def _alerts(base: str, alerts: Iterable[tuple[int, str]]) -> Iterator[Entity]:
    for number, name in alerts:
        active = f"value_json | selectattr('id', 'eq', {number}) | selectattr('active') | list"
        yield Entity("binary_sensor", f"alert_{number}", _switch(base, name.capitalize(), "alerts", active, "problem"))


def _sensor(base: str, value: Value) -> Config:
    shown = SHOWN[value.kind]
    classed = {} if shown.device_class is None else {"device_class": shown.device_class}
    return {
        "name": value.name,
        "state_topic": f"{base}/{value.key}",
        "value_template": _converted("value", value.kind),
        "unit_of_measurement": shown.unit,
        "suggested_display_precision": shown.digits,
        "state_class": "measurement",
        **classed,
    }


def _converted(field: str, kind: Kind) -> str:
    """What Home Assistant makes of a value; "None" is to it what null is to us."""
    shown, name = SHOWN[kind], f"value_json.{field}"
    number = f"({name} * {shown.factor!r} + {shown.offset!r}) | round({shown.digits})"
    whole = f"({number}) % 360" if kind == "angle" else number  # what rounds to 360 is north
    return f"{{{{ None if {name} is none else {whole} }}}}"


def _text(base: str, name: str, key: str, expression: str, icon: str) -> Config:
    topic = f"{base}/{key}"
    return {
        "name": name,
        "state_topic": topic,
        "value_template": f"{{{{ {expression} }}}}",
        "json_attributes_topic": topic,
        "icon": icon,
    }


def _switch(base: str, name: str, key: str, condition: str, device_class: str) -> Config:
    return {
        "name": name,
        "state_topic": f"{base}/{key}",
        "value_template": f"{{{{ 'ON' if ({condition}) else 'OFF' }}}}",
        "device_class": device_class,
    }


# What may be ordered --------------------------------------------------------------------------------------------

BUTTONS: dict[Vehicle, dict[str, tuple[str, str, str]]] = {
    "boat": {
        "request": ("Request command", "REQCMD", "mdi:hand-back-right"),
        "release": ("Release command", "RELCMD", "mdi:hand-wave"),
        "standby": ("Standby", "DISENGAGE", "mdi:pause-octagon"),
        "auto": ("Auto", "ENGAGE", "mdi:robot"),
        "port_10": ("Port 10°", "PORTTEN", "mdi:chevron-double-left"),
        "port_1": ("Port 1°", "PORTONE", "mdi:chevron-left"),
        "starboard_1": ("Starboard 1°", "STBDONE", "mdi:chevron-right"),
        "starboard_10": ("Starboard 10°", "STBDTEN", "mdi:chevron-double-right"),
    },
    "rover": {"stop": ("Stop", "stop", "mdi:stop-circle")},
}
"""Key, and then name, word and picture. A rover has no others: nobody who drives it may be so far away."""


def _orders(device: Device, station: int | None) -> Iterator[Entity]:
    """Where nobody may order, what may have been offered before is taken back."""
    for entity in _offered(device):
        yield entity if station is not None else Entity(entity.component, entity.key, None)


def _offered(device: Device) -> Iterator[Entity]:
    topic = f"{device.base}/{ORDER}"
    for key, (name, word, icon) in BUTTONS[device.vehicle].items():
        order = {"type": word, "id": 0} if word.islower() else {"type": "command", "id": 0, "verb": word}
        config = {"name": name, "command_topic": topic, "payload_press": _json(order), "icon": icon}
        yield Entity("button", key, config)
    if device.vehicle == "boat":
        yield Entity("number", "course", _course(device.base, topic))


def _course(base: str, topic: str) -> Config:
    order = '{"type": "command", "id": 0, "verb": "SETHEADING", "parameter": {{ value * ' + repr(pi / 180) + " }}}"
    return {
        "name": "Course",
        "command_topic": topic,
        "command_template": order,
        "state_topic": f"{base}/pilot",
        "value_template": _converted("setpoint", "angle"),
        "min": 0,
        "max": 359.9,
        "step": 0.1,
        "mode": "box",
        "unit_of_measurement": "°",
        "icon": "mdi:compass",
    }


def _json(order: Config) -> str:
    return msgspec.json.encode(order).decode()
