"""Messages are those of the specification."""

import json

import pytest

from timonel.interop.signalk.deltas import SELF, Vessel, delta, hello, meta, rounded, tree
from timonel.interop.signalk.model import Model
from timonel.interop.signalk.told import Told

EPOCH = 1_700_000_000.0
UUID = "urn:mrn:signalk:uuid:b7590868-1d62-47d9-989c-32321b349fb9"
VESSEL = Vessel(UUID, "Alba")


def test_a_delta_says_for_each_source_when_it_told_what() -> None:
    news = [
        Told("heading", "timonel.40", 0.25, {"navigation.headingTrue": 1.23456789012}),
        Told("pilot", "timonel", 1.0, {"steering.autopilot.state": None}),
    ]
    assert json.loads(delta(SELF, news, EPOCH)) == {
        "context": "vessels.self",
        "updates": [
            {
                "$source": "timonel.40",
                "timestamp": "2023-11-14T22:13:20.250Z",
                "values": [{"path": "navigation.headingTrue", "value": 1.23456789}],
            },
            {
                "$source": "timonel",
                "timestamp": "2023-11-14T22:13:21.000Z",
                "values": [{"path": "steering.autopilot.state", "value": None}],
            },
        ],
    }


def test_a_stream_begins_with_who_we_are() -> None:
    assert json.loads(hello(VESSEL.context, 0.5, EPOCH)) == {
        "name": "timonel",
        "version": "1.7.0",
        "self": f"vessels.{UUID}",
        "roles": ["master", "main"],
        "timestamp": "2023-11-14T22:13:20.500Z",
    }


def test_meta_says_unit_and_meaning_of_the_paths_that_have_them() -> None:
    (update,) = json.loads(meta(SELF, ["navigation.headingTrue", "navigation.position", "unknown"], 0.0, EPOCH))[
        "updates"
    ]
    units = {each["path"]: each["value"].get("units") for each in update["meta"]}
    assert units == {"navigation.headingTrue": "rad", "navigation.position": None}
    assert all(each["value"]["description"] for each in update["meta"])


@pytest.mark.parametrize(
    ("value", "written"),
    [(0.1 + 0.2, 0.3), (-1e-12, 0.0), ({"latitude": 39.50000001234}, {"latitude": 39.500000012}), ("x", "x"), (3, 3),
     ({"yaw": None}, {"yaw": None}), (None, None), (True, True)],
)  # fmt: skip
def test_no_more_digits_are_written_than_anybody_measures(value: object, written: object) -> None:
    assert json.dumps(rounded(value)) == json.dumps(written)  # type: ignore[arg-type]


def test_the_tree_has_every_value_at_its_place() -> None:
    model = Model()
    model.update(
        [
            Told("heading", "timonel.40", 1.0, {"navigation.headingTrue": 1.0}),
            Told("log", "timonel.42", 1.0, {"navigation.log": 1000, "navigation.trip.log": 10}),
            Told("pilot", "timonel", 1.0, {"notifications.timonel.x7": {"state": "alarm"}}),
        ],
        1.0,
    )
    whole = tree(VESSEL, model.entries, EPOCH)
    assert (whole["version"], whole["self"]) == ("1.7.0", f"vessels.{UUID}")
    own = whole["vessels"][UUID]
    assert (own["uuid"], own["name"]) == (UUID, "Alba")
    assert own["navigation"]["headingTrue"] == {
        "value": 1.0,
        "$source": "timonel.40",
        "timestamp": "2023-11-14T22:13:21.000Z",
        "meta": {"units": "rad", "description": "Where the bow points, true"},
    }
    assert (own["navigation"]["log"]["value"], own["navigation"]["trip"]["log"]["value"]) == (1000, 10)
    assert own["notifications"]["timonel"]["x7"]["value"] == {"state": "alarm"}
    assert {"40", "42"} < whole["sources"]["timonel"].keys()


def test_a_vessel_with_an_mmsi_has_no_uuid() -> None:
    own = Vessel("urn:mrn:imo:mmsi:224123456", "Alba").base
    assert own == {"mmsi": "224123456", "name": "Alba"}
