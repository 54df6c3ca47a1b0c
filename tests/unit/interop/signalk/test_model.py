"""What changed, and what is no more."""

from timonel.interop.signalk.model import Model
from timonel.interop.signalk.told import Told

HEADING = Told("heading", "timonel.40", 1.0, {"navigation.headingTrue": 1.0})
NEWER = Told("heading", "timonel.40", 2.0, {"navigation.headingTrue": 1.0})
STATE = Told("pilot", "timonel", None, {"steering.autopilot.state": "standby"})


def test_what_was_told_before_is_not_new() -> None:
    model = Model()
    assert model.update([HEADING], 1.0) == [HEADING]
    assert model.update([HEADING], 1.1) == []
    assert model.sequence == 1


def test_a_value_that_is_told_again_is_new_though_it_is_the_same() -> None:
    model = Model()
    model.update([HEADING], 1.0)
    assert model.update([NEWER], 2.0) == [NEWER]
    assert model.entries["navigation.headingTrue"].changed == 2


def test_a_state_is_new_only_when_it_is_another_and_then_has_the_time_of_now() -> None:
    model = Model()
    (told,) = model.update([STATE], 1.0)
    assert told.heard == 1.0
    assert model.update([STATE], 2.0) == []
    assert model.entries["steering.autopilot.state"].heard == 1.0


def test_what_aged_out_is_null_once() -> None:
    model = Model()
    model.update([HEADING], 1.0)
    (gone,) = model.update([], 4.0)
    assert gone == Told("heading", "timonel.40", 4.0, {"navigation.headingTrue": None})
    assert model.update([], 5.0) == []
    assert model.entries["navigation.headingTrue"].value is None


def test_a_path_that_its_source_no_longer_tells_is_null_in_all_that_follows() -> None:
    model = Model()
    model.update([Told("depth", "timonel.43", 1.0, {"below": 20.0, "belowKeel": 18.5})], 1.0)
    for heard in (2.0, 3.0):
        (told,) = model.update([Told("depth", "timonel.43", heard, {"below": 20.0})], heard)
        assert told.values == {"below": 20.0, "belowKeel": None}


def test_everything_is_what_is_known_with_what_is_gone() -> None:
    model = Model()
    model.update([HEADING, STATE], 1.0)
    model.update([STATE], 4.0)
    told = {told.source: told for told in model.everything()}
    assert told["timonel.40"].values == {"navigation.headingTrue": None}
    assert told["timonel"].heard == 1.0
