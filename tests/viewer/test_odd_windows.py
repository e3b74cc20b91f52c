"""Pages in low and narrow windows, and in browsers that draw nothing in 3D."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import ROOT
from pages import needs_browser
from playwright.sync_api import sync_playwright
from screenshot import browser_path, opened

from humanoid_rail import Auto, Robot, Scene, Trajectory, load_scene, plan
from humanoid_rail.viewer.playback import motions_html, playback_html
from humanoid_rail.viewer.robot_page import robot_html

SIZES = [(320, 480), (568, 320), (280, 653), (844, 390)]


@pytest.fixture(scope="module")
def failed(robot: Robot) -> tuple[Scene, Trajectory]:
    """A plan that says much."""
    scene = load_scene(ROOT / "scenes" / "unsolvable" / "target_in_collision-4.yaml")
    return scene, plan(robot, scene, Auto(max_edge_checks=100))


@needs_browser
@pytest.mark.parametrize("size", SIZES)
def test_the_picture_keeps_its_share_and_the_timeline_its_place(
    size: tuple[int, int], robot: Robot, failed: tuple[Scene, Trajectory], tmp_path: Path
) -> None:
    page_file = tmp_path / "page.html"
    page_file.write_text(motions_html(robot, [("one", *failed), ("two", *failed)]), encoding="utf-8")
    with opened(page_file, size) as (page, troubles):
        stage, timeline = (page.locator(part).bounding_box() for part in ("#stage", "#timeline"))
        assert stage["height"] > 0.33 * size[1]
        assert timeline["y"] + timeline["height"] == pytest.approx(size[1], abs=1)
        for button in page.locator("#timeline button").all():
            assert button.bounding_box()["y"] + 30 < size[1]
        assert page.evaluate("document.getElementById('caption').scrollTop = 1e4, true")
        last = page.locator("#caption p").last.bounding_box()
        assert last["y"] + last["height"] <= stage["y"] + 1, "the end of the caption can be scrolled to"
        assert not troubles


@needs_browser
def test_a_browser_without_webgl_says_so(robot: Robot, failed: tuple[Scene, Trajectory], tmp_path: Path) -> None:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=browser_path(), args=["--no-sandbox", "--disable-gpu", "--disable-3d-apis"]
        )
        page = browser.new_page()
        for text in (playback_html(robot, *failed), robot_html(robot)):
            (tmp_path / "page.html").write_text(text, encoding="utf-8")
            page.goto((tmp_path / "page.html").as_uri())
            assert page.get_by_text("no WebGL").is_visible()
        browser.close()
