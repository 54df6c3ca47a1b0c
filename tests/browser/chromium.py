"""Debian's Chromium, as the browser tests want it: no window, no request to anybody but the page's own host."""

from playwright.sync_api import Browser, Playwright

CHROMIUM = "/usr/bin/chromium"
FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--autoplay-policy=no-user-gesture-required",
]


def launch(playwright: Playwright) -> Browser:
    """A new browser with nothing remembered."""
    return playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
