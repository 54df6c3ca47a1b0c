"""The cockpit at work: `timonel demo rover` behind it, and everything that makes a rover stop."""

import os
import re
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect

from tests.browser.demo import Demo, busy, wait_until
from tests.browser.driver import Cockpit, Rover
from tests.browser.pictures import brightest
from tests.browser.relay import Relay
from tests.browser.station import PALETTES, SIZES

IMAGES = Path(__file__).parents[2] / "docs" / "images"
AXE = Path(__file__).parents[2] / "node_modules" / "axe-core" / "axe.min.js"
STICK_OLD = 0.2  # s after which a stick does not count any more
SILENT = 0.5  # s after which a permission is withdrawn
STANDS = 1.0  # s that a rover takes to stand from full speed, and more
SLACK = 0.25  # s until we hear of it, on an idle computer
TURNING = 2.0  # rpm
HIDDEN = """Object.defineProperty(document, 'hidden', {value: true, configurable: true});
  document.dispatchEvent(new Event('visibilitychange'))"""
COUNTED = """() => {
  const said = window.testSaid = [], plain = WebSocket.prototype.send;
  WebSocket.prototype.send = function (text) {
    if (text.includes('"stick"')) said.push(performance.now());
    return plain.call(this, text);
  };
}"""
AXE_RUN = "part => axe.run(part, {resultTypes: ['violations']})"
BOXES = """() => [...document.querySelectorAll('.panel, .wheel, .unit, .label, .stop, .key')]
  .filter((one) => one.offsetParent).map((one) => {
    const {x, y, width, height} = one.getBoundingClientRect();
    return [one.className, x, y, width, height].map((each) => each?.toFixed?.(0) ?? each).join(' ');
  })"""
NO_NEWS = """() => {
  window.WebSocket = class { readyState = 0; close() {} };
  testSockets.forEach((one) => { one.onmessage = null; });
}"""
SMALL = """() => [...document.querySelectorAll('.cockpit button, .cockpit select')].filter((one) => one.offsetParent)
  .filter((one) => {
    const {x, right, width, height} = one.getBoundingClientRect();
    return Math.min(width, height) < 40 || x < 0 || right > innerWidth;
  }).map((one) => one.outerHTML)"""


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    demo = Demo(tmp_path_factory.mktemp("rover"), "rover")
    demo.start()
    yield demo
    demo.stop()


@pytest.fixture(scope="module")
def rover(demo: Demo) -> Iterator[Rover]:
    with Rover(demo) as rover:
        yield rover


@pytest.fixture
def operator(browser: Browser, demo: Demo, rover: Rover) -> Iterator[Cockpit]:
    """In command, with the drives enabled and a gamepad in his hands."""
    with Cockpit(browser, demo.url) as cockpit:
        cockpit.take("Operator")
        cockpit.enable()
        cockpit.plug()
        yield cockpit
        cockpit.page.keyboard.press("Escape")
        wait_until(lambda: not rover.permitted, "it is stopped")
    wait_until(lambda: rover.fastest < TURNING, "it stands")


def turns(rover: Rover, take_hold: Callable[[], None], let_go: Callable[[], None]) -> None:
    """Somebody takes hold, until the wheels turn fast; again if the page was held up for so long that it let go."""
    for _ in range(5):
        take_hold()
        with suppress(AssertionError):
            wait_until(lambda: rover.fastest > 60, "the wheels turn", 3.0)
            return
        let_go()
    raise AssertionError("the wheels do not turn")


def drive(cockpit: Cockpit, rover: Rover) -> None:
    """Forward by gamepad; enabled anew if another page that was loaded held this one up."""

    def take_hold() -> None:
        if not rover.permitted:
            cockpit.enable()
        cockpit.hold(forward=1.0)

    turns(rover, take_hold, lambda: cockpit.page.evaluate("testPad.set(0, 0, false)"))


def rests(rover: Rover, within: float) -> None:
    """Its wheels are told to rest within so many seconds from now, and then they stand."""
    assert wait_until(lambda: rover.told == (0, 0), "its wheels are told to rest") < within + SLACK * busy()
    assert wait_until(lambda: rover.fastest < TURNING, "it stands") < STANDS * busy()


def is_lost(rover: Rover) -> None:
    """The ladder: within 200 ms its wheels are told to rest, within 500 ms its permission ends."""
    began = time.monotonic()
    rested = ended = None
    while rested is None or ended is None:
        passed = time.monotonic() - began
        rested = rested or (passed if rover.told == (0, 0) else None)
        ended = ended or (None if rover.permitted else passed)
        time.sleep(0.005)
        assert passed < 5.0, "it drives on"
    assert (rested < STICK_OLD + SLACK * busy(), ended < SILENT + SLACK * busy()) == (True, True), (rested, ended)
    wait_until(lambda: rover.fastest < TURNING, "it stands", STANDS * busy())


# Pictures, before anything goes wrong -------------------------------------------------------------------------


def test_pictures_for_the_manual(operator: Cockpit, rover: Rover, browser: Browser, demo: Demo, tmp_path: Path) -> None:
    """With TIMONEL_PICTURES set they become those of the documentation."""
    wanted = "TIMONEL_PICTURES" in os.environ
    images = IMAGES if wanted else tmp_path
    operator.page.set_viewport_size({"width": 1920, "height": 1080})
    operator.hold(x=0.12, forward=0.95)
    operator.page.wait_for_timeout(8_000 if wanted else 500)
    pictures = [images / f"cockpit-{palette}.png" for palette in PALETTES]
    for palette, picture in zip(PALETTES, pictures, strict=True):
        operator.palette(palette)
        operator.page.wait_for_timeout(700 if wanted else 0)
        operator.page.screenshot(path=picture)
    operator.page.evaluate("testPad.set(0, 0, false)")
    with Cockpit(browser, demo.url, size="telephone") as telephone:
        telephone.be("Operator")
        if not rover.permitted:
            telephone.enable()
        telephone.push()
        telephone.page.wait_for_timeout(1500 if wanted else 0)
        pictures.append(images / "cockpit-telephone.png")
        telephone.page.screenshot(path=pictures[-1])
        telephone.page.mouse.up()
    assert all(picture.stat().st_size > 10_000 for picture in pictures)


# Driving ------------------------------------------------------------------------------------------------------


def test_the_rover_is_enabled_by_a_slide_and_driven_with_a_gamepad(operator: Cockpit, rover: Rover) -> None:
    assert rover.commander == 1
    assert rover.permitted
    drive(operator, rover)
    wheel = operator.page.locator("[data-side=left][data-place=front]")
    expect(wheel.locator(".rpm")).to_have_text(re.compile(r"\d\d"))
    expect(wheel.locator(".set .value")).to_have_text(re.compile("100"))
    assert operator.state() == "held"
    operator.hold(x=1.0, forward=0.0)
    wait_until(lambda: rover.told[1] < -0.9, "it turns to the right")
    operator.page.evaluate("testPad.set(1, 0, false)")
    rests(rover, 0.1)
    assert rover.permitted


def test_a_gamepad_without_its_shoulder_button_drives_nothing(operator: Cockpit, rover: Rover) -> None:
    operator.page.evaluate("testPad.set(0, -1, false)")
    operator.page.wait_for_timeout(400)
    assert rover.told == (0, 0)
    assert operator.state() == "ready"


def test_a_thumb_on_the_stick_drives_until_it_is_lifted(operator: Cockpit, rover: Rover) -> None:
    turns(rover, operator.push, operator.page.mouse.up)
    operator.page.mouse.up()
    rests(rover, 0.1)


def test_keys_drive_while_they_are_held(operator: Cockpit, rover: Rover) -> None:
    keyboard = operator.page.keyboard
    for forward, turn in (("KeyW", "KeyA"), ("ArrowUp", "ArrowLeft")):
        turns(rover, partial(keyboard.down, forward), partial(keyboard.up, forward))
        keyboard.down(turn)
        wait_until(lambda: rover.told[0] < 0.1 < rover.told[1], "it turns to the left")
        keyboard.up(forward)
        keyboard.up(turn)
        rests(rover, 0.1)


def test_sticks_are_said_thirty_times_a_second_while_one_is_held_and_never_more_than_fifty(
    operator: Cockpit, rover: Rover
) -> None:
    drive(operator, rover)
    operator.page.evaluate(COUNTED)
    operator.page.wait_for_timeout(2000)
    said = operator.page.evaluate("window.testSaid")
    assert 20 / busy() <= (len(said) - 1) / (said[-1] - said[0]) * 1000 <= 50


# What stops it ------------------------------------------------------------------------------------------------


def test_a_gamepad_that_is_unplugged_stops_the_wheels(operator: Cockpit, rover: Rover) -> None:
    drive(operator, rover)
    operator.page.evaluate("testPad.unplug()")
    rests(rover, STICK_OLD)
    expect(operator.page.locator(".stick .word")).to_contain_text("gamepad unplugged")
    operator.plug()
    operator.page.evaluate("testPad.set(0, -1, true)")
    operator.page.wait_for_timeout(400)
    assert rover.told == (0, 0)


@pytest.mark.parametrize(
    ("loss", "words"),
    [(HIDDEN, "the page was hidden"), ("window.dispatchEvent(new Event('blur'))", "another window")],
    ids=["the tab is hidden", "another window has the focus"],
)
def test_a_page_that_is_not_looked_at_lets_go(operator: Cockpit, rover: Rover, loss: str, words: str) -> None:
    drive(operator, rover)
    operator.page.evaluate(loss)
    rests(rover, STICK_OLD)
    expect(operator.page.locator(".stick .word")).to_contain_text(words)


def test_behind_a_hidden_tab_the_permission_ends_and_command_is_free(operator: Cockpit, rover: Rover) -> None:
    operator.page.evaluate(HIDDEN)
    assert wait_until(lambda: not rover.permitted, "the permission ends") < SILENT + 0.1 + SLACK * busy()
    assert wait_until(lambda: rover.commander == 0, "command is free") < 1.5 + SLACK * busy()


@pytest.mark.parametrize(
    "end", ["testSockets.at(-1).close()", "window.stop(); location.href = 'about:blank'"], ids=["closed", "left"]
)
def test_a_socket_that_is_gone_stops_the_rover(operator: Cockpit, rover: Rover, end: str) -> None:
    drive(operator, rover)
    operator.page.evaluate(end)
    is_lost(rover)
    operator.faults.clear()


def test_a_window_that_is_closed_stops_the_rover(browser: Browser, demo: Demo, rover: Rover) -> None:
    cockpit = Cockpit(browser, demo.url).open().take("Operator")
    cockpit.enable()
    cockpit.plug()
    drive(cockpit, rover)
    cockpit.context.close()
    is_lost(rover)


def test_a_page_that_hangs_does_not_drive_on(operator: Cockpit, rover: Rover) -> None:
    drive(operator, rover)
    operator.page.evaluate("setTimeout(() => { const end = Date.now() + 2500; while (Date.now() < end); })")
    is_lost(rover)
    operator.page.wait_for_timeout(500)


def test_a_cable_that_is_pulled_stops_the_rover_within_the_ladder(browser: Browser, demo: Demo, rover: Rover) -> None:
    with Relay(demo.port) as relay, Cockpit(browser, f"http://127.0.0.1:{relay.port}/") as cockpit:
        cockpit.take("Operator")
        cockpit.enable()
        cockpit.plug()
        drive(cockpit, rover)
        relay.cut()
        is_lost(rover)
        expect(cockpit.page.locator(".stick .word")).to_contain_text("no connection")
        expect(cockpit.page.locator(".wheel .rpm").first).to_have_text(re.compile("[-–]{4}"), timeout=6000)
        cockpit.faults.clear()


@pytest.mark.parametrize("key", ["Escape", "Space"])
def test_stop_keys_stop_on_every_page(operator: Cockpit, rover: Rover, key: str) -> None:
    for page in ("rover", "way", "plots", "link"):
        operator.page.locator(f".pages [data-page={page}]").click()
        if not rover.permitted:
            operator.enable()
        operator.page.keyboard.press(key)
        assert wait_until(lambda: not rover.permitted, "it is stopped") < SLACK * busy()


@pytest.mark.parametrize("size", SIZES)
def test_stop_is_met_by_a_touch_on_every_page_and_over_every_dialog(
    browser: Browser, demo: Demo, rover: Rover, size: str
) -> None:
    with Cockpit(browser, demo.url, size=size) as cockpit:
        cockpit.take("Operator")
        for _ in cockpit.pages():
            assert cockpit.stop_shown()
        if cockpit.page.locator(".pages [data-page=drive]").is_visible():
            cockpit.page.locator(".pages [data-page=drive]").click()
        for opener in cockpit.page.locator(".top-bar [aria-haspopup=dialog]").all():
            cockpit.page.wait_for_timeout(50)
            cockpit.enable()
            opener.click()
            assert cockpit.stop_shown()
            cockpit.page.locator("dialog[open] .stop").click()
            wait_until(lambda: not rover.permitted, "it is stopped")
            cockpit.page.keyboard.press("Escape")
        assert cockpit.page.locator(".stop:disabled").count() == 0


def test_a_button_of_the_gamepad_stops(operator: Cockpit, rover: Rover) -> None:
    drive(operator, rover)
    operator.page.evaluate("testPad.press(1, true)")
    rests(rover, 0.1)
    assert not rover.permitted


def test_any_station_stops_who_drives(operator: Cockpit, rover: Rover, browser: Browser, demo: Demo) -> None:
    drive(operator, rover)
    with Cockpit(browser, demo.url, size="telephone") as other:
        other.be("Jetson")
        other.page.locator(".cockpit > .stop").click()
        rests(rover, 0.1)
        wait_until(lambda: not rover.permitted, "it is stopped", 1.0)


# Enabling -----------------------------------------------------------------------------------------------------


def test_half_a_slide_and_a_tap_enable_nothing(browser: Browser, demo: Demo, rover: Rover) -> None:
    with Cockpit(browser, demo.url) as cockpit:
        cockpit.take("Operator")
        cockpit.slide(0.6)
        box = cockpit.page.locator(".slide").bounding_box()
        assert box is not None
        cockpit.page.mouse.click(box["x"] + box["width"] - 20, box["y"] + 20)
        cockpit.page.locator(".slide").press("Enter")
        cockpit.page.wait_for_timeout(400)
        assert not rover.permitted


def test_nobody_enables_with_a_stick_that_is_pushed(browser: Browser, demo: Demo, rover: Rover) -> None:
    with Cockpit(browser, demo.url) as cockpit:
        cockpit.take("Operator")
        cockpit.plug()
        cockpit.page.evaluate("testPad.set(0, -1, false)")
        cockpit.page.wait_for_timeout(100)
        cockpit.slide()
        expect(cockpit.page.locator(".permission .reason")).to_have_text("Let go of the stick first")
        assert not rover.permitted


@pytest.mark.parametrize("how", ["E anywhere", "Enter on the slide"])
def test_the_drives_are_enabled_with_the_keyboard_alone(browser: Browser, demo: Demo, rover: Rover, how: str) -> None:
    with Cockpit(browser, demo.url) as cockpit:
        cockpit.take("Operator")
        key = "Enter" if how.startswith("Enter") else "KeyE"
        if key == "Enter":
            cockpit.page.locator(".slide").focus()
        cockpit.page.keyboard.down(key)
        wait_until(lambda: rover.permitted, "it is enabled", 3.0)
        cockpit.page.keyboard.up(key)
        cockpit.page.keyboard.press("Space")
        wait_until(lambda: not rover.permitted, "it is stopped", 1.0)


def test_who_is_not_in_command_neither_enables_nor_drives(
    operator: Cockpit, rover: Rover, browser: Browser, demo: Demo
) -> None:
    with Cockpit(browser, demo.url) as other:
        other.be("Jetson")
        other.plug()
        expect(other.page.locator(".slide")).not_to_have_attribute("data-state", "ready")
        other.page.evaluate("testPad.set(0, 0, true)")
        other.page.wait_for_timeout(100)
        other.page.evaluate("testPad.set(0, -1, true)")
        other.page.keyboard.down("KeyW")
        other.page.wait_for_timeout(400)
        other.page.keyboard.up("KeyW")
        assert (rover.commander, rover.told) == (1, (0, 0))


# Command ------------------------------------------------------------------------------------------------------


def test_command_that_is_asked_for_and_given_stops_the_rover_and_the_other_may_drive(
    operator: Cockpit, rover: Rover, browser: Browser, demo: Demo
) -> None:
    with Cockpit(browser, demo.url, size="telephone") as other:
        other.be("Jetson")
        drive(operator, rover)
        other.press("REQCMD")
        expect(operator.page.locator("[data-verb=ACKCMD]")).to_be_visible()
        operator.settle()
        operator.press("ACKCMD")
        wait_until(lambda: rover.commander == 2, "command passes")
        rests(rover, 0.1)
        assert not rover.permitted
        expect(operator.page.locator(".slide")).to_have_attribute("data-state", "locked")
        other.enable()
        turns(rover, other.push, other.page.mouse.up)
        other.page.mouse.up()
        rests(rover, 0.1)


def test_of_two_windows_of_a_station_the_one_that_is_pushed_drives(
    operator: Cockpit, rover: Rover, browser: Browser, demo: Demo
) -> None:
    with Cockpit(browser, demo.url) as second:
        second.be("Operator")
        if not rover.permitted:
            second.enable()
        turns(rover, second.push, second.page.mouse.up)
        second.page.mouse.up()
        rests(rover, 0.1)
        drive(operator, rover)
        operator.page.evaluate("testPad.set(0, 0, false)")
        rests(rover, 0.1)


# Limits, and what is shown ------------------------------------------------------------------------------------


def test_the_speed_limit_is_stepped_and_obeyed(operator: Cockpit, rover: Rover) -> None:
    stepper = operator.page.locator("[data-which=speed]")
    stepper.get_by_role("button", name="Slower").click(click_count=3, delay=20)
    expect(stepper.locator(".value")).to_have_text(re.compile("85"))
    assert rover.topics["limits"]["speed"] == 17
    drive(operator, rover)
    wait_until(lambda: rover.told == (0.85, 0.85), "it drives no faster")
    operator.page.evaluate("testPad.set(0, 0, false)")
    stepper.get_by_role("button", name="Faster").click(click_count=3, delay=20)
    expect(stepper.locator(".value")).to_have_text(re.compile("100"))


def test_the_page_of_the_link_tells_rates_ages_and_the_way_there_and_back(operator: Cockpit) -> None:
    operator.page.locator(".pages [data-page=link]").click()
    row = operator.page.locator(".quality tbody tr", has_text="WheelSpeedLeft")
    expect(row).to_have_text(re.compile(r"107WheelSpeedLeft\s*(19|20|21)\.\d\s*\d\.\d"), timeout=6000)
    expect(operator.page.locator(".figures .value").first).to_have_text(re.compile(r"\d"))
    operator.page.locator("[data-which=current]").get_by_role("button", name="Less current").click()
    expect(operator.page.locator("[data-which=current] .value")).to_have_text(re.compile("95"))


def test_any_signal_is_drawn_against_time(operator: Cockpit) -> None:
    operator.page.locator(".pages [data-page=plots]").click()
    operator.page.get_by_label("Line 1").select_option(label="Cell 3 · V")
    canvas = operator.page.locator(".plots canvas")
    expect(canvas).to_be_visible()
    operator.page.reload()
    operator.page.locator(".pages [data-page=plots]").click()
    expect(operator.page.get_by_label("Line 1")).to_have_value("cell3")


def test_what_is_stale_is_dashes_and_nothing_shifts(operator: Cockpit, rover: Rover) -> None:
    before = operator.page.evaluate(BOXES)
    drive(operator, rover)
    assert operator.page.evaluate(BOXES) == before
    operator.page.evaluate("testPad.set(0, 0, false)")
    operator.page.evaluate(NO_NEWS)
    expect(operator.page.locator(".wheel .rpm").first).to_have_text(re.compile("[-–]"), timeout=6000)


@pytest.mark.parametrize(("size", "palette"), [("telephone", "night"), ("plotter", "day"), ("bridge", "dusk")])
def test_axe_has_nothing_to_say(browser: Browser, demo: Demo, size: str, palette: str) -> None:
    with Cockpit(browser, demo.url, size=size, palette=palette) as cockpit:
        cockpit.take("Operator")
        cockpit.page.evaluate(AXE.read_text())
        for number, _ in enumerate(cockpit.pages()):
            part = ".pane[data-page={}]".format(cockpit.page.locator(".cockpit").get_attribute("data-page"))
            found = cockpit.page.evaluate(AXE_RUN, "html" if number == 0 else part)["violations"]
            assert [(one["id"], node["target"]) for one in found for node in one["nodes"]] == []


def test_at_night_nothing_dazzles(operator: Cockpit, rover: Rover) -> None:
    operator.palette("night")
    drive(operator, rover)
    for _ in operator.pages():
        operator.page.wait_for_timeout(300)
        luminance, blue = brightest(operator.page)
        assert luminance <= 0.10
        assert blue <= 0.02


@pytest.mark.parametrize("size", SIZES)
def test_everything_is_on_the_screen_and_large_enough_for_a_thumb(browser: Browser, demo: Demo, size: str) -> None:
    with Cockpit(browser, demo.url, size=size) as cockpit:
        cockpit.take("Operator")
        whole = "[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"
        for _ in cockpit.pages():
            assert cockpit.page.evaluate(SMALL) == []
            assert cockpit.page.evaluate(whole) == list(SIZES[size])
