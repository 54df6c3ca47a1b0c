"""A gateway with a token, as one that others reach; its bus is silent."""

import re
from pathlib import Path

from playwright.sync_api import Browser, expect

from tests.browser.demo import serves, wait_until
from tests.browser.station import Console
from tests.program import Program, free_port

TOKEN = "correct-horse-battery-staple"
PAGES = {"boat": ".helm", "rover": ".cockpit"}
TOML = """[vehicle]
kind = "{kind}"
[bus]
url = "loop://{bus}"
{stations}
[web]
listen = "127.0.0.1:{port}"
token = "{token}"
{more}
"""
NAMES = {1: "Bridge", 2: "Cockpit", 3: "Flybridge"}
SIGNED_OUT = ("401", "WebSocket")
"""What a browser says of a gateway that does not know it yet."""


class Guarded:
    """It asks for a token, and shows digits in its log."""

    def __init__(self, directory: Path, vehicle: str, more: str = "") -> None:
        self.vehicle = vehicle
        self.port = free_port()
        self.url = f"http://127.0.0.1:{self.port}/"
        stations = "".join(
            f'[[station]]\nid = {number}\nname = "{name}"\nurl = "pty://{directory}/{number}"\n'
            for number, name in NAMES.items()
        )
        path = directory / f"{vehicle}.toml"
        path.write_text(
            TOML.format(kind=vehicle, bus=self.port, stations=stations, port=self.port, token=TOKEN, more=more)
        )
        self.program = Program(directory, "run", str(path))

    def start(self) -> None:
        self.program.start()
        wait_until(lambda: serves(self.program, self.url), "the console is served", 30.0)

    def stop(self) -> None:
        self.program.kill()

    def digits(self) -> str:
        """Those that the log told last."""

        def told() -> list[str]:
            return re.findall(r"the digits are (\d{6})", self.program.log_path.read_text())

        before = getattr(self, "_told", 0)
        wait_until(lambda: len(told()) > before, "digits")
        self._told = len(told())
        return told()[-1]


class Visitor(Console):
    """A window that the gateway does not know."""

    def __init__(self, browser: Browser, gateway: Guarded, *, size: str = "plotter", language: str = "en") -> None:
        super().__init__(browser, gateway.url, size=size, language=language)
        self._gateway = gateway

    def open(self) -> "Visitor":
        self.page.goto(self.url)
        expect(self.page.locator(".sign-in")).to_be_visible(timeout=20_000)
        return self

    def _note(self, text: str, kind: str) -> None:
        if not any(words in text for words in SIGNED_OUT):
            super()._note(text, kind)

    def sign_in(self) -> "Visitor":
        self.page.get_by_label("token", exact=False).fill(TOKEN)
        self.page.keyboard.press("Enter")
        expect(self.page.locator(PAGES[self._gateway.vehicle])).to_be_visible(timeout=20_000)
        return self

    def ask_to_be(self, station: str) -> None:
        """The digits are asked for."""
        self.page.locator(".top-bar .station").click()
        self.page.get_by_role("button", name=re.compile(rf"^\d · {station}")).click()
        expect(self.page.locator("#pairing-code")).to_be_visible()

    def tell(self, digits: str) -> None:
        self.page.locator("#pairing-code").fill(digits)
        self.page.keyboard.press("Enter")

    def pair(self, station: str) -> "Visitor":
        """As the person at the gateway's own terminal does it."""
        self.ask_to_be(station)
        self.tell(self._gateway.digits())
        self.is_now(station)
        return self

    def is_now(self, station: str) -> None:
        expect(self.page.locator(".top-bar .station")).to_contain_text(station)

    def takes_command(self) -> None:
        """If it has not got it from before: a window that is gone leaves its station in command."""
        bar = self.page.locator(".command-bar")
        expect(bar.locator("[data-verb=TAKECMD]").or_(bar.locator("[data-verb=RELCMD]"))).to_be_visible()
        if bar.get_attribute("data-command") != "ours":
            self.settle()
            self.press("TAKECMD")
        expect(bar).to_have_attribute("data-command", "ours")
