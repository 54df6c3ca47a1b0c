"""Who drives a rover from a browser, as the tests play it, with a gamepad that is not there."""

import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Self

from playwright.sync_api import Browser, Page, Route, expect
from websockets.sync.client import connect
from websockets.typing import Origin

from tests.browser.demo import Demo
from tests.browser.station import Console

GAMEPAD = """(() => {
  const pads = [null, null, null, null];
  window.testPad = {
    plug() { pads[0] = {index: 0, id: "Test pad (Vendor: 0000)", mapping: "standard", connected: true, timestamp: 0,
      axes: [0, 0, 0, 0], buttons: Array.from({length: 17}, () => ({pressed: false, touched: false, value: 0}))}; },
    unplug() { pads[0] = null; window.dispatchEvent(new Event("gamepaddisconnected")); },
    set(x, y, held) { pads[0].axes[0] = x; pads[0].axes[1] = y; pads[0].buttons[5].pressed = held; },
    press(button, down) { pads[0].buttons[button].pressed = down; },
  };
  navigator.getGamepads = () => pads;
  const sockets = window.testSockets = [];
  const Plain = window.WebSocket;
  window.WebSocket = class extends Plain { constructor(...given) { super(...given); sockets.push(this); } };
})()"""


class Rover:
    """The simulated rover behind a demo, as the gateway tells it to whoever looks, page or no page."""

    def __init__(self, demo: Demo) -> None:
        self.topics: dict[str, Any] = {}
        self._url = demo.url.rstrip("/")
        self._told = threading.Event()
        self._over = threading.Event()
        self._hearing = threading.Thread(target=self._hear)

    def __enter__(self) -> Self:
        self._hearing.start()
        assert self._told.wait(10.0)
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._hearing.join()

    def _hear(self) -> None:
        address = f"{self._url.replace('http', 'ws', 1)}/api/v1/socket"
        with connect(address, origin=Origin(self._url)) as socket:
            while not self._over.is_set():
                self.topics |= json.loads(socket.recv()).get("topics", {})
                self._told.set()

    @property
    def permitted(self) -> bool:
        return bool(self.topics["drive"]["permitted"])

    @property
    def told(self) -> tuple[float, float]:
        """The set points of the left and the right wheels, -1..1."""
        return self.topics["drive"]["left"], self.topics["drive"]["right"]

    @property
    def fastest(self) -> float:
        """The fastest wheel as its encoder says it, rpm."""
        return max(abs(wheel["rpm"]) for wheel in self.topics["wheels"])

    @property
    def commander(self) -> int:
        return int(self.topics["command"]["commander"])


class Cockpit(Console):
    """A window with a cockpit in it, and a driver before it."""

    def __init__(
        self, browser: Browser, url: str, *, size: str = "plotter", palette: str = "day", language: str = "en"
    ) -> None:
        super().__init__(browser, url, size=size, palette=palette, language=language)
        self.context.add_init_script(GAMEPAD)

    def open(self) -> Self:
        self.page.goto(self.url)
        expect(self.page.locator(".cockpit")).to_be_visible(timeout=20_000)
        expect(self.page.locator(".wheel .rpm").first).not_to_have_text("----", timeout=10_000)
        return self

    def take(self, station: str) -> Self:
        """Be a station, and in command."""
        self.be(station)
        bar = self.page.locator(".command-bar")
        expect(bar.locator("[data-verb=TAKECMD]").or_(bar.locator("[data-verb=RELCMD]"))).to_be_visible()
        kept = bar.get_attribute("data-command") == "ours"  # from before, for the 2 s that a driver may be away
        if not kept:
            self.press("TAKECMD")
        try:
            self.has(station)
        except AssertionError:
            if not kept:
                raise
            self.press("TAKECMD")  # they were over before this window had said anything
            self.has(station)
        return self

    def slide(self, share: float = 1.0) -> None:
        """The thumb along its track, and let go there."""
        thumb, track = self._box(".slide .thumb"), self._box(".slide")
        x, y = thumb["x"] + thumb["width"] / 2, thumb["y"] + thumb["height"] / 2
        mouse = self.page.mouse
        mouse.move(x, y)
        mouse.down()
        mouse.move(x + share * (track["width"] - thumb["width"]), y, steps=8)
        mouse.up()

    def enable(self) -> None:
        self.slide()
        expect(self.page.locator(".permission .state strong")).to_have_text("Enabled")

    def _box(self, what: str) -> Any:
        box = self.page.locator(what).bounding_box()
        assert box is not None
        return box

    def lay_thumb(self) -> tuple[float, float]:
        """Put a thumb on the stick and keep it there."""
        box = self._box(".stick .surface")
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        return x, y

    def ready(self) -> None:
        """Wait until who takes hold drives."""
        expect(self.page.locator(".stick")).to_have_attribute("data-state", "ready")

    def push(self) -> None:
        """Drive forward with a thumb on the stick."""
        self.ready()
        x, y = self.lay_thumb()
        self.page.mouse.move(x, y - 200, steps=5)

    def plug(self) -> None:
        self.page.evaluate("testPad.plug()")
        self.page.wait_for_timeout(80)  # it is looked at 30 times a second

    def hold(self, x: float = 0.0, forward: float = 1.0) -> None:
        """The shoulder button, and then the stick."""
        if self.state() != "held":
            self.ready()
        self.page.evaluate("testPad.set(0, 0, true)")
        self.page.wait_for_timeout(80)
        self.page.evaluate(f"testPad.set({x}, {-forward}, true)")

    def palette(self, name: str) -> None:
        """Choose a palette, as its key in the settings does."""
        self.page.locator(f"dialog [data-palette={name}]").dispatch_event("click")

    def pages(self) -> Iterator[None]:
        """Turn every page of the cockpit; a large screen has but one."""
        yield None
        for tab in self.page.locator(".pages .tab:visible").all():
            tab.click()
            yield None

    def stop_shown(self) -> bool:
        """Whether a touch where STOP is meets STOP, whatever else is open."""
        return bool(self.page.evaluate(STOP_HIT))

    def state(self) -> str:
        """Of the stick: locked, ready or held."""
        return self.page.locator(".stick").get_attribute("data-state") or ""


STOP_HIT = """(() => {
  const boxes = [...document.querySelectorAll(".stop")].map((one) => one.getBoundingClientRect());
  const hit = (x, y) => document.elementFromPoint(x, y)?.closest(".stop:not(:disabled)");
  const shown = boxes.filter((box) => box.width > 0);
  return shown.length > 0 && shown.every(({left, top, width, height}) =>
    [0.05, 0.5, 0.95].every((share) => hit(left + share * width, top + height / 2)));
})()"""


def modules(page: Page, static: Path) -> None:
    """Serve the console's files to a page that has no gateway."""

    def serve(route: Route) -> None:
        name = route.request.url.removeprefix("http://cockpit.test/")
        if name:
            route.fulfill(path=static / name)
        else:
            route.fulfill(body="<!doctype html>", content_type="text/html")

    page.route("http://cockpit.test/**", serve)
    page.goto("http://cockpit.test/")
