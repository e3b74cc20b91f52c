"""The picture of the live page for the documents; `scripts/pictures.py` makes it with the others."""

from __future__ import annotations

from playwright.sync_api import Page
from screenshot import window

from humanoid_rail import HumanoidRailError, Robot, load_robot_of_scene, load_scene
from humanoid_rail.live.server import Live, serving

SECOND = 1000.0
"""In the milliseconds of a browser."""
BEFORE = 0.05
"""The picture is taken so long before a hand arrives, s."""
NEAR = 0.03
"""The robot is there when no joint is farther away than this, m and rad."""


def live_page(robot: Robot) -> bytes:
    """Return the live page with a round of picks, planned and certified."""
    scene = load_scene("scenes/picks.yaml")
    with serving(load_robot_of_scene(scene), scene) as live, window() as page:
        page.goto(live.url)
        page.get_by_text("certified").first.wait_for(timeout=60.0 * SECOND)
        _close_notes(page)
        page.get_by_text("Joints").click()
        page.mouse.move(1.0, 1.0)
        _wait_for_moment(live, page)
        picture: bytes = page.screenshot()
        return picture


def _wait_for_moment(live: Live, page: Page) -> None:
    """Wait until the robot has its hand at the first target, nearly; until then the page has drawn everything."""
    plan = live.session.plan
    if plan is None or plan.motion is None:
        raise HumanoidRailError("the round of picks is not planned")
    wanted = plan.motion.configuration(plan.motion.arrivals[0] - BEFORE)
    page.wait_for_timeout(6.0 * SECOND)
    while abs(live.session.tick(0.0).q - wanted).max() > NEAR:
        page.wait_for_timeout(0.02 * SECOND)


def _close_notes(page: Page) -> None:
    """Close viser's notes on a browser that draws in software."""
    for note in page.locator(".mantine-Notification-closeButton").all():
        note.click()
