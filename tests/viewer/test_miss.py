"""What the page shows of a plan that failed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, PythonKinematics, plan
from pages import needs_browser, page_data
from screenshot import PHONE, opened, seek, settle

from humanoid_rail import Robot, Scene, load_scene, paper_scene
from humanoid_rail.cli.report import report_plan
from humanoid_rail.viewer.miss import miss_panel
from humanoid_rail.viewer.playback import playback_html

NAME = "<b>ball</b> & more"


def failed(name: str) -> Scene:
    scene = load_scene(ROOT / "scenes" / "unsolvable" / "target_in_collision-1.yaml")
    return scene.model_copy(update={"obstacles": (scene.obstacles[0].model_copy(update={"name": name}),)})


@needs_browser
def test_the_nearest_miss_is_seen_with_what_blocks_it(robot: Robot, tmp_path: Path) -> None:
    scene = failed(NAME)
    trajectory = plan(robot, scene)
    found = trajectory.diagnosis
    file = tmp_path / "page.html"
    file.write_text(playback_html(robot, scene, trajectory), encoding="utf-8")
    with opened(file) as (page, troubles):
        assert page.evaluate("[playback.clock.t, playback.clock.playing]") == [
            pytest.approx(trajectory.duration, abs=1e-6),
            False,
        ], "it opens where the motion ends, and stands still"
        first, _, rest = trajectory.reason.partition("; ")
        said = page.locator("#caption .why")
        assert said.inner_text() == first
        said.click()
        assert said.inner_text() == f"{first}; {rest}"
        seek(page, 0.0)
        why = page.locator("#why")
        assert why.is_visible()
        text = why.inner_text()
        assert NAME in text
        assert found.remedies[0].what in text
        assert page.locator("#why b").count() == 0
        assert page.locator("#labels .miss:visible").all_inner_texts() == [f"{found.misses[0].distance:.3g} m"]
        hand, ends, blocking = page.evaluate(
            """() => {
                viewer.scene.updateMatrixWorld(true);
                const root = viewer.scene_tree.find(["meshcat", "world"]).object;
                const to = root.matrixWorld.clone().invert();
                const find = path => playback.figures[0].find("miss", ...path.split("/"));
                const at = (node, y) => root.position.clone().set(0, y, 0).applyMatrix4(node.matrixWorld)
                    .applyMatrix4(to).toArray();
                const { joint, offset } = playback.page.hands[0], name = playback.page.joints[joint - 1].node;
                const ghost = root.position.clone().fromArray(offset);
                ghost.applyMatrix4(find(`ghost/${name}`).matrixWorld).applyMatrix4(to);
                const line = find("lines/left/line/<object>");
                const half = line.geometry.parameters.height / 2;
                const red = [];
                find("obstacles").traverse(each => {
                    if (each.isInstancedMesh) red.push(each.material.color.getHex());
                });
                return [ghost.toArray(), [at(line, -half), at(line, half)], red];
            }"""
        )
        expected = PythonKinematics(robot).measure(np.array(found.q)).hands[0]
        np.testing.assert_allclose(hand, expected, atol=1e-5)
        np.testing.assert_allclose(ends, [expected, scene.targets["left"]], atol=1e-5)
        assert set(blocking) == {0xD42A2A}
        page.keyboard.press("w")
        settle(page)
        assert not why.is_visible()
        assert not page.evaluate("() => playback.figures[0].find('miss').visible")
        assert page.locator("#labels .miss:visible").count() == 0
        assert not troubles


@needs_browser
def test_on_a_phone_the_panel_hides_nothing_and_can_be_folded(robot: Robot, tmp_path: Path) -> None:
    scene = load_scene(ROOT / "scenes" / "unsolvable" / "target_out_of_reach-4.yaml")
    file = tmp_path / "page.html"
    file.write_text(playback_html(robot, scene, plan(robot, scene)), encoding="utf-8")
    with opened(file, PHONE) as (page, troubles):
        why, stage = page.locator("#why"), page.locator("#stage")
        box, picture = why.bounding_box(), stage.bounding_box()
        assert box["y"] >= picture["y"] + picture["height"] - 1, "it is below the picture"
        helps = page.locator("#why h3", has_text="What would help").bounding_box()
        assert helps["y"] + helps["height"] < box["y"] + box["height"], "it is seen without scrolling"
        assert why.evaluate("panel => { panel.scrollTop = 1e4; return panel.scrollTop > 0; }"), (
            "the rest is scrolled to"
        )
        page.locator("#why h2").tap()
        assert why.bounding_box()["height"] < 40
        assert stage.bounding_box()["height"] > picture["height"] + 50
        page.locator("#why h2").tap()
        assert page.locator("#why h3").first.is_visible()
        assert not troubles


def test_what_would_help_stands_once(robot: Robot, capsys: pytest.CaptureFixture[str]) -> None:
    scene = load_scene(ROOT / "scenes" / "unsolvable" / "target_in_collision-1.yaml")
    trajectory = plan(robot, scene)
    report_plan("a plan", trajectory)
    said = capsys.readouterr().out
    assert said.count("along") == 1
    assert said.count("nearest miss") == 1
    panel = miss_panel("Why", trajectory.reason, trajectory.diagnosis)
    assert panel.count("along") == 1
    assert "<h3>Besides</h3><ul><li>the motion is as far as qp gets" in panel


def test_a_plan_that_reaches_its_targets_has_nothing_of_it(robot: Robot) -> None:
    page = playback_html(robot, paper_scene(), plan(robot, paper_scene()))
    assert 'id="why"' not in page
    assert 'data-view="why"' not in page
    assert page_data(page)["motions"][0]["miss"] is None
