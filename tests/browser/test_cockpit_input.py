"""From hands to sticks: the cockpit's pure machines, played call by call in the browser that they are for."""

from collections.abc import Iterator
from math import hypot
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page

import timonel.web
from tests.browser.driver import modules

STATIC = Path(timonel.web.__file__).parent / "static"
PLAY = """async ([module, maker, given, calls]) => {
  const machine = (await import(`/cockpit/${module}.js`))[maker](...given);
  const word = (one) => one?.type === "stick" ? [one.x, one.y] : one?.type ?? one;
  const plain = (said) => Array.isArray(said) ? said.map(word) : said;
  const call = ([name, ...rest]) => machine[name] instanceof Function ? plain(machine[name](...rest)) : machine[name];
  return calls.map(call);
}"""
CALL = "async ([module, name, given]) => (await import(`/cockpit/${module}.js`))[name](...given)"

FREE = {"held": False, "x": 0, "y": 0}
REST = {"held": True, "x": 0, "y": 0}
AHEAD = {"held": True, "x": 0, "y": 1}
GONE = [[0, 0], "let_go"]
LOSSES = ("hidden", "blur", "socket", "stop")


@pytest.fixture(scope="module")
def page(browser: Browser) -> Iterator[Page]:
    page = browser.new_page()
    modules(page, STATIC)
    yield page
    page.close()


def deadman(page: Page, *calls: tuple[Any, ...]) -> Any:
    """What each call says; a stick is [x, y]."""
    return page.evaluate(PLAY, ["deadman", "createDeadman", [], calls])


def call(page: Page, module: str, name: str, *given: Any) -> Any:
    return page.evaluate(CALL, [module, name, given])


# Deadman ------------------------------------------------------------------------------------------------------


def test_a_stick_is_said_while_it_is_held_and_at_rest_once_when_it_is_let_go(page: Page) -> None:
    *_, held, pushed, tick, released, after = deadman(
        page, ("allow", True), ("receive", "pad", FREE), ("receive", "pad", REST), ("receive", "pad", AHEAD),
        ("tick",), ("receive", "pad", FREE), ("tick",),
    )  # fmt: skip
    assert (held, pushed, tick, released, after) == ([[0, 0]], [], [[0, 1]], GONE, [])


@pytest.mark.parametrize("loss", LOSSES)
def test_after_a_loss_nobody_drives_before_he_took_hold_anew(page: Page, loss: str) -> None:
    said = deadman(
        page, ("allow", True), ("receive", "keys", FREE), ("receive", "keys", REST), ("receive", "keys", AHEAD),
        ("lose", loss), ("receive", "keys", AHEAD), ("receive", "keys", REST), ("tick",), ("driver",), ("reason",),
        ("receive", "keys", FREE), ("receive", "keys", REST), ("driver",),
    )  # fmt: skip
    assert said[4:] == [GONE, [], [], [], None, loss, [], [[0, 0]], "keys"]


def test_after_a_loss_a_hand_that_held_nothing_may_take_hold(page: Page) -> None:
    said = deadman(
        page, ("allow", True), ("receive", "touch", FREE), ("lose", "blur"), ("receive", "touch", REST), ("driver",)
    )
    assert said[2:] == [[], [[0, 0]], "touch"]


def test_a_permission_is_no_start_for_a_hand_that_holds_already(page: Page) -> None:
    said = deadman(
        page, ("receive", "pad", FREE), ("receive", "pad", REST), ("allow", True), ("receive", "pad", REST),
        ("receive", "pad", AHEAD), ("tick",), ("driver",),
    )  # fmt: skip
    assert said[-4:] == [[], [], [], None]


def test_that_driving_is_not_allowed_any_more_lets_go(page: Page) -> None:
    said = deadman(
        page, ("allow", True), ("receive", "pad", FREE), ("receive", "pad", REST), ("allow", False),
        ("allow", True), ("receive", "pad", REST), ("driver",),
    )  # fmt: skip
    assert said[3:] == [GONE, [], [], None]


def test_a_stick_that_is_pushed_when_it_is_taken_drives_from_where_it_was_at_rest(page: Page) -> None:
    said = deadman(
        page, ("allow", True), ("receive", "pad", FREE), ("receive", "pad", AHEAD), ("driver",),
        ("receive", "pad", REST), ("receive", "pad", AHEAD), ("tick",),
    )  # fmt: skip
    assert said[2:] == [[], None, [[0, 0]], [], [[0, 1]]]


def test_who_holds_first_drives_and_another_does_not_take_over_when_he_lets_go(page: Page) -> None:
    said = deadman(
        page, ("allow", True), ("receive", "pad", FREE), ("receive", "keys", FREE), ("receive", "pad", REST),
        ("receive", "keys", REST), ("receive", "keys", AHEAD), ("tick",), ("receive", "pad", FREE),
        ("receive", "keys", REST), ("driver",),
    )  # fmt: skip
    assert said[3:] == [[[0, 0]], [], [], [[0, 0]], GONE, [], None]


def test_a_pad_that_is_unplugged_lets_go_and_has_to_be_seen_at_rest_when_it_comes_back(page: Page) -> None:
    said = deadman(
        page, ("allow", True), ("receive", "pad", FREE), ("receive", "pad", REST), ("forget", "pad", "unplugged"),
        ("receive", "pad", REST), ("driver",), ("receive", "pad", FREE), ("receive", "pad", REST), ("driver",),
    )  # fmt: skip
    assert said[3:] == [GONE, [], None, [], [[0, 0]], "pad"]


def test_a_pad_that_is_unplugged_takes_nothing_from_who_drives_by_touch(page: Page) -> None:
    said = deadman(
        page, ("allow", True), ("receive", "touch", REST), ("receive", "touch", FREE), ("receive", "pad", FREE),
        ("receive", "touch", REST), ("forget", "pad", "unplugged"), ("driver",),
    )  # fmt: skip
    assert said[-2:] == [[], "touch"]


def test_a_stick_is_touched_while_it_is_pushed_even_if_nobody_holds_the_button(page: Page) -> None:
    touched = deadman(
        page, ("touched",), ("receive", "pad", FREE | {"x": 0.2}), ("touched",), ("receive", "pad", REST), ("touched",),
        ("receive", "pad", FREE), ("touched",),
    )  # fmt: skip
    assert touched[::2] == [False, True, True, False]


# Shaping ------------------------------------------------------------------------------------------------------


def test_a_worn_stick_at_rest_is_at_rest_and_a_full_one_is_full(page: Page) -> None:
    assert call(page, "shaping", "shaped", 0.07, -0.07) == {"x": 0, "y": 0}
    assert call(page, "shaping", "shaped", 0, 1) == {"x": 0, "y": 1}
    assert call(page, "shaping", "shaped", -1.3, 0) == {"x": -1, "y": 0}


def test_a_stick_is_fine_around_the_middle_and_has_no_jump_at_the_edge_of_its_dead_zone(page: Page) -> None:
    values = [call(page, "shaping", "shaped", 0, share / 20)["y"] for share in range(21)]
    assert values == sorted(values)
    assert 0 < values[3] < 0.05
    assert values[10] < 0.3


def test_a_stick_in_the_corner_is_no_longer_than_one_along_its_axis(page: Page) -> None:
    stick = call(page, "shaping", "shaped", 1, 1)
    assert hypot(stick["x"], stick["y"]) == pytest.approx(1)


def test_what_is_no_number_is_at_rest(page: Page) -> None:
    assert page.evaluate("import('/cockpit/shaping.js').then(({shaped}) => shaped(NaN, 1))") == {"x": 0, "y": 0}


def test_a_key_rises_in_half_a_second_and_falls_at_once(page: Page) -> None:
    assert call(page, "shaping", "ramped", 0, 1, 0.1) == pytest.approx(0.2)
    assert call(page, "shaping", "ramped", 0.9, 1, 0.1) == 1
    assert call(page, "shaping", "ramped", 1, 0, 0.01) == 0
    assert call(page, "shaping", "ramped", 1, -1, 0.1) == pytest.approx(-0.2)


# Sliding and holding ------------------------------------------------------------------------------------------


def slide(page: Page, *calls: tuple[Any, ...]) -> Any:
    return page.evaluate(PLAY, ["confirming", "createSlide", [], calls])


def hold(page: Page, *calls: tuple[Any, ...]) -> Any:
    return page.evaluate(PLAY, ["confirming", "createHold", [], calls])


def test_a_thumb_slid_to_the_end_and_let_go_there_is_meant(page: Page) -> None:
    said = slide(page, ("press", 20, 54), ("move", 120, 200), ("share",), ("move", 225, 200), ("release",), ("share",))
    assert (said[0], said[2], said[4], said[5]) == (True, 0.5, True, 0)


def test_a_thumb_that_comes_back_or_is_torn_away_is_not_meant(page: Page) -> None:
    assert slide(page, ("press", 20, 54), ("move", 225, 200), ("move", 150, 200), ("release",))[-1] is False
    assert slide(page, ("press", 20, 54), ("move", 225, 200), ("cancel",), ("release",))[-1] is False


def test_a_touch_at_the_end_of_the_track_slides_nothing(page: Page) -> None:
    assert slide(page, ("press", 240, 54), ("move", 260, 200), ("share",), ("release",)) == [False, None, 0, False]


def test_a_key_means_it_once_when_it_was_held_long_enough(page: Page) -> None:
    assert hold(page, ("press", 1.0), ("done", 1.7), ("press", 1.7), ("done", 1.81), ("done", 3.0)) == [
        None, False, None, True, False,
    ]  # fmt: skip
    assert hold(page, ("press", 1.0), ("cancel",), ("press", 1.5), ("done", 2.0))[-1] is False


# Limits, attitude, way ----------------------------------------------------------------------------------------


def test_a_limit_steps_within_what_the_frame_allows(page: Page) -> None:
    assert [call(page, "limits", "next", "speed", *given) for given in ((None, -1), (1, -1), (20, 1), (7, 1))] == [
        19,
        1,
        20,
        8,
    ]
    assert [call(page, "limits", "next", "current", *given) for given in ((None, -1), (10, -1), (200, 1), (37, 1))] == [
        190,
        10,
        200,
        50,
    ]


def imu(ax: float, ay: float, az: float, at: float = 1.0, *, rate_x: float = 0.0) -> dict[str, Any]:
    return {
        "acceleration": {"x": ax, "y": ay, "z": az}, "rate": {"x": rate_x, "y": 0, "z": 0}, "at": at,
        "quality": "fresh",
    }  # fmt: skip


def test_the_ground_tells_roll_and_pitch(page: Page) -> None:
    level = call(page, "attitude", "attitude", None, imu(0, 0, 9.8))
    bow_up = call(page, "attitude", "attitude", None, imu(4.9, 0, 8.487))
    starboard_down = call(page, "attitude", "attitude", None, imu(0, 4.9, 8.487))
    assert (level["roll"], level["pitch"]) == (0, 0)
    assert (bow_up["roll"], bow_up["pitch"]) == pytest.approx((0, 0.5236), abs=1e-3)
    assert (starboard_down["roll"], starboard_down["pitch"]) == pytest.approx((0.5236, 0), abs=1e-3)


def test_turning_is_seen_at_once_and_a_jolt_is_not_an_attitude(page: Page) -> None:
    level = {"roll": 0, "pitch": 0, "at": 1.0}
    assert call(page, "attitude", "attitude", level, imu(0, 0, 9.8, 1.1, rate_x=1.0))["roll"] == pytest.approx(
        0.088, abs=0.01
    )
    assert call(page, "attitude", "attitude", level, imu(9.8, 0, 9.8, 1.05))["pitch"] < 0.06


def test_what_is_stale_or_falls_has_no_attitude(page: Page) -> None:
    assert call(page, "attitude", "attitude", None, imu(0, 0, 9.8) | {"quality": "stale"}) is None
    assert call(page, "attitude", "attitude", None, imu(0, 0, 0.1)) is None


def test_the_way_is_measured_in_metres_and_trembling_is_not_driving(page: Page) -> None:
    said = page.evaluate(
        PLAY,
        ["way", "createWay", [], [("add", 52.0, 21.0), ("add", 52.000002, 21.0), ("add", 52.00009, 21.0), ("length",)]],
    )
    assert said[-1] == pytest.approx(10.0, abs=0.1)
    assert said[2]["north"] == pytest.approx(10.0, abs=0.1)


def test_what_is_recorded_comes_back_in_order_and_nothing_is_made_up(page: Page) -> None:
    calls = [("take", time, [["a", time]] if time != 3 else []) for time in (1, 2, 3, 4, 5)]
    said = page.evaluate(PLAY, ["recorder", "createRecorder", [4], [*calls, ("since", ["a", "b"], 2)]])
    assert said[-1] == [[2, 3, 4, 5], [2, None, 4, 5], [None, None, None, None]]
