"""The helm at work: `timonel demo` behind it, browsers and a scripted station before it."""

import os
import re
import select
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect

from tests.browser.demo import Demo, busy, wait_until
from tests.browser.pictures import brightest
from tests.browser.station import Console
from timonel.nmea0183 import parp
from timonel.nmea0183.parp import Verb

RECONNECTION = 2.0  # s
NIGHT = 0.10  # luminance, 1 is a white screen by day
PICTURED = (("night", "bridge"), ("night", "telephone"), ("dusk", "bridge"), ("day", "plotter"))
PICTURES = Path(__file__).parents[2] / "docs" / "images"
TIMEOUT = 10.0  # s that a commander has to answer


class ScriptedStation:
    """A program on a station's pseudo-terminal."""

    def __init__(self, demo: Demo, name: str) -> None:
        self.fd = os.open(demo.directory / name.lower(), os.O_RDWR | os.O_NOCTTY)
        self._heard = b""

    def say(self, verb: Verb, station: int) -> None:
        os.write(self.fd, parp.command(verb, station))

    def hears(self, beginning: str, within: float = 5.0) -> str:
        """The first line from now on that begins so."""
        begin = time.monotonic()
        while time.monotonic() - begin < within:
            if select.select([self.fd], [], [], 0.1)[0]:
                self._heard += os.read(self.fd, 65536)
            *lines, self._heard = self._heard.split(b"\r\n")
            for line in lines:
                if line.decode("ascii", "replace").startswith(beginning):
                    return line.decode("ascii")
        raise AssertionError(f"not within {within:g} s: {beginning}")

    def close(self) -> None:
        os.close(self.fd)


@pytest.fixture
def bridge(browser: Browser, boat: Demo) -> Iterator[Console]:
    """A console that is the bridge and in command, the pilot at rest."""
    with Console(browser, boat.url) as console:
        console.be("Bridge")
        if "you have command" not in console.page.locator(".command-bar").inner_text():
            console.settle()
            console.press("TAKECMD")
        console.has("bridge")
        console.settle()
        console.press("DISENGAGE")
        expect(console.page.locator(".mode .word")).to_have_text("STANDBY")
        yield console


def test_from_taking_command_the_boat_is_brought_to_a_new_course(browser: Browser, boat: Demo) -> None:
    with Console(browser, boat.url) as console:
        expect(console.page.locator(".lock")).to_contain_text("Looking only")
        console.be("Bridge")
        console.press("TAKECMD")
        console.has("bridge")
        console.settle()
        console.press("ENGAGE")
        expect(console.page.locator(".mode .word")).to_have_text("AUTO")
        engaged = console.degrees("setpoint")
        console.press("STBDTEN")
        expect(console.page.locator(".order")).to_contain_text("+10° confirmed", timeout=3000)
        wanted = (engaged + 10) % 360
        assert console.degrees("setpoint") == pytest.approx(wanted, abs=0.05)
        wait_until(lambda: _apart(console.degrees("heading"), wanted) < 1.5, "it settles on the new course", 30)
        console.page.wait_for_timeout(1000)
        assert _apart(console.degrees("heading"), wanted) < 3.0


def test_the_helm_is_pictured_and_does_not_dazzle_at_night(bridge: Console, browser: Browser, boat: Demo) -> None:
    """With TIMONEL_PICTURES set they become those of the documentation."""
    bridge.press("ENGAGE")
    wanted = PICTURED if "TIMONEL_PICTURES" in os.environ else PICTURED[:1]
    for palette, size in wanted:
        with Console(browser, boat.url, palette=palette, size=size) as console:
            console.be("Bridge")
            console.settle()
            console.press("STBDTEN")
            expect(console.page.locator(".order")).to_contain_text("+10° confirmed", timeout=4000)
            console.page.wait_for_timeout(600)
            if palette == "night":
                assert brightest(console.page)[0] <= NIGHT
            if "TIMONEL_PICTURES" in os.environ:
                console.page.screenshot(path=PICTURES / f"helm-{palette}-{size}.png")


def _apart(one: float, other: float) -> float:
    return abs((one - other + 180) % 360 - 180)


def test_a_request_that_nobody_answers_passes_command_after_ten_seconds_in_both_windows(
    bridge: Console, browser: Browser, boat: Demo
) -> None:
    with Console(browser, boat.url) as cockpit:
        cockpit.be("Cockpit")
        expect(cockpit.page.locator(".lock")).to_contain_text("Bridge has command")
        cockpit.press("REQCMD")
        began = time.monotonic()
        for console in (bridge, cockpit):
            expect(console.page.locator(".request .asks")).to_have_text("Cockpit asks for command")
            left = int(console.page.locator(".ring-of-seconds text").text_content() or 0)
            assert 10 - 2 * busy() <= left <= 10
        expect(cockpit.page.locator("[data-verb=REQCMD]")).to_be_disabled()
        expect(cockpit.page.locator(".command-bar .name")).to_have_text("Cockpit", timeout=15_000)
        assert TIMEOUT - 1 < time.monotonic() - began < TIMEOUT + 0.5 * busy()
        bridge.has("cockpit")
        expect(bridge.page.locator(".lock")).to_contain_text("Cockpit has command")
        expect(cockpit.page.locator(".request")).to_be_hidden()


def test_a_request_is_answered_with_one_touch(bridge: Console, browser: Browser, boat: Demo) -> None:
    with Console(browser, boat.url, size="telephone") as flybridge:
        flybridge.be("Flybridge")
        flybridge.press("REQCMD")
        expect(bridge.page.locator("[data-verb=DENYCMD]")).to_be_visible()
        bridge.settle()
        bridge.press("DENYCMD")
        expect(flybridge.page.locator(".order")).to_contain_text("refused: denied")
        flybridge.settle()
        flybridge.press("REQCMD")
        expect(bridge.page.locator("[data-verb=ACKCMD]")).to_be_visible()
        bridge.settle()
        bridge.press("ACKCMD")
        flybridge.has("flybridge")
        expect(flybridge.page.locator(".key.turn").first).to_be_enabled()


def test_command_passes_between_a_browser_and_a_station_on_a_wire(browser: Browser, boat: Demo) -> None:
    wire = ScriptedStation(boat, "Bridge")
    try:
        with Console(browser, boat.url) as cockpit:
            cockpit.be("Cockpit")
            wire.say(Verb.TAKECMD, 1)
            cockpit.has("bridge")
            cockpit.settle()
            cockpit.press("REQCMD")
            wire.hears("$PARP,CMDREQUEST,02")
            wire.say(Verb.ACKCMD, 1)
            wire.hears("$PARP,CMDTRANSFER,01,02")
            cockpit.has("cockpit")
            cockpit.settle()
            cockpit.press("ENGAGE")
            assert ",HEADING_HOLD," in wire.hears("$PARP,STATUS,HEADING_HOLD")
            wire.say(Verb.REQCMD, 1)
            expect(cockpit.page.locator(".request .asks")).to_have_text("Bridge asks for command")
            cockpit.settle()
            cockpit.press("ACKCMD")
            wire.hears("$PARP,CMDTRANSFER,02,01")
            wire.say(Verb.DISENGAGE, 1)
            expect(cockpit.page.locator(".mode .word")).to_have_text("STANDBY")
    finally:
        wire.close()


def test_a_console_that_is_not_in_command_steers_nothing(bridge: Console, browser: Browser, boat: Demo) -> None:
    with Console(browser, boat.url) as cockpit:
        cockpit.be("Cockpit")
        bridge.press("ENGAGE")
        expect(cockpit.page.locator(".mode .word")).to_have_text("AUTO")
        before = cockpit.degrees("setpoint")
        for key in ("ArrowRight", "Shift+ArrowRight", "Space"):
            cockpit.page.keyboard.press(key)
        for key in cockpit.page.locator(".key.turn, .auto, .standby").all():
            expect(key).to_be_disabled()
        cockpit.page.wait_for_timeout(700)
        assert cockpit.degrees("setpoint") == before
        expect(cockpit.page.locator(".mode .word")).to_have_text("AUTO")


def test_the_helm_is_worked_with_the_keyboard_alone(browser: Browser, boat: Demo) -> None:
    with Console(browser, boat.url) as console:
        keyboard, page = console.page.keyboard, console.page
        _tab_to(console, ".station")
        keyboard.press("Enter")
        page.locator("dialog[open]").wait_for()
        _tab_to(console, ".choice")
        keyboard.press("Enter")
        expect(page.locator(".top-bar .station")).to_contain_text("Bridge")
        if page.locator("[data-verb=TAKECMD]").count():
            _tab_to(console, ".command-key")
            keyboard.press("Enter")
        console.has("bridge")
        console.settle()
        _tab_to(console, ".auto")
        keyboard.press("Enter")
        expect(page.locator(".mode .word")).to_have_text("AUTO")
        before = console.degrees("setpoint")
        for key, change in (("ArrowRight", 1), ("Shift+ArrowRight", 11), ("ArrowLeft", 10), ("Shift+ArrowLeft", 0)):
            keyboard.press(key)
            _wait_for_setpoint(console, before + change)
            page.wait_for_timeout(310)
        keyboard.press("Space")
        expect(page.locator(".mode .word")).to_have_text("STANDBY")


def _wait_for_setpoint(console: Console, course: float) -> None:
    try:
        wait_until(lambda: _apart(console.degrees("setpoint"), course) < 0.2, f"set point {course:.1f}")
    except AssertionError as failed:
        focus = console.page.evaluate("document.activeElement.outerHTML")[:200]
        shown = console.page.locator("body").inner_text()
        raise AssertionError(f"{failed}\nfocus: {focus}\nshown: {shown}") from failed


def _tab_to(console: Console, selector: str) -> None:
    for _ in range(40):
        console.page.keyboard.press("Tab")
        if console.page.evaluate(f"document.activeElement.matches('{selector}')"):
            return
    raise AssertionError(f"no way to {selector} by Tab")


def test_a_page_is_back_two_seconds_after_its_gateway(browser: Browser, boat: Demo) -> None:
    with Console(browser, boat.url) as console:
        console.be("Cockpit")
        boat.stop()
        expect(console.page.locator(".command-bar .name")).to_have_text("No connection to the gateway", timeout=4000)
        expect(console.page.locator(".big.heading .value")).to_have_text("–––.–")
        console.page.wait_for_timeout(1800)  # until it tries once a second
        boat.start()
        began = time.monotonic()
        expect(console.page.locator(".big.heading .value")).to_have_text(re.compile(r"\d"), timeout=15_000)
        assert time.monotonic() - began < RECONNECTION * busy()
        expect(console.page.locator(".top-bar .station")).to_contain_text("Cockpit")
        console.faults.clear()  # that there was nobody is what this is about


def test_nothing_is_asked_of_another_host_and_no_policy_is_broken(browser: Browser, boat: Demo) -> None:
    with Console(browser, boat.url, size="bridge") as console:
        console.page.wait_for_timeout(1500)
        assert {url.split("/")[2] for url in console.requests if not url.startswith("data:")} == {
            boat.url.split("/")[2]
        }
        assert len(console.requests) > 20
