"""How the helm looks, sounds and feels under the finger; the gateway is played, to show what we want to see."""

import base64
import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.browser.demo import busy
from tests.browser.gateway_words import CLOCK, PlayedGateway, Topics, alert, boat
from tests.browser.pictures import brightest
from tests.browser.static import serve
from tests.browser.station import SIZES, Console

AXE = Path(__file__).parents[2] / "node_modules" / "axe-core" / "axe.min.js"
KEY = 72  # px
CAP_HEIGHT = 0.714  # of the font's size: Noto Sans
PANES = ("compass", "trend", "track")
DIALOGS = (".chip", ".lamp-button", ".bar-key:not(.station)", ".bar-key.station")
PLACES = """parts => parts.map((part) => {
  const {x, y, width, height} = document.querySelector(part).getBoundingClientRect();
  return [part, x, y, width, height];
})"""
WHITE = base64.b64decode("iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4//8/AAX+Av4N70a4AAAAAElFTkSuQmCC")
ALARM = {
    "pilot": {"mode": "ALARM", "setpoint": None, "reference": "true", "pending": False},
    "alerts": [alert("alarm")],
}


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """The page's own files, with the policy of the gateway."""
    with serve() as url:
        yield url


Played = Callable[..., tuple[Console, PlayedGateway]]


@pytest.fixture
def played(browser: Browser, address: str) -> Iterator[Played]:
    """A console in front of a played gateway, with the topics that are given."""
    consoles: list[Console] = []

    def play(station: int | None = 2, *, topics: Topics | None = None, **how: Any) -> tuple[Console, PlayedGateway]:
        console = Console(browser, address, **how)
        consoles.append(console)
        gateway = PlayedGateway(console.page, boat() | (topics or {}), station)
        return console.open(), gateway

    yield play
    for console in consoles:
        console.context.close()
        assert not console.faults, console.faults


def box(page: Page, selector: str) -> dict[str, float]:
    found = page.locator(selector).bounding_box()
    assert found is not None
    return dict(found)


# Under the finger ---------------------------------------------------------------------------------------------------


def test_keys_are_as_large_as_a_wet_thumb_and_everything_is_on_the_screen(played: Played) -> None:
    console, gateway = played()
    page = console.page
    for width, height in SIZES.values():
        page.set_viewport_size({"width": width, "height": height})
        for key in page.locator(".key.turn, .standby").all():
            place = key.bounding_box()
            assert place is not None
            assert place["width"] >= KEY
            assert place["height"] >= KEY
            assert place["x"] >= 0
            assert place["x"] + place["width"] <= width
            assert place["y"] + place["height"] <= height
        assert box(page, ".standby")["width"] >= width - 26
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert page.evaluate("document.documentElement.scrollHeight") <= height
        for mode in ("STANDBY", "HEADING_HOLD", "ALARM"):
            gateway.change(pilot={"mode": mode, "setpoint": None, "reference": "true", "pending": False})
            word = page.locator(".mode .word")
            expect(word).to_have_text("AUTO" if mode == "HEADING_HOLD" else mode)
            font = float(word.evaluate("node => parseFloat(getComputedStyle(node).fontSize)"))
            assert font * CAP_HEIGHT >= 0.04 * height, "read at three metres"
            assert word.evaluate("node => node.scrollWidth <= node.parentElement.clientWidth")


def test_nothing_moves_when_values_change(played: Played) -> None:
    console, gateway = played()
    page = console.page
    fresh = {name: gateway.topics[name] for name in ("heading", "rudder", "sog", "stw", "depth", "rate_of_turn", "cog")}
    gone = {name: dict.fromkeys(("value", "at")) | {"quality": "absent", "reference": "true"} for name in fresh}
    parts = [".big.heading", ".big.setpoint", ".panel.rudder", ".compass", ".turns", ".auto", ".standby"]
    parts += [".command-bar", ".chip", ".clock", ".tile[data-key=sog] .unit", ".corner.left .unit"]
    for width, height in SIZES.values():
        page.set_viewport_size({"width": width, "height": height})
        gateway.change(**fresh, pilot=boat()["pilot"], alerts=[])
        places = page.evaluate(PLACES, parts)
        for number in range(8):
            value = {"value": (number - 4) * 0.03, "at": CLOCK, "quality": "fresh"}
            gateway.change(rate_of_turn=value, rudder=value, sog=value | {"value": 3.0 * number})
            assert page.evaluate(PLACES, parts) == places
        gateway.change(**gone, **ALARM)
        expect(page.locator(".big.heading .value")).to_have_text("–––.–")
        assert page.evaluate(PLACES, parts) == places


def test_standby_is_one_touch_away_on_every_pane_and_under_every_dialog(played: Played) -> None:
    console, gateway = played()
    page = console.page
    place = box(page, ".standby")
    for pane in PANES:
        page.locator(f".tab[data-pane={pane}]").click()
        assert box(page, ".standby") == place
        page.locator(".standby").click()
    for opener in DIALOGS:
        page.locator(opener).click()
        expect(page.locator("dialog[open]")).to_be_visible()
        page.locator(".standby").click()
    expect(page.locator("dialog[open]")).to_have_count(0)
    assert gateway.orders() == ["DISENGAGE"] * 7


def test_the_second_half_of_a_double_tap_turns_nothing(played: Played) -> None:
    console, gateway = played()
    console.settle()
    ten = console.page.locator("[data-verb=STBDTEN]")
    ten.dblclick()
    assert gateway.orders() == ["STBDTEN"]
    console.page.wait_for_timeout(320)
    ten.click()
    assert gateway.orders() == ["STBDTEN", "STBDTEN"]


def test_a_key_that_has_just_come_to_us_waits_until_it_can_be_meant(played: Played) -> None:
    console, gateway = played()
    command = gateway.topics["command"]
    gateway.change(command=command | {"commander": 1, "commander_name": "Bridge"})
    expect(console.page.locator(".lock")).to_be_visible()
    gateway.change(command=command)
    expect(console.page.locator(".lock")).to_be_hidden()
    console.page.locator("[data-verb=STBDTEN]").click()
    console.page.locator("[data-verb=RELCMD]").click()
    console.page.locator(".standby").click()
    assert gateway.orders() == ["DISENGAGE"]
    console.settle()
    console.page.locator("[data-verb=STBDTEN]").click()
    assert gateway.orders() == ["DISENGAGE", "STBDTEN"]


# What became of it --------------------------------------------------------------------------------------------------


OUTCOMES: list[tuple[list[tuple[str, str]], str]] = [
    ([("sent", ""), ("confirmed", "")], "+1° confirmed"),
    ([("refused", "not in command")], "+1° refused: not in command"),
    ([("sent", ""), ("unconfirmed", "the pilot has not confirmed")], "+1° not confirmed: the pilot has not"),
    ([("sent", "")], "+1° sent"),
    ([("sent", "")], "+1° not confirmed"),
    ([], "+1° …"),
    ([], "+1° not confirmed"),
]


def test_an_order_shows_what_became_of_it(played: Played) -> None:
    console, gateway = played()
    console.settle()
    for answers, words in OUTCOMES:
        gateway.answer(*answers)
        console.press("STBDONE")
        expect(console.page.locator(".order")).to_contain_text(words, timeout=3500)
        console.page.wait_for_timeout(320)


def test_after_a_gap_the_page_asks_for_everything_anew(played: Played) -> None:
    console, gateway = played()
    gateway.change(since=40, heading={"value": 1.0, "at": CLOCK, "quality": "fresh", "reference": "true"})
    expect(console.page.locator(".big.heading .value")).to_have_text("057.3")
    assert [said["type"] for said in gateway.heard] == ["refresh"]


def test_a_gateway_that_falls_silent_is_no_longer_believed(played: Played) -> None:
    console, gateway = played()
    expect(console.page.locator(".big.heading .value")).to_have_text("044.8")
    gateway.fall_silent()
    expect(console.page.locator(".command-bar .name")).to_have_text("No connection to the gateway", timeout=4000)
    for value in console.page.locator(".big .value, .tile .value, .rudder .value").all_text_contents():
        assert set(value) <= set("–.")
    for key in console.page.locator(".key.turn, .standby").all():
        expect(key).to_be_disabled()


def test_a_stale_value_is_dashes_and_says_how_old_it_is(played: Played) -> None:
    console, gateway = played()
    gateway.change(stw={"value": 3.0, "at": CLOCK - 12, "quality": "stale"})
    tile = console.page.locator(".tile[data-key=stw]")
    expect(tile.locator(".value")).to_have_text("––.–")
    expect(tile.locator(".more")).to_have_text(re.compile(r"1\ds"))


# Alerts -------------------------------------------------------------------------------------------------------------


def sounds(page: Page, action: Callable[[], None], during: float) -> int:
    page.evaluate("window.heard = 0; document.addEventListener('timonel-sound', () => window.heard++)")
    action()
    page.wait_for_timeout(int(during * 1000))
    return int(page.evaluate("window.heard"))


def test_an_alarm_flashes_and_sounds_until_somebody_acknowledges_it(played: Played) -> None:
    console, gateway = played()
    page = console.page
    page.locator(".panel.mode").click()  # browsers are silent before a first touch
    assert sounds(page, lambda: gateway.change(**ALARM), 2.5) >= 2
    chip = page.locator(".chip")
    expect(chip).to_contain_text("Backbone silent")
    assert chip.evaluate("node => getComputedStyle(node).animationName") == "flash"
    chip.click()
    page.get_by_role("button", name="Acknowledge").click()
    assert gateway.heard[-1]["type"] == "acknowledge"
    gateway.change(alerts=[alert("alarm", acknowledged=True)])
    assert sounds(page, lambda: None, 1.5) == 0
    expect(chip).to_contain_text("Backbone silent")
    assert chip.evaluate("node => getComputedStyle(node).animationName") == "none"


def test_a_silenced_alarm_sounds_again_when_its_silence_is_over(played: Played) -> None:
    console, gateway = played()
    page = console.page
    page.locator(".panel.mode").click()
    quiet = [alert("alarm", silenced_until=CLOCK + 2.0)]
    assert sounds(page, lambda: gateway.change(clock=CLOCK, alerts=quiet), 1.2) == 0
    assert sounds(page, lambda: gateway.change(clock=CLOCK + 2.5), 1.2) >= 1


def test_a_warning_sounds_when_it_arises_and_when_it_is_announced_again(played: Played) -> None:
    console, gateway = played()
    page = console.page
    page.locator(".panel.mode").click()
    assert sounds(page, lambda: gateway.change(alerts=[alert("warning")]), 1.2) > 0
    assert sounds(page, lambda: gateway.change(alerts=[alert("warning")]), 1.2) == 0
    assert sounds(page, lambda: gateway.change(alerts=[alert("warning", announced=1)]), 1.2) > 0


def test_an_alert_of_another_device_is_shown_in_its_own_words_and_acknowledged(played: Played) -> None:
    console, gateway = played()
    theirs = alert("alarm") | {"id": 401, "name": "Pilot off course", "text": "Raymarine"}
    gateway.change(alerts=[theirs])
    chip = console.page.locator(".chip")
    expect(chip).to_contain_text("Pilot off course")
    chip.click()
    expect(console.page.locator(".alert .text")).to_have_text("Raymarine")
    console.page.get_by_role("button", name="Acknowledge").click()
    assert (gateway.heard[-1]["type"], gateway.heard[-1]["alert"]) == ("acknowledge", 401)


def test_a_caution_is_silent_and_does_not_flash(played: Played) -> None:
    console, gateway = played()
    console.page.locator(".panel.mode").click()
    assert sounds(console.page, lambda: gateway.change(alerts=[alert("caution", acknowledged=True)]), 1.2) == 0
    chip = console.page.locator(".chip")
    expect(chip).to_contain_text("Backbone silent")
    assert chip.evaluate("node => getComputedStyle(node).animationName") == "none"


def test_a_transfer_of_command_is_heard(played: Played) -> None:
    console, gateway = played()
    console.page.locator(".panel.mode").click()
    passed = gateway.topics["command"] | {"commander": 1, "commander_name": "Bridge"}
    assert sounds(console.page, lambda: gateway.change(command=passed), 0.5) == 1


def test_who_asks_for_less_motion_gets_a_steady_alarm(played: Played) -> None:
    console, _ = played(topics=ALARM)
    console.page.emulate_media(reduced_motion="reduce")
    chip = console.page.locator(".chip")
    assert chip.evaluate("node => getComputedStyle(node).animationName") == "none"
    assert "inset" in str(chip.evaluate("node => getComputedStyle(node).boxShadow"))


# For everybody ------------------------------------------------------------------------------------------------------


def violations(page: Page, part: str, *, only_colours: bool = False) -> list[str]:
    """What axe-core finds in a part of the page, in its own words; by day with a contrast of at least 7:1."""
    day = page.evaluate("document.documentElement.dataset.obcTheme") in ("bright", "day")
    contrast = "color-contrast-enhanced" if day else "color-contrast"
    options: Topics = {"rules": {contrast: {"enabled": True}}}
    if only_colours:
        options = {"runOnly": [contrast]}
    found = page.evaluate("([part, options]) => axe.run(part, options)", [part, options])["violations"]
    return [f"{one['id']}: {node['target']} {node['failureSummary']}" for one in found for node in one["nodes"]]


def test_axe_finds_nothing_and_the_contrast_by_day_is_seven(played: Played) -> None:
    asked = boat()["command"] | {"queue": [{"station": 1, "name": "Bridge"}], "deadline": CLOCK + 8}
    console, gateway = played(topics={"command": asked})
    page = console.page
    page.evaluate(AXE.read_text())
    assert violations(page, "html") == []
    for pane in PANES[1:]:
        page.locator(f".tab[data-pane={pane}]").click()
        assert violations(page, f".{pane}") == []
    gateway.change(**ALARM)
    for opener in DIALOGS:
        page.locator(opener).click()
        assert violations(page, "dialog[open]") == []
        page.keyboard.press("Escape")
    page.set_viewport_size({"width": 320, "height": 568})
    assert violations(page, ".helm") == []


def test_every_palette_has_its_contrast(played: Played) -> None:
    asked = boat()["command"] | {"queue": [{"station": 1, "name": "Bridge"}], "deadline": CLOCK + 8}
    locked = asked | {"commander": 1, "queue": [], "deadline": None}
    console, gateway = played()
    page = console.page
    page.evaluate(AXE.read_text())
    for palette in ("bright", "dusk", "night"):
        page.evaluate("name => { document.documentElement.dataset.obcTheme = name }", palette)
        gateway.change(command=asked, pilot=boat()["pilot"], alerts=[])
        assert violations(page, ".helm", only_colours=True) == []
        gateway.change(command=locked, **ALARM)
        assert violations(page, ".helm", only_colours=True) == []


def test_the_words_change_with_the_language(played: Played) -> None:
    console, _ = played(1, language="pl")
    expect(console.page.locator("[data-verb=TAKECMD]")).to_have_text("Przejmij")
    console.page.locator(".bar-key:not(.station)").click()
    console.page.get_by_role("button", name="Español").click()
    expect(console.page.locator("[data-verb=TAKECMD]")).to_have_text("Tomar")
    assert console.page.locator("html").get_attribute("lang") == "es"


def test_what_the_gateway_says_is_said_in_the_language_of_the_page(played: Played) -> None:
    transferred = {"at": CLOCK, "text": "command passes from nobody to station 2", "kind": "command", "times": 1}
    console, _ = played(1, language="es", topics=ALARM | {"events": [transferred]})
    expect(console.page.locator(".badge .line")).to_contain_text("el mando pasa de nadie a puesto 2")
    console.page.locator(".chip").click()
    expect(console.page.locator(".alert .text")).to_have_text("no llega nada del bus desde hace 3 s")


def test_a_map_of_the_owner_s_own_lies_under_the_track_and_does_not_dazzle_at_night(
    browser: Browser, address: str
) -> None:
    console = Console(browser, address, palette="night")
    console.page.route("**/api/v1/about", lambda route: route.fulfill(json={"tiles": 14}))
    console.page.route("**/tiles/**", lambda route: route.fulfill(body=WHITE, content_type="image/png"))
    PlayedGateway(console.page, boat())
    with console:
        console.page.locator(".tab[data-pane=track]").click()
        expect(console.page.locator(".leaflet-tile-loaded").first).to_be_visible()
        asked = [url for url in console.requests if "/tiles/" in url]
        assert all(re.search(r"/tiles/14/\d+/\d+\.png$", url) for url in asked)
        console.page.wait_for_timeout(300)
        luminance, blue = brightest(console.page)
        assert (luminance <= 0.10, blue <= 0.02) == (True, True), (luminance, blue)


def test_at_night_nothing_dazzles(played: Played) -> None:
    console, _ = played(palette="night", size="bridge", topics={"alerts": [alert("warning")]})
    console.page.wait_for_timeout(500)
    luminance, blue = brightest(console.page)
    assert luminance <= 0.10
    assert blue <= 0.02


# What it takes ------------------------------------------------------------------------------------------------------


def first_load(browser: Browser, address: str) -> tuple[float, float]:
    """What is sent, bytes, and when something is first seen, ms, on a computer four times as slow as this one."""
    console = Console(browser, address)
    PlayedGateway(console.page, boat())
    session = console.context.new_cdp_session(console.page)
    weights: list[float] = []
    session.on("Network.loadingFinished", lambda event: weights.append(event["encodedDataLength"]))
    session.send("Network.enable")
    session.send("Emulation.setCPUThrottlingRate", {"rate": 4})
    console.open()
    expect(console.page.locator(".uplot")).to_be_attached(timeout=15_000)
    expect(console.page.locator(".map.leaflet-container")).to_be_attached(timeout=15_000)
    paint = console.page.evaluate("performance.getEntriesByName('first-contentful-paint')[0].startTime")
    console.context.close()
    return sum(weights), float(paint)


def test_the_first_load_is_light_and_paints_within_a_second_on_a_slow_computer(browser: Browser, address: str) -> None:
    loads = [first_load(browser, address) for _ in range(2)]
    assert max(weight for weight, _ in loads) <= 250_000
    assert min(paint for _, paint in loads) <= 1000 * busy()


def test_it_can_be_installed_and_opens_while_the_gateway_restarts(browser: Browser, address: str) -> None:
    context = browser.new_context()
    page = context.new_page()
    manifest = json.loads(page.goto(f"{address}manifest.webmanifest").text())  # type: ignore[union-attr]
    assert {"name", "start_url", "display", "icons"} <= manifest.keys()
    for picture in manifest["icons"]:
        assert page.goto(address + picture["src"]).ok  # type: ignore[union-attr]
    page.goto(address)
    page.evaluate("navigator.serviceWorker.ready.then(() => 0)")
    page.reload()
    page.wait_for_timeout(500)
    context.set_offline(True)
    page.reload()
    expect(page.locator(".waiting")).to_be_visible()
    kept = page.evaluate(
        "caches.open('timonel-shell').then(cache => cache.keys()).then(all => all.map(one => one.url))"
    )
    assert any(url.endswith("helm.css") for url in kept)
    assert not any("/api/" in url for url in kept)
    context.close()
