"""Signing in, and becoming a station: a gateway with a token, and windows that it does not know."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, expect

from tests.browser.driver import STOP_HIT
from tests.browser.guarded import Guarded, Visitor
from tests.browser.station import SIZES

STANDBY_HIT = """() => {
  const {left, top, width, height} = document.querySelector(".standby").getBoundingClientRect();
  return [0.1, 0.5, 0.9].every((share) =>
    document.elementFromPoint(left + share * width, top + height / 2)?.closest(".standby") != null);
}"""


@pytest.fixture(scope="module")
def boat(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Guarded]:
    gateway = Guarded(tmp_path_factory.mktemp("guarded"), "boat")
    gateway.start()
    yield gateway
    gateway.stop()


@pytest.fixture(scope="module")
def rover(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Guarded]:
    gateway = Guarded(tmp_path_factory.mktemp("guarded"), "rover")
    gateway.start()
    yield gateway
    gateway.stop()


def test_nothing_is_shown_before_the_token_is_told(browser: Browser, boat: Guarded) -> None:
    with Visitor(browser, boat) as visitor:
        assert visitor.page.locator(".helm").count() == 0
        visitor.page.locator("#token").fill("a wrong one of length")
        visitor.page.keyboard.press("Enter")
        expect(visitor.page.locator(".wrong")).to_have_text("wrong token")
        visitor.faults = [fault for fault in visitor.faults if "403" not in fault]
        visitor.sign_in()
        expect(visitor.page.locator(".lock")).to_contain_text("Looking only")
        visitor.page.reload()
        expect(visitor.page.locator(".helm")).to_be_visible(timeout=20_000)
        assert "token" not in visitor.page.url


def test_a_window_becomes_a_station_by_the_digits_of_the_log_and_steers_as_it(browser: Browser, boat: Guarded) -> None:
    with Visitor(browser, boat) as visitor:
        visitor.sign_in().pair("Bridge").takes_command()
        visitor.page.reload()
        expect(visitor.page.locator(".helm")).to_be_visible(timeout=20_000)
        visitor.is_now("Bridge")


def test_the_one_in_command_sees_the_digits_and_tells_them(browser: Browser, boat: Guarded) -> None:
    with Visitor(browser, boat) as bridge, Visitor(browser, boat, size="telephone") as tablet:
        bridge.sign_in().pair("Bridge").takes_command()
        tablet.sign_in().ask_to_be("Cockpit")
        asking = bridge.page.locator(".pairing")
        expect(asking).to_contain_text("Cockpit")
        digits = asking.locator(".value").inner_text().replace(" ", "")
        tablet.tell("000000" if digits != "000000" else "111111")
        expect(tablet.page.locator(".code .wrong")).to_contain_text("not the digits")
        tablet.tell(digits)
        tablet.is_now("Cockpit")
        expect(asking).to_have_count(0)
        tablet.faults = [fault for fault in tablet.faults if "403" not in fault]


def test_the_one_in_command_refuses_and_the_digits_are_worth_nothing(browser: Browser, boat: Guarded) -> None:
    with Visitor(browser, boat) as bridge, Visitor(browser, boat) as stranger:
        bridge.sign_in().pair("Bridge").takes_command()
        stranger.sign_in().ask_to_be("Flybridge")
        digits = bridge.page.locator(".pairing .value").inner_text().replace(" ", "")
        bridge.page.get_by_role("button", name="Refuse").click()
        expect(bridge.page.locator(".pairing")).to_have_count(0)
        stranger.tell(digits)
        expect(stranger.page.locator(".code .wrong")).to_contain_text("too late")
        stranger.faults = [fault for fault in stranger.faults if "403" not in fault]


ASK = """async () => {
  for (const station of [2, 3, 4]) {
    await fetch("/api/v1/pairings", {method: "POST", headers: {"Content-Type": "application/json"},
      body: JSON.stringify({station, name: "a tablet with a name of almost forty"})});
  }
}"""


def each_size_with_a_crowd(window: Visitor) -> Iterator[str]:
    """While three others want to be stations."""
    window.page.evaluate(ASK)
    expect(window.page.locator(".pairing")).to_have_count(3)
    for size, (width, height) in SIZES.items():
        window.page.set_viewport_size({"width": width, "height": height})
        yield size


def test_standby_is_met_by_a_touch_while_others_want_to_be_stations(browser: Browser, boat: Guarded) -> None:
    with Visitor(browser, boat) as bridge:
        bridge.sign_in().pair("Bridge").takes_command()
        for size in each_size_with_a_crowd(bridge):
            assert bridge.page.evaluate(STANDBY_HIT), size


def test_stop_is_met_by_a_touch_while_others_want_to_be_stations_of_a_rover(browser: Browser, rover: Guarded) -> None:
    with Visitor(browser, rover) as driver:
        driver.sign_in().ask_to_be("Bridge")
        for width, height in SIZES.values():
            driver.page.set_viewport_size({"width": width, "height": height})
            assert driver.page.evaluate(STOP_HIT), "over the box that asks for the digits"
        driver.tell(rover.digits())
        driver.is_now("Bridge")
        driver.takes_command()
        for size in each_size_with_a_crowd(driver):
            assert driver.page.evaluate(STOP_HIT), size
