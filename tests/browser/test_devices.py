"""The devices of the bus in the console: under its links."""

from playwright.sync_api import expect

from tests.browser.gateway_words import device
from tests.browser.test_helm_looks import Played, address, played

__all__ = ["address", "played"]  # fixtures


def test_the_links_show_who_is_on_the_bus(played: Played) -> None:
    console, gateway = played()
    page = console.page
    page.locator(".lamp-button").click()
    rows = page.locator(".device")
    expect(rows).to_have_count(3)
    expect(rows.nth(0)).to_contain_text("timonel (this gateway)")
    expect(rows.nth(1)).to_contain_text("204")
    expect(rows.nth(1)).to_contain_text("Raymarine EV-1 Course Computer")
    expect(rows.nth(1)).to_contain_text("Autopilot · 2.21 · 0451234")
    expect(rows.nth(2)).to_contain_text("no address")
    gateway.change(devices=[device(7, "Garmin", "<img src=x onerror=alert(1)>", "Display")])
    expect(rows).to_have_count(1)
    expect(rows.first).to_contain_text("<img src=x onerror=alert(1)>")
    gateway.change(devices=[])
    expect(rows).to_have_text("No device has introduced itself")
