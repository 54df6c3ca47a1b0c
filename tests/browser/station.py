"""A person at a console, as the tests play it."""

import re
from types import TracebackType
from typing import Self

from playwright.sync_api import Browser, BrowserContext, Page, expect

SIZES = {"telephone": (320, 568), "plotter": (1024, 600), "bridge": (1920, 1080)}
PALETTES = ("day", "dusk", "night")
EXPECTED = ("WebSocket connection", "ERR_CONNECTION", "blocked by Playwright")
"""What a browser says when a gateway is restarted, and to tests that want no service worker."""


class Console:
    """A window of its own with the helm in it, and everything that went wrong there."""

    def __init__(
        self, browser: Browser, url: str, *, size: str = "plotter", palette: str = "day", language: str = "en"
    ) -> None:
        width, height = SIZES[size]
        self.context: BrowserContext = browser.new_context(
            viewport={"width": width, "height": height}, locale=language, service_workers="block"
        )
        self.context.add_init_script(
            f"localStorage.getItem('timonel.palette') || localStorage.setItem('timonel.palette', '{palette}')"
        )
        self.page: Page = self.context.new_page()
        self.faults: list[str] = []
        self.requests: list[str] = []
        self.page.on("console", lambda message: self._note(message.text, message.type))
        self.page.on("pageerror", lambda fault: self.faults.append(str(fault)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.url = url

    def _note(self, text: str, kind: str) -> None:
        if kind in ("error", "warning") and not any(words in text for words in EXPECTED):
            self.faults.append(text)

    def open(self) -> Self:
        self.page.goto(self.url)
        expect(self.page.locator(".helm")).to_be_visible(timeout=20_000)
        return self

    def be(self, station: str) -> Self:
        """Choose a station."""
        self.page.locator(".top-bar .station").click()
        self.page.get_by_role("button", name=re.compile(rf"^\d · {station}$")).click()
        expect(self.page.locator(".top-bar .station")).to_contain_text(station)
        return self

    def press(self, verb: str) -> None:
        """The key that says this word of the `$PARP` family, as soon as the page believes that it is meant."""
        self.page.locator(f"[data-verb={verb}]").click()

    def settle(self) -> None:
        """Wait until a key that is new may be pressed."""
        self.page.wait_for_timeout(800)

    def has(self, text: str) -> None:
        """Who has command is written there, or will be soon."""
        expect(self.page.locator(".command-bar .name")).to_have_text(re.compile(text, re.IGNORECASE), timeout=3000)

    def degrees(self, which: str) -> float:
        """`heading` or `setpoint` as it is written there."""
        return float(self.page.locator(f".big.{which} .value").inner_text())

    def __enter__(self) -> Self:
        return self.open()

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.context.close()
        if kind is None:
            assert not self.faults, self.faults
