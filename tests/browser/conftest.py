"""One browser for all tests, each with windows of its own, and a vehicle to look at."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, sync_playwright

from tests.browser.chromium import launch
from tests.browser.demo import Demo


@pytest.fixture(scope="module")  # a loop that runs on would be in the way of the tests behind
def browser() -> Iterator[Browser]:
    """Debian's Chromium."""
    with sync_playwright() as playwright:
        browser = launch(playwright)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def boat(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    """`timonel demo boat`, four times as fast, so that a turn does not take half a minute."""
    demo = Demo(tmp_path_factory.mktemp("boat"), "boat", "--speed", "4")
    demo.start()
    yield demo
    demo.stop()
