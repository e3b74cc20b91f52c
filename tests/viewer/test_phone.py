"""The playback page on a phone."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import ROOT, plan
from pages import needs_browser
from screenshot import PHONE, opened

from humanoid_rail import Robot, Scene, load_robot_of_scene, load_scene, plan_case, retime
from humanoid_rail.viewer.playback import playback_html


@needs_browser
def test_on_a_phone_nothing_overlaps_and_a_touch_is_enough(tmp_path: Path) -> None:
    scene = load_scene(ROOT / "scenes" / "picks.yaml")
    robot = load_robot_of_scene(scene)
    trajectory = retime(plan(robot, scene), robot, scene)
    (tmp_path / "page.html").write_text(playback_html(robot, scene, trajectory), encoding="utf-8")
    with opened(tmp_path / "page.html", PHONE) as (page, troubles):
        boxes = [page.locator(part).bounding_box() for part in ("#caption", "#stage", "#plots", "#timeline")]
        below = 0.0
        for box in boxes:
            assert box["y"] == pytest.approx(below, abs=1)
            assert (box["x"], box["width"]) == (0, PHONE[0])
            below = box["y"] + box["height"]
        assert below == pytest.approx(PHONE[1], abs=1)
        assert boxes[1]["height"] > 0.4 * PHONE[1], "the picture is small"
        assert page.evaluate("document.documentElement.scrollWidth") <= PHONE[0]
        track = page.locator("#track").bounding_box()
        page.touchscreen.tap(track["x"] + track["width"] / 2, track["y"] + 2)
        assert page.evaluate("playback.clock.t") == pytest.approx(trajectory.duration / 2, abs=0.05)
        page.touchscreen.tap(*(page.locator("#play").bounding_box()[side] + 12 for side in "xy"))
        assert page.evaluate("playback.clock.playing")
        for hand in page.evaluate("""() => playback.figures[0].hands.map(hand =>
                playback.camera.inView(hand.toArray()).project(viewer.camera).toArray())"""):
            assert max(map(abs, hand[:2])) < 1, "the robot is in the picture"
        assert not troubles


@needs_browser
def test_what_is_not_checked_can_be_read_on_a_phone(robot: Robot, scene: Scene, tmp_path: Path) -> None:
    (tmp_path / "page.html").write_text(playback_html(robot, scene, plan_case(robot, 3, dt=0.1)), encoding="utf-8")
    names, first = robot.links_without_body, ", ".join(robot.links_without_body[:4])
    with opened(tmp_path / "page.html", PHONE) as (page, troubles):
        line = page.locator("#caption .bare")
        assert line.inner_text() == f"not checked, as they have no collision body: {first} and {len(names) - 4} more"
        assert line.evaluate("p => p.scrollWidth <= p.clientWidth"), "all of it is seen"
        line.tap()
        assert line.inner_text().endswith(": " + ", ".join(names))
        assert not troubles
