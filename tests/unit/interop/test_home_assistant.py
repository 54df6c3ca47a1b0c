"""What Home Assistant is told. That its own schema takes the documents was seen with Home Assistant 2024.3."""

from typing import Any

import msgspec
import pytest

from timonel.interop.home_assistant import Config, Device, discovery
from timonel.interop.mqtt import VALUES, Vehicle
from timonel.web.messages import Command, Stop

COMMON = {"name", "unique_id", "availability_topic", "device", "origin", "icon"}
KNOWN = {
    "sensor": COMMON
    | {
        "state_topic", "value_template", "unit_of_measurement", "device_class", "state_class",
        "suggested_display_precision", "json_attributes_topic",
    },
    "binary_sensor": COMMON | {"state_topic", "value_template", "device_class", "json_attributes_topic"},
    "device_tracker": COMMON | {"json_attributes_topic", "source_type"},
    "button": COMMON | {"command_topic", "payload_press"},
    "number": COMMON
    | {
        "command_topic", "command_template", "state_topic", "value_template", "min", "max", "step", "mode",
        "unit_of_measurement",
    },
}  # fmt: skip
"""Keys of each component, from the pages of Home Assistant."""


def told(vehicle: Vehicle, station: int | None = None) -> dict[str, Config | None]:
    device = Device("timonel_alisea", "Alisea", vehicle, "timonel/alisea", "1.0")
    return discovery(device, "homeassistant", {101: "backbone silent"}, station)


def configs(vehicle: Vehicle, station: int | None = None) -> dict[tuple[str, str], dict[str, Any]]:
    """By component and entity."""
    parts = {tuple(topic.split("/")): config for topic, config in told(vehicle, station).items()}
    assert {(part[0], part[2], part[4]) for part in parts} == {("homeassistant", "timonel_alisea", "config")}
    return {(part[1], part[3]): config for part, config in parts.items() if config is not None}


@pytest.mark.parametrize("vehicle", ["boat", "rover"])
def test_each_document_has_only_what_its_component_knows(vehicle: Vehicle) -> None:
    for (component, _), config in configs(vehicle, station=3).items():
        assert config.keys() <= KNOWN[component]


@pytest.mark.parametrize("vehicle", ["boat", "rover"])
def test_every_value_is_a_sensor_of_one_device(vehicle: Vehicle) -> None:
    found = configs(vehicle)
    assert {("sensor", value.key) for value in VALUES[vehicle]} <= found.keys()
    assert len({config["unique_id"] for config in found.values()}) == len(found)
    assert {str(config["device"]["identifiers"]) for config in found.values()} == {"['timonel_alisea']"}


def test_people_read_degrees_and_knots_and_celsius() -> None:
    found = configs("boat")
    units = {key: config.get("unit_of_measurement") for (_, key), config in found.items()}
    assert (units["heading"], units["sog"], units["water_temperature"], units["depth"]) == ("°", "kn", "°C", "m")
    template = found["sensor", "heading"]["value_template"]
    expected = (
        "{{ None if value_json.value is none else ((value_json.value * 57.29577951308232 + 0.0) | round(1)) % 360 }}"
    )
    assert template == expected


def test_an_alert_is_on_while_it_is_active() -> None:
    alert = configs("boat")["binary_sensor", "alert_101"]
    assert alert["name"] == "Backbone silent"
    assert alert["state_topic"] == "timonel/alisea/alerts"
    assert "selectattr('id', 'eq', 101) | selectattr('active')" in alert["value_template"]


@pytest.mark.parametrize("vehicle", ["boat", "rover"])
def test_where_nobody_may_order_what_could_be_pressed_is_taken_back(vehicle: Vehicle) -> None:
    offered = [key for key in configs(vehicle, station=3) if key[0] in ("button", "number")]
    assert offered
    alone = told(vehicle)
    for component, key in offered:
        assert alone[f"homeassistant/{component}/timonel_alisea/{key}/config"] is None
    assert not [key for key in configs(vehicle) if key[0] in ("button", "number")]


def test_a_boat_s_buttons_are_the_words_of_the_console() -> None:
    found = configs("boat", station=3)
    pressed = [config["payload_press"] for (kind, _), config in found.items() if kind == "button"]
    orders = [msgspec.json.decode(order, type=Command) for order in pressed]
    verbs = ["REQCMD", "RELCMD", "DISENGAGE", "ENGAGE", "PORTTEN", "PORTONE", "STBDONE", "STBDTEN"]
    assert [order.verb for order in orders] == verbs
    course = found["number", "course"]["command_template"].replace("{{ value * 0.017453292519943295 }}", "0.785")
    assert msgspec.json.decode(course, type=Command) == Command(0, "SETHEADING", 0.785)


def test_all_that_can_be_pressed_on_a_rover_is_stop() -> None:
    buttons = [config for (kind, _), config in configs("rover", station=2).items() if kind in ("button", "number")]
    assert [msgspec.json.decode(config["payload_press"], type=Stop) for config in buttons] == [Stop(0)]
