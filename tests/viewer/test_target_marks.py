"""Marks of targets say all steps that have a hand at the same place."""

from __future__ import annotations

from pathlib import Path

import pytest
from pages import needs_browser
from screenshot import opened

from humanoid_rail import Pose, Robot, Scene, plan
from humanoid_rail.scene.targets import numbers_there
from humanoid_rail.viewer.playback import playback_html

HERE, ELSEWHERE = (-1.6, 0.6, 3.4), (-1.6, 0.9, 3.4)
RIGHT = (-1.6, 2.2, 3.4)


@pytest.fixture
def twice() -> Scene:
    steps = ({"left": HERE, "right": None}, {"left": ELSEWHERE, "right": RIGHT}, {"left": HERE, "right": RIGHT})
    return Scene(name="twice", targets=steps)


def test_steps_at_the_same_place_are_found(twice: Scene) -> None:
    assert [numbers_there(twice.steps, step, "left") for step in range(3)] == ["1, 3", "2", "1, 3"]
    assert numbers_there(twice.steps, 1, "right") == "2, 3"
    turned = [*twice.steps, {"left": Pose(position=HERE, approach=(0.0, 0.0, -1.0)), "right": HERE}]
    assert numbers_there(turned, 3, "left") == "1, 3, 4"
    assert numbers_there(turned, 3, "right") == "4", "it is another hand"


@needs_browser
def test_each_place_has_one_mark(robot: Robot, twice: Scene, tmp_path: Path) -> None:
    (tmp_path / "page.html").write_text(playback_html(robot, twice, plan(robot, twice)), encoding="utf-8")
    with opened(tmp_path / "page.html") as (page, troubles):
        marks = page.locator("#labels .steps").all_text_contents()
        assert sorted(marks) == ["1, 3", "2", "2, 3"]
        assert not troubles
