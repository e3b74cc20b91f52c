"""What the page shows of a plan that failed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from conftest import ROOT, PythonKinematics, plan
from pages import needs_browser, page_data
from screenshot import opened, seek, settle

from humanoid_rail import Robot, Scene, load_scene, paper_scene
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


def test_a_plan_that_reaches_its_targets_has_nothing_of_it(robot: Robot) -> None:
    page = playback_html(robot, paper_scene(), plan(robot, paper_scene()))
    assert 'id="why"' not in page
    assert 'data-view="why"' not in page
    assert page_data(page)["motions"][0]["miss"] is None
