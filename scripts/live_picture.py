"""The picture of the live page for the documents; `scripts/pictures.py` makes it with the others."""

from __future__ import annotations

from playwright.sync_api import Page, sync_playwright
from screenshot import ARGUMENTS, DESKTOP, browser_path

from humanoid_rail import HumanoidRailError, Robot, load_scene
from humanoid_rail.live.server import serving

SECOND = 1000.0
"""In the milliseconds of a browser."""


def live_page(robot: Robot) -> bytes:
    """Return the live page with a round of picks, planned and certified."""
    path = browser_path()
    if path is None:
        raise HumanoidRailError("no browser: install chromium")
    with serving(robot, load_scene("scenes/picks.yaml")) as live, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=ARGUMENTS)
        page = browser.new_page(viewport={"width": DESKTOP[0], "height": DESKTOP[1]})
        page.goto(live.url)
        page.get_by_text("certified").first.wait_for(timeout=60.0 * SECOND)
        _close_notes(page)
        page.wait_for_timeout(3.0 * SECOND)
        picture: bytes = page.screenshot()
        browser.close()
        return picture


def _close_notes(page: Page) -> None:
    """Close viser's notes on a browser that draws in software."""
    for note in page.locator(".mantine-Notification-closeButton").all():
        note.click()
