"""Draws the console's icons in the sizes that browsers install, from `icons/timonel.svg`."""

from pathlib import Path

from playwright.sync_api import sync_playwright

from tests.browser.chromium import launch

ICONS = Path(__file__).parents[1] / "src" / "timonel" / "web" / "static" / "icons"
SIZES = (192, 512)


def main() -> None:
    """Write the PNG files."""
    with sync_playwright() as playwright:
        browser = launch(playwright)
        for size in SIZES:
            page = browser.new_page(viewport={"width": size, "height": size})
            page.set_content((ICONS / "timonel.svg").read_text())
            page.add_style_tag(content="body { margin: 0 } svg { display: block; width: 100vw }")
            page.screenshot(path=ICONS / f"timonel-{size}.png", omit_background=True)
        browser.close()


if __name__ == "__main__":
    main()
