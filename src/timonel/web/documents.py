"""What the console shows, as documents for an MQTT broker."""

from collections.abc import Callable, Mapping
from typing import Any

from timonel.interop import mqtt
from timonel.web.messages import AlertState, CommandState, DriveState, LinkState, PilotState, WheelState
from timonel.web.state import fresh

Topics = Mapping[str, Any]
Documents = dict[str, mqtt.Document | list[mqtt.Document]]
Measured = tuple[float | None, str, str | None]
"""A value while it holds, its quality, and the reference of a direction."""
Read = Callable[[Topics], Measured]


def values(topics: Topics, vehicle: mqtt.Vehicle) -> Documents:
    """The measured values, by the last level of their topic."""
    return {value.key: _reading(topics, READS[vehicle][value.key], value.kind) for value in mqtt.VALUES[vehicle]}


def states(topics: Topics, vehicle: mqtt.Vehicle, now: float) -> Documents:
    """All else, which people should see at once; `now` in s."""
    told: Documents = {
        "command": _command(topics["command"]),
        "alerts": [_alert(alert, now) for alert in topics["alerts"]],
        "links": [_link(link) for link in topics["links"]],
    }
    if vehicle == "boat":
        return told | {"pilot": _pilot(topics["pilot"]), "position": _position(topics["position"])}
    return told | {"drive": _drive(topics["drive"], topics["battery"].state), "position": _position(topics["gps"])}


def _reading(topics: Topics, read: Read, kind: mqtt.Kind) -> mqtt.Reading:
    value, quality, reference = read(topics)
    return mqtt.Reading(value, mqtt.UNITS[kind], quality, reference)


def _part(topic: str, name: str = "value") -> Read:
    """A value of a topic."""

    def read(topics: Topics) -> Measured:
        told = topics[topic]
        return fresh(told, name), told.quality, getattr(told, "reference", None)

    return read


def _cell(number: int) -> Read:
    def read(topics: Topics) -> Measured:
        battery = topics["battery"]
        return (battery.cells[number] if battery.quality == "fresh" else None), battery.quality, None

    return read


def _wheel_speed(topics: Topics) -> Measured:
    """The mean of the wheels that tell theirs."""
    wheels: list[WheelState] = topics["wheels"]
    speeds = [speed for wheel in wheels if (speed := fresh(wheel, "rpm")) is not None]
    if not speeds:
        return None, _worst(wheels), None
    return round(sum(speeds) / len(speeds), 2), "fresh", None


def _worst(wheels: list[WheelState]) -> str:
    return "stale" if any(wheel.quality != "absent" for wheel in wheels) else "absent"


READS: dict[mqtt.Vehicle, dict[str, Read]] = {
    "boat": {
        "heading": _part("heading"),
        "cog": _part("cog"),
        "sog": _part("sog"),
        "stw": _part("stw"),
        "depth": _part("depth"),
        "wind_apparent_speed": _part("wind_apparent", "speed"),
        "wind_apparent_angle": _part("wind_apparent", "angle"),
        "wind_true_speed": _part("wind_true", "speed"),
        "wind_true_angle": _part("wind_true", "angle"),
        "water_temperature": _part("water_temperature"),
        "rudder": _part("rudder"),
        "rate_of_turn": _part("rate_of_turn"),
        "variation": _part("variation"),
    },
    "rover": {
        "battery_voltage": _part("battery", "voltage"),
        **{f"cell{number + 1}": _cell(number) for number in range(4)},
        "wheel_speed": _wheel_speed,
        "heading": _part("magnetometer", "heading"),
    },
}


def _command(state: CommandState) -> mqtt.Command:
    queue = [mqtt.Requester(waiting.station, waiting.name) for waiting in state.queue]
    return mqtt.Command(state.commander, state.commander_name, queue, state.policy)


def _pilot(state: PilotState) -> mqtt.Pilot:
    return mqtt.Pilot(state.mode, state.setpoint, state.reference, state.pending)


def _drive(state: DriveState, battery: str | None) -> mqtt.Drive:
    return mqtt.Drive(state.permitted, state.reason, round(state.left, 3), round(state.right, 3), battery)


def _position(topic: Any) -> mqtt.Position:
    if topic.quality != "fresh":
        return mqtt.Position(topic.quality)
    return mqtt.Position(topic.quality, topic.latitude, topic.longitude)


def _alert(state: AlertState, now: float) -> mqtt.Alert:
    silenced = state.silenced_until is not None and now < state.silenced_until
    return mqtt.Alert(state.id, state.name, state.text, state.priority, state.active, state.acknowledged, silenced)


def _link(state: LinkState) -> mqtt.Link:
    return mqtt.Link(state.name, state.kind, state.connected, state.reason)
